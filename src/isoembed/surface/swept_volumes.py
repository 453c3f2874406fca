"""Derivative of the volume in hyperbolic and spherical space.

With the fourth coordinate w, a point of a triangle is ``sum of s_i X_i`` over its norm, with barycentric
coordinates s, and a motion with normal speeds phi_i of the corners has the normal speed ``sum of s_i phi_i``
there, over the same norm.  Hence a triangle sweeps volume at the rate ``sum of c_i phi_i``,

    c_i = sn b sn c sin A  int s_i / q^2 ds,    q = sum of s_i s_j cs(l_ij),

integrated over the simplex of the s; in Euclidean space it is a third of the area.
"""

import numpy as np

from isoembed.arrays import Floats
from isoembed.mesh.triangulation import Triangulation
from isoembed.space import Space
from isoembed.surface.measures import amplitudes, edge_lengths


def curved_volume_gradient(triangulation: Triangulation, vertices: Floats, space: Space) -> Floats:
    """Gradient of the volume with respect to vertices on the hyperboloid or sphere, (V, 3).

    The unit normal of a triangle is ``(n, -k d)``, where ``n . y = d`` is its plane in projective coordinates
    y, with ``|n|^2 + k d^2 = 1``; the normal speed of a corner with velocity x' is ``(n + k d y) . x'``.
    """
    t, k = triangulation, space.curvature
    y = vertices / space.heights(vertices)[:, None]
    corners = y[t.faces]
    n = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    d = np.einsum("fi,fi->f", n, corners[:, 0])
    size = np.sqrt(np.einsum("fi,fi->f", n, n) + k * d * d)[:, None]
    n, d = n / size, d / size[:, 0]
    speeds = n[:, None, :] + k * d[:, None, None] * corners
    gradients = (_shares(t, vertices, space)[:, :, None] * speeds).reshape(-1, 3)
    return np.stack([np.bincount(t.faces.ravel(), column) for column in gradients.T], axis=1)


def _shares(t: Triangulation, vertices: Floats, space: Space) -> Floats:
    """Coefficients c, (F, 3)."""
    lengths = edge_lengths(t.edges, vertices, space)[t.face_edges]  # from each corner to the next one
    # quadrature nodes: 6, plus 6 per radius of curvature in the longest edge
    wanted = 6 + 6.0 * space.root * float(lengths.max())
    nodes, weights = np.polynomial.legendre.leggauss(int(min(wanted, 80)))  # nodes at most
    nodes, weights = (nodes + 1) / 2, weights / 2
    short = 2 * (1 - space.cs(lengths))
    found = np.zeros((t.n_faces, 3))
    for u, of_u in zip(nodes, weights, strict=True):
        for v, of_v in zip(nodes, weights, strict=True):
            s = np.array([1 - u, u * (1 - v), u * v])
            q = 1 - short @ (s * np.roll(s, -1))
            found += of_u * of_v * u * s / q[:, None] ** 2
    return found * amplitudes(t.faces, vertices, space)[:, None]
