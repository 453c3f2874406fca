"""The vertices of a polytope without curvature.

The apex may move, so ``x_i / r_i``, the unit vectors from the apex, are a kernel of ``d kappa / d r``: three
columns that one factor gives for all vertices alike.  Building the body up pyramid by pyramid instead would
lose all digits on large ones.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from isoembed.alexandrov.ambient import (
    ambient_lengths,
    away_from_apex,
    conformal_radii,
    distances_from_apex,
)
from isoembed.alexandrov.doubly_covered import FLAT_LIMIT
from isoembed.alexandrov.lengths import conformal_distances, worst_length, worst_of_conformal
from isoembed.alexandrov.newton import Analyses, Solution, pinned
from isoembed.alexandrov.polytope import Polytope
from isoembed.arrays import Floats, Indices
from isoembed.errors import InvalidMetric
from isoembed.intrinsic.flips import flip
from isoembed.intrinsic.halfedges import HalfEdges
from isoembed.intrinsic.multi_edges import remove_multi_edges, repeated
from isoembed.linalg import SingularMatrix
from isoembed.mesh.triangulation import Triangulation
from isoembed.progress.stages import StageRecorder
from isoembed.space import Space
from isoembed.surface.convexity import dent_depths
from isoembed.surface.measures import outward
from isoembed.surface.rigidity import LengthSystem, length_residuals
from isoembed.thresholds import threshold


@dataclass(frozen=True)
class PlacementThresholds:
    """Thresholds of the placement of a polytope's vertices."""

    precise: float = threshold(1e-12, "relative", "Residual of linear equations for a kernel.")
    rough: float = threshold(1e-4, "relative", "Residual of linear equations for a correction.")
    sample: int = threshold(100_000, "edges", "Edges that determine the six numbers of a linear map.")
    relaxations: int = threshold(20, "count", "Newton steps on the lengths at most.")
    diagonals: int = threshold(8, "edges", "Of those that are repeated, to be kept one after the other.")
    dented: float = threshold(1e-8, "mean edge lengths", "Deeper dents are never rounding.")
    shallow: float = threshold(1e-13, "mean edge lengths", "Less deep dents are always rounding.")
    exact: float = threshold(1e-12, "mean edge lengths", "Error of the lengths of a solution.")
    thick: float = threshold(10.0, "errors of the lengths", "That one which is no polygon has, flattened.")
    polishes: int = threshold(3, "count", "Rounds of the polish at most.")
    polished: float = threshold(8 * 2.0**-52, "radii", "Error of the lengths at which they may end.")
    magnified: float = threshold(1e-6, "mean edge lengths", "Size to which errors are lifted above rounding.")


PLACEMENT = PlacementThresholds()


def realized(solution: Solution, recorder: StageRecorder) -> Floats:
    """Vertices, shape (V, 3), as exact as floats allow; in Euclidean space the apex is the origin.

    Parameters
    ----------
    solution : Solution
    recorder : StageRecorder
        Counts the rounds of the polish.
    """
    about = around_apex(solution)
    for _ in range(PLACEMENT.polishes):
        worst = worst_of_conformal(solution.polytope.tables, about)
        if worst <= PLACEMENT.polished * float(np.abs(about).max()):
            break
        about = polished(solution, about)
        recorder.iterations += 1
    return away_from_apex(solution.polytope.space, about)


def placed(solution: Solution) -> Floats:
    """Vertices, shape (V, 3); in Euclidean space the apex is the origin."""
    return away_from_apex(solution.polytope.space, around_apex(solution))


def around_apex(solution: Solution) -> Floats:
    """Vertices around the apex, which is the origin, in conformal coordinates, shape (V, 3)."""
    p = solution.polytope
    directions = np.zeros((p.radii.size, 3))
    directions[solution.pins] = np.eye(3)
    directions += solution.solve(p.times_jacobian(directions), PLACEMENT.precise)[0]
    # They are so up to a linear map B: fit G = B B^T to |x_i| = sn(r_i) and |x_i - x_j|, known from l_ij.
    i, j, lengths = _edges(p)
    lengths = ambient_lengths(p.space, lengths, p.radii[i], p.radii[j])
    raw = directions * p.space.sn(p.radii)[:, None]
    products = np.concatenate([_products(directions), _products((raw[i] - raw[j]) / lengths[:, None])])
    g, *_ = np.linalg.lstsq(products, np.ones(len(products)), rcond=None)
    values, vectors = np.linalg.eigh(g[SYMMETRIC])
    raw = directions * conformal_radii(p.space, p.radii)[:, None]
    return raw @ (vectors * np.sqrt(np.abs(values)))  # all positive, if the polytope has no curvature


