"""Interfaces of surfaces to be triangulated, and vertex densities."""

from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from isoembed.arrays import Floats
from isoembed.meshing.spreading import Cells, Zone, roundest_axis

CELLS = (1024, 256)  # in theta and phi, where the density is sampled


class Surface(Protocol):
    """A closed surface that is the image of the unit sphere: a unit vector, its direction, names a point.

    The underscored methods take unit vectors u (n, 3) and compute in the surface's own unit of length, in
    which it is of ordinary size.
    """

    @property
    def _unit(self) -> float:
        """The surface's own unit of length."""

    @property
    def _radius(self) -> float:
        """Radius of the sphere of the same area."""

    def point(self, directions: ArrayLike) -> Floats:
        """Points (n, 3), in the unit of the user."""

    def _points(self, u: Floats) -> Floats:
        """Points (n, 3)."""

    def _normals(self, u: Floats) -> Floats:
        """Outward unit normals (n, 3)."""

    def _curvatures(self, u: Floats) -> tuple[Floats, Floats]:
        """Gaussian and mean curvature, each (n,)."""

    def _area_density(self, u: Floats) -> Floats:
        """Area of the surface over area of the sphere of directions (n,)."""

    def _moved(self, u: Floats, displacement: Floats) -> Floats:
        """Directions of the points displaced by tangent vectors, right to first order."""


@runtime_checkable
class ZoneSurface(Protocol):
    """A surface that is the image of a zone of the unit sphere: a disc, a band, or a torus cut open.

    The underscored methods are as those of a `Surface`.
    """

    @property
    def zone(self) -> Zone:
        """Range of theta."""

    @property
    def is_ring(self) -> bool:
        """Whether the circles at both ends of the zone are one curve, parametrized alike."""

    def point(self, directions: ArrayLike) -> Floats:
        """Points (n, 3), in the unit of the user."""

    def _points(self, u: Floats) -> Floats:
        """Points (n, 3)."""

    def _tensor(self, u: Floats) -> Floats:
        """First fundamental form (n, 3, 3): symmetric, and zero along u."""

    def _area_density(self, u: Floats) -> Floats:
        """Area of the surface over area of the sphere of directions (n,)."""


def vertex_density(surface: Surface, u: Floats) -> Floats:
    """Vertices per area (n,) that a surface asks for, up to a factor: 1 + share |K| A / 4 pi.

    One part of the vertices is spread over the area, the other over the absolute Gaussian curvature.
    int |K| dA does not depend on how sharp a tip is, so every tip gets its share at every sharpness
    and no tip starves the rest; a sphere stays uniform.
    """
    K, _ = surface._curvatures(u)
    return 1.0 + 0.1 * np.abs(K) * surface._radius**2  # vertices by curvature against one by area


def spread_directions(surface: Surface, square: Floats) -> Floats:
    """Directions (n, 3) with the `vertex_density`, carried from points of the unit square (n, 2)."""

    def density(u: Floats) -> Floats:
        return np.asarray(surface._area_density(u) * vertex_density(surface, u))

    extent = np.linalg.norm(surface._points(np.eye(3)), axis=1)
    return Cells.of(density, CELLS, roundest_axis(extent)).spread(square)
