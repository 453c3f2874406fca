"""Horizon finder: marginally outer trapped surfaces, and surfaces of constant expansion, in any slice."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from isoembed.errors import InvalidMetric, InvalidParameter, NoHorizon
from isoembed.relativity.horizons.ladder import (
    Rung,
    climbed,
    in_degree,
    is_symmetric,
    level_of,
    shape_apart,
)
from isoembed.relativity.horizons.newton import NoConvergence
from isoembed.relativity.horizons.search_places import Place, places_of
from isoembed.relativity.horizons.stability import principal_eigenvalue
from isoembed.relativity.horizons.surface_level import Equations
from isoembed.relativity.horizons.sweep import Sweep, leaf_of, swept
from isoembed.relativity.spacetimes.star_surface import StarSurface
from isoembed.relativity.spacetimes.surface_data import SurfaceData
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry
from isoembed.smooth.scattered_fit import deviating
from isoembed.smooth.transforms import resized
from isoembed.thresholds import threshold


@dataclass(frozen=True)
class FinderThresholds:
    """Thresholds of the horizon finder."""

    marginal: float = threshold(
        1e-9, "relative", "Stability eigenvalue above minus this that is not negative."
    )
    first: int = threshold(8, "count", "Degree in which a guess is looked at.")
    smaller: float = threshold(0.8, "relative", "First sphere over the one before, that was too large.")
    spheres: int = threshold(6, "count", "First spheres that are tried.")
    inside: float = threshold(0.98, "relative", "Mean radius just inside of a horizon over its own, at most.")
    together: float = threshold(0.9999, "relative", "The same, where an inner horizon is not told apart.")
    off: float = threshold(0.01, "radius", "Distance by which a surface may be off to be the one asked for.")


FINDER = FinderThresholds()


@dataclass(frozen=True, eq=False)
class FoundHorizon:
    """A surface of constant expansion in a slice; a marginally outer trapped surface where that is 0.

    Attributes
    ----------
    surface : StarSurface
        With what it may be off, for the errors of its data.
    geometry : ThreeGeometry
        The slice.
    expansion : float
        What was asked for: 0 for a horizon.
    residual : float
        The largest difference of the expansion from that, times the areal radius, at points that were not
        used to find it.
    stability : float
        The least eigenvalue of the stability operator, times the squared areal radius: 1 for a horizon of
        Schwarzschild.
    area : float
    iterations : int
        Newton's steps, in all degrees.
    notes : tuple of str
        What one should know.

    References
    ----------
    Andersson, Mars and Simon, Phys. Rev. Lett. 95 (2005) 111102, on the stability operator.
    """

    surface: StarSurface
    geometry: ThreeGeometry
    expansion: float
    residual: float
    stability: float
    area: float
    iterations: int
    notes: tuple[str, ...] = ()

    @property
    def degree(self) -> int:
        """The degree of the surface's harmonics."""
        return self.surface.harmonics.degree

    @property
    def outer(self) -> bool:
        """Whether it is stable, as outermost horizons are; an inner horizon is not."""
        return self.stability >= -FINDER.marginal

    @property
    def irreducible_mass(self) -> float:
        """The root of the area over 16 pi."""
        return float(np.sqrt(self.area / (16.0 * np.pi)))

    def data(self, axis: Sequence[float] | None = None, name: str = "") -> SurfaceData:
        """Data of which quasi-local energies are computed: see `StarSurface.data`."""
        data = self.surface.data(self.geometry, axis, self.expansion == 0.0, name)
        return replace(data, notes=(*data.notes, *self.notes))


