"""Convex polyhedra as embeddings, on triangles that need not be those of the input."""

from dataclasses import KW_ONLY, dataclass, field, replace
from functools import cached_property
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike

from isoembed.alexandrov.derivatives import GivenLengthDerivatives
from isoembed.arrays import Floats, Indices, Mask
from isoembed.embedding.embedding import Embedding
from isoembed.embedding.polyhedron import Polyhedron
from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.intrinsic.edge_paths import EdgePaths
from isoembed.intrinsic.halfedges import HalfEdges
from isoembed.mesh.triangulation import Triangulation, frozen
from isoembed.metric.glued import GluedMetric
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.metric.repair import Repair
from isoembed.proof.convex import ConvexCertificate, certify
from isoembed.space import Space
from isoembed.strict_json import plain
from isoembed.surface.checked import checked
from isoembed.surface.convexity import dent_depths
from isoembed.surface.segments import Segments


def metric_on(tables: HalfEdges) -> PolyhedralMetric:
    """The metric of triangles that are a simplicial complex.

    Raises
    ------
    InvalidMetric
        They are none, or rounding broke one of them.
    """
    triangulation = Triangulation(tables.faces)
    lengths = np.empty(triangulation.n_edges)
    lengths[triangulation.face_edges.ravel()] = tables.lengths
    return PolyhedralMetric.on(triangulation, lengths, Space(tables.curvature))


