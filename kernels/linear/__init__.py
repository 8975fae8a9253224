"""Conjugate gradients, factorisation and multilevel preconditioning."""
