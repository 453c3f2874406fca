"""Surfaces of constant expansion one inside the other, from a large sphere to the outermost horizon.

They are told apart by their mean radius, and the expansion c that belongs to it is found with each.  It is
2 / r on large spheres, grows, and falls to 0 at a horizon; ``c R / 2``, R the areal radius, falls from 1 to 0
in Schwarzschild.  Where there is no horizon it has a least value above 0.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from isoembed.arrays import Floats
from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.relativity.horizons.ladder import in_degree, level_of, recentered
from isoembed.relativity.horizons.newton import NoConvergence, Solution, solve
from isoembed.relativity.spacetimes.star_surface import StarSurface
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry
from isoembed.smooth.transforms import resized
from isoembed.thresholds import threshold


@dataclass(frozen=True)
class SweepThresholds:
    """Thresholds of the sweep through surfaces of constant expansion."""

    first: int = threshold(8, "count", "First degree of the surfaces.")
    highest: tuple[int, int] = threshold((48, 128), "count", "Highest degree, and with symmetry about z.")
    tail: float = threshold(1e-4, "mean radius", "Coefficients of high degree that ask for a higher one.")
    step: float = threshold(0.85, "relative", "Mean radius over the one before.")
    shortest: float = threshold(0.99, "relative", "Step beyond which it is not made smaller.")
    residual: float = threshold(1e-6, "radius", "Residual at which a surface on the way is good enough.")
    precise: float = threshold(1e-12, "radius", "Residual at which one of least expansion is.")
    smallest: float = threshold(1e-3, "first radius", "Mean radius at which the sweep ends.")
    turned: float = threshold(1.05, "relative", "Rise of c R / 2 over its least value that ends the sweep.")
    flat: float = threshold(1e-6, "relative", "Change of c R / 2 that is none.")
    settled: float = threshold(1e-11, "over the areal radius", "Change of the least expansion that is none.")
    noisy: float = threshold(0.01, "radius", "Displacement by the slice's error that is worth mentioning.")
    sign: float = threshold(0.1, "relative", "The same with which its sign is known.")
    near: float = threshold(0.3, "c R / 2", "Least value that is found in higher degrees.")
    apart: float = threshold(1e-3, "relative", "Difference of mean radii of which a rate is made.")
    refinements: int = threshold(20, "count", "Most steps to the least expansion in one degree.")


SWEEP = SweepThresholds()


@dataclass(frozen=True, eq=False)
class Leaf:
    """A surface of constant expansion of the sweep.

    Attributes
    ----------
    surface : StarSurface
    expansion : float
    areal_radius : float
    rate : float
        The derivative of the expansion in the coefficient of degree zero.
    tangent : ndarray
        That of all coefficients.
    noise : float
        See `isoembed.relativity.horizons.newton.Solution`.
    """

    surface: StarSurface
    expansion: float
    areal_radius: float
    rate: float
    tangent: Floats
    noise: float

    @property
    def fall(self) -> float:
        """``c R / 2``: 1 on a sphere in flat space, 0 on a horizon."""
        return 0.5 * self.expansion * self.areal_radius

    def moved(self, factor: float) -> StarSurface:
        """A guess of the surface whose mean radius is so many times as large."""
        f = self.surface.coefficients
        return StarSurface(
            self.surface.center, self.surface.harmonics, f + (factor - 1.0) * f[0] * self.tangent
        )


@dataclass(frozen=True, eq=False)
class Sweep:
    """What a sweep found.

    Attributes
    ----------
    horizon : StarSurface or None
        A guess of the surface of expansion 0.
    least : Leaf
        The surface of the least ``c R / 2``.
    why : str
        What ended the sweep without a horizon.
    """

    horizon: StarSurface | None
    least: Leaf
    why: str = ""


def swept(geometry: ThreeGeometry, start: StarSurface, *, symmetric: bool) -> Sweep:
    """Sweep from a surface inwards to a horizon, or outwards from a trapped one.

    Parameters
    ----------
    geometry : ThreeGeometry
    start : StarSurface
    symmetric : bool
        About z: slice and surface.

    Raises
    ------
    NoConvergence, InvalidMetric, InvalidParameter
        There is no surface of constant expansion as large as the first one.
    """
    start = in_degree(start, max(SWEEP.first, start.harmonics.degree), symmetric)
    leaves = [leaf_of(geometry, start, symmetric=symmetric)]
    least, trapped, factor = leaves[0], leaves[0].expansion <= 0.0, SWEEP.step
    largest = leaves[0].surface.mean_radius
    while True:
        last = leaves[-1]
        try:
            guess = last.moved(1.0 / factor if trapped else factor)
            leaf = leaf_of(geometry, recentered(guess, symmetric), symmetric=symmetric)
        except (NoConvergence, InvalidMetric, InvalidParameter) as error:
            factor = np.sqrt(factor)
            if factor > SWEEP.shortest or abs(last.fall) > abs(least.fall):
                return _ended(geometry, leaves, f"no smaller one was found: {error}{_noisy(last)}", symmetric)
            continue
        leaves.append(leaf)
        least = min(leaves, key=lambda leaf: abs(leaf.fall))
        if (leaf.expansion <= 0.0) != trapped:
            return Sweep(_crossing(last, leaf), leaf)
        factor = max(SWEEP.step, factor**1.5)
        if not trapped and abs(leaf.fall) > SWEEP.turned * abs(least.fall) and least is not leaves[0]:
            return _ended(geometry, leaves, "it grows again", symmetric)
        if not SWEEP.smallest < leaf.surface.mean_radius / largest < 1.0 / SWEEP.smallest:
            return _ended(geometry, leaves, "they have become as small as points", symmetric)


def leaf_of(
    geometry: ThreeGeometry, guess: StarSurface, *, symmetric: bool, enough: float = SWEEP.residual
) -> Leaf:
    """The surface of constant expansion with the mean radius of a given one near by.

    Raises
    ------
    NoConvergence, InvalidMetric, InvalidParameter
        See `isoembed.relativity.horizons.newton.solve`.
    """
    while True:
        level = level_of(geometry, guess)
        solution = solve(level, guess.coefficients, None, enough)
        f, harmonics = solution.shape.f, guess.harmonics
        high = harmonics.labels[0] > 0.75 * harmonics.degree
        tail = np.abs(f[high]).max() / f[0]
        if tail <= max(SWEEP.tail, solution.noise) or harmonics.degree >= SWEEP.highest[int(symmetric)]:
            break
        degree = min(SWEEP.highest[int(symmetric)], 3 * harmonics.degree // 2)
        guess = in_degree(StarSurface(guess.center, harmonics, f), degree, symmetric)
    rate, tangent = _tangent(solution)
    return Leaf(
        StarSurface(guess.center, harmonics, f),
        solution.expansion,
        level.areal_radius(solution.shape),
        rate,
        tangent,
        solution.noise,
    )


def least_expansion(geometry: ThreeGeometry, leaf: Leaf, *, symmetric: bool, settled: float) -> Leaf:
    """The surface of the least expansion of those near a given one.

    Parameters
    ----------
    geometry : ThreeGeometry
    leaf : Leaf
    symmetric : bool
        About z: slice and surface.
    settled : float
        Relative change of the least expansion with the degree that is none.

    Raises
    ------
    NoConvergence, InvalidMetric, InvalidParameter
        See `isoembed.relativity.horizons.newton.solve`.
    """
    highest = SWEEP.highest[int(symmetric)]
    while True:
        leaf = _minimized(geometry, leaf, symmetric)
        degree = leaf.surface.harmonics.degree
        if degree >= highest:
            return leaf
        finer = in_degree(leaf.surface, min(highest, 3 * degree // 2), symmetric)
        new = _minimized(
            geometry, leaf_of(geometry, finer, symmetric=symmetric, enough=SWEEP.precise), symmetric
        )
        if abs(new.expansion - leaf.expansion) <= settled * abs(new.expansion):
            return new
        leaf = new


def _minimized(geometry: ThreeGeometry, leaf: Leaf, symmetric: bool) -> Leaf:
    """Root of the rate of the expansion by the secant method, in one degree."""
    a = leaf
    b = leaf_of(geometry, a.moved(1.0 + SWEEP.apart), symmetric=symmetric, enough=SWEEP.precise)
    for _ in range(SWEEP.refinements):
        fa, fb = a.surface.coefficients[0], b.surface.coefficients[0]
        if a.rate == b.rate:
            break
        step = -b.rate * (fb - fa) / (b.rate - a.rate)
        step = float(np.clip(step, -0.1 * fb, 0.1 * fb))
        a, b = b, leaf_of(geometry, b.moved(1.0 + step / fb), symmetric=symmetric, enough=SWEEP.precise)
        if abs(step * b.rate) <= SWEEP.settled / b.areal_radius:
            break
    return b


def _ended(geometry: ThreeGeometry, leaves: list[Leaf], why: str, symmetric: bool) -> Sweep:
    """A sweep that met no horizon, unless the expansion is below zero between two surfaces."""
    least = min(leaves, key=lambda leaf: abs(leaf.fall))
    if 0.0 < least.fall < SWEEP.near and least is not leaves[0]:
        try:
            finer = least_expansion(geometry, least, symmetric=symmetric, settled=SWEEP.sign)
        except (NoConvergence, InvalidMetric, InvalidParameter):
            return Sweep(None, least, why)
        if finer.expansion <= 0.0:
            return Sweep(_outside(geometry, finer, symmetric), finer)
        least = finer
    return Sweep(None, least, why)


def _noisy(leaf: Leaf) -> str:
    if leaf.noise <= SWEEP.noisy:
        return ""
    return f"; the slice may displace the surface by {100.0 * leaf.noise:.2g} % there"


def _outside(geometry: ThreeGeometry, least: Leaf, symmetric: bool) -> StarSurface:
    """A guess of the surface of expansion 0 outside of one of the least expansion, which is negative."""
    larger = leaf_of(geometry, least.moved(1.0 + SWEEP.apart), symmetric=symmetric, enough=SWEEP.precise)
    curvature = (larger.rate - least.rate) / (SWEEP.apart * least.surface.coefficients[0])
    distance = np.sqrt(-2.0 * least.expansion / abs(curvature))
    return least.moved(1.0 + float(distance) / least.surface.coefficients[0])


def _crossing(a: Leaf, b: Leaf) -> StarSurface:
    """A guess of the surface of expansion 0 between two others."""
    part = a.expansion / (a.expansion - b.expansion)
    if a.surface.center != b.surface.center:
        return b.surface
    first = resized(a.surface.coefficients[:, None], a.surface.harmonics, b.surface.harmonics)[:, 0]
    f = (1.0 - part) * first + part * b.surface.coefficients
    return StarSurface(b.surface.center, b.surface.harmonics, f)


def _tangent(solution: Solution) -> tuple[float, Floats]:
    """The derivatives of the expansion and of the coefficients in that of degree zero."""
    equations = solution.equations
    one = np.zeros(len(solution.shape.f))
    one[0] = 1.0
    rates = -equations.solved(replace(equations, free=False).applied(one))
    rate, rates[0] = float(rates[0]), 1.0
    return rate, rates
