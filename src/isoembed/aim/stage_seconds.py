"""Typical durations of stages, for estimates of the time left.

In seconds, with 40,000 vertices; only the ratios count.
"""

AT_ONCE = {"radii": 1.0}
BY_A_POLYTOPE = {"nearest waypoint": 0.5, "polytopes": 1.0, "leap": 0.8}
POLYHEDRON = {"waypoint": 1.0, "flat vertices": 0.05, "polytope": 1.0, "placement": 0.2, "edge paths": 0.1}
GUIDED = {"guided pull back": 100.0, "polish": 2.0, "neighbors": 15.0}
LOCAL = {"local search": 100.0}
PULL_BACK = {"pull back": 2.0, **GUIDED, "mirrored patches": 50.0, **LOCAL}
