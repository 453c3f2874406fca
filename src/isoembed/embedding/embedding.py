"""Embeddings: vertices in space, the metric that they realize, and how they were found.

What is costly to compute, or slow to import, is computed and imported when it is asked for.
"""

import copy
from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike

from isoembed.arrays import Floats, Indices, Mask
from isoembed.embedding.sensitivity import Sensitivity
from isoembed.embedding.sentence import sentence
from isoembed.embedding.views import Views
from isoembed.errors import InvalidParameter
from isoembed.evidence import Evidence
from isoembed.linalg import SingularMatrix
from isoembed.mesh.triangulation import Triangulation, frozen
from isoembed.metric.curvature import dual_areas, gaussian_curvature
from isoembed.metric.glued import GluedMetric
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.progress.stages import Stage
from isoembed.space import Space
from isoembed.space.models import from_model, to_model
from isoembed.surface import alignment, convexity, curvature, measures, smoothness
from isoembed.surface.checked import checked_errors
from isoembed.surface.segments import Segments

if TYPE_CHECKING:
    from isoembed.embedding.comparison import Comparison
    from isoembed.proof.certificate import Certificate


@dataclass(frozen=True, eq=False, repr=False)
class Embedding(Sensitivity, Views):
    """Realization of a polyhedral metric, exact or attempted: in R^3, or in the space of its curvature.

    Parameters
    ----------
    metric : PolyhedralMetric
        What was to be realized.
    vertices : array_like of float, shape (V, 3)
        In the unit of the metric's lengths.  A closed surface with negative volume is mirrored.  In
        hyperbolic and spherical space, the first three coordinates on hyperboloid or sphere.
    method : str
        The name of the method that found them.
    tolerance : float
        Largest residual that counts as converged.
    stages : sequence of Stage
        How they were found.
    message : str
        What the method has to say; by default a sentence on the residual.
    others : sequence of Embedding
        Other realizations of the same lengths that were met: the metric has more than one.
    uniqueness : Evidence, optional
        Evidence that there are no realizations but this one and `others`; None if none were sought.
    length_errors : ndarray, shape (E,), optional
        Standard deviations of the lengths, if they are known (`with_length_errors`).

    Attributes
    ----------
    metric, vertices, method, tolerance, stages, others, uniqueness, length_errors
        As given; `vertices` is read-only.

    Raises
    ------
    ValueError
        The vertices have another shape, are not finite, or on the sphere not in the open half about the
        origin.
    """

    metric: PolyhedralMetric
    vertices: Floats
    _: KW_ONLY
    method: str
    tolerance: float
    stages: Sequence[Stage] = ()
    message: str = ""
    others: "Sequence[Embedding]" = ()
    uniqueness: Evidence | None = None
    length_errors: Floats | None = None

    # Cached properties that have a unit.
    _DIMENSIONAL: ClassVar[tuple[str, ...]] = ("gaussian_curvature", "mean_curvature")

    def __post_init__(self) -> None:
        points, metric = np.array(self.vertices, dtype=np.float64, order="C"), self.metric
        if points.shape != (metric.triangulation.n_vertices, 3):
            raise ValueError(
                f"the vertices have shape {points.shape}, not ({metric.triangulation.n_vertices}, 3)"
            )
        _check_finite(points)
        # The sign is taken in the metric's own unit: the volume of tiny surfaces underflows.
        points = from_model(metric.space, points, "ambient") / metric.unit
        points = metric.unit * self._oriented(points)
        self._set(vertices=frozen(points), stages=tuple(self.stages), others=tuple(self.others))
        if not self.message:
            self._set(message=self._sentence())

    def _set(self, **values: Any) -> None:
        for name, value in values.items():
            object.__setattr__(self, name, value)

    def _oriented(self, points: Floats) -> Floats:
        """Normalized vertices or their mirror image: that with positive volume, if the surface is closed."""
        if not self.triangulation.is_closed:
            return points
        return measures.outward(self.metric.faces, points, self._space)

    def _sentence(self) -> str:
        return sentence(self)

    def distance(self, other: "Embedding") -> float:
        """How far the vertices are from another realization's, rigid motions aside, in mean edge lengths."""
        apart = alignment.distance(self._normalized, other.vertices / self.metric.unit, self._space)
        return apart / self.metric.normalized.mean_length

    def _with_message(self, message: str) -> Self:
        """Return the same embedding with another message."""
        return self._with(message=message)

    def _with_stages(self, stages: Sequence[Stage]) -> Self:
        """Return the same embedding with other stages."""
        return self._with(stages=tuple(stages))

    def _with_others(self, others: "Sequence[Embedding]", uniqueness: Evidence | None = None) -> Self:
        """Return the same embedding with other realizations beside it, which the message then names."""
        both = self._with(others=tuple(others), uniqueness=uniqueness)
        return both._with(message=both._sentence())

    def with_length_errors(self, errors: ArrayLike) -> Self:
        """Return the same surface with errors of its lengths, of which the report makes error bars.

        Parameters
        ----------
        errors : float or array_like, shape (E,)
            Standard deviations of the lengths, in their unit, as of `deviation`.

        Raises
        ------
        InvalidParameter, InvalidMetric
            As `integral_deviation`.
        """
        self.triangulation.check_sphere()
        return self._with(length_errors=frozen(checked_errors(self.metric, errors)))

    def _in_unit_of(self, given: PolyhedralMetric | GluedMetric) -> Self:
        """Return the same surface, found for the `normalized` of a metric, in the unit of that metric.

        What was measured is not measured again: but for `_DIMENSIONAL`, what is cached has no unit.  Where
        floats cannot hold so small a surface, the unit moves its vertices, and all is measured anew.
        """
        own = isinstance(given, PolyhedralMetric) and self.metric is given.normalized
        vertices = given.unit * self.vertices
        _check_finite(vertices)
        changes: dict[str, Any] = {
            "metric": given if own else self.metric.scaled(given.unit).in_space(given.space),
            "vertices": frozen(vertices),
            "others": tuple(other._in_unit_of(given) for other in self.others),
        }
        if self.length_errors is not None:
            changes["length_errors"] = frozen(given.unit * self.length_errors)
        if (vertices / given.unit != self.vertices).any():
            return replace(self, **changes, message="")
        changed = self._with(**changes)
        for name in self._DIMENSIONAL:
            changed.__dict__.pop(name, None)
        return changed

    def _with(self, **changes: Any) -> Self:
        changed = copy.copy(self)
        changed._set(**changes)
        return changed

    def __repr__(self) -> str:
        return (
            f"{type(self).__name__}({self.triangulation.n_vertices} vertices, method {self.method!r}, "
            f"{self.status}, residual {self.residual:.1e})"
        )

    @property
    def triangulation(self) -> Triangulation:
        """The triangles that the lengths belong to."""
        return self.metric.triangulation

    @property
    def space(self) -> Space:
        """Where the surface is: of the curvature of the metric's triangles."""
        return self.metric.space

    @property
    def _space(self) -> Space:
        """The same in the normalized unit."""
        return self.metric.normalized.space

    @property
    def faces(self) -> Indices:
        """(F, 3): the triangles."""
        return self.metric.faces

    @property
    def edges(self) -> Indices:
        """(E, 2): the ends of the edges."""
        return self.metric.edges

    @property
    def polygons(self) -> Indices | Sequence[Indices]:
        """The faces: the vertices around each, counterclockwise seen from outside.

        They are the triangles, unless the surface is a `ConvexPolyhedron`.
        """
        return self.faces

    @property
    def face_polygons(self) -> Indices:
        """The face that each triangle is part of, shape (F,)."""
        return np.arange(len(self.faces))

    @property
    def face_sides(self) -> Indices:
        """How many sides each face has."""
        return np.full(len(self.faces), 3)

    @property
    def polygon_edges(self) -> Mask:
        """Edges between two faces, shape (E,): the others are diagonals, which might lie elsewhere."""
        return np.ones(len(self.metric.edges), dtype=np.bool_)

    @property
    def seams(self) -> Segments:
        """Where sides of paper were glued: nowhere, unless the surface is the `ConvexPolyhedron` of a net."""
        return Segments.none()

    @cached_property
    def _vertex_areas(self) -> Floats:
        """The vertices' shares of the area, (V,), in the normalized unit."""
        return frozen(curvature.vertex_areas(self.triangulation, self._normalized, self._space))

    @cached_property
    def _normalized(self) -> Floats:
        """The vertices in the unit of the normalized metric, in which nothing under- or overflows."""
        return frozen(self.vertices / self.metric.unit)

    @cached_property
    def _straight(self) -> Floats:
        """The normalized vertices in projective coordinates, in which planes are planes."""
        return frozen(to_model(self._space, self._normalized, "projective"))

    @cached_property
    def _conformal(self) -> Floats:
        """The normalized vertices in conformal coordinates, in which small shapes are as they are."""
        return frozen(to_model(self._space, self._normalized, "conformal"))

    @cached_property
    def _realized(self) -> Floats:
        """Distances of the ends of the edges, (E,), in the normalized unit."""
        return frozen(measures.edge_lengths(self.edges, self._normalized, self._space))

    @property
    def lengths(self) -> Floats:
        """Lengths of the edges on this surface, shape (E,): `metric` has those that were asked for."""
        return frozen(self._realized * self.metric.unit)

    @cached_property
    def residuals(self) -> Floats:
        """``| |x_a - x_b| - l_ab |`` over the mean edge length, shape (E,): of distances in the space."""
        normalized = self.metric.normalized
        return frozen(np.abs(self._realized - normalized.lengths) / normalized.mean_length)

    @property
    def residual(self) -> float:
        """The largest of `residuals`."""
        return float(self.residuals.max())

    @property
    def converged(self) -> bool:
        """Whether the largest residual, measured on these vertices, is within the tolerance."""
        return self.residual <= self.tolerance

    @property
    def status(self) -> str:
        """``"converged"`` or ``"not converged"``."""
        return "converged" if self.converged else "not converged"

    @property
    def _vertex_error(self) -> float:
        """Error of the vertices from rounded coordinates, in the normalized unit; 0 if there were none."""
        precision = self.metric.precision
        return 0.0 if precision is None else precision.vertex_error * self.metric.normalized.mean_length

    @cached_property
    def dihedral_angles(self) -> Floats:
        """Exterior dihedral angles in radians, shape (E,): 0 where flat, positive where convex.

        On a boundary they are 0.
        """
        return frozen(curvature.dihedral_angles(self.triangulation, self._normalized, self._space))

    @cached_property
    def normals(self) -> Floats:
        """Unit normals of the triangles, shape (F, 3), outward if the surface is closed.

        Raises
        ------
        InvalidParameter
            The surface is in hyperbolic or spherical space, where directions at different points differ.
        """
        if not self.space.is_euclidean:
            raise InvalidParameter(f"normals are those of surfaces in R^3, not in {self.space!r}")
        normals = measures.face_normals(self.faces, self._normalized)
        with np.errstate(invalid="ignore"):  # a triangle without area has none: NaN
            return frozen(normals / np.linalg.norm(normals, axis=1, keepdims=True))

    @cached_property
    def gaussian_curvature(self) -> Floats:
        """Gaussian curvature at the vertices, shape (V,): a property of the metric.

        The deficit over the circumcentric dual area, and in hyperbolic and spherical space the curvature of
        the triangles more; NaN where the dual area is not positive.
        """
        known = dual_areas(self.metric.normalized) > 0
        values = np.full(len(known), np.nan)
        with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
            curvature = gaussian_curvature(self.metric)
        known &= np.abs(curvature) < 1e300  # beyond, sums overflow
        values[known] = curvature[known]
        return frozen(values)

    @cached_property
    def concave_edges(self) -> Mask:
        """Edges with an exterior dihedral angle below -1e-7 radians, shape (E,).

        Where the coordinates that the lengths come from were rounded, below minus what this explains.
        """
        return frozen(
            convexity.concave_edges(
                self.triangulation, self._normalized, self._space, self.dihedral_angles, self._vertex_error
            )
        )

    @cached_property
    def inverted_vertices(self) -> Mask:
        """Vertices whose edges are all concave, shape (V,)."""
        return frozen(convexity.inverted_vertices(self.triangulation, self.concave_edges))

    @cached_property
    def partially_inverted_vertices(self) -> Mask:
        """Vertices with more than 70 % of their edges concave, but not all, shape (V,)."""
        return frozen(convexity.partially_inverted_vertices(self.triangulation, self.concave_edges))

    @cached_property
    def self_intersections(self) -> Indices:
        """Pairs of faces that intersect, shape (n, 2): none on an embedded surface."""
        from isoembed.surface.intersection import self_intersections

        return frozen(self_intersections(self.faces, self._straight))

    @cached_property
    def mean_curvature(self) -> Floats:
        """Mean curvature H = (k1 + k2) / 2 at the vertices, shape (V,)."""
        normalized = curvature.vertex_mean_curvature(
            self.triangulation, self._normalized, self._vertex_areas, self._space, self.dihedral_angles
        )
        return frozen(normalized / self.metric.unit)

    @cached_property
    def _ordered(self) -> smoothness.Ordered:
        return smoothness.in_spatial_order(self.triangulation, self._conformal)

    @cached_property
    def _offsets(self) -> Floats:
        """Distances of the vertices from fits to their neighbors, (V, 3), in conformal coordinates."""
        return frozen(smoothness.offsets(self.triangulation, self._conformal, self._ordered))

    @cached_property
    def roughness(self) -> float:
        """Root mean square distance of the vertices from a cubic fitted to their neighbors, in edge lengths.

        Realizations less than a thousandth of an edge apart are told apart by `fine_roughness`.  Both are
        measured in conformal coordinates.
        """
        return smoothness.roughness(self.triangulation, self._conformal, self._offsets)

    @cached_property
    def fine_roughness(self) -> float:
        """Robust mean of the residuals of quintics fitted to the neighbors, taken twice, in edge lengths.

        Of two realizations of the same lengths that are near each other, the one with less is the smoother.
        """
        return smoothness.fine_roughness(self.triangulation, self._conformal, self._ordered)

    @cached_property
    def rough_edges(self) -> Mask:
        """Edges whose dihedral angle has another sign than their neighborhood gives them, shape (E,)."""
        t, straight = self.triangulation, self._straight
        if self.space.is_euclidean:
            return frozen(smoothness.rough_edges(t, straight, self._offsets, self.dihedral_angles))
        return frozen(smoothness.rough_edges(t, straight, smoothness.offsets(t, straight)))

    @cached_property
    def bending_energy(self) -> float:
        """Integral of H^2 + k dA, k the curvature of space: 4 pi for a sphere, more for any other surface."""
        return curvature.bending_energy(
            self.triangulation, self._normalized, self._vertex_areas, self._space, self.dihedral_angles
        )

    @cached_property
    def smallest_singular_value(self) -> float:
        """Smallest singular value of the rigidity matrix J, rigid motions apart: 0 if the surface can flex.

        To first order, the vertices need not move by more than its inverse times a change of the lengths,
        both in the Euclidean norm.  It takes one factorization of J J^T, as a step of Newton's method does.
        """
        from isoembed.surface.rigidity import LengthSystem

        self.triangulation.check_sphere()  # of others J is not square, rigid motions apart
        system = LengthSystem(self.triangulation, space=self._space)
        lengths = self.metric.normalized.lengths
        try:
            return float(system.smallest_singular_values(self._normalized, lengths, 1)[0][0])
        except SingularMatrix:
            return 0.0

    @cached_property
    def certificate(self) -> "Certificate":
        """The proof that an exact realization of the lengths is near these vertices, or why there is none.

        It says how near, how far away any other is at least, and whether the faces cross.  It takes two
        factorizations of J J^T, and a search for self-intersections.
        """
        from isoembed.proof.certificate import NO_SPHERE, Certificate, certify

        if not self.triangulation.is_sphere:
            return NO_SPHERE
        if not self.converged:
            return Certificate(False, "not certified, because the lengths miss the tolerance")
        return certify(self.metric, self.vertices)

    def comparison(self, other: "Embedding") -> "Comparison":
        """How another surface in R^3, of the same triangles, differs from this one.

        If both have the same lengths and a `certificate`, it is the exact surfaces that are compared, with
        proven errors.  That takes three factorizations more for each.

        Parameters
        ----------
        other : Embedding
            Of the same triangles, such as one of the `others`.

        Raises
        ------
        InvalidParameter
            The triangles are others, or space is curved.
        """
        from isoembed.embedding.comparison import compare

        return compare(self, other)

    @property
    def area(self) -> float:
        """Area, in the unit of the lengths, squared."""
        unit = self.metric.unit
        return measures.area(self.faces, self._normalized, self._space) * unit * unit

    @property
    def volume(self) -> float:
        """Enclosed volume, in the unit of the lengths, cubed; raises InvalidMetric if there is a boundary."""
        self.triangulation.check_closed()
        unit = self.metric.unit
        return measures.volume(self.faces, self._normalized, self._space) * unit * unit * unit

    @property
    def integrated_mean_curvature(self) -> float:
        """Integral of H dA = 1/2 sum l theta, in the unit of the lengths."""
        normalized = curvature.integrated_mean_curvature(
            self.triangulation, self._normalized, self._space, self.dihedral_angles
        )
        return normalized * self.metric.unit

    @property
    def report(self) -> dict[str, Any]:
        """Report of what was asked, done and reached: the JSON object that the command writes.

        A number that is infinite (the volume of a body 1e150 across) is None.  So is the smallest singular
        value where J J^T is large, beyond 20,000 vertices or some 900 edges at one of them: it alone costs as
        much as all else.  For the same reason there is no certificate beyond 30,000 vertices; the property
        has it all the same.  With `length_errors` it has the `integral_deviation` under ``deviation``.
        """
        from isoembed.embedding.report import report

        return report(self)


def _check_finite(points: Floats) -> None:
    finite = np.isfinite(points).all(axis=1)
    if not finite.all():
        v = int(np.argmin(finite))
        raise ValueError(f"vertex {v} has the coordinates {points[v].tolist()}, which are not finite")
