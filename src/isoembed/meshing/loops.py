# cython: boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False, infer_types=True
"""Compiled loops of mesh improvement: vertex steps, flips and quality checks."""

from __future__ import annotations

import cython
import numpy as np
from cython.cimports.isoembed.c_types import ConstFlag, ConstInt, ConstReal, Flag, Int, Int8, Real
from cython.cimports.isoembed.intrinsic.delaunay_loops import looks_outward
from cython.cimports.isoembed.intrinsic.loops import (
    Mesh,
    corner_angle,
    edges_between,
    following,
    glue,
    preceding,
)
from cython.cimports.libc.math import cos, hypot, sin, sqrt

INF = cython.declare(cython.double, float("inf"))
PI = cython.declare(cython.double, 3.141592653589793)
LONGEST_STEP = cython.declare(cython.double, 0.5)  # over the shortest edge at the vertex, as in `lloyd`
_GOOD = cython.declare(cython.schar, 0)  # verdicts, as in `touch_up`
_OUTSIDE = cython.declare(cython.schar, 1)
_INWARD = cython.declare(cython.schar, 2)


@cython.cfunc
@cython.exceptval(check=False)
def _normalize(x: Real[:, ::1], v: Int) -> cython.void:
    size = sqrt(x[v, 0] * x[v, 0] + x[v, 1] * x[v, 1] + x[v, 2] * x[v, 2])
    for c in range(3):
        x[v, c] /= size


def relaxed(
    u: ConstReal[:, ::1],
    mesh: Mesh,
    density: ConstReal[::1],
    moving: ConstFlag[::1],
    optimal: cython.bint,
    factor: Real,
):
    """Directions (V, 3) after moving some vertices within their stars, unfolded into the plane.

    Parameters
    ----------
    u : ndarray, shape (V, 3)
    mesh : Mesh
        Delaunay triangulation.
    density : ndarray, shape (V,)
        Prescribed number of vertices per area, up to a factor.
    moving : ndarray of bool, shape (V,)
    optimal : bool
        Whether to move toward the mean circumcenter of the triangles (optimal Delaunay triangulation: Chen
        and Holst, 2011), which repairs quickly, or toward the centroid of the Voronoi cell (Du, Faber and
        Gunzburger, 1999), which smooths.  Both use the squared density as mass density.
    factor : float
        Over-relaxation factor.

    Notes
    -----
    The angles of a star are scaled to 2 pi.  A step in the plane is mapped to the sphere by the linear map
    that best fits the neighbors' unfolded positions to their directions.  Steps that would invert a triangle
    are shortened.
    """
    corners = mesh.corners
    moved: Real[:, ::1] = np.array(u)
    settled: Flag[::1] = np.zeros(u.shape[0], dtype=np.bool_)
    step: Real[::1] = np.empty(3)
    room: Real[:, ::1] = np.empty((2, 3))
    v: Int
    f: Int
    for first in range(corners.shape[0]):
        v = corners[first]
        if moving[v] and not settled[v]:
            settled[v] = True
            _set_step(first, u, mesh, density, optimal, factor, step, room)
            for c in range(3):
                moved[v, c] += step[c]
            _normalize(moved, v)
    keep: Real = 0.5
    for attempt in range(9):
        turned: cython.bint = False
        for f in range(0, corners.shape[0], 3):
            if not looks_outward(moved, corners[f], corners[f + 1], corners[f + 2]):
                turned = True
                for h in range(f, f + 3):
                    v = corners[h]
                    for c in range(3):
                        moved[v, c] = u[v, c] + keep * (moved[v, c] - u[v, c])
                    _normalize(moved, v)
        if not turned:
            return np.asarray(moved)
        if attempt == 7:
            keep = 0.0
    return np.array(u)


@cython.cfunc
@cython.exceptval(check=False)
def _set_step(
    first: Int,
    u: ConstReal[:, ::1],
    mesh: Mesh,
    density: ConstReal[::1],
    optimal: cython.bint,
    factor: Real,
    step: Real[::1],
    room: Real[:, ::1],
) -> cython.void:
    """Set the tangential displacement (3,) of the start vertex of half-edge `first`."""
    j: Int
    k: Int
    neighbor: Int
    corners, twins, lengths = mesh.corners, mesh.twins, mesh.lengths
    v = corners[first]
    total: Real = 0.0
    shortest: Real = INF
    h = first
    while True:
        total += corner_angle(h, mesh)
        shortest = min(shortest, lengths[h])
        h = twins[preceding(h)]
        if h == first:
            break

    step[0] = step[1] = step[2] = 0.0
    if not (total > 0.0 and shortest > 0.0):
        return  # the lengths form no triangles
    scale = 2.0 * PI / total
    weight, x, y = 0.0, 0.0, 0.0
    xx, xy, yy = 0.0, 0.0, 0.0
    along: Real[:, ::1] = room
    along[:, :] = 0.0
    direction = 0.0
    px, py = lengths[first], 0.0
    while True:
        into = preceding(h)
        j, k = corners[following(h)], corners[into]
        direction += scale * corner_angle(h, mesh)
        qx, qy = lengths[into] * cos(direction), lengths[into] * sin(direction)
        xx += px * px
        xy += px * py
        yy += py * py
        height = u[j, 0] * u[v, 0] + u[j, 1] * u[v, 1] + u[j, 2] * u[v, 2]
        for c in range(3):
            tangent = u[j, c] - height * u[v, c]
            along[0, c] += tangent * px
            along[1, c] += tangent * py
        double = px * qy - py * qx
        if double > 0.0:
            p2, q2 = px * px + py * py, qx * qx + qy * qy
            cx, cy = 0.5 * (qy * p2 - py * q2) / double, 0.5 * (px * q2 - qx * p2) / double
            mean = (density[v] + density[j] + density[k]) / 3.0
            if optimal:
                mass = double * mean * mean
                weight += mass
                x += mass * cx
                y += mass * cy
            else:
                for half in range(2):
                    mx = 0.5 * px if half == 0 else 0.5 * qx
                    my = 0.5 * py if half == 0 else 0.5 * qy
                    side = 1.0 if half == 0 else -1.0
                    neighbor = j if half == 0 else k
                    # Signed, as the circumcenter of an obtuse triangle is outside.
                    area = side * (mx * cy - my * cx)
                    middle = 0.5 * (density[v] + density[neighbor])
                    share = (density[v] + middle + mean) / 3.0
                    mass = area * (share * share)
                    weight += mass
                    x += mass * (mx + cx) / 3.0
                    y += mass * (my + cy) / 3.0
        px, py = qx, qy
        h = twins[into]
        if h == first:
            break

    determinant = xx * yy - xy * xy
    if not (weight > 0.0 and determinant > 0.0):
        return
    x, y = factor * x / weight, factor * y / weight
    bound = LONGEST_STEP * shortest
    cut = bound / max(bound, hypot(x, y))
    a, b = cut * (yy * x - xy * y) / determinant, cut * (xx * y - xy * x) / determinant
    for c in range(3):
        step[c] = a * along[0, c] + b * along[1, c]


