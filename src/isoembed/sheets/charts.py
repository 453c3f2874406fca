"""Flat charts of vertex neighborhoods of a polyhedral metric: two rings of triangles, three at a boundary."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats, Indices, Mask
from isoembed.metric.curvature import corner_angles
from isoembed.metric.polyhedral import PolyhedralMetric


@dataclass(frozen=True, eq=False)
class Charts:
    """Plane coordinates of the neighbors of each vertex, which is at the origin.

    The triangles at a vertex are flattened: inside the surface, angles are scaled to sum to a full turn.
    Each triangle beyond one of them is unfolded and, at a boundary, where neighbors are on one side only,
    each triangle beyond those.  Rows are sorted by center.

    Attributes
    ----------
    centers, neighbors : ndarray of int64, shape (n,)
    positions : ndarray, shape (n, 2)
    """

    centers: Indices
    neighbors: Indices
    positions: Floats

    @classmethod
    def of(cls, metric: PolyhedralMetric) -> Charts:
        """Charts of a metric of flat triangles."""
        t, lengths = metric.triangulation, metric.face_lengths
        corners, across = t.faces.ravel(), t.sides_across
        h = np.arange(corners.size)
        after, before = h - h % 3 + (h + 1) % 3, h - h % 3 + (h + 2) % 3
        start = _directions(t.n_vertices, corners, across, before, corner_angles(metric))
        end = start + _scaled(corner_angles(metric), corners, t.n_vertices, across).ravel()
        side = lengths.ravel()
        # The end of each half-edge, and on the boundary the start of the half-edge entering the vertex.
        last = across[before] < 0
        near = _polar(side, start)
        far = _polar(side[before], end)
        ring = (
            np.concatenate([corners, corners[last]]),
            np.concatenate([corners[after], corners[before[last]]]),
            np.concatenate([near, far[last]]),
        )
        links = _Links(corners, across, after, before, side)
        second, sides = links.unfolded(_Sides(corners, across[after], near, far))
        third, _ = links.unfolded(sides.of(t.boundary_vertices[sides.centers]))
        beyond = (
            np.concatenate([second[0], third[0]]),
            np.concatenate([second[1], third[1]]),
            np.concatenate([second[2], third[2]]),
        )
        return cls._sorted(t.n_vertices, ring, beyond)

    @classmethod
    def _sorted(
        cls, n: int, ring: tuple[Indices, Indices, Floats], beyond: tuple[Indices, Indices, Floats]
    ) -> Charts:
        """Charts of the rings and the vertices beyond them, except the center and those in the ring."""
        keys = ring[0] * n + ring[1]
        own = beyond[0] * n + beyond[1]
        selected = (beyond[0] != beyond[1]) & ~np.isin(own, keys)
        once, which, counts = np.unique(own[selected], return_inverse=True, return_counts=True)
        sums = [np.bincount(which, beyond[2][selected, k], minlength=len(once)) for k in range(2)]
        means = np.stack(sums, axis=1) / counts[:, None]
        nearest = np.full(n, np.inf)
        np.minimum.at(nearest, ring[0], np.linalg.norm(ring[2], axis=1))
        # Around a sharp corner a vertex may be unfolded to either side of the center, or onto it.
        # Unfolded vertices keep a tenth of the distance of the nearest neighbor from the center.
        is_clear = np.linalg.norm(means, axis=1) > 0.1 * nearest[once // n]
        keys = np.concatenate([keys, once[is_clear]])
        positions = np.concatenate([ring[2], means[is_clear]])
        order = np.argsort(keys, kind="stable")
        centers, neighbors = np.divmod(keys[order], n)
        return cls(centers, neighbors, positions[order])


def _directions(n: int, corners: Indices, across: Indices, before: Indices, angles: Floats) -> Floats:
    """Direction of each half-edge in the chart of its start, (3F,)."""
    scaled = _scaled(angles, corners, n, across).ravel()
    first = np.empty(n, dtype=np.int64)
    first[corners] = np.arange(corners.size)
    bounded = across < 0
    first[corners[bounded]] = np.flatnonzero(bounded)
    direction = np.zeros(corners.size)
    at, turned = first, np.zeros(n)
    while len(at):  # all vertices at once, counterclockwise from corner to corner
        direction[at] = turned
        following = across[before[at]]
        goes_on = (following >= 0) & (following != first[corners[at]])
        turned = (turned + scaled[at])[goes_on]
        at = following[goes_on]
    return direction


def _scaled(angles: Floats, corners: Indices, n: int, across: Indices) -> Floats:
    """Angles, (F, 3), scaled to sum to 2 pi at each inner vertex."""
    sums = np.bincount(corners, angles.ravel(), minlength=n)
    factors = 2 * np.pi / sums
    factors[corners[across < 0]] = 1.0
    return angles * factors[corners].reshape(-1, 3)


def _polar(r: Floats, angle: Floats) -> Floats:
    return r[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)


@dataclass(frozen=True, eq=False)
class _Sides:
    """Sides of triangles in charts, (n,): twin half-edges, -1 if there is none, and ends.

    The triangle is to the left of the line from `begins` to `ends`, (n, 2).
    """

    centers: Indices
    across: Indices
    begins: Floats
    ends: Floats

    def of(self, chosen: Mask) -> _Sides:
        return _Sides(self.centers[chosen], self.across[chosen], self.begins[chosen], self.ends[chosen])


@dataclass(frozen=True, eq=False)
class _Links:
    """Half-edges, (3F,): start vertices, twins, next and previous half-edges, and lengths."""

    corners: Indices
    across: Indices
    after: Indices
    before: Indices
    lengths: Floats

    def unfolded(self, sides: _Sides) -> tuple[tuple[Indices, Indices, Floats], _Sides]:
        """Corner beyond each side, as center, neighbor and position, and the two sides at it."""
        sides = sides.of(sides.across >= 0)
        g, p, q = sides.across, sides.begins, sides.ends
        base = q - p
        length = np.linalg.norm(base, axis=1)
        to_p, to_q = self.lengths[self.after[g]], self.lengths[self.before[g]]
        along = (to_p**2 - to_q**2 + length**2) / (2 * length)
        height = np.sqrt(np.maximum(to_p**2 - along**2, 0.0))
        u = base / length[:, None]
        outward = np.stack([u[:, 1], -u[:, 0]], axis=1)
        r = p + along[:, None] * u + height[:, None] * outward
        beside = _Sides(
            np.tile(sides.centers, 2),
            np.concatenate([self.across[self.after[g]], self.across[self.before[g]]]),
            np.concatenate([p, r]),
            np.concatenate([r, q]),
        )
        return (sides.centers, self.corners[self.before[g]], r), beside
