"""Slices of spacetime: metric, gradient, extrinsic curvature; slices from functions; their checks.

Signs are those of Alcubierre and of Baumgarte and Shapiro:
``K_ij = -(d_t gamma_ij - L_beta gamma_ij) / (2 alpha)``, and outgoing light rays expand by
``theta_+ = k - K_ij (gamma^ij - n^i n^j)``.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter
from isoembed.relativity.spacetimes.checks import positive_number
from isoembed.relativity.spacetimes.differences import (
    EIGHTH,
    SIXTH,
    central_differences,
    disagreement,
)
from isoembed.smooth.user_functions import array_of, called

Numbers = NDArray[Any]
"""Real arrays, or complex ones for complex-step derivatives."""

COMPLEX_STEP = 1e-30  # its square is negligible


class ThreeGeometry(ABC):
    """Spacelike slice in Cartesian coordinates x, y, z of any kind.

    Derived classes define `time_symmetric`, `metric`, `gradient`, `extrinsic_curvature` and `error`; the
    other members default to a slice without known black holes, without a boundary and without a grid.
    """

    @property
    @abstractmethod
    def time_symmetric(self) -> bool:
        """Whether the extrinsic curvature vanishes everywhere."""

    @property
    def black_holes(self) -> tuple[tuple[float, Sequence[float]], ...]:
        """Mass and position of each black hole; by default none are known.

        Searches for horizons start from spheres around them, and surfaces may not pass through them.
        """
        return ()

    @property
    def box(self) -> tuple[Floats, Floats] | None:
        """Lower and upper corner, each (3,), of the domain of the slice; None if unbounded.

        Without black holes, searches for horizons start from the largest sphere in it.
        """
        return None

    @property
    def hindrance(self) -> str:
        """Reason why no horizon can be found in the slice; by default empty."""
        return ""

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes needed to interpret the numbers of surfaces in the slice; by default none."""
        return ()

    @abstractmethod
    def metric(self, x: Floats) -> Floats:
        """``gamma_ij`` (n, 3, 3) at the points x (n, 3)."""

    @abstractmethod
    def gradient(self, x: Floats) -> Floats:
        """``d_k gamma_ij`` (n, 3, 3, 3) at the points x (n, 3), in the order [point, k, i, j]."""

    @abstractmethod
    def extrinsic_curvature(self, x: Floats) -> Floats:
        """``K_ij`` (n, 3, 3) at the points x (n, 3)."""

    @abstractmethod
    def error(self, quantity: Callable[[ThreeGeometry], Floats]) -> Floats:
        """Errors of a quantity computed from the slice, with their signs if known.

        Parameters
        ----------
        quantity : callable
            Takes a slice, this one or an approximation of different accuracy, and returns an array (c, n) of
            c quantities at n points.

        Returns
        -------
        ndarray, shape (c, n)
        """

    def deviating(self, x: Floats) -> Iterator[ThreeGeometry]:
        """Random samples of the slice within the noise of its data, near x (n, 3); by default none."""
        yield from ()

    def least_diameter(self, x: Floats) -> float:
        """Coordinate diameter of the smallest horizon resolved by a grid at the points x (n, 3).

        By default 0, without a grid.  It is used to explain failed searches for smaller horizons.
        """
        return 0.0


def check_geometry(geometry: object) -> None:
    """Check that an object is a slice.  Raises `InvalidParameter`: it is not, but a function, for example."""
    if not isinstance(geometry, ThreeGeometry):
        advice = (
            "AnalyticCallable and CallableGeometry make one of a function"
            if callable(geometry)
            else "derive its class from ThreeGeometry"
        )
        raise InvalidParameter(f"the slice is a {type(geometry).__name__}, not a ThreeGeometry: {advice}")


