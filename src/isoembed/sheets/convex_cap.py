"""Convex caps: surfaces of nonnegative curvature bounded by a convex curve in a plane.

A metric of nonnegative curvature on a disc, with angles of at most pi along the boundary, is that of exactly
one convex cap.  Two copies glued along the boundary form a convex metric on the sphere, whose polyhedron
(`isoembed.Alexandrov`) is symmetric about the plane of the boundary.  Newton's method then solves for the
lengths of the given triangles, which may differ from those of the polyhedron; with the heights of the
boundary the system is square.

References
----------
Pogorelov, Extrinsic Geometry of Convex Surfaces (1973).
Izmestiev, A variational proof of Alexandrov's convex cap theorem, Discrete Comput. Geom. 40 (2008).
"""

from __future__ import annotations

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.errors import InvalidMetric
from isoembed.mesh.triangulation import Triangulation
from isoembed.metric.convexity import deficit_spread
from isoembed.metric.curvature import deficits
from isoembed.metric.glued import GluedMetric
from isoembed.metric.polyhedral import ANGLE_ROUNDING, PolyhedralMetric
from isoembed.nonlinear.acceptance import LineSearch
from isoembed.nonlinear.newton import largest, newton
from isoembed.progress.stages import StageRecorder
from isoembed.sheets.length_constraints import EXACT, LengthConstraints
from isoembed.surface.rigidity import edge_rows
from isoembed.surface.vertex_system import HeldVertices, VertexSystem

ANY_CURVATURE = "positions (B, 3) of the boundary allow any curvature, boundary='free' prescribes none"


def check_disc(metric: PolyhedralMetric) -> None:
    """Refuse surfaces with handles or several boundaries; raises InvalidMetric."""
    t = metric.triangulation
    if t.euler_characteristic != 1 or len(t.boundaries) != 1:
        boundaries = "one boundary" if len(t.boundaries) == 1 else f"{len(t.boundaries)} boundaries"
        raise InvalidMetric(f"the surface has {boundaries} and genus {t.genus}: a convex cap is a disc")


def check_cap(metric: PolyhedralMetric, tolerance: float = 0.0) -> None:
    """Refuse metrics that are not those of a convex cap.

    Parameters
    ----------
    metric : PolyhedralMetric
    tolerance : float
        Errors of the lengths, in mean edge lengths, that may have made angles negative.

    Raises
    ------
    InvalidMetric
        The surface is not a disc, or the curvature or the exterior angle of the boundary is negative at a
        vertex; the message names the vertex.
    """
    check_disc(metric)
    t = metric.triangulation
    found = deficits(metric)
    spread = deficit_spread(t.faces, metric.face_lengths, t.sides_across)
    # Two standard deviations are explained by errors of the lengths.
    beyond = np.minimum(found + np.maximum(ANGLE_ROUNDING, 2.0 * tolerance * spread), 0.0)
    worst = int(np.argmin(beyond))
    if beyond[worst] < 0:
        quantity = "exterior angle of the boundary" if t.boundary_vertices[worst] else "deficit"
        raise InvalidMetric(
            f"the {quantity} at vertex {worst} is {found[worst]:.4g} radians, but is nonnegative on a "
            f"convex cap; {ANY_CURVATURE}"
        )


def copied_vertices(triangulation: Triangulation) -> Indices:
    """Mirror image of each vertex in the double of a disc, (V,); those of its boundary are their own."""
    t = triangulation
    inside = np.flatnonzero(~t.boundary_vertices)
    copied = np.arange(t.n_vertices)
    copied[inside] = t.n_vertices + np.arange(len(inside))
    return copied


def doubled(metric: PolyhedralMetric) -> GluedMetric:
    """Double of a disc: two mirror images glued along the boundary, the first with the given indices."""
    t = metric.triangulation
    count, copied = t.n_faces, copied_vertices(t)
    faces = np.concatenate([t.faces, copied[t.faces[:, ::-1]]])
    # Side c of a face, from corner c to the next, is side (4 - c) % 3 of its mirror image.
    h = np.arange(3 * count)
    image = 3 * (count + h // 3) + (4 - h % 3) % 3
    across = t.sides_across
    twins = np.empty(6 * count, dtype=np.int64)
    twins[h] = np.where(across >= 0, across, image)
    twins[image] = np.where(across >= 0, image[across], h)
    lengths = np.empty(6 * count)
    lengths[h] = lengths[image] = metric.face_lengths.ravel()
    return GluedMetric(faces, twins, lengths.reshape(-1, 3))


def upright(vertices: Floats, boundary: Floats) -> Floats:
    """Move a cap so that its boundary, (B, 3), is in the plane z = 0, with the rest above."""
    middle = boundary.mean(axis=0)
    _, _, axes = np.linalg.svd(boundary - middle, full_matrices=False)
    if np.linalg.det(axes) < 0:
        axes = axes * [[1.0], [1.0], [-1.0]]
    placed = (vertices - middle) @ axes.T
    return placed * [1.0, -1.0, -1.0] if placed[:, 2].sum() < 0 else placed


def with_heights(metric: PolyhedralMetric, start: Floats, heights: Floats, recorder: StageRecorder) -> Floats:
    """Solve for the lengths and the heights z of the boundary's vertices by Newton's method.

    Two vertices of the boundary are constrained against horizontal motions, which makes the system square; it
    is solved by normal equations in nested-dissection order.

    Parameters
    ----------
    metric : PolyhedralMetric
        Metric on a disc.
    start : ndarray, shape (V, 3)
        Vertices near the surface.
    heights : ndarray, shape (B,)
        Heights along `Triangulation.boundaries`.
    recorder : StageRecorder

    Returns
    -------
    ndarray, shape (V, 3)
        Last iterate.
    """
    lengths, t = LengthConstraints(metric), metric.triangulation
    [loop] = t.boundaries
    system = VertexSystem(t, work=recorder.work)
    blocks = np.zeros((len(loop), 3, 3))
    blocks[:, 2, 2] = 1.0
    across = (start[loop] - start[loop[0]])[:, :2]
    far = int(np.argmax((across**2).sum(axis=1)))
    normal = np.array([-across[far, 1], across[far, 0]]) / np.linalg.norm(across[far])
    blocks[0, :2, :2] = np.eye(2)
    blocks[far, :2, :2] = np.outer(normal, normal)
    clamped = HeldVertices(loop, blocks)

    def equations(vertices: Floats) -> Floats:
        return np.concatenate([lengths.residuals(vertices), vertices[loop, 2] - heights])

    def solve(vertices: Floats, residuals: Floats) -> Floats:
        recorder.show(residual=float(np.abs(residuals).max()) / metric.mean_length)
        recorder.iterations += 1
        forces = lengths.forces(vertices, residuals[: t.n_edges])
        forces[loop, 2] += residuals[t.n_edges :]
        factor = system.penalized(edge_rows(t, vertices, metric.lengths), 0.0, clamped=clamped)
        return factor.solve(forces.ravel()).reshape(-1, 3)

    # The iteration may end at rounding, without convergence (as shown by the residual), or at a singular
    # matrix due to flat vertices, which the polyhedron has placed already.
    return newton(
        start,
        equations,
        solve,
        LineSearch(decrease=0.1, shortest=2.0**-11),
        norm=lambda p: float(np.linalg.norm(p.residual)),
        converged=lambda p, *_: largest(p) < EXACT * metric.mean_length,
        max_iterations=60,
    ).point.x
