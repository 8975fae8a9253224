"""Convex quadratic programs, each solved by DAQP or PIQP and its answer verified."""
