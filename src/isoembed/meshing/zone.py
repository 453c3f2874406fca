"""Triangulations of spherical zones (discs about a pole, bands): circles of latitude and vertices on each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter
from isoembed.meshing.metric_relaxation import MetricMesh
from isoembed.meshing.sphere import GOLDEN, angles_of, directions_at, fibonacci_lattice
from isoembed.meshing.spreading import Cells, Zone

ALONG = 2048  # samples of the metric along a circle
STRIP = np.sqrt(3.0) / 4.0  # width of the Voronoi cells of vertices on a boundary, over the edge length


def even_points(cells: Cells, k: int) -> Floats:
    """Deterministic directions (k, 3) with the density of the cells."""
    return cells.spread(fibonacci_lattice(k))


@dataclass(frozen=True, eq=False)
class ZoneLayout:
    """Distribution of the vertices of a triangulation of a zone in a metric.

    Attributes
    ----------
    zone : tuple of float
        Range of theta.  Circles of latitude at its ends are boundaries; a pole is not.
    tensor : callable
        Takes unit vectors (n, 3) and returns the metric (n, 3, 3) there.
    area : callable
        Takes unit vectors (n, 3) and returns the area element over that of the unit sphere (n,).
    density : callable
        Takes unit vectors (n, 3) and returns the prescribed vertices per area (n,), up to a factor.
    is_ring : bool
        Whether the two circles are identified, forming a torus.
    """

    zone: Zone
    tensor: Callable[[Floats], Floats]
    area: Callable[[Floats], Floats]
    density: Callable[[Floats], Floats]
    is_ring: bool = False

    @property
    def circles(self) -> tuple[float, ...]:
        """Angles theta of the boundaries."""
        return tuple(theta for theta in self.zone if 0.0 < theta < np.pi)

    def vertices(self, size: float) -> float:
        """Number of vertices for edges of this length at unit density."""
        whole, around = self._measures
        return float(2.0 / np.sqrt(3.0) * whole / size**2 + 0.5 * around / size + self._characteristic)

    def size(self, n: int) -> float:
        """Edge length at unit density for n vertices: the inverse of `vertices`."""
        whole, around = self._measures
        a, b = 2.0 / np.sqrt(3.0) * whole, 0.5 * around
        inner = n - self._characteristic
        return float((b + np.sqrt(b * b + 4.0 * a * inner)) / (2.0 * inner))

    def mesh(
        self,
        n: int,
        distances: Callable[[Floats, Floats], Floats],
        points: Callable[[Cells, int], Floats] = even_points,
    ) -> MetricMesh:
        """Unrelaxed triangulation with n vertices in the zone, closed by cones.

        The vertices of a ring's second circle coincide with those of the first, and are not counted.

        Parameters
        ----------
        n : int
        distances : callable
            As in `MetricMesh`.
        points : callable
            Takes the density on cells and a number k and returns k directions inside the zone.

        Raises
        ------
        InvalidParameter
            The boundaries alone need more vertices, or triangles would cross one.
        """
        size = self.size(n)
        # In a narrow band, aligned vertices on both sides would form squares.
        turns = (0.0, 0.0 if self.is_ring else GOLDEN)
        rims = [self._rim(theta, size, turn) for theta, turn in zip(self.circles, turns, strict=False)]
        boundary = sum(map(len, rims))
        inner = n - (len(rims[0]) if self.is_ring else boundary)
        if inner < 0:
            raise InvalidParameter(
                f"{n} vertices are too few: nearly equilateral triangles have {boundary} on boundaries"
            )
        apexes = [(0.0, 0.0, z) for z, theta in zip((1.0, -1.0), self.zone, strict=True) if 0 < theta < np.pi]
        between = points(self._wanted_cells, inner) if inner else np.empty((0, 3))
        u = np.concatenate([*rims, self._inside(between, size), apexes])
        mesh = MetricMesh.hull(u, self.tensor, distances, boundary, len(apexes))
        cones = mesh.tables.faces[mesh.is_cone]
        if ((cones >= boundary) & (cones < mesh.n_vertices)).any():
            raise InvalidParameter(f"{n} vertices are too few for this metric: triangles cross the boundary")
        return mesh

    @property
    def _characteristic(self) -> int:
        """Euler characteristic of the zone."""
        return 2 - len(self.circles)

    @cached_property
    def _measures(self) -> tuple[float, float]:
        """Area, and length of the boundaries, scaled to unit density."""
        whole = self._wanted_cells.integral()
        boundaries = () if self.is_ring else self.circles
        return whole, sum(float(self._circle(theta)[1].mean()) * 2.0 * np.pi for theta in boundaries)

    @cached_property
    def _wanted_cells(self) -> Cells:
        """Prescribed vertices per area of the unit sphere."""
        return Cells.of(lambda u: self.area(u) * self.density(u), (256, 256), zone=self.zone)

    def _circle(self, theta: float) -> Floats:
        """Speeds (2, n) of theta and phi at uniform steps along a circle, in local edge lengths."""
        phi = 2.0 * np.pi / ALONG * (np.arange(ALONG) + 0.5)
        cos, sin, zero = np.cos(phi), np.sin(phi), np.zeros(ALONG)
        u = directions_at(np.full(ALONG, np.cos(theta)), phi)
        by_theta = np.stack([np.cos(theta) * cos, np.cos(theta) * sin, zero - np.sin(theta)], axis=1)
        by_phi = np.sin(theta) * np.stack([-sin, cos, zero], axis=1)
        v = np.stack([by_theta, by_phi])
        return np.asarray(np.sqrt(np.einsum("ani,nij,anj->an", v, self.tensor(u), v) * self.density(u)))

    def _rim(self, theta: float, size: float, turn: float) -> Floats:
        """Equidistant directions (k, 3) on a circle, shifted by a fraction of their distance."""
        along = np.concatenate([[0.0], np.cumsum(self._circle(theta)[1])])
        count = max(3, round(2.0 * np.pi * float(along[-1]) / ALONG / size))
        fractions = (np.arange(count) + turn % 1.0) / count
        phi = np.interp(fractions, along / along[-1], np.linspace(0.0, 2.0 * np.pi, ALONG + 1))
        return directions_at(np.full(count, np.cos(theta)), phi)

    def _inside(self, u: Floats, size: float) -> Floats:
        """Directions (k, 3) in the zone, moved out of the Voronoi cells of vertices on its boundaries."""
        start, stop = self.zone
        theta, phi = angles_of(u)
        widths = np.zeros((2, len(u)))
        for width, end in zip(widths, self.zone, strict=True):
            if end in self.circles:
                at = 2.0 * np.pi / ALONG * (np.arange(ALONG) + 0.5)
                width[:] = STRIP * size / np.interp(phi, at, self._circle(end)[0], period=2.0 * np.pi)
        # At least half of the width remains in bands as narrow as a triangle.
        widths *= np.minimum(1.0, 0.5 * (stop - start) / np.maximum(widths.sum(axis=0), 1e-300))
        before, after = widths
        theta = start + before + (theta - start) * (1.0 - (before + after) / (stop - start))
        return directions_at(np.cos(theta), phi)
