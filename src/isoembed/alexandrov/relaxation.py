"""Newton's method on the lengths with flips, for the last part of the homotopy.

For nearly flat vertices ``d kappa / d r`` is nearly singular, but the lengths determine their positions.
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
DENTED = 1e-8  # mean edge lengths: deeper dents are never due to rounding
SHALLOW = 1e-13  # mean edge lengths: shallower dents are always due to rounding
RELAXED = 1e-12  # mean edge lengths: length error of a solution


def relaxed(tables: HalfEdges, vertices: Floats, work: Work) -> Floats:
    """Newton's method on the lengths, for nearly flat vertices with nearly singular ``d kappa / d r``.

    Returns
    -------
    ndarray, shape (V, 3)
        Best iterate.
    """
    try:
        triangulation = Triangulation(tables.faces)
    except InvalidMetric:  # flat bodies may have multiple edges, and no Newton step either
        return vertices
    lengths = np.empty(triangulation.n_edges)
    lengths[triangulation.face_edges.ravel()] = tables.lengths
    space = Space(tables.curvature)
    system, steps = LengthSystem(triangulation, space=space, work=work), count()

    def solve(x: Floats, r: Floats) -> Floats:
        try:
            return system.step(x, lengths, r)
        except SingularMatrix:  # heights of nearly flat vertices, within rounding
            return system.step(x, lengths, r, mu=1e-14)

    def worst(p: Point) -> float:
        inside = (space.curvature * np.einsum("ij,ij->i", p.x, p.x) < 1).all()
        return worst_length(tables, p.x) if inside else np.inf  # outside the hemisphere

    return newton(
        vertices,
        lambda x: length_residuals(triangulation, x, lengths, space),
        solve,
        norm=worst,
        # Rounding floor; on thin bodies, each step at least halves the errors.
        converged=lambda _, error, before: (
            (next(steps) >= MAX_STEPS or before <= RELAXED) and not error < before / 2
        ),
        max_iterations=200,
    ).best.x


@dataclass(frozen=True, eq=False)
class Relaxed:
    """Surface with the lengths of a metric that is convex except for dents.

    Attributes
    ----------
    tables : HalfEdges
    vertices : ndarray, shape (V, 3)
    dent : float
        Depth of the deepest dent, in mean edge lengths, that no flip removes.
    """

    tables: HalfEdges
    vertices: Floats
    dent: float

    @property
    def is_sure(self) -> bool:
        """Whether the surface has no dents and is not a doubly covered polygon."""
        centered = self.vertices - self.vertices.mean(axis=0)
        normal = np.linalg.svd(centered, full_matrices=False)[2][2]
        flattened = worst_length(self.tables, self.vertices - (centered @ normal)[:, None] * normal)
        error = max(worst_length(self.tables, self.vertices), FLAT_IN_FLOATS)
        # Flattening a body that is not a polygon causes significant length errors.
        return self.dent <= DENTED and flattened > 10.0 * error


def relaxed_polytope(nearest: Polytope, work: Work) -> Relaxed | None:
    """Solve for the lengths if the curvatures become small but do not vanish, and flip concave edges.

    Parameters
    ----------
    nearest : Polytope
        Polytope with small curvatures.
    work : Work
        Counter of factorizations.

    Returns
    -------
    Relaxed or None
        Surface with the lengths of the metric, possibly with dents; None if none is found.
    """
    try:
        solution = pinned(nearest, Analyses.of(nearest.tables, work))
        with np.errstate(invalid="ignore"):  # bodies many radii of curvature wide, far from a polyhedron
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
    """Alternate relaxation and flips as long as this removes dents; None if the lengths are not met."""
    best = None
    for _ in range(MAX_STEPS):
        if repeated(tables).size:  # due to flips on both sides of a nearly flat body
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
    """Yield the triangulation or, if it has multiple edges, versions that keep one of these.

    Nearly flat bodies may have the same diagonal on both sides along the path, but not at its end.
    """
    edges = repeated(tables)
    if not edges.size:
        yield tables.copy()
    for h in edges[:8]:  # multiple edges that are kept in turn
        mesh, fixed = tables.copy(), np.zeros(tables.corners.size, dtype=np.bool_)
        fixed[[h, tables.twins[h]]] = True
        remove_multi_edges(mesh, fixed)
        yield mesh


def _dents(tables: HalfEdges, vertices: Floats) -> Floats:
    """Depths of the dents, in mean edge lengths, shape (E,)."""
    triangulation = Triangulation(tables.faces)
    return dent_depths(triangulation, vertices, Space(tables.curvature)) / tables.lengths.mean()


def _flipped(tables: HalfEdges, depths: Floats, threshold: float) -> int:
    """Flip edges dented by more than `threshold`, the deepest first, each face once; return their number."""
    triangulation = Triangulation(tables.faces)
    whole = np.ones(triangulation.n_faces, dtype=np.bool_)
    views, flipped = tables.views, 0
    for e in np.argsort(-depths)[: int((depths > threshold).sum())]:
        faces = triangulation.edge_faces[e]
        if whole[faces].all() and flip(int(triangulation.edge_halfedges[e, 0]), views, 0.0):
            whole[faces] = False
            flipped += 1
    return flipped
