"""Interfaces of surfaces to be triangulated, and vertex densities."""

from functools import lru_cache
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from isoembed.arrays import Floats
from isoembed.meshing.spreading import Cells, Zone, roundest_axis

CELLS = (1024, 256)  # in theta and phi, where the density is sampled


class Surface(Protocol):
    """Closed surface parametrized by the unit sphere: each point has a unit vector, its direction.

    The underscored methods take unit vectors u (n, 3) and use the surface's own unit of length, in which its
    size is of order 1.  Surfaces are immutable and hashable: equal ones share their vertex density.
    """

    @property
    def _unit(self) -> float:
        """Unit of length of the underscored methods."""

    @property
    def _radius(self) -> float:
        """Radius of the sphere with the same area."""

    def __hash__(self) -> int:
        """Hash of the parameters: equal surfaces share what is computed of them."""

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
        """Directions of the points displaced by tangent vectors, to first order."""


@runtime_checkable
class ZoneSurface(Protocol):
    """Surface parametrized by a zone of the unit sphere: a disc, a band, or a torus cut open.

    The underscored methods are those of a `Surface`.
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
    """Prescribed number of vertices per area (n,), up to a factor: 1 + 0.1 |K| A / 4 pi.

    One part of the vertices is distributed by area, the other by absolute Gaussian curvature.
    int |K| dA over a tip does not depend on its sharpness, so every tip gets a fixed number of vertices
    and none takes them from the rest; a sphere stays uniform.
    """
    K, _ = surface._curvatures(u)
    return 1.0 + 0.1 * np.abs(K) * surface._radius**2  # weight of curvature relative to area


def spread_directions(surface: Surface, square: Floats) -> Floats:
    """Directions (n, 3) with the `vertex_density`, mapped from points of the unit square (n, 2)."""
    return _density_cells(surface).spread(square)


@lru_cache(maxsize=8)
def _density_cells(surface: Surface) -> Cells:
    """Vertices per area of the sphere of directions; cached, as one surface has meshes of many sizes."""

    def density(u: Floats) -> Floats:
        return np.asarray(surface._area_density(u) * vertex_density(surface, u))

    extent = np.linalg.norm(surface._points(np.eye(3)), axis=1)
    cells = Cells.of(density, CELLS, roundest_axis(extent))
    cells.values.setflags(write=False)
    return cells