def polished(solution: Solution, about: Floats) -> Floats:
    """One more Newton step, on the lengths: the errors that rounding left in the placement go.

    The vertices are an exact polytope of nearly right lengths, without curvature and with its directions for
    a kernel.  What changes when the lengths are put right is linear in their errors, so these may be
    magnified before the curvatures, which are differences of nearly equal numbers, are evaluated.

    Parameters
    ----------
    solution : Solution
    about : ndarray, shape (V, 3)
        Vertices from `around_apex`, or from a polish before.

    Returns
    -------
    ndarray, shape (V, 3)
        The argument itself where that is no improvement.
    """
    tables, space = solution.polytope.tables, solution.polytope.space
    i, j = tables.corners, tables.corners[tables.twins]
    radii = distances_from_apex(space, about)
    actual = conformal_distances(space, about[i], about[j])
    missing = tables.lengths - actual
    error = float(np.abs(missing).max())
    if error == 0:
        return about
    scale = PLACEMENT.magnified * float(tables.lengths.mean()) / error
    wrong = tables._replace(lengths=actual + scale * missing)
    p = Polytope.on(wrong, radii)
    if p is None:
        return about
    dr, _ = solution.solve(p.curvatures, PLACEMENT.rough)
    q = Polytope.on(wrong, radii + dr)
    if q is None:
        return about
    directions = about / np.linalg.norm(about, axis=1)[:, None]
    turned = directions + solution.solve(q.times_jacobian(directions), PLACEMENT.rough)[0] / scale
    radii = radii + dr / scale
    moved = turned * space.sn(radii)[:, None]
    # Up to a linear map again, which now is near the identity.
    i, j, lengths = _edges(solution.polytope)
    lengths = ambient_lengths(space, lengths, radii[i], radii[j])
    chords = moved[i] - moved[j]
    strain, *_ = np.linalg.lstsq(
        _products(chords) / lengths[:, None], lengths - np.linalg.norm(chords, axis=1), rcond=None
    )
    moved += moved @ strain[SYMMETRIC]
    if not space.is_euclidean:
        moved *= (conformal_radii(space, radii) / space.sn(radii))[:, None]
    return moved if worst_of_conformal(tables, moved) < worst_of_conformal(tables, about) else about


def relaxed(tables: HalfEdges, vertices: Floats, recorder: StageRecorder) -> Floats:
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
    system = LengthSystem(triangulation, space=space)
    best = vertices
    for _ in range(PLACEMENT.relaxations):
        recorder.factorizations += 1
        try:
            residuals = length_residuals(triangulation, vertices, lengths, space)
            step = system.step(vertices, lengths, residuals)
        except SingularMatrix:
            break
        vertices = vertices - step
        if not (space.curvature * np.einsum("ij,ij->i", vertices, vertices) < 1).all():
            break  # out of the half of the sphere
        before, worst = worst_length(tables, best), worst_length(tables, vertices)
        if worst < before:
            best = vertices
        if before <= PLACEMENT.exact and worst > before / 2:
            break  # the rounding floor; where the body is thin, each step halves the errors, at least
    return best


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
        """Whether it has no dents, and is no polygon covered twice: flattened, it would miss its lengths."""
        centered = self.vertices - self.vertices.mean(axis=0)
        normal = np.linalg.svd(centered, full_matrices=False)[2][2]
        flattened = worst_length(self.tables, self.vertices - (centered @ normal)[:, None] * normal)
        error = max(worst_length(self.tables, self.vertices), FLAT_LIMIT.exact)
        return self.dent <= PLACEMENT.dented and flattened > PLACEMENT.thick * error


