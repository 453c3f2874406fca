"""Horizon finder: marginally outer trapped surfaces, and the evidence that no other one encloses them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Literal

import numpy as np

from isoembed.errors import InvalidMetric, InvalidParameter, NoHorizon
from isoembed.evidence import Evidence
from isoembed.meshing.sphere import gauss_rule
from isoembed.relativity.horizons.foliation import Foliation, crossing, foliate, inside
from isoembed.relativity.horizons.found_horizon import FoundHorizon, horizon_near, refined_horizon
from isoembed.relativity.horizons.newton import NoConvergence
from isoembed.relativity.horizons.normal_image import foliated_inwards
from isoembed.relativity.horizons.radial_image import is_symmetric
from isoembed.relativity.horizons.symmetry_axis import symmetry_axis
from isoembed.relativity.spacetimes.checks import written
from isoembed.relativity.spacetimes.harmonic_map import HarmonicMap
from isoembed.relativity.spacetimes.star_surface import StarSurface
from isoembed.relativity.spacetimes.surface import Surface
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry, check_geometry

NODES = (16, 32)  # heights and angles at which a guess is tried
# First spheres, over the guess: small ones for grids and among holes, large ones around fast holes.
RADII = (1.0, 0.8, 0.64, 0.5, 0.4, 0.32, 2.0, 4.0, 8.0, 16.0, 32.0)
FAILURES = (NoConvergence, InvalidMetric, InvalidParameter)
"""Exceptions that end a search."""


def find_horizon(geometry: ThreeGeometry, guess: Surface | None = None) -> FoundHorizon:
    """Find the outermost marginally outer trapped surface, or the one near a guess.

    Parameters
    ----------
    geometry : ThreeGeometry
        Any slice.
    guess : StarSurface or MappedSurface, optional
        A surface near the one that is looked for, such as a sphere; if Newton's method does not lead from one
        that is star-shaped to a horizon, a foliation by surfaces of constant expansion does.  By default the
        foliation begins at a large sphere around all black holes of a closed form, or at the largest one in a
        grid.

    Returns
    -------
    FoundHorizon
        If there are several that no other one encloses, as far as was searched, the one of the largest area;
        a note says so.

    Raises
    ------
    NoHorizon
        None was found; the message says whether one exists, and what ended the search.
    InvalidParameter
        The guess leaves the slice, there is none and the slice does not say where to look, or the slice has
        no horizon in its coordinates: a `ThreeGeometry.hindrance`.

    Notes
    -----
    Newton's method for the radius in spherical harmonics, with the exact linearization of the expansion; the
    degree grows until the expansion is zero to rounding, or to the error of the slice.  From a mapped surface
    the displacement along its normals is sought instead, in coordinates that are made to fit.

    Leaves of the foliation are barriers, see `isoembed.relativity.horizons.foliation`: where the expansion
    changes sign there is a horizon.  `FoundHorizon.outermost` says what was searched for larger ones.

    Examples
    --------
    >>> from isoembed.relativity import BrillLindquist
    >>> horizon = find_horizon(BrillLindquist((0.5, 0.5), ((0, 0, 0.25), (0, 0, -0.25))))
    >>> round(horizon.irreducible_mass, 9), horizon.outer, horizon.outermost.kind
    (0.998248418, True, 'searched')
    """
    if guess is None:
        search = _search(geometry)
        first = search.horizons[0]
        if len(search.horizons) == 1:
            return first
        others = ", ".join(f"{other.area:.6g} around {_center(other)}" for other in search.horizons[1:])
        separate = "separate horizons" if search.separate else "horizons that were found"
        note = (
            f"this is the one of the largest area, {first.area:.6g} around {_center(first)}, of "
            f"{len(search.horizons)} {separate}; the others have {others}, and a guess there leads to them"
        )
        return replace(first, notes=(*first.notes, note))
    _check_guess(guess)
    _check_slice(geometry)
    guess.expansion(geometry, gauss_rule(*NODES)[0])  # refuses a guess that leaves the slice
    try:
        return horizon_near(geometry, guess)
    except FAILURES as error:
        why = str(error)
    if isinstance(guess, StarSurface):
        try:
            return replace(_foliated(geometry, guess), outermost=None)  # larger ones were not sought
        except FAILURES as error:
            why = str(error)
    raise NoHorizon(f"no horizon was found from the guess: {why}")


def find_horizons(geometry: ThreeGeometry) -> tuple[FoundHorizon, ...]:
    """All horizons around the black holes of a slice that no other one encloses, the largest area first.

    Where no common horizon of all holes is found, those of fewer holes are looked for, group by group.

    Parameters
    ----------
    geometry : ThreeGeometry

    Raises
    ------
    NoHorizon, InvalidParameter
        See `find_horizon`.
    """
    return _search(geometry).horizons


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
    _check_guess(guess)
    check_geometry(geometry)
    try:
        return horizon_near(geometry, guess, expansion)
    except FAILURES as error:
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
        # First degree of surfaces inside a horizon.
        start = HarmonicMap.projected(surface, 24, symmetric=is_symmetric(geometry, surface))
        inner = refined_horizon(geometry, foliated_inwards(geometry, start.reparametrized()))
    except FAILURES as error:
        raise NoHorizon(f"no inner horizon was found where it was looked for: {error}") from None
    if inner.outer:  # Newton's method may lead back to the one outside
        raise NoHorizon(
            "no inner horizon was found where it was looked for: the one that was found there, of area "
            f"{inner.area:.6g}, is stable, with the eigenvalue {inner.stability:.3g} / R^2"
        )
    return inner


@dataclass(frozen=True, eq=False)
class _Search:
    """Result of the search for the horizons of a slice.

    Attributes
    ----------
    horizons : tuple of FoundHorizon
        The largest area first.
    separate : bool
        Whether all groups of holes were tried, and each search for a common horizon ended at a least
        expansion above its error.
    """

    horizons: tuple[FoundHorizon, ...]
    separate: bool


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


def _search(geometry: ThreeGeometry) -> _Search:
    """The horizons around groups of holes, the largest groups first."""
    _check_slice(geometry)
    found: list[tuple[frozenset[int], FoundHorizon]] = []  # with the holes inside
    failures: list[tuple[Place, NoHorizon]] = []
    places = list(_places(geometry))
    for place in places:
        if any(place.holes & taken for taken, _ in found):
            continue
        try:
            horizon = _inside_sphere(geometry, place)
        except NoHorizon as failure:
            if failure.barriers is not None:
                raise
            failures.append((place, failure))
            continue
        # A search that begins around some holes may end at the horizon that they have in common with others.
        holes = place.holes | _holes_inside(geometry, horizon.surface)
        found = [(others, other) for others, other in found if not others <= holes] + [(holes, horizon)]
    if not found:
        raise failures[0][1]
    n = len(places[0].holes)
    horizons, separate = [], sum(len(place.holes) > 1 for place in places) >= 2**n - n - 1
    for holes, horizon in found:
        around = [failure for other, failure in failures if holes < other.holes]
        separate &= all(failure.least_error is not None for failure in around)
        horizons.append(_within(horizon, around))
    alone = {i for place in places for i in place.holes}.difference(*(holes for holes, _ in found))
    if alone:
        at = ", ".join(str(i) for i in sorted(alone))
        note = f"no horizon was found around the black holes {at}, by their place in the slice's list"
        horizons = [replace(horizon, notes=(*horizon.notes, note)) for horizon in horizons]
    return _Search(tuple(sorted(horizons, key=lambda horizon: -horizon.area)), separate)


def _holes_inside(geometry: ThreeGeometry, surface: Surface) -> frozenset[int]:
    """The black holes inside a surface, by their place in the slice's list: its solid angle there is 4 pi."""
    n, order = surface.harmonics.degree + NODES[0], surface.harmonics.order
    u, weights = gauss_rule(n, 2 * (order + NODES[0]))
    jet = surface.jet(u)
    normals = np.cross(jet.first[:, 0], jet.first[:, 1])
    inside = []
    for i, (_, position) in enumerate(geometry.black_holes):
        away = jet.x - np.array(position)
        flux = np.einsum("ni,ni->n", away, normals) / np.linalg.norm(away, axis=1) ** 3
        if abs(weights @ flux) > 2.0 * np.pi:
            inside.append(i)
    return frozenset(inside)


