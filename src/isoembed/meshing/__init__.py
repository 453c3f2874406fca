"""Triangulation of smooth surfaces and metrics.

Points are spread with a wanted density, connected, and relaxed until the triangles are nearly equilateral.
"""

from isoembed.meshing.directions import directions_of
from isoembed.meshing.surface import Surface
from isoembed.meshing.surface_mesh import triangulate

__all__ = ["Surface", "directions_of", "triangulate"]
