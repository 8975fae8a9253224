"""Elastic forces and stiffness of tets."""
