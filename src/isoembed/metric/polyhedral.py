"""Polyhedral metrics: a triangulated surface with edge lengths, and their unit."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from isoembed.arrays import Floats, Indices
from isoembed.errors import InvalidMetric, warn_of_mesh
from isoembed.mesh.checks import index_array, real_array
from isoembed.mesh.triangulation import Triangulation, frozen
from isoembed.metric.distances import lengths_between
from isoembed.metric.given_mesh import merging_advice, triangle_mesh
from isoembed.metric.other_packages import of_pyvista, of_trimesh
from isoembed.metric.precision import Precision, rounding_error
from isoembed.metric.triangle_checks import check_triangles, first_broken, within_inequalities
from isoembed.metric.triangle_metric import TriangleMetric
from isoembed.metric.wrong_length import wrong_length_clause
from isoembed.space import EUCLIDEAN, Space
from isoembed.space.models import Model, from_model

if TYPE_CHECKING:
    from isoembed.metric.glued import GluedMetric

SAME_LENGTH = 1e-12  # relative difference of two values for one edge
ANGLE_ROUNDING = 1e-9  # radians: of deficits, and of sums of angles across edges
NO_EDGES = frozen(np.empty(0, dtype=np.int64))


@dataclass(frozen=True, eq=False, init=False, repr=False)
class PolyhedralMetric(TriangleMetric):
    """A polyhedral metric rho on the sphere (paper, section 2), or on another oriented surface.

    Surfaces with boundary, and of higher genus, are for ``embed(metric, boundary=...)``; everything else is
    about spheres, and refuses others.

    Parameters
    ----------
    faces : array_like of int, shape (F, 3)
        Triangles; those that are not oriented as face 0 is are turned over.
    lengths : array_like of float, shape (E,)
        Edge lengths, in any unit and of any size.
    edges : array_like of int, shape (E, 2), optional
        The ends of the edge that each length belongs to, in any order.  Without it the lengths are in the
        order of `Triangulation.edges`: smaller index first, lexicographic.
    curvature : float, optional
        Of the triangles, in 1/length^2, and of the space that the surface is to be in: zero in the plane and
        R^3, negative in hyperbolic space, positive on the sphere.
    length_errors : float or array_like, shape (E,), optional
        Standard deviations of the lengths, as of `with_length_errors`, in the order of the lengths.

    Attributes
    ----------
    triangulation : Triangulation
    lengths : ndarray, shape (E,)
        In the order of `edges`.
    given_lengths : ndarray, shape (E,)
        The lengths before any change within their errors.
    space : Space
        Euclidean, hyperbolic or spherical, of this curvature.
    precision : Precision or None
        Precision of the coordinates that the lengths come from; None if it is not known, or if they were
        doubles.
    length_errors : ndarray, shape (E,), or None
        Standard deviations of the lengths, whose errors are independent; None if the lengths are exact.
        Lengths that break a triangle inequality are changed within their errors so that they do not.
    diagonals : ndarray of int, shape (D,)
        Edges inside of planar polygons that were cut into triangles: among the realizations that are found,
        one in which these polygons are planar is preferred.

    Raises
    ------
    InvalidMetric
        The faces are not a connected oriented surface, an edge lacks a length, a length is not positive and
        finite, a triangle inequality is broken, or a triangle is too large for its curvature; the message
        names the first offender.

    Warns
    -----
    MeshNote
        Faces are turned over, or lengths are changed within their errors.

    Examples
    --------
    >>> tetrahedron = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]
    >>> PolyhedralMetric(tetrahedron, [1.0] * 6)
    PolyhedralMetric(4 vertices, 6 edges, 4 faces, mean edge length 1)
    """

    triangulation: Triangulation
    lengths: Floats
    given_lengths: Floats
    space: Space
    precision: Precision | None
    length_errors: Floats | None
    diagonals: Indices
    _digits_count: bool

    def __init__(
        self,
        faces: ArrayLike,
        lengths: ArrayLike,
        edges: ArrayLike | None = None,
        *,
        curvature: float = 0.0,
        length_errors: ArrayLike | None = None,
    ) -> None:
        triangulation = Triangulation(faces)
        values = _length_array(lengths)
        errors = None if length_errors is None else np.asarray(length_errors, dtype=np.float64)
        if edges is not None:
            order = _matching(triangulation, values, edges)
            if errors is not None and errors.shape == values.shape:
                errors = errors[order]
            values = values[order]
        used = values if errors is None else _within_errors(triangulation, values, errors)
        self._set(triangulation, used, Space(curvature), given=True)
        if errors is not None:
            self._put(given_lengths=frozen(values), **self._measured(errors))

    @classmethod
    def from_mesh(
        cls,
        vertices: ArrayLike,
        faces: ArrayLike,
        *,
        merge: float | None = None,
        curvature: float = 0.0,
        model: Model = "ambient",
    ) -> PolyhedralMetric:
        """Take the edge lengths of a surface in R^3 (or R^n) and forget its coordinates.

        Parameters
        ----------
        vertices : array_like of float, shape (V, n)
            In hyperbolic and in spherical space three coordinates in the model.
        faces : array_like of int, shape (F, 3), or sequence of polygons in R^3
            The vertices around each face.  Polygons are cut into triangles.
        merge : float, optional
            Vertices that are as near to one another, in mean edge lengths, become the first of them; at 0
            those that are equal.  Faces that then are edges or points, and vertices in no face, are left
            out; the vertices that are left are numbered in their order.  Above 0, a side that only one face
            has is split at vertices as near to it (T-junctions), and triangles without area are left out.
        curvature : float, optional
            Of the space that the vertices are in, and so of the triangles; lengths are its distances.
        model : {"ambient", "conformal", "projective"}
            Which coordinates they are in hyperbolic and in spherical space: those of the hyperboloid or
            sphere, of Poincare's ball, whose radius is 2 / sqrt(-k), or stereographic projection, of Klein's
            ball, of radius 1 / sqrt(-k), or gnomonic projection.

        Raises
        ------
        InvalidMetric
            As the constructor, and where a coordinate is not finite, a vertex is in no face, or a polygon
            has no area.
        InvalidParameter
            There is no such model, or a vertex is not a point of it.

        Warns
        -----
        MeshNote
            Vertices are merged, polygons are not planar, or something is left out.

        Examples
        --------
        A cube of six squares:

        >>> corners = [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
        >>> squares = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
        >>> PolyhedralMetric.from_mesh(corners, squares)
        PolyhedralMetric(8 vertices, 18 edges, 12 faces, mean edge length 1.13807)
        """
        space = Space(curvature)
        given = vertices if space.is_euclidean else _ambient(vertices, space, model)
        points, triangles, diagonals = triangle_mesh(given, faces, merge, space=space)
        try:
            triangulation = Triangulation(triangles)
            if not triangulation.is_closed and merging_advice(points, triangles):
                raise InvalidMetric(triangulation._open_edge)  # a seam whose vertices stand twice
            if len(points) > triangulation.n_vertices:
                raise InvalidMetric(f"vertex {triangulation.n_vertices} is in no face")
            size = np.abs(points).max() or 1.0  # keeps the squares from under- and overflowing
            if not space.is_euclidean:  # a power of two: the curvature is not rounded
                size = float(np.ldexp(1.0, int(np.frexp(size)[1])))
            with np.errstate(over="ignore"):  # a length beyond the floats is refused as infinite
                lengths = size * lengths_between(triangulation, points / size, space.scaled(1 / size))
                metric = cls.on(triangulation, lengths, space).with_diagonals(diagonals)
            if not space.is_euclidean:
                return metric
            return metric._knowing(precision=Precision.of(points, metric.mean_length))
        except InvalidMetric as error:
            advice = merging_advice(points, faces if merge is None else triangles, space)
            raise InvalidMetric(f"{error}{advice}") from None

    @classmethod
    def from_trimesh(cls, mesh: Any, *, merge: float | None = None) -> PolyhedralMetric:
        """Take the edge lengths of a ``trimesh.Trimesh``, or of any object with ``vertices`` and ``faces``.

        Parameters
        ----------
        mesh : trimesh.Trimesh
            A ``curvature`` in its ``metadata`` is that of the space whose conformal coordinates the vertices
            are, as `isoembed.io.to_trimesh` writes it.
        merge : float, optional
            As of `from_mesh`.

        Raises
        ------
        InvalidParameter
            It has no vertices or no faces.
        InvalidMetric
            As `from_mesh`.
        """
        return cls.from_mesh(**of_trimesh(mesh), merge=merge)

    @classmethod
    def from_pyvista(cls, mesh: Any, *, merge: float | None = None) -> PolyhedralMetric:
        """Take the edge lengths of a ``pyvista.PolyData``, or of any object with ``points`` and ``faces``.

        Parameters
        ----------
        mesh : pyvista.PolyData
            Polygons are cut into triangles.  A ``curvature`` in its ``field_data`` is that of the space whose
            conformal coordinates the points are, as `isoembed.io.to_pyvista` writes it.
        merge : float, optional
            As of `from_mesh`: sharp edges of PyVista's own bodies have their points twice.

        Raises
        ------
        InvalidParameter
            It has no points or no faces.
        InvalidMetric
            As `from_mesh`.
        """
        return cls.from_mesh(**of_pyvista(mesh), merge=merge)

    @classmethod
    def on(
        cls, triangulation: Triangulation, lengths: ArrayLike, space: Space = EUCLIDEAN
    ) -> PolyhedralMetric:
        """Put computed lengths, in the order of its edges, on a triangulation that is there already.

        Raises
        ------
        InvalidMetric
            They are not lengths of a metric.
        """
        metric = cls.__new__(cls)
        metric._set(triangulation, _length_array(lengths), space)
        return metric

    def _set(
        self, triangulation: Triangulation, lengths: Floats, space: Space, *, given: bool = False
    ) -> None:
        """Set lengths that were computed, or given by a user who may have rounded or mistyped them."""
        _check_lengths(triangulation, lengths, space, given=given)
        lengths.flags.writeable = False
        self._put(triangulation=triangulation, lengths=lengths, given_lengths=lengths, space=space)
        self._put(precision=None, length_errors=None, diagonals=NO_EDGES, _digits_count=True)

    def _put(self, **values: Any) -> None:
        for name, value in values.items():
            object.__setattr__(self, name, value)

    def with_diagonals(self, pairs: Indices) -> PolyhedralMetric:
        """Return the same metric with the edges that have these ends, (D, 2), as `diagonals`.

        Raises
        ------
        InvalidMetric
            Two vertices are not the ends of an edge, or the table has another shape.
        """
        pairs = np.asarray(pairs)
        if pairs.ndim != 2 or pairs.shape[1] != 2:
            raise InvalidMetric(f"the diagonals have the shape {pairs.shape}, not (D, 2)")
        found = self.triangulation.edge_indices(pairs)
        if (found < 0).any():
            k = int(np.argmax(found < 0))
            raise InvalidMetric(f"diagonal {k} {pairs[k].tolist()} is not an edge")
        return self._knowing(diagonals=frozen(found))

    def rounded_as(self, other: PolyhedralMetric | GluedMetric) -> PolyhedralMetric:
        """Return the metric with the `precision` of another in the same unit, whose surface it is."""
        if other.precision is None:
            return self
        return self._knowing(precision=other.precision.in_means(other.mean_length / self.mean_length))

    def _knowing(self, **properties: Any) -> PolyhedralMetric:
        """Copy with another precision, errors or rounding of the lengths."""
        changed = copy(self)
        changed.__dict__.pop("_normalized", None)
        changed._put(**properties)
        return changed

    @property
    def tables(self) -> tuple[NDArray, ...]:
        """Arrays that define it up to its `unit`: faces, lengths, and in curved space the curvature."""
        normalized = self.normalized
        curved = () if normalized.space.is_euclidean else (np.array(normalized.curvature),)
        measured = () if normalized.length_errors is None else (normalized.length_errors,)
        exact = () if measured or self._digits_count else (np.zeros(1),)
        planar = (self.diagonals,) if len(self.diagonals) else ()
        return self.faces, normalized.lengths, *curved, *measured, *exact, *planar

    def with_lengths(self, lengths: ArrayLike) -> PolyhedralMetric:
        """Return the metric with the same triangles and these lengths, in the order of `edges`.

        Raises
        ------
        InvalidMetric
            They are not lengths of a metric.
        """
        metric = self.__new__(type(self))
        metric._set(self.triangulation, _length_array(lengths), self.space, given=True)
        return metric

    def with_length_errors(self, errors: ArrayLike) -> PolyhedralMetric:
        """Return the metric with standard deviations of its given lengths; errors of zero make it exact.

        Parameters
        ----------
        errors : float or array_like, shape (E,)
            In the unit of the lengths and the order of `edges`: one for all, or one for each edge.

        Raises
        ------
        InvalidMetric
            They are of another shape, negative or not finite, or zero for some edges only; or they do not
            explain a broken triangle inequality of the given lengths.

        Warns
        -----
        MeshNote
            Lengths are changed within their errors, to obey a triangle inequality.
        """
        changed = self._measured(errors)
        sigma = changed["length_errors"]
        if sigma is None:
            return self._knowing(**changed, given_lengths=self.lengths)
        if np.array_equal(self.given_lengths, self.lengths):
            return self._knowing(**changed)
        used = _within_errors(self.triangulation, self.given_lengths, sigma)
        return self.with_lengths(used)._knowing(**self._known(1.0) | changed)

    @property
    def _stated_errors(self) -> dict[str, Floats]:
        """The argument ``length_errors`` of a copy: the errors, 0 if stated to be exact, empty if unknown."""
        if self.length_errors is not None:
            return {"length_errors": self.length_errors}
        return {} if self._digits_count else {"length_errors": np.zeros(())}

    @property
    def exact(self) -> PolyhedralMetric:
        """The same metric with its lengths taken as exact: without `length_errors`."""
        return self if self.length_errors is None else self.with_length_errors(0.0)

    def _measured(self, errors: ArrayLike) -> dict[str, Any]:
        """Standard deviations, checked, as `with_length_errors` sets them."""
        given = np.asarray(errors, dtype=np.float64)
        sigma = np.full(self.lengths.shape, float(given)) if given.ndim == 0 else np.array(given)
        if sigma.shape != self.lengths.shape:
            raise InvalidMetric(f"the length errors have the shape {sigma.shape}, not {self.lengths.shape}")
        exact = not sigma.any()
        wrong = ~np.isfinite(sigma) | (sigma < 0 if exact else sigma <= 0)
        if wrong.any():
            e = int(np.argmax(wrong))
            raise InvalidMetric(
                f"the length error of edge {e} {self.edges[e].tolist()} is {sigma[e]}, not a positive finite "
                "number; length_errors=0 takes the lengths as exact"
            )
        # Errors that are given, be they zero, go before the digits.
        found = None if exact else frozen(sigma)
        return {"length_errors": found, "rounding": None, "_digits_count": False}

    def in_space(self, space: Space) -> PolyhedralMetric:
        """Return the metric with the same triangles and lengths, of the curvature of another space.

        Raises
        ------
        InvalidMetric
            A triangle is too large for it.
        """
        if space == self.space:
            return self
        return self.on(self.triangulation, self.lengths, space)._knowing(**self._known(1.0))

    def scaled(self, factor: float) -> PolyhedralMetric:
        """Return the metric in another unit: every length times this factor."""
        with np.errstate(over="ignore"):  # a length beyond the floats is refused as infinite
            scaled = self.on(self.triangulation, self.lengths * factor, self.space.scaled(factor))
        return scaled._knowing(**self._known(factor))

    def _known(self, factor: float) -> dict[str, Any]:
        """All but triangles and lengths, in another unit, which does not show the digits of the lengths."""
        errors = None if self.length_errors is None else frozen(self.length_errors * factor)
        return {
            "given_lengths": frozen(self.given_lengths * factor),
            "precision": self.precision,
            "length_errors": errors,
            "rounding": self.rounding,
            "diagonals": self.diagonals,
            "_digits_count": self._digits_count,
        }

    @property
    def _turned_over(self) -> PolyhedralMetric:
        """The same metric with the other orientation of its faces; the edges have the same order."""
        turned = Triangulation(self.faces[:, ::-1])
        return self.on(turned, self.lengths, self.space)._knowing(**self._known(1.0))

    def __repr__(self) -> str:
        t = self.triangulation
        return (
            f"PolyhedralMetric({t.n_vertices} vertices, {t.n_edges} edges, {t.n_faces} faces, "
            f"mean edge length {self.mean_length:.6g}"
            f"{'' if self.space.is_euclidean else f', curvature {self.curvature:.6g}'})"
        )

    @property
    def faces(self) -> Indices:
        """(F, 3): the triangles."""
        return self.triangulation.faces

    @property
    def edges(self) -> Indices:
        """(E, 2): the ends of each edge."""
        return self.triangulation.edges

    @cached_property
    def deficits(self) -> Floats:
        """Angle deficits, 2 pi less the sum of the angles at each vertex, pi on a boundary, shape (V,).

        On a boundary they are the exterior angles.  With k the curvature of the triangles, A their area and
        chi the Euler characteristic they sum to 2 pi chi - k A (Gauss-Bonnet).
        """
        t = self.triangulation
        found = 2 * np.pi - cast(Floats, np.bincount(self.faces.ravel(), self.triangles.angles.ravel()))
        if not t.is_closed:  # two boundary edges meet at each vertex there
            found -= np.pi / 2 * np.bincount(t.edges[t.boundary_edges].ravel(), minlength=len(found))
        return frozen(found)

    @cached_property
    def mean_length(self) -> float:
        """Mean edge length: the unit of every residual."""
        largest = self.lengths.max()
        return float(largest * np.mean(self.lengths / largest))

    @cached_property
    def rounding(self) -> float | None:
        """Standard deviation over the mean length of lengths that show that they were rounded, else None."""
        return rounding_error(self.lengths)

    @property
    def point_rounding(self) -> float | None:
        """Standard deviation over the mean length of lengths between rounded points, else None.

        None if errors were given, be they zero.
        """
        if self.precision is None or self.precision.is_of_lengths or not self._digits_count:
            return None
        return self.precision.length_error

    @property
    def length_error(self) -> float | None:
        """Root mean square error of the lengths over their mean, given or by their digits; None if exact."""
        if self.length_errors is None:
            return self.rounding
        return float(np.sqrt(np.mean((self.length_errors / self.mean_length) ** 2)))

    @cached_property
    def face_lengths(self) -> Floats:
        """(F, 3): length of each half-edge."""
        return frozen(self.lengths[self.triangulation.face_edges])


def _length_array(lengths: ArrayLike) -> Floats:
    values = real_array(lengths, "edge", "length")
    if values.ndim != 1:
        raise InvalidMetric(f"the lengths have shape {values.shape}, not (E,)")
    return values


def _matching(triangulation: Triangulation, lengths: Floats, edges: ArrayLike) -> Indices:
    """Find the places of lengths that come with their edges in the triangulation's order."""
    pairs = index_array(edges, 2, "edge", "ends")
    if len(pairs) != len(lengths):
        raise InvalidMetric(f"there are {len(pairs)} edges but {len(lengths)} lengths")
    _check_positive(pairs, lengths)
    index = triangulation.edge_indices(pairs)
    if (index < 0).any():
        k = int(np.argmax(index < 0))
        raise InvalidMetric(f"edge {k} {pairs[k].tolist()} is in no face")
    if len(pairs) == triangulation.n_edges and (np.bincount(index) == 1).all():
        return np.argsort(index)
    order = np.argsort(index, kind="stable")
    present, start = np.unique(index[order], return_index=True)
    if len(present) < triangulation.n_edges:
        e = int(np.setdiff1d(np.arange(triangulation.n_edges), present)[0])
        left, right = triangulation.edge_sides[e]
        f = (left if left >= 0 else right) // 3
        raise InvalidMetric(f"edge {triangulation.edges[e].tolist()} of face {f} has no length")
    matched = lengths[order[start]]
    differs = np.abs(lengths - matched[index]) > SAME_LENGTH * np.abs(matched[index])
    if differs.any():
        k = int(np.argmax(differs))
        first = int(order[start[index[k]]])
        raise InvalidMetric(
            f"edge {k} {pairs[k].tolist()} has length {lengths[k]}, "
            f"but edge {first} is the same edge and has {lengths[first]}"
        )
    return order[start]


def _check_positive(edges: Indices, lengths: Floats) -> None:
    good = np.isfinite(lengths) & (lengths > 0)
    if not good.all():
        e = int(np.argmin(good))
        raise InvalidMetric(
            f"edge {e} {edges[e].tolist()} has length {lengths[e]}, not a positive finite number"
        )


def _check_lengths(triangulation: Triangulation, lengths: Floats, space: Space, *, given: bool) -> None:
    if len(lengths) != triangulation.n_edges:
        raise InvalidMetric(f"there are {triangulation.n_edges} edges but {len(lengths)} lengths")
    _check_positive(triangulation.edges, lengths)
    face_edges, edges = triangulation.face_edges, triangulation.edges

    def name(e: int) -> str:
        return f"edge {e} {edges[e].tolist()}"

    try:
        check_triangles(
            triangulation.faces, face_edges, lengths, space, lambda h: name(int(face_edges.flat[h]))
        )
    except InvalidMetric as error:
        if not given or first_broken(face_edges, lengths, 0.0) < 0:
            raise
        deviation = (rounding_error(lengths) or 0.0) * float(np.mean(lengths))
        errors = np.full(len(lengths), deviation)
        if deviation and within_inequalities(face_edges, lengths, errors) is not lengths:
            raise InvalidMetric(
                f"{error}; rounding explains it: give {deviation:.2g} as the standard deviation of lengths"
            ) from None
        doubt = wrong_length_clause(triangulation.faces, face_edges, lengths, space, name)
        raise InvalidMetric(f"{error}{doubt}") from None


def _within_errors(triangulation: Triangulation, lengths: Floats, errors: Floats) -> Floats:
    """The lengths, changed within their errors where a triangle inequality asks for it, which is said."""
    if len(lengths) != triangulation.n_edges or errors.size not in (1, len(lengths)):
        return lengths
    _check_positive(triangulation.edges, lengths)
    sigma = np.broadcast_to(errors, lengths.shape)
    if not (np.isfinite(sigma) & (sigma > 0)).all():
        return lengths
    found = within_inequalities(triangulation.face_edges, lengths, sigma)
    change = np.abs(found - lengths)
    if change.any():
        e = int(np.argmax(change / sigma))
        warn_of_mesh(
            f"{(change > 0).sum()} lengths are changed within their errors, so that no triangle inequality "
            f"is broken; farthest that of edge {e} {triangulation.edges[e].tolist()}, from {lengths[e]:.9g} "
            f"to {found[e]:.9g}"
        )
    return found


def _ambient(vertices: ArrayLike, space: Space, model: Model) -> Floats:
    """Points of curved space, given in a model."""
    points = real_array(vertices, "vertex", "coordinate")
    if points.ndim != 2 or points.shape[1] != 3:
        raise InvalidMetric(f"the vertices have shape {points.shape}, not (V, 3)")
    return from_model(space, points, model)
