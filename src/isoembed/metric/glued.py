"""Polyhedral metrics glued from triangles along sides, not restricted to simplicial complexes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from isoembed.arrays import Floats, Indices, Mask
from isoembed.errors import InvalidMetric
from isoembed.intrinsic.halfedges import HalfEdges
from isoembed.mesh.checks import check_euler, check_numbering, index_array
from isoembed.mesh.loops import pinched, reached_faces
from isoembed.mesh.triangulation import frozen
from isoembed.metric.polyhedral import SAME_LENGTH, PolyhedralMetric
from isoembed.metric.precision import Precision
from isoembed.metric.simplicial import simplicial
from isoembed.metric.triangle_checks import check_triangles
from isoembed.metric.triangle_metric import TriangleMetric
from isoembed.space import Space


@dataclass(frozen=True, eq=False, init=False, repr=False)
class GluedMetric(TriangleMetric):
    """Polyhedral metric on the sphere: triangles and the pairs of sides along which they are glued.

    Half-edge ``h = 3 f + c`` is the side of face f from its corner c to the next.  Loops, multiple edges,
    triangles glued to themselves and the doubly covered triangle are allowed, as long as the result is a
    sphere.

    Parameters
    ----------
    faces : array_like of int, shape (F, 3)
        Vertex at each corner, counterclockwise; vertices are numbered from 0 without gaps.
    twins : array_like of int, shape (3F,)
        Half-edge to which each half-edge is glued, in opposite direction.
    face_lengths : array_like of float, shape (F, 3)
        Length of each half-edge, in any unit.
    curvature : float, optional
        Curvature of the triangles and of the ambient space, in 1/length^2, as in `isoembed.PolyhedralMetric`.

    Attributes
    ----------
    faces : ndarray of int64, shape (F, 3)
    twins : ndarray of int64, shape (3F,)
    face_lengths : ndarray, shape (F, 3)
        Equal on glued sides.
    space : Space
        Euclidean, hyperbolic or spherical space of this curvature.
    seams : ndarray of bool, shape (3F,)
        Half-edges along which sheets of paper were glued: none, unless the metric comes from an
        `isoembed.gluing.Net`.
    precision : Precision or None
        Precision of the coordinates from which the lengths were computed, if known.

    Raises
    ------
    InvalidMetric
        A side is glued to none, to itself or to two; glued sides have different ends or lengths; a length is
        not positive and finite, or too long for triangles of this curvature; a triangle inequality is
        violated; or the result is not a single sphere.  The message names the first offender.

    Examples
    --------
    A triangle with two of its sides glued to each other, and another that closes the loop:

    >>> GluedMetric([[0, 0, 1], [0, 0, 2]], [3, 2, 1, 0, 5, 4], [[1.0] * 3] * 2)
    GluedMetric(3 vertices, 3 edges, 2 faces, mean edge length 1)
    """

    faces: Indices
    twins: Indices
    face_lengths: Floats
    space: Space
    seams: Mask
    precision: Precision | None

    def __init__(
        self, faces: ArrayLike, twins: ArrayLike, face_lengths: ArrayLike, *, curvature: float = 0.0
    ) -> None:
        space = Space(curvature)
        corners = index_array(faces, 3, "face", "corners").copy()
        sides = _twin_array(twins, corners.size)
        lengths = _length_table(face_lengths, len(corners))
        check_numbering(corners)
        _check_ends(corners, sides)
        _check_triangles(corners, lengths, space)
        lengths = _matched(sides, lengths)
        _check_sphere(corners, sides)
        self._set(corners, sides, lengths, space)

    @classmethod
    def of(cls, metric: PolyhedralMetric | GluedMetric) -> GluedMetric:
        """Convert a polyhedral metric to a glued one; a glued metric is returned unchanged.

        Parameters
        ----------
        metric : PolyhedralMetric or GluedMetric

        Raises
        ------
        InvalidMetric
            The metric is not on a sphere.
        """
        if isinstance(metric, GluedMetric):
            metric.check_sphere()
            return metric
        metric.triangulation.check_sphere()
        twins = metric.triangulation.twins
        return cls._create(metric.faces, twins, metric.face_lengths, metric.space, precision=metric.precision)

    @classmethod
    def _create(
        cls,
        faces: Indices,
        twins: Indices,
        face_lengths: Floats,
        space: Space,
        seams: Mask | None = None,
        precision: Precision | None = None,
    ) -> GluedMetric:
        """Create a metric from valid tables, without checks."""
        metric = cls.__new__(cls)
        metric._set(faces, twins, face_lengths, space, seams, precision)
        return metric

    def _set_any_surface(self, faces: Indices, twins: Indices, face_lengths: Floats, space: Space) -> None:
        """Set the triangles of any manifold; half-edges on its boundary are their own twins."""
        _check_triangles(faces, face_lengths, space)
        self._set(faces, twins, _matched(twins, face_lengths), space)

    def _with(self, face_lengths: Floats, space: Space) -> GluedMetric:
        return GluedMetric._create(self.faces, self.twins, face_lengths, space, self.seams, self.precision)

    def _set(
        self,
        faces: Indices,
        twins: Indices,
        face_lengths: Floats,
        space: Space,
        seams: Mask | None = None,
        precision: Precision | None = None,
    ) -> None:
        nowhere = np.zeros(faces.size, dtype=np.bool_)
        object.__setattr__(self, "faces", frozen(faces))
        object.__setattr__(self, "twins", frozen(twins))
        object.__setattr__(self, "face_lengths", frozen(face_lengths))
        object.__setattr__(self, "space", space)
        object.__setattr__(self, "seams", frozen(nowhere if seams is None else seams))
        object.__setattr__(self, "precision", precision)

    def __repr__(self) -> str:
        return (
            f"{type(self).__name__}({self.n_vertices} vertices, {self.n_edges} edges, {self.n_faces} faces, "
            f"mean edge length {self.mean_length:.6g}"
            f"{'' if self.space.is_euclidean else f', curvature {self.curvature:.6g}'})"
        )

    @property
    def n_vertices(self) -> int:
        """Number of vertices, V = F / 2 + 2 on the sphere."""
        return int(self.faces.max()) + 1

    @property
    def n_edges(self) -> int:
        """Number of edges, E = 3 V - 6 on the sphere."""
        return (self.twins.size + len(self._boundary)) // 2

    @property
    def n_faces(self) -> int:
        """Number of faces, F = 2 V - 4 on the sphere."""
        return len(self.faces)

    @cached_property
    def _boundary(self) -> Indices:
        """Half-edges on the boundary of a `Net`, which are their own twins."""
        return np.flatnonzero(self.twins == np.arange(self.twins.size))

    @property
    def is_sphere(self) -> bool:
        """Whether the surface has no boundary or handles: always, except for an `isoembed.gluing.Net`."""
        return not len(self._boundary) and self.n_vertices - self.n_edges + self.n_faces == 2

    def check_sphere(self) -> None:
        """Raise InvalidMetric for nets of surfaces with boundary or handles."""
        if len(self._boundary):
            raise InvalidMetric(
                f"{_side(int(self._boundary[0]))} is glued to none ({len(self._boundary)} such sides): the "
                "surface is not closed"
            )
        check_euler(self.n_vertices, self.n_faces)

    @cached_property
    def mean_length(self) -> float:
        """Mean edge length: the unit of every residual."""
        largest, lengths = self.face_lengths.max(), self.face_lengths
        if len(self._boundary):  # edges count once, and these have one half-edge
            lengths = np.append(lengths, lengths.ravel()[self._boundary])
        return float(largest * np.mean(lengths / largest))

    def scaled(self, factor: float) -> GluedMetric:
        """Return the metric in another unit, with every length multiplied by this factor."""
        return self._with(self.face_lengths * factor, self.space.scaled(factor))

    def with_lengths(self, face_lengths: ArrayLike) -> GluedMetric:
        """Return the same triangles with other lengths, shape (F, 3).

        Raises
        ------
        InvalidMetric
        """
        lengths = _length_table(face_lengths, self.n_faces)
        _check_triangles(self.faces, lengths, self.space)
        return self._with(_matched(self.twins, lengths), self.space)

    @classmethod
    def flipped(cls, tables: HalfEdges) -> GluedMetric:
        """Metric from the flipped or renumbered triangles of another one; without seams.

        Raises
        ------
        InvalidMetric
            Rounding broke a triangle.
        """
        space = Space(tables.curvature)
        _check_triangles(tables.faces, tables.face_lengths, space)
        return cls._create(tables.faces, tables.twins, tables.face_lengths, space)

    @property
    def tables(self) -> tuple[NDArray, ...]:
        """Arrays that define the metric up to its `unit`: faces, twins, lengths, and curvature if not 0."""
        normalized = self.normalized
        curved = () if normalized.space.is_euclidean else (np.array(normalized.curvature),)
        return self.faces, self.twins, normalized.face_lengths, *curved

    @cached_property
    def deficits(self) -> Floats:
        """Angle deficits, 2 pi (pi on a boundary) minus the sum of the angles at each vertex, shape (V,).

        On the sphere they sum to 4 pi minus curvature times area.
        """
        total = np.bincount(self.faces.ravel(), self.triangles.angles.ravel())
        full = np.full(self.n_vertices, 2 * np.pi)
        full[self.faces.ravel()[self._boundary]] = np.pi
        return frozen(full - cast(Floats, total))

    def half_edges(self, directed: bool = True) -> HalfEdges:
        """Copy of the triangles as half-edge tables for flips, with or without directions."""
        constructor = HalfEdges.of if directed else HalfEdges.without_directions
        return constructor(self.faces, self.twins, self.face_lengths, self.curvature)

    @property
    def length_error(self) -> float | None:
        """Root mean square error of the lengths over their mean, by the `precision` of the sheets."""
        return None if self.precision is None else self.precision.length_error

    def simplicial(self) -> PolyhedralMetric:
        """Metric on a simplicial complex, as required for files.

        Loops are cut into three and multiple edges into two; adjacent faces get a vertex inside, and those
        that meet a vertex twice also a ring around it.

        Returns
        -------
        PolyhedralMetric
            Metric with the vertices of this one first, in order, followed by the flat new ones.

        Raises
        ------
        InvalidMetric
            A triangle is so thin that rounding breaks one of its parts.
        """
        unit = self.normalized
        metric = simplicial(unit.faces, unit.twins, unit.face_lengths, unit.space)
        return metric.rounded_as(unit).scaled(self.unit)


def _side(h: int) -> str:
    return f"side {h % 3} of face {h // 3}"


def _table(values: ArrayLike, name: str, shape: tuple[int, ...]) -> NDArray:
    try:
        table = np.asarray(values)
    except ValueError:  # rows of different sizes
        raise InvalidMetric(f"the {name} are not a table of shape {shape}") from None
    if table.shape != shape:
        raise InvalidMetric(f"the {name} have shape {table.shape}, not {shape}")
    return table


def _twin_array(twins: ArrayLike, size: int) -> Indices:
    table = _table(twins, "twins", (size,))
    if table.dtype.kind not in "iu":
        raise InvalidMetric(f"the twins have the type {table.dtype}, not whole numbers")
    outside = (table < 0) | (table >= size)
    if outside.any():
        h = int(np.argmax(outside))
        raise InvalidMetric(f"{_side(h)} is glued to half-edge {table[h]}, but there are only {size}")
    table = table.astype(np.int64)
    every = np.arange(size)
    alone = table == every
    if alone.any():
        raise InvalidMetric(f"{_side(int(np.argmax(alone)))} is glued to itself")
    one_way = table[table] != every
    if one_way.any():
        h = int(np.argmax(one_way))
        t = int(table[h])
        raise InvalidMetric(f"{_side(h)} is glued to {_side(t)}, but that is glued to {_side(int(table[t]))}")
    return table


def _length_table(face_lengths: ArrayLike, faces: int) -> Floats:
    table = _table(face_lengths, "lengths", (faces, 3))
    if table.dtype.kind not in "iuf":
        raise InvalidMetric(f"the lengths have the type {table.dtype}, not numbers")
    table = table.astype(np.float64)
    good = np.isfinite(table) & (table > 0)
    if not good.all():
        h = int(np.argmin(good))
        raise InvalidMetric(f"{_side(h)} has length {table.flat[h]}, not a positive finite number")
    return table


def _check_ends(faces: Indices, twins: Indices) -> None:
    """Refuse glued sides that do not join the same vertices in opposite directions."""
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    differ = start[twins] != end
    if differ.any():
        h = int(np.argmax(differ))
        t = int(twins[h])
        raise InvalidMetric(
            f"{_side(h)} runs from vertex {start[h]} to {end[h]} and is glued to {_side(t)}, "
            f"which runs from {start[t]} to {end[t]}, not back"
        )


def _check_triangles(faces: Indices, lengths: Floats, space: Space) -> None:
    check_triangles(faces, np.arange(lengths.size).reshape(-1, 3), lengths.ravel(), space, _side)


def _matched(twins: Indices, lengths: Floats) -> Floats:
    """Assign the length of the first of two glued sides to both, if they agree up to rounding."""
    flat = lengths.ravel()
    differs = np.abs(flat - flat[twins]) > SAME_LENGTH * flat
    if differs.any():
        h = int(np.argmax(differs))
        t = int(twins[h])
        raise InvalidMetric(
            f"{_side(h)} has length {float(flat[h])!r}, but {_side(t)}, which is glued to it, "
            f"has {float(flat[t])!r}"
        )
    return flat[np.minimum(twins, np.arange(flat.size))].reshape(-1, 3)


def _check_sphere(faces: Indices, twins: Indices) -> None:
    """Refuse surfaces other than a single sphere."""
    reached = reached_faces(twins)
    if not reached.all():
        f = int(np.argmin(reached))
        raise InvalidMetric(f"the surface has several components: face {f} is not connected to face 0")
    n = int(faces.max()) + 1
    v = pinched(faces.ravel(), twins, n)
    if v >= 0:
        raise InvalidMetric(
            f"the faces around vertex {v} form more than one fan: the surface is not a manifold"
        )
    check_euler(n, len(faces))
