"""Reinsertion of removed flat vertices into a flipped triangulation."""

from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from isoembed.arrays import Floats, Indices, Mask, Points
from isoembed.errors import InvalidMetric
from isoembed.intrinsic.chart import distances
from isoembed.intrinsic.flat_vertices import Removal
from isoembed.intrinsic.halfedges import HalfEdges
from isoembed.intrinsic.insertion_loops import Marks, insert_all, seen_sides
from isoembed.intrinsic.loops import leaving_halfedges
from isoembed.intrinsic.multi_edges import separated
from isoembed.intrinsic.path_loops import locate
from isoembed.intrinsic.polygon_loops import first_sides
from isoembed.intrinsic.polygons import Polygons, lay_out, loosened
from isoembed.mesh.triangulation import frozen

Table = TypeVar("Table", bound=NDArray)


@dataclass(frozen=True, eq=False)
class Restored:
    """A triangulation with all vertices, and where in the faces without the flat ones these lie.

    Attributes
    ----------
    tables : HalfEdges
        Vertices numbered, and directions measured, as before the removal.
    polygons : Polygons
        The same, laid out.
    kept : ndarray of bool, shape (3F,)
        The half-edges of ``tables`` that are parts of the edges that were to be kept.
    core, flat : ndarray of int
        The vertices that had stayed, and those that were put back, both ascending.
    faces : ndarray of int, shape (n,)
        For every flat vertex the face, of those without flat vertices, in which it lies.
    barycentric : ndarray, shape (n, 3)
        And how much of the three corners it is, on hyperboloid or sphere if the faces are curved; not
        negative, sum 1 in the plane.
    corners : ndarray of int, shape (n, 3)
        The three corners, in the numbers of the triangulation without flat vertices.
    """

    tables: HalfEdges
    polygons: Polygons
    kept: Mask
    core: Indices
    flat: Indices
    faces: Indices
    barycentric: Floats
    corners: Indices

    def vertices(self, core: Floats) -> Floats:
        """Positions of all vertices from those of the core, if its faces are flat triangles.

        Parameters
        ----------
        core : ndarray, shape (V - n, 3)
            Of a `isoembed.space.Space`.

        Returns
        -------
        ndarray, shape (V, 3)
        """
        result = np.empty((self.core.size + self.flat.size, core.shape[1]))
        result[self.core] = core
        result[self.flat] = np.einsum("nc,ncd->nd", self.barycentric, core[self.corners])
        return result


