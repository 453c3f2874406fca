# cython: boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False, infer_types=True
"""Compiled Delaunay and weighted Delaunay criteria of edges, and edge-flip algorithms based on them."""

from __future__ import annotations

import cython
import numpy as np
from cython.cimports.isoembed.c_types import ConstInt, ConstReal, Flag, Int, Real
from cython.cimports.isoembed.intrinsic.loops import (
    Mesh,
    Rule,
    edges_between,
    flip,
    flip_edges,
    following,
    leaving_halfedges,
    preceding,
)
from cython.cimports.isoembed.space.trigonometry import amplitude, apex, chord, cs, sn, twice_area

INF = cython.declare(cython.double, float("inf"))
SLACK = cython.declare(cython.double, 1e-12)  # relative tolerance of the Delaunay criterion
ROUNDING = cython.declare(cython.double, 4e-16)  # of a difference of squared lengths, relative to their sum
THINNEST = cython.declare(
    cython.double, 1e-15
)  # height over longest side: below, triangles degenerate by rounding
THIN = cython.declare(
    cython.double, 1e-8
)  # height over longest side: below, the triangle inequality may degenerate in floats
BLOCKED = cython.declare(cython.longlong, -1)  # outcomes of a rule, as in `loops`
LEFT = cython.declare(cython.longlong, 0)
FLIPPED = cython.declare(cython.longlong, 1)


@cython.cfunc
@cython.exceptval(check=False)
def flip_tracked(h: cython.longlong, mesh: Mesh, carried: Tracked, thinnest: cython.double) -> cython.bint:
    """Flip an edge by `flip`, and update the kept and leaving half-edges."""
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


@cython.cclass
class Weighted(Rule):
    """Weighted Delaunay rule; with equal weights, the Delaunay rule.

    Parameters
    ----------
    mesh : Mesh
    weights : ndarray, shape (V,)
        Squared radii, up to a constant; in curved space squared `chord` of the radii.
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
    """Constrained Delaunay rule that keeps some edges and updates the tables below.

    Attributes
    ----------
    kept : ndarray of bool, shape (3F,)
        Half-edges that are not flipped.
    leaving : ndarray of int64, shape (n,)
        Some half-edge leaving each vertex.
    """

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
    and apex there.  On the hyperboloid and sphere, the cosines of the radii at the corners define a linear
    function; the result is its slope across h, divided by the curvature.
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
    """Tilts of all half-edges and their rounding errors, shape (3F,)."""
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
    """Lower half-edges of the edges that are not weighted Delaunay."""
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
    """Whether the edge of h is weighted Delaunay: the power centers are in order, d + d' >= 0."""
    here, error = tilt(h, mesh, weights)
    there, other_error = tilt(mesh.twins[h], mesh, weights)
    return here + there >= -(SLACK * (abs(here) + abs(there)) + error + other_error)


@cython.cfunc
@cython.exceptval(check=False)
def looks_outward(
    u: cython.const[cython.double][:, ::1], a: cython.longlong, b: cython.longlong, c: cython.longlong
) -> cython.bint:
    """Whether three directions are counterclockwise, as seen from outside."""
    volume: cython.double = 0.0
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        volume += u[a, k] * (u[b, i] * u[c, j] - u[b, j] * u[c, i])
    return volume > 0.0


@cython.cclass
class Outward(Rule):
    """Delaunay rule restricted to flips that keep a spherical triangulation oriented outward.

    Attributes
    ----------
    u : ndarray, shape (V, 3)
    weights : ndarray, shape (V,)
        Zeros.
    flipped : ndarray of int64, shape (k,)
        One half-edge of each flipped edge.
    count : int
        Number of flips.
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
    """Flip to the Delaunay triangulation in place, by flips that keep the triangles oriented outward.

    The length of a new edge is that in its two triangles unfolded into the plane.

    Returns
    -------
    ndarray of int, shape (k,)
        One half-edge of each flipped edge, possibly repeated.
    """
    rule = Outward(mesh, u)
    flip_edges(non_delaunay_edges(mesh, rule.weights), rule)
    return np.array(rule.flipped[: rule.count])


def separate_edges(edges: ConstInt[::1], mesh: Mesh, kept: Flag[::1], n: Int):
    """Flip loops and multiple edges among those given, unless the new edge would be one."""
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
