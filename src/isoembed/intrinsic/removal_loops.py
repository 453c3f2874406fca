# cython: boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False, infer_types=True
"""Compiled removal of flat vertices, after flips that remove loops and reduce their degrees."""

from __future__ import annotations

import cython
import numpy as np
from cython.cimports.isoembed.c_types import ConstFlag, Flag, Int, Real
from cython.cimports.isoembed.intrinsic.delaunay_loops import Tracked, flip_tracked
from cython.cimports.isoembed.intrinsic.loops import (
    Mesh,
    corner_angle,
    degree,
    following,
    preceding,
    restore_delaunay,
)
from cython.cimports.isoembed.intrinsic.star_loops import retriangulate_star

from isoembed.intrinsic.loops import empty_stack

THIN = cython.declare(
    cython.double, 1e-8
)  # height over longest side: below, the triangle inequality may degenerate in floats
END = cython.declare(cython.longlong, -1)  # bottom of the stack
NONE = cython.declare(cython.longlong, -1)  # no half-edge
FLIPPED_LOOP = cython.declare(cython.longlong, -2)
MAX_DEGREE = cython.declare(cython.longlong, 16)  # of a removed vertex: the cost grows with its cube


@cython.cclass
class Notes:
    """Output arrays of a `Removal`."""

    removed: Int[::1]
    anchors: Int[::1]
    directions: Real[::1]
    distances: Real[::1]
    backs: Real[::1]

    def __init__(self, removal):
        self.removed, self.anchors = removal.removed, removal.anchors
        self.directions, self.distances, self.backs = removal.directions, removal.distances, removal.backs


def remove_vertices(mesh: Mesh, flat: ConstFlag[::1], removal):
    """Remove the flat vertices in place; return a mask of the remaining faces and the number removed."""
    corners, twins = mesh.corners, mesh.twins
    n = corners.shape[0]
    notes = Notes(removal)
    carried = Tracked(mesh, np.zeros(n, dtype=np.bool_), flat.shape[0])
    number: Int = 0
    left: Int
    alive: Flag[::1] = np.ones(n // 3, dtype=np.bool_)
    stack: Int[::1] = empty_stack(n)
    moved: Int[::1] = np.full(n, -1, dtype=np.int64)
    rounds: Int[::1] = np.zeros(flat.shape[0], dtype=np.int64)  # last round in which a neighbor was removed
    remaining: Int[::1] = np.flatnonzero(flat)
    count: Int = 0
    most: Int = 10  # maximum degree of a vertex removed in an early round
    while remaining.shape[0] > 0:
        number += 1
        left = 0
        for k in range(remaining.shape[0]):
            v = remaining[k]
            is_removed: cython.bint = False
            if rounds[v] != number and degree(carried.leaving[v], twins, most) <= most:
                h = _untie(v, mesh, carried)
                if h != NONE:
                    _note(h, mesh, notes, count)
                    is_removed = retriangulate_star(h, mesh, carried.leaving, alive, moved, stack)
            if not is_removed:
                remaining[left] = v
                left += 1
                continue
            notes.removed[count] = v
            count += 1
            side = stack[n]
            while side != END:  # of the new triangles
                rounds[corners[side]] = rounds[corners[twins[side]]] = number
                side = stack[side]
            restore_delaunay(stack, carried)
        if left == remaining.shape[0] and most > n:
            break
        if 20 * (remaining.shape[0] - left) < remaining.shape[0] and most <= n:
            most *= 4  # after removing less than a twentieth, allow four times as many edges
        remaining = remaining[:left]
    return np.asarray(alive), count


@cython.cfunc
@cython.exceptval(check=False)
def _removable(h: Int, mesh: Mesh) -> Int:
    """Half-edge from the same vertex with which `retriangulate_star` can begin, or NONE.

    The vertex must have few edges and no loop, or a single loop around one vertex that has no other edge.
    """
    corners, twins = mesh.corners, mesh.twins
    loops: Int = 0
    e = tip = h
    for _ in range(MAX_DEGREE):
        if corners[twins[e]] == corners[h]:
            loops += 1
        if e // 3 == twins[e] // 3:
            tip = e
        e = twins[preceding(e)]
        if e == h:
            enclosed: cython.bint = loops == 2 and tip // 3 == twins[tip] // 3
            return tip if loops == 0 or enclosed else NONE
    return NONE


@cython.cfunc
@cython.exceptval(check=False)
def _untie(v: Int, mesh: Mesh, carried: Tracked) -> Int:
    """Flip edges at a vertex until it can be removed.

    Returns
    -------
    int
        Half-edge for `retriangulate_star`, or NONE.
    """
    # at most ten flips per edge
    for _ in range(10 * degree(carried.leaving[v], mesh.twins, mesh.twins.shape[0])):
        first = _removable(carried.leaving[v], mesh)
        if first >= 0:
            return first
        loop = _flip_loop(v, mesh, carried)
        if loop == FLIPPED_LOOP:
            continue
        if loop == NONE:
            if not _thin_out(v, mesh, carried):
                break
        else:
            edge = _in_the_way(loop, mesh)
            if not flip_tracked(edge, mesh, carried, THIN):
                break
    return NONE


@cython.cfunc
@cython.exceptval(check=False)
def _flip_loop(v: Int, mesh: Mesh, carried: Tracked) -> Int:
    """Flip one of the loops at a vertex.

    Returns
    -------
    int
        FLIPPED_LOOP if one was flipped; else a loop that cannot be flipped, or NONE if there is none.
    """
    found = NONE
    twins = mesh.twins
    h = carried.leaving[v]
    for _ in range(degree(h, twins, twins.shape[0])):
        if mesh.corners[twins[h]] == v:
            if flip_tracked(h, mesh, carried, THIN):
                return FLIPPED_LOOP
            found = h
        h = twins[preceding(h)]
    return found


@cython.cfunc
@cython.exceptval(check=False)
def _thin_out(v: Int, mesh: Mesh, carried: Tracked) -> cython.bint:
    """Flip edges at a vertex without loops, starting with those that leave good triangles; return success."""
    for thinnest in (0.1, 0.01, 0.0001, 1e-06, THIN):  # height over longest side that flips leave
        h = carried.leaving[v]
        surplus = edges = degree(h, mesh.twins, mesh.twins.shape[0])
        for _ in range(edges):
            if surplus > MAX_DEGREE and flip_tracked(h, mesh, carried, thinnest):  # h still leaves v
                surplus -= 1
            h = mesh.twins[preceding(h)]
        if surplus < edges:
            return True
    return False


@cython.cfunc
@cython.exceptval(check=False)
def _in_the_way(h: Int, mesh: Mesh) -> Int:
    """Edge whose flip divides the largest angle that blocks the flip of an edge."""
    t = mesh.twins[h]
    first, second = corner_angle(h, mesh), corner_angle(following(h), mesh)
    across, opposite = corner_angle(t, mesh), corner_angle(following(t), mesh)
    # The first angle of h and the second of its twin meet at the start of h.
    if first + opposite > second + across:
        return following(h) if first > opposite else preceding(t)
    return preceding(h) if second > across else following(t)


@cython.cfunc
@cython.exceptval(check=False)
def _note(h: Int, mesh: Mesh, removal: Notes, count: Int) -> cython.void:
    """Record the position of the start vertex of a half-edge relative to its nearest neighbor."""
    corners, twins, lengths, directions = mesh.corners, mesh.twins, mesh.lengths, mesh.directions
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
