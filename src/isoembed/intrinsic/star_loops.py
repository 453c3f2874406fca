# cython: boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False, infer_types=True
"""Compiled retriangulation of the star of a removed vertex."""

from __future__ import annotations

import cython
import numpy as np
from cython.cimports.isoembed.c_types import Complex, ConstComplex, ConstInt, Int, Real
from cython.cimports.isoembed.intrinsic.chart import (
    argument,
    coordinate,
    cross,
    distance,
    dot,
    point,
    polar,
    toward,
)
from cython.cimports.isoembed.intrinsic.loops import (
    Mesh,
    corner_angle,
    degree,
    following,
    glue,
    modulo,
    preceding,
    push,
    total_angle,
)
from cython.cimports.isoembed.space.trigonometry import amplitude, angle_between, sn

INF = cython.declare(cython.double, float("inf"))
PI = cython.declare(cython.double, 3.141592653589793)
THIN = cython.declare(
    cython.double, 1e-8
)  # height over longest side: below, the triangle inequality may degenerate in floats


@cython.cfunc
def retriangulate_star(
    h: cython.longlong,
    mesh: Mesh,
    leaving: cython.longlong[::1],
    alive: cython.uchar[::1],
    moved: cython.longlong[::1],
    stack: cython.longlong[::1],
) -> cython.bint:
    """Replace the triangles around a vertex by two fewer, and push their sides on a stack.

    Parameters
    ----------
    h : int
        Half-edge leaving the vertex, which has no loop, or a single one that encloses only the end of h.
    mesh : HalfEdges
    leaving : ndarray of int, shape (V,)
        Some half-edge leaving each vertex.
    alive : ndarray of bool, shape (F,)
        Remaining faces.
    moved : ndarray of int, shape (3F,)
        Scratch, all -1.
    stack : ndarray
        Empty stack, as from `empty_stack`.

    Returns
    -------
    bool
        False, with nothing changed, if all triangulations of the polygon have a triangle that is too thin.
    """
    corners, twins, lengths = mesh.corners, mesh.twins, mesh.lengths
    directions, curvature = mesh.directions, mesh.curvature
    i: Int
    j: Int
    k: Int
    t: Int
    # The polygon: its corners, their positions, and the sides from each to the next.
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

    # Lengths between corners, and directions at the first of them.
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
    for t in range(n - 2):  # triangles that are cut off first: i -> k and k -> j are known
        i, k, j = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        if j - i < n - 1:
            size[i, j] = size[j, i] = distance(toward(z[i], z[j], curvature), curvature)
            at_i = angle_between(size[i, k], size[i, j], size[k, j], curvature)
            at_j = angle_between(size[k, j], size[i, j], size[i, k], curvature)
            direction[i, j], direction[j, i] = direction[i, k] + at_i, direction[j, k] - at_j

    half: Int[:, ::1] = np.empty((n, n), dtype=np.int64)  # new half-edges between corners
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
    """Triangles around the start vertex of a half-edge.

    Returns
    -------
    ndarray of int, ndarray of int, ndarray of int
        Vertices around it, faces, and sides between these vertices; if h leads to a vertex enclosed by a
        loop, only those outside the loop, with the inner face last.
    ndarray of complex
        Positions of the vertices in a `chart` centered at the vertex, with the x axis along h.
    """
    corners, twins = mesh.corners, mesh.twins
    folded: cython.bint = h // 3 == twins[h] // 3
    e, edges = h, degree(h, twins, corners.shape[0])
    # If folded, the edges are h, the loop, n + 1 others (the last ends where the first does), and the loop.
    n = edges - 4 if folded else edges
    vertices: Int[::1] = np.empty(n, dtype=np.int64)
    sides: Int[::1] = np.empty(n, dtype=np.int64)
    faces: Int[::1] = np.empty(n + 2 if folded else n, dtype=np.int64)
    z: Complex[::1] = np.empty(n, dtype=np.complex128)
    # The defect from 2 pi is rounding error, distributed to the angles of thin triangles.
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
    """Longest side over height of a half-edge's triangle: amplification of length errors in its angles."""
    a, b, c = mesh.lengths[h], mesh.lengths[following(h)], mesh.lengths[preceding(h)]
    longest, area = max(a, b, c), amplitude(a, b, c, mesh.curvature)
    return longest * sn(longest, mesh.curvature) / area if area > 0 else INF


@cython.cfunc
def _around_tip(z: ConstComplex[::1], far: Real, width: Real, curvature: Real):
    """Unfold a polygon around an inner vertex of small total angle (tip), cut open from it to a corner.

    Parameters
    ----------
    z : ndarray of complex, shape (n,)
        Corners in the chart centered at the other inner vertex, with the x axis toward the tip.
    far, width : float
        Distance of the tip, and length of the loop around it.
    curvature : float

    Returns
    -------
    int
        Corner of the cut, chosen for the best triangles.
    ndarray of complex, shape (n + 2,)
        Corners in the chart centered at the tip: the tip, then all corners from the cut, and that of the cut
        again.
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
            direction = 0j - toward(tip, z[i % n], curvature)
            points[k + 1] = turning * direction if i >= n else direction
        worst: Real = _best_cut(points, curvature)[1]
        if worst > most:
            best, most, best_points = first, worst, points
    return best, np.asarray(best_points)


@cython.cfunc
def _turned(values: ConstInt[::1], first: Int, before: Int):
    """Rotate values to begin at `first`, append the first one again, and prepend `before`."""
    n = values.shape[0]
    result: Int[::1] = np.empty(n + 2, dtype=np.int64)
    result[0] = before
    for k in range(n + 1):
        result[k + 1] = values[(first + k) % n]
    return np.asarray(result)


@cython.cfunc
def _best_cut(z: ConstComplex[::1], curvature: Real):
    """Triangulate a polygon, maximizing the least ratio of height to longest side.

    If all triangles are positively oriented, they do not overlap; no other check is needed.

    Returns
    -------
    ndarray of int, shape (n - 2, 3)
        Corners in ascending order; a triangle comes after those cut off by its shorter sides.
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
