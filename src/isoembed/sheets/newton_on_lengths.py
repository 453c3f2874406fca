"""Newton's method to the nearest surface with given edge lengths: minimum-norm and Gauss-Newton steps."""

from __future__ import annotations

import numpy as np

from isoembed.arrays import Floats
from isoembed.nonlinear.acceptance import contraction
from isoembed.nonlinear.newton import newton
from isoembed.nonlinear.stopping import below
from isoembed.progress.stages import StageRecorder
from isoembed.sheets.length_constraints import LengthConstraints
from isoembed.surface.rigidity import LengthSystem, edge_rows
from isoembed.surface.vertex_system import HeldTriangle, VertexSystem


def nearest_with_lengths(lengths: LengthConstraints, start: Floats, recorder: StageRecorder) -> Floats:
    """Vertices with the given lengths, exactly or in least squares, near the start.

    With fewer edges than unknowns, steps have minimum norm; with more, as for surfaces with handles, they are
    Gauss-Newton steps.

    Parameters
    ----------
    lengths : LengthConstraints
    start : ndarray, shape (V, 3)
    recorder : StageRecorder

    Returns
    -------
    ndarray, shape (V, 3)
        Last iterate.
    """
    t, metric = lengths.triangulation, lengths.metric
    enough = t.n_edges > 3 * t.n_vertices - 6
    system = VertexSystem(t, work=recorder.work) if enough else LengthSystem(t, work=recorder.work)

    def solve(x: Floats, r: Floats) -> Floats:
        recorder.show(residual=float(np.abs(r).max()) / metric.mean_length)
        recorder.iterations += 1
        if isinstance(system, LengthSystem):
            return system.step(x, metric.lengths, r)
        rows = edge_rows(t, x, metric.lengths)
        forces = t.incidence @ (rows * r[:, None])
        factor = system.penalized(rows, 0.0, clamped=HeldTriangle.of(x, t.faces[0]))
        return factor.solve(forces.ravel(), sweeps=2).reshape(-1, 3)

    return newton(
        start,
        lengths.residuals,
        solve,
        contraction(1.0),
        converged=below(1e-15 * metric.mean_length),
        max_iterations=30,
    ).point.x
