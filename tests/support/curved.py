"""Bodies in hyperbolic and spherical space, with flat vertices, and the triangles of their surfaces."""

import numpy as np

import zoo
from isoembed import PolyhedralMetric
from isoembed.intrinsic.delaunay import make_delaunay
from isoembed.intrinsic.halfedges import HalfEdges
from isoembed.intrinsic.loops import corner_angle
from isoembed.mesh.triangulation import Triangulation
from isoembed.space import Space
from isoembed.space.models import from_model
from sprinkled import sprinkled


def body(n, seed, curvature, size, flat=0, aspect=1.0):
    """Convex hull of n points, and vertices on its faces and edges: (points, faces, which are flat).

    Faces are flat in projective coordinates.  The points are ambient, at most ``size / 2`` from the origin.
    """
    hull, faces = zoo.random_hull(n, seed)
    space, hull = Space(curvature), hull * [aspect, 1, 1]
    y, faces, is_flat = sprinkled(hull, faces, flat, seed)
    far = np.array(size / 2)
    y *= space.sn(far) / space.cs(far) / np.linalg.norm(hull, axis=1).max()
    return from_model(space, y, "projective"), faces, is_flat


def tables_in(x, faces, curvature):
    """The tables of triangles with corners at points of a space."""
    ends = np.sort([faces, np.roll(faces, -1, axis=1)], axis=0)
    lengths = Space(curvature).distances(*x[ends])
    return HalfEdges.of(faces, Triangulation(faces).twins, lengths, curvature)


def angle_sums(tables):
    """The angle around each vertex."""
    views = tables.views
    angles = [corner_angle(h, views) for h in range(tables.corners.size)]
    return np.bincount(tables.corners, angles)


def weights_in(x, curvature):
    """The weights of which the triangles of a convex body are the weighted Delaunay triangles."""
    space = Space(curvature)
    return space.chords(x, space.center(x)) ** 2


def polyhedron_in(tables, x):
    """Flip to the triangles of a convex body, and tell at which half-edges it is bent."""
    tables = tables.copy()
    assert make_delaunay(tables, weights_in(x, tables.curvature))[1] == 0
    y = x / Space(tables.curvature).heights(x)[:, None]
    a, b, c = y[tables.faces.T]
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    here, there = np.repeat(normals, 3, axis=0), normals[tables.twins // 3]
    return tables, (here * there).sum(axis=1) < 1 - 1e-9


def distances_in(tables, x):
    """Straight through space along every half-edge."""
    return Space(tables.curvature).distances(x[tables.corners], x[tables.corners[tables.twins]])


def metric_in(x, faces, curvature):
    """The metric of a mesh in a space."""
    a, b = Triangulation(faces).edges.T
    return PolyhedralMetric(faces, Space(curvature).distances(x[a], x[b]), curvature=curvature)


def apart(x, y, curvature):
    """The largest difference of the distances between any two points, over the largest distance."""
    space = Space(curvature)
    i, j = np.triu_indices(len(x), 1)
    expected = space.distances(x[i], x[j])
    return np.abs(space.distances(y[i], y[j]) - expected).max() / expected.max()
