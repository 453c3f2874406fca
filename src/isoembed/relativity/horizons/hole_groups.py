"""Groups of black holes in a slice, and initial spheres for the search for their common horizons."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from isoembed.errors import InvalidParameter
from isoembed.meshing.sphere import gauss_rule
from isoembed.relativity.spacetimes.surface import Surface
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry


@dataclass(frozen=True)
class HoleGroup:
    """Group of black holes inside a sphere.

    Attributes
    ----------
    center : three floats
    radius : float
    holes : frozenset of int
        Indices of the black holes; empty for a sphere in a grid.
    """

    center: tuple[float, float, float]
    radius: float
    holes: frozenset[int] = frozenset()


def hole_groups(geometry: ThreeGeometry) -> Iterator[HoleGroup]:
    """Spheres around all black holes of a slice, or in its grid, then around groups of holes, largest first.

    Groups whose sphere would reach another hole are omitted, as are groups of holes farther apart than twice
    their mass: in Brill-Lindquist slices a common horizon exists up to 0.77 times the mass.  Raises
    `InvalidParameter`: the slice does not name its black holes or box.
    """
    holes, box = geometry.black_holes, geometry.box
    if not holes and box is not None:
        low, high = np.asarray(box, dtype=np.float64)
        x, y, z = (0.5 * (low + high)).tolist()
        yield HoleGroup((x, y, z), 0.9 * 0.5 * float((high - low).min()))  # margin to the edge of the grid
        return
    if not holes:
        raise InvalidParameter(
            "the slice does not specify the positions of its black holes: use find_horizon(geometry, guess) "
            "with a guess for each, such as StarSurface.sphere(center, radius); a class of your own may "
            "define black_holes or box"
        )
    everything = frozenset(range(len(holes)))
    # More than eight holes have too many groups to try them all.
    sizes = range(len(holes) - 1, 0, -1) if len(holes) <= 8 else (1,)
    groups = [everything]
    groups += [frozenset(group) for size in sizes for group in combinations(sorted(everything), size)]
    for group in groups:
        around = _around(holes, group)
        if around is not None:
            yield around


def _around(holes: Sequence[tuple[float, Sequence[float]]], group: frozenset[int]) -> HoleGroup | None:
    """Sphere around some holes that stays clear of the others; None if there is none."""
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
    return HoleGroup((x, y, z), radius, group)


def _linked(masses: np.ndarray, at: np.ndarray) -> bool:
    """Whether the holes are connected by distances of at most twice their total mass."""
    # Holes farther apart than twice their mass have no common horizon.
    near = np.linalg.norm(at[:, None] - at[None], axis=2) <= 2.0 * masses.sum()
    reached = near[0]
    for _ in at:
        reached = near[reached].any(axis=0)
    return bool(reached.all())


def holes_inside(geometry: ThreeGeometry, surface: Surface) -> frozenset[int]:
    """Indices of the black holes inside a surface, where its solid angle is 4 pi."""
    more = 16  # additional nodes beyond those for the harmonics
    u, weights = gauss_rule(surface.harmonics.degree + more, 2 * (surface.harmonics.order + more))
    jet = surface.jet(u)
    normals = np.cross(jet.first[:, 0], jet.first[:, 1])
    inside = []
    for i, (_, position) in enumerate(geometry.black_holes):
        away = jet.x - np.array(position)
        flux = np.einsum("ni,ni->n", away, normals) / np.linalg.norm(away, axis=1) ** 3
        if abs(weights @ flux) > 2.0 * np.pi:
            inside.append(i)
    return frozenset(inside)
