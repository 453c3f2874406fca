# cython: boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False, infer_types=True
"""Loops over triangles that are laid out in polygons: lines across them, and vertices put into them.

Straight lines go across triangles that are unfolded one after another in a `chart`.  A line starts at the
origin and runs along the positive x axis.  The triangle that it is in is known by the half-edge through which
it leaves, from a lower to an upper corner, and by the motion that takes the frame of its polygon to that of
the line: the state ``(out, turn, shift)``, so that in the plane corner h lies at ``turn z[h] + shift``.
"""

from __future__ import annotations

import cython
import numpy as np
from cython.cimports.libc.math import atan2, atanh, hypot, isnan, sqrt

if cython.compiled:
    from cython.cimports.isoembed.intrinsic.chart import (
        argument,
        coordinate,
        cross,
        distance,
        dot,
        from_frame,
        motion,
        moved,
        norm,
        point,
        polar,
        stretch,
        toward,
        turn_at,
    )
else:
    from isoembed.intrinsic.chart import (
        argument,
        coordinate,
        cross,
        distance,
        dot,
        from_frame,
        motion,
        moved,
        norm,
        point,
        polar,
        stretch,
        toward,
        turn_at,
    )
if cython.compiled:
    from cython.cimports.isoembed.intrinsic.loops import (
        Mesh,
        Rule,
        corner_angle,
        edges_between,
        flip_edges,
        following,
        glue,
        leaving_halfedges,
        modulo,
        preceding,
        push,
        restore_delaunay,
        swap_diagonals,
        third_corner,
        total_angle,
    )
else:
    from isoembed.intrinsic.loops import (
        Mesh,
        Rule,
        corner_angle,
        edges_between,
        flip_edges,
        following,
        glue,
        leaving_halfedges,
        modulo,
        preceding,
        push,
        restore_delaunay,
        swap_diagonals,
        third_corner,
        total_angle,
    )
if cython.compiled:
    from cython.cimports.isoembed.space.trigonometry import cs, sn
else:
    from isoembed.space.trigonometry import cs, sn

from isoembed.intrinsic.loops import empty_stack

Int = cython.typedef(cython.longlong)
ConstInt = cython.typedef(cython.const[cython.longlong])
Real = cython.typedef(cython.double)
ConstReal = cython.typedef(cython.const[cython.double])
Flag = cython.typedef(cython.uchar)
ConstFlag = cython.typedef(cython.const[cython.uchar])
Complex = cython.typedef(cython.doublecomplex)
ConstComplex = cython.typedef(cython.const[cython.doublecomplex])

PI = cython.declare(cython.double, 3.141592653589793)
BLOCKED = cython.declare(cython.longlong, -1)  # outcomes of a rule, as in `loops`
LEFT = cython.declare(cython.longlong, 0)
FLIPPED = cython.declare(cython.longlong, 1)
# a line may cross so many more triangles than there are: round a needle
EXTRA_CROSSINGS = cython.declare(cython.longlong, 10**6)
OUTSIDE = cython.declare(
    cython.double, 1e-9
)  # side lengths: a point farther outside of a face is searched for in all
ON_SIDE = cython.declare(
    cython.double, 1e-11
)  # longest sides: height at which a vertex is put on a side that is not to be flipped
NEAR_SIDE = cython.declare(
    cython.double, 1e-6
)  # side lengths: detour by way of a vertex that is put on another side


@cython.cclass
class Layout:
    """The arrays of `Polygons`, which are changed in place."""

    corners: Int[::1]
    twins: Int[::1]
    z: Complex[::1]
    fixed: Flag[::1]
    cells: Int[::1]
    curvature: cython.double

    def __init__(self, polygons):
        self.corners, self.twins, self.z = polygons.corners, polygons.twins, polygons.z
        self.fixed, self.cells, self.curvature = polygons.fixed, polygons.cells, polygons.curvature