def relaxed_polytope(nearest: Polytope, recorder: StageRecorder) -> Relaxed | None:
    """Where the curvatures get small but not to zero, go on with the lengths, and flip what is then concave.

    Parameters
    ----------
    nearest : Polytope
        With small curvatures.
    recorder : StageRecorder

    Returns
    -------
    Relaxed or None
        None if no triangles and vertices are found that have the lengths of the metric.  They may have dents.
    """
    try:
        solution = pinned(nearest, Analyses.of(nearest.tables), recorder)
        with np.errstate(invalid="ignore"):  # many radii of curvature wide, and far from a polyhedron
            vertices = placed(solution)
    except SingularMatrix:
        return None
    if not np.isfinite(vertices).all():
        return None
    for tables in _simplicial(nearest.tables):
        body = relaxed_without_dents(tables, vertices, recorder)
        if body is not None:
            return body
    return None


def relaxed_without_dents(tables: HalfEdges, vertices: Floats, recorder: StageRecorder) -> Relaxed | None:
    """Relax and flip in turn, as long as that mends dents; None if lengths are missed."""
    best = None
    for _ in range(PLACEMENT.relaxations):
        if repeated(tables).size:  # made by flips on both sides of what is nearly flat
            break
        vertices = relaxed(tables, vertices, recorder)
        if not worst_length(tables, vertices) <= PLACEMENT.exact:
            break
        depths = _dents(tables, outward(tables.faces, vertices, Space(tables.curvature)))
        dent = float(depths.max())
        if dent <= PLACEMENT.dented and (best is None or dent < best.dent):
            best = Relaxed(tables.copy(), vertices, dent)
        if not _flipped(tables, depths, PLACEMENT.dented if best is None else PLACEMENT.shallow):
            return best or Relaxed(tables, vertices, dent)
    return best


def _simplicial(tables: HalfEdges) -> Iterator[HalfEdges]:
    """The triangles, or those that are left without repeated edges where one of these is kept.

    Nearly flat bodies have the same diagonal on both sides until their path ends, and not on both there.
    """
    edges = repeated(tables)
    if not edges.size:
        yield tables.copy()
    for h in edges[: PLACEMENT.diagonals]:
        mesh, kept = tables.copy(), np.zeros(tables.corners.size, dtype=np.bool_)
        kept[[h, tables.twins[h]]] = True
        remove_multi_edges(mesh, kept)
        yield mesh


def _dents(tables: HalfEdges, vertices: Floats) -> Floats:
    """Depths of the dents, in mean edge lengths, shape (E,)."""
    triangulation = Triangulation(tables.faces)
    return dent_depths(triangulation, vertices, Space(tables.curvature)) / tables.lengths.mean()


def _flipped(tables: HalfEdges, depths: Floats, least: float) -> int:
    """How many edges that are dented by more than this were flipped, the deepest first, each face once."""
    triangulation = Triangulation(tables.faces)
    whole = np.ones(triangulation.n_faces, dtype=np.bool_)
    flipped = 0
    for e in np.argsort(-depths)[: int((depths > least).sum())]:
        faces = triangulation.edge_faces[e]
        if whole[faces].all() and flip(int(triangulation.edge_halfedges[e, 0]), tables, 0.0):
            whole[faces] = False
            flipped += 1
    return flipped


SYMMETRIC = np.array([[0, 3, 4], [3, 1, 5], [4, 5, 2]])


def _products(v: Floats) -> Floats:
    """The coefficients of ``v^T S v`` in the six entries of a symmetric S, shape (n, 6)."""
    x, y, z = v.T
    return np.stack([x * x, y * y, z * z, 2 * x * y, 2 * x * z, 2 * y * z], axis=1)


def _edges(p: Polytope) -> tuple[Indices, Indices, Floats]:
    """Ends and lengths of the edges, or of an even sample of them."""
    tables = p.tables
    h = np.flatnonzero(np.arange(tables.twins.size) < tables.twins)
    h = h[:: -(-h.size // PLACEMENT.sample)]
    return tables.corners[h], tables.corners[tables.twins[h]], tables.lengths[h]
