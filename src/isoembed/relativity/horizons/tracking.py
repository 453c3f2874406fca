"""Horizon tracking: outermost horizons of a sequence of slices, continued from slice to slice."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

from isoembed.errors import NoHorizon
from isoembed.evidence import Evidence
from isoembed.relativity.horizons.finder import find_horizons
from isoembed.relativity.horizons.foliation import inside
from isoembed.relativity.horizons.found_horizon import FoundHorizon, horizon_near
from isoembed.relativity.horizons.newton import FAILURES
from isoembed.relativity.horizons.radial_image import is_symmetric
from isoembed.relativity.horizons.symmetry_axis import averaged, horizon_in_slice, symmetry_axis
from isoembed.relativity.spacetimes.star_surface import StarSurface
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry


@dataclass(frozen=True)
class TrackedHorizons:
    """Horizons of one slice of a sequence.

    Attributes
    ----------
    horizons : tuple of FoundHorizon
        Outermost horizons, in order of decreasing area; empty if none was found.  A note marks a horizon that
        does not continue one of the previous slice, so that the area may be discontinuous.
    continued : tuple of int or None
        Index of the horizon in the previous slice that each of them continues.
    failure : NoHorizon or None
        Exception of the search in this slice alone, if no horizon was found.
    """

    horizons: tuple[FoundHorizon, ...]
    continued: tuple[int | None, ...]
    failure: NoHorizon | None = None


def track_horizons(slices: Iterable[ThreeGeometry]) -> Iterator[TrackedHorizons]:
    """Find the outermost horizons of a sequence of slices, such as an evolution.

    Each slice is searched separately with `isoembed.relativity.find_horizons`, and the horizons of the
    previous slice are continued by Newton's method.  A continued horizon replaces those of the search that it
    encloses.  If the outermost horizon does not continue one of the previous slice, for example where a
    common horizon appears, its area may be discontinuous, and a note says so.

    Parameters
    ----------
    slices : iterable of ThreeGeometry
        Slices, close enough to each other for Newton's method.

    Yields
    ------
    TrackedHorizons
        One for each slice.

    Raises
    ------
    InvalidParameter
        A slice does not name its black holes or box.

    Examples
    --------
    >>> from isoembed.relativity import BrillLindquist
    >>> slices = (BrillLindquist((0.5, 0.5), ((0, 0, z), (0, 0, -z))) for z in (0.5, 0.38, 0.37))
    >>> [(len(found.horizons), found.continued) for found in track_horizons(slices)]
    [(2, (None, None)), (1, (None,)), (1, (0,))]
    """
    before: TrackedHorizons | None = None
    for geometry in slices:
        searched: tuple[FoundHorizon, ...] = ()
        failure = None
        try:
            searched = find_horizons(geometry)
        except NoHorizon as error:
            failure = error
        if before is None:
            before = TrackedHorizons(searched, (None,) * len(searched), failure)
        else:
            before = _joined(before.horizons, geometry, searched, failure)
        yield before


def _joined(
    before: tuple[FoundHorizon, ...],
    geometry: ThreeGeometry,
    searched: tuple[FoundHorizon, ...],
    failure: NoHorizon | None,
) -> TrackedHorizons:
    """Horizons of the search and those continued from the previous slice, without enclosed ones."""
    found: list[tuple[FoundHorizon, int | None]] = [(horizon, None) for horizon in searched]
    followed = [_continued(geometry, horizon) for horizon in before]
    for index, horizon in enumerate(followed):
        if horizon is None:
            continue
        same = next((k for k, (other, _) in enumerate(found) if _is_same(horizon, other)), None)
        if same is None:
            found.append((horizon, index))
        elif found[same][1] is None:
            found[same] = found[same][0], index
    outermost = [
        (horizon, index)
        for horizon, index in found
        if not any(_encloses(other, horizon) and other.area > horizon.area for other, _ in found)
    ]
    outermost.sort(key=lambda pair: -pair[0].area)
    horizons = []
    for horizon, before_it in outermost:
        if before_it is None and before:
            areas = ", ".join(f"{other.area:.6g}" for other in before)
            note = (
                f"Newton's method leads to this horizon, of area {horizon.area:.6g}, from none of the slice "
                f"before (of area {areas}): its area may be discontinuous"
            )
            horizon = replace(horizon, notes=(*horizon.notes, note))
        elif not any(horizon is other for other in searched):
            note = "continued from the slice before: the search of this slice alone did not find it"
            horizon = replace(horizon, notes=(*horizon.notes, note), outermost=Evidence("searched", note))
        horizons.append(horizon)
    return TrackedHorizons(
        tuple(horizons), tuple(index for _, index in outermost), None if horizons else failure
    )


def _continued(geometry: ThreeGeometry, before: FoundHorizon) -> FoundHorizon | None:
    """Stable horizon near one of the previous slice, or None if Newton's method does not find it."""
    surface = before.surface
    try:
        symmetric, frame = is_symmetric(geometry, surface), None
        if isinstance(surface, StarSurface) and not symmetric:
            frame = symmetry_axis(geometry, StarSurface.sphere(surface.center, surface.mean_radius))
        if frame is None:
            horizon = horizon_near(geometry, surface, symmetric=symmetric)
        else:
            assert isinstance(surface, StarSurface)
            horizon = horizon_near(frame, averaged(surface, frame), symmetric=True)
            horizon = horizon_in_slice(horizon, frame)
    except FAILURES:
        return None
    return horizon if horizon.outer else None


def _is_same(one: FoundHorizon, other: FoundHorizon) -> bool:
    apart = math.dist(one.surface.center, other.surface.center)
    near = apart <= 0.01 * other.surface.mean_radius  # tolerance of recentered surfaces
    return near and abs(one.area - other.area) <= 1e-6 * other.area  # accuracy of found horizons


def _encloses(outer: FoundHorizon, inner: FoundHorizon) -> bool:
    """Whether a star-shaped horizon encloses another one."""
    large = outer.surface
    return outer is not inner and isinstance(large, StarSurface) and inside(inner.surface, large)
