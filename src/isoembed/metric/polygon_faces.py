"""Triangulation of polygons in space."""

from collections import Counter
from dataclasses import dataclass
from functools import cached_property
from typing import cast

import numpy as np

from isoembed.arrays import Floats, Indices, Mask
from isoembed.errors import InvalidMetric
from isoembed.intrinsic.ears import triangulated
from isoembed.intrinsic.plane import flattened
from isoembed.mesh.polygons import polygon_normals

PLANAR = 1e-5  # in polygon sizes: smaller distances from the plane change diagonals by at most 1e-10
ERRORS = 4.0  # in vertex errors: distance from the plane allowed in `isoembed.surface.flat_faces`
MIN_AREA = 1e-12  # relative to the polygon: smaller triangles degenerate by rounding


@dataclass(frozen=True, eq=False)
class PolygonFaces:
    """Polygons in space.

    Parameters
    ----------
    points : ndarray, shape (V, 3)
        Coordinates of at most order 1.
    corners : ndarray of int, shape (n,)
        Concatenated vertices of the polygons.
    sizes : ndarray of int, shape (F,)
        Number of corners of each polygon, at least 3.
    """

    points: Floats
    corners: Indices
    sizes: Indices

    @cached_property
    def starts(self) -> Indices:
        """Index of the first corner of each polygon, shape (F,)."""
        return cast(Indices, np.cumsum(self.sizes) - self.sizes)

    @cached_property
    def arms(self) -> Floats:
        """Vectors from the center of a polygon to its corners, shape (n, 3)."""
        p = self.points[self.corners]
        centers = np.add.reduceat(p, self.starts) / self.sizes[:, None]
        return p - np.repeat(centers, self.sizes, axis=0)

    @cached_property
    def normals(self) -> Floats:
        """Normals with the area of the polygon's projection as length, shape (F, 3)."""
        return polygon_normals(self.points[self.corners], self.sizes) / 2

    @cached_property
    def extents(self) -> Floats:
        """Sizes of the polygons: largest distance of corners from the center, shape (F,)."""
        return cast(Floats, np.maximum.reduceat(np.linalg.norm(self.arms, axis=1), self.starts))

    @cached_property
    def warps(self) -> Floats:
        """Largest distance of corners from the polygon's plane, divided by its size, shape (F,)."""
        areas = np.linalg.norm(self.normals, axis=1, keepdims=True)
        units = np.divide(self.normals, areas, out=np.zeros_like(self.normals), where=areas > 0)
        heights = np.abs((self.arms * np.repeat(units, self.sizes, axis=0)).sum(axis=1))
        off = np.maximum.reduceat(heights, self.starts)
        return np.divide(off, self.extents, out=np.zeros_like(off), where=self.extents > 0)

    def warped(self, error: float, tolerance: float = PLANAR) -> Mask:
        """Nonplanar polygons, shape (F,).

        Parameters
        ----------
        error : float
            Bound on the error of a vertex.
        tolerance : float
            Distance from the plane, in polygon sizes.
        """
        return (self.warps > tolerance) & (self.warps * self.extents > ERRORS * error)

    def triangles(self) -> Indices:
        """Delaunay triangles of all polygons, in their order, shape (sum of sizes - 2, 3).

        Raises
        ------
        InvalidMetric
            A polygon repeats a vertex, has no area or intersects itself; the message names the first.
        """
        self._check_repetitions()
        counts = self.sizes - 2
        places = np.cumsum(counts) - counts
        triangles = np.empty((int(counts.sum()), 3), dtype=np.int64)
        for n in np.unique(self.sizes).tolist():
            (which,) = np.nonzero(self.sizes == n)
            rows = self.starts[which, None] + np.arange(n)
            if n == 3:
                cut = np.broadcast_to(np.arange(3), (len(which), 1, 3))
            else:
                cut = self._quads(which, rows) if n == 4 else self._ears(which, rows)
            corners = np.take_along_axis(rows[:, None, :], cut, axis=2)
            triangles[places[which, None] + np.arange(n - 2)] = self.corners[corners]
        self._part(triangles, np.repeat(np.arange(len(counts)), counts))
        return triangles

    def _check_repetitions(self) -> None:
        face = np.repeat(np.arange(len(self.sizes)), self.sizes)
        order = np.lexsort([self.corners, face])
        same = (np.diff(face[order]) == 0) & (np.diff(self.corners[order]) == 0)
        if same.any():
            f = int(face[order][:-1][same].min())
            transposed = (
                ": the table of faces looks transposed" if len(self.sizes) == 3 < self.sizes[f] else ""
            )
            raise InvalidMetric(f"{self._name(f)} repeats a vertex{transposed}")

    def _name(self, f: int) -> str:
        corners = self.corners[self.starts[f] :][: self.sizes[f]].tolist()
        return f"face {f} {corners}" if len(corners) < 20 else f"face {f} with {len(corners)} corners"

    def _refuse(self, f: int) -> None:
        raise InvalidMetric(
            f"{self._name(f)} cannot be cut into triangles: it has no area, or crosses itself"
        )

    def _quads(self, which: Indices, rows: Indices) -> Indices:
        """Corners of two triangles for each quadrilateral, split by its Delaunay diagonal."""
        p, normals = self.arms[rows], self.normals[which]
        areas = (normals**2).sum(axis=1)

        def turns(i: int, j: int, k: int) -> Floats:
            return (np.cross(p[:, j] - p[:, i], p[:, k] - p[:, i]) * normals).sum(axis=1) / 2

        threshold = MIN_AREA * areas
        first = np.minimum(turns(0, 1, 2), turns(0, 2, 3)) > threshold
        second = np.minimum(turns(0, 1, 3), turns(1, 2, 3)) > threshold
        if not (first | second).all():
            self._refuse(int(which[np.argmin(first | second)]))
        sides = np.roll(p, -1, axis=1) - p
        back = -np.roll(sides, 1, axis=1)
        across = np.linalg.norm(np.cross(sides, back), axis=2)
        angles = np.arctan2(across, (sides * back).sum(axis=2))
        # both diagonals are equally good up to rounding
        better = angles[:, [1, 3]].sum(axis=1) <= angles[:, [0, 2]].sum(axis=1) + 1e-9
        use = first & (better | ~second)
        return np.where(use[:, None, None], [[0, 1, 2], [0, 2, 3]], [[0, 1, 3], [1, 2, 3]])

    def _ears(self, which: Indices, rows: Indices) -> Indices:
        """Corners of the triangles of polygons with equally many corners."""
        found = []
        for f, row in zip(which.tolist(), rows, strict=True):
            arms, normal = self.arms[row], self.normals[f]
            size = np.abs(arms).max()
            area = np.linalg.norm(normal)
            triangles = None
            if area > MIN_AREA * size**2:
                triangles = triangulated(flattened(arms, normal) / (2 * size))
            if triangles is None:
                self._refuse(f)
            found.append(triangles)
        return np.array(found)

    def _part(self, triangles: Indices, owners: Indices) -> None:
        """Flip diagonals that coincide with other edges, as polygons may share more than a side."""
        ends = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2), axis=2).reshape(-1, 2)
        keys, count = np.unique(ends @ [len(self.points), 1], return_counts=True)
        if (count <= 2).all():
            return
        edges = list(zip(*(part.tolist() for part in divmod(keys, len(self.points))), strict=True))
        uses = Counter({edge: n for edge, n in zip(edges, count.tolist(), strict=True) if n > 2})
        there = set(edges)
        for a, b in tuple(uses):
            for f in np.unique(owners[(triangles == a).any(axis=1) & (triangles == b).any(axis=1)]).tolist():
                first, last = np.searchsorted(owners, [f, f + 1])
                both = [t for t in range(first, last) if {a, b} <= set(triangles[t].tolist())]
                if uses[a, b] <= 2 or len(both) < 2:
                    continue
                # The triangles are a, b, c and b, a, d.
                c, d = (({*triangles[t].tolist()} - {a, b}).pop() for t in both)
                if triangles[both[0]].tolist() not in ([a, b, c], [b, c, a], [c, a, b]):
                    c, d = d, c
                flipped = np.array([[a, d, c], [d, b, c]])
                if (min(c, d), max(c, d)) not in there and self._turns_left(flipped, f):
                    triangles[both] = flipped
                    there.add((min(c, d), max(c, d)))
                    uses[a, b] -= 2

    def _turns_left(self, triangles: Indices, f: int) -> bool:
        """Whether triangles are oriented like their polygon."""
        a, b, c = np.moveaxis(self.points[triangles], 1, 0)
        turns = np.cross(b - a, c - a) @ self.normals[f] / 2
        return bool((turns > MIN_AREA * (self.normals[f] ** 2).sum()).all())
