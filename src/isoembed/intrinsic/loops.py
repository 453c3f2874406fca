# cython: boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False, infer_types=True
"""Loops over half-edges: walks around vertices, flips and what they are made for, vertices taken out."""

from __future__ import annotations

import cython
import numpy as np
from cython.cimports.libc.math import atan2, floor, hypot, sin, sqrt

if cython.compiled:
    from cython.cimports.isoembed.intrinsic.chart import (
        argument,
        coordinate,
        cross,
        distance,
        dot,
        from_frame,
        norm,
        point,
        polar,
        toward,
    )
else:
    from isoembed.intrinsic.chart import (
        argument,
        coordinate,
        cross,
        distance,
        dot,
        from_frame,
        norm,
        point,
        polar,
        toward,
    )
if cython.compiled:
    from cython.cimports.isoembed.space.trigonometry import (
        amplitude,
        angle_between,
        apex,
        arc,
        chord,
        cs,
        sn,
        twice_area,
    )
else:
    from isoembed.space.trigonometry import amplitude, angle_between, apex, arc, chord, cs, sn, twice_area

Int = cython.typedef(cython.longlong)
ConstInt = cython.typedef(cython.const[cython.longlong])
Int32 = cython.typedef(cython.int)
Real = cython.typedef(cython.double)
ConstReal = cython.typedef(cython.const[cython.double])
Flag = cython.typedef(cython.uchar)
ConstFlag = cython.typedef(cython.const[cython.uchar])
Complex = cython.typedef(cython.doublecomplex)
ConstComplex = cython.typedef(cython.const[cython.doublecomplex])

INF = cython.declare(cython.double, float("inf"))
PI = cython.declare(cython.double, 3.141592653589793)
SLACK = cython.declare(cython.double, 1e-12)  # relative: an edge that is Delaunay to this is left alone
ROUNDING = cython.declare(cython.double, 4e-16)  # of a difference of squared lengths, relative to their sum
THINNEST = cython.declare(
    cython.double, 1e-15
)  # height over longest side: thinner triangles are lost in rounding
THIN = cython.declare(
    cython.double, 1e-8
)  # height over longest side: the sides of a thinner triangle add up in floats
END = cython.declare(cython.longlong, -1)  # on the stack: nothing below
FREE = cython.declare(cython.longlong, -2)  # and not on it
BLOCKED = cython.declare(cython.longlong, -1)  # outcomes of a rule
LEFT = cython.declare(cython.longlong, 0)
FLIPPED = cython.declare(cython.longlong, 1)
NONE = cython.declare(cython.longlong, -1)  # no half-edge
FLIPPED_LOOP = cython.declare(cython.longlong, -2)
MAX_DEGREE = cython.declare(cython.longlong, 16)  # of a vertex that is removed: the time grows with its cube


@cython.ccall
@cython.exceptval(check=False)
def modulo(angle: cython.double, total: cython.double) -> cython.double:
    """The angle less whole turns, from 0 to the total angle."""
    return angle - floor(angle / total) * total


@cython.cclass
class Mesh:
    """The arrays of `HalfEdges`, which are changed in place."""

    def __init__(self, tables):
        self.corners, self.twins, self.lengths = tables.corners, tables.twins, tables.lengths
        self.directions, self.curvature = tables.directions, tables.curvature


@cython.cfunc
@cython.exceptval(check=False)
def following(h: cython.longlong) -> cython.longlong:
    """The next half-edge of the face."""
    return h - 2 if h % 3 == 2 else h + 1


@cython.cfunc
@cython.exceptval(check=False)
def preceding(h: cython.longlong) -> cython.longlong:
    """The half-edge of the face before."""
    return h + 2 if h % 3 == 0 else h - 1


@cython.cfunc
@cython.exceptval(check=False)
def glue(g: cython.longlong, h: cython.longlong, twins: cython.longlong[::1]) -> cython.void:
    """Make two half-edges twins."""
    twins[g], twins[h] = h, g


@cython.ccall
def leaving_halfedges(corners: cython.const[cython.longlong][::1], n: cython.longlong):
    """A half-edge that leaves each of n vertices, shape (n,); -1 where there is none."""
    leaving: Int[::1] = np.full(n, -1, dtype=np.int64)
    for h in range(corners.shape[0]):
        leaving[corners[h]] = h
    return np.asarray(leaving)


def breadth_first(corners: ConstInt[::1], twins: ConstInt[::1]):
    """The vertices in order of their distance from the first, counted in edges, shape (V,)."""
    n = corners.shape[0] // 6 + 2
    leaving: Int[::1] = leaving_halfedges(corners, n)
    order: Int[::1] = np.empty(n, dtype=np.int64)
    met: Flag[::1] = np.zeros(n, dtype=np.bool_)
    order[0], met[0] = 0, True
    count = 1
    for k in range(n):
        start = h = leaving[order[k]]
        while True:
            v = corners[twins[h]]
            if not met[v]:
                met[v] = True
                order[count] = v
                count += 1
            h = twins[preceding(h)]
            if h == start:
                break
    return np.asarray(order)


