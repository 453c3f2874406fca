"""Where horizons are looked for in a slice: spheres around its black holes, all of them or some."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry
from isoembed.thresholds import threshold

Hole = tuple[float, Sequence[float]]
"""The mass of a black hole and its position."""


@dataclass(frozen=True)
class PlaceThresholds:
    """Thresholds of the spheres around which horizons are looked for."""

    masses: float = threshold(3.0, "mass", "Distance of the sphere from the outermost hole.")
    gap: float = threshold(0.45, "relative", "The same over the distance to the nearest hole outside.")
    within: float = threshold(0.9, "relative", "The sphere over the largest one in a grid.")


PLACES = PlaceThresholds()


@dataclass(frozen=True)
class Place:
    """A sphere around black holes.

    Attributes
    ----------
    center : three floats
    radius : float
    parts : tuple of Place
        Spheres around less of them, on both sides of the widest gap; none around one hole.
    """

    center: tuple[float, float, float]
    radius: float
    parts: tuple[Place, ...] = ()


def places_of(geometry: ThreeGeometry) -> Place:
    """A sphere around all that there is in a slice.

    Raises
    ------
    InvalidParameter
        The slice does not say where that is.
    """
    holes = tuple(getattr(geometry, "black_holes", ()))
    box = getattr(geometry, "box", None)
    if box is not None:
        low, high = (np.array(corner) for corner in box)
        x, y, z = (0.5 * (low + high)).tolist()
        return Place((x, y, z), PLACES.within * 0.5 * float((high - low).min()))
    if not holes:
        raise InvalidParameter(
            "the slice does not say where its black holes are: give a guess, such as a sphere around them"
        )
    return _around(holes, np.inf)


def _around(holes: Sequence[Hole], room: float) -> Place:
    """A sphere around some holes, as far from other ones as it can be."""
    masses = np.array([mass for mass, _ in holes])
    at = np.array([position for _, position in holes], dtype=float)
    center = masses @ at / masses.sum()
    extent = float(np.linalg.norm(at - center, axis=1).max())
    radius = extent + min(PLACES.masses * float(masses.sum()) + extent, PLACES.gap * room)
    x, y, z = center.tolist()
    return Place((x, y, z), radius, _parted(holes, at, room) if len(holes) > 1 else ())


def _parted(holes: Sequence[Hole], at: Floats, room: float) -> tuple[Place, ...]:
    """Both sides of the longest edge of the least spanning tree."""
    apart = np.linalg.norm(at[:, None] - at[None], axis=2)
    tree: list[tuple[float, int, int]] = []
    joined = [0]
    while len(joined) < len(at):
        rest = [i for i in range(len(at)) if i not in joined]
        tree.append(min((float(apart[i, j]), i, j) for i in joined for j in rest))
        joined.append(tree[-1][2])
    widest = max(tree)
    side = {widest[1]}
    edges = [edge for edge in tree if edge is not widest]
    for _ in edges:
        for _, i, j in edges:
            if {i, j} & side:
                side |= {i, j}
    groups = ([i for i in range(len(at)) if (i in side) == inside] for inside in (True, False))
    return tuple(_around([holes[i] for i in group], min(room, widest[0])) for group in groups)
