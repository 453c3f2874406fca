"""Directions with a prescribed density on the sphere, by the inverse distribution function."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from isoembed.arrays import Floats, chunks
from isoembed.meshing.sphere import directions_at

Zone = tuple[float, float]
WHOLE: Zone = (0.0, np.pi)
CHUNK = 4096  # points that are looked up or evaluated at once: intermediate arrays remain in the cache


def roundest_axis(sizes: Floats) -> int:
    """Cartesian axis for which the ratio of the other two of three sizes is closest to 1; z if tied."""
    logs = np.log(sizes)
    spread = [abs(logs[(k + 1) % 3] - logs[(k + 2) % 3]) for k in (2, 1, 0)]
    return 2 - int(np.argmin(np.round(spread, 9)))


@dataclass(frozen=True)
class Cells:
    """Positive function on a zone of the sphere, represented by its values at cell centers.

    The cells are uniform in theta and phi.

    Attributes
    ----------
    values : ndarray, shape (m, n)
        Values by theta, then phi, which are angles about the axis, not those of the function's coordinates.
    axis : int
        Cartesian axis of the angles: 0, 1 or 2.
    zone : tuple of float
        Range of theta; by default the whole sphere.
    """

    values: Floats
    axis: int
    zone: Zone = WHOLE

    @classmethod
    def of(
        cls, function: Callable[[Floats], Floats], shape: tuple[int, int], axis: int = 2, zone: Zone = WHOLE
    ) -> Cells:
        """Sample a function, which takes unit vectors (k, 3) and returns (k,)."""
        u, values = cell_centers(shape, axis, zone), np.empty(shape)
        for part in chunks(len(u), CHUNK):
            values.reshape(-1)[part] = function(u[part])
        return cls(values, axis, zone)

    def integral(self) -> float:
        """Integral over the zone of the unit sphere."""
        return float(2.0 * np.pi * np.mean(self.values, axis=1) @ _heights(len(self.values), self.zone))

    def at(self, u: Floats) -> Floats:
        """Values (k,) in the directions u (k, 3), by bilinear interpolation between cell centers."""
        m, n = self.values.shape
        x, y, z = np.roll(u, 2 - self.axis, axis=1).T
        row = self._row(np.arctan2(np.hypot(x, y), z))
        column = np.arctan2(y, x) % (2.0 * np.pi) * (n / (2.0 * np.pi)) - 0.5
        i, j = np.minimum(row.astype(np.int64), m - 2), np.floor(column).astype(np.int64)
        s, t = row - i, column - j
        j, k = j % n, (j + 1) % n
        low = (1.0 - t) * self.values[i, j] + t * self.values[i, k]
        return np.asarray(
            (1.0 - s) * low + s * ((1.0 - t) * self.values[i + 1, j] + t * self.values[i + 1, k])
        )

    def spread(self, square: Floats) -> Floats:
        """Map points of the unit square (k, 2) to directions (k, 3) with this function as density.

        Points uniformly distributed in the square, periodic in the second coordinate, are mapped by the
        inverses of the marginal distribution in theta and of the conditional one in phi.
        """
        m, n = self.values.shape
        marginal, conditional = self._distributions
        heights, turns = square.T
        theta = np.interp(heights, marginal / marginal[-1], np.linspace(*self.zone, m + 1))
        # The conditional distribution of the point's own height: a blend of the two nearest rows.
        row = self._row(theta)
        low = np.minimum(row.astype(np.int64), m - 2)
        phi = np.empty(len(square))
        for part in chunks(len(square), CHUNK):
            blend = (row - low)[part, None]
            F = (1.0 - blend) * conditional[low[part]] + blend * conditional[low[part] + 1]
            cell = np.clip((turns[part, None] >= F).sum(axis=1) - 1, 0, n - 1)
            at = np.arange(len(F))
            rise = F[at, cell + 1] - F[at, cell]
            phi[part] = (cell + (turns[part] - F[at, cell]) / rise) * (2.0 * np.pi / n)
        return np.roll(directions_at(np.cos(theta), phi), self.axis - 2, axis=-1)

    @cached_property
    def _distributions(self) -> tuple[Floats, Floats]:
        """Marginal distribution (m + 1,) in theta, up to a factor, and conditional ones (m, n + 1) in phi."""
        m = len(self.values)
        cells = self.values * _heights(m, self.zone)[:, None]
        marginal = np.concatenate([[0.0], np.cumsum(cells.sum(axis=1))])
        conditional = np.cumsum(self.values / self.values.sum(axis=1)[:, None], axis=1)
        return marginal, np.concatenate([np.zeros((m, 1)), conditional], axis=1)

    def _row(self, theta: Floats) -> Floats:
        """Fractional row indices (k,) of angles theta: integers at cell centers."""
        start, stop = self.zone
        m = len(self.values)
        return np.clip((theta - start) * (m / (stop - start)) - 0.5, 0.0, m - 1.0)


def cell_centers(shape: tuple[int, int], axis: int, zone: Zone = WHOLE) -> Floats:
    """Directions (m n, 3) of the cell centers, by theta, then phi."""
    start, stop = zone
    theta = start + (np.arange(shape[0]) + 0.5) * ((stop - start) / shape[0])
    phi = (np.arange(shape[1]) + 0.5) * (2.0 * np.pi / shape[1])
    return np.roll(directions_at(np.cos(theta)[:, None], phi), axis - 2, axis=-1).reshape(-1, 3)


def _heights(m: int, zone: Zone) -> Floats:
    """Heights (m,) of the parts of a zone of the unit sphere between uniform steps in theta."""
    return -np.diff(np.cos(np.linspace(*zone, m + 1)))
