"""Alexandrov's theorem: the exact convex polyhedron of a convex metric, and its proof.

Every convex polyhedral metric on the sphere is realized by a unique convex polyhedron.
"""
