"""Vertex areas of a surface: circumcentric dual cells, as for the Gaussian curvature.

The integral of H around a vertex is that over its Voronoi cell to leading order, even on irregular
triangulations.  With a third of each triangle as the vertex area, H at a vertex with five neighbors, all with
six, is 1/7 too large on every refinement.
"""

from __future__ import annotations

from typing import cast

import numpy as np

from isoembed.arrays import Floats
from isoembed.mesh.triangulation import Triangulation
from isoembed.metric.triangles import Triangles
from isoembed.space import EUCLIDEAN, Space
from isoembed.surface.measures import edge_lengths, triangle_areas

FARTHEST = 10.0  # times the barycentric area: larger dual areas come from triangles not Delaunay, or flat


def vertex_areas(triangulation: Triangulation, vertices: Floats, space: Space = EUCLIDEAN) -> Floats:
    """Circumcentric dual areas, shape (V,), clipped to a tenth and ten times the barycentric areas.

    The barycentric area is a third of the area of the triangles around a vertex, and replaces the dual area
    of a vertex beside a triangle without area.
    """
    duals, thirds = _duals_and_thirds(triangulation, vertices, space)
    return np.clip(duals, thirds / FARTHEST, thirds * FARTHEST)


def vertex_area_rates(triangulation: Triangulation, vertices: Floats, grown: Floats, rates: Floats) -> Floats:
    """Derivatives of `vertex_areas` in R^3, shape (V,).

    The dual area of a corner is ``(p (a + b) - (a - b)^2) / (32 A)``, with the squared lengths p of the
    opposite side and a and b of the adjacent sides.

    Parameters
    ----------
    triangulation : Triangulation
    vertices : ndarray, shape (V, 3)
    grown : ndarray, shape (F,)
        Derivatives of the areas of the triangles.
    rates : ndarray, shape (E,)
        Derivatives of the squared lengths.
    """
    t = triangulation
    squares = edge_lengths(t.edges, vertices) ** 2
    areas = triangle_areas(t.faces, vertices)[:, None]
    p, q = (np.roll(each[t.face_edges], -1, axis=1) for each in (squares, rates))  # across from the corners
    (a, b), (da, db) = _others(p), _others(q)
    numerators = p * (a + b) - (a - b) ** 2
    changes = q * (a + b) + p * (da + db) - 2 * (a - b) * (da - db)
    kites = (changes - numerators * grown[:, None] / areas) / (32 * areas)
    of_duals, of_thirds = _around(t, kites), _around(t, np.repeat(grown[:, None] / 3, 3, axis=1))
    duals, thirds = _duals_and_thirds(t, vertices, EUCLIDEAN)
    low, high = duals < thirds / FARTHEST, duals > thirds * FARTHEST
    return np.where(low, of_thirds / FARTHEST, np.where(high, of_thirds * FARTHEST, of_duals))


def vertex_area_changes(
    triangulation: Triangulation, vertices: Floats, squares: Floats, grown: Floats
) -> Floats:
    """Bounds on the changes of `vertex_areas` in R^3, shape (V,), excluding their rounding.

    Parameters
    ----------
    triangulation : Triangulation
    vertices : ndarray, shape (V, 3)
    squares : ndarray, shape (E,)
        Bounds on the changes of the squared lengths.
    grown : ndarray, shape (F,)
        Bounds on the changes of the areas of the triangles.
    """
    t = triangulation
    areas = triangle_areas(t.faces, vertices)[:, None]
    lengths = edge_lengths(t.edges, vertices)
    p, q = (np.roll(each[t.face_edges], -1, axis=1) for each in (lengths * lengths, squares))
    (a, b), around = _others(p), sum(_others(q))
    changes = q * (a + b) + (p + 2 * np.abs(a - b)) * around + (q + around) * around
    kites = np.abs(p * (a + b) - (a - b) ** 2) / (32 * areas)
    lower = areas - grown[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        changed = (changes / 32 + kites * grown[:, None]) / lower
    of_duals = _around(t, np.where(lower > 0, changed, np.inf))
    of_thirds = _around(t, np.repeat(grown[:, None] / 3, 3, axis=1))
    duals, thirds = _duals_and_thirds(t, vertices, EUCLIDEAN)
    within = duals + of_duals < FARTHEST * (thirds - of_thirds)
    return np.maximum(of_duals, of_thirds * np.where(within, 1 / FARTHEST, FARTHEST))


def _duals_and_thirds(t: Triangulation, vertices: Floats, space: Space) -> tuple[Floats, Floats]:
    """Dual and barycentric areas, shape (V,) each."""
    thirds = _around(t, np.repeat(triangle_areas(t.faces, vertices, space)[:, None] / 3, 3, axis=1))
    lengths = edge_lengths(t.edges, vertices, space)[t.face_edges]
    if not lengths.any():
        return thirds, thirds
    triangles = Triangles.of(lengths, space.curvature)
    with np.errstate(divide="ignore", invalid="ignore"):
        duals = _around(t, triangles.kites * triangles.unit * triangles.unit)
    return np.where(np.isfinite(duals), duals, thirds), thirds


def _others(of_corners: Floats) -> tuple[Floats, Floats]:
    """Values of the other two corners of each triangle."""
    return np.roll(of_corners, -1, axis=1), np.roll(of_corners, 1, axis=1)


def _around(t: Triangulation, shares: Floats) -> Floats:
    """Sums over the corners at each vertex, (V,)."""
    return cast(Floats, np.bincount(t.faces.ravel(), shares.ravel(), minlength=t.n_vertices))
