"""Intrinsic geometry: edge lengths, and what follows from them alone.

The room's noun is `PolyhedralMetric`; curvature and conformal change are functions of it.
"""
