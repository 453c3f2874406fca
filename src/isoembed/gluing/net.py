"""Polygons with identified sides, and their polyhedral metric; advice if glued sides differ in length."""

import warnings
from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from isoembed.arrays import Floats, Indices, Mask
from isoembed.errors import InvalidMetric, InvalidParameter, MeshNote, warn_of_mesh
from isoembed.gluing.correction import Correction, corrected
from isoembed.gluing.named_corners import check_together, faced_alike, read_names, sides_of
from isoembed.gluing.outline_points import cut_outlines, glued_points
from isoembed.gluing.polygon import Polygon, distances, shape_of, side_lengths
from isoembed.gluing.runs import Run, read_sides
from isoembed.gluing.tolerance import SAME_LENGTH, Tolerance, UnequalLengths
from isoembed.intrinsic.ears import triangulated, twins_inside
from isoembed.mesh.triangulation import frozen
from isoembed.metric.glued import GluedMetric
from isoembed.metric.precision import Precision
from isoembed.reprs import rounded_up
from isoembed.space import Space
from isoembed.space.models import MODELS, Model


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Net(GluedMetric):
    """A metric glued from planar polygons, stored with the polygons; created by `glue`.

    On a solid with this metric, corner k of polygon p is ``vertices[corners[p][k]]``, and the outline of the
    polygon passes through ``vertices[outlines[p]]`` along its `seams`.

    Attributes
    ----------
    polygons : tuple of ndarray, shape (m, 2)
        Outline of each polygon, counterclockwise: its corners and the points to which corners of others are
        glued; in ambient coordinates on the sphere and in the hyperbolic plane.
    outlines : tuple of ndarray of int64, shape (m,)
        Vertex of each outline point.
    corners : tuple of ndarray of int64, shape (n,)
        Vertex of each corner, in the given order of the corners.
    face_polygons : ndarray of int64, shape (F,)
        Polygon that contains each face.
    places : ndarray, shape (F, 3, 2)
        Positions of the corners of each face in the plane of its polygon.
    seams : ndarray of bool, shape (3F,)
        Half-edges on an outline, as for every `GluedMetric`.
    correction : Correction or None
        Displacement of the corners that made unequal sides equal, already applied to the polygons.
    folded : ndarray, shape (V, 3), or None
        Vertices positioned by the fold angles of the file, if given.
    """

    polygons: tuple[Floats, ...]
    outlines: tuple[Indices, ...]
    corners: tuple[Indices, ...]
    face_polygons: Indices
    places: Floats
    correction: Correction | None
    folded: Floats | None

    def __init__(
        self,
        sheets: Sequence[Polygon],
        runs: Sequence[tuple[Run, Run]],
        correction: Correction | None = None,
        precision: Precision | None = None,
        any_surface: bool = False,
    ) -> None:
        stops, mates = cut_outlines(sheets, runs, Tolerance.exact(len(sheets)))
        space = sheets[0].space
        polygons = tuple(frozen(sheet.points(some)) for sheet, some in zip(sheets, stops, strict=True))
        first = np.cumsum([0, *map(len, stops)])  # offsets of the outlines among all points
        corners = [
            start + np.searchsorted(some, np.arange(sheet.n) * (-1 if sheet.turned else 1) % sheet.n)
            for start, some, sheet in zip(first, stops, sheets, strict=False)
        ]
        vertices = glued_points(first, mates, np.concatenate(corners), any_surface)
        triangles, owners = _triangles(polygons, first, space)
        twins, seams = _sewn(triangles, mates)
        points = np.concatenate(polygons)
        steps = np.concatenate([side_lengths(polygon, space) for polygon in polygons])
        lengths = distances(points[triangles], points[np.roll(triangles, -1, axis=1)], space).ravel()
        rim = triangles.ravel()[seams]
        lengths[seams] = (steps[rim] + steps[mates[rim]]) / 2
        if any_surface:
            self._set_any_surface(vertices[triangles], twins, lengths.reshape(-1, 3), space)
        else:
            super().__init__(vertices[triangles], twins, lengths.reshape(-1, 3), curvature=space.curvature)
        for name, value in (
            ("polygons", polygons),
            ("outlines", tuple(map(frozen, np.split(vertices, first[1:-1])))),
            ("corners", tuple(frozen(vertices[some]) for some in corners)),
            ("face_polygons", frozen(owners)),
            ("places", frozen(points[triangles])),
            ("seams", frozen(seams)),
            ("correction", correction),
            ("precision", None if precision is None else precision.in_means(1 / self.mean_length)),
            ("folded", None),
        ):
            object.__setattr__(self, name, value)

    def knowing(self, *, precision: Precision | None = None, folded: Floats | None = None) -> "Net":
        """Copy with given folded vertices and precision (error of a length in the unit of the sheets)."""
        changed = copy(self)
        changed.__dict__.pop("_normalized", None)
        if precision is not None:
            object.__setattr__(changed, "precision", precision.in_means(1 / self.mean_length))
        if folded is not None:
            object.__setattr__(changed, "folded", frozen(folded))
        return changed


