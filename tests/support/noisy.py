"""Surfaces whose lengths have errors, and by how much they differ."""

import numpy as np

import isoembed
from isoembed.gallery import triangulate
from isoembed.surface import curvature, measures
from isoembed.surface.rigidity import length_residuals

SCALARS = ("area", "volume", "integrated_mean_curvature")
ARRAYS = ("vertices", "normals", "dihedral_angles", "mean_curvature")


def surface(body, n):
    """A body in n vertices, as it was found."""
    x, faces = triangulate(body, n, irregular=3)
    metric = isoembed.PolyhedralMetric.from_mesh(x, faces)
    return isoembed.Embedding(metric, x, method="given", tolerance=1e-10)


def realized(found, system, lengths):
    """The vertices with these lengths, by Newton's method, as near as a rigid motion takes them."""
    x = found.vertices
    for _ in range(3):
        x = x - system.step(x, lengths, length_residuals(found.triangulation, x, lengths))
    center, home = x.mean(axis=0), found.vertices.mean(axis=0)
    u, _, v = np.linalg.svd((x - center).T @ (found.vertices - home))
    return (x - center) @ u @ v + home


def normals(faces, x):
    """Unit normals."""
    N = measures.face_normals(faces, x)
    return N / np.linalg.norm(N, axis=1, keepdims=True)


def differences(found, x):
    """What each quantity of `Changes` has become, less what it was; of vectors, the norm."""
    t, x0 = found.triangulation, found.vertices
    return {
        "vertices": np.linalg.norm(x - x0, axis=1),
        "normals": np.linalg.norm(normals(t.faces, x) - normals(t.faces, x0), axis=1),
        "dihedral_angles": curvature.dihedral_angles(t, x) - curvature.dihedral_angles(t, x0),
        "mean_curvature": curvature.vertex_mean_curvature(t, x) - found.mean_curvature,
        "area": measures.area(t.faces, x) - found.area,
        "volume": measures.volume(t.faces, x) - found.volume,
        "integrated_mean_curvature": curvature.integrated_mean_curvature(t, x)
        - found.integrated_mean_curvature,
    }
