"""Gauss-Newton method for surfaces with prescribed edge lengths and planar polygonal faces.

A surface with polygons of many vertices has more equations than unknowns, and a realization in which the
polygons bend does not satisfy them: far from the surface they lead to it where lengths alone lead elsewhere.
Polygons of rounded coordinates are not exactly planar: the weight of planarity is reduced until the lengths
agree, which also is a path to a surface whose rigidity matrix is nearly singular.
"""

from __future__ import annotations

import numpy as np

from isoembed.aim.polygon_planarity import PolygonPlanarity
from isoembed.arrays import Floats
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.nonlinear.acceptance import LineSearch
from isoembed.nonlinear.newton import Point, newton
from isoembed.nonlinear.stopping import settled
from isoembed.progress.stages import StageRecorder
from isoembed.surface.rigidity import edge_rows, length_residuals
from isoembed.surface.vertex_system import VertexSystem

WEIGHTS = 9.0 * 0.01 ** np.arange(6)
"""Penalty weights of planarity, in decreasing order: with small ones, polygons bend to fit the lengths."""

NEAR = 1e-3  # mean edge lengths; largest distance from planarity at the first weight
SOLVED = 1e-13  # mean edge lengths; residual at the level of rounding
MAX_STEPS = 40


def with_planar_polygons(metric: PolyhedralMetric, vertices: Floats, recorder: StageRecorder) -> Floats:
    """The surface, (V, 3), reached from the given vertices.

    Parameters
    ----------
    metric : PolyhedralMetric
        Euclidean, with `diagonals`, scaled to a mean edge length of about 1.
    vertices : ndarray, shape (V, 3)
    recorder : StageRecorder
    """
    t, lengths, planarity = metric.triangulation, metric.lengths, PolygonPlanarity.of(metric)
    crossings = planarity.crossings
    system = VertexSystem(t, crossings.T @ crossings, recorder.work)

    def stretch(p: Point) -> float:
        return float(np.abs(p.residual[: t.n_edges]).max())

    def fitted(start: Floats, weight: float) -> Point:
        def residual(x: Floats) -> Floats:
            bends = np.sqrt(weight) * planarity.offsets(x)
            return np.concatenate([length_residuals(t, x, lengths), bends.ravel()])

        def solve(x: Floats, r: Floats) -> Floats:
            rows = edge_rows(t, x, lengths)
            forces = t.incidence @ (rows * r[: t.n_edges, None])
            forces += np.sqrt(weight) * (crossings.T @ r[t.n_edges :].reshape(-1, 3))
            recorder.iterations += 1
            return system.penalized(rows, weight).solve(forces.ravel(), sweeps=0).reshape(-1, 3)

        return newton(
            start,
            residual,
            solve,
            LineSearch(0.0, 1e-3),
            converged=lambda p, *_: stretch(p) <= SOLVED,
            stalled=settled(1e-3),
            norm=lambda p: float(p.residual @ p.residual),
            max_iterations=MAX_STEPS,
        ).point

    for weight in WEIGHTS:
        found = fitted(vertices, weight)
        vertices = found.x
        recorder.show(residual=stretch(found))
        if stretch(found) <= SOLVED or np.abs(planarity.offsets(vertices)).max() > NEAR:
            break
    return vertices
