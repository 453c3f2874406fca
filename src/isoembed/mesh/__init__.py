"""Combinatorics of triangulations, without lengths or coordinates.

The room's noun is `Triangulation`; its checks refuse whatever is not a triangulated sphere.
"""
