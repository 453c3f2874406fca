"""Combinatorics: which triangles, edges and vertices touch.  No lengths, no coordinates.

The room's noun is `Triangulation`; its checks refuse whatever is not a triangulated sphere.
"""
