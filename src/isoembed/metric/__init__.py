"""Intrinsic geometry: edge lengths and the quantities determined by them.

The main class is `PolyhedralMetric`; curvature and conformal change are functions of it.
"""
