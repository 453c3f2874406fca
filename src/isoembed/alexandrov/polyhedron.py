"""Convex polyhedra as embeddings, on triangulations that may differ from the input."""

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, field, replace
from functools import cached_property
from typing import Any, Self

import numpy as np

from isoembed.alexandrov.derivatives import GivenLengthDerivatives
from isoembed.arrays import Floats, Indices, Mask
from isoembed.embedding.polyhedron import Polyhedron
from isoembed.errors import InvalidMetric, InvalidParameter, warn_of_mesh
from isoembed.intrinsic.edge_paths import EdgePaths
from isoembed.intrinsic.halfedges import HalfEdges
from isoembed.mesh.triangulation import Triangulation, frozen
from isoembed.metric.glued import GluedMetric
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.metric.precision import Precision
from isoembed.metric.repair import Repair
from isoembed.proof.convex import ConvexCertificate, certify
from isoembed.space import Space
from isoembed.surface.convexity import dent_depths
from isoembed.surface.deviation import vertex_error
from isoembed.surface.segments import Segments
from isoembed.surface.surface import Surface


def metric_on(tables: HalfEdges) -> PolyhedralMetric:
    """Metric of triangles that form a simplicial complex.

    Raises
    ------
    InvalidMetric
        The triangles are invalid, or rounding broke one of them.
    """
    triangulation = Triangulation(tables.faces)
    lengths = np.empty(triangulation.n_edges)
    lengths[triangulation.face_edges.ravel()] = tables.lengths
    return PolyhedralMetric.on(triangulation, lengths, Space(tables.curvature))


@dataclass(frozen=True, eq=False, repr=False)
class GluedSurface(Surface):
    """Surface of a polyhedron whose metric was glued from paper.

    Parameters
    ----------
    given : GluedMetric
    edge_paths : EdgePaths
        Paths of its edges on the triangles of the polyhedron.
    """

    _: KW_ONLY
    given: GluedMetric
    edge_paths: EdgePaths

    @cached_property
    def seams(self) -> Segments:
        """Sides of the glued sheets of paper, as far as their paths were found."""
        given, paths = self.given, self.edge_paths
        halfedges = np.flatnonzero(np.arange(given.twins.size) < given.twins)
        which = np.flatnonzero(given.seams[halfedges])
        return Segments.along(paths, which[~np.isnan(paths.distances[which])], self.vertices)


