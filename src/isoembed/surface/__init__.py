"""Extrinsic geometry of triangulated surfaces.

A `Surface` has the measures as properties; they are functions of a triangulation and its vertices.
"""
