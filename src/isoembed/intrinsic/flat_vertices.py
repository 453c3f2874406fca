"""Flat vertices taken out of a triangulation: the metric does not need them.

The triangles around a vertex without curvature unfold into a polygon in the plane, which is cut anew along
diagonals.  Loops are flipped away first, except for one around the only neighbor of a vertex of small angle.
Vertices go in rounds, in each of which no two are neighbors, so that where a vertex was is known
from a neighbor that goes in a later round or stays: after a number of steps that grows with the logarithm
of the number of vertices (D. Kirkpatrick, Optimal search in planar subdivisions, SIAM J. Comput. 12, 1983).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from isoembed.errors import InvalidMetric
from isoembed.intrinsic.flips import HalfEdges, angle_between, following, preceding
from isoembed.intrinsic.local_delaunay import THIN, flip_tracked, half_edges_leaving, restore_delaunay
from isoembed.intrinsic.retriangulate_star import retriangulate_star
from isoembed.mesh.triangulation import frozen

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Mask = NDArray[np.bool_]

SIDES = 16  # edges at a vertex that is removed, at most: its time grows with the cube
FEW, GROWTH = 10, 4  # edges at a vertex that goes in an early round; so many times more in a later one
WORTHWHILE = 20  # a round that takes fewer than one vertex in so many is not
PATIENCE = 10  # flips at a vertex for each of its edges
NONE, TURNED = -1, -2  # no half-edge


@dataclass(frozen=True, eq=False)
class Removal:
    """Which vertices were removed, and where they were.

    Attributes
    ----------
    core : ndarray of int, shape (V,)
        The old numbers of the vertices that are left, ascending.
    removed : ndarray of int, shape (n,)
        The old numbers of the others, in the order in which they went.
    anchors : ndarray of int, shape (n,)
        The old number of a neighbor that was still there.
    directions : ndarray, shape (n,)
        The direction at the anchor in which the vertex lay.
    distances : ndarray, shape (n,)
        Length of the straight line from the anchor in that direction to the vertex.
    backs : ndarray, shape (n,)
        The direction at the vertex in which that line came back.
    """

    core: Indices
    removed: Indices
    anchors: Indices
    directions: Floats
    distances: Floats
    backs: Floats


def remove_flat_vertices(tables: HalfEdges, flat: Mask) -> tuple[HalfEdges, Removal]:
    """Take flat vertices out of a triangulation.

    Parameters
    ----------
    tables : HalfEdges
    flat : ndarray of bool, shape (V,)
        Vertices of total angle 2 pi up to rounding.  At least three others remain.

    Returns
    -------
    HalfEdges
        A Delaunay triangulation of the same metric on the other vertices, which are renumbered in order; the
        directions are measured as before.
    Removal
        Where the removed vertices were.

    Raises
    ------
    InvalidMetric
        The triangles at a vertex are so thin that rounding hides how they lie.
    """
    tables = tables.copy()
    tables.make_delaunay(np.zeros(flat.size))
    n = int(flat.sum())
    order, anchors = np.empty(n, dtype=np.int64), np.empty(n, dtype=np.int64)
    places = np.empty((n, 3))
    alive, count = _remove(
        tables.corners, tables.twins, tables.lengths, tables.directions, flat, order, anchors, places
    )
    if count < n:
        v = int(np.flatnonzero(flat & ~np.isin(np.arange(flat.size), order[:count]))[0])
        raise InvalidMetric(
            f"vertex {v} is flat, but the triangles around it are so thin that rounding hides how they lie"
        )
    core = np.flatnonzero(~flat)
    number = np.cumsum(~flat) - 1
    kept = np.repeat(alive, 3)
    slot = np.cumsum(kept) - 1
    result = HalfEdges(
        number[tables.corners[kept]],
        slot[tables.twins[kept]],
        tables.lengths[kept],
        tables.directions[kept],
    )
    return result, Removal(
        frozen(core),
        frozen(order),
        frozen(anchors),
        frozen(places[:, 0].copy()),
        frozen(places[:, 1].copy()),
        frozen(places[:, 2].copy()),
    )


@njit(cache=True)
def _remove(
    corners: Indices,
    twins: Indices,
    lengths: Floats,
    directions: Floats,
    flat: Mask,
    order: Indices,
    anchors: Indices,
    places: Floats,
) -> tuple[Mask, int]:
    """Remove the flat vertices in place; return which faces are left, and how many vertices went."""
    n = corners.size
    leaving = half_edges_leaving(corners, flat.size)
    alive = np.ones(n // 3, dtype=np.bool_)
    kept = np.zeros(n, dtype=np.bool_)
    waiting = np.zeros(n, dtype=np.bool_)
    stack = np.empty(n, dtype=np.int64)
    moved = np.full(n, -1, dtype=np.int64)
    weights = np.zeros(flat.size)
    rounds = np.zeros(flat.size, dtype=np.int64)  # the last in which a neighbor went
    remaining = np.flatnonzero(flat)
    count, most, number = 0, FEW, 0
    while remaining.size > 0:
        number += 1
        left = 0
        for k in range(remaining.size):
            v = remaining[k]
            h = leaving[v]
            if rounds[v] == number or degree(h, twins, most) > most:
                remaining[left] = v
                left += 1
                continue
            h = _untie(v, corners, twins, lengths, directions, kept, leaving)
            height = -1
            if h != NONE:
                _note(h, corners, twins, lengths, directions, anchors, places, count)
                height = retriangulate_star(
                    h, corners, twins, lengths, directions, leaving, alive, moved, stack, waiting
                )
            if height < 0:
                remaining[left] = v
                left += 1
                continue
            order[count] = v
            count += 1
            for side in stack[:height]:  # of the new triangles
                rounds[corners[side]] = rounds[corners[twins[side]]] = number
            restore_delaunay(
                stack, height, waiting, corners, twins, lengths, directions, kept, leaving, weights
            )
        if left == remaining.size and most > n:
            break
        if WORTHWHILE * (remaining.size - left) < remaining.size and most <= n:
            most *= GROWTH
        remaining = remaining[:left]
    return alive, count


@njit(cache=True)
def degree(h: int, twins: Indices, most: int) -> int:
    """The number of edges at the vertex that a half-edge leaves, counted no farther than one beyond most."""
    e = h
    for k in range(most + 1):
        e = twins[preceding(e)]
        if e == h:
            return k + 1
    return most + 1


@njit(cache=True)
def _removable(h: int, corners: Indices, twins: Indices) -> int:
    """A half-edge from the vertex of this one from which `retriangulate_star` can begin, or NONE.

    There are few edges, and none is a loop; or one is, and it goes around one vertex that has no other edge.
    """
    loops = 0
    e = tip = h
    for _ in range(SIDES):
        if corners[twins[e]] == corners[h]:
            loops += 1
        if e // 3 == twins[e] // 3:
            tip = e
        e = twins[preceding(e)]
        if e == h:
            enclosed = loops == 2 and tip // 3 == twins[tip] // 3
            return tip if loops == 0 or enclosed else NONE
    return NONE


@njit(cache=True)
def _untie(
    v: int,
    corners: Indices,
    twins: Indices,
    lengths: Floats,
    directions: Floats,
    kept: Mask,
    leaving: Indices,
) -> int:
    """Flip edges at a vertex until it can be removed.

    Returns
    -------
    int
        Where `retriangulate_star` can begin, or NONE.
    """
    for _ in range(PATIENCE * degree(leaving[v], twins, corners.size)):
        first = _removable(leaving[v], corners, twins)
        if first >= 0:
            return first
        loop = _turn_loop(v, corners, twins, lengths, directions, kept, leaving)
        if loop == TURNED:
            continue
        if loop == NONE:
            if not _thin_out(v, corners, twins, lengths, directions, kept, leaving):
                break
        else:
            edge = _in_the_way(loop, twins, lengths)
            if not flip_tracked(edge, corners, twins, lengths, directions, kept, leaving, THIN):
                break
    return NONE


@njit(cache=True)
def _turn_loop(
    v: int,
    corners: Indices,
    twins: Indices,
    lengths: Floats,
    directions: Floats,
    kept: Mask,
    leaving: Indices,
) -> int:
    """Flip one of the loops at a vertex.

    Returns
    -------
    int
        TURNED, if one was; or else one that cannot be, or NONE if there is none.
    """
    found = NONE
    h = leaving[v]
    for _ in range(degree(h, twins, corners.size)):
        if corners[twins[h]] == v:
            if flip_tracked(h, corners, twins, lengths, directions, kept, leaving, THIN):
                return TURNED
            found = h
        h = twins[preceding(h)]
    return found


@njit(cache=True)
def _thin_out(
    v: int,
    corners: Indices,
    twins: Indices,
    lengths: Floats,
    directions: Floats,
    kept: Mask,
    leaving: Indices,
) -> bool:
    """Flip edges at a vertex without loops, those first that leave good triangles; return whether any was."""
    for thinnest in (1e-1, 1e-2, 1e-4, 1e-6, THIN):
        h = leaving[v]
        surplus = edges = degree(h, twins, corners.size)
        for _ in range(edges):
            if surplus > SIDES and flip_tracked(
                h, corners, twins, lengths, directions, kept, leaving, thinnest
            ):  # after which h still leaves v
                surplus -= 1
            h = twins[preceding(h)]
        if surplus < edges:
            return True
    return False


@njit(cache=True)
def _in_the_way(h: int, twins: Indices, lengths: Floats) -> int:
    """The edge whose flip divides the largest of the angles that keep an edge from being flipped."""
    t = twins[h]
    at = np.empty(4)
    for k, e in enumerate((h, t)):
        l, second, third = lengths[e], lengths[following(e)], lengths[preceding(e)]
        at[2 * k], at[2 * k + 1] = angle_between(l, third, second), angle_between(l, second, third)
    # At the start of h meet its own first angle and the second of the twin.
    if at[0] + at[3] > at[1] + at[2]:
        return following(h) if at[0] > at[3] else preceding(t)
    return preceding(h) if at[1] > at[2] else following(t)


@njit(cache=True)
def _note(
    h: int,
    corners: Indices,
    twins: Indices,
    lengths: Floats,
    directions: Floats,
    anchors: Indices,
    places: Floats,
    count: int,
) -> None:
    """Write down where the vertex that a half-edge leaves is seen from its nearest neighbor."""
    e = nearest = h
    while True:
        if lengths[e] < lengths[nearest] and corners[twins[e]] != corners[h]:
            nearest = e
        e = twins[preceding(e)]
        if e == h:
            break
    back = twins[nearest]
    anchors[count] = corners[back]
    places[count, 0] = directions[back]
    places[count, 1] = lengths[nearest]
    places[count, 2] = directions[nearest]
