"""Standard deviations of a surface's quantities from errors of its lengths.

Independent errors of the lengths, of standard deviations s, move every quantity f of the surface by
``df/dl . dl`` to first order: its standard deviation is ``|s df/dl|``.  Lengths whose errors are the same
count as one: the sum of their s df/dl.

A surface that is fitted to lengths with errors misses some of them, and smoothness takes its quantities from
those of the lengths by ``df/dl . r``, r the lengths missed: that is added, as one more error.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Protocol, cast

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.mesh.triangulation import Triangulation
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.metric.variation import area_derivative
from isoembed.reprs import short_repr
from isoembed.surface.changes import INTEGRALS, Changes
from isoembed.surface.curvature import dihedral_angles, vertex_mean_curvature
from isoembed.surface.derivatives import (
    LengthDerivatives,
    Variation,
    dihedral_rates,
    integral_gradients,
    normal_rates,
    volume_gradient,
)
from isoembed.surface.measures import above_boundary, cone_sum, edge_lengths
from isoembed.surface.vertex_areas import vertex_area_rates, vertex_areas

NONLINEAR = 0.1
"""Nonlinearity of the volume above which it is not determined to first order.  In trials it was below .04, or
above .14 and the deviations wrong by factors of 2 to 30."""

PROBES = 400  # random errors with which the deviations at vertices, faces and edges are estimated


class Derivatives(Protocol):
    """Derivatives of the vertices of a surface by its lengths."""

    def jvp(self, changes: Floats) -> Floats:
        """Derivative of the vertices, (V, 3), along a change of the lengths, (E,)."""
        ...

    def vjp(self, gradient: Floats) -> Floats:
        """The transpose of `jvp`: (..., E) from (..., V, 3)."""
        ...


@short_repr
@dataclass(frozen=True, eq=False)
class IntegralDeviation:
    """Standard deviations of what is integrated over a surface whose lengths have independent errors.

    In hyperbolic and spherical space, too.

    Attributes
    ----------
    area, volume, integrated_mean_curvature : float
        To first order.  The volume's is infinite where the surface is not infinitesimally rigid, and NaN of
        surfaces with boundary, unless this is in a horizontal plane.
    correlation : ndarray, shape (3, 3)
        Of the errors of the three; NaN beside one that has no error, or an infinite one.
    volume_nonlinearity : float
        Second-order term of the volume over the first-order term, where the errors change it most: large
        where the surface nearly flexes within the errors.  NaN in hyperbolic and spherical space.
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
        """Deviation by errors of the lengths, as in `Deviation.of`; derivatives are None if J is singular."""
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
        derivatives: Derivatives,
        triangulation: Triangulation,
        vertices: Floats,
        errors: Floats,
        shared: Indices,
        missed: Floats,
    ) -> IntegralDeviation:
        """Deviation of a surface in R^3 with boundary or handles, whose lengths need not be those given."""
        above = above_boundary(triangulation, vertices)
        x = vertices if above is None else above
        rates = derivatives.vjp(integral_gradients(triangulation, x))
        if above is not None:  # the volume is positive, whatever the side
            rates[1] *= np.sign(cone_sum(triangulation.faces, above))
        elif not triangulation.is_closed:
            rates[1] = np.nan
        return cls.from_rates(rates, errors, shared, missed, np.nan)

    @classmethod
    def from_rates(
        cls, rates: Floats, errors: Floats, shared: Indices, missed: Floats, nonlinearity: float
    ) -> IntegralDeviation:
        """Deviation from the derivatives of the three integrals by the lengths, (3, E)."""
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
        """Deviation in another unit: every length, and error of a length, times this factor."""
        return IntegralDeviation(
            unit * (unit * self.area),
            unit * (unit * (unit * self.volume)),
            unit * self.integrated_mean_curvature,
            self.correlation,
            self.volume_nonlinearity,
        )

    @property
    def report(self) -> dict[str, float]:
        """The three standard deviations, infinite if not determined, and the nonlinearity of the volume."""
        integrals = {name: getattr(self, name) for name in INTEGRALS}
        volume = self.volume if self.volume_is_determined else np.inf
        return {**integrals, "volume": volume, "volume_nonlinearity": self.volume_nonlinearity}

    @property
    def volume_is_determined(self) -> bool:
        """Whether the standard deviation of the volume is valid: its nonlinearity is at most a tenth."""
        return not self.volume_nonlinearity > NONLINEAR


@short_repr
@dataclass(frozen=True, eq=False)
class Deviation(Changes):
    """Standard deviations of a surface in R^3 whose lengths have independent errors, to first order.

    Attributes
    ----------
    vertices : ndarray, shape (V,)
        Root mean square of how far each vertex moves, after the best rigid motion of all.
    normals : ndarray, shape (F,)
        Root mean square of the radians by which each triangle turns its normal.
    dihedral_angles : ndarray, shape (E,)
    mean_curvature : ndarray, shape (V,)
    area, volume, integrated_mean_curvature : float
    correlation : ndarray, shape (3, 3)
        Of the errors of area, volume and integrated mean curvature; NaN beside one that has no error.
    volume_nonlinearity : float
        As of `IntegralDeviation`: above a tenth, neither the volume's deviation nor the arrays are valid.
    probes : int
        How many random errors the four arrays are estimated with; 0 if they are exact.
    """

    correlation: Floats
    volume_nonlinearity: float
    probes: int

    @property
    def relative_error(self) -> float:
        """Relative standard deviation of the estimate of each entry of the arrays.

        It is that of the worst case, in which many edges contribute alike.
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
    ) -> Deviation:
        """Estimate from the standard deviations of the lengths, (E,), and labels of `shared_errors`, (E,).

        `missed` are the lengths less those on the surface, (E,), if it is a fit, or zeros.

        Area, volume and integrated mean curvature take one solve together.  For the rest, signs are drawn at
        random for the errors, and the squares of what each draw does are averaged; where the draws are more
        than the errors, each is taken once instead, and the result is exact.
        """
        t = metric.triangulation
        if t.is_sphere:
            closed = cast(LengthDerivatives, derivatives)
            integrals = IntegralDeviation.of(metric, vertices, errors, shared, missed, closed)
        else:
            integrals = IntegralDeviation.of_sheet(derivatives, t, vertices, errors, shared, missed)
        n = int(shared.max()) + 1
        exact = n <= PROBES
        sums = [np.zeros(n) for n in (len(vertices), t.n_faces, t.n_edges, len(vertices))]
        for draw in _units(n) if exact else _signs(n):
            moved = derivatives.jvp(errors * draw[shared])
            for total, square in zip(sums, _squares(t, vertices, moved), strict=True):
                total += square
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
        """Area, volume and int H dA; of the arrays root mean square and largest, and `relative_error`."""
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


def _signs(n: int) -> Iterator[Floats]:
    rng = np.random.default_rng(0)
    for _ in range(PROBES):
        yield rng.choice([-1.0, 1.0], n)


def _squares(t: Triangulation, x: Floats, v: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Squares of what velocities v do to vertices, normals, dihedral angles and H."""
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
    return np.einsum("vi,vi->v", v, v), turned**2, bent**2, curved**2
