"""Where horizons are looked for in a slice: spheres around its black holes, all of them or some."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from isoembed.errors import InvalidParameter
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry

Hole = tuple[float, Sequence[float]]
"""The mass of a black hole and its position."""


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


def places_of(geometry: ThreeGeometry) -> Iterator[Place]:
    """Spheres around all that there is in a slice, and around groups of its holes, the largest first.

    Groups whose sphere reaches another hole are left out, as are those of holes further apart than twice
    their mass: in Brill-Lindquist's slices a common horizon ends at .77 of it.  Raises `InvalidParameter`:
    the slice does not say where its holes are.
    """
    holes = tuple(getattr(geometry, "black_holes", ()))
    box = getattr(geometry, "box", None)
    if box is not None:
        low, high = (np.array(corner) for corner in box)
        x, y, z = (0.5 * (low + high)).tolist()
        yield Place((x, y, z), 0.9 * 0.5 * float((high - low).min()))  # room to the edge of the grid
        return
    if not holes:
        raise InvalidParameter(
            "the slice does not say where its black holes are: give a guess, such as a sphere around them"
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


def _around(holes: Sequence[Hole], group: frozenset[int]) -> Place | None:
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
    """Whether the holes hang together by distances that are not too long."""
    # Holes that are farther apart than twice their mass have no common horizon.
    near = np.linalg.norm(at[:, None] - at[None], axis=2) <= 2.0 * masses.sum()
    reached = near[0]
    for _ in at:
        reached = near[reached].any(axis=0)
    return bool(reached.all())
