"""Piecewise smoothness: creases of a surface, and local polynomial fits on either side of them.

A fit to neighbors on both sides of a crease, such as the rim of a lens, would smooth it.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.sparse import csr_array

from isoembed.arrays import Floats, Indices, Mask
from isoembed.mesh.components import components
from isoembed.mesh.triangulation import Triangulation
from isoembed.surface.curvature import FLAT_ANGLE, dihedral_angles
from isoembed.surface.smoothness import fit_residuals

CONTRAST = 6.0
"""Least ratio of the mean bend of sharp edges to that of others; on the ellipsoid (3, 2, 1) it is up to 5."""


def creases(triangulation: Triangulation, vertices: Floats) -> Iterator[Mask]:
    """Yield masks (E,) of creases of a closed surface, edges between its smooth pieces, sharpest first.

    The bends of all edges are split in two classes, and then the smaller ones again, unless that leaves less
    than half of the vertices off creases: then a smooth piece is split from a flat one.  Sharp edges within
    a piece are no creases.

    References
    ----------
    Otsu, A threshold selection method from gray-level histograms, IEEE Trans. Syst. Man Cybern. 9 (1979).
    """
    bends = np.abs(dihedral_angles(triangulation, vertices))
    gentle, least = np.sort(bends), 0.0
    while len(gentle) > 1:
        count, total = np.arange(1, len(gentle)), np.cumsum(gentle)[:-1]
        low, high = total / count, (gentle.sum() - total) / (len(gentle) - count)
        best = int(np.argmax((high - low) ** 2 * count * (len(gentle) - count)))
        if not high[best] > max(CONTRAST * low[best], FLAT_ANGLE):
            return
        gentle = gentle[: best + 1]
        piece = _pieces(triangulation, bends > gentle[-1])
        left, right = piece[triangulation.edge_halfedges // 3].T
        crease = left != right
        off = triangulation.n_vertices - len(np.unique(triangulation.edges[crease]))
        if off < least:
            return
        if crease.any():
            least = off / 2
            yield crease


def piecewise_fit_residuals(
    triangulation: Triangulation, crease: Mask, vertices: Floats, degree: int = 3
) -> csr_array:
    """Matrix of the `fit_residuals` at vertices off the creases of a closed surface, shape (V, V).

    Each is fitted to neighbors in its own piece.  The rows of vertices at creases are zero.  Residuals of
    degree 3 do not resist a cubic bulge of a flat triangle that keeps its sides.
    """
    n = triangulation.n_vertices
    off = np.ones(n, dtype=np.bool_)
    off[triangulation.edges[crease].ravel()] = False
    piece, cut = _pieces(triangulation, crease), _cut_corners(triangulation, crease)
    rows, columns, values = [np.arange(0)], [np.arange(0)], [np.zeros(0)]
    for each in np.unique(piece[off[triangulation.faces].any(axis=1)]):
        own = piece == each
        _, first, faces = np.unique(cut[own], return_index=True, return_inverse=True)
        used = triangulation.faces[own].ravel()[first]
        residuals = fit_residuals(Triangulation(faces.reshape(-1, 3)), vertices[used], degree).tocoo()
        inside = off[used[residuals.row]]
        rows.append(used[residuals.row[inside]])
        columns.append(used[residuals.col[inside]])
        values.append(residuals.data[inside])
    places = np.concatenate(rows), np.concatenate(columns)
    return csr_array((np.concatenate(values), places), shape=(n, n))


def _pieces(triangulation: Triangulation, crease: Mask) -> Indices:
    """Piece of each face, shape (F,)."""
    left, right = (triangulation.edge_halfedges[~crease] // 3).T
    return components(left, right, triangulation.n_faces)


def _cut_corners(triangulation: Triangulation, crease: Mask) -> Indices:
    """Vertices of the surface cut along the creases, shape (F, 3); a piece may meet itself at a vertex."""
    left, right = triangulation.edge_halfedges[~crease].T
    after_left, after_right = (h - h % 3 + (h + 1) % 3 for h in (left, right))
    starts, ends = np.r_[left, after_left], np.r_[after_right, right]
    return components(starts, ends, 3 * triangulation.n_faces).reshape(-1, 3)
