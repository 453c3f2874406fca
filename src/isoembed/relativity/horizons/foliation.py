"""Foliation by surfaces of constant expansion, inward to the outermost horizon or to none.

The leaves are parametrized by their mean radius; the expansion c is found with each of them.  It is 2 / r on
large spheres and 0 at a horizon; ``c R / 2``, R the areal radius, falls from 1 to 0 in Schwarzschild.  Leaves
that miss a horizon, or are not ended by one, pass a minimum of the expansion.

Leaves are barriers (Andersson, Eichmair and Metzger, Contemp. Math. 554 (2011) 13).  A surface of negative
expansion inside one of positive expansion: there is an outermost horizon between them.  A continuous family
of leaves of positive expansion, one inside the other: by the maximum principle every outer trapped surface
inside the first leaf lies inside the last one.  The leaves that are computed are discrete: that the expansion
is positive on them suggests that it is positive between them, and does not prove it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq, root_scalar

from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.meshing.sphere import gauss_rule
from isoembed.relativity.horizons.constant_expansion import (
    DEGREE_GROWTH,
    FIRST_DEGREE,
    HIGHEST_DEGREES,
    PRECISE_RESIDUAL,
    TRUNCATION,
    ConstantExpansionSurface,
    constant_expansion_surface,
    hole_heights,
)
from isoembed.relativity.horizons.newton import NoConvergence
from isoembed.relativity.horizons.radial_image import about, in_degree, recentered
from isoembed.relativity.spacetimes.star_surface import StarSurface
from isoembed.relativity.spacetimes.surface import Surface
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry
from isoembed.relativity.spacetimes.transformed import ScaledCurvature
from isoembed.smooth.transforms import resized
from isoembed.surface.estimate import percent

SHORTEST_STEP = 1e-4  # over the mean radius
MISSED = 0.3  # largest difference of a leaf from its prediction, over the displacement
SMALLEST = 1e-3
"""Mean radius over that of the first leaf at which the foliation ends."""
RELATIVE_RISE, ABSOLUTE_RISE = 1.05, 0.25
"""Rise of c R / 2 that ends the foliation: relative after a minimum of c, absolute after a minimum of c R / 2
alone, which there is around fast holes, too."""


@dataclass(frozen=True, eq=False)
class Foliation:
    """The leaves from a first surface on, as far as they reach.

    Attributes
    ----------
    leaves : tuple of ConstantExpansionSurface
        One inside the other, or one outside the other where the first one is trapped.
    barriers : tuple of two ConstantExpansionSurface, or None
        The one of positive expansion and the one of negative expansion between which it changes sign.
    minimum : ConstantExpansionSurface or None
        The leaf of least expansion, or of the least ``c R / 2``, if that has a minimum on the way.
    minimum_error : float
        Its error, by the slice and by the degree.
    end : str
        The reason why there are no more.
    """

    leaves: tuple[ConstantExpansionSurface, ...]
    barriers: tuple[ConstantExpansionSurface, ConstantExpansionSurface] | None = None
    minimum: ConstantExpansionSurface | None = None
    minimum_error: float = 0.0
    end: str = ""

    @property
    def least(self) -> ConstantExpansionSurface:
        """The leaf of the least ``c R / 2``."""
        leaves = self.leaves if self.minimum is None else (*self.leaves, self.minimum)
        return min(leaves, key=lambda leaf: abs(leaf.normalized_expansion))

    @property
    def excludes(self) -> bool:
        """Whether the least expansion is a minimum, and above zero by more than its error."""
        return self.minimum is not None and self.minimum.expansion > self.minimum_error

    @property
    def undecided(self) -> bool:
        """Whether the least expansion is zero to within its error."""
        return self.minimum is not None and abs(self.minimum.expansion) <= self.minimum_error


def foliate(
    geometry: ThreeGeometry, start: StarSurface, *, symmetric: bool, longest_step: float = 0.15
) -> Foliation:
    """Leaves from a surface inwards to a horizon, or outwards from a trapped one.

    Raises `NoConvergence`, `InvalidMetric` or `InvalidParameter`: there is no surface of constant expansion
    near the first one.

    Parameters
    ----------
    geometry : ThreeGeometry
    start : StarSurface
    symmetric : bool
        About z: slice and surface.
    longest_step : float
        Longest displacement of a leaf from the one before, over the mean radius.
    """
    leaves = [_first(geometry, start, symmetric)]
    outward = leaves[0].expansion <= 0.0
    largest, step, why = leaves[0].surface.mean_radius, longest_step, ""
    minimum, error, end_at = None, 0.0, np.inf
    while True:
        last = leaves[-1]
        try:
            guess = recentered(last.displaced(step if outward else -step), symmetric)
            leaf = constant_expansion_surface(geometry, guess, symmetric=symmetric)
            missed = _prediction_error(geometry, last, guess, leaf, step)
        except (NoConvergence, InvalidMetric, InvalidParameter) as failure:
            step *= 0.5
            if not why or not isinstance(failure, NoConvergence):
                why = str(failure)
            if step < SHORTEST_STEP or minimum is not None:
                end = f"no smaller surface was found: {why}{_noisy(last)}"
                return Foliation(tuple(leaves), None, minimum, error, end)
            continue
        if missed > MISSED:
            step, why = 0.5 * step, "surfaces differ from their prediction"
            if step < SHORTEST_STEP:
                end = f"no smaller surface was found: {why}{_noisy(last)}"
                return Foliation(tuple(leaves), None, minimum, error, end)
            continue
        step = min(longest_step, step * float(np.clip(0.5 * MISSED / max(missed, 1e-3), 0.5, 2.0)))
        why = ""
        if (leaf.expansion <= 0.0) != outward:
            barriers = (leaf, last) if outward else (last, leaf)
            return Foliation((*leaves, leaf), barriers, minimum, error)
        if not outward and last.rate > 0.0 > leaf.rate:
            try:
                lowest, off = least_expansion(geometry, last, leaf, symmetric=symmetric, settled=0.1)
            except (NoConvergence, InvalidMetric, InvalidParameter) as failure:
                end = f"the surface of least expansion was not found: {failure}"
                return Foliation((*leaves, leaf), None, None, 0.0, end)
            if lowest.expansion <= -off:
                return Foliation((*leaves, lowest), (last, lowest), lowest, off)
            if lowest.expansion <= off:
                end = f"the least expansion is {lowest.expansion:.2g} +- {off:.1g}: its sign is not known"
                return Foliation(tuple(leaves), None, lowest, off, end)
            if minimum is None or lowest.expansion < minimum.expansion:
                minimum, error, end_at = lowest, off, RELATIVE_RISE * lowest.normalized_expansion
        elif (
            not outward
            and minimum is None
            and len(leaves) > 1
            and leaf.rate < 0.0
            and leaf.normalized_expansion > last.normalized_expansion
        ):
            minimum, error = last, _minimum_error(leaves[-2], last, leaf)
            end_at = last.normalized_expansion + ABSOLUTE_RISE
        leaves.append(leaf)
        if minimum is not None and leaf.normalized_expansion < minimum.normalized_expansion:
            minimum, error = None, 0.0
        if minimum is not None and leaf.normalized_expansion > end_at:
            return Foliation(tuple(leaves), None, minimum, error, "the expansion grows again")
        if not SMALLEST < leaf.surface.mean_radius / largest < 1.0 / SMALLEST:
            end = (
                f"the surfaces have become {'a thousand times as large' if outward else 'as small as points'}"
            )
            return Foliation(tuple(leaves), None, minimum, error, end)


def crossing(
    geometry: ThreeGeometry,
    outer: ConstantExpansionSurface,
    inner: ConstantExpansionSurface,
    *,
    symmetric: bool,
    closeness: float,
) -> tuple[ConstantExpansionSurface, ConstantExpansionSurface, StarSurface]:
    """Barriers closer to the horizon between two of them, and a prediction of the horizon.

    Raises `NoConvergence`, `InvalidMetric` or `InvalidParameter`: see
    `isoembed.relativity.horizons.newton.solve`.

    Parameters
    ----------
    geometry : ThreeGeometry
    outer, inner : ConstantExpansionSurface
        Of positive and of negative expansion.
    symmetric : bool
        About z: slice and surface.
    closeness : float
        The distance of the horizon from one of them, in mean radii, as the rate of the expansion predicts it.
    """
    family, largest, smallest = _family(geometry, outer, inner, symmetric)
    xtol = closeness * largest / max(outer.speed, inner.speed)
    root = _root(lambda mean: family.at(mean).expansion, smallest, largest, xtol)
    leaves = sorted(family.known, key=lambda leaf: abs(leaf.surface.coefficients[0] - root))
    above = next(leaf for leaf in leaves if leaf.expansion > 0.0)
    below = next(leaf for leaf in leaves if leaf.expansion <= 0.0)
    return above, below, leaves[0].of_mean(root)


def least_expansion(
    geometry: ThreeGeometry,
    outer: ConstantExpansionSurface,
    inner: ConstantExpansionSurface,
    *,
    symmetric: bool,
    settled: float,
) -> tuple[ConstantExpansionSurface, float]:
    """The leaf of least expansion between two others, and the error of its expansion.

    Raises `NoConvergence`, `InvalidMetric` or `InvalidParameter`: see
    `isoembed.relativity.horizons.newton.solve`.

    Parameters
    ----------
    geometry : ThreeGeometry
    outer, inner : ConstantExpansionSurface
        Where the expansion falls inwards, and where it grows inwards.
    symmetric : bool
        About z: slice and surface.
    settled : float
        Relative change of the least expansion with the degree that counts as zero.
    """
    highest = HIGHEST_DEGREES[int(symmetric)]
    family, largest, smallest = _family(geometry, outer, inner, symmetric)
    xtol = 1e-5 * abs(largest - smallest)
    lowest = family.at(_root(lambda mean: family.at(mean).rate, smallest, largest, xtol))
    while True:
        degree = lowest.surface.harmonics.degree
        rounding = 1e-13 / lowest.areal_radius
        if degree >= highest:
            return lowest, lowest.error + lowest.greatest - lowest.least + rounding
        finer = in_degree(lowest.surface, min(highest, int(DEGREE_GROWTH * degree)), symmetric)
        there = constant_expansion_surface(geometry, finer, symmetric=symmetric, enough=PRECISE_RESIDUAL)
        new = _stationary(geometry, there, symmetric)
        change = abs(new.expansion - lowest.expansion)
        if change <= max(settled * abs(new.expansion), new.error, rounding):
            return new, change + new.error + rounding
        lowest = new


def inside(inner: Surface, outer: StarSurface) -> bool:
    """Whether a surface lies inside another one, at the nodes of a Gauss rule, as right as leaves are."""
    n = max(inner.harmonics.degree, outer.harmonics.degree) + 2
    u, _ = gauss_rule(n, 1 if max(inner.harmonics.order, outer.harmonics.order) == 0 else 2 * n)
    away = inner.points(u) - np.array(outer.center)
    distance = np.linalg.norm(away, axis=1)
    slack = TRUNCATION * outer.mean_radius
    return bool(np.all(distance <= outer.radius(away / distance[:, None]) + slack))


def _minimum_error(
    before: ConstantExpansionSurface, lowest: ConstantExpansionSurface, after: ConstantExpansionSurface
) -> float:
    """Error of the expansion of a leaf whose c R / 2 is less than that of its neighbors.

    The variation of the expansion over the leaf, and as much as c R / 2 differs from that of a neighbor: a
    convex function is at most so much lower between them.
    """
    differences = (leaf.normalized_expansion - lowest.normalized_expansion for leaf in (before, after))
    return lowest.greatest - lowest.least + 2.0 * max(differences) / lowest.areal_radius


def _first(geometry: ThreeGeometry, start: StarSurface, symmetric: bool) -> ConstantExpansionSurface:
    """The leaf near a first surface, about its own centroid.

    Around a hole in motion leaves are displaced by a part of their radius that grows with the speed, too far
    for Newton's method from a sphere: K_ij is turned on in steps.
    """
    surface = in_degree(start, max(FIRST_DEGREE, start.harmonics.degree), symmetric)
    for factor in (1.0,) if geometry.time_symmetric else (0.0, 0.25, 0.5, 0.75, 1.0):
        leaf = constant_expansion_surface(ScaledCurvature(geometry, factor), surface, symmetric=symmetric)
        surface = recentered(leaf.surface, symmetric)
    if surface is leaf.surface:
        return leaf
    return constant_expansion_surface(geometry, surface, symmetric=symmetric)


@dataclass(frozen=True, eq=False)
class _Family:
    """Leaves about one center, by the coefficient of degree zero, each found from the nearest one."""

    geometry: ThreeGeometry
    symmetric: bool
    known: list[ConstantExpansionSurface]

    def at(self, mean: float) -> ConstantExpansionSurface:
        nearest = min(self.known, key=lambda leaf: abs(leaf.surface.coefficients[0] - mean))
        if nearest.surface.coefficients[0] != mean:
            guess = nearest.of_mean(mean)
            nearest = constant_expansion_surface(
                self.geometry, guess, symmetric=self.symmetric, enough=PRECISE_RESIDUAL
            )
            self.known.append(nearest)
        return nearest


def _family(
    geometry: ThreeGeometry, outer: ConstantExpansionSurface, inner: ConstantExpansionSurface, symmetric: bool
) -> tuple[_Family, float, float]:
    """The leaves between two others, and the coefficients of degree zero of these, the outer one first."""
    if inner.surface.center != outer.surface.center:
        inner = constant_expansion_surface(
            geometry, about(inner.surface, outer.surface.center), symmetric=symmetric
        )
    family = _Family(geometry, symmetric, [outer, inner])
    return family, float(outer.surface.coefficients[0]), float(inner.surface.coefficients[0])


def _root(f: Callable[[float], float], a: float, b: float, xtol: float) -> float:
    """The root between a and b by Brent's method.

    Raises `NoConvergence`: the signs at the ends are the same: leaves found anew are not those that they
    were.
    """
    if f(a) * f(b) > 0.0:
        raise NoConvergence("no change of sign is left between two surfaces of constant expansion")
    return float(brentq(f, a, b, xtol=xtol, rtol=1e-15))


def _stationary(
    geometry: ThreeGeometry, leaf: ConstantExpansionSurface, symmetric: bool
) -> ConstantExpansionSurface:
    """The leaf near a given one where the rate of the expansion is zero, in one degree."""
    family = _Family(geometry, symmetric, [leaf])
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
    """Whether each black hole is inside of a surface."""
    return (hole_heights(geometry, surface) < 0.0).tolist()


def _prediction_error(
    geometry: ThreeGeometry,
    last: ConstantExpansionSurface,
    guess: StarSurface,
    leaf: ConstantExpansionSurface,
    step: float,
) -> float:
    """The difference of a leaf from its prediction, over the displacement from the leaf before.

    Raises `NoConvergence`: the leaves cross each other, or pass over a black hole.
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
