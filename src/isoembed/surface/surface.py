"""Surfaces: triangulation, vertices and space, with lazily computed measures of extrinsic geometry."""

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, fields
from functools import cached_property
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike

from isoembed.arrays import Floats, Indices, Mask
from isoembed.errors import InvalidParameter
from isoembed.mesh.triangulation import Triangulation, frozen
from isoembed.space import EUCLIDEAN, Space
from isoembed.space.models import to_model
from isoembed.surface import convexity, curvature, measures, smoothness
from isoembed.surface.flat_faces import FlatFaces, TriangleFaces
from isoembed.surface.segments import Segments
from isoembed.surface.vertex_areas import vertex_areas


@dataclass(frozen=True, eq=False, repr=False)
class Surface:
    """Triangulated surface in R^3, or in hyperbolic or spherical space.

    Parameters
    ----------
    triangulation : Triangulation
    vertices : array_like of float, shape (V, 3)
        In hyperbolic and spherical space, the first three coordinates on the hyperboloid or sphere.
    space : Space
        Ambient space, by default R^3.
    unit : float
        Power of two used as the unit of computations, to avoid under- and overflow.  By default (0) the one
        below the mean edge length.
    vertex_error : float
        Error of the vertices from rounded coordinates or lengths, in the unit of the vertices: bends and
        dents within its effect do not count.
    flat_vertices : ndarray of bool, shape (V,), optional
        Vertices inside the faces and edges of a convex polyhedron with polygonal faces.  By default the faces
        are the triangles.

    Raises
    ------
    ValueError
        The vertices have another shape or are not finite.
    """

    triangulation: Triangulation
    vertices: Floats
    space: Space = EUCLIDEAN
    _: KW_ONLY
    unit: float = 0.0
    vertex_error: float = 0.0
    flat_vertices: Mask | None = None

    # Cached properties that have a unit.
    _DIMENSIONAL: ClassVar[tuple[str, ...]] = ("mean_curvature", "seams")

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", frozen(vertex_array(self.triangulation, self.vertices)))
        if not self.unit:
            object.__setattr__(self, "unit", self._own_unit())
        if self.flat_vertices is not None:
            object.__setattr__(self, "flat_vertices", frozen(np.array(self.flat_vertices, dtype=np.bool_)))

    def _own_unit(self) -> float:
        """The power of two below the mean edge length."""
        exponent = int(np.frexp(np.abs(self.vertices).max())[1])
        near, space = np.ldexp(self.vertices, -exponent), self.space.scaled(float(np.ldexp(1.0, -exponent)))
        mean = measures.edge_lengths(self.edges, near, space).mean()
        return float(np.ldexp(1.0, exponent + int(np.frexp(mean)[1]) - 1))

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.triangulation.n_vertices} vertices, {self.space!r})"

    def _measured_as(self, other: "Surface") -> Self:
        """Copy cached dimensionless measures from the same surface in another unit."""
        own = {*self._DIMENSIONAL, *(field.name for field in fields(self))}
        self.__dict__.update({name: value for name, value in other.__dict__.items() if name not in own})
        return self

    @property
    def faces(self) -> Indices:
        """Triangles, shape (F, 3)."""
        return self.triangulation.faces

    @property
    def edges(self) -> Indices:
        """Ends of the edges, shape (E, 2)."""
        return self.triangulation.edges

    @cached_property
    def flat_faces(self) -> TriangleFaces:
        """Faces: the triangles, or the polygons of a polyhedron with polygonal faces."""
        t = self.triangulation
        if self.flat_vertices is None:
            return TriangleFaces(t, frozen(np.arange(t.n_faces)))
        return FlatFaces.of(t, self._normalized, self._space, self._vertex_error, self.flat_vertices)

    @property
    def seams(self) -> Segments:
        """Seams of glued paper: none, except on the surface of a `ConvexPolyhedron`."""
        return Segments.none()

    @cached_property
    def _normalized(self) -> Floats:
        return frozen(self.vertices / self.unit)

    @cached_property
    def _space(self) -> Space:
        """Space in the normalized unit."""
        return self.space.scaled(1 / self.unit)

    @property
    def _vertex_error(self) -> float:
        return self.vertex_error / self.unit

    @cached_property
    def _straight(self) -> Floats:
        """Normalized vertices in projective coordinates, which map planes to planes."""
        return frozen(to_model(self._space, self._normalized, "projective"))

    @cached_property
    def _conformal(self) -> Floats:
        """Normalized vertices in conformal coordinates, which preserve small shapes."""
        return frozen(to_model(self._space, self._normalized, "conformal"))

    @cached_property
    def _lengths(self) -> Floats:
        """Distances of the ends of the edges, (E,), in the normalized unit."""
        return frozen(measures.edge_lengths(self.edges, self._normalized, self._space))

    @cached_property
    def _vertex_areas(self) -> Floats:
        """Vertex areas, (V,), in the normalized unit."""
        t, x, space = self.triangulation, self._normalized, self._space
        if isinstance(self.flat_faces, FlatFaces):
            return frozen(self.flat_faces.vertex_shares(measures.triangle_areas(t.faces, x, space)))
        return frozen(vertex_areas(t, x, space))

    @property
    def lengths(self) -> Floats:
        """Lengths of the edges, shape (E,)."""
        return frozen(self._lengths * self.unit)

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
            raise InvalidParameter(f"normals need surfaces in R^3, not in {self.space!r}")
        normals = measures.face_normals(self.faces, self._normalized)
        with np.errstate(invalid="ignore"):  # NaN for triangles without area
            return frozen(normals / np.linalg.norm(normals, axis=1, keepdims=True))

    @cached_property
    def concave_edges(self) -> Mask:
        """Edges with an exterior dihedral angle below -1e-7 radians, shape (E,).

        If the lengths come from rounded coordinates, the bound is lower by the effect of the rounding.
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
    def bend_errors(self) -> Floats:
        """Errors of the dihedral angles due to the `vertex_error`, shape (E,), in radians."""
        return frozen(
            curvature.bend_errors(self.triangulation, self._normalized, self._space, self._vertex_error)
        )

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
        return frozen(normalized / self.unit)

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

        Surfaces less than a thousandth of an edge apart are distinguished by `fine_roughness`.  Both are
        measured in conformal coordinates.
        """
        return smoothness.roughness(self.triangulation, self._conformal, self._offsets)

    @cached_property
    def fine_roughness(self) -> float:
        """Robust mean of the twice-applied residuals of quintics fitted to the neighbors, in edge lengths.

        It is smaller for the smoother one of two nearby realizations of the same lengths.
        """
        return smoothness.fine_roughness(self.triangulation, self._conformal, self._ordered)

    @cached_property
    def rough_edges(self) -> Mask:
        """Edges with a dihedral angle of the sign opposite to their neighborhood's prediction, shape (E,)."""
        t, straight = self.triangulation, self._straight
        if self.space.is_euclidean:
            return frozen(smoothness.rough_edges(t, straight, self._offsets, self.dihedral_angles))
        return frozen(smoothness.rough_edges(t, straight, smoothness.offsets(t, straight)))

    @cached_property
    def bending_energy(self) -> float:
        """Integral of H^2 + k dA, where k is the curvature of space.

        4 pi for spheres, more for all other closed surfaces.
        """
        return curvature.bending_energy(
            self.triangulation, self._normalized, self._vertex_areas, self._space, self.dihedral_angles
        )

    @property
    def area(self) -> float:
        """Area, in the unit of the vertices, squared."""
        return measures.area(self.faces, self._normalized, self._space) * self.unit * self.unit

    @property
    def volume(self) -> float:
        """Enclosed volume, in the unit of the vertices cubed; raises InvalidMetric if there is a boundary."""
        self.triangulation.check_closed()
        normalized = measures.volume(self.faces, self._normalized, self._space)
        return normalized * self.unit * self.unit * self.unit

    @property
    def integrated_mean_curvature(self) -> float:
        """Integral of H dA = 1/2 sum l theta, in the unit of the vertices."""
        normalized = curvature.integrated_mean_curvature(
            self.triangulation, self._normalized, self._space, self.dihedral_angles
        )
        return normalized * self.unit


def vertex_array(triangulation: Triangulation, vertices: ArrayLike | Sequence[Any]) -> Floats:
    """Copy of the vertices as an array, (V, 3).

    Raises
    ------
    ValueError
        The vertices have another shape or are not finite.
    """
    points = np.array(vertices, dtype=np.float64, order="C")
    if points.shape != (triangulation.n_vertices, 3):
        raise ValueError(f"the vertices have shape {points.shape}, not ({triangulation.n_vertices}, 3)")
    finite = np.isfinite(points).all(axis=1)
    if not finite.all():
        v = int(np.argmin(finite))
        raise ValueError(f"vertex {v} has the coordinates {points[v].tolist()}, which are not finite")
    return points