def by_lowest_corner(corners: ConstInt[::1]):
    """The faces, ordered by their lowest vertices and then by their numbers, shape (F,)."""
    count = corners.shape[0] // 3
    place: Int[::1] = np.zeros(count // 2 + 3, dtype=np.int64)
    for f in range(count):
        place[min(corners[3 * f], min(corners[3 * f + 1], corners[3 * f + 2])) + 1] += 1
    for v in range(1, place.shape[0]):
        place[v] += place[v - 1]
    order: Int[::1] = np.empty(count, dtype=np.int64)
    for f in range(count):
        lowest = min(corners[3 * f], min(corners[3 * f + 1], corners[3 * f + 2]))
        order[place[lowest]] = f
        place[lowest] += 1
    return np.asarray(order)


@cython.cfunc
@cython.exceptval(check=False)
def degree(
    h: cython.longlong, twins: cython.const[cython.longlong][::1], most: cython.longlong
) -> cython.longlong:
    """Number of edges at the vertex that a half-edge leaves, counted no farther than one beyond most."""
    e = h
    for k in range(most + 1):
        e = twins[preceding(e)]
        if e == h:
            return k + 1
    return most + 1


@cython.cfunc
@cython.exceptval(check=False)
def edges_between(
    h: cython.longlong,
    v: cython.longlong,
    corners: cython.const[cython.longlong][::1],
    twins: cython.const[cython.longlong][::1],
) -> cython.longlong:
    """Number of edges from the vertex that a half-edge leaves to v."""
    found = 0
    e = h
    while True:
        if corners[twins[e]] == v:
            found += 1
        e = twins[preceding(e)]
        if e == h:
            return found


@cython.ccall
@cython.exceptval(check=False)
def corner_angle(h: cython.longlong, mesh: Mesh) -> cython.double:
    """Angle of a face at the corner that a half-edge leaves."""
    return angle_between(
        mesh.lengths[h], mesh.lengths[preceding(h)], mesh.lengths[following(h)], mesh.curvature
    )


@cython.ccall
@cython.exceptval(check=False)
def total_angle(h: cython.longlong, mesh: Mesh) -> cython.double:
    """Sum of the angles at the vertex that a half-edge leaves."""
    start = h
    total = 0.0
    while True:
        total += corner_angle(h, mesh)
        h = mesh.twins[preceding(h)]
        if h == start:
            return total


def set_directions(mesh: Mesh):
    """Measure the directions from the lowest half-edge at each vertex."""
    seen: Flag[::1] = np.zeros(mesh.corners.shape[0], dtype=np.bool_)
    for start in range(mesh.corners.shape[0]):
        h = start
        angle = 0.0
        while not seen[h]:
            seen[h] = True
            mesh.directions[h] = angle
            angle += corner_angle(h, mesh)
            h = mesh.twins[preceding(h)]


@cython.ccall
@cython.exceptval(check=False)
def third_corner(
    h: cython.longlong, p: cython.doublecomplex, q: cython.doublecomplex, mesh: Mesh
) -> cython.doublecomplex:
    """Third corner of a triangle laid out in a `chart`, to the left of half-edge h from p to q."""
    l, third, k = mesh.lengths[h], mesh.lengths[preceding(h)], mesh.curvature
    x, y = apex(l, mesh.lengths[following(h)], third, k)
    if k == 0:
        return from_frame(p, q - p, x / l, y / l)
    side, half = toward(p, q, k), cs(third / 2, k)
    scale = norm(side) * half * half
    return toward(-p, from_frame(0j, side, x / scale, y / scale), k)


@cython.cfunc
@cython.exceptval(check=False)
def swap_diagonals(
    h: cython.longlong, corners: cython.longlong[::1], twins: cython.longlong[::1]
) -> cython.void:
    """Replace the edge of a half-edge by the other diagonal of its two triangles, which are not one.

    Of the faces ijk and jim of half-edge i -> j and its twin remain kim, with the other diagonal in the place
    that ``following(h)`` had, and mjk, with it in the place of ``following(twin)``.  Half-edge jk moves to
    the place of the twin, and im to that of h; the caller moves what else belongs to them.
    """
    t = twins[h]
    jk, im = following(h), following(t)
    corners[jk], corners[im] = corners[preceding(t)], corners[preceding(h)]
    glue(t, twins[jk], twins)  # one after the other: they may be glued to each other
    glue(h, twins[im], twins)
    glue(jk, im, twins)


@cython.ccall
@cython.exceptval(check=False)
def flip(h: Int, mesh: Mesh, thinnest: Real) -> cython.bint:
    """Flip the edge of a half-edge as `swap_diagonals`, if its triangles are a strictly convex quadrilateral.

    Returns
    -------
    bool
        False, and nothing is changed, if both sides are one face, or a new triangle would be as thin as
        stated: no higher than that fraction of its longest side.
    """
    lengths, directions, k = mesh.lengths, mesh.directions, mesh.curvature
    t = mesh.twins[h]
    if h // 3 == t // 3:
        return False
    jk, ki, im, mj = following(h), preceding(h), following(t), preceding(t)
    l, length_jk, length_ki, length_im, length_mj = (
        lengths[h],
        lengths[jk],
        lengths[ki],
        lengths[im],
        lengths[mj],
    )
    if k == 0:
        x, y = apex(l, length_jk, length_ki, k)
        u, v = apex(l, length_mj, length_im, k)
        diagonal = hypot(x - u, y + v)
        # Twice the areas of the new triangles.
        at_i = x * v + u * y
        at_j = (l - x) * v + (l - u) * y
    else:
        diagonal, at_i, at_j = _curved_diagonal(l, length_jk, length_ki, length_im, length_mj, k)
    longest_i = max(diagonal, max(length_ki, length_im))
    longest_j = max(diagonal, max(length_mj, length_jk))
    if not (at_i > thinnest * longest_i * longest_i and at_j > thinnest * longest_j * longest_j):
        return False
    if directions.shape[0]:
        at_m, at_k = directions[mesh.twins[im]], directions[mesh.twins[jk]]  # of m -> i and k -> j
        # The angles of the better triangle tell the directions.
        if at_i * longest_j * longest_j > at_j * longest_i * longest_i:
            at_m -= angle_between(length_im, diagonal, length_ki, k)
            at_k = directions[ki] + angle_between(length_ki, diagonal, length_im, k)
        else:
            at_m = directions[mj] + angle_between(length_mj, diagonal, length_jk, k)
            at_k -= angle_between(length_jk, diagonal, length_mj, k)
        directions[t], directions[h] = directions[jk], directions[im]
        directions[jk], directions[im] = at_m, at_k
    swap_diagonals(h, mesh.corners, mesh.twins)
    lengths[t], lengths[h] = length_jk, length_im
    lengths[jk] = lengths[im] = diagonal
    return True


@cython.cfunc
@cython.exceptval(check=False)
def _curved_diagonal(
    l: Real, jk: Real, ki: Real, im: Real, mj: Real, k: Real
) -> tuple[cython.double, cython.double, cython.double]:
    """The other diagonal of two triangles, and longest side times height of the new ones.

    It is the third side of a triangle by a law of cosines in which nothing cancels.
    """
    x, y = apex(l, jk, ki, k)
    u, v = apex(l, mj, im, k)
    sine, difference = sin((atan2(y, x) + atan2(v, u)) / 2), sn((ki - im) / 2, k)
    diagonal = arc(2 * sqrt(difference * difference + sn(ki, k) * sn(im, k) * sine * sine), k)
    at_i = x * v + u * y
    at_j = apex(l, ki, jk, k)[0] * v + apex(l, im, mj, k)[0] * y
    longest_i, longest_j = max(diagonal, max(ki, im)), max(diagonal, max(mj, jk))
    at_i *= longest_i / sn(longest_i, k)
    return diagonal, at_i, at_j * longest_j / sn(longest_j, k)


@cython.cfunc
@cython.exceptval(check=False)
def flip_tracked(h: Int, mesh: Mesh, carried: Tracked, thinnest: Real) -> cython.bint:
    """Flip an edge as `flip` does, and carry along which edges are kept and which half-edges leave."""
    corners, kept, leaving = mesh.corners, carried.kept, carried.leaving
    t = mesh.twins[h]
    jk, im = following(h), following(t)
    if not flip(h, mesh, thinnest):
        return False
    kept[t], kept[h] = kept[jk], kept[im]
    kept[jk] = kept[im] = False
    leaving[corners[h]], leaving[corners[t]] = h, t
    leaving[corners[jk]], leaving[corners[im]] = jk, im
    return True


def empty_stack(n: Int):
    """A stack for edges of n half-edges: for each the next below it, or `FREE`; last, the top one."""
    stack: Int[::1] = np.full(n + 1, FREE, dtype=np.int64)
    stack[n] = END
    return np.asarray(stack)


@cython.cfunc
@cython.exceptval(check=False)
def push(h: cython.longlong, stack: cython.longlong[::1], twins: cython.longlong[::1]) -> cython.void:
    """Put the edge of a half-edge, as the lower one, on a stack, unless it is there."""
    name, last = min(h, twins[h]), twins.shape[0]
    if stack[name] == FREE:
        stack[name] = stack[last]
        stack[last] = name


@cython.cclass
class Rule:
    """What edges are flipped for, and what else there is to a flip."""

    @cython.cfunc
    @cython.exceptval(check=False)
    def attempt(self, h: cython.longlong) -> cython.longlong:
        """Flip the edge of a half-edge if the rule demands it.

        Returns
        -------
        int
            `FLIPPED`; `LEFT` if it is not to be flipped; `BLOCKED` if it is, but cannot be.
        """
        return LEFT


@cython.cfunc
@cython.exceptval(check=False)
def restore_delaunay(stack: cython.longlong[::1], rule: Rule) -> tuple[cython.longlong, cython.longlong]:
    """Flip the edges on a stack, and around those that are flipped, as a rule demands; the stack is emptied.

    Returns
    -------
    int, int
        Flips made, and edges that were to be flipped when that could not be done.
    """
    twins = rule.twins
    last = twins.shape[0]
    limit = 100 * last + 1000  # far beyond what terminates: rounding could go in circles
    flips: Int = 0
    blocked: Int = 0
    while stack[last] != END:
        h = stack[last]
        stack[last] = stack[h]
        stack[h] = FREE
        t = twins[h]
        outcome = rule.attempt(h) if flips < limit else BLOCKED
        if outcome == FLIPPED:
            flips += 1
            push(h, stack, twins)
            push(preceding(h), stack, twins)
            push(t, stack, twins)
            push(preceding(t), stack, twins)
        elif outcome == BLOCKED:
            blocked += 1
    return flips, blocked


@cython.ccall
def flip_edges(edges: cython.const[cython.longlong][::1], rule: Rule):
    """Do what `restore_delaunay` does, beginning with the edges of these half-edges; what it returns."""
    stack: Int[::1] = empty_stack(rule.twins.shape[0])
    for h in edges:
        push(h, stack, rule.twins)
    return restore_delaunay(stack, rule)


@cython.cclass
class Weighted(Rule):
    """The rule of a weighted Delaunay triangulation; with equal weights, of the Delaunay triangulation.

    Parameters
    ----------
    mesh : Mesh
    weights : ndarray, shape (V,)
        Squared radii, less any constant; in curved space squared `chord` of the radii.
    """

    mesh: Mesh
    weights: ConstReal[::1]

    def __init__(self, mesh: Mesh, weights):
        self.mesh, self.twins, self.weights = mesh, mesh.twins, weights

    @cython.cfunc
    @cython.exceptval(check=False)
    def attempt(self, h: cython.longlong) -> cython.longlong:
        if is_delaunay(h, self.mesh, self.weights):
            return LEFT
        return FLIPPED if flip(h, self.mesh, THINNEST) else BLOCKED


@cython.cclass
class Tracked(Rule):
    """The rule of a Delaunay triangulation that leaves some edges alone and carries along what changes.

    Attributes
    ----------
    kept : ndarray of bool, shape (3F,)
        Half-edges that are not flipped.
    leaving : ndarray of int64, shape (n,)
        A half-edge that leaves each vertex.
    """

    mesh: Mesh
    kept: Flag[::1]
    leaving: Int[::1]
    weights: Real[::1]

    def __init__(self, mesh: Mesh, kept, n: cython.longlong):
        self.mesh, self.twins, self.kept = mesh, mesh.twins, kept
        self.leaving = leaving_halfedges(mesh.corners, n)
        self.weights = np.zeros(n)

    @cython.cfunc
    @cython.exceptval(check=False)
    def attempt(self, h: cython.longlong) -> cython.longlong:
        if self.kept[h] or is_delaunay(h, self.mesh, self.weights):
            return LEFT
        return FLIPPED if flip_tracked(h, self.mesh, self, THIN) else BLOCKED


@cython.ccall
@cython.exceptval(check=False)
def tilt(h: Int, mesh: Mesh, weights: ConstReal[::1]) -> tuple[cython.double, cython.double]:
    """Signed distance of the power center of h's triangle from h, positive inside, and its rounding error.

    It is d = ((|ik|^2 + q_i - q_k) / 2 - p x) / y with p = (l^2 + q_i - q_j) / (2 l).  In curved space it is
    the sine of the distance of the apex from the line of h, times the cosine of the angle between triangle
    and apex there: on hyperboloid and sphere, where the cosines of the radii at the corners are those of a
    linear function, the slope of that across h, over the curvature.
    """
    corners, lengths, k = mesh.corners, mesh.lengths, mesh.curvature
    after, before = following(h), preceding(h)
    l, second, third = lengths[h], lengths[after], lengths[before]
    a, b, c = weights[corners[h]], weights[corners[after]], weights[corners[before]]
    if k != 0:
        return _curved_tilt(l, second, third, a, b, c, k)
    x, y = apex(l, second, third, k)
    p = (l + (a - b) / l) / 2
    if y <= 0:
        return -INF, 0.0
    size = abs(a) + abs(b) + abs(c) + l * l + third * third
    return ((third * third + a - c) / 2 - p * x) / y, ROUNDING * size / y


@cython.cfunc
@cython.exceptval(check=False)
def _curved_tilt(
    l: Real, second: Real, third: Real, a: Real, b: Real, c: Real, k: Real
) -> tuple[cython.double, cython.double]:
    x, y = apex(l, second, third, k)
    if y <= 0:
        return -INF, 0.0
    along, up, flat = chord(l, k), chord(third, k), 1 - k * a / 2
    along, up = along * along, up * up
    p = (along * flat + (a - b)) / (2 * sn(l, k))
    size = abs(a) + abs(b) + abs(c) + along + up
    return ((up * flat + (a - c)) / 2 - p * x) / y, ROUNDING * size / y


@cython.ccall
def tilts(mesh: Mesh, weights: ConstReal[::1]):
    """The tilts of all half-edges and their rounding errors, shape (3F,)."""
    if mesh.curvature != 0:
        return _curved_tilts(mesh, weights)
    corners, lengths = mesh.corners, mesh.lengths
    values: Real[::1] = np.empty(corners.shape[0])
    errors: Real[::1] = np.empty(corners.shape[0])
    for f in range(0, corners.shape[0], 3):
        i, j, k = weights[corners[f]], weights[corners[f + 1]], weights[corners[f + 2]]
        a, b, c = lengths[f], lengths[f + 1], lengths[f + 2]  # ij, jk, ki
        area = twice_area(a, b, c)
        if area <= 0:
            values[f : f + 3] = -INF
            errors[f : f + 3] = 0.0
            continue
        at_i = (a * a + (c - b) * (c + b)) / 2  # products of the two sides at a corner
        at_j = (b * b + (a - c) * (a + c)) / 2
        at_k = (c * c + (b - a) * (b + a)) / 2
        values[f] = (a * (c * c + i - k) - (a * a + i - j) * at_i / a) / (2 * area)
        values[f + 1] = (b * (a * a + j - i) - (b * b + j - k) * at_j / b) / (2 * area)
        values[f + 2] = (c * (b * b + k - j) - (c * c + k - i) * at_k / c) / (2 * area)
        size = (abs(i) + abs(j) + abs(k) + a * a + b * b + c * c) * ROUNDING / area
        errors[f], errors[f + 1], errors[f + 2] = a * size, b * size, c * size
    return np.asarray(values), np.asarray(errors)


@cython.cfunc
def _curved_tilts(mesh: Mesh, weights: ConstReal[::1]):
    corners, lengths, curvature = mesh.corners, mesh.lengths, mesh.curvature
    values: Real[::1] = np.empty(corners.shape[0])
    errors: Real[::1] = np.empty(corners.shape[0])
    q: Real[::1] = np.empty(3)
    sine: Real[::1] = np.empty(3)
    cosine: Real[::1] = np.empty(3)
    square: Real[::1] = np.empty(3)
    for f in range(0, corners.shape[0], 3):
        area = amplitude(lengths[f], lengths[f + 1], lengths[f + 2], curvature)
        if area <= 0:
            values[f : f + 3] = -INF
            errors[f : f + 3] = 0.0
            continue
        for c in range(3):
            l = lengths[f + c]
            half, other = sn(l / 2, curvature), cs(l / 2, curvature)
            sine[c], square[c] = 2 * half * other, 4 * half * half
            cosine[c] = 1 - 2 * curvature * half * half
            q[c] = weights[corners[f + c]]
        total = abs(q[0]) + abs(q[1]) + abs(q[2]) + square[0] + square[1] + square[2]
        for c in range(3):
            after, before = (c + 1) % 3, (c + 2) % 3  # sides ij, jk, ki
            jk, ki = lengths[f + after], lengths[f + before]
            product = square[c] * cosine[before] / 2
            product += 2 * sn((ki - jk) / 2, curvature) * sn((ki + jk) / 2, curvature)
            flat = 1 - curvature * q[c] / 2
            third = square[before] * flat + (q[c] - q[before])
            along = square[c] * flat + (q[c] - q[after])
            values[f + c] = (sine[c] * third - along * product / sine[c]) / (2 * area)
            errors[f + c] = ROUNDING * sine[c] * total / area
    return np.asarray(values), np.asarray(errors)


@cython.ccall
def non_delaunay_edges(mesh: Mesh, weights: ConstReal[::1]):
    """The edges that are not weighted Delaunay, as their lower half-edges."""
    measured = tilts(mesh, weights)
    d: Real[::1] = measured[0]
    error: Real[::1] = measured[1]
    found: Int[::1] = np.empty(d.shape[0] // 2, dtype=np.int64)
    count = 0
    for h in range(d.shape[0]):
        t = mesh.twins[h]
        if h < t and d[h] + d[t] < -(SLACK * (abs(d[h]) + abs(d[t])) + error[h] + error[t]):
            found[count] = h
            count += 1
    return np.array(found[:count])


@cython.cfunc
@cython.exceptval(check=False)
def is_delaunay(h: Int, mesh: Mesh, weights: ConstReal[::1]) -> cython.bint:
    """Whether the dihedral angle at the edge of h is convex: the centers lie in order, d + d' >= 0."""
    here, error = tilt(h, mesh, weights)
    there, other_error = tilt(mesh.twins[h], mesh, weights)
    return here + there >= -(SLACK * (abs(here) + abs(there)) + error + other_error)


@cython.cfunc
@cython.exceptval(check=False)
def looks_outward(
    u: cython.const[cython.double][:, ::1], a: cython.longlong, b: cython.longlong, c: cython.longlong
) -> cython.bint:
    """Whether three directions come counterclockwise, seen from outside."""
    volume: cython.double = 0.0
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        volume += u[a, k] * (u[b, i] * u[c, j] - u[b, j] * u[c, i])
    return volume > 0.0


@cython.cclass
class Outward(Rule):
    """The rule of a Delaunay triangulation that looks outward.

    Attributes
    ----------
    u : ndarray, shape (V, 3)
    weights : ndarray, shape (V,)
        Zeros.
    flipped : ndarray of int64, shape (k,)
        One half-edge of each edge that was flipped.
    count : int
        How many these are.
    """

    mesh: Mesh
    u: ConstReal[:, ::1]
    weights: Real[::1]
    flipped: Int[::1]
    count: cython.longlong

    def __init__(self, mesh: Mesh, u):
        n = mesh.corners.shape[0]
        self.mesh, self.twins, self.u = mesh, mesh.twins, u
        self.weights, self.flipped = np.zeros(n // 6 + 2), np.zeros(4 * n, dtype=np.int64)
        self.count = 0

    @cython.cfunc
    @cython.exceptval(check=False)
    def attempt(self, h: cython.longlong) -> cython.longlong:
        mesh = self.mesh
        if is_delaunay(h, mesh, self.weights):
            return LEFT
        corners, u, t = mesh.corners, self.u, mesh.twins[h]
        into, other = preceding(h), preceding(t)
        i, j, k, m = corners[h], corners[t], corners[into], corners[other]
        if not (looks_outward(u, k, i, m) and looks_outward(u, m, j, k)):
            return BLOCKED
        if edges_between(into, m, corners, mesh.twins) > 0:
            return BLOCKED
        # the ends of a new edge at most 120 degrees apart
        if u[k, 0] * u[m, 0] + u[k, 1] * u[m, 1] + u[k, 2] * u[m, 2] < -0.5:
            return BLOCKED
        if self.count == self.flipped.shape[0] or not flip(h, mesh, 1e-6):  # of height over longest side
            return BLOCKED
        self.flipped[self.count] = following(h)
        self.count += 1
        return FLIPPED


def flip_to_delaunay(u: ConstReal[:, ::1], mesh: Mesh):
    """Flip edges until all are Delaunay whose flip leaves a triangulation that looks outward, in place.

    A new edge gets its length in the plane of its two triangles unfolded.

    Returns
    -------
    ndarray of int, shape (k,)
        One half-edge of each edge that was flipped, some more than once.
    """
    rule = Outward(mesh, u)
    flip_edges(non_delaunay_edges(mesh, rule.weights), rule)
    return np.array(rule.flipped[: rule.count])


def separate_edges(edges: ConstInt[::1], mesh: Mesh, kept: Flag[::1], n: Int):
    """Flip those of the edges that still are repeated, where no other joins the ends of the new edge."""
    carried = Tracked(mesh, kept, n)
    corners, twins = mesh.corners, mesh.twins
    flips: Int = 0
    for h in edges:
        a, b, k, m = corners[h], corners[twins[h]], preceding(h), corners[preceding(twins[h])]
        if kept[h] or not (a == b or edges_between(h, b, corners, twins) > 1):
            continue
        if corners[k] == m or edges_between(k, m, corners, twins) > 0:
            continue
        if flip_tracked(h, mesh, carried, THIN):
            flips += 1
    return flips


@cython.cfunc
@cython.exceptval(check=False)
def turn(
    ax: cython.double,
    ay: cython.double,
    bx: cython.double,
    by: cython.double,
    cx: cython.double,
    cy: cython.double,
) -> cython.double:
    """Twice the area of triangle abc, positive if it turns left; 0 if that is lost in rounding.

    The coordinates are of the size of 1 at most.
    """
    x, y = bx - ax, by - ay
    u, v = cx - ax, cy - ay
    area = x * v - y * u
    # up to rounding, the corners are in line
    return area if abs(area) > 2e-15 * (abs(x) + abs(y) + abs(u) + abs(v)) else 0.0


@cython.cfunc
@cython.exceptval(check=False)
def corner_turn(points: ConstReal[:, ::1], a: Int, b: Int, c: Int) -> Real:
    """`turn` of three of the points."""
    return turn(points[a, 0], points[a, 1], points[b, 0], points[b, 1], points[c, 0], points[c, 1])


def clip_ears(points: ConstReal[:, ::1], triangles: Int[:, ::1]):
    """Fill in the triangles of a simple polygon; whether they are none of them lost in rounding."""
    n = points.shape[0]
    after: Int[::1] = np.arange(1, n + 1) % n
    before: Int[::1] = np.arange(-1, n - 1) % n
    blunt: Flag[::1] = np.empty(n, dtype=np.bool_)  # corners of pi or more: only these can lie in an ear
    for k in range(n):
        blunt[k] = corner_turn(points, before[k], k, after[k]) <= 0
    suspects: Int[::1] = np.flatnonzero(blunt)
    made: Int = 0
    v: Int = 0
    refused: Int = 0
    while made < n - 3:
        if refused > n - made:
            return False
        a, b = before[v], after[v]
        if blunt[v] or not _empty(a, v, b, points, suspects, blunt):
            v = b
            refused += 1
            continue
        triangles[made, 0], triangles[made, 1], triangles[made, 2] = a, v, b
        made += 1
        refused = 0
        after[a], before[b] = b, a
        # corners only become smaller
        blunt[a] = blunt[a] and corner_turn(points, before[a], a, after[a]) <= 0
        blunt[b] = blunt[b] and corner_turn(points, before[b], b, after[b]) <= 0
        v = after[b]  # not b: its ears in a row would be a fan
    a, b = before[v], after[v]
    triangles[made, 0], triangles[made, 1], triangles[made, 2] = a, v, b
    return corner_turn(points, a, v, b) > 0


@cython.cfunc
@cython.exceptval(check=False)
def _empty(
    a: Int, v: Int, b: Int, points: ConstReal[:, ::1], suspects: Int[::1], blunt: Flag[::1]
) -> cython.bint:
    """Whether no other corner lies in the triangle or on its rim."""
    for w in suspects:
        if not blunt[w] or w in (a, b):
            continue
        if (
            corner_turn(points, a, v, w) >= 0
            and corner_turn(points, v, b, w) >= 0
            and corner_turn(points, b, a, w) >= 0
        ):
            return False
    return True


@cython.cfunc
@cython.exceptval(check=False)
def _cotangent(points: ConstReal[:, ::1], i: Int, j: Int, k: Int) -> Real:
    """Of the angle at k."""
    x, y = points[i, 0] - points[k, 0], points[i, 1] - points[k, 1]
    u, v = points[j, 0] - points[k, 0], points[j, 1] - points[k, 1]
    return (x * u + y * v) / (x * v - y * u)


@cython.cclass
class Constrained(Rule):
    """The rule of a Delaunay triangulation of a polygon with these corners (n, 2).

    Its triangles are tables over half-edges; beyond the last of ``corners`` are ``twins`` of the outline.
    """

    corners: Int[::1]
    points: ConstReal[:, ::1]

    def __init__(self, corners, twins, points):
        self.corners, self.twins, self.points = corners, twins, points

    @cython.cfunc
    @cython.exceptval(check=False)
    def attempt(self, h: cython.longlong) -> cython.longlong:
        # An edge is flipped across which the angles sum to more than pi: the sum of their cotangents is
        # negative.
        corners, points, t = self.corners, self.points, self.twins[h]
        if t >= corners.shape[0]:
            return LEFT
        i, j, k, m = corners[h], corners[t], corners[preceding(h)], corners[preceding(t)]
        here, there = _cotangent(points, i, j, k), _cotangent(points, j, i, m)
        if here + there >= -SLACK * (abs(here) + abs(there)):
            return LEFT
        if corner_turn(points, m, j, k) <= 0 or corner_turn(points, k, i, m) <= 0:
            return BLOCKED
        swap_diagonals(h, corners, self.twins)
        return FLIPPED


def assembled(corners: ConstInt[::1], twins: ConstInt[::1], values: ConstReal[::1], diagonal: ConstReal[::1]):
    n = diagonal.shape[0]
    indptr: Int32[::1] = np.ones(n + 1, dtype=np.int32)
    indptr[0] = 0
    for h in range(corners.shape[0]):
        indptr[corners[h] + 1] += 1
    for i in range(n):
        indptr[i + 1] += indptr[i]
    # The half-edges by the vertex that they leave: one entry less a vertex than there are in its column.
    leaving: Int32[::1] = np.empty(corners.shape[0], dtype=np.int32)
    end: Int32[::1] = np.empty(n, dtype=np.int32)
    for i in range(n):
        end[i] = indptr[i] - i
    for h in range(corners.shape[0]):
        i = corners[h]
        leaving[end[i]] = h
        end[i] += 1
    indices: Int32[::1] = np.empty(indptr[n], dtype=np.int32)
    data: Real[::1] = np.empty(indptr[n])
    for i in range(n):
        end[i] = indptr[i]
    for i in range(n):  # columns get their rows in order, and equal ones one after the other
        indices[end[i]], data[end[i]] = i, diagonal[i]
        end[i] += 1
        for k in range(indptr[i] - i, indptr[i + 1] - i - 1):
            h = leaving[k]
            j = corners[twins[h]]
            e = end[j]
            if e > indptr[j] and indices[e - 1] == i:
                data[e - 1] += values[h]
            else:
                indices[e], data[e] = i, values[h]
                end[j] = e + 1
    count: Int = 0
    for i in range(n):
        start, indptr[i] = indptr[i], count
        if start == count:
            count = end[i]
            continue
        for e in range(start, end[i]):
            indices[count], data[count] = indices[e], data[e]
            count += 1
    indptr[n] = count
    return np.asarray(indptr), np.asarray(indices[:count]), np.asarray(data[:count])


@cython.cfunc
def retriangulate_star(
    h: Int, mesh: Mesh, leaving: Int[::1], alive: Flag[::1], moved: Int[::1], stack: Int[::1]
) -> cython.bint:
    """Replace the triangles around a vertex by two fewer, and put their sides on a stack.

    Parameters
    ----------
    h : int
        A half-edge that leaves the vertex.  None is a loop; or one is, and encloses the end of h alone.
    mesh : HalfEdges
    leaving : ndarray of int, shape (V,)
        Half-edges that leave each vertex.
    alive : ndarray of bool, shape (F,)
        The faces that are left.
    moved : ndarray of int, shape (3F,)
        Scratch, all -1.
    stack : ndarray
        Of `isoembed.intrinsic.delaunay`, empty.

    Returns
    -------
    bool
        False, and nothing is changed, if however the polygon is cut, a triangle is too thin.
    """
    corners, twins, lengths = mesh.corners, mesh.twins, mesh.lengths
    directions, curvature = mesh.directions, mesh.curvature
    i: Int
    j: Int
    k: Int
    t: Int
    # The polygon: its corners, where they lie, and the sides from each to the next.
    folded: cython.bint = h // 3 == twins[h] // 3
    star = _star(h, mesh)
    vertices: Int[::1] = star[0]
    faces: Int[::1] = star[1]
    sides: Int[::1] = star[2]
    z: Complex[::1] = star[3]
    if folded:
        first, around = _around_tip(z, lengths[h], lengths[preceding(h)], curvature)
        z = around
        vertices, sides = _turned(vertices, first, corners[twins[h]]), _turned(sides, first, -1)
        sides[sides.shape[0] - 1] = -1
    n = z.shape[0]
    cut = _best_cut(z, curvature)
    triangles: Int[:, ::1] = cut[0]
    if not cut[1] > THIN:
        return False

    # From corner to corner: lengths, and directions at the first.
    size: Real[:, ::1] = np.empty((n, n))
    direction: Real[:, ::1] = np.empty((n, n))
    for i in range(n):
        j = (i + 1) % n
        g = sides[i]
        if g >= 0:
            size[i, j] = size[j, i] = lengths[g]
            direction[i, j], direction[j, i] = directions[g], directions[twins[g]]
    if folded:
        size[0, 1] = size[1, 0] = size[0, n - 1] = size[n - 1, 0] = distance(z[1], curvature)
        direction[0, 1] = direction[0, n - 1] = directions[twins[h]] + argument(z[1])
        angle = argument(-z[1]) - argument(toward(z[1], z[2], curvature))
        direction[1, 0] = direction[n - 1, 0] = direction[1, 2] + modulo(angle, 2 * PI)
    for t in range(n - 2):  # parts before wholes: i -> k and k -> j are known
        i, k, j = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        if j - i < n - 1:
            size[i, j] = size[j, i] = distance(toward(z[i], z[j], curvature), curvature)
            at_i = angle_between(size[i, k], size[i, j], size[k, j], curvature)
            at_j = angle_between(size[k, j], size[i, j], size[i, k], curvature)
            direction[i, j], direction[j, i] = direction[i, k] + at_i, direction[j, k] - at_j

    half: Int[:, ::1] = np.empty((n, n), dtype=np.int64)  # the new half-edge from corner to corner
    across: Int[::1] = np.empty(n, dtype=np.int64)
    for k in range(n):
        across[k] = twins[sides[k]] if sides[k] >= 0 else -1
    for t in range(n - 2):
        i, k, j = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        for c in range(3):
            g = 3 * faces[t] + c
            a = i if c == 0 else k if c == 1 else j
            b = k if c == 0 else j if c == 1 else i
            half[a, b] = g
            corners[g], lengths[g], directions[g] = vertices[a], size[a, b], direction[a, b]
            leaving[vertices[a]] = g
    alive[faces[n - 2]] = alive[faces[n - 1]] = False
    for t in range(n - 2):
        i, j = triangles[t, 0], triangles[t, 2]
        if j - i < n - 1:
            glue(half[i, j], half[j, i], twins)
    if folded:
        glue(half[0, 1], half[n - 1, 0], twins)
    # Sides may be glued to each other.
    for k in range(n):
        if sides[k] >= 0:
            moved[sides[k]] = half[k, (k + 1) % n]
    for k in range(n):
        if sides[k] >= 0:
            g = across[k]
            glue(half[k, (k + 1) % n], moved[g] if moved[g] >= 0 else g, twins)
    for k in range(n):
        if sides[k] >= 0:
            moved[sides[k]] = -1
    for t in range(n - 2):
        for g in range(3 * faces[t], 3 * faces[t] + 3):
            push(g, stack, twins)
    return True


@cython.cfunc
def _star(h: Int, mesh: Mesh):
    """The triangles around the vertex that a half-edge leaves.

    Returns
    -------
    ndarray of int, ndarray of int, ndarray of int
        The vertices around it, the faces, and the sides between those vertices; if h runs to a vertex that a
        loop encloses, only those beyond the loop, and the face within last.
    ndarray of complex
        Where the vertices lie, as seen from it, if the x axis is along h: in a `chart`.
    """
    corners, twins = mesh.corners, mesh.twins
    folded: cython.bint = h // 3 == twins[h] // 3
    e, edges = h, degree(h, twins, corners.shape[0])
    # If so, the edges are h, the loop, those of which the last runs as the first, and the loop.
    n = edges - 4 if folded else edges
    vertices: Int[::1] = np.empty(n, dtype=np.int64)
    sides: Int[::1] = np.empty(n, dtype=np.int64)
    faces: Int[::1] = np.empty(n + 2 if folded else n, dtype=np.int64)
    z: Complex[::1] = np.empty(n, dtype=np.complex128)
    # What is missing of a full angle is the rounding of thin triangles, whose angles it moves the most.
    thin = 0.0
    for _ in range(edges):
        slenderness = _slenderness(e, mesh)
        thin += slenderness * slenderness
        e = twins[preceding(e)]
    missing = (2 * PI - total_angle(h, mesh)) / thin
    angle = 0.0
    for k in range(-2 if folded else 0, n):
        side = following(e)
        faces[k if k >= 0 else n + 2 + k] = e // 3
        if k >= 0:
            vertices[k], sides[k] = corners[side], side
            z[k] = polar(coordinate(mesh.lengths[e], mesh.curvature), angle)
        slenderness = _slenderness(e, mesh)
        angle += corner_angle(e, mesh) + missing * (slenderness * slenderness)
        e = twins[preceding(e)]
    return np.asarray(vertices), np.asarray(faces), np.asarray(sides), np.asarray(z)


@cython.cfunc
@cython.exceptval(check=False)
def _slenderness(h: Int, mesh: Mesh) -> Real:
    """Longest side over height of the triangle of a half-edge: how its angles magnify errors of lengths."""
    a, b, c = mesh.lengths[h], mesh.lengths[following(h)], mesh.lengths[preceding(h)]
    longest, area = max(a, b, c), amplitude(a, b, c, mesh.curvature)
    return longest * sn(longest, mesh.curvature) / area if area > 0 else INF


@cython.cfunc
def _around_tip(z: ConstComplex[::1], far: Real, width: Real, curvature: Real):
    """Unfold a polygon around a vertex of small total angle inside it, cut open from there to a corner.

    Parameters
    ----------
    z : ndarray of complex, shape (n,)
        The corners, as seen from a vertex inside, if the x axis runs to the other one.
    far, width : float
        How far that is, and the length of the loop around it.
    curvature : float

    Returns
    -------
    int
        The corner to which it is cut: that which admits the best triangles.
    ndarray of complex, shape (n + 2,)
        The corners, as seen from the tip: itself, those from the cut once around, that of the cut again.
    """
    n = z.shape[0]
    turning = polar(1.0, angle_between(far, far, width, curvature))
    tip = point(coordinate(far, curvature), 0.0)
    best: Int = 0
    most: Real = -INF
    best_points: Complex[::1] = np.zeros(n + 2, dtype=np.complex128)
    for first in range(n):
        points: Complex[::1] = np.zeros(n + 2, dtype=np.complex128)
        for k in range(n + 1):
            i = first + k
            seen = 0j - toward(tip, z[i % n], curvature)
            points[k + 1] = turning * seen if i >= n else seen
        worst: Real = _best_cut(points, curvature)[1]
        if worst > most:
            best, most, best_points = first, worst, points
    return best, np.asarray(best_points)


@cython.cfunc
def _turned(values: ConstInt[::1], first: Int, before: Int):
    """Begin at one, go once around, and add it again; and put another before."""
    n = values.shape[0]
    result: Int[::1] = np.empty(n + 2, dtype=np.int64)
    result[0] = before
    for k in range(n + 1):
        result[k + 1] = values[(first + k) % n]
    return np.asarray(result)


@cython.cfunc
def _best_cut(z: ConstComplex[::1], curvature: Real):
    """Cut a polygon into triangles of which the thinnest is as thick as can be.

    If none of them is turned over, they do not overlap; so nothing else needs to be checked.

    Returns
    -------
    ndarray of int, shape (n - 2, 3)
        Corners in ascending order; a triangle comes after those that its shorter sides cut off.
    float
        Least height over longest side.
    """
    i: Int
    j: Int
    k: Int
    t: Int
    n = z.shape[0]
    worst: Real[:, ::1] = np.full((n, n), INF)
    middle: Int[:, ::1] = np.empty((n, n), dtype=np.int64)
    for span in range(2, n):
        for i in range(n - span):
            j = i + span
            a = toward(z[i], z[j], curvature)
            worst[i, j] = -INF
            for k in range(i + 1, j):
                b = toward(z[i], z[k], curvature)
                longest = max(dot(a, a), dot(b, b), dot(a - b, a - b))
                here = min(cross(b, a) / longest, worst[i, k], worst[k, j])
                if here > worst[i, j] or k == i + 1:
                    worst[i, j], middle[i, j] = here, k
    triangles: Int[:, ::1] = np.empty((n - 2, 3), dtype=np.int64)
    triangles[n - 3, 0], triangles[n - 3, 2] = 0, n - 1
    found: Int = 1
    for t in range(n - 3, -1, -1):
        i, j = triangles[t, 0], triangles[t, 2]
        k = middle[i, j]
        triangles[t, 1] = k
        if k - i > 1:
            triangles[n - 3 - found, 0], triangles[n - 3 - found, 2] = i, k
            found += 1
        if j - k > 1:
            triangles[n - 3 - found, 0], triangles[n - 3 - found, 2] = k, j
            found += 1
    return np.asarray(triangles), worst[0, n - 1]


@cython.cclass
class Notes:
    """The arrays of a `Removal` that are filled in."""

    removed: Int[::1]
    anchors: Int[::1]
    directions: Real[::1]
    distances: Real[::1]
    backs: Real[::1]

    def __init__(self, removal):
        self.removed, self.anchors = removal.removed, removal.anchors
        self.directions, self.distances, self.backs = removal.directions, removal.distances, removal.backs


def remove_vertices(mesh: Mesh, flat: ConstFlag[::1], removal):
    """Remove the flat vertices in place; return which faces are left, and how many vertices went."""
    corners, twins = mesh.corners, mesh.twins
    n = corners.shape[0]
    notes = Notes(removal)
    carried = Tracked(mesh, np.zeros(n, dtype=np.bool_), flat.shape[0])
    number: Int = 0
    left: Int
    alive: Flag[::1] = np.ones(n // 3, dtype=np.bool_)
    stack: Int[::1] = empty_stack(n)
    moved: Int[::1] = np.full(n, -1, dtype=np.int64)
    rounds: Int[::1] = np.zeros(flat.shape[0], dtype=np.int64)  # the last in which a neighbor went
    remaining: Int[::1] = np.flatnonzero(flat)
    count: Int = 0
    most: Int = 10  # edges at a vertex that goes in an early round
    while remaining.shape[0] > 0:
        number += 1
        left = 0
        for k in range(remaining.shape[0]):
            v = remaining[k]
            gone: cython.bint = False
            if rounds[v] != number and degree(carried.leaving[v], twins, most) <= most:
                h = _untie(v, mesh, carried)
                if h != NONE:
                    _note(h, mesh, notes, count)
                    gone = retriangulate_star(h, mesh, carried.leaving, alive, moved, stack)
            if not gone:
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
            most *= 4  # a round that takes less than a twentieth allows four times as many edges in the next
        remaining = remaining[:left]
    return np.asarray(alive), count


@cython.cfunc
@cython.exceptval(check=False)
def _removable(h: Int, mesh: Mesh) -> Int:
    """A half-edge from the vertex of this one from which `retriangulate_star` can begin, or NONE.

    There are few edges, and none is a loop; or one is, and it goes around one vertex that has no other edge.
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
        Where `retriangulate_star` can begin, or NONE.
    """
    # ten flips an edge until the vertex can be removed
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
        FLIPPED, if one was; or else one that cannot be, or NONE if there is none.
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
    """Flip edges at a vertex without loops, those first that leave good triangles; return whether any was."""
    for thinnest in (0.1, 0.01, 0.0001, 1e-06, THIN):  # height over longest side that flips leave
        h = carried.leaving[v]
        surplus = edges = degree(h, mesh.twins, mesh.twins.shape[0])
        for _ in range(edges):
            if surplus > MAX_DEGREE and flip_tracked(
                h, mesh, carried, thinnest
            ):  # after which h still leaves v
                surplus -= 1
            h = mesh.twins[preceding(h)]
        if surplus < edges:
            return True
    return False


@cython.cfunc
@cython.exceptval(check=False)
def _in_the_way(h: Int, mesh: Mesh) -> Int:
    """The edge whose flip divides the largest of the angles that keep an edge from being flipped."""
    t = mesh.twins[h]
    first, second = corner_angle(h, mesh), corner_angle(following(h), mesh)
    across, opposite = corner_angle(t, mesh), corner_angle(following(t), mesh)
    # At the start of h meet its own first angle and the second of the twin.
    if first + opposite > second + across:
        return following(h) if first > opposite else preceding(t)
    return preceding(h) if second > across else following(t)


@cython.cfunc
@cython.exceptval(check=False)
def _note(h: Int, mesh: Mesh, removal: Notes, count: Int) -> cython.void:
    """Write down where the vertex that a half-edge leaves is seen from its nearest neighbor."""
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


@cython.cclass
class Straight(Rule):
    """The rule by which an edge gives way to the straight line across its two triangles unfolded.

    It leaves the star of a vertex alone, ``fixed``, and doubles no edge.
    """

    mesh: Mesh
    fixed: cython.longlong

    def __init__(self, mesh: Mesh, fixed):
        self.mesh, self.twins, self.fixed = mesh, mesh.twins, fixed

    @cython.cfunc
    @cython.exceptval(check=False)
    def attempt(self, h: cython.longlong) -> cython.longlong:
        if not _is_demanded(h, self.mesh, self.fixed):
            return LEFT
        return FLIPPED if flip(h, self.mesh, THINNEST) else BLOCKED


@cython.cclass
class Ptolemaic(Rule):
    """The rule by which an edge gives way to the other diagonal of a quadrilateral inscribed in a circle.

    It leaves the star of a vertex alone, ``fixed``, and doubles no edge.
    """

    mesh: Mesh
    fixed: cython.longlong

    def __init__(self, mesh: Mesh, fixed):
        self.mesh, self.twins, self.fixed = mesh, mesh.twins, fixed

    @cython.cfunc
    @cython.exceptval(check=False)
    def attempt(self, h: cython.longlong) -> cython.longlong:
        mesh = self.mesh
        if not _is_demanded(h, mesh, self.fixed):
            return LEFT
        t, lengths = mesh.twins[h], mesh.lengths
        jk, ki, im, mj = following(h), preceding(h), following(t), preceding(t)
        diagonal = (lengths[ki] * lengths[mj] + lengths[jk] * lengths[im]) / lengths[h]
        lengths[t], lengths[h] = lengths[jk], lengths[im]
        lengths[jk] = lengths[im] = diagonal
        swap_diagonals(h, mesh.corners, mesh.twins)
        return FLIPPED


@cython.cfunc
@cython.exceptval(check=False)
def _is_demanded(h: Int, mesh: Mesh, fixed: Int) -> cython.bint:
    """Whether a flip is demanded that leaves the star of a vertex alone and doubles no edge."""
    corners, t = mesh.corners, mesh.twins[h]
    # in cosines: four vertices on a circle, but for rounding
    if _cosine(h, mesh) + _cosine(t, mesh) >= -1e-9:
        return False
    k, m = preceding(h), corners[preceding(t)]
    if fixed in (corners[h], corners[t], corners[k], m):
        return False
    return edges_between(k, m, corners, mesh.twins) == 0


@cython.cfunc
@cython.exceptval(check=False)
def _cosine(h: Int, mesh: Mesh) -> Real:
    """Twice the cosine across from a half-edge, also of a triangle that breaks the triangle inequality.

    It is that of the triangle of chords: divided by ``cs(l / 2)``, which the two sides of an edge have in
    common, it is the sine of half the excess of the other two angles over the one across.
    """
    l = chord(mesh.lengths[h], mesh.curvature)
    a = chord(mesh.lengths[following(h)], mesh.curvature)
    b = chord(mesh.lengths[preceding(h)], mesh.curvature)
    return b / a + a / b - l * l / (b * a)
