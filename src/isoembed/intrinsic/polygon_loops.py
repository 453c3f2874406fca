# cython: boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False, infer_types=True
"""Compiled layout of triangles in polygons, and straight lines across them.

Straight lines cross triangles that are unfolded successively in a `chart`.  A line starts at the origin and
runs along the positive x axis.  The current triangle is given by the half-edge through which the line leaves
it, from a lower to an upper corner, and by the motion from the frame of its polygon to that of the line: the
state ``(out, turn, shift)``, so that in the plane corner h is at ``turn z[h] + shift``.
"""

from __future__ import annotations

import cython
import numpy as np
from cython.cimports.isoembed.c_types import Complex, ConstFlag, ConstInt, Flag, Int, Real
from cython.cimports.isoembed.intrinsic.chart import (
    argument,
    coordinate,
    dot,
    motion,
    moved,
    norm,
    point,
    polar,
    toward,
)
from cython.cimports.isoembed.intrinsic.loops import (
    Mesh,
    corner_angle,
    following,
    modulo,
    preceding,
    third_corner,
)
from cython.cimports.isoembed.space.trigonometry import cs, sn
from cython.cimports.libc.math import isnan

PI = cython.declare(cython.double, 3.141592653589793)
# maximum number of crossings beyond the number of triangles: lines can wind around a needle
EXTRA_CROSSINGS = cython.declare(cython.longlong, 10**6)


@cython.cclass
class Layout:
    """Arrays of `Polygons`, changed in place."""

    def __init__(self, polygons):
        self.corners, self.twins, self.z = polygons.corners, polygons.twins, polygons.z
        self.fixed, self.cells, self.curvature = polygons.fixed, polygons.cells, polygons.curvature