def _within(horizon: FoundHorizon, around: list[NoHorizon]) -> FoundHorizon:
    """A horizon with the evidence that no larger one encloses it, from searches that found none."""
    if not around:
        return horizon
    unknown = [failure for failure in around if failure.least_error is None]
    if unknown:
        sentence = f"it is not known whether a larger horizon encloses this one: {unknown[0]}"
        return replace(horizon, outermost=Evidence("searched", sentence), notes=(*horizon.notes, sentence))
    least = min(around, key=lambda failure: failure.least or 0.0)
    basis = (
        "the surfaces of constant expansion around more holes reach a least c R / 2 above zero: "
        f"{least.least:.6g} +- {least.least_error:.1g}"
    )
    return replace(horizon, outermost=Evidence("searched", basis))


def _inside_sphere(geometry: ThreeGeometry, place: Place) -> FoundHorizon:
    """The horizon inside a large sphere around the holes of a place."""
    why = "none of the spheres encloses all holes"
    at = [position for _, position in geometry.black_holes]
    extent = max((math.dist(at[i], place.center) for i in place.holes), default=0.0)
    for factor in RADII:
        if factor * place.radius <= extent:
            continue
        start = StarSurface.sphere(place.center, factor * place.radius)
        try:
            return _foliated(geometry, start)
        except FAILURES as error:
            why = str(error)
    raise NoHorizon(f"no surface of constant expansion was found near the sphere to begin with: {why}")