def insert_vertices(tables: HalfEdges, removal: Removal, kept: Mask) -> Restored:
    """Put flat vertices back, and make the triangles good between the edges that are to be kept.

    Parameters
    ----------
    tables : HalfEdges
        Any triangulation without them, its vertices numbered and directions measured as by
        `remove_flat_vertices`.
    removal : Removal
    kept : ndarray of bool, shape (3F,)
        The half-edges of both sides of the edges that are not to be flipped: those at which the surface is
        to be bent.  Vertices on them split them.

    Returns
    -------
    Restored
        With triangles that are Delaunay but for the edges kept, and but for what keeps loops and edges with
        the same two ends away: of a convex polyhedron or a polygon covered twice, whose edges are all kept,
        there are none.  If that polygon is a triangle, and all flat vertices are on its sides, then there is
        one vertex more, the last, in one of the sheets: both sheets would need the same edges without it.

    Raises
    ------
    InvalidMetric
        A vertex is not to be found, because these are other triangles or thin beyond measure.
    """
    r = removal
    number = np.full(r.core.size + r.removed.size, -1, dtype=np.int64)  # in the core
    number[r.core] = np.arange(r.core.size)
    laid = lay_out(tables, kept)
    faces, barycentric, axis, lost = locate(tables.views, laid.views, r, number)
    if lost >= 0:
        raise InvalidMetric(
            f"vertex {lost}, which is flat, is not found again: the triangles around it are too thin"
        )
    order, near = r.removed[::-1].copy(), r.anchors[::-1].copy()
    if order.size and _is_triangle(tables):
        depths = barycentric[order].min(axis=1)
        first = int(np.argmax(depths))
        if depths[first] < 1e-9:  # in altitudes of the triangle
            order, near, first = np.append(order, number.size), np.append(near, r.core[0]), order.size
            number, faces, axis = np.append(number, -1), np.append(faces, 0), np.append(axis, 0.0)
            barycentric = np.vstack([barycentric, _middle(laid.z[:3], laid.curvature)])
        order, near = (np.concatenate([[part[first]], np.delete(part, first)]) for part in (order, near))
    places = _combined(barycentric, laid.z[3 * faces[:, None] + np.arange(3)], laid.curvature)
    slopes = np.angle(seen_sides(laid.views))
    room = 6 * order.size
    frames = _grown(first_sides(laid.twins, laid.fixed), room)
    axes, slopes = _grown(tables.directions, room), _grown(slopes, room)
    polygons = Polygons(
        _grown(r.core[laid.corners], room),
        _grown(laid.twins, room),
        _grown(laid.z, room),
        _grown(laid.fixed, room),
        _grown(laid.cells, room // 3),
        laid.curvature,
    )
    leaving = leaving_halfedges(r.core[laid.corners], number.size)
    sizes = np.zeros(laid.cells.max() + 1)
    np.maximum.at(sizes, laid.cells, tables.face_lengths.max(axis=1))
    # The two sheets of a polygon have the same corners.
    kept, views = _grown(kept, room), polygons.views
    marks = Marks(views, kept, frames, axes, leaving, sizes, sizes.size == 2)
    insert_all(order, near, faces, places, axis, views, marks)
    sides = seen_sides(views)
    lengths = loosened(distances(sides, polygons.curvature), polygons.twins)
    # A frame gives the direction of a side of the polygon, or of the x axis if the vertex was flat; half a
    # radian takes up what rounding puts before that.
    turns = (np.angle(sides) - slopes[frames] + 0.5) % (2 * np.pi) - 0.5
    result = HalfEdges(polygons.corners, polygons.twins, lengths, axes[frames] + turns, tables.curvature)
    polygons = separated(result, kept, polygons)
    flat = np.flatnonzero(number < 0)
    return Restored(
        result,
        polygons,
        frozen(kept),
        r.core,
        frozen(flat),
        frozen(faces[flat]),
        frozen(barycentric[flat]),
        frozen(tables.faces[faces[flat]]),
    )


def _is_triangle(tables: HalfEdges) -> bool:
    """Whether it is one, covered twice."""
    return np.array_equal(np.sort(tables.faces, axis=1), [[0, 1, 2]] * 2)


def _grown(table: Table, by: int) -> Table:
    """A copy with room for more."""
    return np.concatenate([table, np.zeros(by, dtype=table.dtype)])  # type: ignore[return-value]


def _combined(barycentric: Floats, z: Points, k: float) -> Points:
    """Points (n,) of triangles with corners z (n, 3)."""
    if k == 0:
        return np.einsum("vc,vc->v", barycentric, z)
    x, w = _summed(barycentric, z, k)
    return 2 * x / (1 + w)


def _middle(z: Points, k: float) -> Floats:
    """Barycentric coordinates of the centroid of corners z (3,)."""
    if k == 0:
        return np.full(3, 1 / 3)
    x, w = _summed(np.ones((1, 3)), z[None], k)
    return np.full(3, 1 / np.sqrt(w[0] ** 2 + k * abs(x[0]) ** 2))


def _summed(barycentric: Floats, z: Points, k: float) -> tuple[Points, Floats]:
    """Sums of corners z (n, 3) on hyperboloid or sphere: their first two coordinates, and the last."""
    parts = barycentric / (1 + k / 4 * np.abs(z) ** 2)
    return np.einsum("vc,vc->v", parts, z), np.sum(2 * parts - barycentric, axis=1)
