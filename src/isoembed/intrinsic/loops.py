# cython: boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False, infer_types=True
"""Compiled traversal of half-edges, angles at vertices, edge flips, and the stack of edges to be flipped."""

from __future__ import annotations

import cython
import numpy as np
from cython.cimports.isoembed.c_types import ConstInt, Flag, Int, Real
from cython.cimports.isoembed.intrinsic.chart import from_frame, norm, toward
from cython.cimports.isoembed.space.trigonometry import angle_between, apex, arc, cs, sn
from cython.cimports.libc.math import atan2, floor, hypot, sin, sqrt

END = cython.declare(cython.longlong, -1)  # bottom of the stack
FREE = cython.declare(cython.longlong, -2)  # not on the stack
BLOCKED = cython.declare(cython.longlong, -1)  # outcomes of a rule
LEFT = cython.declare(cython.longlong, 0)
FLIPPED = cython.declare(cython.longlong, 1)


@cython.ccall
@cython.exceptval(check=False)
def modulo(angle: cython.double, total: cython.double) -> cython.double:
    """Angle modulo the total angle, from 0 to the total angle."""
    return angle - floor(angle / total) * total


@cython.cclass
class Mesh:
    """Arrays of `HalfEdges`, changed in place."""

    def __init__(self, tables):
        self.corners, self.twins, self.lengths = tables.corners, tables.twins, tables.lengths
        self.directions, self.curvature = tables.directions, tables.curvature


@cython.cfunc
@cython.exceptval(check=False)
def following(h: cython.longlong) -> cython.longlong:
    """Next half-edge of the face."""
    return h - 2 if h % 3 == 2 else h + 1


@cython.cfunc
@cython.exceptval(check=False)
def preceding(h: cython.longlong) -> cython.longlong:
    """Previous half-edge of the face."""
    return h + 2 if h % 3 == 0 else h - 1


@cython.cfunc
@cython.exceptval(check=False)
def glue(g: cython.longlong, h: cython.longlong, twins: cython.longlong[::1]) -> cython.void:
    """Make two half-edges twins."""
    twins[g], twins[h] = h, g


@cython.ccall
def leaving_halfedges(corners: cython.const[cython.longlong][::1], n: cython.longlong):
    """Some half-edge leaving each of n vertices, shape (n,); -1 where there is none."""
    leaving: Int[::1] = np.full(n, -1, dtype=np.int64)
    for h in range(corners.shape[0]):
        leaving[corners[h]] = h
    return np.asarray(leaving)


def breadth_first(corners: ConstInt[::1], twins: ConstInt[::1]):
    """Breadth-first order of the vertices from the first one, shape (V,)."""
    n = corners.shape[0] // 6 + 2
    leaving: Int[::1] = leaving_halfedges(corners, n)
    order: Int[::1] = np.empty(n, dtype=np.int64)
    visited: Flag[::1] = np.zeros(n, dtype=np.bool_)
    order[0], visited[0] = 0, True
    count = 1
    for k in range(n):
        start = h = leaving[order[k]]
        while True:
            v = corners[twins[h]]
            if not visited[v]:
                visited[v] = True
                order[count] = v
                count += 1
            h = twins[preceding(h)]
            if h == start:
                break
    return np.asarray(order)


def by_lowest_corner(corners: ConstInt[::1]):
    """Faces ordered by their lowest vertex and then by index, shape (F,)."""
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
    """Degree of the start vertex of a half-edge, counted up to ``most + 1``."""
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
    """Number of edges from the start vertex of a half-edge to v."""
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
    """Angle of a face at the start of a half-edge."""
    return angle_between(
        mesh.lengths[h], mesh.lengths[preceding(h)], mesh.lengths[following(h)], mesh.curvature
    )


@cython.ccall
@cython.exceptval(check=False)
def total_angle(h: cython.longlong, mesh: Mesh) -> cython.double:
    """Sum of the angles at the start vertex of a half-edge."""
    start = h
    total = 0.0
    while True:
        total += corner_angle(h, mesh)
        h = mesh.twins[preceding(h)]
        if h == start:
            return total


def set_directions(mesh: Mesh):
    """Compute directions relative to the lowest half-edge at each vertex."""
    visited: Flag[::1] = np.zeros(mesh.corners.shape[0], dtype=np.bool_)
    for start in range(mesh.corners.shape[0]):
        h = start
        angle = 0.0
        while not visited[h]:
            visited[h] = True
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
    """Replace the edge of a half-edge by the other diagonal of its two triangles, which must be distinct.

    The faces ijk and jim of half-edge i -> j and its twin become kim, with the other diagonal in place of
    ``following(h)``, and mjk, with it in place of ``following(twin)``.  Half-edge jk moves to the place of
    the twin, and im to that of h; the caller must move their other data.
    """
    t = twins[h]
    jk, im = following(h), following(t)
    corners[jk], corners[im] = corners[preceding(t)], corners[preceding(h)]
    glue(t, twins[jk], twins)  # in sequence, as they may be glued to each other
    glue(h, twins[im], twins)
    glue(jk, im, twins)


@cython.ccall
@cython.exceptval(check=False)
def flip(h: cython.longlong, mesh: Mesh, thinnest: cython.double) -> cython.bint:
    """Flip the edge of a half-edge by `swap_diagonals` if its triangles form a strictly convex quadrilateral.

    Returns
    -------
    bool
        False, with nothing changed, if both sides are the same face, or if the height of a new triangle would
        be at most the fraction `thinnest` of its longest side.
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
        # Directions are computed from the angles of the better triangle.
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
    """Other diagonal of two triangles, and longest side times height of the new ones.

    It is the third side of a triangle by a law of cosines free of cancellation.
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


def empty_stack(n: Int):
    """Empty stack for edges of n half-edges: next entry below each, or `FREE`; the last item is the top."""
    stack: Int[::1] = np.full(n + 1, FREE, dtype=np.int64)
    stack[n] = END
    return np.asarray(stack)


@cython.cfunc
@cython.exceptval(check=False)
def push(h: cython.longlong, stack: cython.longlong[::1], twins: cython.longlong[::1]) -> cython.void:
    """Push the edge of a half-edge, as its lower one, on a stack unless it is there."""
    name, last = min(h, twins[h]), twins.shape[0]
    if stack[name] == FREE:
        stack[name] = stack[last]
        stack[last] = name


@cython.cclass
class Rule:
    """Criterion for edge flips, with the updates of a flip."""

    @cython.cfunc
    @cython.exceptval(check=False)
    def attempt(self, h: cython.longlong) -> cython.longlong:
        """Flip the edge of a half-edge if the criterion requires it.

        Returns
        -------
        int
            `FLIPPED`; `LEFT` if no flip is required; `BLOCKED` if it is required but impossible.
        """
        return LEFT


@cython.cfunc
@cython.exceptval(check=False)
def restore_delaunay(stack: cython.longlong[::1], rule: Rule) -> tuple[cython.longlong, cython.longlong]:
    """Flip the edges on a stack, and those around flipped ones, by a rule, until the stack is empty.

    Returns
    -------
    int, int
        Number of flips, and number of blocked flips.
    """
    twins = rule.twins
    last = twins.shape[0]
    limit = 100 * last + 1000  # guards against cycles due to rounding
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
    """Restore the Delaunay property as `restore_delaunay`, starting from the edges of these half-edges."""
    stack: Int[::1] = empty_stack(rule.twins.shape[0])
    for h in edges:
        push(h, stack, rule.twins)
    return restore_delaunay(stack, rule)
