"""Extrinsic geometry of triangulated surfaces.

Functions of a triangulation and its vertices, also available as properties of a `Surface`.
"""