def glue(
    polygons: Sequence[ArrayLike],
    sides: Sequence[Any] | None = None,
    *,
    corners: Sequence[Sequence[str | int]] | None = None,
    tolerance: float | None = None,
    curvature: float = 0.0,
    model: Model = "ambient",
    any_surface: bool = False,
) -> Net:
    """Glue polygons along their sides to a polyhedral metric on the sphere: a paper net.

    The polygons lie on a table, face up; side k of a polygon runs from its corner k to the next.  An
    identification is a pair of sides ``((p, k), (q, m))`` or of runs ``((p, a, b), (q, c, d))``: the boundary
    of polygon p from position a to position b, counted in corners, so that 2.5 is the midpoint of side 2.  A
    run continues past the last corner if b <= a, and all around if b == a.  The two are glued like paper,
    without turning it over: for counterclockwise polygons the start of each run meets the end of the other,
    a = d and b = c.  A run or a side glued to itself is folded at its midpoint.  A point inside a side that
    is glued to a corner becomes a vertex.

    Parameters
    ----------
    polygons : sequence of array_like, shape (n, 2)
        Corners of each polygon, in either orientation.  Polygons must be simple but not necessarily convex;
        consecutive sides may be collinear, and the position in the plane is irrelevant.
    sides : sequence of pairs
        Identifications that cover every boundary exactly once, or at most once if `any_surface` is true.
    corners : sequence of sequence of str or int
        Alternative to `sides`: names of the corners of each polygon.  Sides whose endpoints have the same two
        names are glued, as in a list of the faces of a polyhedron.  Polygons are reversed as needed for
        opposite directions of glued sides.
    tolerance : float, optional
        Largest difference of glued lengths, in the unit of the polygons, which must be planar.  By default
        the difference explained by the digits of the corners, if these have 4 to 11 digits, and otherwise
        1e-9 of the length.  A least-squares displacement of the corners makes glued lengths equal
        (`Net.correction`), and vertices whose total angle is then 2 pi within the errors become flat.
    curvature : float, optional
        Curvature in 1/length^2 of the metric, and of the hyperbolic plane (negative) or sphere (positive)
        from which the polygons are cut.
    model : {"ambient", "conformal", "projective"}
        Coordinates of the corners there: hyperboloid or sphere, Poincare disk or stereographic projection,
        Klein disk or gnomonic projection.  On the sphere each polygon must lie in the open hemisphere about
        the origin of the coordinates.
    any_surface : bool, optional
        Whether the surface may have a boundary, consisting of the unglued sides, and handles.  Such metrics
        are embedded with a boundary condition; see `isoembed.embed`.

    Returns
    -------
    Net
        The metric.  Its vertices are first those of the corners, in the order of the polygons, then those
        that other corners and folds create inside sides.

    Raises
    ------
    InvalidMetric
        A polygon is not simple, two runs differ in length by more than the tolerance, part of a boundary is
        glued twice or not at all, or the result is not a single sphere, or not connected.
    InvalidParameter
        An identification does not have this form, both or neither of sides and corners are given, the
        tolerance is not a nonnegative length, or the curvature or model is invalid.

    Warns
    -----
    MeshNote
        The corners are moved by more than rounding errors.

    Examples
    --------
    A square with each side folded at its midpoint is a doubly covered square of half its area:

    >>> envelope = glue([[[0, 0], [1, 0], [1, 1], [0, 1]]], [((0, k), (0, k)) for k in range(4)])
    >>> envelope.corners[0].tolist(), envelope.n_vertices
    ([0, 0, 0, 0], 5)

    A tetrahedron from the corner names of four triangles:

    >>> from isoembed.gluing import regular_polygon
    >>> glue([regular_polygon(3)] * 4, corners=["abc", "abd", "acd", "bcd"]).n_vertices
    4

    An octagon in the hyperbolic plane, with sides folded together in pairs:

    >>> octagon = regular_polygon(8, 1.0, curvature=-1.0)
    >>> glue([octagon], [((0, k), (0, k + 1)) for k in range(0, 8, 2)], curvature=-1.0)
    Net(5 vertices, 9 edges, 6 faces, mean edge length 1.45222, curvature -1)
    """
    space = Space(curvature)
    if model not in MODELS:
        raise InvalidParameter(f"the model is {model!r}, none of {', '.join(MODELS)}")
    if not isinstance(polygons, list | tuple | np.ndarray):
        raise InvalidParameter(f"the polygons are {polygons!r}, not a list of polygons")
    if len(polygons) == 0:
        raise InvalidMetric("there are no polygons")
    sheets = [Polygon.of(polygon, p, space, model) for p, polygon in enumerate(polygons)]
    if (sides is None) == (corners is None):
        raise InvalidParameter("give either the glued sides or the names of the corners")
    try:
        return _glued(sheets, sides, corners, Tolerance.of(sheets, tolerance), any_surface)
    except UnequalLengths as error:
        remedy = _remedy(sheets, sides, corners, error.difference, any_surface)
        raise InvalidMetric(f"{error}{remedy}") from None


