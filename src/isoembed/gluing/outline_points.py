"""Subdivision of glued outlines, and assignment of their points to vertices."""

import itertools
from collections.abc import Sequence

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.errors import InvalidMetric
from isoembed.gluing.polygon import Polygon, following
from isoembed.gluing.runs import Run, cut
from isoembed.gluing.tolerance import Tolerance
from isoembed.mesh.components import components


def cut_outlines(
    sheets: Sequence[Polygon], runs: Sequence[tuple[Run, Run]], tolerance: Tolerance
) -> tuple[list[Floats], Indices]:
    """Subdivide outlines at their corners and at points glued to corners of others.

    Returns
    -------
    list of ndarray
        Positions on each outline, from corner 0.
    ndarray of int
        For each segment of the concatenated outlines, the segment glued to it in opposite direction; itself
        if it is not glued.
    """
    cuts = [(one.polygon, other.polygon, *cut(one, other, tolerance)) for one, other in runs]
    positions = [{float(k) for k in range(sheet.n)} for sheet in sheets]
    for p, q, ours, theirs in cuts:
        positions[p].update(ours)
        positions[q].update(theirs)
    stops = [np.array(sorted(some)) for some in positions]
    count = itertools.count()
    index = [{position: next(count) for position in some.tolist()} for some in stops]
    mates = np.arange(next(count))
    for p, q, ours, theirs in cuts:
        for here, there in zip(ours[:-1], theirs[1:], strict=True):
            mates[index[p][here]], mates[index[q][there]] = index[q][there], index[p][here]
    return stops, mates


def glued_points(first: Indices, mates: Indices, corners: Indices, any_surface: bool) -> Indices:
    """Vertex of each outline point, with the vertices of corners numbered first.

    Raises
    ------
    InvalidMetric
        The surface is not connected, or not a sphere although it must be.
    """
    n = len(mates)
    owners = np.repeat(np.arange(len(first) - 1), np.diff(first))
    part = components(owners, owners[mates], len(first) - 1)
    parts = int(part.max()) + 1
    if parts > 1:
        raise InvalidMetric(
            f"the polygons make {parts} surfaces, not one: "
            f"polygon {int(np.argmax(part != part[0]))} is not connected to polygon 0"
        )
    ends = following(first)
    glued = np.flatnonzero(mates != np.arange(n))
    classes = components(glued, ends[mates[glued]], n)
    count = int(classes.max()) + 1
    euler = count - n // 2 + len(first) - 1
    if euler != 2 and not any_surface:
        raise InvalidMetric(
            f"the polygons make a surface of Euler characteristic {euler} (genus {1 - euler // 2}), not 2: "
            "not a sphere"
        )
    _, earliest = np.unique(classes[np.concatenate([corners, np.arange(n)])], return_index=True)
    numbers = np.empty(count, dtype=np.int64)
    numbers[np.argsort(earliest)] = np.arange(count)
    return numbers[classes]