def check_members(geometry: ThreeGeometry, x: Floats) -> None:
    """Check a slice of a user-defined class at some of the points x (n, 3).

    Raises
    ------
    InvalidParameter
        An array has a wrong shape, the gradient is not that of the metric, or a slice declared time-symmetric
        has a nonzero extrinsic curvature.
    """
    kind = type(geometry)
    if kind.__module__.split(".")[0] == __name__.split(".")[0]:
        return
    x = x[:: len(x) // 32 + 1]  # at most 32 of them
    n, found = len(x), {}
    for name, axes in (("metric", 2), ("gradient", 3), ("extrinsic_curvature", 2)):
        found[name] = np.asarray(getattr(geometry, name)(x))
        if found[name].shape != (n,) + (3,) * axes:
            raise InvalidParameter(
                f"{kind.__name__}.{name} returns an array of shape {found[name].shape} for {n} points, not "
                f"{(n,) + (3,) * axes}"
            )
    if wrong := disagreement(geometry.metric, x, found["gradient"], relative=1e-3):
        given, other = wrong
        turned = (found["gradient"].transpose(0, *order) for order in ((2, 3, 1), (3, 1, 2), (2, 1, 3)))
        fits = any(not disagreement(geometry.metric, x, each, relative=1e-3) for each in turned)
        hint = ": the order is [point, k, i, j], with d_k gamma_ij" if fits else ""
        raise InvalidParameter(
            f"{given} by {kind.__name__}.gradient and {other:.6g} by differences of its metric{hint}"
        )
    if geometry.time_symmetric and found["extrinsic_curvature"].any():
        raise InvalidParameter(
            f"{kind.__name__}.time_symmetric is True, but its extrinsic curvature is not zero everywhere"
        )


class AnalyticGeometry(ThreeGeometry):
    """Slice with a metric that accepts complex coordinates, for exact derivatives."""

    @property
    def time_symmetric(self) -> bool:
        """Whether the extrinsic curvature vanishes everywhere."""
        return True

    @abstractmethod
    def metric(self, x: Numbers) -> Numbers:
        """``gamma_ij`` (n, 3, 3) at the points x (n, 3), which may be complex."""

    def gradient(self, x: Floats) -> Floats:
        """See `ThreeGeometry`."""
        return complex_step(self.metric, x)

    def extrinsic_curvature(self, x: Floats) -> Floats:
        """See `ThreeGeometry`."""
        return np.zeros((len(x), 3, 3))

    def error(self, quantity: Callable[[ThreeGeometry], Floats]) -> Floats:
        """Zero: see `ThreeGeometry`."""
        return np.zeros_like(quantity(self))


class InterpolatedGeometry(ThreeGeometry):
    """Slice whose fields are interpolated by one method."""

    @abstractmethod
    def _field(self, name: str, x: Floats) -> Floats:
        """``metric``, ``gradient`` or ``extrinsic_curvature``, by name, at the points x (n, 3)."""

    def metric(self, x: Floats) -> Floats:
        """See `ThreeGeometry`."""
        return self._field("metric", x)

    def gradient(self, x: Floats) -> Floats:
        """See `ThreeGeometry`."""
        return self._field("gradient", x)

    def extrinsic_curvature(self, x: Floats) -> Floats:
        """See `ThreeGeometry`."""
        return self._field("extrinsic_curvature", x)


ASSUMED = "the slice has no K_ij: it is assumed to be time-symmetric"
"""Note on a slice on a grid."""


class DerivedGeometry(ThreeGeometry):
    """Slice on a grid with another interpolation and otherwise the same properties."""

    grid: ThreeGeometry

    @property
    def time_symmetric(self) -> bool:
        """See `ThreeGeometry`."""
        return self.grid.time_symmetric

    def error(self, quantity: Callable[[ThreeGeometry], Floats]) -> Floats:
        """See `ThreeGeometry`: that of the grid."""
        return self.grid.error(quantity)


class _Callables(ThreeGeometry):
    """Slice given by functions of x (n, 3)."""

    gamma: Callable[[Numbers], ArrayLike]
    K: Callable[[Floats], ArrayLike] | None

    def __post_init__(self) -> None:
        if not callable(self.gamma):
            raise InvalidParameter(f"gamma is a {type(self.gamma).__name__}, not a function of x (n, 3)")
        if not (self.K is None or callable(self.K)):
            raise InvalidParameter(
                f"K is a {type(self.K).__name__}, not a function of x (n, 3); a time-symmetric slice has none"
            )

    @property
    def time_symmetric(self) -> bool:
        """See `ThreeGeometry`."""
        return self.K is None

    def metric(self, x: Numbers) -> Numbers:
        """See `ThreeGeometry`."""
        return _matrices("the metric", self.gamma, x)

    def extrinsic_curvature(self, x: Floats) -> Floats:
        """See `ThreeGeometry`."""
        return np.zeros((len(x), 3, 3)) if self.K is None else _matrices("K_ij", self.K, x)


@dataclass(frozen=True)
class AnalyticCallable(_Callables, AnalyticGeometry):
    """Slice given by functions, with a metric that accepts complex coordinates.

    The metric must not use absolute values, norms, real parts, maxima, conjugates or ``arctan2``, or fill
    arrays of floats: write ``np.sqrt((x**2).sum(axis=1))`` for a radius, and create arrays of ``x.dtype``.

    Raises
    ------
    InvalidParameter
        The derivatives of the metric differ from central differences at a few points.

    Attributes
    ----------
    gamma : callable
        Takes x (n, 3), real or complex, and returns ``gamma_ij`` (n, 3, 3).
    K : callable, optional
        Takes x (n, 3), real, and returns ``K_ij`` (n, 3, 3); without it the slice is time-symmetric.
    """

    gamma: Callable[[Numbers], ArrayLike]
    K: Callable[[Floats], ArrayLike] | None = None

    def gradient(self, x: Floats) -> Floats:
        """See `ThreeGeometry`."""
        gradient = super().gradient(x)
        if wrong := disagreement(self.metric, x, gradient, relative=1e-6):
            given, other = wrong
            raise InvalidParameter(
                f"{given} by the complex step and {other:.6g} by differences: the function for "
                "the metric must accept complex x, but np.linalg.norm, np.abs, np.real and arrays of floats "
                "discard the imaginary part. Write np.sqrt((x**2).sum(axis=1)) for the radius and "
                "np.zeros(..., dtype=x.dtype) for an array, or use CallableGeometry(gamma, length)"
            )
        return gradient


@dataclass(frozen=True)
class CallableGeometry(_Callables):
    """Slice given by arbitrary functions, differentiated by central differences of sixth order.

    Attributes
    ----------
    gamma : callable
        Takes x (n, 3) and returns ``gamma_ij`` (n, 3, 3).
    length : float
        Distance to the nearest hole, or another length scale of the metric.  Steps are 1/256 of it, and the
        gradient of ``1 + length / r`` at r = length is accurate to a few 1e-14.  With a tenth of this length,
        rounding and errors of energies are ten times as large; with ten times this length, the differences
        extend across the hole.
    K : callable, optional
        Takes x (n, 3) and returns ``K_ij`` (n, 3, 3); without it the slice is time-symmetric.

    Raises
    ------
    InvalidParameter
        The length is not positive, or the gradient differs from that with shorter steps at a few points.
    """

    gamma: Callable[[Floats], ArrayLike]
    length: float
    K: Callable[[Floats], ArrayLike] | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        positive_number("the length over which the metric varies", self.length)

    def gradient(self, x: Floats) -> Floats:
        """See `ThreeGeometry`."""
        gradient = self._differentiated(x, SIXTH)
        # Finer steps only, as coarser ones may agree for large noise.
        if wrong := disagreement(self.metric, x, gradient, relative=1e-3, step=self._step / 8.0):
            given, other = wrong
            raise InvalidParameter(
                f"{given} by differences over 1/256 of the length {self.length:.6g} and "
                f"{other:.6g} over shorter ones: give the distance to the nearest hole as the length"
            )
        return gradient

    def error(self, quantity: Callable[[ThreeGeometry], Floats]) -> Floats:
        """See `ThreeGeometry`: ten times the change to eighth-order differences.

        That change is only a tenth of noise and rounding.
        """
        eighth = _EighthOrder(self.gamma, self.length, self.K)
        return np.asarray(10.0 * (quantity(eighth) - quantity(self)))

    def _differentiated(self, x: Floats, weights: tuple[float, ...]) -> Floats:
        return central_differences(self.metric, x, self._step, weights)

    @property
    def _step(self) -> float:
        return self.length / 256.0  # balances truncation and rounding


class _EighthOrder(CallableGeometry):
    def gradient(self, x: Floats) -> Floats:
        return self._differentiated(x, EIGHTH)


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
        Derivative with respect to the k-th coordinate at [:, k].

    References
    ----------
    Squire and Trapp, SIAM Rev. 40 (1998) 110.
    """
    x = np.asarray(x, dtype=np.float64)
    step = COMPLEX_STEP * (float(np.abs(x).max(initial=0.0)) or 1.0)
    return np.stack([f(x + 1j * step * np.eye(3)[k]).imag / step for k in range(3)], axis=1)


def stationary_curvature(
    gradient: Floats, metric: Floats, lapse: Floats, shift: Floats, d_shift: Floats
) -> Floats:
    """``K_ij = (D_i beta_j + D_j beta_i) / (2 alpha)`` (n, 3, 3) of a stationary slice.

    Parameters
    ----------
    gradient, metric : ndarray
        ``d_k gamma_ij`` (n, 3, 3, 3) and ``gamma_ij`` (n, 3, 3).
    lapse : ndarray, shape (n,)
    shift : ndarray, shape (n, 3)
        ``beta_i``, with lowered index.
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


def _matrices(of: str, function: Callable[[Numbers], ArrayLike], x: Numbers) -> Numbers:
    n, subject = len(x), f"the function for {of}"
    array = array_of(subject, called(subject, function, x), real=not np.iscomplexobj(x))
    if array.shape != (n, 3, 3):
        raise InvalidParameter(f"{subject} returns the shape {array.shape} for {n} points, not ({n}, 3, 3)")
    return array