def find_horizon(geometry: ThreeGeometry, guess: StarSurface | None = None) -> FoundHorizon:
    """Marginally outer trapped surface: the outermost one, or the one near a guess.

    Parameters
    ----------
    geometry : ThreeGeometry
        Any slice.
    guess : StarSurface, optional
        A surface near the one that is looked for, such as a sphere; if Newton's method does not lead from it
        to a horizon, surfaces of constant expansion do, one inside the other.  By default they begin at a
        large sphere around all black holes of a closed form, or at the largest one in a grid.

    Returns
    -------
    FoundHorizon
        If there are several outermost ones, the one of the largest area; a note says so.

    Raises
    ------
    NoHorizon
        None was found; the message says what ended the search.
    InvalidParameter
        The guess leaves the slice, or there is none and the slice does not say where to look.

    Notes
    -----
    Newton's method for the radius in spherical harmonics, with the exact linearization of the expansion; the
    degree grows until the expansion is zero to rounding, or to the error of the slice.

    Examples
    --------
    >>> from isoembed.relativity import BrillLindquist
    >>> horizon = find_horizon(BrillLindquist((0.5, 0.5), ((0, 0, 0.25), (0, 0, -0.25))))
    >>> round(horizon.irreducible_mass, 9), horizon.outer
    (0.998248418, True)
    """
    if guess is None:
        found = find_horizons(geometry)
        first = found[0]
        if len(found) == 1:
            return first
        others = ", ".join(f"{other.area:.6g}" for other in found[1:])
        note = (
            f"there are {len(found)} separate outermost horizons: this is the one of the largest area, "
            f"{first.area:.6g}; the others have {others}"
        )
        return replace(first, notes=(*first.notes, note))
    symmetric = is_symmetric(geometry, guess)
    fine = in_degree(guess, max(FINDER.first, guess.harmonics.degree), symmetric)
    level_of(geometry, fine).shape(fine.coefficients)  # refuses a guess that leaves the slice
    try:
        return _found(geometry, guess, 0.0, symmetric)
    except (NoConvergence, InvalidMetric, InvalidParameter):
        pass
    try:
        return _from_sweep(geometry, guess, symmetric)
    except (NoConvergence, InvalidMetric, InvalidParameter) as error:
        raise NoHorizon(f"no horizon was found from the guess: {error}") from None


def find_horizons(geometry: ThreeGeometry) -> tuple[FoundHorizon, ...]:
    """All outermost horizons around the black holes of a slice, the one of the largest area first.

    Where there is no common horizon of several holes they are parted at the widest gap, until there is.

    Parameters
    ----------
    geometry : ThreeGeometry

    Raises
    ------
    NoHorizon, InvalidParameter
        See `find_horizon`.
    """
    found: list[FoundHorizon] = []
    failures: list[NoHorizon] = []
    waiting = [places_of(geometry)]
    while waiting:
        place = waiting.pop()
        try:
            found.append(_around(geometry, place))
        except NoHorizon as failure:
            failures.append(failure)
            waiting.extend(place.parts)
    if not found:
        raise failures[0]
    return tuple(sorted(found, key=lambda horizon: -horizon.area))


def constant_expansion(geometry: ThreeGeometry, expansion: float, guess: StarSurface) -> FoundHorizon:
    """Surface of constant expansion, k - p = c, near a given one.

    Parameters
    ----------
    geometry : ThreeGeometry
    expansion : float
        c, in 1/length.
    guess : StarSurface

    Raises
    ------
    NoHorizon
        Newton's method does not lead to one.
    InvalidParameter
        The guess leaves the slice.

    Examples
    --------
    >>> from isoembed.relativity import PainleveGullstrand, StarSurface
    >>> near = constant_expansion(PainleveGullstrand(1.0), 0.01, StarSurface.sphere((0, 0, 0), 2.1))
    >>> abs(near.surface.mean_radius * 0.01 / 2 + (2 / near.surface.mean_radius) ** 0.5 - 1) < 1e-12
    True
    """
    symmetric = is_symmetric(geometry, guess)
    try:
        return _found(geometry, guess, expansion, symmetric)
    except (NoConvergence, InvalidMetric, InvalidParameter) as error:
        raise NoHorizon(
            f"no surface of expansion {expansion:.6g} was found near the guess: {error}"
        ) from None


def inner_horizon(outer: FoundHorizon) -> FoundHorizon:
    """Marginally outer trapped surface inside of another one that belongs to it.

    Between both the surfaces of constant expansion are trapped.  They approach each other, and vanish where
    the stability of both is zero, as two holes with a common horizon are moved apart.

    Parameters
    ----------
    outer : FoundHorizon
        A stable one.

    Raises
    ------
    NoHorizon
        None was found; the message says what ended the search.
    """
    geometry, surface = outer.geometry, outer.surface
    symmetric = is_symmetric(geometry, surface)
    try:
        trapped = _trapped(geometry, surface, symmetric)
        factor = trapped.mean_radius / surface.mean_radius
        sweep = swept(geometry, trapped, symmetric=symmetric, factor=factor)
        if sweep.horizon is None:
            raise NoConvergence(sweep.why)
        return _found(geometry, sweep.horizon, 0.0, symmetric)
    except (NoConvergence, InvalidMetric, InvalidParameter) as error:
        raise NoHorizon(f"there is no inner horizon where it was looked for: {error}") from None


