"""Proof of convexity for all points near given ones: same convex hull; angles between its polygons.

Faces are merged across possibly flat edges into *cells*. *Near* means within a distance R, the reach, of the
given point with the same index. For every cell, with a unit normal n, it is verified that

- it is a disc of triangles without inner vertices, its vertices are within w of a plane perpendicular to n,
  and seen along n its outline is a convex polygon: its ears (a corner and its two neighbors) and the
  triangles of a fan from one corner turn left;
- its *width* h, the least altitude of an ear minus 2 (w + R), is positive.

Seen along n, the near points of the cell are then also corners of a convex polygon: no ear degenerates during
the motion. A corner's distance to a chord of others is at least that to the line of its neighbors, so
every triangle of three of them has altitudes of at least h, and its plane is tilted against n by an angle
of tangent at most ``t = 2 (w + R) / h``, the *slope*. The *roof* of the cell is the upper side, along n, of
the convex hull of these points: a concave graph over the polygon. Let S be the union of the roofs. It is
verified that

- between cells, S is convex across all edges: ``(n x n') . d > t + t' + 4 R / |edge|``, d along the edge;
- all triangles of S face away from a point o: ``n . (x - o) > R + t (|x - o| + R)`` at their corners x;
- a ray from o meets exactly one of the given triangles.

By the last two, S is a sphere around o that meets every ray from o once: seen from o, it covers each
direction a positive number of times, which equals the degree of the map and is invariant under motions of
the points, and of a roof to the triangles of its cell. A plane through o and no vertex then cuts S in a
simple closed polygon whose angles are at most pi, as S is convex across its edges: in a convex polygon. Any
two points inside S are limits of points in such planes, so S bounds a convex body.

If ``altitude > 4 t^2 longest side`` in every ear, the corner angles of the roofs, within a factor (1 +
t^2)^(1/2) of those of the polygons, are less than pi. A roof, unfolded into the plane, is then a convex
polygon, and its diagonals have lengths L with ``|y_a - y_b| <= L <= (1 + t^2)^(1/2) |y_a - y_b|``: they are
straight when unfolded, so no longer than the path on the roof over the straight line from a to b.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats, Mask
from isoembed.mesh.triangulation import Triangulation
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.proof.length_equations import NotProven
from isoembed.proof.polygonal_cells import Cells
from isoembed.proof.rounding import GUARD, UNDERFLOW, U
from isoembed.surface.flat_faces import FlatFaces
from isoembed.surface.measures import face_normals

# Rounding error of a triple product of differences, relative to the product of their norms: each term takes
# some twenty roundings, and the sum of the six magnitudes is at most twice that product.
TRIPLE = 64 * U


@dataclass(frozen=True, eq=False)
class NearbyHulls:
    """Common properties of all hulls of near points.

    Attributes
    ----------
    dihedrals : ndarray, shape (E,)
        Lower bounds on the sines of the exterior dihedral angles of the edges between cells; infinite at
        other edges.
    flat : ndarray of bool, shape (E,)
        Edges within cells, which the hull may replace by others.
    slopes : ndarray, shape (E,)
        Upper bounds on the tangent of the tilt of the faces left of each edge against their cell's normal.
    """

    dihedrals: Floats
    flat: Mask
    slopes: Floats


def prove_nearby_hulls(triangulation: Triangulation, vertices: Floats, reach: float) -> NearbyHulls:
    """Prove that all points within reach of the vertices span convex polyhedra with the same cells as faces.

    Parameters
    ----------
    triangulation : Triangulation
        Oriented with outward normals.
    vertices : ndarray, shape (V, 3)
        In a unit comparable to the edge lengths, with distinct ends of each edge.
    reach : float
        Distance R.

    Raises
    ------
    NotProven
        The points do not, or not with sufficient margin for rounding errors.
    """
    t = triangulation
    flat = np.zeros(t.n_edges, dtype=np.bool_)
    while True:
        cells = Cells.across(t, flat)
        _check_discs(t, cells)
        roofs = _Roofs.over(t, cells, vertices, reach)
        _check_edges(t, roofs)
        _check_polygons(t, cells, roofs, vertices)
        more = ~flat & (roofs.sines <= roofs.errors)
        if not more.any():
            break
        flat |= more
        _check_vertices(t, flat)
    center = vertices.mean(axis=0)
    _check_center(t, cells, roofs, vertices, reach, center)
    _check_ray(t, vertices - center)
    dihedrals = np.where(flat, np.inf, (roofs.sines - roofs.errors) / GUARD)
    return NearbyHulls(dihedrals, flat, roofs.slopes[cells.labels[t.edge_faces[:, 0]]])


def folds_of_polygons(metric: PolyhedralMetric, vertices: Floats) -> Mask:
    """Edges between polygons that are flat up to rounding, shape (E,): the others are diagonals of these.

    Rounding bends diagonals by amounts of its own, which no bound on the angles of a body is about.
    """
    t, precision = metric.triangulation, metric.precision
    error = 0.0 if precision is None else precision.vertex_error * metric.mean_length
    return FlatFaces.of(t, vertices, metric.space, error, np.zeros(t.n_vertices, dtype=np.bool_)).edges


@dataclass(frozen=True, eq=False)
class _Roofs:
    """Measurements of the roofs over near points.

    Normals (C, 3) and slopes (C,) of the cells; least altitude and longest side of the ears (H,); sines of
    the dihedral angles between cells at the given points (E,), and bounds on their changes nearby (E,).
    """

    normals: Floats
    slopes: Floats
    widths: Floats
    longest: Floats
    sines: Floats
    errors: Floats

    @classmethod
    def over(cls, t: Triangulation, cells: Cells, vertices: Floats, reach: float) -> _Roofs:
        sums = np.column_stack([np.bincount(cells.labels, n) for n in face_normals(t.faces, vertices).T])
        norms = np.linalg.norm(sums, axis=1, keepdims=True)
        normals = sums / np.where(norms > 0, norms, 1.0)

        base = vertices[t.faces[cells.first, 0]]
        d = vertices[t.faces] - base[cells.labels][:, None]
        heights = np.abs(np.einsum("fci,fi->fc", d, normals[cells.labels]))
        heights += TRIPLE * np.linalg.norm(d, axis=2)
        off = np.full(len(base), reach)  # w + R
        np.maximum.at(off, cells.labels, GUARD * (heights.max(axis=1) + reach))

        before, after = vertices[cells.end] - vertices[cells.start], vertices[cells.far] - vertices[cells.end]
        across = vertices[cells.far] - vertices[cells.start]
        sides = np.stack([np.linalg.norm(side, axis=1) for side in (before, after, across)])
        longest = GUARD * sides.max(axis=0)
        doubled = np.linalg.norm(np.cross(before, after), axis=1) - TRIPLE * sides[0] * sides[1]
        widths = doubled / (GUARD * longest) - 2 * GUARD * off[cells.cell]
        narrowest = np.full(len(base), np.inf)
        np.minimum.at(narrowest, cells.cell, widths)
        slopes = np.full(len(base), np.inf)
        np.divide(2 * GUARD**2 * off, narrowest, out=slopes, where=narrowest > 0)

        left, right = cells.labels[t.edge_faces].T
        a, b = t.edges.T
        along = vertices[b] - vertices[a]
        length = np.linalg.norm(along, axis=1)
        sines = np.einsum("ei,ei->e", np.cross(normals[left], normals[right]), along) / length
        errors = GUARD * (slopes[left] + slopes[right] + 4 * reach / length + TRIPLE)
        return cls(normals, slopes, widths, longest, sines, errors)


def _check_edges(t: Triangulation, roofs: _Roofs) -> None:
    # A diagonal with a smaller concave angle may cross a polygon bent inward by rounding, which is then tried
    # as a cell.  This only bounds the search; the proof covers any dent.
    concave = roofs.sines < -roofs.errors - 1e-4
    if concave.any():
        e = int(np.argmax(concave))
        raise NotProven(
            f"edge {e} {t.edges[e].tolist()} is concave: its exterior angle has the sine "
            f"{roofs.sines[e]:.1e} +- {roofs.errors[e]:.1e}"
        )


def _check_vertices(t: Triangulation, flat: Mask) -> None:
    inner = np.bincount(t.edges[flat].ravel(), minlength=t.n_vertices) == t.degrees
    if inner.any():
        raise NotProven(f"vertex {int(np.argmax(inner))} may be flat: so may all its edges")


def _check_discs(t: Triangulation, cells: Cells) -> None:
    if not cells.polygonal.all():
        f = cells.first[np.argmin(cells.polygonal)]
        raise NotProven(
            f"the faces that may be in one plane with face {f} {t.faces[f].tolist()} do not form a polygon"
        )


def _check_polygons(t: Triangulation, cells: Cells, roofs: _Roofs, vertices: Floats) -> None:
    """Check that polygons of several faces are convex, and wide enough for roofs with angles below pi."""
    slope = roofs.slopes[cells.cell]
    several = cells.sizes[cells.cell] > 1
    narrow = several & ~(roofs.widths > 4 * GUARD * slope * slope * roofs.longest)
    if narrow.any():
        k = int(np.argmax(narrow))
        raise NotProven(
            f"vertex {cells.end[k]} may be on a line with {cells.start[k]} and {cells.far[k]}, "
            f"its neighbors in the polygon of face {cells.first[cells.cell[k]]}"
        )
    _, leading, of_halfedge = np.unique(cells.cell, return_index=True, return_inverse=True)
    p, q = cells.start[leading][of_halfedge], cells.end[leading][of_halfedge]  # a side of the same cell
    a, b, c = cells.start, cells.end, cells.far
    normals = roofs.normals[cells.cell]
    for corners, tested in (
        ((a, b, c), several),
        ((p, a, b), several & (a != p) & (b != p)),
        ((p, q, a), several & (a != p) & (a != q)),
    ):
        x, y, z = (vertices[corner[tested]] for corner in corners)
        value, error = _triple(y - x, z - x, normals[tested])
        wrong = ~(value > error)
        if wrong.any():
            f = cells.first[cells.cell[tested][np.argmax(wrong)]]
            raise NotProven(f"the polygon of face {f} {t.faces[f].tolist()} may not be convex")


def _check_center(
    t: Triangulation, cells: Cells, roofs: _Roofs, vertices: Floats, reach: float, center: Floats
) -> None:
    d = vertices[t.faces] - center
    distance = GUARD * np.linalg.norm(d, axis=2)
    heights = np.einsum("fci,fi->fc", d, roofs.normals[cells.labels]) - TRIPLE * distance
    above = heights > GUARD * (reach + roofs.slopes[cells.labels][:, None] * (distance + reach))
    if not above.all():
        f = int(np.argmin(above.all(axis=1)))
        raise NotProven(f"face {f} {t.faces[f].tolist()} may not be visible from the mean of the vertices")


def _check_ray(t: Triangulation, vertices: Floats) -> None:
    """Check that the ray from the origin through the centroid of the largest face meets no other face."""
    largest = int(np.argmax(np.linalg.norm(face_normals(t.faces, vertices), axis=1)))
    ray = vertices[t.faces[largest]].mean(axis=0)
    outside = np.zeros(t.n_faces, dtype=np.bool_)
    for c in range(3):
        a, b = vertices[t.faces[:, c]], vertices[t.faces[:, (c + 1) % 3]]
        value, error = _triple(a, b, np.broadcast_to(ray, a.shape))
        outside |= value < -error
    outside[largest] = True
    if not outside.all():
        f = int(np.argmin(outside))
        raise NotProven(f"face {f} {t.faces[f].tolist()} may lie before or behind face {largest}")


def _triple(a: Floats, b: Floats, c: Floats) -> tuple[Floats, Floats]:
    """Row-wise ``(a x b) . c`` of differences of floats, and a bound on its rounding error."""
    value = np.einsum("ij,ij->i", np.cross(a, b), c)
    sizes = np.prod([np.linalg.norm(vectors, axis=1) for vectors in (a, b, c)], axis=0)
    return value, TRIPLE * sizes + UNDERFLOW
