"""Closed-form surfaces.

``SURFACES`` offers them by name; the fields of each dataclass are its options. A surface knows its points
and curvatures exactly, and its area, volume and int H dA to rounding, for meshes to be compared with.
"""

from isoembed.gallery.bent import Bean, BentTube
from isoembed.gallery.harmonic import HarmonicSurface
from isoembed.gallery.implicit import Drum, Ellipsoid, Sphere, Superellipsoid
from isoembed.gallery.kerr import Ergosphere, KerrHorizon
from isoembed.gallery.revolution import CassiniPeanut
from isoembed.gallery.surface import Surface
from isoembed.meshing.surface_mesh import triangulate

SURFACES: dict[str, type[Surface]] = {
    cls.name: cls
    for cls in (
        *(Ellipsoid, Drum, Sphere, Superellipsoid),
        *(CassiniPeanut, HarmonicSurface, Bean, BentTube),
        *(KerrHorizon, Ergosphere),
    )
}
"""The surfaces by the names that the command line uses."""

__all__ = [
    "SURFACES",
    "Bean",
    "BentTube",
    "CassiniPeanut",
    "Drum",
    "Ellipsoid",
    "Ergosphere",
    "HarmonicSurface",
    "KerrHorizon",
    "Sphere",
    "Superellipsoid",
    "Surface",
    "triangulate",
]
