"""Proofs that exact surfaces are near computed ones: from a metric and vertices to a certificate.

What is computed in floats here has a bound on its rounding errors.
"""
