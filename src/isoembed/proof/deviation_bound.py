"""Proven bounds on the change of a surface when its lengths change.

`nearby_realization` proves that lengths within the given errors have a realization y near the vertices x.
With z, s, J and r as there, the distance of a vertex from x is at most ``|z_a - x_a| + r / s_a``.  Moreover,
y is the end of a path from z on which the squared lengths are linear in time, with velocity ``-S^-1 J^+
F(z)``; it stays in the ball ``|y - z|_s <= r`` because ``|J(y) - J(z)| <= K |y - z|_s``.

Changes of normals and dihedral angles are bounded by the heights of the triangles (`moved_triangles`), those
of areas by the lengths.  The integral of H changes by ``d (1/2 sum l theta) = 1/2 sum theta dl`` (Schlaefli)
along the path.  For the volume, with its gradient g at x, any v, and the derivative A of F at z,

    g . d = (g - A^T v) . d + v . A d,    A d = -F(z) - Q(d),    |Q(d)| <= r^2 / min s,

and terms of higher order in d are bounded triangle by triangle.  The v for which the first term vanishes is
the derivative of the volume with respect to the lengths.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from isoembed.arrays import Floats
from isoembed.mesh.triangulation import Triangulation
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.proof.length_equations import NotProven
from isoembed.proof.moved_triangles import MovedTriangles
from isoembed.proof.nearby_realization import NearbyRealization, norm
from isoembed.proof.rounding import GUARD, U, gamma
from isoembed.reprs import short_repr
from isoembed.surface.changes import Changes
from isoembed.surface.curvature import vertex_mean_curvature
from isoembed.surface.derivatives import volume_gradient
from isoembed.surface.measures import edge_lengths
from isoembed.surface.vertex_areas import vertex_area_changes, vertex_areas


@short_repr
@dataclass(frozen=True, eq=False)
class DeviationBound(Changes):
    """Upper bounds on the errors of a surface in R^3 for all lengths within given errors.

    For any such lengths there is a surface whose quantities differ by at most these bounds from those
    computed for the given one, including rounding.  Bounds are infinite where nothing is proven.

    Attributes
    ----------
    vertices : ndarray, shape (V,)
        Bounds on the displacements of the vertices.
    normals : ndarray, shape (F,)
        Bounds on the rotation angles of the triangles' normals, in radians.
    dihedral_angles : ndarray, shape (E,)
    mean_curvature : ndarray, shape (V,)
    area, volume, integrated_mean_curvature : float
    reason : str
        Reason why nothing is proven; empty if the bounds are proven.
    """

    reason: str = ""

    @property
    def report(self) -> dict[str, Any]:
        """Area, volume and int H dA; root mean square and maximum of each array, and the `reason`."""
        return {**super().report, "reason": self.reason}

    @classmethod
    def unproven(cls, triangulation: Triangulation, reason: str) -> DeviationBound:
        """Infinite bounds."""
        t, inf = triangulation, float("inf")
        at_vertices, at_faces, at_edges = (np.full(n, inf) for n in (t.n_vertices, t.n_faces, t.n_edges))
        return cls(at_vertices, at_faces, at_edges, at_vertices, inf, inf, inf, reason)

    @classmethod
    def of(
        cls, metric: PolyhedralMetric, vertices: Floats, errors: Floats, volume_rates: Floats
    ) -> DeviationBound:
        """Bounds for errors of the lengths up to the given ones.

        Parameters
        ----------
        metric : PolyhedralMetric
            Normalized.
        vertices : ndarray, shape (V, 3)
        errors : ndarray, shape (E,)
        volume_rates : ndarray, shape (E,)
            Derivatives of the volume with respect to the lengths.  Inaccurate ones make its bound larger.

        Raises
        ------
        NotProven
            The errors are too large for the proof.
        """
        if (errors >= metric.lengths).any():
            k = int(np.argmax(errors >= metric.lengths))
            raise NotProven(f"the error of edge {k} is no smaller than its length")
        nearby, t = NearbyRealization.of(metric, vertices, errors, {}), metric.triangulation
        _, farthest = nearby.newton_kantorovich()
        s, steps = nearby.equations.weights, GUARD * nearby.steps
        moved = MovedTriangles(t, vertices, steps, GUARD / s, GUARD * farthest * float(s.min()))

        lengths = edge_lengths(t.edges, vertices)
        squares = GUARD * nearby.length_differences * (2 * lengths + nearby.length_differences)
        grown = moved.area_changes(squares)
        theta, bent = moved.dihedral_angles, np.where(moved.may_jump, 2 * np.pi, moved.bends)
        total = gamma(t.n_edges + 64) * float(moved.areas.sum())
        return cls(
            vertices=moved.far,
            normals=np.minimum(moved.turns, np.pi),
            dihedral_angles=bent,
            mean_curvature=_mean_curvature(moved, lengths, nearby.length_differences, bent, squares),
            area=GUARD * float(grown.sum()) + total,
            volume=_volume(moved, nearby, volume_rates),
            integrated_mean_curvature=_integral(moved, nearby, lengths, theta),
        )


def _mean_curvature(
    moved: MovedTriangles, lengths: Floats, length_errors: Floats, bent: Floats, squares: Floats
) -> Floats:
    """Bounds at the vertices, where H is a quarter of the sum of l theta, divided by the vertex area."""
    t, x, theta = moved.triangulation, moved.vertices, np.abs(moved.dihedral_angles)
    rounding = gamma(int(t.degrees.max()) + 32)
    integrals = (lengths + length_errors) * bent + (length_errors + rounding * lengths) * theta
    of_integrals = np.bincount(t.edges.ravel(), np.repeat(integrals / 4, 2))
    # Rounding of the lengths, and of the cotangents by at most 10 U (sum of l^2) / A.
    squares = squares + rounding * lengths * lengths
    of_areas = vertex_area_changes(t, x, squares, moved.area_changes(squares))
    perimeters = (lengths[t.face_edges] ** 2).sum(axis=1)
    of_areas += np.bincount(t.faces.ravel(), np.repeat(16 * U * perimeters**2 / moved.areas, 3))
    areas = vertex_areas(t, x)
    H = np.abs(vertex_mean_curvature(t, x, areas))
    lower = areas * (1 - rounding) - GUARD * of_areas
    with np.errstate(divide="ignore", invalid="ignore"):
        found = GUARD * (of_integrals + H * of_areas) / lower + rounding * H
    return np.where(lower > 0, found, np.inf)


def _integral(moved: MovedTriangles, nearby: NearbyRealization, lengths: Floats, theta: Floats) -> float:
    """Bound on the change of int H dA: length changes to z and y, times half the largest angles."""
    t = moved.triangulation
    a, b = t.edges.T
    to_z = moved.steps[a] + moved.steps[b]
    # The squares of the lengths at z and at y differ by 2 l F.
    change = 2 * nearby.equations.lengths * nearby.residuals
    at_z = np.maximum(lengths - to_z, 0.0)
    at_y = np.sqrt(np.maximum(at_z * at_z - change, 0.0))
    with np.errstate(divide="ignore"):
        to_y = change / (at_z + at_y)
    largest = np.abs(theta) + moved.bends
    jumps = np.where(moved.may_jump, np.pi * (lengths + nearby.length_differences), 0.0)
    rounding = gamma(t.n_edges + 64) * np.abs(theta) * lengths
    rounding += lengths * (moved.rounding[t.edge_faces].sum(axis=1) + 16 * U)
    return GUARD**2 * float(((to_z + to_y) * largest / 2 + jumps + rounding / 2).sum())


def _volume(moved: MovedTriangles, nearby: NearbyRealization, rates: Floats) -> float:
    """Bound on the change of the volume."""
    t, x, r, s, steps = moved.triangulation, moved.vertices, moved.radius, moved.shares, moved.steps
    (a, b), lengths = t.edges.T, nearby.equations.lengths
    y = np.abs(rates)

    # First order, by F' d = -F(z) - Q(d).
    straight = x[a] - x[b]
    rows = straight / lengths[:, None]
    gradient = volume_gradient(t, x)
    sides = np.linalg.norm(straight, axis=1)
    around = t.faces.ravel()
    longest = sides[t.face_edges].max(axis=1)
    sizes = np.bincount(around, np.repeat(longest**2 / 6, 3))  # magnitudes of the terms of the gradient
    pulled = rates[:, None] * rows
    left = gradient - np.stack(
        [
            np.bincount(a, pulled[:, k], t.n_vertices) - np.bincount(b, pulled[:, k], t.n_vertices)
            for k in range(3)
        ],
        axis=1,
    )
    pulls = np.bincount(t.edges.ravel(), np.repeat(y * sides / lengths, 2))
    rounding = 2 * gamma(int(t.degrees.max()) + 32) * (sizes + pulls)
    left = np.linalg.norm(left, axis=1) + rounding
    # F' is evaluated at z.
    left += np.bincount(t.edges.ravel(), np.repeat(y * (steps[a] + steps[b]) / lengths, 2))
    first = float(y @ nearby.residuals) + norm(rates) * r * r * float(s.max())
    first += norm(left * s) * r + float((np.linalg.norm(gradient, axis=1) + rounding) @ steps)

    # Higher orders: the normals change by at most 2 Lambda + Lambda^2, linear and quadratic in time.
    thirds = moved.areas * (1 + moved.rounding) / 3 * (1 + moved.stretch / 3)
    by_ball = thirds * moved.softness * np.linalg.norm(s[t.faces], axis=1)
    second = r * r * float(np.bincount(around, np.repeat(by_ball, 3)).max())
    by_steps = moved.stretched_by_steps * moved.far[t.faces].sum(axis=1)
    by_steps += moved.stretch * steps[t.faces].sum(axis=1)
    second += float((thirds * by_steps).sum())

    # Rounding of the volume, computed relative to the mean of the vertices.
    out = np.linalg.norm(x - x.mean(axis=0), axis=1).max() + 8 * U * np.abs(x).max()
    measured = gamma(t.n_faces + 64) * float((longest**2).sum()) * out
    measured += 64 * U * float(np.abs(x).max()) * float((longest**2).sum())
    return float(GUARD**2 * (first + second + measured))