def unfolded(mesh: Mesh, fixed: ConstFlag[::1]):
    """Place the corners (3F,), from face to face but for fixed edges, and number the parts (F,)."""
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
    """Which cells are convex polygons, by number.

    A cell of n faces that hang together at n - 1 edges has no vertex inside and no hole; and if it has no
    reflex corner either, it does not overlap itself.
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
            # The corner from this side counterclockwise to the one before it.
            angle: Real = 0.0
            e = h
            for _ in range(fixed.shape[0]):
                angle += corner_angle(e, mesh)
                if fixed[preceding(e)]:
                    break
                e = mesh.twins[preceding(e)]
            if angle > PI + 1e-9:  # radians of rounding
                convex[c] = False
    return np.asarray(convex) & (np.asarray(inner) == 2 * (np.asarray(size) - 1))


def first_sides(twins: ConstInt[::1], fixed: ConstFlag[::1]):
    """The side of the polygon that comes first counterclockwise at each corner of each face, shape (3F,)."""
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
def angle_around(h: Int, polygons: Layout) -> Real:
    """Sum of the angles at the vertex that a half-edge leaves."""
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
def sector(h: Int, direction: Real, total: Real, mesh: Mesh) -> tuple[cython.longlong, cython.double]:
    """Triangle into which a direction points.

    Parameters
    ----------
    h : int
        Any half-edge that leaves the vertex; the search goes counterclockwise from it.
    direction : float
    total : float
        The angle around the vertex.
    mesh : Mesh

    Returns
    -------
    int, float
        The half-edge next clockwise of the direction, and the angle from it to the direction.
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
    h: Int, state: tuple[cython.longlong, cython.doublecomplex, cython.doublecomplex], polygons: Layout
) -> Complex:
    """Where a corner of the triangle lies."""
    turn, shift = state[1], state[2]
    if polygons.curvature == 0:
        return turn * polygons.z[h] + shift
    return moved(polygons.z[h], turn, shift, polygons.curvature)


@cython.ccall
@cython.exceptval(check=False)
def from_corner(
    h: Int, offset: Real, polygons: Layout
) -> tuple[cython.longlong, cython.doublecomplex, cython.doublecomplex]:
    """The line that starts at a vertex, at an angle from a half-edge into its triangle."""
    side = toward(polygons.z[h], polygons.z[following(h)], polygons.curvature)
    length = norm(side)
    turn = point(side.real / length, -side.imag / length) * polar(1.0, -offset)
    return following(h), turn, -turn * polygons.z[h]


@cython.ccall
def from_inside(
    f: Int, start: Complex, angle: Real, polygons: Layout
) -> tuple[cython.longlong, cython.doublecomplex, cython.doublecomplex]:
    """The line that starts in a face, at an angle from the x axis of its polygon."""
    turn = polar(1.0, -angle)
    shift = -turn * start
    z: Complex[::1] = np.empty(3, dtype=np.complex128)
    for c in range(3):
        z[c] = moved(polygons.z[3 * f + c], turn, shift, polygons.curvature)
    k: Int = -1
    for c in range(3):
        if z[c].imag < 0 and z[(c + 1) % 3].imag >= 0:
            k = c
    if k < 0:  # along a side, and rounding puts all corners above or all below: it leaves at the corner ahead
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
    """The line one triangle on."""
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
    state: tuple[cython.longlong, cython.doublecomplex, cython.doublecomplex], length: Real, polygons: Layout
) -> cython.bint:
    """Whether the line is still in its triangle at this distance from its start."""
    lower = place(state[0], state, polygons)
    upper = place(following(state[0]), state, polygons)
    k = polygons.curvature
    if k == 0:
        return (upper.imag - lower.imag) * (lower.real - length) >= (upper.real - lower.real) * lower.imag
    # On hyperboloid or sphere the point of the axis between them is a sum of both.
    sine = lower.real * upper.imag - upper.real * lower.imag
    cosine = (1 - k / 4 * dot(lower, lower)) * upper.imag - (1 - k / 4 * dot(upper, upper)) * lower.imag
    return sine * cs(length, k) >= cosine * sn(length, k)


@cython.ccall
@cython.exceptval(check=False)
def straight(
    state: tuple[cython.longlong, cython.doublecomplex, cython.doublecomplex], length: Real, polygons: Layout
) -> tuple[cython.longlong, cython.doublecomplex, cython.doublecomplex]:
    """Follow a line over a distance; ``out`` is -1 if that leads across absurdly many triangles."""
    for _ in range(polygons.twins.shape[0] + EXTRA_CROSSINGS):
        if reaches(state, length, polygons):
            return state
        state = crossed(state, polygons)
        if isnan(state[2].real):
            break
    return -1, state[1], state[2]


