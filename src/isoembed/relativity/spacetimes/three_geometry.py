"""What a slice of spacetime is: its metric, the gradient of that, and its extrinsic curvature.

Signs are those of Alcubierre and of Baumgarte and Shapiro:
``K_ij = -(d_t gamma_ij - L_beta gamma_ij) / (2 alpha)``, and outgoing light rays expand by
``theta_+ = k - K_ij (gamma^ij - n^i n^j)``.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from isoembed.errors import InvalidMetric, InvalidParameter

Floats = NDArray[np.float64]
Numbers = NDArray[Any]
"""Real, or complex for derivatives by the complex step."""

STEP = 1.0 / 256.0
"""Step of differences over the length of a `CallableGeometry`: truncation and rounding are alike there."""


class ThreeGeometry(Protocol):
    """A spacelike slice, in Cartesian coordinates x, y, z of any kind."""

    @property
    def time_symmetric(self) -> bool:
        """Whether the extrinsic curvature vanishes everywhere."""
        ...

    def metric(self, x: Floats) -> Floats:
        """``gamma_ij`` (n, 3, 3) at the points x (n, 3)."""
        ...

    def gradient(self, x: Floats) -> Floats:
        """``d_k gamma_ij`` (n, 3, 3, 3) at the points x (n, 3), in the order [point, k, i, j]."""
        ...

    def extrinsic_curvature(self, x: Floats) -> Floats:
        """``K_ij`` (n, 3, 3) at the points x (n, 3)."""
        ...

    def relative_error(self, x: Floats) -> float:
        """How uncertain the three are at the points x (n, 3) of a surface, as an error of lengths over them.

        That is half an error of the metric over the metric.  One of the gradient, or of K, counts as what it
        makes over the distance of the points from their mean: the mean curvature is as uncertain.
        """
        ...


class AnalyticGeometry(ABC):
    """A slice whose metric is a formula that holds for complex coordinates: it has exact derivatives."""

    time_symmetric: bool = True

    @abstractmethod
    def metric(self, x: Numbers) -> Numbers:
        """``gamma_ij`` (n, 3, 3) at the points x (n, 3), which may be complex."""

    def gradient(self, x: Floats) -> Floats:
        """See `ThreeGeometry`."""
        return complex_step(self.metric, x)

    def extrinsic_curvature(self, x: Floats) -> Floats:
        """See `ThreeGeometry`."""
        return np.zeros((len(x), 3, 3))

    def relative_error(self, x: Floats) -> float:
        """Zero: see `ThreeGeometry`."""
        return 0.0


@dataclass(frozen=True)
class AnalyticCallable(AnalyticGeometry):
    """A slice given by functions of which the metric takes complex coordinates, too.

    No absolute value, norm, maximum, conjugate or ``arctan2`` may occur in it.

    Attributes
    ----------
    gamma : callable
        Takes x (n, 3), real or complex, and returns ``gamma_ij`` (n, 3, 3).
    K : callable, optional
        Takes x (n, 3), real, and returns ``K_ij`` (n, 3, 3); without it the slice is time-symmetric.
    """

    gamma: Callable[[Numbers], ArrayLike]
    K: Callable[[Floats], ArrayLike] | None = None

    @property
    def time_symmetric(self) -> bool:  # type: ignore[override]
        """See `ThreeGeometry`."""
        return self.K is None

    def metric(self, x: Numbers) -> Numbers:
        """See `ThreeGeometry`; x may be complex."""
        return _matrices("metric", self.gamma(x), len(x))

    def extrinsic_curvature(self, x: Floats) -> Floats:
        """See `ThreeGeometry`."""
        return np.zeros((len(x), 3, 3)) if self.K is None else _matrices("K_ij", self.K(x), len(x))


@dataclass(frozen=True)
class CallableGeometry:
    """A slice given by any functions, differentiated by central differences of sixth order.

    Attributes
    ----------
    gamma : callable
        Takes x (n, 3) and returns ``gamma_ij`` (n, 3, 3).
    length : float
        The distance over which the metric varies, for one the distance to the nearest hole: steps are 1/256
        of it, and the gradient of ``1 + length / r`` at r = length is right to a few 1e-14.
    K : callable, optional
        Takes x (n, 3) and returns ``K_ij`` (n, 3, 3); without it the slice is time-symmetric.
    """

    gamma: Callable[[Floats], ArrayLike]
    length: float
    K: Callable[[Floats], ArrayLike] | None = None

    def __post_init__(self) -> None:
        positive_number("the length over which the metric varies", self.length)

    @property
    def time_symmetric(self) -> bool:
        """See `ThreeGeometry`."""
        return self.K is None

    def metric(self, x: Floats) -> Floats:
        """See `ThreeGeometry`."""
        return _matrices("metric", self.gamma(x), len(x))

    def gradient(self, x: Floats) -> Floats:
        """See `ThreeGeometry`."""
        return self._differentiated(x, (45.0 / 60.0, -9.0 / 60.0, 1.0 / 60.0))

    def extrinsic_curvature(self, x: Floats) -> Floats:
        """See `ThreeGeometry`."""
        return np.zeros((len(x), 3, 3)) if self.K is None else _matrices("K_ij", self.K(x), len(x))

    def relative_error(self, x: Floats) -> float:
        """See `ThreeGeometry`: what differences of eighth order tell, of noise a tenth; and rounding."""
        eighth = self._differentiated(x, (4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0))
        change = float(np.abs(eighth - self.gradient(x)).max(initial=0.0))
        rounding = float(np.finfo(np.float64).eps) / (STEP * self.length)
        size, distance = extent(x, self.metric(x))
        return 0.5 * distance * (10.0 * change / size + rounding)

    def _differentiated(self, x: Floats, weights: Sequence[float]) -> Floats:
        """The gradient (n, 3, 3, 3) from differences over one, two, ... steps to both sides."""
        out = np.zeros((len(x), 3, 3, 3))
        for k in range(3):
            for steps, weight in enumerate(weights, start=1):
                shift = np.zeros(3)
                shift[k] = steps * STEP * self.length
                out[:, k] += weight * (self.metric(x + shift) - self.metric(x - shift))
        return out / (STEP * self.length)


def extent(x: Floats, gamma: Floats) -> tuple[float, float]:
    """The least size of a metric (n, 3, 3) at points x (n, 3), and their largest distance from their mean."""
    size = np.linalg.norm(gamma, axis=(1, 2)).min()
    return float(size), float(np.linalg.norm(x - x.mean(axis=0), axis=1).max())


def complex_step(f: Callable[[Numbers], Numbers], x: Floats) -> Floats:
    """Derivatives of a holomorphic function, exact to rounding.

    Parameters
    ----------
    f : callable
        Takes x (n, 3), complex, and returns an array (n, ...).
    x : ndarray, shape (n, 3)

    Returns
    -------
    ndarray, shape (n, 3, ...)
        The derivative in the k-th coordinate at [:, k].

    References
    ----------
    Squire and Trapp, SIAM Rev. 40 (1998) 110.
    """
    x = np.asarray(x, dtype=np.float64)
    # Any step will do whose square is nothing beside 1; it is measured in the lengths of the problem.
    step = 1e-30 * (float(np.abs(x).max(initial=0.0)) or 1.0)
    return np.stack([f(x + 1j * step * np.eye(3)[k]).imag / step for k in range(3)], axis=1)


def stationary_curvature(
    gradient: Floats, metric: Floats, lapse: Floats, shift: Floats, d_shift: Floats
) -> Floats:
    """``K_ij = (D_i beta_j + D_j beta_i) / (2 alpha)`` (n, 3, 3) of a slice that does not change with time.

    Parameters
    ----------
    gradient, metric : ndarray
        ``d_k gamma_ij`` (n, 3, 3, 3) and ``gamma_ij`` (n, 3, 3).
    lapse : ndarray, shape (n,)
    shift : ndarray, shape (n, 3)
        ``beta_i``, the index below.
    d_shift : ndarray, shape (n, 3, 3)
        ``d_i beta_j``.

    References
    ----------
    Alcubierre, Introduction to 3+1 Numerical Relativity (2008), Eq. (2.3.11).
    """
    up = np.linalg.solve(metric, shift[:, :, None])[:, :, 0]
    # beta^k Gamma_kij, times 2
    mixed = np.einsum("nk,nikj->nij", up, gradient)
    christoffel = mixed + mixed.transpose(0, 2, 1) - np.einsum("nk,nkij->nij", up, gradient)
    return (d_shift + d_shift.transpose(0, 2, 1) - christoffel) / (2.0 * lapse[:, None, None])


def positive_number(what: str, value: float) -> float:
    """Return a number that must be positive and finite.

    Raises
    ------
    InvalidParameter
        It is not.
    """
    number = numbers(value)
    if number.ndim != 0 or not (isfinite(number) and number > 0.0):
        raise InvalidParameter(f"{what} must be positive, not {value}")
    return float(number)


def vector(what: str, value: Sequence[float] | Floats) -> tuple[float, float, float]:
    """Return three finite numbers.

    Raises
    ------
    InvalidParameter
        They are not three, or one is not finite.
    """
    array = numbers(value)
    if array.shape != (3,) or not np.isfinite(array).all():
        raise InvalidParameter(f"{what} must be three finite numbers, not {value}")
    x, y, z = array.tolist()
    return x, y, z


def numbers(given: ArrayLike) -> Floats:
    """An array of what is given; one that is not a number, of shape (), where it has none."""
    try:
        return np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError):
        return np.array(np.nan)


def refuse_points(bad: NDArray[np.bool_], x: Numbers, why: str) -> None:
    """Name the first of some points that are where they must not be.

    Raises
    ------
    InvalidParameter
        There is one.
    """
    if bad.any():
        i = int(np.argmax(bad))
        raise InvalidParameter(f"point {i}, {written(x[i].real)}, {why}")


def check_slice(what: str, x: Floats, gamma: Floats) -> None:
    """Refuse what is no Riemannian metric.

    Raises
    ------
    InvalidMetric
        It is not finite or not positive definite; the message names the first such point.
    """
    minor = gamma[:, 0, 0] * gamma[:, 1, 1] - gamma[:, 0, 1] * gamma[:, 1, 0]
    good = np.isfinite(gamma).all(axis=(1, 2)) & (gamma[:, 0, 0] > 0) & (minor > 0)
    good[good] = np.linalg.det(gamma[good]) > 0
    if not good.all():
        i = int(np.argmin(good))
        entries = ", ".join(f"{value:.6g}" for value in gamma[i][np.triu_indices(3)])
        raise InvalidMetric(f"{what} at {written(x[i])} is not positive definite: xx, xy, ... = {entries}")


def written(x: Floats) -> str:
    """Three numbers for a message."""
    return f"({x[0]:.6g}, {x[1]:.6g}, {x[2]:.6g})"


def _matrices(what: str, given: ArrayLike, n: int) -> Numbers:
    array = np.asarray(given)
    if array.shape != (n, 3, 3):
        raise InvalidParameter(
            f"the function for {what} returns the shape {array.shape} for {n} points, not ({n}, 3, 3)"
        )
    return array