@dataclass(frozen=True, eq=False, repr=False)
class ConvexPolyhedron(Polyhedron):
    """Alexandrov's polyhedron of a metric.

    Its `metric` is the given one on triangles of the polyhedron, which use every given vertex; those at which
    the metric is flat lie inside its faces and edges.  A triangle covered twice whose flat vertices are all
    on its sides has one vertex more, the last: without it, both sheets would need the same edges.

    Parameters
    ----------
    metric : PolyhedralMetric
        On triangles of the polyhedron.
    vertices : array_like of float, shape (V, 3)
    given : GluedMetric
        The metric as it was given, or as it was repaired.
    edge_paths : EdgePaths
        Its edges on the triangles of the polyhedron, in the order of `PolyhedralMetric.edges` or of the lower
        half-edges of a `GluedMetric`; their lengths are in the unit of the normalized metric.
    core : tuple of HalfEdges and ndarray, or None
        Triangles that use only the vertices with a deficit, in order, and the positions of these, both in the
        unit of the metric's lengths; None if the body is flat.
    flat_vertices : ndarray of int
        The vertices without a deficit.
    repair : Repair or None
        What was changed to make the metric convex.
    tolerance, stages, message, uniqueness
        As of an `Embedding`.
    """

    _: KW_ONLY
    given: GluedMetric
    edge_paths: EdgePaths
    core: tuple[HalfEdges, Floats] | None
    flat_vertices: Indices
    repair: Repair | None
    method: str = field(default="alexandrov", init=False)

    _DIMENSIONAL: ClassVar[tuple[str, ...]] = (*Embedding._DIMENSIONAL, "certificate", "seams")

    def __post_init__(self) -> None:
        frozen(self.flat_vertices)
        super().__post_init__()

    def _in_unit_of(self, given: PolyhedralMetric | GluedMetric) -> Self:
        """Return the same polyhedron, found for the `normalized` of a metric, in the unit of that metric."""
        own = GluedMetric.of(given) if self.repair is None else self.given.scaled(given.unit)
        core = self.core and (
            self.core[0]._replace(lengths=given.unit * self.core[0].lengths, curvature=given.curvature),
            frozen(given.unit * self.core[1]),
        )
        # First these: where floats cannot hold the vertices, `path_residuals` are measured anew.
        changed = self._with(given=own, core=core)
        return super(ConvexPolyhedron, changed)._in_unit_of(given)

    @property
    def residual(self) -> float:
        """The largest of `residuals` and `path_residuals`."""
        return max(float(self.residuals.max()), float(self.path_residuals.max()))

    @cached_property
    def path_residuals(self) -> Floats:
        """Given lengths against those of `edge_paths` as drawn on the surface, over the mean edge length.

        They measure the triangles of the polyhedron by the edges of the input, in the order of `edge_paths`;
        infinite where an edge was not found.
        """
        paths = self.edge_paths
        unit = np.exp2(np.rint(np.log2(self.given.mean_length / paths.lengths.mean())))
        off = np.abs(paths.lengths_on(self.vertices / unit) - paths.lengths) / paths.lengths.mean()
        return frozen(np.where(np.isnan(off), np.inf, off))

    @cached_property
    def dents(self) -> Floats:
        """The `dent_depths` of the edges, in mean edge lengths, shape (E,)."""
        depths = dent_depths(self.triangulation, self._normalized, self._space)
        return frozen(depths / self.metric.normalized.mean_length)

    @property
    def _flat(self) -> Mask:
        flat = np.zeros(len(self.vertices), dtype=np.bool_)
        flat[self.flat_vertices] = True
        return flat

    @cached_property
    def seams(self) -> Segments:
        """The sides of the paper that the metric was glued from, on the polyhedron; those that were found."""
        given, paths = self.given, self.edge_paths
        halfedges = np.flatnonzero(np.arange(given.twins.size) < given.twins)
        which = np.flatnonzero(given.seams[halfedges])
        return Segments.along(paths, which[~np.isnan(paths.distances[which])], self.vertices)

    @cached_property
    def certificate(self) -> ConvexCertificate:
        """The proof that this is the polyhedron of its metric up to a stated distance, or why there is none.

        It takes the lengths on the triangles of `core` as exact numbers; `path_residuals` say how far they
        are from the given ones.
        """
        if not self.converged:
            return ConvexCertificate(False, "not certified, because the lengths miss the tolerance")
        if self.core is None:
            return ConvexCertificate(False, "not certified, because the body is a doubly covered polygon")
        tables, vertices = self.core
        try:
            certificate = certify(metric_on(tables), vertices)
        except InvalidMetric as error:
            return ConvexCertificate(False, f"not certified, because {error}")
        return replace(
            certificate,
            reason=f"{certificate.reason}; that metric is of its own triangles without the flat vertices, "
            f"and agrees with the given edges to {self.path_residuals.max():.1e} of the mean edge length",
        )

    @cached_property
    def _by_given(self) -> GivenLengthDerivatives:
        if self.core is None:
            raise InvalidParameter("the body is a doubly covered polygon, which has no derivatives")
        return GivenLengthDerivatives.of(self, self.edge_paths, self._flat)

    def given_jvp(self, changes: ArrayLike) -> Floats:
        """How the vertices move, to first order, when the lengths that were given change.

        `jvp` is by the lengths of the polyhedron's own triangles.  The first call factors what both this and
        `given_vjp` need.

        Parameters
        ----------
        changes : array_like, shape (..., n)
            Of the given lengths, in the order of `edge_paths`: that of `PolyhedralMetric.edges`, or of the
            lower half-edges of a `GluedMetric`.

        Returns
        -------
        ndarray, shape (..., V, 3)
            In the same unit, without translation and rotation.

        Raises
        ------
        InvalidParameter
            The changes have another shape or are not finite; a flat vertex does not remain flat, or its face
            breaks, so that there is no derivative or one on one side only; the polyhedron is not in R^3 or
            is flat, or its triangles have another number of edges.
        SingularMatrix
            It is too thin.
        """
        dl = checked(changes, (len(self.edge_paths.ends),), "changes")
        rows = [self._by_given.jvp(row) for row in dl.reshape(-1, dl.shape[-1])]
        return np.array(rows).reshape(*dl.shape[:-1], len(self.vertices), 3)

    def given_vjp(self, gradient: ArrayLike) -> Floats:
        """Derivatives by the given lengths of a function of the vertices, from its derivatives by these.

        Parameters
        ----------
        gradient : array_like, shape (..., V, 3)
            As that of `vjp`.

        Returns
        -------
        ndarray, shape (..., n)
            The transpose of `given_jvp`, along changes that keep flat vertices flat.

        Raises
        ------
        InvalidParameter, SingularMatrix
            As `given_jvp`.
        """
        g = checked(gradient, (len(self.vertices), 3), "gradient")
        rows = [self._by_given.vjp(row) for row in g.reshape(-1, *g.shape[-2:])]
        return np.array(rows).reshape(*g.shape[:-2], len(self.edge_paths.ends))

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
    def report(self) -> dict[str, Any]:
        """What was asked, done and reached, as `Embedding.report`, with what only polyhedra have."""
        report = super().report
        report["input"] |= {
            "vertices": self.given.n_vertices,
            "edges": self.given.n_edges,
            "faces": self.given.n_faces,
            "negative_deficits": 0 if self.repair is None else int((self.repair.deficits < 0).sum()),
        }
        report["residual"]["paths"] = plain(float(self.path_residuals.max()))
        return report | {
            "polyhedron": {
                "vertices": self.triangulation.n_vertices - len(self.flat_vertices),
                "faces": int(self.face_polygons.max()) + 1,
                "flat_vertices": len(self.flat_vertices),
            },
            "repair": None if self.repair is None else self.repair.as_json(),
        }
