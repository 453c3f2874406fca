# cython: boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False, infer_types=True
"""Compiled insertion of vertices into triangulated polygons, kept Delaunay by flips."""

from __future__ import annotations

import cython
import numpy as np
from cython.cimports.isoembed.c_types import Complex, ConstComplex, ConstInt, ConstReal, Flag, Int, Real
from cython.cimports.isoembed.intrinsic.chart import (
    cross,
    dot,
    from_frame,
    motion,
    moved,
    norm,
    toward,
    turn_at,
)
from cython.cimports.isoembed.intrinsic.loops import (
    Rule,
    edges_between,
    flip_edges,
    following,
    glue,
    preceding,
    push,
    restore_delaunay,
    swap_diagonals,
)
from cython.cimports.isoembed.intrinsic.polygon_loops import Layout
from cython.cimports.libc.math import atan2, hypot, sqrt

from isoembed.intrinsic.loops import empty_stack

BLOCKED = cython.declare(cython.longlong, -1)  # outcomes of a rule, as in `loops`
LEFT = cython.declare(cython.longlong, 0)
FLIPPED = cython.declare(cython.longlong, 1)
OUTSIDE = cython.declare(
    cython.double, 1e-9
)  # in side lengths: a point farther outside a face is searched for in all faces
ON_SIDE = cython.declare(
    cython.double, 1e-11
)  # in longest sides: below this height a vertex is placed on a fixed side
NEAR_SIDE = cython.declare(
    cython.double, 1e-6
)  # in side lengths: below this detour a vertex is placed on another side


@cython.cclass
class Marks(Rule):
    """Delaunay rule of polygons, with the tables updated by flips and splits.

    Attributes
    ----------
    polygons : Layout
    kept : ndarray of bool, shape (3F,)
        Half-edges of kept edges.
    frames : ndarray of int64, shape (3F,)
        Index in `axes` of the direction of the x axis at each corner's vertex.
    axes : ndarray, shape (3F,)
    leaving : ndarray of int64, shape (V,)
        Some half-edge leaving each vertex.
    sizes : ndarray, shape (number of polygons,)
        Longest side of each polygon, or of a triangle in it.
    simple : bool
        Whether flips that create multiple edges are excluded.
    """

    polygons: Layout
    kept: Flag[::1]
    frames: Int[::1]
    axes: Real[::1]
    leaving: Int[::1]
    sizes: Real[::1]
    simple: cython.bint

    def __init__(self, polygons: Layout, kept, frames, axes, leaving, sizes, simple):
        self.polygons, self.twins = polygons, polygons.twins
        self.kept, self.frames, self.axes = kept, frames, axes
        self.leaving, self.sizes, self.simple = leaving, sizes, simple

    @cython.cfunc
    @cython.exceptval(check=False)
    def attempt(self, h: cython.longlong) -> cython.longlong:
        mesh = self.polygons
        if mesh.fixed[h]:
            return LEFT
        z, t, curvature = mesh.z, mesh.twins[h], mesh.curvature
        jk, ki, im, mj = following(h), preceding(h), following(t), preceding(t)
        i, j, k, m = z[h], z[t], z[ki], z[mj]
        if curvature != 0:  # chart centered at k: lines from k are straight, and circles are preserved
            i, j, m, k = toward(k, i, curvature), toward(k, j, curvature), toward(k, m, curvature), 0j
        a, b, c, d, e = i - k, j - k, j - m, i - m, m - k
        aa, bb, cc, dd, ee = dot(a, a), dot(b, b), dot(c, c), dot(d, d), dot(e, e)
        sine = cross(a, b) * dot(c, d) + dot(a, b) * cross(c, d)  # of the sum of the angles at k and m
        # tolerance of the excess over pi of two angles, in radians
        if sine >= -1e-9 * sqrt(aa * bb * cc * dd):
            return LEFT
        # thinner triangles are not resolved by the coordinates
        if not (cross(a, e) > 1e-14 * max(aa, dd, ee) and cross(e, b) > 1e-14 * max(bb, cc, ee)):
            return BLOCKED
        if self.simple and edges_between(ki, mesh.corners[mj], mesh.corners, mesh.twins) > 0:
            return BLOCKED
        _copy(jk, t, mesh, self)
        _copy(im, h, mesh, self)
        _copy(mj, jk, mesh, self)
        _copy(ki, im, mesh, self)
        swap_diagonals(h, mesh.corners, mesh.twins)
        _join(jk, im, mesh, self)
        self.leaving[mesh.corners[h]] = h
        self.leaving[mesh.corners[ki]] = ki
        self.leaving[mesh.corners[t]] = t
        self.leaving[mesh.corners[mj]] = mj
        return FLIPPED


