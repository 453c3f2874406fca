"""Horizon finder: marginally outer trapped surfaces, and the evidence that they are outermost."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from isoembed.errors import InvalidParameter, NoHorizon
from isoembed.evidence import Evidence
from isoembed.meshing.sphere import gauss_rule
from isoembed.relativity.horizons.foliated_horizon import NODES, foliated_horizon
from isoembed.relativity.horizons.found_horizon import FoundHorizon, horizon_near, refined_horizon
from isoembed.relativity.horizons.hole_groups import HoleGroup, hole_groups, holes_inside
from isoembed.relativity.horizons.inner_foliation import foliated_inwards
from isoembed.relativity.horizons.newton import FAILURES
from isoembed.relativity.horizons.radial_image import is_symmetric
from isoembed.relativity.spacetimes.checks import written
from isoembed.relativity.spacetimes.harmonic_map import HarmonicMap
from isoembed.relativity.spacetimes.star_surface import StarSurface
from isoembed.relativity.spacetimes.surface import Surface
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry, check_geometry


def find_horizon(geometry: ThreeGeometry, guess: Surface | None = None) -> FoundHorizon:
    """Find the outermost marginally outer trapped surface, or the one near a guess.

    Parameters
    ----------
    geometry : ThreeGeometry
        Slice.
    guess : StarSurface or MappedSurface, optional
        Initial guess, such as a sphere.  If Newton's method does not converge from a star-shaped guess, a
        foliation by surfaces of constant expansion starts there.  By default it starts from a large sphere
        around all black holes of a closed-form slice, or from the largest one in a grid.

    Returns
    -------
    FoundHorizon
        The horizon of largest area if the search finds several outermost ones, with a note.

    Raises
    ------
    NoHorizon
        None was found; the message says whether one exists, and why the search ended.
    InvalidParameter
        The guess leaves the slice, there is no guess and the slice does not name its black holes or box, or
        the slice has no horizon in its coordinates; see `ThreeGeometry.hindrance`.

    Notes
    -----
    Newton's method solves for the radius in spherical harmonics, with the exact linearization of the
    expansion.  The degree is raised until the expansion is zero to rounding, or to the error of the slice.
    For a mapped surface, the unknown is the displacement along its normals, in adapted coordinates.

    Leaves of the foliation are barriers (see `isoembed.relativity.horizons.foliation`): there is a horizon
    between leaves of opposite sign.  `FoundHorizon.outermost` describes the search for larger horizons.

    Examples
    --------
    >>> from isoembed.relativity import BrillLindquist
    >>> horizon = find_horizon(BrillLindquist((0.5, 0.5), ((0, 0, 0.25), (0, 0, -0.25))))
    >>> round(horizon.irreducible_mass, 9), horizon.outer, horizon.outermost.kind
    (0.998248418, True, 'searched')
    """
    if guess is None:
        (first, *others), separate = _search(geometry)
        if not others:
            return first
        areas = ", ".join(f"{other.area:.6g} around {_center(other)}" for other in others)
        kind = "separate horizons" if separate else "horizons that were found"
        note = (
            f"this one has the largest area, {first.area:.6g} around {_center(first)}, of "
            f"{1 + len(others)} {kind}; the others have {areas}, and can be found from a guess there"
        )
        return replace(first, notes=(*first.notes, note))
    _check_guess(guess)
    _check_slice(geometry)
    guess.expansion(geometry, gauss_rule(*NODES)[0])  # raises if the guess leaves the slice
    try:
        return horizon_near(geometry, guess)
    except FAILURES as error:
        why = str(error)
    if isinstance(guess, StarSurface):
        try:
            return replace(foliated_horizon(geometry, guess), outermost=None)  # larger ones were not sought
        except FAILURES as error:
            why = str(error)
    raise NoHorizon(f"no horizon was found from the guess, which may enclose none: {why}")


def find_horizons(geometry: ThreeGeometry) -> tuple[FoundHorizon, ...]:
    """Find all outermost horizons around the black holes of a slice, in order of decreasing area.

    If no common horizon of all holes is found, smaller groups of holes are searched one by one.

    Parameters
    ----------
    geometry : ThreeGeometry

    Raises
    ------
    NoHorizon, InvalidParameter
        See `find_horizon`.
    """
    return _search(geometry)[0]


def constant_expansion(geometry: ThreeGeometry, expansion: float, guess: Surface) -> FoundHorizon:
    """Find a surface of constant expansion, k - p = c, near a given surface.

    Parameters
    ----------
    geometry : ThreeGeometry
    expansion : float
        Expansion c, in 1/length.
    guess : StarSurface or MappedSurface

    Raises
    ------
    NoHorizon
        Newton's method does not converge.
    InvalidParameter
        The guess leaves the slice.

    Examples
    --------
    >>> from isoembed.relativity import PainleveGullstrand, StarSurface
    >>> near = constant_expansion(PainleveGullstrand(1.0), 0.01, StarSurface.sphere((0, 0, 0), 2.1))
    >>> abs(near.surface.mean_radius * 0.01 / 2 + (2 / near.surface.mean_radius) ** 0.5 - 1) < 1e-12
    True
    """
    _check_guess(guess)
    check_geometry(geometry)
    try:
        return horizon_near(geometry, guess, expansion)
    except FAILURES as error:
        raise NoHorizon(
            f"no surface of expansion {expansion:.6g} was found near the guess: {error}"
        ) from None


def inner_horizon(outer: FoundHorizon) -> FoundHorizon:
    """Find the unstable inner horizon that belongs to an outer one.

    The surfaces of constant expansion between the two are trapped.  As two holes with a common horizon are
    moved apart, the two horizons approach each other and annihilate where the stability of both is zero.

    Parameters
    ----------
    outer : FoundHorizon
        Stable horizon.

    Raises
    ------
    NoHorizon
        None was found; the message says why the search ended.
    """
    geometry, surface = outer.geometry, outer.surface
    try:
        # Initial degree of surfaces inside a horizon.
        start = HarmonicMap.projected(surface, 24, symmetric=is_symmetric(geometry, surface))
        inner = refined_horizon(geometry, foliated_inwards(geometry, start.reparametrized()))
    except FAILURES as error:
        raise NoHorizon(f"no inner horizon was found in the searched region: {error}") from None
    if inner.outer:  # Newton's method may converge to the outer horizon
        raise NoHorizon(
            "no inner horizon was found in the searched region: the horizon found there, of area "
            f"{inner.area:.6g}, is stable, with the eigenvalue {inner.stability:.3g} / R^2"
        )
    return inner


def _center(horizon: FoundHorizon) -> str:
    return written(np.array(horizon.surface.center))


def _check_guess(guess: object) -> None:
    if not isinstance(guess, Surface):
        raise InvalidParameter(
            f"the guess is a {type(guess).__name__}, not a surface such as StarSurface.sphere(center, radius)"
        )


def _check_slice(geometry: ThreeGeometry) -> None:
    check_geometry(geometry)
    if geometry.hindrance:
        raise InvalidParameter(geometry.hindrance)


def _search(geometry: ThreeGeometry) -> tuple[tuple[FoundHorizon, ...], bool]:
    """Horizons around groups of holes, of decreasing area, searched from the largest group to the smallest.

    Also whether they are known to be separate: all groups of holes were tried, and each search for a common
    horizon ended with a least expansion larger than its error.
    """
    _check_slice(geometry)
    found: list[tuple[frozenset[int], FoundHorizon]] = []  # with the holes inside
    failures: list[tuple[HoleGroup, NoHorizon]] = []
    groups = list(hole_groups(geometry))
    for group in groups:
        if any(group.holes & earlier for earlier, _ in found):
            continue
        try:
            horizon = _inside_sphere(geometry, group)
        except NoHorizon as failure:
            if failure.barriers is not None:
                raise
            failures.append((group, failure))
            continue
        # A search around some holes may find their common horizon with others.
        holes = group.holes | holes_inside(geometry, horizon.surface)
        found = [(others, other) for others, other in found if not others <= holes] + [(holes, horizon)]
    if not found:
        raise failures[0][1]
    n = len(groups[0].holes)
    horizons, separate = [], sum(len(group.holes) > 1 for group in groups) >= 2**n - n - 1
    for holes, horizon in found:
        around = [failure for other, failure in failures if holes < other.holes]
        separate &= all(failure.least_error is not None for failure in around)
        horizons.append(_within(horizon, around))
    alone = {i for group in groups for i in group.holes}.difference(*(holes for holes, _ in found))
    if alone:
        at = ", ".join(str(i) for i in sorted(alone))
        note = f"no horizon was found around the black holes {at}, by their place in the slice's list"
        horizons = [replace(horizon, notes=(*horizon.notes, note)) for horizon in horizons]
    return tuple(sorted(horizons, key=lambda horizon: -horizon.area)), separate


def _within(horizon: FoundHorizon, around: list[NoHorizon]) -> FoundHorizon:
    """Horizon with the evidence from unsuccessful searches that no larger one encloses it."""
    if not around:
        return horizon
    unknown = [failure for failure in around if failure.least_error is None]
    if unknown:
        sentence = f"it is not known whether a larger horizon encloses this one: {unknown[0]}"
        return replace(horizon, outermost=Evidence("searched", sentence), notes=(*horizon.notes, sentence))
    lowest = min(around, key=lambda failure: failure.least or 0.0)
    basis = (
        "the surfaces of constant expansion around more holes reach a least c R / 2 above zero: "
        f"{lowest.least:.6g} +- {lowest.least_error:.1g}"
    )
    return replace(horizon, outermost=Evidence("searched", basis))


def _inside_sphere(geometry: ThreeGeometry, group: HoleGroup) -> FoundHorizon:
    """Horizon inside a large sphere around the holes of a group."""
    why = "none of the spheres encloses all holes"
    at = [position for _, position in geometry.black_holes]
    extent = max((math.dist(at[i], group.center) for i in group.holes), default=0.0)
    # Small spheres are for grids and between holes, large ones for fast holes.
    for factor in (1.0, 0.8, 0.64, 0.5, 0.4, 0.32, 2.0, 4.0, 8.0, 16.0, 32.0):
        if factor * group.radius <= extent:
            continue
        start = StarSurface.sphere(group.center, factor * group.radius)
        try:
            return foliated_horizon(geometry, start)
        except FAILURES as error:
            why = str(error)
    raise NoHorizon(f"no surface of constant expansion was found near the starting sphere: {why}")
