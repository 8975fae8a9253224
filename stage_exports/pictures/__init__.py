"""Off-screen pictures and movies."""
