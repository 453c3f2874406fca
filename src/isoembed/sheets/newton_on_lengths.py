"""Newton's method on edge lengths: minimum-norm and Gauss-Newton steps."""

from __future__ import annotations

import numpy as np

from isoembed.arrays import Floats
from isoembed.linalg import SingularMatrix
from isoembed.progress.stages import StageRecorder
from isoembed.sheets.length_constraints import LengthConstraints
from isoembed.surface.rigidity import HeldTriangle, LengthSystem, VertexSystem, edge_rows

STEPS = 30  # at most
EXACT = 1e-15  # largest residual, in mean edge lengths, that ends it


def nearest_with_lengths(lengths: LengthConstraints, start: Floats, recorder: StageRecorder) -> Floats:
    """Vertices with the lengths, or with least squares of what they miss, near the start.

    Where there are fewer edges than unknowns, steps are of least norm; where there are more, as of surfaces
    with handles, they are Gauss-Newton steps.

    Parameters
    ----------
    lengths : LengthConstraints
    start : ndarray, shape (V, 3)
    recorder : StageRecorder

    Returns
    -------
    ndarray, shape (V, 3)
        The iterate with the least residual.
    """
    t, metric = lengths.triangulation, lengths.metric
    enough = t.n_edges > 3 * t.n_vertices - 6
    system = VertexSystem(t) if enough else LengthSystem(t)
    x = best = start
    r = lengths.residuals(x)
    least = float(np.abs(r).max())
    for _ in range(STEPS):
        recorder.show(residual=least / metric.mean_length)
        if least < EXACT * metric.mean_length:
            break
        recorder.factorizations += 1
        recorder.iterations += 1
        try:
            if isinstance(system, VertexSystem):
                rows = edge_rows(t, x, metric.lengths)
                held = HeldTriangle.of(x, t.faces[0])
                forces = t.incidence @ (rows * r[:, None])
                step = system.penalized(rows, 0.0, held=held).solve(forces.ravel(), sweeps=2).reshape(-1, 3)
            else:
                step = system.step(x, metric.lengths, r)
        except SingularMatrix:
            break
        x = x - step
        r = lengths.residuals(x)
        missed = float(np.abs(r).max())
        if not missed < least:
            break
        best, least = x, missed
    return best
