"""Flat vertices taken out of a triangulation: the metric does not need them.

The triangles around a vertex without curvature unfold into a polygon in the plane, which is cut anew along
diagonals.  Loops are flipped away first, except for one around the only neighbor of a vertex of small angle.
Vertices go in rounds, in each of which no two are neighbors, so that where a vertex was is known
from a neighbor that goes in a later round or stays: after a number of steps that grows with the logarithm
of the number of vertices (D. Kirkpatrick, Optimal search in planar subdivisions, SIAM J. Comput. 12, 1983).
"""

from typing import NamedTuple

import numpy as np

from isoembed.arrays import Floats, Indices, Mask
from isoembed.errors import InvalidMetric
from isoembed.intrinsic.delaunay import END, THIN, empty_stack, make_delaunay, restore_delaunay
from isoembed.intrinsic.flips import Tracked, flip_tracked, tracked
from isoembed.intrinsic.halfedges import HalfEdges, corner_angle, degree, following, preceding
from isoembed.intrinsic.retriangulate_star import retriangulate_star
from isoembed.kernel import kernel
from isoembed.mesh.triangulation import frozen

NONE, FLIPPED = -1, -2  # no half-edge


MAX_DEGREE = 16  # of a vertex that is removed: the time grows with its cube
THINNEST = (1e-1, 1e-2, 1e-4, 1e-6, THIN)  # height over longest side that flips leave, one after another


class Removal(NamedTuple):
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


