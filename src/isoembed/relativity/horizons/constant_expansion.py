"""Surface of constant expansion with a given mean radius, a leaf of a foliation."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from isoembed.arrays import Floats
from isoembed.relativity.horizons.newton import Solution, solve
from isoembed.relativity.horizons.radial_image import discretized, in_degree
from isoembed.relativity.spacetimes.star_surface import StarSurface
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry

DEGREE_GROWTH = 1.5
TRUNCATION = 1e-4
"""Largest coefficient of high degree, in mean radii, above which the degree is raised."""
PRECISE_RESIDUAL = 1e-12  # of leaves near a minimum or a horizon, in mean radii


@dataclass(frozen=True, eq=False)
class ConstantExpansionSurface:
    """A surface of constant expansion.

    Attributes
    ----------
    surface : StarSurface
    expansion : float
        Constant part c of the expansion.
    lower, upper : float
        Bounds on the expansion: its extremes at the nodes, minus and plus the error of the slice.
    error : float
        Error of c from the error of the slice, at constant mean radius.
    areal_radius : float
    rate : float
        Derivative of the expansion with respect to the coefficient of degree zero.
    tangent : ndarray
        Derivatives of all coefficients with respect to that of degree zero.
    speed : float
        Largest displacement of a point relative to that of the mean radius.
    noise : float
        See `isoembed.relativity.horizons.newton.Solution`.
    """

    surface: StarSurface
    expansion: float
    lower: float
    upper: float
    error: float
    areal_radius: float
    rate: float
    tangent: Floats
    speed: float
    noise: float

    @property
    def normalized_expansion(self) -> float:
        """``c R / 2``: 1 on a sphere in flat space, 0 on a horizon."""
        return 0.5 * self.expansion * self.areal_radius

    def displaced(self, distance: float) -> StarSurface:
        """Predicted leaf with a largest outward displacement of a given number of mean radii."""
        return self.of_mean(self.surface.coefficients[0] * (1.0 + distance / self.speed))

    def of_mean(self, mean: float) -> StarSurface:
        """Predicted leaf with a given coefficient of degree zero."""
        f = self.surface.coefficients
        return StarSurface(self.surface.center, self.surface.harmonics, f + (mean - f[0]) * self.tangent)


def constant_expansion_surface(
    geometry: ThreeGeometry, guess: StarSurface, *, enough: float = 1e-6
) -> ConstantExpansionSurface:
    """Find the surface of constant expansion with the mean radius of an initial guess.

    Raises `NoConvergence`, `InvalidMetric` or `InvalidParameter`: see
    `isoembed.relativity.horizons.newton.solve`.

    Parameters
    ----------
    geometry : ThreeGeometry
    guess : StarSurface
        Initial guess, without harmonics of nonzero order if slice and surface are symmetric about the z-axis.
    enough : float
        Residual at which to stop, as a displacement relative to the radius; the default is for intermediate
        leaves.
    """
    highest = highest_degree(guess)
    while True:
        discretization = discretized(geometry, guess)
        solution = solve(discretization, guess.coefficients, None, enough)
        at, harmonics = solution.iterate, guess.harmonics
        f, theta = at.f, at.local.expansion
        errors, R = np.abs(discretization.expansion_errors(at)), discretization.areal_radius(at)
        high = harmonics.labels[0] > 0.75 * harmonics.degree
        tail = np.abs(f[high]).max() / f[0]
        spread = 0.5 * R * float(np.ptp(theta))
        smooth = tail <= max(TRUNCATION, solution.noise)
        fall = 0.5 * R * abs(solution.expansion)
        allowed = max(1e-5, R * float(errors.max()))  # near a horizon the sign varies over the surface
        # A variation of more than 2 % requires a higher degree.
        constant = spread <= max(min(0.02, 0.5 * fall), allowed)
        surface = StarSurface(guess.center, harmonics, f)
        resolved = harmonics.degree * clearance(geometry, surface) >= surface.mean_radius
        if (smooth and constant and resolved) or harmonics.degree >= highest:
            break
        degree = min(highest, int(DEGREE_GROWTH * harmonics.degree))
        guess = in_degree(surface, degree)
    rate, tangent = _tangent(solution)
    by_slice = solution.equations.projected(errors)
    return ConstantExpansionSurface(
        surface=surface,
        expansion=solution.expansion,
        lower=float((theta - errors).min()),
        upper=float((theta + errors).max()),
        error=abs(float(solution.equations.solved(by_slice)[0])),
        areal_radius=R,
        rate=rate,
        tangent=tangent,
        speed=float(np.abs(discretization.transform.values(tangent[:, None])).max()) * np.sqrt(4.0 * np.pi),
        noise=solution.noise,
    )


def highest_degree(surface: StarSurface) -> int:
    """Largest degree of leaves with the symmetry of a surface."""
    return 512 if surface.harmonics.order == 0 else 48


def hole_heights(geometry: ThreeGeometry, surface: StarSurface) -> Floats:
    """Signed radial distances (n,) of the black holes of a slice from a surface, positive outside."""
    at = np.array([position for _, position in geometry.black_holes]).reshape(-1, 3)
    away = at - np.array(surface.center)
    distance = np.linalg.norm(away, axis=1)
    away[distance == 0.0] = (0.0, 0.0, 1.0)
    u = away / np.linalg.norm(away, axis=1)[:, None]
    return np.asarray(distance - surface.radius(u))


def clearance(geometry: ThreeGeometry, surface: StarSurface) -> float:
    """Radial distance of a surface from the nearest black hole: the length scale of its features."""
    return float(np.abs(hole_heights(geometry, surface)).min(initial=np.inf))


def _tangent(solution: Solution) -> tuple[float, Floats]:
    """Derivatives of the expansion and of the coefficients with respect to the coefficient of degree zero."""
    equations = solution.equations
    one = np.zeros(len(solution.iterate.f))
    one[0] = 1.0
    rates = -equations.solved(replace(equations, free=False).applied(one))
    rate, rates[0] = float(rates[0]), 1.0
    return rate, rates
