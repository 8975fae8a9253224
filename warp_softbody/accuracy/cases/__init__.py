"""What charts compare: the cases, their settings, and the numbers taken from a motion."""
