"""Doubly covered polygons: the degenerate polyhedra of Alexandrov's theorem.

On the path to such a polygon the pyramids degenerate and Newton's method does not converge; but the triangles
are already those of the two sheets, and determine the polygon.
"""

from dataclasses import dataclass

import numpy as np

from isoembed.alexandrov.ambient import away_from_apex
from isoembed.alexandrov.lengths import worst_length
from isoembed.alexandrov.polytope import Polytope, delaunay_weights
from isoembed.arrays import Floats, Indices, Mask
from isoembed.intrinsic.delaunay import make_delaunay
from isoembed.intrinsic.delaunay_loops import tilts
from isoembed.intrinsic.halfedges import HalfEdges
from isoembed.intrinsic.loops import flip, set_directions
from isoembed.mesh.components import components
from isoembed.metric.triangles import Triangles
from isoembed.space import Space

THIN = 1e-4  # relative to squared radii: with a lower apex, the body may become flat
FLAT_IN_FLOATS = 1e-13  # error of the lengths of a polygon due to rounding, in mean edge lengths
ROUNDING = 1e-7  # tolerance of the sheets' angles (radians) and of the closing of the polygon (relative)


@dataclass(frozen=True, eq=False)
class DoublyCovered:
    """Doubly covered convex polygon in the plane.

    Attributes
    ----------
    tables : HalfEdges
        Triangles of the two sheets, without multiple edges if there are more than three vertices.
    vertices : ndarray, shape (V, 3)
        Vertices in the plane z = 0.
    error : float
        Largest error of a length of the metric, in mean edge lengths, which is small also for thin bodies.
    """

    tables: HalfEdges
    vertices: Floats
    error: float


def flat_limit(p: Polytope) -> DoublyCovered | None:
    """Determine the polygon from a polytope close to flat; None if there is none."""
    weights, cosine = delaunay_weights(p.space, p.radii)
    feet = cosine * tilts(p.tables.views, weights)[0]
    other = feet[p.tables.twins]
    # Both feet of an apex above a flat edge are on it, up to rounding and the height of a body not yet flat,
    # in edge lengths.
    on_edge = (1e-8 + 30.0 * p.lowest) * p.tables.lengths
    # The relative sum of the feet beside an edge is 1 at a fold and 0 at a flat edge.
    limit = 0.5 * (np.abs(feet) + np.abs(other)) + on_edge
    return doubly_covered(p.tables, feet + other > limit)


def doubly_covered_triangle(core: HalfEdges) -> DoublyCovered | None:
    """Lay out the doubly covered triangle of a metric on three vertices; None if it is lost to rounding."""
    tables = core.copy()
    make_delaunay(tables, np.zeros(3))
    loops = np.flatnonzero(tables.corners == tables.corners[tables.twins])
    if loops.size:  # replaces the side opposite to an obtuse angle
        flip(int(loops[0]), tables.views, 0.0)
    return doubly_covered(tables, np.ones(6, dtype=np.bool_))