def joined(tails: ConstInt[::1], twin: ConstInt[::1], halfedges: ConstInt[::1], vertices: ConstInt[::1]):
    """Whether the start of a half-edge and a vertex are adjacent, for each pair of them."""
    found: Flag[::1] = np.zeros(halfedges.shape[0], dtype=np.bool_)
    for row in range(halfedges.shape[0]):
        found[row] = edges_between(halfedges[row], vertices[row], tails, twin) > 0
    return np.asarray(found)


def flip_halfedges(faces: Int[:, ::1], twin: Int[::1], halfedges: ConstInt[::1]):
    """Flip half-edges, in different triangles, in place."""
    for h in halfedges:
        g = twin[h]
        f, c, e, d = h // 3, h % 3, g // 3, g % 3
        i, j, k, m = faces[f, c], faces[f, (c + 1) % 3], faces[f, (c + 2) % 3], faces[e, (d + 2) % 3]
        ki, im = twin[3 * f + (c + 2) % 3], twin[3 * e + (d + 1) % 3]
        mj, jk = twin[3 * e + (d + 2) % 3], twin[3 * f + (c + 1) % 3]
        faces[f, 0], faces[f, 1], faces[f, 2] = k, i, m
        faces[e, 0], faces[e, 1], faces[e, 2] = m, j, k
        glue(3 * f, ki, twin)
        glue(3 * f + 1, im, twin)
        glue(3 * f + 2, 3 * e + 2, twin)
        glue(3 * e, mj, twin)
        glue(3 * e + 1, jk, twin)


def judge(
    x: ConstReal[:, ::1],
    normals: ConstReal[:, ::1],
    faces: ConstInt[:, ::1],
    angles: ConstReal[:, ::1],
    window: ConstReal[::1],
    which: ConstInt[::1],
    verdicts: Int8[::1],
):
    """Verdicts on some triangles, in place: good, an angle outside the window, or inward."""
    for f in which:
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        outward: Real = 0.0
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            area = (x[b, i] - x[a, i]) * (x[c, j] - x[a, j]) - (x[b, j] - x[a, j]) * (x[c, i] - x[a, i])
            outward += area * (normals[a, k] + normals[b, k] + normals[c, k])
        verdicts[f] = _GOOD
        for k in range(3):
            if not (window[0] <= angles[f, k] and angles[f, k] <= window[1]):
                verdicts[f] = _OUTSIDE
        if not outward > 0.0:
            verdicts[f] = _INWARD


def surroundings(faces: ConstInt[:, ::1], twin: ConstInt[::1], seeds: ConstInt[::1], n: Int, rings: Int):
    """Vertices within a number of edges of some triangles, and the triangles around them."""
    vertices: Int[::1] = np.empty(n, dtype=np.int64)
    triangles: Int[::1] = np.empty(faces.shape[0], dtype=np.int64)
    seen_vertices: Flag[::1] = np.zeros(n, dtype=np.bool_)
    visited: Flag[::1] = np.zeros(faces.shape[0], dtype=np.bool_)
    n_vertices: Int = 0
    begin: Int = 0
    end: Int = seeds.shape[0]
    h: Int
    f: Int
    for k in range(seeds.shape[0]):
        triangles[k] = seeds[k]
        visited[seeds[k]] = True
    for _ in range(rings + 1):
        last = end
        for row in range(begin, last):
            for first in range(3 * triangles[row], 3 * triangles[row] + 3):
                v = faces[first // 3, first % 3]
                if seen_vertices[v]:
                    continue
                seen_vertices[v] = True
                vertices[n_vertices] = v
                n_vertices += 1
                h = first
                while True:
                    f = h // 3
                    if not visited[f]:
                        visited[f] = True
                        triangles[end] = f
                        end += 1
                    h = twin[3 * f + (h + 2) % 3]
                    if h == first:
                        break
        begin = last
    return np.array(vertices[:n_vertices]), np.array(triangles[:end])
