"""Intrinsic geometry: edge lengths, and what follows from them alone.

The main class is `PolyhedralMetric`; curvature and conformal change are functions of it.
"""
