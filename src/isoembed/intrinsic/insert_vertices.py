"""Reinsertion of removed flat vertices; doubly covered triangles get an additional vertex."""

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
    """Triangulation with all vertices, and positions of the flat ones in the triangulation without them.

    Attributes
    ----------
    tables : HalfEdges
        Triangulation with the vertex indices and reference directions from before the removal.
    polygons : Polygons
        Layout of the triangulation.
    kept : ndarray of bool, shape (3F,)
        Half-edges of ``tables`` on the kept edges.
    core, flat : ndarray of int
        Remaining and reinserted vertices, both ascending.
    faces : ndarray of int, shape (n,)
        Face of the triangulation without flat vertices that contains each flat vertex.
    barycentric : ndarray, shape (n, 3)
        Barycentric coordinates in that face, on the hyperboloid or sphere if the faces are curved;
        nonnegative, with sum 1 in the plane.
    corners : ndarray of int, shape (n, 3)
        Corners of that face, in the numbering without flat vertices.
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
        """Positions of all vertices, interpolated from those of the core if its faces are planar triangles.

        Parameters
        ----------
        core : ndarray, shape (V - n, 3)
            Positions in an `isoembed.space.Space`.

        Returns
        -------
        ndarray, shape (V, 3)
        """
        result = np.empty((self.core.size + self.flat.size, core.shape[1]))
        result[self.core] = core
        result[self.flat] = np.einsum("nc,ncd->nd", self.barycentric, core[self.corners])
        return result


def insert_vertices(tables: HalfEdges, removal: Removal, kept: Mask) -> Restored:
    """Reinsert flat vertices, with a constrained Delaunay triangulation between the kept edges.

    Parameters
    ----------
    tables : HalfEdges
        Any triangulation without the flat vertices, with the numbering and reference directions of
        `remove_flat_vertices`.
    removal : Removal
    kept : ndarray of bool, shape (3F,)
        Half-edges on both sides of the edges that must not be flipped, along which the surface is bent.
        Vertices on these edges split them.

    Returns
    -------
    Restored
        Triangulation that is Delaunay except at kept edges and where loops and multiple edges are avoided; a
        convex polyhedron or a doubly covered polygon with all its edges kept has no such edges.  If that
        polygon is a triangle with all flat vertices on its sides, one more vertex is added, the last, in one
        of the sheets: otherwise both sheets would need the same edges.

    Raises
    ------
    InvalidMetric
        A vertex cannot be located, because the triangles differ or are extremely thin.
    """
    r = removal
    number = np.full(r.core.size + r.removed.size, -1, dtype=np.int64)  # in the core
    number[r.core] = np.arange(r.core.size)
    laid = lay_out(tables, kept)
    faces, barycentric, axis, unlocated = locate(tables.views, laid.views, r, number)
    if unlocated >= 0:
        raise InvalidMetric(
            f"vertex {unlocated}, which is flat, is not found again: the triangles around it are too thin"
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
    # The two sheets of a doubly covered polygon have the same corners.
    kept, views = _grown(kept, room), polygons.views
    marks = Marks(views, kept, frames, axes, leaving, sizes, sizes.size == 2)
    insert_all(order, near, faces, places, axis, views, marks)
    sides = seen_sides(views)
    lengths = loosened(distances(sides, polygons.curvature), polygons.twins)
    # A frame gives the direction of a side of the polygon, or of the x axis if the vertex was flat; half a
    # radian absorbs rounding errors to its right.
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
    """Whether the triangulation is a doubly covered triangle."""
    return np.array_equal(np.sort(tables.faces, axis=1), [[0, 1, 2]] * 2)


def _grown(table: Table, by: int) -> Table:
    """Copy with additional entries."""
    return np.concatenate([table, np.zeros(by, dtype=table.dtype)])  # type: ignore[return-value]


def _combined(barycentric: Floats, z: Points, k: float) -> Points:
    """Points (n,) with barycentric coordinates in triangles with corners z (n, 3)."""
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
    """Weighted sums of corners z (n, 3) on hyperboloid or sphere: first two coordinates, and last one."""
    parts = barycentric / (1 + k / 4 * np.abs(z) ** 2)
    return np.einsum("vc,vc->v", parts, z), np.sum(2 * parts - barycentric, axis=1)
