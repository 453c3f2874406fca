"""Foliation by surfaces of constant expansion, inward to the outermost horizon if there is one.

The leaves are parametrized by their mean radius; their expansion c is an unknown.  It is 2 / r on large
spheres and 0 at a horizon; ``c R / 2``, R the areal radius, decreases from 1 to 0 in Schwarzschild.  Leaves
that do not reach a horizon pass a minimum of the expansion.

Leaves are barriers (Andersson, Eichmair and Metzger, Contemp. Math. 554 (2011) 13).  Between a surface of
negative expansion and one of positive expansion around it there is an outermost horizon.  For a continuous
nested family of leaves of positive expansion, the maximum principle implies that every outer trapped surface
inside the first leaf lies inside the last one.  The computed leaves are discrete: positive expansion on them
suggests, but does not prove, positive expansion between them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq, root_scalar

from isoembed.meshing.sphere import gauss_rule
from isoembed.relativity.horizons.constant_expansion import (
    DEGREE_GROWTH,
    PRECISE_RESIDUAL,
    TRUNCATION,
    ConstantExpansionSurface,
    constant_expansion_surface,
    highest_degree,
    hole_heights,
)
from isoembed.relativity.horizons.newton import FAILURES, NoConvergence
from isoembed.relativity.horizons.radial_image import about, in_degree, recentered
from isoembed.relativity.spacetimes.star_surface import StarSurface
from isoembed.relativity.spacetimes.surface import Surface
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry
from isoembed.relativity.spacetimes.transformed import ScaledCurvature
from isoembed.smooth.transforms import resized
from isoembed.surface.estimate import percent

SHORTEST_STEP = 1e-4  # in mean radii
MISSED = 0.3  # largest difference of a leaf from its prediction, relative to the displacement


@dataclass(frozen=True, eq=False)
class Foliation:
    """Sequence of leaves of constant expansion.

    Attributes
    ----------
    leaves : tuple of ConstantExpansionSurface
        Nested leaves, from the outside inward, or outward if the first leaf is trapped.
    barriers : tuple of two ConstantExpansionSurface, or None
        Leaves of positive and of negative expansion with a change of sign between them.
    minimum : ConstantExpansionSurface or None
        Leaf of least expansion, or of least ``c R / 2``, if there is a minimum along the foliation.
    minimum_error : float
        Error of the least expansion, from the slice and from the degree.
    end : str
        Reason for the end of the foliation.
    """

    leaves: tuple[ConstantExpansionSurface, ...]
    barriers: tuple[ConstantExpansionSurface, ConstantExpansionSurface] | None = None
    minimum: ConstantExpansionSurface | None = None
    minimum_error: float = 0.0
    end: str = ""

    @property
    def least(self) -> ConstantExpansionSurface:
        """Leaf of least ``|c R / 2|``."""
        leaves = self.leaves if self.minimum is None else (*self.leaves, self.minimum)
        return min(leaves, key=lambda leaf: abs(leaf.normalized_expansion))

    @property
    def excludes(self) -> bool:
        """Whether the least expansion is a minimum that exceeds its error."""
        return self.minimum is not None and self.minimum.expansion > self.minimum_error

    @property
    def undecided(self) -> bool:
        """Whether the least expansion is zero to within its error."""
        return self.minimum is not None and abs(self.minimum.expansion) <= self.minimum_error


def foliate(
    geometry: ThreeGeometry, start: StarSurface, *, symmetric: bool, longest_step: float = 0.15
) -> Foliation:
    """Compute leaves inward from a surface to a horizon, or outward from a trapped surface.

    Raises `NoConvergence`, `InvalidMetric` or `InvalidParameter`: there is no surface of constant expansion
    near the start.

    Parameters
    ----------
    geometry : ThreeGeometry
    start : StarSurface
    symmetric : bool
        Whether slice and surface are symmetric about the z-axis.
    longest_step : float
        Largest displacement between successive leaves, in mean radii.
    """
    leaves = [_first(geometry, start, symmetric)]
    outward = leaves[0].expansion <= 0.0
    largest, step, why = leaves[0].surface.mean_radius, longest_step, ""
    minimum, error, end_at = None, 0.0, np.inf
    while True:
        last = leaves[-1]
        try:
            guess = recentered(last.displaced(step if outward else -step))
            leaf = constant_expansion_surface(geometry, guess)
            prediction_error = _prediction_error(geometry, last, guess, leaf, step)
        except FAILURES as failure:
            step *= 0.5
            if not why or not isinstance(failure, NoConvergence):
                why = str(failure)
            if step < SHORTEST_STEP or minimum is not None:
                end = f"no smaller surface was found: {why}{_noisy(last)}"
                return Foliation(tuple(leaves), None, minimum, error, end)
            continue
        if prediction_error > MISSED:
            step, why = 0.5 * step, "surfaces differ from their prediction"
            if step < SHORTEST_STEP:
                end = f"no smaller surface was found: {why}{_noisy(last)}"
                return Foliation(tuple(leaves), None, minimum, error, end)
            continue
        step = min(longest_step, step * float(np.clip(0.5 * MISSED / max(prediction_error, 1e-3), 0.5, 2.0)))
        why = ""
        if (leaf.expansion <= 0.0) != outward:
            barriers = (leaf, last) if outward else (last, leaf)
            return Foliation((*leaves, leaf), barriers, minimum, error)
        if not outward and last.rate > 0.0 > leaf.rate:
            try:
                lowest, off = least_expansion(geometry, last, leaf, settled=0.1)
            except FAILURES as failure:
                end = f"the surface of least expansion was not found: {failure}"
                return Foliation((*leaves, leaf), None, None, 0.0, end)
            if lowest.expansion <= -off:
                return Foliation((*leaves, lowest), (last, lowest), lowest, off)
            if lowest.expansion <= off:
                end = f"the least expansion is {lowest.expansion:.2g} +- {off:.1g}: its sign is not known"
                return Foliation(tuple(leaves), None, lowest, off, end)
            if minimum is None or lowest.expansion < minimum.expansion:
                minimum, error, end_at = lowest, off, 1.05 * lowest.normalized_expansion
        elif (
            not outward
            and minimum is None
            and len(leaves) > 1
            and leaf.rate < 0.0
            and leaf.normalized_expansion > last.normalized_expansion
        ):
            minimum, error = last, _minimum_error(leaves[-2], last, leaf)
            end_at = last.normalized_expansion + 0.25  # fast holes may have such a minimum, too
        leaves.append(leaf)
        if minimum is not None and leaf.normalized_expansion < minimum.normalized_expansion:
            minimum, error = None, 0.0
        if minimum is not None and leaf.normalized_expansion > end_at:
            return Foliation(tuple(leaves), None, minimum, error, "the expansion grows again")
        if not 1e-3 < leaf.surface.mean_radius / largest < 1e3:
            end = (
                f"the surfaces have become {'a thousand times as large' if outward else 'as small as points'}"
            )
            return Foliation(tuple(leaves), None, minimum, error, end)


def crossing(
    geometry: ThreeGeometry,
    outer: ConstantExpansionSurface,
    inner: ConstantExpansionSurface,
    *,
    closeness: float,
) -> tuple[ConstantExpansionSurface, ConstantExpansionSurface, StarSurface]:
    """Narrow the barriers of a horizon, and predict the horizon between them.

    Raises `NoConvergence`, `InvalidMetric` or `InvalidParameter`: see
    `isoembed.relativity.horizons.newton.solve`.

    Parameters
    ----------
    geometry : ThreeGeometry
    outer, inner : ConstantExpansionSurface
        Leaves of positive and of negative expansion.
    closeness : float
        Tolerance of the predicted horizon, in mean radii.
    """
    family, largest, smallest = _family(geometry, outer, inner)
    xtol = closeness * largest / max(outer.speed, inner.speed)
    root = _root(lambda mean: family.at(mean).expansion, smallest, largest, xtol)
    leaves = sorted(family.computed, key=lambda leaf: abs(leaf.surface.coefficients[0] - root))
    above = next(leaf for leaf in leaves if leaf.expansion > 0.0)
    below = next(leaf for leaf in leaves if leaf.expansion <= 0.0)
    return above, below, leaves[0].of_mean(root)


def least_expansion(
    geometry: ThreeGeometry,
    outer: ConstantExpansionSurface,
    inner: ConstantExpansionSurface,
    *,
    settled: float,
) -> tuple[ConstantExpansionSurface, float]:
    """Leaf of least expansion between two others, and the error of its expansion.

    Raises `NoConvergence`, `InvalidMetric` or `InvalidParameter`: see
    `isoembed.relativity.horizons.newton.solve`.

    Parameters
    ----------
    geometry : ThreeGeometry
    outer, inner : ConstantExpansionSurface
        Leaves with inward decreasing and with inward increasing expansion.
    settled : float
        Relative change of the least expansion between degrees that counts as converged.
    """
    highest = highest_degree(outer.surface)
    family, largest, smallest = _family(geometry, outer, inner)
    xtol = 1e-5 * abs(largest - smallest)
    lowest = family.at(_root(lambda mean: family.at(mean).rate, smallest, largest, xtol))
    while True:
        degree = lowest.surface.harmonics.degree
        rounding = 1e-13 / lowest.areal_radius
        if degree >= highest:
            return lowest, lowest.error + lowest.upper - lowest.lower + rounding
        finer = in_degree(lowest.surface, min(highest, int(DEGREE_GROWTH * degree)))
        new = _stationary(geometry, constant_expansion_surface(geometry, finer, enough=PRECISE_RESIDUAL))
        change = abs(new.expansion - lowest.expansion)
        if change <= max(settled * abs(new.expansion), new.error, rounding):
            return new, change + new.error + rounding
        lowest = new


def inside(inner: Surface, outer: StarSurface) -> bool:
    """Whether a surface lies inside another one at the nodes of a Gauss rule, to the accuracy of leaves."""
    n = max(inner.harmonics.degree, outer.harmonics.degree) + 2
    u, _ = gauss_rule(n, 1 if max(inner.harmonics.order, outer.harmonics.order) == 0 else 2 * n)
    away = inner.points(u) - np.array(outer.center)
    distance = np.linalg.norm(away, axis=1)
    slack = TRUNCATION * outer.mean_radius
    return bool(np.all(distance <= outer.radius(away / distance[:, None]) + slack))


def _minimum_error(
    before: ConstantExpansionSurface, lowest: ConstantExpansionSurface, after: ConstantExpansionSurface
) -> float:
    """Error of the expansion of a leaf with smaller c R / 2 than its neighbors.

    The sum of the variation of the expansion over the leaf and the difference of c R / 2 from a neighbor, a
    bound on how much lower a convex function is between them.
    """
    differences = (leaf.normalized_expansion - lowest.normalized_expansion for leaf in (before, after))
    return lowest.upper - lowest.lower + 2.0 * max(differences) / lowest.areal_radius


def _first(geometry: ThreeGeometry, start: StarSurface, symmetric: bool) -> ConstantExpansionSurface:
    """Leaf near the initial surface, about its own centroid.

    Leaves around a moving hole are displaced by a fraction of their radius that increases with the speed, too
    far for Newton's method from a sphere; K_ij is therefore scaled up in steps.
    """
    surface = in_degree(start, max(8, start.harmonics.degree), symmetric)
    for factor in (1.0,) if geometry.time_symmetric else (0.0, 0.25, 0.5, 0.75, 1.0):
        leaf = constant_expansion_surface(ScaledCurvature(geometry, factor), surface)
        surface = recentered(leaf.surface)
    if surface is leaf.surface:
        return leaf
    return constant_expansion_surface(geometry, surface)


@dataclass(frozen=True, eq=False)
class _Family:
    """Leaves about one center by their coefficient of degree zero, each computed from the nearest one."""

    geometry: ThreeGeometry
    computed: list[ConstantExpansionSurface]

    def at(self, mean: float) -> ConstantExpansionSurface:
        nearest = min(self.computed, key=lambda leaf: abs(leaf.surface.coefficients[0] - mean))
        if nearest.surface.coefficients[0] != mean:
            guess = nearest.of_mean(mean)
            nearest = constant_expansion_surface(self.geometry, guess, enough=PRECISE_RESIDUAL)
            self.computed.append(nearest)
        return nearest


def _family(
    geometry: ThreeGeometry, outer: ConstantExpansionSurface, inner: ConstantExpansionSurface
) -> tuple[_Family, float, float]:
    """Family of leaves between two others, and the coefficients of degree zero of the outer and inner one."""
    if inner.surface.center != outer.surface.center:
        inner = constant_expansion_surface(geometry, about(inner.surface, outer.surface.center))
    family = _Family(geometry, [outer, inner])
    return family, float(outer.surface.coefficients[0]), float(inner.surface.coefficients[0])


def _root(f: Callable[[float], float], a: float, b: float, xtol: float) -> float:
    """Root between a and b by Brent's method.

    Raises `NoConvergence`: both ends have the same sign, because recomputed leaves differ from the former.
    """
    if f(a) * f(b) > 0.0:
        raise NoConvergence("no change of sign is left between two surfaces of constant expansion")
    return float(brentq(f, a, b, xtol=xtol, rtol=1e-15))


def _stationary(geometry: ThreeGeometry, leaf: ConstantExpansionSurface) -> ConstantExpansionSurface:
    """Leaf of stationary expansion near a given leaf, in the same degree."""
    family = _Family(geometry, [leaf])
    mean = float(leaf.surface.coefficients[0])
    found = root_scalar(
        lambda mean: family.at(mean).rate,
        x0=mean,
        x1=mean * (1.0 + 1e-3 / leaf.speed),
        method="secant",
        xtol=1e-8 * mean / leaf.speed,
        maxiter=20,
    )
    if not found.converged:
        raise NoConvergence("the surface of least expansion was not found")
    return family.at(float(found.root))


def _enclosed(geometry: ThreeGeometry, surface: StarSurface) -> list[bool]:
    """Whether each black hole is inside a surface."""
    return (hole_heights(geometry, surface) < 0.0).tolist()


def _prediction_error(
    geometry: ThreeGeometry,
    last: ConstantExpansionSurface,
    guess: StarSurface,
    leaf: ConstantExpansionSurface,
    step: float,
) -> float:
    """Difference of a leaf from its prediction, relative to the displacement from the previous leaf.

    Raises `NoConvergence`: the leaves intersect, or there is a black hole between them.
    """
    old = resized(guess.coefficients[:, None], guess.harmonics, leaf.surface.harmonics)[:, 0]
    u, _ = gauss_rule(leaf.surface.harmonics.degree + 2, 2 * leaf.surface.harmonics.order + 1)
    change = leaf.surface.radius(u) - StarSurface(guess.center, leaf.surface.harmonics, old).radius(u)
    small, large = sorted((last.surface, leaf.surface), key=lambda surface: surface.mean_radius)
    if not inside(small, large):
        raise NoConvergence("the surfaces of constant expansion cross each other")
    if _enclosed(geometry, small) != _enclosed(geometry, large):
        raise NoConvergence("the surfaces of constant expansion pass over a black hole")
    return float(np.abs(change).max()) / (step * last.surface.mean_radius)


def _noisy(leaf: ConstantExpansionSurface) -> str:
    if leaf.noise <= 0.01:
        return ""
    return f"; the slice may displace the surface by {percent(leaf.noise)} there"
