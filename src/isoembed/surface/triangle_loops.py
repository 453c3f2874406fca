# cython: boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False, infer_types=True
"""Compiled normals, areas, bounding boxes and dihedral angles of triangles."""

from __future__ import annotations

import cython
import numpy as np
from cython.cimports.isoembed.c_types import ConstInt, ConstReal, Real
from cython.cimports.isoembed.space.trigonometry import triangle_area
from cython.cimports.libc.math import sqrt

TINY = cython.declare(cython.double, 2.2250738585072014e-308)  # smallest normal number
SHUT = cython.declare(cython.double, 1e-9)  # as in `curvature`


def face_normals(faces: ConstInt[:, :], vertices: ConstReal[:, ::1]):
    """Normals of the triangles by the right-hand rule, with twice the areas as norms, (F, 3)."""
    normals: Real[:, ::1] = np.empty((faces.shape[0], 3))
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            normals[f, k] = (vertices[b, i] - vertices[a, i]) * (vertices[c, j] - vertices[a, j]) - (
                vertices[b, j] - vertices[a, j]
            ) * (vertices[c, i] - vertices[a, i])
    return np.asarray(normals)


def face_areas(faces: ConstInt[:, ::1], vertices: ConstReal[:, ::1]):
    """Areas of the triangles, (F,)."""
    normals: Real[:, ::1] = face_normals(faces, vertices)
    areas: Real[::1] = np.empty(faces.shape[0])
    for f in range(faces.shape[0]):
        a, b, c = normals[f, 0], normals[f, 1], normals[f, 2]
        areas[f] = sqrt(a * a + b * b + c * c) / 2
    return np.asarray(areas)


def vertex_normals(faces: ConstInt[:, ::1], vertices: ConstReal[:, ::1]):
    """Unit normals at the vertices, (V, 3): area-weighted means over triangles; zero where these cancel."""
    x: Real
    y: Real
    z: Real
    largest: Real
    sums: Real[:, ::1] = np.zeros((vertices.shape[0], 3))
    normals: Real[:, ::1] = face_normals(faces, vertices)
    for f in range(faces.shape[0]):
        for corner in range(3):
            for k in range(3):
                sums[faces[f, corner], k] += normals[f, k]
    for v in range(vertices.shape[0]):
        x, y, z = sums[v, 0], sums[v, 1], sums[v, 2]
        largest = max(abs(x), abs(y), abs(z))
        if largest > 0:  # the squares of areas would underflow
            x, y, z = x / largest, y / largest, z / largest
            norm = sqrt(x * x + y * y + z * z)
            sums[v, 0], sums[v, 1], sums[v, 2] = x / norm, y / norm, z / norm
    return np.asarray(sums)


def curved_areas(face_lengths: ConstReal[:, ::1], k: Real):
    found: Real[::1] = np.empty(face_lengths.shape[0])
    for f in range(face_lengths.shape[0]):
        found[f] = triangle_area(face_lengths[f, 0], face_lengths[f, 1], face_lengths[f, 2], k)
    return np.asarray(found)


def boxes_of(faces: ConstInt[:, :], vertices: ConstReal[:, ::1]):
    """Signed volumes of the parallelepipeds over the triangles from the origin, (F,)."""
    normals: Real[:, ::1] = face_normals(faces, vertices)
    boxes: Real[::1] = np.empty(faces.shape[0])
    for f in range(faces.shape[0]):
        v = faces[f, 0]
        boxes[f] = (
            vertices[v, 0] * normals[f, 0] + vertices[v, 1] * normals[f, 1] + vertices[v, 2] * normals[f, 2]
        )
    return np.asarray(boxes)


def folds(
    edges: ConstInt[:, ::1],
    edge_halfedges: ConstInt[:, ::1],
    normals: ConstReal[:, ::1],
    vertices: ConstReal[:, ::1],
):
    """Sines and cosines of the dihedral angles, each (E,), times the norms of the normals."""
    sine: Real[::1] = np.empty(edges.shape[0])
    cosine: Real[::1] = np.empty(edges.shape[0])
    for e in range(edges.shape[0]):
        n, m = edge_halfedges[e, 0] // 3, edge_halfedges[e, 1] // 3
        n0, n1, n2 = normals[n, 0], normals[n, 1], normals[n, 2]
        m0, m1, m2 = normals[m, 0], normals[m, 1], normals[m, 2]
        a, b = edges[e, 0], edges[e, 1]
        x, y = vertices[b, 0] - vertices[a, 0], vertices[b, 1] - vertices[a, 1]
        z = vertices[b, 2] - vertices[a, 2]
        length = max(sqrt(x * x + y * y + z * z), TINY)
        sine[e] = (
            (n1 * m2 - n2 * m1) * (x / length)
            + (n2 * m0 - n0 * m2) * (y / length)
            + (n0 * m1 - n1 * m0) * (z / length)
        )
        cosine[e] = n0 * m0 + n1 * m1 + n2 * m2
        if cosine[e] < 0 and abs(sine[e]) < SHUT:
            sine[e] = abs(sine[e])
    return np.asarray(sine), np.asarray(cosine)
