"""Combinatorics of triangulations, without lengths or coordinates.

The main class is `Triangulation`; its checks refuse whatever is not a triangulated sphere.
"""
