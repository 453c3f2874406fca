"""Combinatorics of triangulations, without lengths or coordinates.

The main class is `Triangulation`; its checks reject everything but triangulated surfaces.
"""
