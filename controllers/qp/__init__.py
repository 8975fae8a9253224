"""Convex quadratic programs, solved by DAQP or PIQP."""
