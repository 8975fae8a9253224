"""Quadratic programs with complementarity constraints, usable on their own."""