def _trapped(geometry: ThreeGeometry, surface: StarSurface, symmetric: bool) -> StarSurface:
    """A surface of constant negative expansion a little inside of a horizon."""
    factor = FINDER.inside
    while factor < FINDER.together:
        smaller = replace(surface, coefficients=factor * surface.coefficients, deviations=None)
        leaf = leaf_of(geometry, smaller, symmetric=symmetric)
        if leaf.expansion < 0.0:
            return leaf.surface
        factor = float(np.sqrt(factor))
    raise NoConvergence("the surfaces of constant expansion just inside of it are not trapped")


def _around(geometry: ThreeGeometry, place: Place) -> FoundHorizon:
    """The outermost horizon inside of a large sphere."""
    radius = place.radius
    for _ in range(FINDER.spheres):
        start = StarSurface.sphere(place.center, radius)
        try:
            return _from_sweep(geometry, start, is_symmetric(geometry, start))
        except (NoConvergence, InvalidMetric, InvalidParameter) as error:
            why = str(error)
            radius *= FINDER.smaller
    raise NoHorizon(f"no surface of constant expansion was found near the sphere to begin with: {why}")


def _from_sweep(geometry: ThreeGeometry, start: StarSurface, symmetric: bool) -> FoundHorizon:
    sweep = swept(geometry, start, symmetric=symmetric)
    if sweep.horizon is None:
        raise NoHorizon(_least(sweep), sweep.least.fall)
    try:
        return _found(geometry, sweep.horizon, 0.0, symmetric)
    except (NoConvergence, InvalidMetric, InvalidParameter) as error:
        raise NoHorizon(f"the expansion falls below zero, but no horizon was found there: {error}") from None


def _least(sweep: Sweep) -> str:
    least = sweep.least
    center = ", ".join(f"{x:.4g}" for x in least.surface.center)
    return (
        "no horizon was found: of the surfaces of constant expansion c and areal radius R, from the first "
        f"one on, the least c R / 2 is {least.fall:.6g}, at R = {least.areal_radius:.6g} around ({center}), "
        f"and on a horizon it is 0; they ended because {sweep.why}"
    )


def _found(geometry: ThreeGeometry, start: StarSurface, expansion: float, symmetric: bool) -> FoundHorizon:
    """The surface near a guess, with what it may be off."""
    rung, steps, ended = climbed(geometry, start, expansion, symmetric=symmetric)
    shape = rung.solution.shape
    equations = rung.level.equations(shape)
    R = rung.level.areal_radius(shape)
    notes: tuple[str, ...] = ()
    if ended == "exhausted":
        notes = (
            f"in degree {rung.surface.harmonics.degree}, the highest, the expansion is still "
            f"{rung.residual:.2g} / R, R the areal radius",
        )
    surface = _uncertain(geometry, rung, equations, expansion)
    off = surface.misfit / surface.mean_radius
    if off > FINDER.off:
        raise NoConvergence(
            f"the expansion is still {rung.residual:.2g} / R, R the areal radius, in degree "
            f"{rung.surface.harmonics.degree}, and the slice may displace the surface by {100.0 * off:.2g} %"
        )
    return FoundHorizon(
        surface=surface,
        geometry=geometry,
        expansion=expansion,
        residual=rung.residual,
        stability=principal_eigenvalue(equations, R) * R * R,
        area=4.0 * np.pi * R * R,
        iterations=steps,
        notes=notes,
    )


def _uncertain(geometry: ThreeGeometry, rung: Rung, equations: Equations, expansion: float) -> StarSurface:
    """The surface with deviations: how far the slice's error and what is left of the expansion move it."""
    surface, shape = rung.surface, rung.solution.shape
    by_slice = equations.projected(rung.level.expansion_errors(shape)[:, None])[:, 0]
    level, apart = shape_apart(geometry, surface)
    left = level.equations(apart).projected((apart.local.expansion - expansion)[:, None])[:, 0]
    deviations = np.stack([equations.solved(by_slice), equations.solved(left)]) * np.sqrt(2.0)
    harmonics = surface.harmonics
    misfit = float(np.sqrt(np.mean(np.sum(deviations**2, axis=1)) / (4.0 * np.pi)))
    return replace(
        surface,
        misfit=misfit,
        deviations=resized(deviations.T, harmonics, deviating(harmonics)).T,
    )
