"""Horizon finder: marginally outer trapped surfaces, and surfaces of constant expansion, in any slice."""

from __future__ import annotations

from dataclasses import dataclass, replace

from isoembed.errors import InvalidMetric, InvalidParameter, NoHorizon
from isoembed.meshing.sphere import gauss_rule
from isoembed.relativity.horizons.found_horizon import FoundHorizon, mapped_horizon, star_horizon
from isoembed.relativity.horizons.ladder import is_symmetric
from isoembed.relativity.horizons.mapped_ladder import swept_mapped
from isoembed.relativity.horizons.newton import NoConvergence
from isoembed.relativity.horizons.search_places import Place, places_of
from isoembed.relativity.horizons.sheet import Sheet
from isoembed.relativity.horizons.sweep import Sweep, swept
from isoembed.relativity.spacetimes.star_surface import StarSurface
from isoembed.relativity.spacetimes.surface import Surface
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry
from isoembed.thresholds import threshold


@dataclass(frozen=True)
class FinderThresholds:
    """Thresholds of the horizon finder."""

    nodes: tuple[int, int] = threshold((16, 32), "count", "Heights and angles at which a guess is tried.")
    sheet: int = threshold(24, "count", "First degree of surfaces inside of a horizon.")
    smaller: float = threshold(0.8, "relative", "First sphere over the one before, that was too large.")
    spheres: int = threshold(6, "count", "First spheres that are tried.")


FINDER = FinderThresholds()


def find_horizon(geometry: ThreeGeometry, guess: Surface | None = None) -> FoundHorizon:
    """Marginally outer trapped surface: the outermost one, or the one near a guess.

    Parameters
    ----------
    geometry : ThreeGeometry
        Any slice.
    guess : StarSurface or MappedSurface, optional
        A surface near the one that is looked for, such as a sphere; if Newton's method does not lead from one
        that is star-shaped to a horizon, surfaces of constant expansion do, one inside the other.  By default
        they begin at a large sphere around all black holes of a closed form, or at the largest one in a grid.

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
    degree grows until the expansion is zero to rounding, or to the error of the slice.  From a mapped surface
    the displacement along its normals is sought instead, in coordinates that are made to fit.

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
    guess.expansion(geometry, gauss_rule(*FINDER.nodes)[0])  # refuses a guess that leaves the slice
    try:
        return _near(geometry, guess, 0.0)
    except (NoConvergence, InvalidMetric, InvalidParameter) as error:
        why = str(error)
    if isinstance(guess, StarSurface):
        try:
            return _from_sweep(geometry, guess, is_symmetric(geometry, guess))
        except (NoConvergence, InvalidMetric, InvalidParameter) as error:
            why = str(error)
    raise NoHorizon(f"no horizon was found from the guess: {why}")


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


def constant_expansion(geometry: ThreeGeometry, expansion: float, guess: Surface) -> FoundHorizon:
    """Surface of constant expansion, k - p = c, near a given one.

    Parameters
    ----------
    geometry : ThreeGeometry
    expansion : float
        c, in 1/length.
    guess : StarSurface or MappedSurface

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
    try:
        return _near(geometry, guess, expansion)
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
    try:
        start = Sheet.of(surface, FINDER.sheet, symmetric=is_symmetric(geometry, surface)).even()
        return mapped_horizon(geometry, swept_mapped(geometry, start), 0.0)
    except (NoConvergence, InvalidMetric, InvalidParameter) as error:
        raise NoHorizon(f"there is no inner horizon where it was looked for: {error}") from None


def _near(geometry: ThreeGeometry, guess: Surface, expansion: float) -> FoundHorizon:
    """The surface near a guess, by Newton's method alone."""
    symmetric = is_symmetric(geometry, guess)
    if isinstance(guess, StarSurface):
        return star_horizon(geometry, guess, expansion, symmetric=symmetric)
    return mapped_horizon(geometry, Sheet.of(guess, guess.harmonics.degree, symmetric=symmetric), expansion)


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
        return star_horizon(geometry, sweep.horizon, 0.0, symmetric=symmetric)
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
