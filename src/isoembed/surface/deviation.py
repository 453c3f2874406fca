"""Standard deviations of a surface's quantities due to errors of its lengths.

Independent errors of the lengths with standard deviations s change every quantity f of the surface by
``df/dl . dl`` to first order: its standard deviation is ``|s df/dl|``.  Lengths with a common error
contribute a single term, the sum of their s df/dl.

A surface fitted to lengths with errors does not realize them exactly: smoothing changes its quantities by
``df/dl . r``, where r are the length residuals.  This bias is added as one more error.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Protocol, cast

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.linalg import SingularMatrix
from isoembed.mesh.triangulation import Triangulation
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.metric.variation import area_derivative
from isoembed.reprs import short_repr
from isoembed.surface.changes import INTEGRALS, Changes
from isoembed.surface.curvature import bend_rates, dihedral_angles, vertex_mean_curvature
from isoembed.surface.derivatives import (
    LengthDerivatives,
    Variation,
    dihedral_rates,
    integral_gradients,
    normal_rates,
    volume_gradient,
)
from isoembed.surface.flat_faces import coplanar_faces
from isoembed.surface.measures import above_boundary, cone_sum, edge_lengths
from isoembed.surface.vertex_areas import vertex_area_rates, vertex_areas

NONLINEAR = 0.1
"""Nonlinearity of the volume above which first-order error propagation is invalid.  In trials it was either
below .04, or above .14 with deviations wrong by factors of 2 to 30."""

BEND_PROBES = 16  # enough for the largest deviation to a fifth
BEND_DEVIATIONS = 5.0
"""Standard deviations within which a bend is none.  With 3, a few of 123 solids from rounded lengths lost
faces."""

SIZES = 0.8 ** np.arange(21)  # of vertex errors that are tried, the largest first, over the largest
PROBES = 400  # random error vectors for estimating the deviations at vertices, faces and edges


class Derivatives(Protocol):
    """Derivatives of the vertices of a surface with respect to its lengths."""

    def jvp(self, changes: Floats) -> Floats:
        """Derivative of the vertices, (V, 3), along a change of the lengths, (E,)."""
        ...

    def vjp(self, gradient: Floats) -> Floats:
        """Transpose of `jvp`: (..., E) from (..., V, 3)."""
        ...


class CurvatureRates(Protocol):
    """Derivatives of a mean curvature that is not that of the dihedral angles."""

    def rates(self, velocity: Floats) -> Floats:
        """Derivative, (V,), for velocities of the vertices, (V, 3)."""
        ...

    def integral_gradient(self) -> Floats:
        """Gradient of the integral with respect to the vertices, (V, 3)."""
        ...


@short_repr
@dataclass(frozen=True, eq=False)
class IntegralDeviation:
    """Standard deviations of the integrals over a surface whose lengths have independent errors.

    Also in hyperbolic and spherical space.

    Attributes
    ----------
    area, volume, integrated_mean_curvature : float
        First-order standard deviations.  That of the volume is infinite if the surface is not infinitesimally
        rigid, and NaN for surfaces with boundary, unless the boundary is in a horizontal plane.
    correlation : ndarray, shape (3, 3)
        Correlation matrix of the three errors; NaN for those with zero or infinite deviation.
    volume_nonlinearity : float
        Ratio of the second-order to the first-order term of the volume, along the errors that change it most:
        large if the surface nearly flexes within the errors.  NaN in hyperbolic and spherical space.
    """

    area: float
    volume: float
    integrated_mean_curvature: float
    correlation: Floats
    volume_nonlinearity: float

    @classmethod
    def of(
        cls,
        metric: PolyhedralMetric,
        vertices: Floats,
        errors: Floats,
        shared: Indices,
        missed: Floats,
        derivatives: LengthDerivatives | None,
    ) -> IntegralDeviation:
        """Deviation due to length errors, as in `Deviation.of`; `derivatives` is None if J is singular."""
        space, t = metric.space, metric.triangulation
        volume_rates, nonlinearity = np.full(len(errors), np.inf), np.inf
        if derivatives is not None:
            volume_rates = derivatives.vjp(volume_gradient(t, vertices, space))
            nonlinearity = np.nan
        if derivatives is not None and space.is_euclidean:
            largest = errors * np.bincount(shared, errors * volume_rates)[shared]
            if largest.any():
                steepest = largest / np.sqrt(volume_rates @ largest)
                first, second = Variation.of(derivatives, t, vertices, metric.lengths, steepest).volume
                nonlinearity = abs(second / 2 / first)
        # Schlaefli: sum l dtheta = -2 k dV
        integral_rates = dihedral_angles(t, vertices, space) / 2
        if not space.is_euclidean:
            integral_rates = integral_rates - space.curvature * volume_rates
        rates = np.array([area_derivative(metric), volume_rates, integral_rates])
        return cls.from_rates(rates, errors, shared, missed, nonlinearity)

    @classmethod
    def of_sheet(
        cls,
        derivatives: Derivatives | None,
        metric: PolyhedralMetric,
        vertices: Floats,
        errors: Floats,
        shared: Indices,
        missed: Floats,
        curvature: CurvatureRates | None = None,
    ) -> IntegralDeviation:
        """Deviation of a surface in R^3 with boundary or handles, possibly a fit to the given lengths.

        `derivatives` is None if the surface is not rigid.  With a boundary the mean curvature is that of
        `curvature`; without one its deviation is NaN.
        """
        triangulation = metric.triangulation
        if derivatives is None:
            unknown = np.full((2, len(errors)), np.inf)
            rates = np.vstack([area_derivative(metric), unknown])
            return cls.from_rates(rates, errors, shared, missed, np.inf)
        above = above_boundary(triangulation, vertices)
        x = vertices if above is None else above
        gradients = integral_gradients(triangulation, x)
        if not triangulation.is_closed:
            gradients[2] = 0.0 if curvature is None else curvature.integral_gradient()
        rates = derivatives.vjp(gradients)
        if curvature is None and not triangulation.is_closed:
            rates[2] = np.nan
        if above is not None:  # the volume is positive, whatever the side
            rates[1] *= np.sign(cone_sum(triangulation.faces, above))
        elif not triangulation.is_closed:
            rates[1] = np.nan
        return cls.from_rates(rates, errors, shared, missed, np.nan)

    @classmethod
    def from_rates(
        cls, rates: Floats, errors: Floats, shared: Indices, missed: Floats, nonlinearity: float
    ) -> IntegralDeviation:
        """Deviation from the derivatives of the three integrals with respect to the lengths, (3, E)."""
        with np.errstate(invalid="ignore"):
            each = np.where(errors > 0, errors * rates, 0.0)
            smoothed = np.where(missed != 0, missed * rates, 0.0).sum(axis=1)
            scaled = np.array(
                [[*np.bincount(shared, row), one] for row, one in zip(each, smoothed, strict=True)]
            )
            covariance = scaled @ scaled.T
            sigma = np.sqrt(np.diag(covariance))
            correlation = covariance / sigma / sigma[:, None]
        by_area, by_volume, by_integral = map(float, sigma)
        return cls(by_area, by_volume, by_integral, correlation, float(nonlinearity))

    def scaled(self, unit: float) -> IntegralDeviation:
        """Deviation in another unit, in which every length and length error is scaled by this factor."""
        return IntegralDeviation(
            unit * (unit * self.area),
            unit * (unit * (unit * self.volume)),
            unit * self.integrated_mean_curvature,
            self.correlation,
            self.volume_nonlinearity,
        )

    @property
    def report(self) -> dict[str, float]:
        """The three standard deviations, infinite if undetermined, and the nonlinearity of the volume."""
        integrals = {name: getattr(self, name) for name in INTEGRALS}
        volume = self.volume if self.volume_is_determined else np.inf
        return {**integrals, "volume": volume, "volume_nonlinearity": self.volume_nonlinearity}

    @property
    def volume_is_determined(self) -> bool:
        """Whether the standard deviation of the volume is valid: nonlinearity of at most a tenth."""
        return not self.volume_nonlinearity > NONLINEAR


@short_repr
@dataclass(frozen=True, eq=False)
class Deviation(Changes):
    """Standard deviations of a surface in R^3 whose lengths have independent errors, to first order.

    Attributes
    ----------
    vertices : ndarray, shape (V,)
        Root mean square displacements, after the best rigid motion of all vertices.
    normals : ndarray, shape (F,)
        Root mean square rotation angles of the triangles' normals, in radians.
    dihedral_angles : ndarray, shape (E,)
    mean_curvature : ndarray, shape (V,)
    area, volume, integrated_mean_curvature : float
    correlation : ndarray, shape (3, 3)
        Correlation matrix of the errors of area, volume and integrated mean curvature; NaN for those without
        error.
    volume_nonlinearity : float
        As of `IntegralDeviation`: above a tenth, neither the volume's deviation nor the arrays are valid.
    probes : int
        Number of random error vectors used to estimate the four arrays; 0 if they are exact.
    """

    correlation: Floats
    volume_nonlinearity: float
    probes: int

    @property
    def relative_error(self) -> float:
        """Relative standard deviation of the estimate of each entry of the arrays.

        This is the worst case, in which many edges contribute equally.
        """
        return float(1 / np.sqrt(2 * self.probes)) if self.probes else 0.0

    @classmethod
    def of(
        cls,
        derivatives: Derivatives,
        metric: PolyhedralMetric,
        vertices: Floats,
        errors: Floats,
        shared: Indices,
        missed: Floats,
        curvature: CurvatureRates | None = None,
    ) -> Deviation:
        """Estimate from the standard deviations of the lengths, (E,), and labels of `shared_errors`, (E,).

        `missed` are the given lengths minus those of the surface, (E,), if it is a fit, else zeros.  If
        `curvature` is None, the mean curvature is that of the dihedral angles.

        Area, volume and integrated mean curvature need a single solve.  The arrays are estimated by averaging
        the squared responses to errors with random signs; if there are no more errors than probes, each error
        is applied once instead, and the result is exact.
        """
        t = metric.triangulation
        if t.is_sphere:
            closed = cast(LengthDerivatives, derivatives)
            integrals = IntegralDeviation.of(metric, vertices, errors, shared, missed, closed)
        else:
            integrals = IntegralDeviation.of_sheet(
                derivatives, metric, vertices, errors, shared, missed, curvature
            )
        n = int(shared.max()) + 1
        exact = n <= PROBES
        sums = [np.zeros(n) for n in (len(vertices), t.n_faces, t.n_edges, len(vertices))]
        for draw in _units(n) if exact else _signs(n, PROBES):
            moved = derivatives.jvp(errors * draw[shared])
            *rates, curved = _rates(t, vertices, moved)
            if curvature is not None:
                curved = curvature.rates(moved)
            for total, rate in zip(sums, (*rates, curved), strict=True):
                total += rate**2
        probes = 0 if exact else PROBES
        at_vertices, at_faces, at_edges, of_curvature = (np.sqrt(total / max(probes, 1)) for total in sums)
        return cls(
            vertices=at_vertices,
            normals=at_faces,
            dihedral_angles=at_edges,
            mean_curvature=of_curvature,
            **{name: getattr(integrals, name) for name in INTEGRALS},
            volume_nonlinearity=integrals.volume_nonlinearity,
            correlation=integrals.correlation,
            probes=probes,
        )

    @property
    def report(self) -> dict[str, Any]:
        """Area, volume and int H dA; root mean square and maximum of each array, and `relative_error`."""
        return {
            **super().report,
            "volume_nonlinearity": self.volume_nonlinearity,
            "relative_error": self.relative_error,
        }


def _units(n: int) -> Iterator[Floats]:
    for e in range(n):
        one = np.zeros(n)
        one[e] = 1.0
        yield one


def _signs(n: int, count: int) -> Iterator[Floats]:
    rng = np.random.default_rng(0)
    for _ in range(count):
        yield rng.choice([-1.0, 1.0], n)


def _rates(t: Triangulation, x: Floats, v: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Rates of the vertices, normals, dihedral angles and their H for vertex velocities v."""
    N, rates = normal_rates(t, x, v)
    size = np.linalg.norm(N, axis=1)
    n = N / size[:, None]
    along = np.einsum("fi,fi->f", n, rates)  # twice the rate of the area
    turned = np.linalg.norm(rates - along[:, None] * n, axis=1) / size
    bent = dihedral_rates(t, x, v)
    (a, b), lengths = t.edges.T, edge_lengths(t.edges, x)
    grown = np.einsum("ei,ei->e", x[a] - x[b], v[a] - v[b]) / lengths
    quarters = np.repeat((grown * dihedral_angles(t, x) + lengths * bent) / 4, 2)
    integrals = np.bincount(t.edges.ravel(), quarters)
    areas, shares = vertex_areas(t, x), vertex_area_rates(t, x, along / 2, 2 * lengths * grown)
    curved = (integrals - vertex_mean_curvature(t, x, areas) * shares) / areas
    return np.linalg.norm(v, axis=1), turned, bent, curved


