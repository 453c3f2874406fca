"""Double Fourier interpolation on a (theta, phi) grid, whose kind (uniform, Gauss-Legendre) is recognized.

Extended to all theta, a smooth function on the sphere is invariant under the glide reflection (theta, phi) ->
(-theta, phi + pi), so that the coefficient of exp(i m phi) is a cosine series in theta for even m and a sine
series for odd m [1]_.  The poles need no special treatment.

References
----------
.. [1] S. A. Orszag, "Fourier series on spheres", Monthly Weather Review 102 (1974), 56-75.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.polynomial import legendre
from numpy.typing import ArrayLike, NDArray

from isoembed.arrays import Floats, Indices, Mask, chunks
from isoembed.errors import InvalidMetric
from isoembed.meshing.sphere import angles_of

Complexes = NDArray[np.complex128]

POLE = 1e-6  # angle from the pole within which a node counts as the pole, in radians
UNEVEN = 1e-6  # largest deviation of the angles phi from uniform spacing, in steps
FINER = 8  # refinement of the table relative to the grid; half of it for large tables
LARGE = 1 << 24  # number of entries of a large table
STENCIL = 16  # nodes per direction of the local interpolation, accurate to 1e-12
CHUNK = 256  # values interpolated at a time, whose stencils fit into the cache


@dataclass(frozen=True, eq=False)
class DoubleFourier:
    """Fourier series of functions given on a grid in theta and phi.

    Parameters
    ----------
    theta : array_like, shape (n,)
        Increasing angles, strictly between 0 and pi; see `inner_nodes`.
    phi : array_like, shape (m,)
        Uniform angles as in `around`, without the end point.
    values : ndarray, shape (n, m, c)
        Values of c functions at the nodes: scalars, or tensor components invariant under the reflection.

    Raises
    ------
    InvalidMetric
        The nodes do not determine a series, for example if they are on one hemisphere only.
    """

    theta: Floats
    phi: Floats
    values: Floats

    def __post_init__(self) -> None:
        condition = self.condition
        if not condition < 1e4:  # the nodes do not determine the series
            raise InvalidMetric(
                f"the {len(self.theta)} nodes theta = {self.theta[0]:.6g} ... {self.theta[-1]:.6g} do not "
                f"determine a Fourier series (condition {condition:.1g}): cell-centered, uniform and "
                "Gauss-Legendre nodes from pole to pole do"
            )

    @cached_property
    def condition(self) -> float:
        """Condition number of the series at the nodes in theta: sqrt(2) for cell-centered grids or more."""
        return float(max(np.linalg.cond(series) for series in self._series(self.theta)))

    def _series(self, theta: Floats) -> tuple[Floats, Floats]:
        """Cosines for even m and sines for odd m, each (len(theta), n)."""
        k = np.arange(len(self.theta))
        return np.cos(np.multiply.outer(theta, k)), np.sin(np.multiply.outer(theta, k + 1))

    @cached_property
    def coefficients(self) -> Complexes:
        """Coefficients (n, m // 2 + 1, c) of cosines or sines in theta times exp(i m (phi - phi_0))."""
        m = len(self.phi)
        spectrum = np.fft.rfft(self.values, axis=1) / m
        spectrum[:, 1 : (m + 1) // 2] *= 2.0  # one-sided spectrum: all orders but 0 and m / 2
        for parity, series in enumerate(self._series(self.theta)):
            part = spectrum[:, parity::2]
            spectrum[:, parity::2] = np.linalg.solve(series, _flat(part)).reshape(part.shape)
        return spectrum

    @cached_property
    def table(self) -> Floats:
        """Values on a finer grid, with a margin of half a stencil for `at`; one column for one angle phi."""
        (rows, columns), margin = self._table_shape, STENCIL // 2
        theta = np.arange(-margin, rows + margin + 1, dtype=np.float64) * (np.pi / rows)
        a = self.coefficients
        spectrum = np.zeros((len(theta), columns // 2 + 1, a.shape[2]), dtype=np.complex128)
        for parity, series in enumerate(self._series(theta)):
            part = a[:, parity::2]
            values = series @ _flat(part)
            spectrum[:, parity : a.shape[1] : 2] = values.reshape(len(theta), *part.shape[1:])
        spectrum[:, 1:] /= 2.0
        fine = np.fft.irfft(spectrum * columns, columns, axis=1)
        margins = np.arange(-margin, columns + margin + 1) % columns
        return np.ascontiguousarray(fine if columns == 1 else fine[:, margins])

    def on(self, theta: Floats, phi: Floats) -> Floats:
        """Values (k, l, c) on the product grid of theta (k,) and phi (l,), by direct summation."""
        a = self.coefficients
        turns = np.exp(1j * np.multiply.outer(np.arange(a.shape[1]), phi - self.phi[0]))
        heights = np.empty((len(theta), *a.shape[1:]), dtype=np.complex128)
        for parity, series in enumerate(self._series(theta)):
            part = a[:, parity::2]
            heights[:, parity::2] = (series @ _flat(part)).reshape(len(theta), *part.shape[1:])
        return np.ascontiguousarray(np.einsum("kmc,ml->klc", heights, turns, optimize=True).real)

    @property
    def _table_shape(self) -> tuple[int, int]:
        """Numbers of steps from pole to pole and around."""
        finer = FINER if self.values.size * FINER**2 <= LARGE else FINER // 2
        m = len(self.phi)
        return finer * len(self.theta), 1 if m == 1 else finer * max(m, 2 * STENCIL // FINER)

    def at(self, u: Floats) -> Floats:
        """Values (n, c) at unit vectors u (n, 3); at the poles the limit along phi = 0."""
        theta, phi = angles_of(u)
        phi = (phi - self.phi[0]) % (2.0 * np.pi)
        rows, columns = self._table_shape
        return _interpolated(self.table, theta * (rows / np.pi), phi * (columns / (2.0 * np.pi)))


def inner_nodes(theta: ArrayLike) -> Mask:
    """Mask of the angles theta (n,) of a grid other than the poles.

    Raises
    ------
    InvalidMetric
        The angles are not finite, not between 0 and pi, or not increasing, or there are fewer than two
        besides the poles; the message names the first such node.
    """
    theta = one_dimensional(theta, "theta")
    bad = ~((theta >= -POLE) & (theta <= np.pi + POLE))
    if bad.any():
        i = int(np.argmax(bad))
        raise InvalidMetric(
            f"theta[{i}] = {theta[i]:.6g} is not between 0 and pi: it counts from the north pole, in radians"
        )
    falls = np.diff(theta) <= 0.0
    if falls.any():
        i = int(np.argmax(falls))
        raise InvalidMetric(
            f"theta[{i + 1}] = {theta[i + 1]:.6g} is not above theta[{i}] = {theta[i]:.6g}: the angles "
            "increase, from the north pole on"
        )
    inner = (theta > POLE) & (theta < np.pi - POLE)
    if inner.sum() < 2:
        raise InvalidMetric(f"there are {inner.sum()} nodes theta besides the poles, fewer than 2")
    return inner


def around(phi: ArrayLike) -> int:
    """Number of distinct angles phi (m,) of a grid: all, or all but a repeated end point.

    The angles are uniform over one full turn, from any first angle; a single angle is for functions symmetric
    about the z-axis.

    Raises
    ------
    InvalidMetric
        The angles are not of this form; the message names the first wrong one.
    """
    phi = one_dimensional(phi, "phi")
    closed = len(phi) > 1 and abs(phi[-1] - phi[0] - 2.0 * np.pi) < UNEVEN
    m = len(phi) - 1 if closed else len(phi)
    step = 2.0 * np.pi / m
    expected = phi[0] + step * np.arange(m)
    bad = ~(np.abs(phi[:m] - expected) <= UNEVEN * step + _rounding(expected))
    if bad.any():
        j = int(np.argmax(bad))
        rounded = np.abs(phi[:m] - expected).max() <= 1e-3 * step
        advice = ", in eight digits or more" if rounded else ""
        raise InvalidMetric(
            f"phi[{j}] = {distinct(phi[j], expected[j])} is not {distinct(expected[j], phi[j])}: "
            f"{m} uniform angles phi from {phi[0]:.6g} once around are needed, in radians{advice}"
        )
    return m


def exact_theta(theta: ArrayLike) -> Floats:
    """Angles theta (n,), with single-precision angles of a standard grid replaced by the exact ones."""
    nodes = one_dimensional(theta, "theta")
    n = len(nodes)
    one_to_n = np.arange(1.0, n + 1.0)
    grids = [
        (one_to_n - 0.5) * (np.pi / n),
        np.linspace(0.0, np.pi, n) if n > 1 else nodes,
        one_to_n * (np.pi / (n + 1)),
    ]
    if is_legendre(nodes):
        grids.append(np.asarray(np.arccos(legendre.leggauss(n)[0])[::-1]))
    return next((exact for exact in grids if _is_rounded(nodes, exact)), nodes)


def is_legendre(theta: Floats) -> bool:
    """Whether angles theta (n,) are close to Gauss-Legendre nodes rather than those of other grids."""
    n = len(theta)
    near = (np.arange(n) + 0.75) * (np.pi / (n + 0.5))
    # Gauss-Legendre nodes deviate from these uniform angles by 0.1 / n at most.
    return bool(np.max(np.abs(theta - near)) < 0.1 / n)


def exact_phi(phi: ArrayLike) -> Floats:
    """Angles phi (m,), with single-precision angles of a standard grid replaced by the exact ones."""
    nodes = one_dimensional(phi, "phi")
    m = len(nodes)
    for steps in (m, m - 1):  # without and with the end point
        if steps > 0:
            half = np.pi / steps
            exact = np.round(nodes[0] / half) * half + 2.0 * half * np.arange(m)
            if _is_rounded(nodes, exact):
                return exact
    return nodes


def _is_rounded(nodes: Floats, exact: Floats) -> bool:
    """Whether angles are roundings of exact ones to single precision, or computed in it."""
    single = np.all(nodes == nodes.astype(np.float32))
    return bool(single and np.all(np.abs(nodes - exact) <= _rounding(exact)))


def _rounding(angles: Floats) -> Floats:
    """Rounding errors (n,) of angles in single precision."""
    return 4.0 * float(np.finfo(np.float32).eps) * np.maximum(np.abs(angles), 1.0)


def distinct(value: float, other: float) -> str:
    """Number with enough digits to distinguish it from another one."""
    return next(
        (f"{value:.{d}g}" for d in (6, 9, 12) if f"{value:.{d}g}" != f"{other:.{d}g}"), f"{value:.17g}"
    )


def one_dimensional(angles: ArrayLike, name: str) -> Floats:
    """Checked angles as a one-dimensional array.

    Raises
    ------
    InvalidMetric
        The angles are not a one-dimensional array of finite numbers; the message names the first bad one.
    """
    array = np.asarray(angles)
    if array.ndim != 1 or array.size == 0 or array.dtype.kind not in "iuf":
        raise InvalidMetric(
            f"{name} has the shape {array.shape} and the type {array.dtype}, not (n,) numbers"
        )
    bad = ~np.isfinite(array)
    if bad.any():
        i = int(np.argmax(bad))
        raise InvalidMetric(f"{name}[{i}] = {array[i]} is not finite")
    return array.astype(np.float64)


def _flat(part: Complexes) -> Complexes:
    return part.reshape(len(part), part.shape[1] * part.shape[2])


def _weights(t: Floats) -> Floats:
    """Lagrange weights (n, stencil) at t (n,) in [0, 1] for nodes 1 - stencil / 2, ..., stencil / 2."""
    stencil = STENCIL
    first = 1 - stencil // 2
    weights, after = np.ones((stencil, t.size)), np.ones_like(t)
    for j in range(1, stencil):
        weights[j] = weights[j - 1] * (t - (first + j - 1)) / j
    for j in range(stencil - 1, -1, -1):
        weights[j] *= after
        after *= -(t - (first + j)) / (stencil - j)
    return np.ascontiguousarray(weights.T)


def _stencils(positions: Floats, count: int) -> tuple[Indices, Floats]:
    """First nodes (n,) and weights (n, stencil) at fractional indices (n,); one node needs no stencil."""
    if count == 1:
        return np.zeros(len(positions), dtype=np.int64), np.ones((len(positions), 1))
    before = np.minimum(positions.astype(np.int64), count - STENCIL - 2)
    return before + 1, _weights(positions - before)


def _interpolated(table: Floats, rows: Floats, columns: Floats) -> Floats:
    """Interpolated values (n, c) at fractional indices (n,) inside a table (rows, columns, c)."""
    n_rows, n_columns, count = table.shape
    (i, w_row), (j, w_column) = _stencils(rows, n_rows), _stencils(columns, n_columns)
    width = w_column.shape[1]
    windows = sliding_window_view(table.reshape(n_rows, -1), (STENCIL, width * count))
    values = np.empty((len(rows), count))
    for some in chunks(len(rows), CHUNK):
        nodes = windows[i[some], j[some] * count]
        across = (w_row[some, None] @ nodes).reshape(-1, width, count)
        values[some] = (w_column[some, None] @ across)[:, 0]
    return values
