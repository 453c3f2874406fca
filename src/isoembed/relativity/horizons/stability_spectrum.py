"""Spectrum of the stability operator of a marginally outer trapped surface.

The operator is not self-adjoint unless the slice is time-symmetric: its eigenvalues may be complex, and then
come in pairs.  The one with the least real part, the principal eigenvalue, is real.  Eigenfunctions are
expanded in spherical harmonics (Galerkin's method); about an axis of symmetry each order is solved by itself.

References
----------
Andersson, Mars and Simon, Adv. Theor. Math. Phys. 12 (2008) 853; Pook-Kolb, Birnholtz, Krishnan and
Schnetter, Phys. Rev. D 99 (2019) 064005, who compute spectra of axisymmetric surfaces.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, SupportsIndex

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eig, lu_factor, lu_solve, qr
from scipy.optimize import linear_sum_assignment

from isoembed.arrays import Floats, Indices
from isoembed.errors import InvalidParameter
from isoembed.meshing.sphere import gauss_rule
from isoembed.meshing.surface_mesh import checked_count
from isoembed.relativity.horizons.discretization import DEALIASING
from isoembed.relativity.horizons.expansion_operator import LinearizedExpansion, linearized
from isoembed.relativity.horizons.found_horizon import FoundHorizon
from isoembed.relativity.horizons.stability import SETTLED
from isoembed.relativity.spacetimes.harmonic_map import HarmonicMap
from isoembed.relativity.spacetimes.jet import SurfaceFamily
from isoembed.relativity.spacetimes.local_geometry import LocalGeometry
from isoembed.relativity.spacetimes.mapped_surface import MappedSurface
from isoembed.relativity.spacetimes.star_surface import StarSurface
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry
from isoembed.reprs import short_repr
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.scattered_fit import deviating
from isoembed.smooth.sphere_transform import SphereTransform
from isoembed.smooth.transforms import resized
from isoembed.surface.estimate import Estimate

Complexes = NDArray[np.complex128]
Matrix = NDArray[Any]

MOST = 200
"""Eigenvalues that can be asked for."""
DEGREES, SYMMETRIC_DEGREES = (12, 16, 24, 32, 48), (16, 24, 32, 48, 64, 96, 128, 192, 256)
"""Degrees of eigenfunctions, one after the other; beyond the last the matrices are too large."""
SMALL, UNCERTAIN = 0.5, 2.0
"""Change over the error that the data make at which to stop; allowance for an error that is one of many."""
MARGIN = 8
"""Eigenvalues beside twice those asked for in a subspace: it converges as the powers of their ratio."""
ITERATIONS = 60
PAIRED = 1e-9
"""Imaginary part, relative, of an eigenvalue that is one of a pair."""
COLUMNS = 128
"""Harmonics to which the operator is applied at a time, which bounds the memory."""


@short_repr
@dataclass(frozen=True, eq=False)
class StabilitySpectrum:
    """The first eigenvalues of the stability operator of a horizon, by increasing real part.

    Attributes
    ----------
    values : ndarray of complex, shape (n,)
        The eigenvalues times the squared areal radius, each as often as its multiplicity.  The first is real;
        it is ``FoundHorizon.stability``.
    errors : ndarray, shape (n,)
        Of the values: the change from a lower degree, and what the errors of the slice and of the surface
        make.
    orders : ndarray of int, shape (n,), or None
        Where slice and surface are symmetric about the z-axis, the orders m of the eigenfunctions, which are
        proportional to ``exp(i m phi)``; None elsewhere.
    areal_radius : float
        R, the root of the area over 4 pi: the eigenvalues are ``values / R**2``, in 1/length^2.
    """

    values: Complexes
    errors: Floats
    orders: Indices | None
    areal_radius: float

    @property
    def report(self) -> dict[str, Any]:
        """Plain numbers, for JSON: ``real`` and ``imaginary`` parts, ``errors``, ``orders``, ``R``."""
        return {
            "real": self.values.real.tolist(),
            "imaginary": self.values.imag.tolist(),
            "errors": self.errors.tolist(),
            "orders": None if self.orders is None else self.orders.tolist(),
            "areal_radius": self.areal_radius,
        }


def stability_spectrum(horizon: FoundHorizon, n: SupportsIndex = 10) -> StabilitySpectrum:
    """The first eigenvalues of the stability operator of a horizon, or of a surface of constant expansion.

    Parameters
    ----------
    horizon : FoundHorizon
        From `find_horizon`, `inner_horizon` or `constant_expansion`.
    n : int
        How many eigenvalues, at most 200; one more where the last is the first of a complex pair.

    Returns
    -------
    StabilitySpectrum

    Raises
    ------
    InvalidParameter
        The horizon is not a FoundHorizon, or n is not a number of eigenvalues.

    Notes
    -----
    The sign of the operator is that of ``L psi``, the change of the expansion by an outward displacement psi:
    on a Schwarzschild horizon ``-Laplacian + 1 / R^2`` at a moment of time symmetry.

    Examples
    --------
    >>> from isoembed.relativity import IsotropicSchwarzschild, find_horizon
    >>> spectrum = stability_spectrum(find_horizon(IsotropicSchwarzschild(1.0)), 4)
    >>> spectrum.values.real.round(9)  # 1 + l (l + 1)
    array([1., 3., 3., 3.])
    """
    if not isinstance(horizon, FoundHorizon):
        raise InvalidParameter(f"the horizon is a {type(horizon).__name__}, not a FoundHorizon")
    n = checked_eigenvalues(n)
    allowed: tuple[int, ...] = SYMMETRIC_DEGREES if _is_symmetric(horizon.surface) else DEGREES
    degrees = tuple(degree for degree in allowed if (degree - 1) ** 2 >= 2 * n + MARGIN)
    operator = _Operator.of(horizon, degrees[0], n)
    found = operator.spectrum(n)
    known = _by_data(operator, found, horizon)
    for degree in degrees[1:]:
        before, operator = found, _Operator.of(horizon, degree, n)
        found = operator.spectrum(n)
        change = found.apart(before)
        if np.all(change <= np.maximum(SETTLED * found.size, SMALL * known[: len(change)])):
            break
    errors = change + SETTLED * found.size + known[: len(change)]
    return StabilitySpectrum(found.values, errors, found.orders, operator.areal_radius)


def spectrum_lines(report: dict[str, Any]) -> Iterator[str]:
    """The lines of a text on the report of a spectrum."""
    R = report["areal_radius"]
    yield f"eigenvalues of the stability operator times R^2, R = {R:.10g}:"
    orders = report["orders"] or [None] * len(report["real"])
    rows = zip(report["real"], report["imaginary"], report["errors"], orders, strict=True)
    for real, imaginary, error, order in rows:
        value = Estimate(real, error).rounded
        if imaginary:
            value += f" {'+-'[imaginary < 0.0]} {Estimate(abs(imaginary), error).rounded} i"
        of_order = "" if order is None else f", m = {order}"
        yield f"  {value} {Estimate(real, error).plus_minus}{of_order}"


def checked_eigenvalues(n: SupportsIndex) -> int:
    """The number of eigenvalues that is asked for; `InvalidParameter` if it is not valid."""
    return checked_count("the number of eigenvalues", n, 1, MOST)


@dataclass(frozen=True, eq=False)
class _Found:
    """The first eigenvalues of an operator, n of them and some more, with the orders of eigenfunctions."""

    n: int
    candidates: Complexes
    their_orders: Indices | None

    @property
    def values(self) -> Complexes:
        """The n eigenvalues."""
        return self.candidates[: self.n]

    @property
    def orders(self) -> Indices | None:
        """Their orders."""
        return None if self.their_orders is None else self.their_orders[: self.n]

    @property
    def size(self) -> Floats:
        """Their sizes (n,), at least 1."""
        return np.maximum(np.abs(self.values), 1.0)

    def apart(self, other: _Found, more: int = 0) -> Floats:
        """Distances (n + more,) to eigenvalues of another operator, each to a different one."""
        distances = np.abs(self.candidates[: self.n + more, None] - other.candidates)
        return np.asarray(distances[linear_sum_assignment(distances)])


def _family(surface: StarSurface | MappedSurface, heights: int, around: int) -> SurfaceFamily:
    """Displacements of a surface at the nodes of a rule: along normals, or radial of a star-shaped one."""
    if isinstance(surface, MappedSurface):
        map = HarmonicMap(surface.harmonics, surface.coefficients)
        return SurfaceFamily(map.jet_at_nodes(heights), map.normals().jet_at_nodes(heights))
    transform, c = SphereTransform(surface.harmonics, heights, around), surface.coefficients[:, None]
    star = SurfaceFamily.star(surface.center, transform.u)
    radius = transform.values(c)[:, 0], transform.gradients(c)[..., 0], transform.hessians(c)[..., 0]
    return replace(star, base=star.at(*radius))


def _linearized(family: SurfaceFamily, geometry: ThreeGeometry) -> LinearizedExpansion:
    return linearized(family, LocalGeometry.of(geometry, family.base))


def _coefficients(family: SurfaceFamily, geometry: ThreeGeometry) -> Floats:
    """The functions (7, N) that make a `LinearizedExpansion`."""
    L = _linearized(family, geometry)
    return np.vstack([L.second.T, L.first.T, L.zeroth, L.tilt])


@dataclass(frozen=True, eq=False)
class _Operator:
    """The stability operator of a surface on harmonics of one degree.

    Attributes
    ----------
    transform : SphereTransform
        Of the eigenfunctions.
    weights : ndarray, shape (N,)
        Of the nodes: those of one meridian where there is symmetry.
    family : SurfaceFamily
        Displacements of the surface.
    linear : LinearizedExpansion
        At the nodes.
    symmetric : bool
    areal_radius : float
    below : float
        A number that no eigenvalue is near to or less than, times the squared areal radius.
    """

    transform: SphereTransform
    weights: Floats
    family: SurfaceFamily
    linear: LinearizedExpansion
    symmetric: bool
    areal_radius: float
    below: float

    @classmethod
    def of(cls, horizon: FoundHorizon, degree: int, n: int) -> _Operator:
        """The operator of a horizon, in harmonics that n eigenfunctions may need."""
        surface = horizon.surface
        symmetric = _is_symmetric(surface)
        heights = int(DEALIASING * max(degree, surface.harmonics.degree)) + 2
        around = 1 if symmetric else 2 * heights
        family = _family(surface, heights, around)
        local = LocalGeometry.of(horizon.geometry, family.base)
        weights = gauss_rule(heights, around)[1]
        R = float(np.sqrt(weights @ local.density / (4.0 * np.pi)))
        # Of n eigenvalues on a disk with two sides, which is the flattest surface, none has a higher order.
        order = min(degree, int(np.sqrt(2.0 * n)) + 4) if symmetric else degree
        transform = SphereTransform(Harmonics(degree, order), heights, max(around, 2 * order + 1))
        linear = linearized(family, local)
        return cls(transform, weights, family, linear, symmetric, R, horizon.stability - 1.0)

    def changed(self, change: Floats) -> _Operator:
        """The operator whose coefficients (7, N) differ by a change."""
        L = self.linear
        second, first = L.second + change[:3].T, L.first + change[3:5].T
        linear = LinearizedExpansion(second, first, L.zeroth + change[5], L.tilt + change[6])
        return replace(self, linear=linear)

    def spectrum(self, n: int) -> _Found:
        """The first n eigenvalues, one more rather than half of a complex pair."""
        if self.symmetric:
            values, orders = self._by_order(n)
        else:
            values = self._first(*self._matrices(), n)
            orders = np.zeros(len(values), dtype=np.int64)
        digits = 9  # beyond these multiple eigenvalues differ by rounding
        by = np.lexsort((-values.imag, np.abs(values.imag).round(digits), values.real.round(digits)))
        values, orders = values[by], orders[by]
        if values[n - 1].imag > PAIRED * abs(values[n - 1]):
            n += 1
        values.imag[np.abs(values.imag) <= PAIRED * np.abs(values)] = 0.0
        return _Found(n, values, orders if self.symmetric else None)

    def _by_order(self, n: int) -> tuple[Complexes, Indices]:
        """The first eigenvalues of each order that may have some of the first n, and the orders."""
        values, orders = np.empty(0, dtype=np.complex128), np.empty(0, dtype=np.int64)
        weights = self.weights * self.linear.scale
        for m in range(self.transform.harmonics.order + 1):
            values_there, slopes, hessians = self.transform.on_meridian(m)
            theta = self.linear.applied(values_there, slopes, hessians)
            A = values_there.T @ (weights[:, None] * theta)
            B = values_there.T @ ((weights * self.linear.tilt)[:, None] * values_there)
            own = self._first(A, B, n)
            if len(values) >= n and own.real.min() > np.sort(values.real)[n - 1]:
                break
            values = np.concatenate([values, own, own.conj()] if m else [own])
            orders = np.concatenate([orders, np.full(len(own), m), np.full(len(own) * (m > 0), -m)])
        return values, orders

    def _matrices(self) -> tuple[Floats, Floats]:
        """The projections (size, size) of the operator, and of how far harmonics move the surface outward."""
        T, size = self.transform, self.transform.harmonics.size
        weights = (self.weights * self.linear.scale)[:, None]
        A, B = np.empty((2, size, size))
        for begin in range(0, size, COLUMNS):
            part = slice(begin, begin + COLUMNS)
            c = np.eye(size)[:, part]
            values = T.values(c)
            theta = self.linear.applied(values, T.gradients(c), T.hessians(c))
            A[:, part] = T.adjoint_values(weights * theta)
            B[:, part] = T.adjoint_values(weights * self.linear.tilt[:, None] * values)
        return A, B

    def _first(self, A: Matrix, B: Matrix, n: int) -> Complexes:
        """The first eigenvalues of a matrix pencil times the squared areal radius, n of them and some more.

        By iteration of a subspace with the inverse of the shifted matrix, in which multiple eigenvalues are
        found like others.
        """
        A = A * self.areal_radius**2
        size = len(A)
        most = 2 * n + MARGIN
        if most >= size:
            return np.asarray(eig(A, B, right=False))
        factors = lu_factor(A - self.below * B)
        degrees = (
            self.transform.harmonics.labels[0] if size == self.transform.harmonics.size else np.arange(size)
        )
        X = np.eye(size)[:, np.argsort(degrees, kind="stable")[:most]]
        before = np.full(n, np.inf)
        for _ in range(ITERATIONS):
            X = qr(lu_solve(factors, B @ X), mode="economic")[0]
            values = eig(X.conj().T @ A @ X, X.conj().T @ B @ X, right=False)
            values = values[np.argsort(values.real, kind="stable")]
            if np.all(
                np.abs(values[:n].real - before) <= 0.1 * SETTLED * np.maximum(np.abs(values[:n]), 1.0)
            ):
                break
            before = values[:n].real
        return np.asarray(values)


def _by_data(operator: _Operator, found: _Found, horizon: FoundHorizon) -> Floats:
    """Errors of the first eigenvalues by those of the slice, of its differences and of the surface.

    They are of one eigenvalue more than was found.  In all degrees they are alike: a low one tells them.
    """
    n = found.n
    # Differences along displacements twice as long, of sixth order, have 64 times the error, or nearly so.
    longer = replace(operator.family, direction=operator.family.direction.scaled(2.0))
    coarser = _linearized(longer, horizon.geometry)
    by_differences = found.apart(replace(operator, linear=coarser).spectrum(n), 1) / 32.0
    uncertain = horizon.geometry.error(partial(_coefficients, operator.family))
    errors = UNCERTAIN * found.apart(operator.changed(uncertain).spectrum(n), 1)
    for moved in _deviating(horizon.surface):
        there = _Operator.of(replace(horizon, surface=moved), operator.transform.harmonics.degree, n)
        errors = np.hypot(errors, found.apart(there.spectrum(n), 1))
    return errors + by_differences


def _is_symmetric(surface: StarSurface | MappedSurface) -> bool:
    """Whether surface and slice are symmetric about the z-axis, where the surface was found in that slice."""
    return surface.harmonics.order <= 1


def _deviating(surface: StarSurface | MappedSurface) -> Iterator[StarSurface | MappedSurface]:
    """Surfaces that are displaced by what the surface may be off; see `StarSurface.deviations`."""
    for deviation in () if surface.deviations is None else surface.deviations:
        by = deviation.reshape(len(deviation), -1)
        change = resized(by, deviating(surface.harmonics), surface.harmonics)
        yield replace(surface, coefficients=surface.coefficients + change.reshape(surface.coefficients.shape))
