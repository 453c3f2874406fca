"""Geodesic spheres and domes: icosahedral, class I, method 1."""

import numpy as np
from scipy.spatial import ConvexHull

import solids


def dome(frequency, height=None):
    """Vertices and triangles of a sphere of radius 1, a vertex of the icosahedron on top.

    Every triangle of the icosahedron is cut into frequency^2 alike, whose corners are projected.  With a
    height, only triangles above it are left, with their vertices.
    """
    corners = solids.uniform("icosahedron")
    points = np.array(
        [
            (i * corners[a] + j * corners[b] + (frequency - i - j) * corners[c]) / frequency
            for a, b, c in solids.triangles(solids.polygons(corners))
            for i in range(frequency + 1)
            for j in range(frequency + 1 - i)
        ]
    )
    points = points[np.unique(np.round(points, 9), axis=0, return_index=True)[1]]
    points = points / np.linalg.norm(points, axis=1)[:, None]
    faces = outward(points)
    if height is None:
        return points, faces
    up = corners[0] / np.linalg.norm(corners[0])
    side = np.cross(up, corners[1])
    side /= np.linalg.norm(side)
    points = points @ np.array([side, np.cross(up, side), up]).T
    faces = faces[(points[faces, 2] > height).all(axis=1)]
    kept, numbered = np.unique(faces, return_inverse=True)
    return points[kept], numbered.reshape(-1, 3)


def outward(points):
    """Triangles of the hull of points around the origin, counterclockwise seen from outside."""
    faces = ConvexHull(points).simplices
    a, b, c = points[faces].transpose(1, 0, 2)
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), a + b + c) < 0
    faces[inward] = faces[inward][:, ::-1]
    return faces