def _foliated(geometry: ThreeGeometry, start: StarSurface) -> FoundHorizon:
    """The horizon to which a foliation leads, in a frame where it needs the fewest harmonics.

    Raises `NoConvergence`, `InvalidMetric` or `InvalidParameter`: there is no surface of constant expansion
    near the first one; `NoHorizon`: there is no change of sign, or the horizon beside it is not resolved.
    """
    if is_symmetric(geometry, start):
        return _from_foliation(geometry, start, True)
    axis = symmetry_axis(geometry, start)
    if axis is None:
        return _from_foliation(geometry, start, False)
    return axis.horizon(
        _from_foliation(axis.frame, StarSurface.sphere((0.0, 0.0, 0.0), start.mean_radius), True)
    )


def _from_foliation(geometry: ThreeGeometry, start: StarSurface, symmetric: bool) -> FoundHorizon:
    """The horizon to which a foliation leads, in the given frame; see `_foliated`."""
    foliation = foliate(geometry, start, symmetric=symmetric)
    if foliation.barriers is not None:
        return _between(geometry, foliation, symmetric)
    if foliation.undecided:
        degenerate = _degenerate(geometry, foliation, symmetric)
        if degenerate is not None:
            return degenerate
    raise _none(geometry, foliation)


def _between(geometry: ThreeGeometry, foliation: Foliation, symmetric: bool) -> FoundHorizon:
    """The stable horizon between barriers, which exists.

    Raises `NoHorizon`: it was not resolved; the message names the barriers.
    """
    assert foliation.barriers is not None
    outer, inner = foliation.barriers
    for closeness in (1e-4, 1e-6, 1e-8):
        try:
            outer, inner, guess = crossing(geometry, outer, inner, symmetric=symmetric, closeness=closeness)
            horizon = horizon_near(geometry, guess, symmetric=symmetric)
        except FAILURES as error:
            why = str(error)
            continue
        if not horizon.outer:
            why = f"the one that was found is not stable, with the eigenvalue {horizon.stability:.3g} / R^2"
        elif not _is_between(horizon, foliation):
            why = "the one that was found does not lie between them"
        else:
            return replace(horizon, outermost=_outermost(foliation))
    outer, inner = foliation.barriers
    proved = inner.greatest < 0.0 < outer.least
    kind: Literal["proved", "searched"] = "proved" if proved else "searched"
    verdict = (
        "a horizon exists between two surfaces, and no horizon was resolved there"
        if proved
        else "the expansion seems to change sign between two surfaces, but by less than its error, and no "
        "horizon was resolved there"
    )
    raise NoHorizon(
        f"{verdict}: the outer one has areal radius {outer.areal_radius:.9g} and expansion "
        f"{outer.expansion:.3g}, the inner one {inner.areal_radius:.9g} and {inner.expansion:.3g}; {why}"
        f"{_too_coarse(geometry, outer.surface)}",
        evidence=Evidence(kind, "barriers: a surface of negative expansion inside one of positive expansion"),
        barriers=(outer.surface, inner.surface),
    )


def _is_between(horizon: FoundHorizon, foliation: Foliation) -> bool:
    """Whether a horizon lies inside the leaves of positive expansion, and around the trapped ones."""
    surface = horizon.surface
    assert isinstance(surface, StarSurface)
    return all(
        inside(surface, leaf.surface) if leaf.expansion > 0.0 else inside(leaf.surface, surface)
        for leaf in foliation.leaves
    )


def _outermost(foliation: Foliation) -> Evidence:
    """The evidence that no horizon in the first leaf reaches outside of the one that was found."""
    above = [leaf for leaf in foliation.leaves if leaf.expansion > 0.0]
    if foliation.leaves[0].expansion <= 0.0:
        return Evidence("searched", "surfaces of constant expansion from a trapped one outward")
    positive = "positive" if all(leaf.least > 0.0 for leaf in above) else "positive in the mean"
    return Evidence(
        "searched",
        f"inside the surface of areal radius {above[0].areal_radius:.6g}: the expansion is {positive} on "
        f"{len(above)} surfaces, each inside the one before",
    )


def _degenerate(geometry: ThreeGeometry, foliation: Foliation, symmetric: bool) -> FoundHorizon | None:
    """The surface of least expansion, where that is zero to rounding: a horizon of stability zero."""
    assert foliation.minimum is not None
    try:
        horizon = horizon_near(geometry, foliation.minimum.surface, symmetric=symmetric)
    except FAILURES:
        return None
    if horizon.residual > 1e-9 or abs(horizon.stability) > 1e-4:
        return None
    return replace(horizon, outermost=_outermost(foliation))


