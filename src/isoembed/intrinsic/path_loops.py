# cython: boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False, infer_types=True
"""Compiled tracing of straight paths (geodesics) across triangles, and their equilibrium stresses."""

from __future__ import annotations

import cython
import numpy as np
from cython.cimports.isoembed.c_types import Complex, ConstComplex, ConstInt, ConstReal, Int, Real
from cython.cimports.isoembed.intrinsic.chart import (
    coordinate,
    cross,
    distance,
    norm,
    point,
    stretch,
    toward,
    turn_at,
)
from cython.cimports.isoembed.intrinsic.loops import (
    Mesh,
    following,
    leaving_halfedges,
    preceding,
    total_angle,
)
from cython.cimports.isoembed.intrinsic.polygon_loops import (
    Layout,
    angle_around,
    crossed,
    from_corner,
    from_inside,
    place,
    reaches,
    sector,
    straight,
)
from cython.cimports.isoembed.space.trigonometry import cs, sn
from cython.cimports.libc.math import atan2, atanh, isnan, sqrt

PI = cython.declare(cython.double, 3.141592653589793)
# maximum number of crossings beyond the number of triangles: lines can wind around a needle
EXTRA_CROSSINGS = cython.declare(cython.longlong, 10**6)


def locate(mesh: Mesh, laid: Layout, removal, number: ConstInt[::1]):
    """Faces containing the removed vertices, and barycentric coordinates in these.

    Returns
    -------
    ndarray of int, shape (V,)
    ndarray, shape (V, 3)
    ndarray, shape (V,)
        Direction of the polygon's x axis at each vertex.
    int
        A vertex that was not found, or -1.
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
    """Half-edges next clockwise of the given ones rotated by `tilt`, and the angles to these."""
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
        # Both go counterclockwise, so that each search begins where the previous one ended.
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
    """Number of crossings of each path, and its end if it starts along the x axis; NaN if not found."""
    g: Int
    corners, curvature = polygons.corners, polygons.curvature
    counts: Int[::1] = np.zeros(first.shape[0], dtype=np.int64)
    meet: Complex[::1] = np.full(first.shape[0], complex(np.nan, np.nan))
    for e in range(first.shape[0]):
        far = lengths[e]
        goal = point(coordinate(far, curvature), 0.0)
        state = from_corner(first[e], angles[e], polygons)
        # rounding error of a position, in coordinates, plus a tolerance of 1e-6 of the length
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
            if isnan(end.real):  # triangles too thin for a direction: would circle a vertex forever
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
    """Crossed half-edges, and parameters of the crossings, of straight paths from the origin."""
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
    """Fraction of a side at which a line crosses it, from the cross products of its ends with the line."""
    if k == 0:
        along = below + above
        return min(max(below / along, 0.0), 1.0) if along > 0 else 0.5
    # On the hyperboloid or sphere the crossing is `above` times one end plus `below` times the other.
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
    """Compute the half-edges of the triangles along one path with crossings, and their stresses."""
    n, l = path.shape[0], tables.lengths
    tip: Int
    head: Int
    tail: Int
    z: Complex[::1] = np.zeros(n + 3, dtype=np.complex128)
    load: Complex[::1] = np.zeros(n + 3, dtype=np.complex128)
    near: Int[::1] = np.zeros(n, dtype=np.int64)
    far: Int[::1] = np.zeros(n, dtype=np.int64)  # with `near`, the ends of the crossed edges
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
    """Corner to the left of the side from a to b of length `base`, at the given distances from both."""
    along = (base * base + (at_a - at_b) * (at_a + at_b)) / (2 * base)
    height = sqrt(max((at_a - along) * (at_a + along), 0.0))
    return a + (b - a) / base * point(along, height)


@cython.cfunc
@cython.exceptval(check=False)
def _carry(
    v: Int, a: Int, b: Int, z: ConstComplex[::1], load: Complex[::1], stresses: Real[::1]
) -> cython.void:
    """Balance the load at v by the edges to a and b, and transfer it to these."""
    to_a, to_b = z[v] - z[a], z[v] - z[b]
    to_a, to_b = to_a / norm(to_a), to_b / norm(to_b)
    area = cross(to_a, to_b)
    stresses[0], stresses[1] = cross(load[v], to_b) / area, cross(to_a, load[v]) / area
    load[a] = load[a] + stresses[0] * to_a
    load[b] = load[b] + stresses[1] * to_b
