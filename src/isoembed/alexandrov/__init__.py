"""The exact convex polyhedron of a convex metric (Alexandrov 1941), and the proof that it is the one.

Every convex polyhedral metric on the sphere is the surface of one convex polyhedron.
"""
