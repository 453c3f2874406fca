"""Proofs: certificates that a realization is near computed vertices.

All floating-point results here come with bounds on their rounding errors.
"""
