"""Proofs: certificates that a realization is near computed vertices.

What is computed in floats here has a bound on its rounding errors.
"""
