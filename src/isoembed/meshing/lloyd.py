"""Lloyd relaxation on a surface: vertices move to the centroids of their Voronoi cells."""

import numpy as np

from isoembed.arrays import Floats, Indices

OVERRELAXATION = 1.5  # of Lloyd steps, which converge slowly; with 1.8 they do not converge
RINGS = 2  # edges between a bad triangle and vertices that move


def lloyd_step(vertices: Floats, normals: Floats, faces: Indices, density: Floats) -> Floats:
    """Tangential displacements (V, 3) toward the centroids of the Voronoi cells.

    Parameters
    ----------
    vertices, normals : (V, 3)
        Points of the mesh, and outward normals of the surface there.
    faces : (F, 3)
        Delaunay mesh.
    density : (V,)
        Prescribed number of vertices per area, up to a factor.

    Notes
    -----
    A centroidal Voronoi tessellation for the mass density rho has rho^(1/2) vertices per area in two
    dimensions, so rho is the squared vertex density. The part of a vertex's cell in a triangle consists of
    two right triangles between the vertex, the midpoints of its two edges and the circumcenter; their areas
    are signed, as the circumcenter of an obtuse triangle is outside.

    References
    ----------
    Q. Du, V. Faber and M. Gunzburger, "Centroidal Voronoi tessellations" (1999).
    """
    x, w = vertices[faces], density[faces]
    edge = np.roll(x, -2, axis=1) - np.roll(x, -1, axis=1)  # edge c is opposite to corner c
    l2 = np.einsum("fci,fci->fc", edge, edge)
    cosine = l2.sum(axis=1)[:, None] - 2.0 * l2  # 2 b c cos A
    center = np.einsum("fc,fci->fi", l2 * cosine, x) / (l2 * cosine).sum(axis=1)[:, None]
    double_area = np.linalg.norm(np.cross(edge[:, 0], edge[:, 1]), axis=1)
    area = l2 * cosine / (16.0 * double_area[:, None])  # l^2 cot(A) / 8 for each end of the edge

    weight, moment = np.zeros(len(vertices)), np.zeros_like(vertices)
    for side in (1, 2):  # edges opposite to the next two corners
        other = 3 - side
        middle = 0.5 * (x + np.roll(x, -other, axis=1))
        middle_density = 0.5 * (w + np.roll(w, -other, axis=1))
        mass = np.roll(area, -side, axis=1) * ((w + middle_density + w.mean(axis=1)[:, None]) / 3.0) ** 2
        centroid = (x + middle + center[:, None]) / 3.0
        weight += np.bincount(faces.ravel(), mass.ravel(), len(vertices))
        for axis in range(3):
            first = mass * centroid[..., axis]
            moment[:, axis] += np.bincount(faces.ravel(), first.ravel(), len(vertices))

    step = OVERRELAXATION * (moment / weight[:, None] - vertices)
    step -= np.einsum("ij,ij->i", step, normals)[:, None] * normals
    shortest = np.full(len(vertices), np.inf)
    np.minimum.at(shortest, faces, np.sqrt(np.minimum(np.roll(l2, -1, axis=1), np.roll(l2, -2, axis=1))))
    bound = 0.5 * shortest
    return step * (bound / np.maximum(bound, np.linalg.norm(step, axis=1)))[:, None]