def remove_flat_vertices(mesh: HalfEdges, flat: Mask) -> tuple[HalfEdges, Removal]:
    """Take flat vertices out of a triangulation.

    Parameters
    ----------
    mesh : HalfEdges
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
    mesh = mesh.copy()
    make_delaunay(mesh, np.zeros(flat.size))
    n = int(flat.sum())
    core = np.flatnonzero(~flat)
    removal = Removal(core, *np.empty((2, n), dtype=np.int64), *np.empty((3, n)))
    alive, count = _remove(mesh, flat, removal)
    if count < n:
        v = int(np.setdiff1d(np.flatnonzero(flat), removal.removed[:count])[0])
        raise InvalidMetric(
            f"vertex {v} is flat, but the triangles around it are so thin that rounding hides how they lie"
        )
    left = mesh.of_faces(np.flatnonzero(alive))
    number = np.cumsum(~flat) - 1
    return left._replace(corners=number[left.corners]), Removal._make(frozen(table) for table in removal)


@kernel
def _remove(mesh: HalfEdges, flat: Mask, removal: Removal) -> tuple[Mask, int]:
    """Remove the flat vertices in place; return which faces are left, and how many vertices went."""
    corners, twins = mesh.corners, mesh.twins
    n = corners.size
    carried = tracked(corners, np.zeros(n, dtype=np.bool_), flat.size)
    alive = np.ones(n // 3, dtype=np.bool_)
    stack = empty_stack(n)
    moved = np.full(n, -1, dtype=np.int64)
    rounds = np.zeros(flat.size, dtype=np.int64)  # the last in which a neighbor went
    remaining = np.flatnonzero(flat)
    count, most, number = 0, 10, 0  # edges at a vertex that goes in an early round
    while remaining.size > 0:
        number += 1
        left = 0
        for k in range(remaining.size):
            v = remaining[k]
            gone = False
            if rounds[v] != number and degree(carried.leaving[v], twins, most) <= most:
                h = _untie(v, mesh, carried)
                if h != NONE:
                    _note(h, mesh, removal, count)
                    gone = retriangulate_star(h, mesh, carried.leaving, alive, moved, stack)
            if not gone:
                remaining[left] = v
                left += 1
                continue
            removal.removed[count] = v
            count += 1
            side = stack[-1]
            while side != END:  # of the new triangles
                rounds[corners[side]] = rounds[corners[twins[side]]] = number
                side = stack[side]
            restore_delaunay(stack, mesh, carried)
        if left == remaining.size and most > n:
            break
        if 20 * (remaining.size - left) < remaining.size and most <= n:
            most *= 4  # a round that takes less than a twentieth allows four times as many edges in the next
        remaining = remaining[:left]
    return alive, count


@kernel
def _removable(h: int, mesh: HalfEdges) -> int:
    """A half-edge from the vertex of this one from which `retriangulate_star` can begin, or NONE.

    There are few edges, and none is a loop; or one is, and it goes around one vertex that has no other edge.
    """
    corners, twins = mesh.corners, mesh.twins
    loops = 0
    e = tip = h
    for _ in range(MAX_DEGREE):
        if corners[twins[e]] == corners[h]:
            loops += 1
        if e // 3 == twins[e] // 3:
            tip = e
        e = twins[preceding(e)]
        if e == h:
            enclosed = loops == 2 and tip // 3 == twins[tip] // 3
            return tip if loops == 0 or enclosed else NONE
    return NONE


@kernel
def _untie(v: int, mesh: HalfEdges, carried: Tracked) -> int:
    """Flip edges at a vertex until it can be removed.

    Returns
    -------
    int
        Where `retriangulate_star` can begin, or NONE.
    """
    # ten flips an edge until the vertex can be removed
    for _ in range(10 * degree(carried.leaving[v], mesh.twins, mesh.twins.size)):
        first = _removable(carried.leaving[v], mesh)
        if first >= 0:
            return first
        loop = _flip_loop(v, mesh, carried)
        if loop == FLIPPED:
            continue
        if loop == NONE:
            if not _thin_out(v, mesh, carried):
                break
        else:
            edge = _in_the_way(loop, mesh)
            if not flip_tracked(edge, mesh, carried, THIN):
                break
    return NONE


@kernel
def _flip_loop(v: int, mesh: HalfEdges, carried: Tracked) -> int:
    """Flip one of the loops at a vertex.

    Returns
    -------
    int
        FLIPPED, if one was; or else one that cannot be, or NONE if there is none.
    """
    found = NONE
    twins = mesh.twins
    h = carried.leaving[v]
    for _ in range(degree(h, twins, twins.size)):
        if mesh.corners[twins[h]] == v:
            if flip_tracked(h, mesh, carried, THIN):
                return FLIPPED
            found = h
        h = twins[preceding(h)]
    return found


@kernel
def _thin_out(v: int, mesh: HalfEdges, carried: Tracked) -> bool:
    """Flip edges at a vertex without loops, those first that leave good triangles; return whether any was."""
    for thinnest in THINNEST:
        h = carried.leaving[v]
        surplus = edges = degree(h, mesh.twins, mesh.twins.size)
        for _ in range(edges):
            if surplus > MAX_DEGREE and flip_tracked(
                h, mesh, carried, thinnest
            ):  # after which h still leaves v
                surplus -= 1
            h = mesh.twins[preceding(h)]
        if surplus < edges:
            return True
    return False


@kernel
def _in_the_way(h: int, mesh: HalfEdges) -> int:
    """The edge whose flip divides the largest of the angles that keep an edge from being flipped."""
    t = mesh.twins[h]
    at = np.empty(4)
    for k, e in enumerate((h, t)):
        at[2 * k], at[2 * k + 1] = corner_angle(e, mesh), corner_angle(following(e), mesh)
    # At the start of h meet its own first angle and the second of the twin.
    if at[0] + at[3] > at[1] + at[2]:
        return following(h) if at[0] > at[3] else preceding(t)
    return preceding(h) if at[1] > at[2] else following(t)


@kernel
def _note(h: int, mesh: HalfEdges, removal: Removal, count: int) -> None:
    """Write down where the vertex that a half-edge leaves is seen from its nearest neighbor."""
    corners, twins, lengths, directions, _ = mesh
    e = nearest = h
    while True:
        if lengths[e] < lengths[nearest] and corners[twins[e]] != corners[h]:
            nearest = e
        e = twins[preceding(e)]
        if e == h:
            break
    back = twins[nearest]
    removal.anchors[count] = corners[back]
    removal.directions[count] = directions[back]
    removal.distances[count] = lengths[nearest]
    removal.backs[count] = directions[nearest]
