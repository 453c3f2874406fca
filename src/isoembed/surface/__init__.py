"""Extrinsic geometry of triangulated surfaces.

The room's noun is `Embedding`; the measures are functions of a triangulation and its vertices.
"""
