"""Newton's method on the lengths with flips, for the last part of the homotopy.

Nearly flat vertices leave ``d kappa / d r`` nearly singular; their places are determined by the lengths all
the same.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count

import numpy as np

from isoembed.alexandrov.doubly_covered import FLAT_IN_FLOATS
from isoembed.alexandrov.lengths import worst_length
from isoembed.alexandrov.newton import Analyses, pinned
from isoembed.alexandrov.placement import placed
from isoembed.alexandrov.polytope import Polytope
from isoembed.arrays import Floats
from isoembed.errors import InvalidMetric
from isoembed.intrinsic.halfedges import HalfEdges
from isoembed.intrinsic.loops import flip
from isoembed.intrinsic.multi_edges import remove_multi_edges, repeated
from isoembed.linalg import SingularMatrix, Work
from isoembed.mesh.triangulation import Triangulation
from isoembed.nonlinear.newton import Point, newton
from isoembed.space import Space
from isoembed.surface.convexity import dent_depths
from isoembed.surface.measures import outward
from isoembed.surface.rigidity import LengthSystem, length_residuals

MAX_STEPS = 20  # of Newton's method on the lengths
DENTED = 1e-8  # mean edge lengths: deeper dents are never rounding
SHALLOW = 1e-13  # mean edge lengths: less deep dents are always rounding
RELAXED = 1e-12  # mean edge lengths: error of the lengths of a solution


def relaxed(tables: HalfEdges, vertices: Floats, work: Work) -> Floats:
    """Newton's method on the lengths, where nearly flat vertices leave ``d kappa / d r`` nearly singular.

    Returns
    -------
    ndarray, shape (V, 3)
        The best on the way.
    """
    try:
        triangulation = Triangulation(tables.faces)
    except InvalidMetric:  # flat bodies may have repeated edges, and no Newton step either
        return vertices
    lengths = np.empty(triangulation.n_edges)
    lengths[triangulation.face_edges.ravel()] = tables.lengths
    space = Space(tables.curvature)
    system, steps = LengthSystem(triangulation, space=space, work=work), count()

    def solve(x: Floats, r: Floats) -> Floats:
        return system.step(x, lengths, r)

    def worst(p: Point) -> float:
        inside = (space.curvature * np.einsum("ij,ij->i", p.x, p.x) < 1).all()
        return worst_length(tables, p.x) if inside else np.inf  # out of the half of the sphere

    return newton(
        vertices,
        lambda x: length_residuals(triangulation, x, lengths, space),
        solve,
        norm=worst,
        # The rounding floor; where the body is thin, each step halves the errors, at least.
        converged=lambda _, error, before: (
            (next(steps) >= MAX_STEPS or before <= RELAXED) and not error < before / 2
        ),
        max_iterations=200,
    ).best.x


@dataclass(frozen=True, eq=False)
class Relaxed:
    """A surface that has the lengths of a metric, and is convex but for dents.

    Attributes
    ----------
    tables : HalfEdges
    vertices : ndarray, shape (V, 3)
    dent : float
        Depth of the deepest dent, in mean edge lengths; no flip mends it.
    """

    tables: HalfEdges
    vertices: Floats
    dent: float

    @property
    def is_sure(self) -> bool:
        """Whether it has no dents, and is not a doubly covered polygon, which would miss its lengths."""
        centered = self.vertices - self.vertices.mean(axis=0)
        normal = np.linalg.svd(centered, full_matrices=False)[2][2]
        flattened = worst_length(self.tables, self.vertices - (centered @ normal)[:, None] * normal)
        error = max(worst_length(self.tables, self.vertices), FLAT_IN_FLOATS)
        # Errors of the lengths, by which a body that is not a polygon misses them when flattened.
        return self.dent <= DENTED and flattened > 10.0 * error


def relaxed_polytope(nearest: Polytope, work: Work) -> Relaxed | None:
    """Solve for the lengths where the curvatures get small but not to zero, and flip concave edges.

    Parameters
    ----------
    nearest : Polytope
        With small curvatures.
    work : Work
        Counts factorizations.

    Returns
    -------
    Relaxed or None
        None if no triangles and vertices are found that have the lengths of the metric.  They may have dents.
    """
    try:
        solution = pinned(nearest, Analyses.of(nearest.tables, work))
        with np.errstate(invalid="ignore"):  # many radii of curvature wide, and far from a polyhedron
            vertices = placed(solution)
    except SingularMatrix:
        return None
    if not np.isfinite(vertices).all():
        return None
    for tables in _simplicial(nearest.tables):
        body = relaxed_without_dents(tables, vertices, work)
        if body is not None:
            return body
    return None


def relaxed_without_dents(tables: HalfEdges, vertices: Floats, work: Work) -> Relaxed | None:
    """Relax and flip in turn, as long as that mends dents; None if lengths are missed."""
    best = None
    for _ in range(MAX_STEPS):
        if repeated(tables).size:  # made by flips on both sides of what is nearly flat
            break
        vertices = relaxed(tables, vertices, work)
        if not worst_length(tables, vertices) <= RELAXED:
            break
        depths = _dents(tables, outward(tables.faces, vertices, Space(tables.curvature)))
        dent = float(depths.max())
        if dent <= DENTED and (best is None or dent < best.dent):
            best = Relaxed(tables.copy(), vertices, dent)
        if not _flipped(tables, depths, DENTED if best is None else SHALLOW):
            return best or Relaxed(tables, vertices, dent)
    return best


def _simplicial(tables: HalfEdges) -> Iterator[HalfEdges]:
    """The triangles, or those that are left without repeated edges where one of these is kept.

    Nearly flat bodies have the same diagonal on both sides until their path ends, and not on both there.
    """
    edges = repeated(tables)
    if not edges.size:
        yield tables.copy()
    for h in edges[:8]:  # repeated edges that are kept one after the other
        mesh, kept = tables.copy(), np.zeros(tables.corners.size, dtype=np.bool_)
        kept[[h, tables.twins[h]]] = True
        remove_multi_edges(mesh, kept)
        yield mesh


def _dents(tables: HalfEdges, vertices: Floats) -> Floats:
    """Depths of the dents, in mean edge lengths, shape (E,)."""
    triangulation = Triangulation(tables.faces)
    return dent_depths(triangulation, vertices, Space(tables.curvature)) / tables.lengths.mean()


def _flipped(tables: HalfEdges, depths: Floats, least: float) -> int:
    """Flip edges dented by more than `least`, the deepest first, each face once; return their number."""
    triangulation = Triangulation(tables.faces)
    whole = np.ones(triangulation.n_faces, dtype=np.bool_)
    views, flipped = tables.views, 0
    for e in np.argsort(-depths)[: int((depths > least).sum())]:
        faces = triangulation.edge_faces[e]
        if whole[faces].all() and flip(int(triangulation.edge_halfedges[e, 0]), views, 0.0):
            whole[faces] = False
            flipped += 1
    return flipped