def _too_coarse(geometry: ThreeGeometry, surface: Surface) -> str:
    """A sentence on the grid of a slice, where a surface is small for it."""
    least = geometry.least_diameter(surface.points(gauss_rule(*NODES)[0]))
    if (diameter := 2.0 * surface.mean_radius) >= least:
        return ""
    return (
        f".\nThis surface has a diameter of {diameter:.3g} in coordinates, and the grid resolves horizons "
        f"of at least {least:.3g}: use a finer grid around the hole"
    )


def _none(geometry: ThreeGeometry, foliation: Foliation) -> NoHorizon:
    """The error for a foliation without a change of sign."""
    least = foliation.least
    center = ", ".join(f"{x:.4g}" for x in least.surface.center)
    error = 0.5 * foliation.minimum_error * least.areal_radius if foliation.excludes else None
    off = "" if error is None else f" +- {error:.1g}"
    evidence = Evidence(
        "searched",
        f"{len(foliation.leaves)} surfaces of constant expansion, of areal radius "
        f"{foliation.leaves[0].areal_radius:.6g} to {foliation.leaves[-1].areal_radius:.6g}",
    )
    at = f"at R = {least.areal_radius:.6g} around ({center})"
    # It is 1 in flat space: there is a hole.
    coarse = _too_coarse(geometry, least.surface) if least.normalized_expansion < 0.5 else ""
    return NoHorizon(
        "no horizon was found: among surfaces of constant expansion c and areal radius R, the least c R / 2 "
        f"is {least.normalized_expansion:.6g}{off}, {at}, and a horizon has 0; the search ended because "
        f"{foliation.end}{coarse}",
        least.normalized_expansion,
        evidence,
        error,
    )


@dataclass(frozen=True)
class Place:
    """A sphere around black holes.

    Attributes
    ----------
    center : three floats
    radius : float
    holes : frozenset of int
        Their indices; empty for a sphere in a grid.
    """

    center: tuple[float, float, float]
    radius: float
    holes: frozenset[int] = frozenset()


def _places(geometry: ThreeGeometry) -> Iterator[Place]:
    """Spheres around all that there is in a slice, and around groups of its holes, the largest first.

    Groups whose sphere reaches another hole are left out, as are those of holes further apart than twice
    their mass: in Brill-Lindquist's slices a common horizon ends at .77 of it.  Raises `InvalidParameter`:
    the slice does not say where its holes are.
    """
    holes, box = geometry.black_holes, geometry.box
    if not holes and box is not None:
        low, high = np.asarray(box, dtype=np.float64)
        x, y, z = (0.5 * (low + high)).tolist()
        yield Place((x, y, z), 0.9 * 0.5 * float((high - low).min()))  # room to the edge of the grid
        return
    if not holes:
        raise InvalidParameter(
            "the slice does not say where its black holes are: use find_horizon(geometry, guess) with a "
            "guess for each, such as StarSurface.sphere(center, radius); a class of your own may define "
            "black_holes or box"
        )
    everything = frozenset(range(len(holes)))
    # More holes have too many groups to try all of them.
    sizes = range(len(holes) - 1, 0, -1) if len(holes) <= 8 else (1,)
    groups = [everything]
    groups += [frozenset(group) for size in sizes for group in combinations(sorted(everything), size)]
    for group in groups:
        place = _around(holes, group)
        if place is not None:
            yield place


def _around(holes: Sequence[tuple[float, Sequence[float]]], group: frozenset[int]) -> Place | None:
    """A sphere around some holes, as far from the others as it can be."""
    masses = np.array([holes[i][0] for i in sorted(group)])
    at = np.array([holes[i][1] for i in sorted(group)], dtype=float)
    center = masses @ at / masses.sum()
    extent = float(np.linalg.norm(at - center, axis=1).max())
    others = [holes[i][1] for i in range(len(holes)) if i not in group]
    room = min((float(np.linalg.norm(center - other)) for other in others), default=np.inf) - extent
    apart = others and len(group) > 1 and not _linked(masses, at)
    if room <= 0.0 or apart:
        return None
    # Three masses beyond the outermost hole, but less than halfway to the nearest hole outside.
    radius = extent + min(3.0 * float(masses.sum()) + extent, 0.45 * room)
    x, y, z = center.tolist()
    return Place((x, y, z), radius, group)


def _linked(masses: np.ndarray, at: np.ndarray) -> bool:
    """Whether the holes are connected by distances of at most twice their total mass."""
    # Holes that are farther apart than twice their mass have no common horizon.
    near = np.linalg.norm(at[:, None] - at[None], axis=2) <= 2.0 * masses.sum()
    reached = near[0]
    for _ in at:
        reached = near[reached].any(axis=0)
    return bool(reached.all())
