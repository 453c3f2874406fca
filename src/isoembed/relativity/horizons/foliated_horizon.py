"""Horizon found by a foliation with surfaces of constant expansion, and the evidence on larger horizons."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

from isoembed.errors import NoHorizon
from isoembed.evidence import Evidence
from isoembed.meshing.sphere import gauss_rule
from isoembed.relativity.horizons.foliation import Foliation, crossing, foliate, inside
from isoembed.relativity.horizons.found_horizon import FoundHorizon, horizon_near
from isoembed.relativity.horizons.newton import FAILURES
from isoembed.relativity.horizons.radial_image import is_symmetric
from isoembed.relativity.horizons.symmetry_axis import horizon_in_slice, symmetry_axis
from isoembed.relativity.spacetimes.star_surface import StarSurface
from isoembed.relativity.spacetimes.surface import Surface
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry

NODES = (16, 32)  # latitudes and longitudes of the nodes at which surfaces are checked


def foliated_horizon(geometry: ThreeGeometry, start: StarSurface) -> FoundHorizon:
    """Find a horizon by a foliation, in the frame that requires the fewest harmonics.

    Raises `NoConvergence`, `InvalidMetric` or `InvalidParameter`: there is no surface of constant expansion
    near the start; `NoHorizon`: the expansion does not change sign, or the horizon there is not resolved.
    """
    if is_symmetric(geometry, start):
        return _from_foliation(geometry, start, symmetric=True)
    frame = symmetry_axis(geometry, start)
    if frame is None:
        return _from_foliation(geometry, start, symmetric=False)
    sphere = StarSurface.sphere((0.0, 0.0, 0.0), start.mean_radius)
    return horizon_in_slice(_from_foliation(frame, sphere, symmetric=True), frame)


def _from_foliation(geometry: ThreeGeometry, start: StarSurface, *, symmetric: bool) -> FoundHorizon:
    """Find a horizon by a foliation in the given frame; see `foliated_horizon`."""
    foliation = foliate(geometry, start, symmetric=symmetric)
    if foliation.barriers is not None:
        return _between(geometry, foliation)
    if foliation.undecided:
        degenerate = _degenerate(geometry, foliation)
        if degenerate is not None:
            return degenerate
    raise _none(geometry, foliation)


def _between(geometry: ThreeGeometry, foliation: Foliation) -> FoundHorizon:
    """Stable horizon between barriers.

    Raises `NoHorizon`: it was not resolved; the message describes the barriers.
    """
    assert foliation.barriers is not None
    outer, inner = foliation.barriers
    for closeness in (1e-4, 1e-6, 1e-8):
        try:
            outer, inner, guess = crossing(geometry, outer, inner, closeness=closeness)
            horizon = horizon_near(geometry, guess, symmetric=guess.harmonics.order == 0)
        except FAILURES as error:
            why = str(error)
            continue
        if not horizon.outer:
            why = f"the horizon found is not stable, with the eigenvalue {horizon.stability:.3g} / R^2"
        elif not _is_between(horizon, foliation):
            why = "the horizon found does not lie between them"
        else:
            return replace(horizon, outermost=_outermost(foliation))
    outer, inner = foliation.barriers
    proved = inner.upper < 0.0 < outer.lower
    kind: Literal["proved", "searched"] = "proved" if proved else "searched"
    verdict = (
        "a horizon exists between two surfaces, but was not resolved"
        if proved
        else "the expansion seems to change sign between two surfaces, but by less than its error, and no "
        "horizon was resolved there"
    )
    raise NoHorizon(
        f"{verdict}: the outer one has areal radius {outer.areal_radius:.9g} and expansion "
        f"{outer.expansion:.3g}, the inner one {inner.areal_radius:.9g} and {inner.expansion:.3g}; {why}"
        f"{_below(coarse_grid(geometry, outer.surface))}",
        evidence=Evidence(kind, "barriers: a surface of negative expansion inside one of positive expansion"),
        barriers=(outer.surface, inner.surface),
    )


def _is_between(horizon: FoundHorizon, foliation: Foliation) -> bool:
    """Whether a horizon lies inside the leaves of positive expansion and outside the trapped leaves."""
    surface = horizon.surface
    assert isinstance(surface, StarSurface)
    return all(
        inside(surface, leaf.surface) if leaf.expansion > 0.0 else inside(leaf.surface, surface)
        for leaf in foliation.leaves
    )


def _outermost(foliation: Foliation) -> Evidence:
    """Evidence that no horizon inside the first leaf extends beyond the one found."""
    above = [leaf for leaf in foliation.leaves if leaf.expansion > 0.0]
    if foliation.leaves[0].expansion <= 0.0:
        return Evidence("searched", "surfaces of constant expansion from a trapped one outward")
    positive = "positive" if all(leaf.lower > 0.0 for leaf in above) else "positive in the mean"
    return Evidence(
        "searched",
        f"inside the surface of areal radius {above[0].areal_radius:.6g}: the expansion is {positive} on "
        f"{len(above)} surfaces, each inside the one before",
    )


def _degenerate(geometry: ThreeGeometry, foliation: Foliation) -> FoundHorizon | None:
    """Surface of least expansion as a horizon of zero stability, if the expansion is zero to rounding."""
    assert foliation.minimum is not None
    least = foliation.minimum.surface
    try:
        horizon = horizon_near(geometry, least, symmetric=least.harmonics.order == 0)
    except FAILURES:
        return None
    if horizon.residual > 1e-9 or abs(horizon.stability) > 1e-4:
        return None
    return replace(horizon, outermost=_outermost(foliation))


def coarse_grid(geometry: ThreeGeometry, surface: Surface) -> str:
    """Sentence on the resolution of a grid, if a surface is too small for it; otherwise empty."""
    minimum = geometry.least_diameter(surface.points(gauss_rule(*NODES)[0]))
    if (diameter := 2.0 * surface.mean_radius) >= minimum:
        return ""
    return (
        f"this surface has a diameter of {diameter:.3g} in coordinates, and the grid resolves horizons "
        f"of at least {minimum:.3g}: use a finer grid around the hole"
    )


def _below(sentence: str) -> str:
    """Sentence on a separate line below another one; empty for an empty sentence."""
    return f".\n{sentence[0].upper()}{sentence[1:]}" if sentence else ""


def _none(geometry: ThreeGeometry, foliation: Foliation) -> NoHorizon:
    """Exception for a foliation without a change of sign."""
    leaf = foliation.least
    center = ", ".join(f"{x:.4g}" for x in leaf.surface.center)
    error = 0.5 * foliation.minimum_error * leaf.areal_radius if foliation.excludes else None
    off = "" if error is None else f" +- {error:.1g}"
    evidence = Evidence(
        "searched",
        f"{len(foliation.leaves)} surfaces of constant expansion, of areal radius "
        f"{foliation.leaves[0].areal_radius:.6g} to {foliation.leaves[-1].areal_radius:.6g}",
    )
    at = f"at R = {leaf.areal_radius:.6g} around ({center})"
    # c R / 2 is 1 in flat space; a value below 0.5 indicates a hole.
    coarse = coarse_grid(geometry, leaf.surface) if leaf.normalized_expansion < 0.5 else ""
    return NoHorizon(
        "no horizon was found: among surfaces of constant expansion c and areal radius R, the least c R / 2 "
        f"is {leaf.normalized_expansion:.6g}{off}, {at}, and a horizon has 0; the search ended because "
        f"{foliation.end}{_below(coarse)}",
        leaf.normalized_expansion,
        evidence,
        error,
    )