@dataclass(frozen=True, eq=False, repr=False)
class ConvexPolyhedron(Polyhedron):
    """Alexandrov's polyhedron of a metric.

    Its `metric` is the given one on triangles of the polyhedron, with all given vertices; flat ones are
    inside its faces and edges.  A doubly covered triangle with all flat vertices on its sides has one more
    vertex, the last: otherwise both sheets would need the same edges.

    Parameters
    ----------
    metric : PolyhedralMetric
        Metric on triangles of the polyhedron.
    vertices : array_like of float, shape (V, 3)
    given : GluedMetric
        Given metric, possibly repaired.
    edge_paths : EdgePaths
        Paths of its edges on the triangles of the polyhedron, in the order of `PolyhedralMetric.edges` or of
        the lower half-edges of a `GluedMetric`; their lengths are in the unit of the normalized metric.
    core : tuple of HalfEdges and ndarray, or None
        Triangulation with only the vertices with a deficit, in order, and their positions, both in the unit
        of the metric's lengths; None if the body is flat.
    flat_vertices : ndarray of int
        Vertices without deficit.
    repair : Repair or None
        Changes made to obtain a convex metric.
    tolerance, stages, message, uniqueness
        See `Embedding`.
    """

    _: KW_ONLY
    given: GluedMetric
    edge_paths: EdgePaths
    core: tuple[HalfEdges, Floats] | None
    flat_vertices: Indices
    repair: Repair | None
    method: str = field(default="alexandrov", init=False)

    def __post_init__(self) -> None:
        frozen(self.flat_vertices)
        super().__post_init__()

    def _in_unit_of(self, target: PolyhedralMetric | GluedMetric) -> Self:
        """Return the same polyhedron, computed for the `normalized` of a metric, in that metric's unit."""
        own = GluedMetric.of(target) if self.repair is None else self.given.scaled(target.unit)
        core = self.core and (
            self.core[0]._replace(lengths=target.unit * self.core[0].lengths, curvature=target.curvature),
            frozen(target.unit * self.core[1]),
        )
        # These first: if the conversion rounds the vertices, `path_residuals` are recomputed.
        changed = self._with(given=own, core=core)
        changed.__dict__.pop("_certificate", None)  # its distance has a unit
        return super(ConvexPolyhedron, changed)._in_unit_of(target)

    def _with_errors_of(self, target: PolyhedralMetric | GluedMetric) -> Self:
        """Return the same polyhedron with the errors of the given lengths, within which bends do not count.

        Diagonals of its own have the root mean square error.
        """
        error = target.length_error
        if not error:
            return self
        errors = target.length_errors if isinstance(target, PolyhedralMetric) else None
        if self.core is None or not self.space.is_euclidean:
            if errors is not None:
                exact = "of doubly covered polygons" if self.core is None else "in curved space"
                warn_of_mesh(f"lengths {exact} are taken as exact: their errors are unused")
            return self
        error *= target.mean_length
        metric, sigma = self.metric, None
        try:
            error_bound = vertex_error(metric_on(self.core[0]), self.core[1], error)
            metric = metric._knowing(precision=Precision.of_lengths(error_bound / metric.mean_length))
        except InvalidMetric:  # triangles without the flat vertices need not form a simplicial complex
            pass
        if isinstance(target, PolyhedralMetric) and errors is not None:
            index = self.triangulation.edge_indices(target.edges)
            sigma = np.full(len(self.edges), error)
            sigma[index[index >= 0]] = errors[index >= 0]
            sigma = frozen(sigma)
        return replace(self, metric=metric, length_errors=sigma, message="")

    @property
    def residual(self) -> float:
        """Maximum of `residuals` and `path_residuals`."""
        return max(float(self.residuals.max()), float(self.path_residuals.max()))

    @cached_property
    def path_residuals(self) -> Floats:
        """Differences of given lengths from those of `edge_paths` on the surface, over the mean edge length.

        They compare the triangles of the polyhedron with the edges of the input, in the order of
        `edge_paths`; infinite if an edge was not found.
        """
        paths = self.edge_paths
        unit = np.exp2(np.rint(np.log2(self.given.mean_length / paths.lengths.mean())))
        off = np.abs(paths.lengths_on(self.vertices / unit) - paths.lengths) / paths.lengths.mean()
        return frozen(np.where(np.isnan(off), np.inf, off))

    @cached_property
    def dents(self) -> Floats:
        """Depths of dents at the edges (`dent_depths`), in mean edge lengths, shape (E,)."""
        depths = dent_depths(
            self.triangulation, self.vertices / self.metric.unit, self.metric.normalized.space
        )
        return frozen(depths / self.metric.normalized.mean_length)

    @property
    def _flat(self) -> Mask:
        flat = np.zeros(len(self.vertices), dtype=np.bool_)
        flat[self.flat_vertices] = True
        return flat

    def _made_surface(self, kind: type[Surface] = Surface, **more: Any) -> Surface:
        return super()._made_surface(GluedSurface, given=self.given, edge_paths=self.edge_paths, **more)

    @cached_property
    def _certificate(self) -> ConvexCertificate:
        if not self.converged:
            return ConvexCertificate(False, "not certified, because the lengths miss the tolerance")
        if self.core is None:
            return ConvexCertificate(False, "not certified, because the body is a doubly covered polygon")
        tables, vertices = self.core
        try:
            certificate = certify(metric_on(tables).rounded_as(self.metric), vertices)
        except InvalidMetric as error:
            return ConvexCertificate(False, f"not certified, because {error}")
        return replace(
            certificate,
            reason=f"{certificate.reason}; the certified metric is that of its own triangles, without the "
            f"flat vertices, and agrees with the given edges to {self.path_residuals.max():.1e} of the "
            "mean edge length",
        )

    def _given_derivatives(self) -> GivenLengthDerivatives:
        if self.core is None:
            raise InvalidParameter("the body is a doubly covered polygon, which has no derivatives")
        return GivenLengthDerivatives.of(self, self.edge_paths, self._flat)

    def _sentence(self) -> str:
        worst = int(np.argmax(self.path_residuals))
        if self.path_residuals[worst] <= max(self.tolerance, float(self.residuals.max())):
            return super()._sentence()
        a, b = self.edge_paths.ends[worst].tolist()
        if np.isinf(self.path_residuals[worst]):
            return (
                f"the given edge from vertex {a} to {b} was not found on the polyhedron, which has triangles "
                "that are too thin for floats"
            )
        return (
            f"the lengths miss the tolerance {self.tolerance:.0e}: on the polyhedron the given edge from "
            f"vertex {a} to {b} is off by {self.path_residuals[worst]:.1e} of the mean edge length"
        )

    @property
    def _reported(self) -> Mapping[str, Any]:
        """Entries of the report specific to polyhedra."""
        return {
            "input": {
                "vertices": self.given.n_vertices,
                "edges": self.given.n_edges,
                "faces": self.given.n_faces,
                "negative_deficits": 0 if self.repair is None else int((self.repair.deficits < 0).sum()),
            },
            "residual": {"paths": float(self.path_residuals.max())},
            "polyhedron": {
                "vertices": self.triangulation.n_vertices - len(self.flat_vertices),
                "faces": len(self.surface.flat_faces),
                "flat_vertices": len(self.flat_vertices),
            },
            "repair": None if self.repair is None else self.repair.as_json(),
        }