def unfolded(mesh: Mesh, fixed: ConstFlag[::1]):
    """Lay out the corners (3F,) from face to face across all edges but fixed ones; number the parts (F,)."""
    twins, lengths = mesh.twins, mesh.lengths
    n = twins.shape[0] // 3
    z: Complex[::1] = np.zeros(3 * n, dtype=np.complex128)
    cells: Int[::1] = np.full(n, -1, dtype=np.int64)
    stack: Int[::1] = np.empty(n, dtype=np.int64)
    number: Int = 0
    top: Int = 0
    for first in range(n):
        if cells[first] >= 0:
            continue
        h = 3 * first
        z[h + 1] = coordinate(lengths[h], mesh.curvature)
        z[h + 2] = third_corner(h, z[h], z[h + 1], mesh)
        cells[first] = number
        stack[0], top = first, 1
        while top > 0:
            top -= 1
            f = stack[top]
            for h in range(3 * f, 3 * f + 3):
                t = twins[h]
                if fixed[h] or cells[t // 3] >= 0:
                    continue
                z[following(t)], z[t] = z[h], z[following(h)]
                z[preceding(t)] = third_corner(t, z[t], z[h], mesh)
                cells[t // 3] = number
                stack[top] = t // 3
                top += 1
        number += 1
    return np.asarray(z), np.asarray(cells)


def are_convex(cells: ConstInt[::1], mesh: Mesh, fixed: ConstFlag[::1]):
    """Mask of the cells that are convex polygons.

    A cell of n faces connected by n - 1 edges has no inner vertex and no hole; if it also has no reflex
    corner, it does not overlap itself.
    """
    n: Int = int(np.max(cells)) + 1
    inner: Int[::1] = np.zeros(n, dtype=np.int64)
    size: Int[::1] = np.zeros(n, dtype=np.int64)
    convex: Flag[::1] = np.ones(n, dtype=np.bool_)
    for h in range(fixed.shape[0]):
        c = cells[h // 3]
        if h % 3 == 0:
            size[c] += 1
        if not fixed[h]:
            inner[c] += 1
        else:
            # angle of the corner from this side counterclockwise to the previous one
            angle: Real = 0.0
            e = h
            for _ in range(fixed.shape[0]):
                angle += corner_angle(e, mesh)
                if fixed[preceding(e)]:
                    break
                e = mesh.twins[preceding(e)]
            if angle > PI + 1e-9:  # tolerance for rounding, in radians
                convex[c] = False
    return np.asarray(convex) & (np.asarray(inner) == 2 * (np.asarray(size) - 1))


def first_sides(twins: ConstInt[::1], fixed: ConstFlag[::1]):
    """First side of the polygon, counterclockwise, at each corner of each face, shape (3F,)."""
    first: Int[::1] = np.empty(twins.shape[0], dtype=np.int64)
    for h in range(twins.shape[0]):
        if fixed[h]:
            e = h
            while True:
                first[e] = h
                into = preceding(e)
                if fixed[into]:
                    break
                e = twins[into]
    return np.asarray(first)


@cython.cfunc
@cython.exceptval(check=False)
def angle_around(h: cython.longlong, polygons: Layout) -> cython.double:
    """Sum of the angles at the start vertex of a half-edge."""
    z, curvature, start = polygons.z, polygons.curvature, h
    total: Real = 0.0
    while True:
        ahead = toward(z[h], z[following(h)], curvature)
        total += argument(toward(z[h], z[preceding(h)], curvature) * ahead.conjugate())
        h = polygons.twins[preceding(h)]
        if h == start:
            return total


@cython.ccall
@cython.exceptval(check=False)
def sector(
    h: cython.longlong, direction: cython.double, total: cython.double, mesh: Mesh
) -> tuple[cython.longlong, cython.double]:
    """Triangle at a vertex that contains a direction.

    Parameters
    ----------
    h : int
        Any half-edge leaving the vertex; the search goes counterclockwise from it.
    direction : float
    total : float
        Total angle at the vertex.
    mesh : Mesh

    Returns
    -------
    int, float
        Half-edge next clockwise of the direction, and the angle from it to the direction.
    """
    offset = modulo(direction - mesh.directions[h], total)
    while True:
        ahead = mesh.twins[preceding(h)]
        nearer = modulo(direction - mesh.directions[ahead], total)
        if not nearer < offset:
            return h, offset
        h, offset = ahead, nearer


@cython.ccall
@cython.exceptval(check=False)
def place(
    h: cython.longlong,
    state: tuple[cython.longlong, cython.doublecomplex, cython.doublecomplex],
    polygons: Layout,
) -> cython.doublecomplex:
    """Position of a corner in the frame of the line."""
    turn, shift = state[1], state[2]
    if polygons.curvature == 0:
        return turn * polygons.z[h] + shift
    return moved(polygons.z[h], turn, shift, polygons.curvature)


@cython.ccall
@cython.exceptval(check=False)
def from_corner(
    h: cython.longlong, offset: cython.double, polygons: Layout
) -> tuple[cython.longlong, cython.doublecomplex, cython.doublecomplex]:
    """State of a line that starts at a vertex, at an angle from a half-edge into its triangle."""
    side = toward(polygons.z[h], polygons.z[following(h)], polygons.curvature)
    length = norm(side)
    turn = point(side.real / length, -side.imag / length) * polar(1.0, -offset)
    return following(h), turn, -turn * polygons.z[h]


@cython.ccall
def from_inside(
    f: cython.longlong, start: cython.doublecomplex, angle: cython.double, polygons: Layout
) -> tuple[cython.longlong, cython.doublecomplex, cython.doublecomplex]:
    """State of a line that starts in a face, at an angle from the x axis of its polygon."""
    turn = polar(1.0, -angle)
    shift = -turn * start
    z: Complex[::1] = np.empty(3, dtype=np.complex128)
    for c in range(3):
        z[c] = moved(polygons.z[3 * f + c], turn, shift, polygons.curvature)
    k: Int = -1
    for c in range(3):
        if z[c].imag < 0 and z[(c + 1) % 3].imag >= 0:
            k = c
    if k < 0:  # along a side, with all corners on one side by rounding: it leaves at the corner ahead
        for c in range(3):
            if k < 0 or z[c].real * norm(z[k]) > z[k].real * norm(z[c]):
                k = c
        if max(z[0].imag, z[1].imag, z[2].imag) <= 0:
            k = (k + 2) % 3
    return 3 * f + k, turn, shift


@cython.cfunc
@cython.exceptval(check=False)
def crossed(
    state: tuple[cython.longlong, cython.doublecomplex, cython.doublecomplex], polygons: Layout
) -> tuple[cython.longlong, cython.doublecomplex, cython.doublecomplex]:
    """State of the line in the next triangle."""
    out, turn, shift = state[0], state[1], state[2]
    z, g = polygons.z, polygons.twins[out]
    if polygons.fixed[out]:
        a, b, c, d = z[out], z[following(out)], z[following(g)], z[g]  # in two frames
        if polygons.curvature == 0:
            there = turn * (b - a) * (d - c).conjugate()
            shift += (turn * (a + b) - there / norm(there) * (c + d)) / 2
            turn = there / norm(there)
        else:
            upper = place(following(out), state, polygons)
            turn, shift = motion(place(out, state, polygons), upper, c, d, polygons.curvature)
    ahead = moved(z[preceding(g)], turn, shift, polygons.curvature)
    return following(g) if ahead.imag > 0 else preceding(g), turn, shift


@cython.cfunc
@cython.exceptval(check=False)
def reaches(
    state: tuple[cython.longlong, cython.doublecomplex, cython.doublecomplex],
    length: cython.double,
    polygons: Layout,
) -> cython.bint:
    """Whether the line is still in its triangle at this distance from its start."""
    lower = place(state[0], state, polygons)
    upper = place(following(state[0]), state, polygons)
    k = polygons.curvature
    if k == 0:
        return (upper.imag - lower.imag) * (lower.real - length) >= (upper.real - lower.real) * lower.imag
    # On the hyperboloid or sphere, the point of the axis between them is a linear combination of both.
    sine = lower.real * upper.imag - upper.real * lower.imag
    cosine = (1 - k / 4 * dot(lower, lower)) * upper.imag - (1 - k / 4 * dot(upper, upper)) * lower.imag
    return sine * cs(length, k) >= cosine * sn(length, k)


@cython.ccall
@cython.exceptval(check=False)
def straight(
    state: tuple[cython.longlong, cython.doublecomplex, cython.doublecomplex],
    length: cython.double,
    polygons: Layout,
) -> tuple[cython.longlong, cython.doublecomplex, cython.doublecomplex]:
    """Follow a line over a distance; ``out`` is -1 if it crosses too many triangles."""
    for _ in range(polygons.twins.shape[0] + EXTRA_CROSSINGS):
        if reaches(state, length, polygons):
            return state
        state = crossed(state, polygons)
        if isnan(state[2].real):
            break
    return -1, state[1], state[2]
