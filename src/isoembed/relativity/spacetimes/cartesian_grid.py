"""Slices on a Cartesian grid, interpolated to eighth order, with estimates of noise and truncation."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from math import comb, factorial

import numpy as np
from numpy.typing import ArrayLike

from isoembed.arrays import Floats, Indices
from isoembed.errors import InvalidParameter
from isoembed.relativity.spacetimes.checks import numbers, positive_number, refuse_points, vector, written
from isoembed.relativity.spacetimes.loops import contracted, contracted_gradient
from isoembed.relativity.spacetimes.three_geometry import (
    ASSUMED,
    DerivedGeometry,
    InterpolatedGeometry,
    ThreeGeometry,
)
from isoembed.reprs import short_repr
from isoembed.smooth.user_functions import array_of

ENTRY = np.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]])
"""Indices of the six components, arranged as a symmetric matrix."""
STENCIL = 8  # points of the Lagrange interpolation along each axis
FEWER = STENCIL - 2  # the same of lower order, for error estimates
OUTSIDE = 1e-9  # largest distance of a point from the grid, in spacings
PERIOD = 64  # period of noise samples in spacings, long enough for few coincidences on a surface
ACROSS = 20  # spacings across a horizon; with 10 none is found, with 14 its area has 5 digits
ERROR_FACTOR = 10.0  # ratio of the error to the change with two points more or less


@short_repr
@dataclass(frozen=True, eq=False)
class CartesianGrid(InterpolatedGeometry):
    """Slice given by its values at the points ``origin + spacing * (i, j, k)``.

    Interpolation uses polynomials of degree seven along each axis, through the eight nearest points: the
    error is of eighth order in the spacing, that of the gradient of seventh order.

    Attributes
    ----------
    origin : three floats
        Position of the point [0, 0, 0].
    spacing : float or three floats
    gamma : ndarray, shape (6, nx, ny, nz) or (3, 3, nx, ny, nz)
        ``gamma_ij``, stored as the six components xx, xy, xz, yy, yz and zz.  Values inside a hole may be
        NaN: interpolation uses only values within four spacings (seven at the faces of the grid).
    K : ndarray, shape as gamma, optional
        ``K_ij``, with the sign of `isoembed.relativity.spacetimes.three_geometry`; without it the slice is
        time-symmetric.
    remarks : tuple of str
        Initial sentences of `notes`.

    Raises
    ------
    InvalidParameter
        A shape is wrong, there are fewer than eight points along an axis, a matrix is not symmetric,
        gamma is not positive definite anywhere, or the spacing is not positive; or a point at which a field
        is evaluated lies outside the grid.
    """

    origin: Sequence[float]
    spacing: float | Sequence[float]
    gamma: Floats
    K: Floats | None = None
    remarks: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "origin", vector("the origin", self.origin))
        steps = numbers(self.spacing)
        spacing = vector("the spacing", np.full(3, steps) if steps.ndim == 0 else steps)
        for axis, h in zip("xyz", spacing, strict=True):
            positive_number(f"the spacing in {axis}", h)
        object.__setattr__(self, "spacing", spacing)
        object.__setattr__(self, "gamma", _six("gamma", self.gamma))
        shape = self.gamma.shape[1:]
        if min(shape) < STENCIL:
            raise InvalidParameter(f"the grid has {shape} points: there must be {STENCIL} along each axis")
        if self.K is not None:
            object.__setattr__(self, "K", _six("K", self.K))
            if self.K.shape != self.gamma.shape:
                raise InvalidParameter(f"K is given at {self.K.shape[1:]} points, gamma at {shape}")
        self._check_signature()

    def _check_signature(self) -> None:
        """Check that gamma is positive definite at some of the nodes; inside holes it need not be."""
        steps = tuple(slice(None, None, n // 20 + 1) for n in self.gamma.shape[1:])
        some = self.gamma[(slice(None), *steps)].reshape(6, -1)
        finite = np.isfinite(some).all(axis=0)
        xx, xy, xz, yy, yz, zz = some[:, finite]
        minor = xx * yy - xy * xy
        det = zz * minor - xx * yz * yz - yy * xz * xz + 2.0 * xy * yz * xz
        if finite.any() and not ((xx > 0.0) & (minor > 0.0) & (det > 0.0)).any():
            entries = ", ".join(f"{value:.6g}" for value in some[:, np.argmax(finite)])
            raise InvalidParameter(
                f"gamma is not positive definite anywhere; its first node has xx, xy, ... = {entries}"
            )

    @property
    def time_symmetric(self) -> bool:
        """See `ThreeGeometry`."""
        return self.K is None

    @property
    def notes(self) -> tuple[str, ...]:
        """See `ThreeGeometry`."""
        return (*self.remarks, ASSUMED) if self.time_symmetric else self.remarks

    @property
    def box(self) -> tuple[Floats, Floats]:
        """See `ThreeGeometry`: the corners of the grid."""
        origin = np.array(self.origin)
        return origin, origin + (np.array(self.gamma.shape[1:]) - 1) * np.array(self.spacing)

    def _field(self, name: str, x: Floats) -> Floats:
        return np.asarray(getattr(_Interpolation(self, STENCIL), name)(x))

    def error(self, quantity: Callable[[ThreeGeometry], Floats]) -> Floats:
        """See `ThreeGeometry`: ten times the change by interpolation with six or ten points.

        This is about the size of noise, and much more than the truncation error.  The smaller of both changes
        is used for each quantity, as more points are worse near a singularity.  Errors that are smooth on the
        grid are not detected.
        """
        own = quantity(self)
        less, more = (quantity(other) - own for other in (_Interpolation(self, FEWER), WiderStencil(self)))
        smaller = np.sum(less**2, axis=1) < np.sum(more**2, axis=1)
        return np.asarray(ERROR_FACTOR * np.where(smaller[:, None], less, more))

    def deviating(self, x: Floats) -> Iterator[ThreeGeometry]:
        """See `ThreeGeometry`: with noise of the size estimated from high-order differences."""
        fields = self.gamma if self.K is None else np.concatenate([self.gamma, self.K])
        start, s = _Interpolation(self, STENCIL).located(x)
        nodes = np.unique(start + np.round(s).astype(np.int64), axis=0)
        levels = noise_levels(fields, nodes)
        rng = np.random.default_rng(0)
        for _ in range(8):  # noise samples
            yield _Noisy(self, STENCIL, sampled_noise(levels, STENCIL, rng))

    def least_diameter(self, x: Floats) -> float:
        """See `ThreeGeometry`: 20 spacings."""
        return ACROSS * float(np.max(self.spacing))


@dataclass(frozen=True, eq=False)
class _Interpolation(DerivedGeometry):
    """Slice on a grid, interpolated with a given number of points along each axis."""

    grid: CartesianGrid
    nodes: int

    def metric(self, x: Floats) -> Floats:
        start, s = self.located(x)
        return self._summed(slice(6), start, lagrange_weights(s, self.nodes)[0])

    def gradient(self, x: Floats) -> Floats:
        start, s = self.located(x)
        weights, slopes = lagrange_weights(s, self.nodes)
        slopes /= np.array(self.grid.spacing)[:, None]
        return self._gradient(start, weights, slopes)

    def extrinsic_curvature(self, x: Floats) -> Floats:
        if self.grid.K is None:
            return np.zeros((len(x), 3, 3))
        start, s = self.located(x)
        return self._summed(slice(6, 12), start, lagrange_weights(s, self.nodes)[0])

    def _summed(self, part: slice, start: Indices, weights: Floats) -> Floats:
        """Weighted sums (n, 3, 3) of gamma, the first six fields, or K, the other six."""
        fields = self.grid.gamma if part.start is None else self.grid.K
        return np.asarray(contracted(fields, start, weights)[:, ENTRY])

    def _gradient(self, start: Indices, weights: Floats, slopes: Floats) -> Floats:
        """Weighted sums (n, 3, 3, 3) of gamma, with the slopes along one axis."""
        return np.asarray(contracted_gradient(self.grid.gamma, start, weights, slopes)[:, :, ENTRY])

    def located(self, x: Floats) -> tuple[Indices, Floats]:
        """First point of the stencil along each axis (n, 3), and the distance from it in spacings."""
        origin, spacing = np.array(self.grid.origin), np.array(self.grid.spacing)
        shape = np.array(self.grid.gamma.shape[1:])
        t = (x - origin) / spacing
        outside = ((t < -OUTSIDE) | (t > shape - 1.0 + OUTSIDE) | np.isnan(t)).any(axis=1)
        box = f"from {written(origin)} to {written(origin + (shape - 1) * spacing)}"
        refuse_points(outside, x, f"lies outside the grid, which reaches {box}")
        start = np.clip(np.floor(t).astype(np.int64) - (self.nodes // 2 - 1), 0, shape - self.nodes)
        return start, t - start


@dataclass(frozen=True, eq=False)
class _Noisy(_Interpolation):
    """Slice on a grid with periodic noise (m, s, s, s) added to its fields."""

    noise: Floats

    def _summed(self, part: slice, start: Indices, weights: Floats) -> Floats:
        noise = contracted(self.noise[part], start % PERIOD, weights)[:, ENTRY]
        return np.asarray(super()._summed(part, start, weights) + noise)

    def _gradient(self, start: Indices, weights: Floats, slopes: Floats) -> Floats:
        noise = contracted_gradient(self.noise[:6], start % PERIOD, weights, slopes)[:, :, ENTRY]
        return np.asarray(super()._gradient(start, weights, slopes) + noise)


@dataclass(frozen=True, eq=False)
class WiderStencil(InterpolatedGeometry, DerivedGeometry):
    """Slice on a grid, interpolated with two more points where they exist, and two fewer elsewhere."""

    grid: CartesianGrid

    def _field(self, name: str, x: Floats) -> Floats:
        more = STENCIL + 2
        values = np.asarray(getattr(_Interpolation(self.grid, FEWER), name)(x))
        if min(self.grid.gamma.shape[1:]) >= more:
            wider = getattr(_Interpolation(self.grid, more), name)(x)
            there = np.isfinite(wider.reshape(len(x), -1)).all(axis=1)
            values[there] = wider[there]
        return values


def _six(name: str, values: ArrayLike) -> Floats:
    """Entries (6, nx, ny, nz) of symmetric matrices, read-only."""
    array = array_of(name, values).astype(np.float64, copy=False)
    if array.ndim == 5 and array.shape[:2] == (3, 3):
        # A larger asymmetry is not rounding.
        with np.errstate(invalid="ignore"):  # of infinities
            apart = np.abs(array - array.swapaxes(0, 1)) > 1e-10 * np.abs(array).max(axis=(0, 1))
        for i, j in ((0, 1), (0, 2), (1, 2)):
            if apart[i, j].any():
                at = tuple(int(index) for index in np.argwhere(apart[i, j])[0])
                raise InvalidParameter(
                    f"{name} is not symmetric at the grid point {at}: {array[i, j][at]} and {array[j, i][at]}"
                )
        array = array[np.triu_indices(3)]
    if array.ndim != 4 or len(array) != 6:
        raise InvalidParameter(
            f"{name} must have the shape (6, nx, ny, nz) or (3, 3, nx, ny, nz), not {array.shape}"
        )
    array = np.ascontiguousarray(array).view()
    array.setflags(write=False)
    return array


def lagrange_weights(s: Floats, nodes: int) -> tuple[Floats, Floats]:
    """Lagrange polynomials (..., nodes) for the nodes 0, 1, ... at s (...), and their derivatives."""
    x = s - np.arange(nodes).reshape(-1, *[1] * s.ndim)
    # Products of the factors below and above each node, and their derivatives.
    below, above = np.ones((2, *x.shape)), np.ones((2, *x.shape))
    below[1, 0] = above[1, -1] = 0.0
    for j in range(1, nodes):
        below[0, j] = below[0, j - 1] * x[j - 1]
        below[1, j] = below[1, j - 1] * x[j - 1] + below[0, j - 1]
        above[0, -1 - j] = above[0, -j] * x[-j]
        above[1, -1 - j] = above[1, -j] * x[-j] + above[0, -j]
    at_node = [(-1.0) ** (nodes - 1 - j) * factorial(j) * factorial(nodes - 1 - j) for j in range(nodes)]
    both = np.stack([below[0] * above[0], below[1] * above[0] + below[0] * above[1]])
    weights, slopes = np.ascontiguousarray(np.moveaxis(both, 1, -1)) / at_node
    return weights, slopes


def noise_levels(fields: Floats, nodes: Indices) -> Floats:
    """Standard deviations (m,) of the noise in fields (m, nx, ny, nz) at nodes (n, 3) of the grid.

    Differences of order p along an axis, divided by the square root of the binomial coefficient (2 p over p),
    have the standard deviation of white noise.  Smooth parts increase it; the least over axes and orders is
    used.
    """
    levels = np.full(len(fields), np.inf)
    for axis in range(3):
        for order in (6, 8, 10):  # smooth functions affect higher ones less
            size = fields.shape[1 + axis]
            if size <= order:
                continue
            at = nodes.copy()
            at[:, axis] = np.clip(at[:, axis] - order // 2, 0, size - order - 1)
            difference = np.zeros((len(fields), len(nodes)))
            for step in range(order + 1):
                i, j, k = at.T
                difference += (-1) ** step * comb(order, step) * fields[:, i, j, k]
                at[:, axis] += 1
            difference = difference[:, np.isfinite(difference).all(axis=0)]
            if difference.shape[1]:
                levels = np.minimum(levels, np.sqrt(np.mean(difference**2, axis=1) / comb(2 * order, order)))
    return np.where(np.isfinite(levels), levels, 0.0)


def sampled_noise(levels: Floats, margin: int, rng: np.random.Generator) -> Floats:
    """White noise (m, s, s, s) of given levels (m,) on a periodic grid, with a margin after the period."""
    noise = np.empty((len(levels), *[PERIOD + margin] * 3))
    noise[:, :PERIOD, :PERIOD, :PERIOD] = rng.standard_normal((len(levels), *[PERIOD] * 3))
    noise[:, :PERIOD, :PERIOD, :PERIOD] *= levels[:, None, None, None]
    for axis in (1, 2, 3):
        along = np.moveaxis(noise, axis, 0)
        along[PERIOD:] = along[:margin]
    return noise
