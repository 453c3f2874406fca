"""Height of a smooth surface over its inscribed triangles, and integrals of it.

The height over a triangle is the f of `smooth_integrals`, a quadratic function of barycentric coordinates.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats
from isoembed.mesh.triangulation import Triangulation
from isoembed.space import Space
from isoembed.surface import measures
from isoembed.surface.shape_operator import normal_curvatures, shape_operators
from isoembed.surface.tangent_frames import carried_to_faces, drawn_faces


@dataclass(frozen=True)
class Bulges:
    """Integrals over the surface minus those over the inscribed triangles, (F,) except the operators."""

    operators: Floats  # at the vertices
    heights: Floats  # int f
    area: Floats
    area_size: Floats  # the absolute values of its terms
    integrated_mean_curvature: Floats
    integrated_mean_curvature_size: Floats
    turns: Floats  # (kappa l)^2: sum of squared principal curvatures times the mean square of the edges

    @classmethod
    def of(cls, triangulation: Triangulation, points: Floats, degree: int, space: Space) -> Bulges:
        """Integrate f, its gradient and the slopes at the edges, in closed form."""
        face_edges = triangulation.face_edges
        operators = shape_operators(triangulation, points, degree, space)
        lengths = measures.edge_lengths(triangulation.edges, points, space)
        kappa = normal_curvatures(triangulation, points, operators, space)
        f = (kappa * lengths**2 / 2)[face_edges]  # f[:, h] is the coefficient of lambda_h lambda_(h + 1)
        l = lengths[face_edges]
        corners = drawn_faces(space, triangulation.faces, points)
        A = measures.triangle_areas(triangulation.faces, points, space)
        at_corners = carried_to_faces(space, triangulation.faces, points, operators)
        B = (at_corners[:, 0] + at_corners[:, 1] + at_corners[:, 2]) / 3
        trace = np.einsum("fii->f", B)
        square = np.einsum("fij,fij->f", B, B)
        # The gradients of lambda point inward across the edges and have length 1 / height; a triangle
        # without area contributes nothing.
        twice = np.where(A > 0, 2 * A, np.inf)[:, None]
        inward = _inward(corners)
        grad_lambda = inward * (l[:, [1, 2, 0]] / twice)[:, :, None]
        # grad f = sum_a lambda_a G_a: G_a is the gradient at the corner a.
        G = f[:, :, None] * grad_lambda[:, [1, 2, 0]] + f[:, [2, 0, 1], None] * grad_lambda[:, [2, 0, 1]]
        turned = np.einsum("fij,faj->fai", B, G)
        steep = A / 12 * (_dot(G.sum(axis=1), G.sum(axis=1)) + _dot(G, G).sum(axis=1))
        bent = A / 12 * (_dot(G.sum(axis=1), turned.sum(axis=1)) + _dot(G, turned).sum(axis=1))
        heights = A / 12 * f.sum(axis=1)
        kinks = np.zeros_like(A)
        for h in range(3):
            g, g_next = -_dot(G[:, h], inward[:, h - 1]), -_dot(G[:, (h + 1) % 3], inward[:, h - 1])
            f_t = f[:, h] / l[:, h]  # at the ends, with opposite signs
            cubes = (g + g_next) * (g**2 + g_next**2) / 4
            kinks += l[:, h] * (f_t**2 * (g + g_next) / 6 + cubes / 3)
        terms = np.stack(
            [
                ((trace**2 - square) / 2 - space.curvature) * heights,
                -(trace * steep - bent) / 2,
                trace * steep / 4,
                kinks / 4,
            ]
        )
        return cls(
            operators=operators,
            heights=heights,
            area=trace * heights - steep / 2,
            area_size=np.abs(trace * heights) + steep / 2,
            integrated_mean_curvature=terms.sum(axis=0),
            integrated_mean_curvature_size=np.abs(terms).sum(axis=0),
            turns=square * np.mean(l**2, axis=1),
        )


def _inward(corners: Floats) -> Floats:
    """Unit vectors in triangles, (F, 3, 3), across the edge opposite to each corner and toward it."""
    each = np.arange(corners.size // 3).reshape(-1, 3)
    normals = measures.face_normals(each, corners.reshape(-1, 3))
    norms = np.linalg.norm(normals, axis=1)[:, None]
    normals /= np.where(norms > 0, norms, 1.0)
    opposite = corners[:, [2, 0, 1]] - corners[:, [1, 2, 0]]
    opposite /= np.linalg.norm(opposite, axis=2)[:, :, None]
    return np.cross(normals[:, None, :], opposite)


def _dot(a: Floats, b: Floats) -> Floats:
    return np.asarray(np.einsum("...i,...i->...", a, b))