def glue_rounded(
    polygons: Sequence[ArrayLike],
    sides: Sequence[Any],
    precision: Precision | None,
    tolerance: float | None = None,
    any_surface: bool = False,
) -> Net:
    """Glue the sheets of a solid whose coordinates have a given precision (error of a length in their unit).

    The faces are flat, and glued sides equal, only up to this precision.
    """
    if precision is not None and tolerance is None:
        sheets = [Polygon.of(polygon, p, Space(0.0), "ambient") for p, polygon in enumerate(polygons)]
        try:
            net = _glued(sheets, sides, None, Tolerance.of(sheets), any_surface)
        except UnequalLengths:
            allowed = Tolerance.of(sheets, precision.vertex_error)
            with warnings.catch_warnings():  # the precision explains the correction
                warnings.simplefilter("ignore", MeshNote)
                net = _glued(sheets, sides, None, allowed, any_surface)
        return net.knowing(precision=precision)
    net = glue(polygons, sides, tolerance=tolerance, any_surface=any_surface)
    return net.knowing(precision=precision)


def _remedy(sheets: Sequence[Polygon], sides: Any, corners: Any, difference: float, any_surface: bool) -> str:
    """Suggestion of a tolerance that permits the given difference of sides, if it helps."""
    word = rounded_up(difference)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MeshNote)
        try:
            net = _glued(sheets, sides, corners, Tolerance.of(sheets, float(word)), any_surface)
        except InvalidMetric:
            return "; correct them"
    moved = 0.0 if net.correction is None else net.correction.largest
    return f"; correct them, or allow it: tolerance={word} moves corners by {moved:.1g}"


def _glued(
    sheets: Sequence[Polygon],
    sides: Sequence[Any] | None,
    corners: Any,
    allowed: Tolerance,
    any_surface: bool,
) -> Net:
    if sides is not None:
        return _net(sheets, sides, allowed, any_surface)
    names = read_names(corners, sheets)
    pairs = sides_of(names, sheets, allowed, any_surface)
    sheets = faced_alike(names, sheets, pairs)
    net = _net(sheets, pairs, allowed, any_surface)
    check_together(names, net.corners)
    return net


def _net(sheets: Sequence[Polygon], sides: Sequence[Any], tolerance: Tolerance, any_surface: bool) -> Net:
    """Net of the corrected sheets; warns of corrections above rounding."""
    runs = read_sides(sides, sheets, tolerance, any_surface)
    changed, correction = corrected(sheets, runs, tolerance, any_surface)
    if correction is None:
        return Net(sheets, runs, any_surface=any_surface)
    if correction.largest > SAME_LENGTH * max(sheet.perimeter for sheet in sheets):
        warn_of_mesh(str(correction))
    exact = read_sides(sides, changed, Tolerance.exact(len(changed)), any_surface)
    return Net(changed, exact, correction, tolerance.precision(correction.difference), any_surface)


def _triangles(polygons: Sequence[Floats], first: Indices, space: Space) -> tuple[Indices, Indices]:
    """Triangulation of all outlines, shape (F, 3), and the polygon of each triangle."""
    triangles = []
    for p, polygon in enumerate(polygons):
        inside = triangulated(shape_of(polygon, space))
        if inside is None:
            raise InvalidMetric(f"polygon {p} is too thin to be triangulated in floating point")
        triangles.append(first[p] + inside)
    return np.concatenate(triangles), np.repeat(np.arange(len(polygons)), [len(some) for some in triangles])


def _sewn(triangles: Indices, mates: Indices) -> tuple[Indices, Mask]:
    """Twin of each half-edge, and mask of half-edges on outlines."""
    twins, start = twins_inside(triangles), triangles.ravel()
    seams = twins < 0
    halfedges = np.empty(len(mates), dtype=np.int64)
    halfedges[start[seams]] = np.flatnonzero(seams)
    twins[seams] = halfedges[mates[start[seams]]]
    return twins, seams
