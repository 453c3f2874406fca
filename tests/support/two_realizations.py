"""Two surfaces with the same lengths."""

import numpy as np

import zoo
from isoembed import Embedding, PolyhedralMetric


def capped(height):
    """The corners of a regular tetrahedron, and a fifth vertex over its first face, or below it."""
    x, faces = zoo.tetrahedron()
    a, b, c = faces[0]
    normal = np.cross(x[b] - x[a], x[c] - x[a])
    apex = x[faces[0]].mean(axis=0) + height * normal / np.linalg.norm(normal)
    return np.vstack([x, apex]), np.vstack([faces[1:], [[a, b, 4], [b, c, 4], [c, a, 4]]])


def cap_outside_and_inside(height):
    """Both embeddings of the same metric."""
    metric = PolyhedralMetric.from_mesh(*capped(height))
    return tuple(Embedding(metric, capped(h)[0], method="given", tolerance=1e-10) for h in (height, -height))
