"""Bodies in hyperbolic and spherical space: hulls, and smooth bodies of the gallery carried there."""

import numpy as np

import zoo
from isoembed.gallery import triangulate
from isoembed.metric.polyhedral import PolyhedralMetric


def carried(space, vertices):
    """Points of Euclidean space at the same distance from the origin, in the same direction."""
    r = np.linalg.norm(vertices, axis=1)[:, None]
    return vertices / r * space.sn(r)


def hull(space, n, size, seed):
    """Convex hull of points about an ellipsoid with axes of 1, .8 and .6 times this size."""
    vertices, _ = zoo.random_hull(n, seed)
    x = carried(space, size * vertices)
    _, faces = zoo.outward_hull(x / space.heights(x)[:, None])
    return x, faces


def smooth(space, surface, n, size):
    """A surface of the gallery, on n vertices: its farthest point is at a distance of this size."""
    vertices, faces = triangulate(surface, n)
    vertices = vertices - vertices.mean(axis=0)
    return carried(space, size * vertices / np.linalg.norm(vertices, axis=1).max()), faces


def metric_of(space, x, faces):
    """The metric of a surface with these triangles, the coordinates forgotten."""
    return PolyhedralMetric.from_mesh(x, faces, curvature=space.curvature)


def misfit(space, x, known):
    """The largest difference of a distance between two vertices from what it is on the known surface."""
    i, j = np.triu_indices(len(x), 1)
    return np.abs(space.distances(x[i], x[j]) - space.distances(known[i], known[j])).max()
