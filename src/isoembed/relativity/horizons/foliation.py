"""Foliation by surfaces of constant expansion, from a large sphere to the outermost horizon.

The leaves are parametrized by their mean radius; the expansion c is found with each of them.  It is 2 / r on
large spheres and falls to 0 at a horizon; ``c R / 2``, R the areal radius, falls from 1 to 0 in
Schwarzschild.  Where there is no horizon the expansion has a minimum above 0.

Leaves are barriers (Andersson, Eichmair and Metzger, Contemp. Math. 554 (2011) 13).  A surface of negative
expansion inside one of positive expansion: there is an outermost horizon between them.  A continuous family
of leaves of positive expansion, one inside the other: by the maximum principle every outer trapped surface
inside the first leaf lies inside the last one.  The leaves that are computed are discrete: that the expansion
is positive on them suggests that it is positive between them, and does not prove it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq, root_scalar

from isoembed.arrays import Floats
from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.meshing.sphere import gauss_rule
from isoembed.relativity.horizons.ladder import about, in_degree, level_of, recentered
from isoembed.relativity.horizons.newton import NoConvergence, Solution, solve
from isoembed.relativity.spacetimes.scaled_curvature import ScaledCurvature
from isoembed.relativity.spacetimes.star_surface import StarSurface
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry
from isoembed.smooth.transforms import resized
from isoembed.thresholds import threshold


@dataclass(frozen=True)
class FoliationThresholds:
    """Thresholds of the foliation by surfaces of constant expansion."""

    first: int = threshold(8, "count", "First degree of the surfaces.")
    highest: tuple[int, int] = threshold((48, 512), "count", "Highest degree, and with symmetry about z.")
    tail: float = threshold(1e-4, "mean radius", "Coefficients of high degree that ask for a higher one.")
    spread: float = threshold(0.02, "c R / 2", "Variation of the expansion that asks for a higher degree.")
    step: float = threshold(0.15, "mean radius", "Longest displacement of a leaf from the one before.")
    shortest: float = threshold(1e-4, "mean radius", "Shortest displacement that is tried.")
    bent: float = threshold(0.3, "displacement", "Largest difference of a leaf from its prediction.")
    residual: float = threshold(1e-6, "mean radius", "Residual of a leaf.")
    precise: float = threshold(1e-12, "mean radius", "Residual of a leaf near the minimum or the horizon.")
    rise: tuple[float, float] = threshold(
        (1.05, 0.25),
        "c R / 2",
        "Rise that ends the foliation: relative after a minimum of c, absolute after one of c R / 2 alone, "
        "as there are around fast holes, too.",
    )


FOLIATION = FoliationThresholds()
SMALLEST = 1e-3
"""Mean radius over that of the first leaf at which the foliation ends: a surface this small is a point."""
HIGHER = 1.5
"""Ratio of one degree to the one before."""


@dataclass(frozen=True, eq=False)
class Leaf:
    """A surface of constant expansion.

    Attributes
    ----------
    surface : StarSurface
    expansion : float
        Its constant part c.
    least, greatest : float
        The extreme values of the expansion at the nodes, further apart by the slice's error.
    error : float
        The change of c by the slice's error, at constant mean radius.
    areal_radius : float
    rate : float
        The derivative of the expansion in the coefficient of degree zero.
    tangent : ndarray
        That of all coefficients.
    speed : float
        The displacement of the fastest point over that of the mean radius.
    noise : float
        See `isoembed.relativity.horizons.newton.Solution`.
    """

    surface: StarSurface
    expansion: float
    least: float
    greatest: float
    error: float
    areal_radius: float
    rate: float
    tangent: Floats
    speed: float
    noise: float

    @property
    def fall(self) -> float:
        """``c R / 2``: 1 on a sphere in flat space, 0 on a horizon."""
        return 0.5 * self.expansion * self.areal_radius

    def displaced(self, distance: float) -> StarSurface:
        """Prediction of the leaf whose fastest point is so many mean radii further out."""
        return self.of_mean(self.surface.coefficients[0] * (1.0 + distance / self.speed))

    def of_mean(self, mean: float) -> StarSurface:
        """Prediction of the leaf whose coefficient of degree zero is given."""
        f = self.surface.coefficients
        return StarSurface(self.surface.center, self.surface.harmonics, f + (mean - f[0]) * self.tangent)


@dataclass(frozen=True, eq=False)
class Foliation:
    """The leaves from a first surface on, as far as they reach.

    Attributes
    ----------
    leaves : tuple of Leaf
        One inside the other, or one outside the other where the first one is trapped.
    barriers : tuple of two Leaf, or None
        The one of positive expansion and the one of negative expansion between which it changes sign.
    minimum : Leaf or None
        The leaf of least expansion, or of the least ``c R / 2``, if that has a minimum on the way.
    minimum_error : float
        Its error, by the slice and by the degree.
    end : str
        The reason why there are no more.
    """

    leaves: tuple[Leaf, ...]
    barriers: tuple[Leaf, Leaf] | None = None
    minimum: Leaf | None = None
    minimum_error: float = 0.0
    end: str = ""

    @property
    def least(self) -> Leaf:
        """The leaf of the least ``c R / 2``."""
        leaves = self.leaves if self.minimum is None else (*self.leaves, self.minimum)
        return min(leaves, key=lambda leaf: abs(leaf.fall))

    @property
    def excludes(self) -> bool:
        """Whether the least expansion is a minimum, and above zero by more than its error."""
        return self.minimum is not None and self.minimum.expansion > self.minimum_error

    @property
    def undecided(self) -> bool:
        """Whether the least expansion is zero to within its error."""
        return self.minimum is not None and abs(self.minimum.expansion) <= self.minimum_error


def foliate(geometry: ThreeGeometry, start: StarSurface, *, symmetric: bool) -> Foliation:
    """Leaves from a surface inwards to a horizon, or outwards from a trapped one.

    Parameters
    ----------
    geometry : ThreeGeometry
    start : StarSurface
    symmetric : bool
        About z: slice and surface.

    Raises
    ------
    NoConvergence, InvalidMetric, InvalidParameter
        There is no surface of constant expansion near the first one.
    """
    leaves = [_first(geometry, start, symmetric)]
    outward = leaves[0].expansion <= 0.0
    largest, step, why = leaves[0].surface.mean_radius, FOLIATION.step, ""
    minimum, error, end_at = None, 0.0, np.inf
    while True:
        last = leaves[-1]
        try:
            guess = recentered(last.displaced(step if outward else -step), symmetric)
            leaf = leaf_of(geometry, guess, symmetric=symmetric)
            bent = _bent(geometry, last, guess, leaf, step)
        except (NoConvergence, InvalidMetric, InvalidParameter) as failure:
            step *= 0.5
            if not why or not isinstance(failure, NoConvergence):
                why = str(failure)
            if step < FOLIATION.shortest or minimum is not None:
                end = f"no smaller one was found: {why}{_noisy(last)}"
                return Foliation(tuple(leaves), None, minimum, error, end)
            continue
        if bent > FOLIATION.bent:
            step, why = 0.5 * step, "surfaces differ from their prediction"
            if step < FOLIATION.shortest:
                end = f"no smaller one was found: {why}{_noisy(last)}"
                return Foliation(tuple(leaves), None, minimum, error, end)
            continue
        step = min(FOLIATION.step, step * float(np.clip(0.5 * FOLIATION.bent / max(bent, 1e-3), 0.5, 2.0)))
        why = ""
        if (leaf.expansion <= 0.0) != outward:
            barriers = (leaf, last) if outward else (last, leaf)
            return Foliation((*leaves, leaf), barriers, minimum, error)
        if not outward and last.rate > 0.0 > leaf.rate:
            try:
                lowest, off = least_expansion(geometry, last, leaf, symmetric=symmetric, settled=0.1)
            except (NoConvergence, InvalidMetric, InvalidParameter) as failure:
                end = f"the one of least expansion was not found: {failure}"
                return Foliation((*leaves, leaf), None, None, 0.0, end)
            if lowest.expansion <= -off:
                return Foliation((*leaves, lowest), (last, lowest), lowest, off)
            if lowest.expansion <= off:
                end = f"the least expansion is {lowest.expansion:.2g} +- {off:.1g}: its sign is not known"
                return Foliation(tuple(leaves), None, lowest, off, end)
            if minimum is None or lowest.expansion < minimum.expansion:
                minimum, error, end_at = lowest, off, FOLIATION.rise[0] * lowest.fall
        elif (
            not outward and minimum is None and len(leaves) > 1 and leaf.rate < 0.0 and leaf.fall > last.fall
        ):
            minimum, error = last, last.greatest - last.least
            end_at = last.fall + FOLIATION.rise[1]
        leaves.append(leaf)
        if minimum is not None and leaf.fall < minimum.fall:
            minimum, error = None, 0.0
        if minimum is not None and leaf.fall > end_at:
            return Foliation(tuple(leaves), None, minimum, error, "their expansion grows again")
        if not SMALLEST < leaf.surface.mean_radius / largest < 1.0 / SMALLEST:
            end = f"they have become {'a thousand times as large' if outward else 'as small as points'}"
            return Foliation(tuple(leaves), None, minimum, error, end)


def leaf_of(
    geometry: ThreeGeometry, guess: StarSurface, *, symmetric: bool, enough: float = FOLIATION.residual
) -> Leaf:
    """The surface of constant expansion with the mean radius of a guess.

    Parameters
    ----------
    geometry : ThreeGeometry
    guess : StarSurface
    symmetric : bool
        About z: slice and surface.
    enough : float
        Residual, as a displacement over the radius, at which to stop.

    Raises
    ------
    NoConvergence, InvalidMetric, InvalidParameter
        See `isoembed.relativity.horizons.newton.solve`.
    """
    highest = FOLIATION.highest[int(symmetric)]
    while True:
        level = level_of(geometry, guess)
        solution = solve(level, guess.coefficients, None, enough)
        f, harmonics, theta = solution.shape.f, guess.harmonics, solution.shape.local.expansion
        errors, R = np.abs(level.expansion_errors(solution.shape)), level.areal_radius(solution.shape)
        high = harmonics.labels[0] > 0.75 * harmonics.degree
        tail = np.abs(f[high]).max() / f[0]
        spread = 0.5 * R * float(np.ptp(theta))
        smooth = tail <= max(FOLIATION.tail, solution.noise)
        fall = 0.5 * R * abs(solution.expansion)
        least = max(1e-5, R * float(errors.max()))  # about a horizon the sign is not that of all points
        constant = spread <= max(min(FOLIATION.spread, 0.5 * fall), least)
        surface = StarSurface(guess.center, harmonics, f)
        seen = harmonics.degree * _clearance(geometry, surface) >= surface.mean_radius
        if (smooth and constant and seen) or harmonics.degree >= highest:
            break
        degree = min(highest, int(HIGHER * harmonics.degree))
        guess = in_degree(StarSurface(guess.center, harmonics, f), degree, symmetric)
    rate, tangent = _tangent(solution)
    by_slice = solution.equations.projected(errors[:, None])[:, 0]
    return Leaf(
        surface=StarSurface(guess.center, harmonics, f),
        expansion=solution.expansion,
        least=float((theta - errors).min()),
        greatest=float((theta + errors).max()),
        error=abs(float(solution.equations.solved(by_slice)[0])),
        areal_radius=R,
        rate=rate,
        tangent=tangent,
        speed=float(np.abs(level.transform.values(tangent[:, None])).max()) * np.sqrt(4.0 * np.pi),
        noise=solution.noise,
    )


def crossing(
    geometry: ThreeGeometry, outer: Leaf, inner: Leaf, *, symmetric: bool, closeness: float
) -> tuple[Leaf, Leaf, StarSurface]:
    """Barriers closer to the horizon between two of them, and a prediction of the horizon.

    Parameters
    ----------
    geometry : ThreeGeometry
    outer, inner : Leaf
        Of positive and of negative expansion.
    symmetric : bool
        About z: slice and surface.
    closeness : float
        The distance of the horizon from one of them, in mean radii, as the rate of the expansion predicts it.

    Raises
    ------
    NoConvergence, InvalidMetric, InvalidParameter
        See `isoembed.relativity.horizons.newton.solve`.
    """
    family, largest, smallest = _family(geometry, outer, inner, symmetric)
    xtol = closeness * largest / max(outer.speed, inner.speed)
    root = _root(lambda mean: family.at(mean).expansion, smallest, largest, xtol)
    leaves = sorted(family.known, key=lambda leaf: abs(leaf.surface.coefficients[0] - root))
    above = next(leaf for leaf in leaves if leaf.expansion > 0.0)
    below = next(leaf for leaf in leaves if leaf.expansion <= 0.0)
    return above, below, leaves[0].of_mean(root)


def least_expansion(
    geometry: ThreeGeometry, outer: Leaf, inner: Leaf, *, symmetric: bool, settled: float
) -> tuple[Leaf, float]:
    """The leaf of least expansion between two others, and the error of its expansion.

    Parameters
    ----------
    geometry : ThreeGeometry
    outer, inner : Leaf
        Where the expansion falls inwards, and where it grows inwards.
    symmetric : bool
        About z: slice and surface.
    settled : float
        Relative change of the least expansion with the degree that is none.

    Raises
    ------
    NoConvergence, InvalidMetric, InvalidParameter
        See `isoembed.relativity.horizons.newton.solve`.
    """
    highest = FOLIATION.highest[int(symmetric)]
    family, largest, smallest = _family(geometry, outer, inner, symmetric)
    xtol = 1e-5 * abs(largest - smallest)
    lowest = family.at(_root(lambda mean: family.at(mean).rate, smallest, largest, xtol))
    while True:
        degree = lowest.surface.harmonics.degree
        rounding = 1e-13 / lowest.areal_radius
        if degree >= highest:
            return lowest, lowest.error + lowest.greatest - lowest.least + rounding
        finer = in_degree(lowest.surface, min(highest, int(HIGHER * degree)), symmetric)
        there = leaf_of(geometry, finer, symmetric=symmetric, enough=FOLIATION.precise)
        new = _stationary(geometry, there, symmetric)
        change = abs(new.expansion - lowest.expansion)
        if change <= max(settled * abs(new.expansion), new.error, rounding):
            return new, change + new.error + rounding
        lowest = new


def inside(inner: StarSurface, outer: StarSurface) -> bool:
    """Whether a surface lies inside another one, at the nodes of a Gauss rule, as right as leaves are."""
    n = max(inner.harmonics.degree, outer.harmonics.degree) + 2
    u, _ = gauss_rule(n, 1 if max(inner.harmonics.order, outer.harmonics.order) == 0 else 2 * n)
    away = inner.points(u) - np.array(outer.center)
    distance = np.linalg.norm(away, axis=1)
    slack = FOLIATION.tail * outer.mean_radius
    return bool(np.all(distance <= outer.radius(away / distance[:, None]) + slack))


def _first(geometry: ThreeGeometry, start: StarSurface, symmetric: bool) -> Leaf:
    """The leaf near a first surface, about its own centroid.

    Around a hole in motion leaves are displaced by a part of their radius that grows with the speed, too far
    for Newton's method from a sphere: K_ij is turned on in steps.
    """
    surface = in_degree(start, max(FOLIATION.first, start.harmonics.degree), symmetric)
    for factor in (1.0,) if geometry.time_symmetric else (0.0, 0.25, 0.5, 0.75, 1.0):
        leaf = leaf_of(ScaledCurvature(geometry, factor), surface, symmetric=symmetric)
        surface = recentered(leaf.surface, symmetric)
    if surface is leaf.surface:
        return leaf
    return leaf_of(geometry, surface, symmetric=symmetric)


@dataclass(frozen=True, eq=False)
class _Family:
    """Leaves about one center, by the coefficient of degree zero, each found from the nearest one."""

    geometry: ThreeGeometry
    symmetric: bool
    known: list[Leaf]

    def at(self, mean: float) -> Leaf:
        nearest = min(self.known, key=lambda leaf: abs(leaf.surface.coefficients[0] - mean))
        if nearest.surface.coefficients[0] != mean:
            guess = nearest.of_mean(mean)
            nearest = leaf_of(self.geometry, guess, symmetric=self.symmetric, enough=FOLIATION.precise)
            self.known.append(nearest)
        return nearest


def _family(
    geometry: ThreeGeometry, outer: Leaf, inner: Leaf, symmetric: bool
) -> tuple[_Family, float, float]:
    """The leaves between two others, and the coefficients of degree zero of these, the outer one first."""
    if inner.surface.center != outer.surface.center:
        inner = leaf_of(geometry, about(inner.surface, outer.surface.center), symmetric=symmetric)
    family = _Family(geometry, symmetric, [outer, inner])
    return family, float(outer.surface.coefficients[0]), float(inner.surface.coefficients[0])


def _root(f: Callable[[float], float], a: float, b: float, xtol: float) -> float:
    """The root between a and b by Brent's method.

    Raises
    ------
    NoConvergence
        The signs at the ends are the same: leaves found anew are not those that they were.
    """
    if f(a) * f(b) > 0.0:
        raise NoConvergence("no change of sign is left between two surfaces of constant expansion")
    return float(brentq(f, a, b, xtol=xtol, rtol=1e-15))


def _stationary(geometry: ThreeGeometry, leaf: Leaf, symmetric: bool) -> Leaf:
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


def _heights(geometry: ThreeGeometry, surface: StarSurface) -> Floats:
    """How far the black holes of a slice that knows them are outside of a surface, along rays."""
    at = np.array([position for _, position in getattr(geometry, "black_holes", ())]).reshape(-1, 3)
    away = at - np.array(surface.center)
    distance = np.linalg.norm(away, axis=1)
    away[distance == 0.0] = (0.0, 0.0, 1.0)
    u = away / np.linalg.norm(away, axis=1)[:, None]
    return np.asarray(distance - surface.radius(u))


def _enclosed(geometry: ThreeGeometry, surface: StarSurface) -> list[bool]:
    """Whether each black hole is inside of a surface."""
    return (_heights(geometry, surface) < 0.0).tolist()


def _clearance(geometry: ThreeGeometry, surface: StarSurface) -> float:
    """The distance of a surface from the nearest black hole: the length over which it may change."""
    return float(np.abs(_heights(geometry, surface)).min(initial=np.inf))


def _bent(geometry: ThreeGeometry, last: Leaf, guess: StarSurface, leaf: Leaf, step: float) -> float:
    """The difference of a leaf from its prediction, over the displacement from the leaf before.

    Raises
    ------
    NoConvergence
        The leaves cross each other, or pass over a black hole.
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


def _noisy(leaf: Leaf) -> str:
    if leaf.noise <= 0.01:
        return ""
    return f"; the slice may displace the surface by {100.0 * leaf.noise:.2g} % there"


def _tangent(solution: Solution) -> tuple[float, Floats]:
    """The derivatives of the expansion and of the coefficients in that of degree zero."""
    equations = solution.equations
    one = np.zeros(len(solution.shape.f))
    one[0] = 1.0
    rates = -equations.solved(replace(equations, free=False).applied(one))
    rate, rates[0] = float(rates[0]), 1.0
    return rate, rates
