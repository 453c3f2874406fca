"""Convex solids from first principles: Platonic, Archimedean and Catalan solids, prisms and pyramids.

Each is the array of its vertices, shape (V, 3), of edge length 1 where all edges are equal; the faces are
those of the hull, `polygons`.  Johnson solids are in `johnson_solids`.
"""

from functools import cache

import numpy as np
from scipy.optimize import fsolve
from scipy.spatial import ConvexHull

PHI = (1 + 5**0.5) / 2


def polygons(points):
    """Faces of the hull, each the vertices around it, counterclockwise seen from outside."""
    hull = ConvexHull(points)
    faces, left = [], np.arange(len(hull.simplices))
    while left.size:
        plane = hull.equations[left[0]]
        same = np.abs(hull.equations[left] - plane).max(axis=1) < 1e-7
        same, left = left[same], left[~same]
        corners = np.unique(hull.simplices[same])
        arms = points[corners] - points[corners].mean(axis=0)
        around = np.arctan2(arms @ np.cross(plane[:3], arms[0]), arms @ arms[0])
        faces.append(corners[np.argsort(around)])
    return faces


def triangles(faces):
    """Polygons cut into triangles from their first corners, shape (F, 3)."""
    return np.array([[face[0], face[k], face[k + 1]] for face in faces for k in range(1, len(face) - 1)])


def has_regular_faces(points):
    """Whether all vertices are on the hull, and its faces are regular polygons of side 1."""
    faces = polygons(points)
    for face in faces:
        sides = np.linalg.norm(points[face] - np.roll(points[face], 1, axis=0), axis=1)
        radii = np.linalg.norm(points[face] - points[face].mean(axis=0), axis=1)
        if max(np.abs(sides - 1).max(), np.ptp(radii)) > 1e-12:
            return False
    return len(np.unique(np.concatenate(faces))) == len(points)


def unit_edges(points):
    return points / np.sort(np.linalg.norm(points[0] - points, axis=1))[1]


# Platonic and Archimedean solids: orbits of a reflection group.

RINGS = {
    "tetrahedron": (3, (1, 0, 0)),
    "cube": (4, (1, 0, 0)),
    "octahedron": (4, (0, 0, 1)),
    "dodecahedron": (5, (1, 0, 0)),
    "icosahedron": (5, (0, 0, 1)),
    "truncated tetrahedron": (3, (1, 1, 0)),
    "cuboctahedron": (4, (0, 1, 0)),
    "truncated cube": (4, (1, 1, 0)),
    "truncated octahedron": (4, (0, 1, 1)),
    "rhombicuboctahedron": (4, (1, 0, 1)),
    "truncated cuboctahedron": (4, (1, 1, 1)),
    "icosidodecahedron": (5, (0, 1, 0)),
    "truncated dodecahedron": (5, (1, 1, 0)),
    "truncated icosahedron": (5, (0, 1, 1)),
    "rhombicosidodecahedron": (5, (1, 0, 1)),
    "truncated icosidodecahedron": (5, (1, 1, 1)),
}
"""Of the solid: the order of the rotations of its faces, and the mirrors that the vertex is not on."""

SNUBS = {"snub cube": 4, "snub dodecahedron": 5}
PLATONIC = tuple(RINGS)[:5]
ARCHIMEDEAN = (*tuple(RINGS)[5:], *SNUBS)


def mirrors(p):
    """Normals of the mirrors of the group [p, 3], as rows."""
    c = np.cos(np.pi / p)
    first, second = np.array([1.0, 0, 0]), np.array([-c, np.sqrt(1 - c * c), 0])
    y = -0.5 / second[1]
    return np.array([first, second, [0, y, np.sqrt(1 - y * y)]])


def orbit(point, generators):
    """All images of a point under the group of these matrices."""
    found = [point]
    for x in found:
        for g in generators:
            if np.abs(found - g @ x).max(axis=1).min() > 1e-6:
                found.append(g @ x)
    return np.array(found)


@cache
def uniform(name):
    """A Platonic or Archimedean solid."""
    if name in RINGS:
        p, ringed = RINGS[name]
        normals = mirrors(p)
        reflections = [np.eye(3) - 2 * np.outer(m, m) for m in normals]
        return unit_edges(orbit(np.linalg.solve(normals, ringed), reflections))
    normals = mirrors(SNUBS[name])
    a, b, c = (np.eye(3) - 2 * np.outer(m, m) for m in normals)

    def uneven(x):
        ab, bc, ac = (np.linalg.norm(x - r @ x) for r in (a @ b, b @ c, a @ c))
        return ab - 1, bc - 1, ac - 1

    return unit_edges(orbit(fsolve(uneven, np.linalg.solve(normals, [1, 1, 1]), xtol=1e-13), (a @ b, b @ c)))


def catalan(name):
    """The dual of an Archimedean solid: a vertex for every face."""
    points = uniform(name)
    duals = []
    for face in polygons(points):
        a, b, c = points[face[:3]]
        normal = np.cross(b - a, c - a)
        duals.append(normal / (normal @ a))
    return np.array(duals)


# Prisms and pyramids.


def ring(n, z=0.0, turn=0.0):
    """A regular n-gon of side 1 around the z axis, a vertex at the angle `turn`."""
    angle = turn + 2 * np.pi * np.arange(n) / n
    radius = 0.5 / np.sin(np.pi / n)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), np.full(n, z)])


def prism(n, height=1.0):
    return np.vstack([ring(n), ring(n, height)])


def antiprism(n, height=None):
    """Without a height, that with equilateral triangles."""
    return np.vstack([ring(n), ring(n, drum(n) if height is None else height, np.pi / n)])


def drum(n):
    """Height of the antiprism with equilateral triangles."""
    return np.sqrt(1 - (0.5 / np.cos(np.pi / (2 * n))) ** 2)


def pyramid(n, height):
    return np.vstack([ring(n), [0, 0, height]])


def bipyramid(n, up, down):
    return np.vstack([pyramid(n, up), [0, 0, -down]])