@cython.cclass
class Marks(Rule):
    """What flips and splits of polygons carry along, and the rule of their Delaunay triangulation.

    Attributes
    ----------
    polygons : Layout
    kept : ndarray of bool, shape (3F,)
        The half-edges of edges that are kept.
    frames : ndarray of int64, shape (3F,)
        Where in `axes` the direction of a corner's vertex that is the x axis is to be found.
    axes : ndarray, shape (3F,)
    leaving : ndarray of int64, shape (V,)
        A half-edge that leaves each vertex.
    sizes : ndarray, shape (number of polygons,)
        The longest side of each polygon, or of a triangle in it.
    simple : bool
        Whether flips are to join no two vertices that are joined already.
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
        if curvature != 0:  # seen from k, where lines from there are straight; circles are circles
            i, j, m, k = toward(k, i, curvature), toward(k, j, curvature), toward(k, m, curvature), 0j
        a, b, c, d, e = i - k, j - k, j - m, i - m, m - k
        aa, bb, cc, dd, ee = dot(a, a), dot(b, b), dot(c, c), dot(d, d), dot(e, e)
        sine = cross(a, b) * dot(c, d) + dot(a, b) * cross(c, d)  # of the sum of the angles at k and m
        # excess over pi of two angles, in radians, that is left
        if sine >= -1e-9 * sqrt(aa * bb * cc * dd):
            return LEFT
        # coordinates do not hold thinner triangles
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
        Where it lies.
    start : int
        A face of the polygon from which it is to be searched.
    new : int
        Six half-edges from here on are unused, but ``marks.axes[new]`` is its direction that is the x axis.
    polygons : Layout
    marks : Marks
    stack : ndarray
        Of `isoembed.intrinsic.delaunay`, empty.
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
        t = twins[s]  # which may have been moved: both can be sides of one face
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
    """Face of a polygon in which a point lies, or nearly so, of n faces; the search begins at another."""
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
    if best < -OUTSIDE:  # led astray: try all
        for g in range(n):
            if polygons.cells[g] == polygons.cells[start]:
                depth = _depth(p, g, polygons)
                if depth > best:
                    f, best = g, depth
    return f


@cython.cfunc
@cython.exceptval(check=False)
def _distance(p: Complex, h: Int, polygons: Layout) -> Real:
    """Signed distance of a point from the line of a half-edge, positive inside, over the length of that."""
    side, arm = _seen(p, h, polygons)
    return cross(side, arm) / dot(side, side)


@cython.cfunc
@cython.exceptval(check=False)
def _seen(p: Complex, h: Int, polygons: Layout) -> tuple[cython.doublecomplex, cython.doublecomplex]:
    """The end of a half-edge and a point, both as seen from its start."""
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
    """The half-edge of a face that is to be split by a point in it; -1 if the point is well inside."""
    fixed = polygons.fixed
    least: Real = 1.0
    s: Int = -1
    for h in range(3 * f, 3 * f + 3):
        side, arm = _seen(p, h, polygons)
        height = cross(side, arm) / dot(side, side)
        if fixed[h]:
            # It comes first: a point on it that is put on another is never put on it.
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
    """A point near a side in the coordinates of the face across, and by what angle to these the axes turn."""
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
    """Whether a point on a side and the corner across make two triangles of which neither is turned over."""
    z, k = polygons.z, polygons.curvature
    tip = z[preceding(s)]
    arm = toward(tip, p, k)
    return cross(toward(tip, z[s], k), arm) > 0 and cross(arm, toward(tip, z[following(s)], k)) > 0


@cython.cfunc
@cython.exceptval(check=False)
def _split_face(v: Int, p: Complex, a: Int, new: Int, polygons: Layout, marks: Marks) -> cython.void:
    """Join a vertex to the corners of the face of half-edge a."""
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
    """Join a vertex to a corner, by half-edges away from it and back."""
    _copy(start, back, polygons, marks)
    _set_corner(away, v, p, new, polygons, marks)
    _join(away, back, polygons, marks)


@cython.cfunc
@cython.exceptval(check=False)
def _split_side(v: Int, p: Complex, s: Int, m: Int, polygons: Layout, marks: Marks) -> cython.void:
    """Put a vertex on half-edge s and join it to the corner across; its second part m is not glued."""
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
    """Copy all that is known of a half-edge but its twin."""
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
    """Make two half-edges an edge inside a polygon."""
    glue(g, h, polygons.twins)
    marks.kept[g] = marks.kept[h] = polygons.fixed[g] = polygons.fixed[h] = False


def seen_sides(polygons: Layout):
    """The end of each half-edge as seen from its start, shape (3F,)."""
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
    """Insert vertices near others, of which the faces, and places and axes in these, are given."""
    new = polygons.twins.shape[0] - 6 * order.shape[0]
    flip_edges(np.arange(new), marks)
    stack: Int[::1] = empty_stack(polygons.twins.shape[0])
    for k in range(order.shape[0]):
        v, u = order[k], near[k]
        marks.axes[new] = axis[v]
        start = _face_near(marks.leaving[u], faces[v], polygons)
        insert(v, places[v], start, new, polygons, marks, stack)
        new += 6
    if marks.simple:  # what joined two vertices that were joined already, and are no more
        flip_edges(np.arange(new), marks)


@cython.cfunc
@cython.exceptval(check=False)
def _face_near(h: Int, f: Int, polygons: Layout) -> Int:
    """A face at the vertex that a half-edge leaves, if one does, in the polygon of face f; or else f."""
    if h < 0:
        return f
    e = h
    while polygons.cells[e // 3] != polygons.cells[f]:
        e = polygons.twins[preceding(e)]
        if e == h:
            return f
    return e // 3


def locate(mesh: Mesh, laid: Layout, removal, number: ConstInt[::1]):
    """The faces in which the removed vertices lie, and where: barycentric coordinates.

    Returns
    -------
    ndarray of int, shape (V,)
    ndarray, shape (V, 3)
    ndarray, shape (V,)
        The direction at the vertex that is that of the x axis of the polygon.
    int
        A vertex that is lost, or -1.
    """
    n = number.shape[0]
    faces: Int[::1] = np.zeros(n, dtype=np.int64)
    barycentric: Real[:, ::1] = np.zeros((n, 3))
    axis: Real[::1] = np.zeros(n)
    places: Complex[::1] = np.empty(n, dtype=np.complex128)  # in the polygon
    removed: ConstInt[::1] = removal.removed
    anchors: ConstInt[::1] = removal.anchors
    directions: ConstReal[::1] = removal.directions
    way_lengths: ConstReal[::1] = removal.distances
    backs: ConstReal[::1] = removal.backs
    leaving: Int[::1] = leaving_halfedges(mesh.corners, n - removed.shape[0])
    h: Int
    f: Int
    state: tuple[cython.longlong, cython.doublecomplex, cython.doublecomplex]
    z: Complex[::1] = np.empty(3, dtype=np.complex128)
    areas: Real[::1] = np.empty(3)
    scales: Real[::1] = np.empty(3)
    for k in range(removed.shape[0] - 1, -1, -1):
        v, u = removed[k], anchors[k]
        way, far = directions[k], way_lengths[k]
        if number[u] >= 0:
            h = leaving[number[u]]
            h, offset = sector(h, way, total_angle(h, mesh), mesh)
            state = from_corner(h, offset, laid)
        else:
            state = from_inside(faces[u], places[u], way - axis[u], laid)
        state = straight(state, far, laid)
        if state[0] < 0:
            return np.asarray(faces), np.asarray(barycentric), np.asarray(axis), v
        f = state[0] // 3
        here = point(coordinate(far, laid.curvature), 0.0)
        for i in range(3):
            z[i] = toward(here, place(3 * f + i, state, laid), laid.curvature)
            scales[i] = stretch(z[i], laid.curvature)
            z[i] = z[i] / scales[i]
        for i in range(3):
            areas[i] = max(cross(z[(i + 1) % 3], z[(i + 2) % 3]), 0.0)
        total: Real = 0.0
        for i in range(3):
            total += areas[i] * (2 / scales[i] - 1)
        for i in range(3):
            barycentric[v, i] = areas[i] / total
        faces[v] = f
        if laid.curvature == 0:
            places[v] = 0j
            for i in range(3):
                places[v] = places[v] + barycentric[v, i] * laid.z[3 * f + i]
        else:
            places[v] = toward(state[2], here, laid.curvature) * state[1].conjugate()
        axis[v] = backs[k] - PI + turn_at(places[v], state[1], state[2], laid.curvature)
    return np.asarray(faces), np.asarray(barycentric), np.asarray(axis), -1


def set_out(original: Mesh, final: Mesh, polygons: Layout, halfedges: ConstInt[::1], tilt: Real):
    """The half-edges next clockwise of those given, which are turned by so much, and the angles between."""
    number: Int[::1] = np.full(original.corners.shape[0], -1, dtype=np.int64)
    for e in range(halfedges.shape[0]):
        number[halfedges[e]] = e
    first: Int[::1] = np.empty(halfedges.shape[0], dtype=np.int64)
    angles: Real[::1] = np.empty(halfedges.shape[0])
    n: Int = np.max(original.corners) + 1
    old: Int[::1] = leaving_halfedges(original.corners, n)
    new: Int[::1] = leaving_halfedges(final.corners, np.max(final.corners) + 1)
    g: Int
    angle: Real
    for v in range(n):
        total = angle_around(new[v], polygons)
        # Both go counterclockwise, so that the search begins where the last one ended.
        h, g = old[v], new[v]
        while True:
            e = number[h]
            if e >= 0:
                g, angle = sector(g, original.directions[h] + tilt, total, final)
                first[e], angles[e] = g, angle
            h = original.twins[preceding(h)]
            if h == old[v]:
                break
    return np.asarray(first), np.asarray(angles)


def follow(
    first: ConstInt[::1],
    angles: ConstReal[::1],
    lengths: ConstReal[::1],
    goals: ConstInt[::1],
    polygons: Layout,
):
    """Crossings of each path, and where it ends if it sets out along the x axis; not a number if astray."""
    g: Int
    corners, curvature = polygons.corners, polygons.curvature
    counts: Int[::1] = np.zeros(first.shape[0], dtype=np.int64)
    meet: Complex[::1] = np.full(first.shape[0], complex(np.nan, np.nan))
    for e in range(first.shape[0]):
        far = lengths[e]
        goal = point(coordinate(far, curvature), 0.0)
        state = from_corner(first[e], angles[e], polygons)
        # rounding of a place, in coordinates; a path that misses by 1e-6 of its length went elsewhere
        near = 1e-6 * far + 2.0**-48 * (norm(polygons.z[first[e]]) + norm(polygons.z[state[0]]))
        found: cython.bint = False
        for start in range(2):
            g = state[0] if start == 0 else following(state[0])
            end = place(g, state, polygons)
            if not found and corners[g] == goals[e] and norm(toward(goal, end, curvature)) <= near:
                meet[e] = end
                found = True
        if found:
            continue
        for k in range(corners.shape[0] + EXTRA_CROSSINGS):
            if reaches(state, far + near, polygons):
                break
            g = preceding(polygons.twins[state[0]])
            state = crossed(state, polygons)
            end = place(g, state, polygons)
            if isnan(end.real):  # by triangles too thin for a direction: round a vertex for ever
                break
            if corners[g] == goals[e] and norm(toward(goal, end, curvature)) <= near:
                meet[e], counts[e] = end, k + 1
                break
    return np.asarray(counts), np.asarray(meet)


def cross_all(
    first: ConstInt[::1],
    angles: ConstReal[::1],
    offsets: ConstInt[::1],
    meet: ConstComplex[::1],
    polygons: Layout,
):
    """Half-edges that are crossed, and where, by paths from the origin straight to where they end."""
    halfedges: Int[::1] = np.empty(offsets[first.shape[0]], dtype=np.int64)
    parameters: Real[::1] = np.empty(offsets[first.shape[0]])
    for e in range(first.shape[0]):
        if offsets[e] == offsets[e + 1]:
            continue
        state = from_corner(first[e], angles[e], polygons)
        for k in range(offsets[e], offsets[e + 1]):
            halfedges[k] = state[0]
            lower = place(state[0], state, polygons)
            upper = place(following(state[0]), state, polygons)
            below, above = cross(lower, meet[e]), cross(meet[e], upper)
            parameters[k] = _parameter(lower, upper, below, above, polygons.curvature)
            state = crossed(state, polygons)
    return np.asarray(halfedges), np.asarray(parameters)


@cython.cfunc
@cython.exceptval(check=False)
def _parameter(lower: Complex, upper: Complex, below: Real, above: Real, k: Real) -> Real:
    """Where a side is crossed by a line on which its ends have these products: part of its length."""
    if k == 0:
        along = below + above
        return min(max(below / along, 0.0), 1.0) if along > 0 else 0.5
    # On hyperboloid or sphere the crossing is `above` times one end and `below` times the other.
    below, above = max(below / stretch(lower, k), 0.0), max(above / stretch(upper, k), 0.0)
    length = distance(toward(lower, upper, k), k)
    sine, cosine = below * sn(length, k), above + below * cs(length, k)
    if not (below + above > 0 and length > 0):
        return 0.5
    root = sqrt(abs(k))
    if k > 0:
        return min(atan2(root * sine, cosine) / (root * length), 1.0)
    return min(atanh(min(root * sine / cosine, 1.0 - 2.0**-53)) / (root * length), 1.0)


def balance(path: ConstInt[::1], tables: Mesh, columns: Int[::1], values: Real[::1]):
    """The half-edges around one path that crosses some, and their stresses."""
    n, l = path.shape[0], tables.lengths
    tip: Int
    head: Int
    tail: Int
    z: Complex[::1] = np.zeros(n + 3, dtype=np.complex128)
    load: Complex[::1] = np.zeros(n + 3, dtype=np.complex128)
    near: Int[::1] = np.zeros(n, dtype=np.int64)
    far: Int[::1] = np.zeros(n, dtype=np.int64)  # the ends of what is crossed
    h = path[0]
    z[1] = point(l[preceding(h)], 0.0)
    z[2] = _third(z[0], z[1], l[preceding(h)], l[following(h)], l[h])
    tail, head = 1, 2
    for k in range(n):
        near[k], far[k], tip = tail, head, k + 3
        g = tables.twins[path[k]]
        z[tip] = _third(z[head], z[tail], l[g], l[preceding(g)], l[following(g)])
        columns[2 * k], columns[2 * k + 1] = following(g), preceding(g)
        if k + 1 < n:
            if path[k + 1] == preceding(g):
                tail = tip
            else:
                head = tip
    end = n + 2
    load[end] = (z[end] - z[0]) / norm(z[end] - z[0])
    for k in range(n - 1, -1, -1):
        _carry(k + 3, near[k], far[k], z, load, values[2 * k : 2 * k + 2])
    columns[2 * n], columns[2 * n + 1], columns[2 * n + 2] = following(h), h, preceding(h)
    _carry(2, 0, 1, z, load, values[2 * n : 2 * n + 2])
    values[2 * n + 2] = load[1].real


@cython.cfunc
@cython.exceptval(check=False)
def _third(a: Complex, b: Complex, base: Real, at_a: Real, at_b: Real) -> Complex:
    """The corner to the left of the side from a to b, of this length, at these distances from both."""
    along = (base * base + (at_a - at_b) * (at_a + at_b)) / (2 * base)
    height = sqrt(max((at_a - along) * (at_a + along), 0.0))
    return a + (b - a) / base * point(along, height)


@cython.cfunc
@cython.exceptval(check=False)
def _carry(
    v: Int, a: Int, b: Int, z: ConstComplex[::1], load: Complex[::1], stresses: Real[::1]
) -> cython.void:
    """Balance the load at v by the edges to a and b, and hand it on to these."""
    to_a, to_b = z[v] - z[a], z[v] - z[b]
    to_a, to_b = to_a / norm(to_a), to_b / norm(to_b)
    area = cross(to_a, to_b)
    stresses[0], stresses[1] = cross(load[v], to_b) / area, cross(to_a, load[v]) / area
    load[a] = load[a] + stresses[0] * to_a
    load[b] = load[b] + stresses[1] * to_b
