"""Closed-form surfaces.

``SURFACES`` contains them by name; the fields of each dataclass are its options. For comparison with meshes,
a closed surface of genus 0 has exact points and curvatures, and area, volume and int H dA to rounding; a
surface with boundary, or a torus, has points, area, and the integrals of H^2 and k1^2 + k2^2.
"""

from isoembed.gallery.bent import Bean, BentTube
from isoembed.gallery.harmonic import HarmonicSurface
from isoembed.gallery.implicit import Drum, Ellipsoid, Sphere, Superellipsoid
from isoembed.gallery.kerr import Ergosphere, KerrHorizon
from isoembed.gallery.revolution import CassiniPeanut
from isoembed.gallery.surface import Surface
from isoembed.gallery.zone_surface import Cap, Catenoid, Cone, Enneper, Torus, ZoneSurface
from isoembed.meshing.surface_mesh import triangulate

SURFACES: dict[str, type[Surface | ZoneSurface]] = {
    cls.name: cls
    for cls in (
        *(Ellipsoid, Drum, Sphere, Superellipsoid),
        *(CassiniPeanut, HarmonicSurface, Bean, BentTube),
        *(KerrHorizon, Ergosphere),
        *(Cap, Cone, Catenoid, Enneper, Torus),
    )
}
"""Surfaces by their command-line names."""

__all__ = [
    "SURFACES",
    "Bean",
    "BentTube",
    "Cap",
    "CassiniPeanut",
    "Catenoid",
    "Cone",
    "Drum",
    "Ellipsoid",
    "Enneper",
    "Ergosphere",
    "HarmonicSurface",
    "KerrHorizon",
    "Sphere",
    "Superellipsoid",
    "Surface",
    "Torus",
    "ZoneSurface",
    "triangulate",
]
