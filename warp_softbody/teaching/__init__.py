"""Gains that a body learns by a search: what is wanted, what a try costs, and what is kept."""
