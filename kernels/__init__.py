"""Warp functions and kernels, made per precision by cached factories.

Every factory takes a ``Real`` (see ``precision``) and returns a namespace of kernels; a precision
that is never asked for is never compiled. Arguments are grouped ``# model``, ``# in``, ``# out``.
"""