def vertex_error(metric: PolyhedralMetric, vertices: Floats, error: float) -> float:
    """Error of each vertex in R^3 that accounts for the bends due to errors of the lengths.

    The errors are independent, or common to equal lengths, as rounding errors are.  Displacements of this
    size may flatten edges (see `bend_rates`), but none whose dihedral angle exceeds five standard deviations
    of the larger of both.  Of all such sizes below the `largest_vertex_error` it is that of the fewest
    `coplanar_faces`: smaller ones leave bends due to errors, larger ones join faces that then are curved.

    Parameters
    ----------
    metric : PolyhedralMetric
    vertices : ndarray, shape (V, 3)
    error : float
        Standard deviation of each length.
    """
    t = metric.triangulation
    upper_bound = largest_vertex_error(metric, error)
    try:
        derivatives = LengthDerivatives.of(t, vertices, metric.lengths)
    except SingularMatrix:
        return upper_bound
    order = np.argsort(metric.lengths, kind="stable")
    shared = np.empty(t.n_edges, dtype=np.int64)  # the same for equal lengths
    shared[order] = np.cumsum(np.diff(metric.lengths[order], prepend=-np.inf) > 1e-3 * error) - 1
    each = np.arange(t.n_edges)
    labels = [each, shared] if shared.max() < each[-1] else [each]
    squares = np.zeros((len(labels), t.n_edges))
    for draw in _signs(t.n_edges, BEND_PROBES):
        for square, label in zip(squares, labels, strict=True):
            square += dihedral_rates(t, vertices, derivatives.jvp(error * draw[label])) ** 2
    rates, angles = bend_rates(t, vertices, error), np.abs(dihedral_angles(t, vertices))
    largest = BEND_DEVIATIONS * np.sqrt(squares.max(axis=0) / BEND_PROBES)
    flat = angles <= largest
    needed = (largest / rates)[flat].max() if flat.any() else upper_bound
    limit = min(needed, upper_bound, 0.999 * (angles / rates)[~flat].min(initial=np.inf))
    sizes = limit * SIZES
    return float(sizes[np.argmin([coplanar_faces(t, vertices, error=size).max() for size in sizes])])


def largest_vertex_error(metric: PolyhedralMetric, error: float) -> float:
    """Displacement of a nearly flat vertex by errors of the lengths, which grows with their square root."""
    return float(np.sqrt(error * metric.mean_length))
