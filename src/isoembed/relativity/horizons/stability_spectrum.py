"""Spectrum of the stability operator of a marginally outer trapped surface: n eigenvalues, with errors.

The operator is in general not self-adjoint unless the slice is time-symmetric; complex eigenvalues come in
conjugate pairs.  The principal eigenvalue, that of least real part, is real.  Eigenfunctions are expanded in
spherical harmonics (Galerkin's method); with axial symmetry each order is solved separately.

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
from isoembed.relativity.horizons.principal_eigenvalue import SETTLED
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

MARGIN = 8
"""Dimension of the subspace beyond twice the number of eigenvalues, for convergence of subspace iteration."""
PAIRED = 1e-9
"""Least relative imaginary part of an eigenvalue of a complex pair."""


@short_repr
@dataclass(frozen=True, eq=False)
class StabilitySpectrum:
    """First eigenvalues of the stability operator of a horizon, in order of increasing real part.

    Attributes
    ----------
    values : ndarray of complex, shape (n,)
        Eigenvalues times the squared areal radius, repeated by multiplicity.  The first is real and equals
        ``FoundHorizon.stability``.
    errors : ndarray, shape (n,)
        Errors of the values, from the change between degrees and the errors of slice and surface.
    orders : ndarray of int, shape (n,), or None
        Orders m of the eigenfunctions, proportional to ``exp(i m phi)``, if slice and surface are symmetric
        about the z-axis; otherwise None.
    areal_radius : float
        Areal radius R: the eigenvalues are ``values / R**2``, in 1/length^2.
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
    """First eigenvalues of the stability operator of a horizon, or of a surface of constant expansion.

    Parameters
    ----------
    horizon : FoundHorizon
        Result of `find_horizon`, `inner_horizon` or `constant_expansion`.
    n : int
        Number of eigenvalues, at most 200; one more if the last is the first of a complex pair.

    Returns
    -------
    StabilitySpectrum

    Raises
    ------
    InvalidParameter
        The horizon is not a FoundHorizon, or n is not an integer from 1 to 200.

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
    # Degrees of eigenfunctions, in order of refinement, limited by the size of the matrices.
    symmetric = _is_symmetric(horizon.surface)
    allowed = (16, 24, 32, 48, 64, 96, 128, 192, 256) if symmetric else (12, 16, 24, 32, 48)
    degrees = tuple(degree for degree in allowed if (degree - 1) ** 2 >= 2 * n + MARGIN)
    operator = _Operator.of(horizon, degrees[0], n)
    found = operator.spectrum(n)
    data_errors = _by_data(operator, found, horizon)
    for degree in degrees[1:]:
        before, operator = found, _Operator.of(horizon, degree, n)
        found = operator.spectrum(n)
        change = found.apart(before)
        if np.all(change <= np.maximum(SETTLED * found.size, 0.5 * data_errors[: len(change)])):
            break
    errors = change + SETTLED * found.size + data_errors[: len(change)]
    return StabilitySpectrum(found.values, errors, found.orders, operator.areal_radius)


def spectrum_lines(report: dict[str, Any]) -> Iterator[str]:
    """Lines of text for the report of a spectrum."""
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
    """Checked number of eigenvalues.  Raises `InvalidParameter`: it is out of range."""
    return checked_count("the number of eigenvalues", n, 1, 200)


@dataclass(frozen=True, eq=False)
class _Found:
    """First n eigenvalues of an operator and some more, with the orders of the eigenfunctions."""

    n: int
    candidates: Complexes
    their_orders: Indices | None

    @property
    def values(self) -> Complexes:
        """First n eigenvalues."""
        return self.candidates[: self.n]

    @property
    def orders(self) -> Indices | None:
        """Orders of the first n eigenvalues."""
        return None if self.their_orders is None else self.their_orders[: self.n]

    @property
    def size(self) -> Floats:
        """Absolute values (n,) of the eigenvalues, at least 1."""
        return np.maximum(np.abs(self.values), 1.0)

    def apart(self, other: _Found, more: int = 0) -> Floats:
        """Distances (n + more,) to the eigenvalues of another operator, in the optimal assignment."""
        distances = np.abs(self.candidates[: self.n + more, None] - other.candidates)
        return np.asarray(distances[linear_sum_assignment(distances)])


def _family(surface: StarSurface | MappedSurface, heights: int, around: int) -> SurfaceFamily:
    """Displacements of a surface at the nodes of a rule: radial if star-shaped, otherwise along normals."""
    if isinstance(surface, MappedSurface):
        map = HarmonicMap(surface.harmonics, surface.coefficients)
        return SurfaceFamily(map.jet_at_nodes(heights), map.normals().jet_at_nodes(heights))
    transform = SphereTransform(surface.harmonics, heights, around)
    star = SurfaceFamily.star(surface.center, transform.u)
    return replace(star, base=star.at_nodes(transform, surface.coefficients))


def _linearized(family: SurfaceFamily, geometry: ThreeGeometry) -> LinearizedExpansion:
    return linearized(family, LocalGeometry.of(geometry, family.base))


def _coefficients(family: SurfaceFamily, geometry: ThreeGeometry) -> Floats:
    """Coefficient functions (7, N) of a `LinearizedExpansion`."""
    L = _linearized(family, geometry)
    return np.vstack([L.second.T, L.first.T, L.zeroth, L.tilt])


@dataclass(frozen=True, eq=False)
class _Operator:
    """Stability operator of a surface in harmonics of a fixed degree.

    Attributes
    ----------
    transform : SphereTransform
        Transform of the eigenfunctions.
    weights : ndarray, shape (N,)
        Weights of the nodes, which are on one meridian if there is axial symmetry.
    family : SurfaceFamily
        Displacements of the surface.
    linear : LinearizedExpansion
        Linearized expansion at the nodes.
    symmetric : bool
    areal_radius : float
    below : float
        Shift below the real parts of all eigenvalues, times the squared areal radius.
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
        """Operator of a horizon, in harmonics sufficient for n eigenfunctions."""
        surface = horizon.surface
        symmetric = _is_symmetric(surface)
        heights = int(DEALIASING * max(degree, surface.harmonics.degree)) + 2
        around = 1 if symmetric else 2 * heights
        family = _family(surface, heights, around)
        local = LocalGeometry.of(horizon.geometry, family.base)
        weights = gauss_rule(heights, around)[1]
        R = float(np.sqrt(weights @ local.density / (4.0 * np.pi)))
        # No higher order among n eigenvalues on a two-sided disk, the flattest surface.
        order = min(degree, int(np.sqrt(2.0 * n)) + 4) if symmetric else degree
        transform = SphereTransform(Harmonics(degree, order), heights, max(around, 2 * order + 1))
        linear = linearized(family, local)
        return cls(transform, weights, family, linear, symmetric, R, horizon.stability - 1.0)

    def changed(self, change: Floats) -> _Operator:
        """Operator with a change (7, N) of its coefficient functions."""
        L = self.linear
        second, first = L.second + change[:3].T, L.first + change[3:5].T
        linear = LinearizedExpansion(second, first, L.zeroth + change[5], L.tilt + change[6])
        return replace(self, linear=linear)

    def spectrum(self, n: int) -> _Found:
        """First n eigenvalues, one more if that completes a complex pair."""
        if self.symmetric:
            values, orders = self._by_order(n)
        else:
            values = self._first(*self._matrices(), n)
            orders = np.zeros(len(values), dtype=np.int64)
        digits = 9  # multiple eigenvalues agree to these digits
        by = np.lexsort((-values.imag, np.abs(values.imag).round(digits), values.real.round(digits)))
        values, orders = values[by], orders[by]
        if values[n - 1].imag > PAIRED * abs(values[n - 1]):
            n += 1
        values.imag[np.abs(values.imag) <= PAIRED * np.abs(values)] = 0.0
        return _Found(n, values, orders if self.symmetric else None)

    def _by_order(self, n: int) -> tuple[Complexes, Indices]:
        """First eigenvalues of each order that may contribute to the first n, and their orders."""
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
        """Projections (size, size) of the operator and of the normal displacement."""
        T, size = self.transform, self.transform.harmonics.size
        weights = (self.weights * self.linear.scale)[:, None]
        A, B = np.empty((2, size, size))
        columns = 128  # harmonics per application of the operator, which bounds the memory
        for begin in range(0, size, columns):
            part = slice(begin, begin + columns)
            c = np.eye(size)[:, part]
            values = T.values(c)
            theta = self.linear.applied(values, T.gradients(c), T.hessians(c))
            A[:, part] = T.adjoint_values(weights * theta)
            B[:, part] = T.adjoint_values(weights * self.linear.tilt[:, None] * values)
        return A, B

    def _first(self, A: Matrix, B: Matrix, n: int) -> Complexes:
        """First n eigenvalues of a matrix pencil times the squared areal radius, and some more.

        Subspace iteration with the inverse of the shifted matrix, which handles multiple eigenvalues.
        """
        A = A * self.areal_radius**2
        size = len(A)
        count = 2 * n + MARGIN
        if count >= size:
            return np.asarray(eig(A, B, right=False))
        factors = lu_factor(A - self.below * B)
        degrees = (
            self.transform.harmonics.labels[0] if size == self.transform.harmonics.size else np.arange(size)
        )
        X = np.eye(size)[:, np.argsort(degrees, kind="stable")[:count]]
        before = np.full(n, np.inf)
        for _ in range(60):
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
    """Errors of n + 1 eigenvalues from the errors of the slice, of its finite differences and of the surface.

    They hardly depend on the degree, so that a low degree suffices.
    """
    n = found.n
    # Sixth-order differences with twice the step have about 64 times the error.
    longer = replace(operator.family, direction=operator.family.direction.scaled(2.0))
    coarser = _linearized(longer, horizon.geometry)
    by_differences = found.apart(replace(operator, linear=coarser).spectrum(n), 1) / 32.0
    uncertain = horizon.geometry.error(partial(_coefficients, operator.family))
    errors = 2.0 * found.apart(operator.changed(uncertain).spectrum(n), 1)
    for moved in _deviating(horizon.surface):
        there = _Operator.of(replace(horizon, surface=moved), operator.transform.harmonics.degree, n)
        errors = np.hypot(errors, found.apart(there.spectrum(n), 1))
    return errors + by_differences


def _is_symmetric(surface: StarSurface | MappedSurface) -> bool:
    """Whether surface and slice are symmetric about the z-axis, for a surface found in that slice."""
    return surface.harmonics.order <= 1


def _deviating(surface: StarSurface | MappedSurface) -> Iterator[StarSurface | MappedSurface]:
    """Surfaces displaced by the estimated errors of a surface; see `StarSurface.deviations`."""
    for deviation in () if surface.deviations is None else surface.deviations:
        by = deviation.reshape(len(deviation), -1)
        change = resized(by, deviating(surface.harmonics), surface.harmonics)
        yield replace(surface, coefficients=surface.coefficients + change.reshape(surface.coefficients.shape))