def doubly_covered(tables: HalfEdges, folds: Mask) -> DoublyCovered | None:
    """Lay out the polygon with the given boundary; None if these edges bound no doubly covered polygon.

    Parameters
    ----------
    tables : HalfEdges
    folds : ndarray of bool, shape (3F,)
        Half-edges on the boundary of the polygon.
    """
    boundary = _boundary(tables, folds)
    if boundary is None:
        return None
    start = tables.corners[boundary]
    n = start.size
    triangles = Triangles.of(tables.face_lengths, tables.curvature)
    front = _sheet(tables, folds)[np.arange(tables.corners.size) // 3] == 0
    corner, every = tables.corners, triangles.angles.ravel()
    of_front, of_back = (
        np.bincount(corner[sheet], every[sheet], minlength=n)[start] for sheet in (front, ~front)
    )
    if np.abs(of_front - of_back).max() > ROUNDING:
        return None
    exterior = np.pi - (of_front + of_back) / 2
    bend = triangles.space.curvature * triangles.areas.sum() / 2
    if abs(exterior.sum() - (2 * np.pi - bend)) > ROUNDING:
        return None
    points = _laid_out(Space(tables.curvature), tables.lengths[boundary], exterior)
    if points is None:
        return None
    vertices = _in_order(points, start)
    return DoublyCovered(_fans(tables, boundary, points), vertices, worst_length(tables, vertices))


def _laid_out(space: Space, sides: Floats, exterior: Floats) -> Floats | None:
    """Corners of a polygon with these sides and exterior angles, shape (n, 2); None if it does not close."""
    whole = sides.sum()
    if space.is_euclidean:
        heading = np.cumsum(exterior) - exterior[0]
        steps = sides[:, None] * np.stack([np.cos(heading), np.sin(heading)], axis=1)
        if np.abs(steps.sum(axis=0)).max() > ROUNDING * whole:
            return None
        steps -= sides[:, None] * steps.sum(axis=0) / whole  # distributes the rounding error
        return np.concatenate([[[0.0, 0.0]], np.cumsum(steps, axis=0)[:-1]])
    # Columns of a motion are the images of the two axes and of the origin; the last coordinate is a cosine.
    motion, places = np.eye(3), np.empty((sides.size + 1, 3))
    cosines, sines = space.cs(sides), space.sn(sides)
    for i in range(sides.size):
        places[i] = motion[:, 2]
        c, s = cosines[i], sines[i]
        motion = motion @ np.array([[c, 0, s], [0, 1, 0], [-space.curvature * s, 0, c]])
        turn = exterior[(i + 1) % sides.size]
        motion[:, :2] @= np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    places[-1] = motion[:, 2]
    gap = places[-1] - places[0]
    if np.abs(gap[:2]).max() > ROUNDING * whole:
        return None
    places = places[:-1] - (np.cumsum(sides) - sides)[:, None] / whole * gap
    places /= np.sqrt(places[:, 2] ** 2 + space.curvature * (places[:, :2] ** 2).sum(axis=1))[:, None]
    about = np.zeros((sides.size, 3))
    about[:, :2] = 2 * places[:, :2] / (1 + places[:, 2:])
    return away_from_apex(space, about)[:, :2]


def _sheet(tables: HalfEdges, folds: Mask) -> Indices:
    """Sheet of each face, as separated by the folds, shape (F,)."""
    inside = np.flatnonzero(~folds)
    return components(inside // 3, tables.twins[inside] // 3, tables.corners.size // 3)


def _boundary(tables: HalfEdges, folds: Mask) -> Indices | None:
    """Half-edges of the folds on sheet 0 in cyclic order, if they form one cycle through all vertices."""
    n = tables.corners.size // 6 + 2
    sheet = _sheet(tables, folds)
    if not np.array_equal(folds, folds[tables.twins]) or folds.sum() != 2 * n or sheet.max() != 1:
        return None
    half = np.flatnonzero(folds)
    half = half[sheet[half // 3] == 0]
    start, end = tables.corners[half], tables.corners[tables.twins[half]]
    if half.size != n or not np.array_equal(np.sort(start), np.arange(n)):
        return None
    leaving = np.empty(n, dtype=np.int64)
    leaving[start] = np.arange(n)
    order = [0]
    while len(order) < n:
        order.append(int(leaving[end[order[-1]]]))
    around = half[order]
    return around if np.unique(order).size == n else None


def _fans(tables: HalfEdges, boundary: Indices, points: Floats) -> HalfEdges:
    """Triangulate the front from the first vertex and the back from the second, without common diagonals."""
    n = len(points)
    i = np.arange(1, n - 1)
    front = np.stack([np.zeros_like(i), i, i + 1], axis=1)
    back = np.stack([np.ones_like(i), (i + 2) % n, i + 1], axis=1)
    places = np.concatenate([front, back])
    a, b = places.ravel(), np.roll(places, -1, axis=1).ravel()
    order, reverse = np.argsort(a * n + b), np.argsort(b * n + a)
    twins = np.empty(a.size, dtype=np.int64)
    twins[order] = reverse
    space = Space(tables.curvature)
    lengths = np.linalg.norm(points[a] - points[b], axis=1)
    if not space.is_euclidean:
        lengths = space.distances(points[a], points[b])
    corners = tables.corners[boundary][a]
    fans = HalfEdges(corners, twins, lengths, np.zeros(a.size), space.curvature)
    set_directions(fans.views)
    # The half-edges of the boundary keep their directions.
    boundary_sides = np.flatnonzero((b == (a + 1) % n) & (np.arange(a.size) < front.size))
    offset = np.empty(n)
    offset[corners[boundary_sides]] = (
        tables.directions[boundary[a[boundary_sides]]] - fans.directions[boundary_sides]
    )
    return fans._replace(directions=fans.directions + offset[corners])


def _in_order(points: Floats, vertices: Indices) -> Floats:
    placed = np.zeros((len(points), 3))
    placed[vertices, :2] = points
    return placed
