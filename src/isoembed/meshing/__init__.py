"""Triangulation of smooth surfaces and metrics.

Points are distributed with a prescribed density, connected, and relaxed to nearly equilateral triangles.
"""

from isoembed.meshing.directions import directions_of
from isoembed.meshing.surface import Surface
from isoembed.meshing.surface_mesh import triangulate

__all__ = ["Surface", "directions_of", "triangulate"]