@cython.cfunc
@cython.exceptval(check=False)
def insert(
    v: Int, p: Complex, start: Int, new: Int, polygons: Layout, marks: Marks, stack: Int[::1]
) -> cython.void:
    """Insert a vertex into a polygon.

    Parameters
    ----------
    v : int
    p : complex
        Position of the vertex.
    start : int
        Face of the polygon at which the search starts.
    new : int
        First of six unused half-edges; ``marks.axes[new]`` is the direction of the x axis at the vertex.
    polygons : Layout
    marks : Marks
    stack : ndarray
        Empty stack, as from `empty_stack`.
    """
    twins = polygons.twins
    f = face_at(p, start, polygons, new // 3)
    s = _side_at(p, f, polygons, marks.sizes[polygons.cells[f]])
    if s < 0:
        g = f
        _split_face(v, p, 3 * f, new, polygons, marks)
    else:
        q, turn = _across(p, s, twins[s], polygons)
        marks.axes[new + 3] = marks.axes[new] + turn
        _split_side(v, p, s, new, polygons, marks)
        t = twins[s]  # may have changed: both can be sides of one face
        g = t // 3
        _split_side(v, q, t, new + 3, polygons, marks)
        glue(twins[t], new + 3, twins)
        glue(t, new, twins)
    for part in range(4):
        first = 3 * f if part == 0 else 3 * g if part == 1 else new if part == 2 else new + 3
        for h in range(first, first + 3):
            marks.leaving[polygons.corners[h]] = h
            push(h, stack, twins)
    restore_delaunay(stack, marks)


@cython.ccall
@cython.exceptval(check=False)
def face_at(p: Complex, start: Int, polygons: Layout, n: Int) -> Int:
    """Face, out of n, that contains a point of a polygon up to rounding; the search begins at `start`."""
    f: Int = start
    came: Int = -1
    go: Int
    for _ in range(n):
        go = -1
        least: Real = 0.0
        for h in range(3 * f, 3 * f + 3):
            depth = _distance(p, h, polygons)
            if h != came and not polygons.fixed[h] and depth < least:
                go, least = h, depth
        if go < 0:
            break
        came = polygons.twins[go]
        f = came // 3
    best = _depth(p, f, polygons)
    if best < -OUTSIDE:  # the walk failed: try all faces
        for g in range(n):
            if polygons.cells[g] == polygons.cells[start]:
                depth = _depth(p, g, polygons)
                if depth > best:
                    f, best = g, depth
    return f


@cython.cfunc
@cython.exceptval(check=False)
def _distance(p: Complex, h: Int, polygons: Layout) -> Real:
    """Signed distance of a point from the line of a half-edge, positive inside, divided by its length."""
    side, arm = _seen(p, h, polygons)
    return cross(side, arm) / dot(side, side)


@cython.cfunc
@cython.exceptval(check=False)
def _seen(p: Complex, h: Int, polygons: Layout) -> tuple[cython.doublecomplex, cython.doublecomplex]:
    """End of a half-edge and a point, both in the chart centered at its start."""
    z, k = polygons.z, polygons.curvature
    return toward(z[h], z[following(h)], k), toward(z[h], p, k)


@cython.cfunc
@cython.exceptval(check=False)
def _depth(p: Complex, f: Int, polygons: Layout) -> Real:
    h = 3 * f
    return min(_distance(p, h, polygons), _distance(p, h + 1, polygons), _distance(p, h + 2, polygons))


@cython.cfunc
@cython.exceptval(check=False)
def _side_at(p: Complex, f: Int, polygons: Layout, size: Real) -> Int:
    """Half-edge of a face to be split by a point in the face; -1 if the point is well inside."""
    fixed = polygons.fixed
    least: Real = 1.0
    s: Int = -1
    for h in range(3 * f, 3 * f + 3):
        side, arm = _seen(p, h, polygons)
        height = cross(side, arm) / dot(side, side)
        if fixed[h]:
            # Fixed sides take precedence: a point on one must not be placed on another side.
            share = height * norm(side) / (ON_SIDE * size) - 1
            if share >= 0:
                continue
        else:
            foot = dot(arm, side) / dot(side, side)
            detour: Real = 0.0
            if height > 0:
                for end in range(2):
                    along = foot if end == 0 else 1 - foot
                    way = hypot(along, height)
                    detour += height * height / (way + along) if along > 0 else way - along
            share = detour / NEAR_SIDE
        if share < least:
            least, s = share, h
    if s >= 0:
        t = polygons.twins[s]
        q = _across(p, s, t, polygons)[0]
        if not (_cuts(p, s, polygons) and _cuts(q, t, polygons)):
            return -1
    return s


@cython.cfunc
@cython.exceptval(check=False)
def _across(p: Complex, s: Int, t: Int, polygons: Layout) -> tuple[cython.doublecomplex, cython.double]:
    """Point near a side in the coordinates of the face across, and rotation angle of the axes to these."""
    z, start, k = polygons.z, polygons.z[following(t)], polygons.curvature
    if k != 0:
        turn, shift = motion(start, z[t], z[s], z[following(s)], k)
        return moved(p, turn, shift, k), -turn_at(p, turn, shift, k)
    here, there = z[following(s)] - z[s], z[t] - start
    size = dot(here, here)
    c, d = dot(there, here) / size, cross(here, there) / size
    return from_frame(start, p - z[s], c, d), -atan2(d, c)


@cython.cfunc
@cython.exceptval(check=False)
def _cuts(p: Complex, s: Int, polygons: Layout) -> cython.bint:
    """Whether a point on a side and the opposite corner form two positively oriented triangles."""
    z, k = polygons.z, polygons.curvature
    tip = z[preceding(s)]
    arm = toward(tip, p, k)
    return cross(toward(tip, z[s], k), arm) > 0 and cross(arm, toward(tip, z[following(s)], k)) > 0


@cython.cfunc
@cython.exceptval(check=False)
def _split_face(v: Int, p: Complex, a: Int, new: Int, polygons: Layout, marks: Marks) -> cython.void:
    """Connect a vertex to the corners of the face of half-edge a."""
    b, c = following(a), preceding(a)
    m, n = new, new + 3
    polygons.cells[m // 3] = polygons.cells[n // 3] = polygons.cells[a // 3]
    _copy(b, m, polygons, marks)
    glue(m, polygons.twins[b], polygons.twins)
    _copy(c, n, polygons, marks)
    glue(n, polygons.twins[c], polygons.twins)
    _spoke(c, n + 1, a, v, p, new, polygons, marks)
    _spoke(m + 2, b, m, v, p, new, polygons, marks)
    _spoke(n + 2, m + 1, n, v, p, new, polygons, marks)


@cython.cfunc
@cython.exceptval(check=False)
def _spoke(
    away: Int, back: Int, start: Int, v: Int, p: Complex, new: Int, polygons: Layout, marks: Marks
) -> cython.void:
    """Connect a vertex to a corner by half-edges away from it and back."""
    _copy(start, back, polygons, marks)
    _set_corner(away, v, p, new, polygons, marks)
    _join(away, back, polygons, marks)


@cython.cfunc
@cython.exceptval(check=False)
def _split_side(v: Int, p: Complex, s: Int, m: Int, polygons: Layout, marks: Marks) -> cython.void:
    """Split half-edge s by a vertex and connect it to the opposite corner; the second part m is not glued."""
    a, b = following(s), preceding(s)
    polygons.cells[m // 3] = polygons.cells[s // 3]
    _copy(a, m + 1, polygons, marks)
    _copy(b, m + 2, polygons, marks)
    _copy(s, m, polygons, marks)
    glue(m + 1, polygons.twins[a], polygons.twins)
    _set_corner(a, v, p, m, polygons, marks)
    _set_corner(m, v, p, m, polygons, marks)
    _join(a, m + 2, polygons, marks)


@cython.cfunc
@cython.exceptval(check=False)
def _copy(h: Int, to: Int, polygons: Layout, marks: Marks) -> cython.void:
    """Copy all data of a half-edge except its twin."""
    polygons.corners[to], polygons.z[to] = polygons.corners[h], polygons.z[h]
    polygons.fixed[to] = polygons.fixed[h]
    marks.kept[to], marks.frames[to] = marks.kept[h], marks.frames[h]


@cython.cfunc
@cython.exceptval(check=False)
def _set_corner(h: Int, v: Int, p: Complex, frame: Int, polygons: Layout, marks: Marks) -> cython.void:
    polygons.corners[h], polygons.z[h], marks.frames[h] = v, p, frame


@cython.cfunc
@cython.exceptval(check=False)
def _join(g: Int, h: Int, polygons: Layout, marks: Marks) -> cython.void:
    """Glue two half-edges to an edge inside a polygon."""
    glue(g, h, polygons.twins)
    marks.kept[g] = marks.kept[h] = polygons.fixed[g] = polygons.fixed[h] = False


def seen_sides(polygons: Layout):
    """End of each half-edge in the chart centered at its start, shape (3F,)."""
    z = polygons.z
    sides: Complex[::1] = np.empty(z.shape[0], dtype=np.complex128)
    for h in range(z.shape[0]):
        sides[h] = toward(z[h], z[following(h)], polygons.curvature)
    return np.asarray(sides)


def insert_all(
    order: ConstInt[::1],
    near: ConstInt[::1],
    faces: ConstInt[::1],
    places: ConstComplex[::1],
    axis: ConstReal[::1],
    polygons: Layout,
    marks: Marks,
):
    """Insert vertices near others, given their faces, and positions and axes in these."""
    new = polygons.twins.shape[0] - 6 * order.shape[0]
    flip_edges(np.arange(new), marks)
    stack: Int[::1] = empty_stack(polygons.twins.shape[0])
    for k in range(order.shape[0]):
        v, u = order[k], near[k]
        marks.axes[new] = axis[v]
        start = _face_near(marks.leaving[u], faces[v], polygons)
        insert(v, places[v], start, new, polygons, marks, stack)
        new += 6
    if marks.simple:  # retry flips blocked by multiple edges that no longer exist
        flip_edges(np.arange(new), marks)


@cython.cfunc
@cython.exceptval(check=False)
def _face_near(h: Int, f: Int, polygons: Layout) -> Int:
    """Face in the polygon of face f at the start of half-edge h; f if there is none."""
    if h < 0:
        return f
    e = h
    while polygons.cells[e // 3] != polygons.cells[f]:
        e = polygons.twins[preceding(e)]
        if e == h:
            return f
    return e // 3
