"""Vertices with given edge lengths by the Levenberg-Marquardt method: some surface nearby, be it crumpled."""

import numpy as np

from isoembed import Embedding, PolyhedralMetric
from isoembed.progress.stages import Log
from isoembed.surface.rigidity import LengthSystem, length_residuals
from reproduction.arrays import Floats

DAMPING = 1e-2  # at first, relative to the mean diagonal of J J^T
STIFFER = 5.0  # factor after a step uphill
SOFTER = 0.3  # factor after a step that halves the sum of squares


def least_squares(
    metric: PolyhedralMetric, start: Floats, *, method: str, tolerance: float, max_iterations: int
) -> Embedding:
    """Minimize the sum of ``(|x_a - x_b|^2 - l_ab^2)^2 / (2 l_ab)^2`` from a start.

    Parameters
    ----------
    metric : PolyhedralMetric
    start : ndarray, shape (V, 3)
        In the unit of ``metric.normalized``.
    method : str
        Name for the result.
    tolerance : float
        Of the lengths: the residual at which the iteration stops.
    max_iterations : int

    Returns
    -------
    Embedding
        Where the iteration ended, whether the lengths are attained or not.
    """
    given, log = metric.normalized, Log()
    t, system = given.triangulation, LengthSystem(given.triangulation)
    x, mu = start, DAMPING
    r = length_residuals(t, x, given.lengths)
    with log.stage("least squares") as recorder:
        for _ in range(max_iterations):
            if np.abs(r).max() <= tolerance:
                break
            trial = x - system.step(x, given.lengths, r, mu)  # not singular: mu > 0
            recorder.iterations += 1
            recorder.factorizations += 1
            r_trial = length_residuals(t, trial, given.lengths)
            before, after = r @ r, r_trial @ r_trial
            if after < before:
                mu *= SOFTER if after < before / 2 else 1.0
                x, r = trial, r_trial
            else:
                mu *= STIFFER
    return Embedding(metric, metric.unit * x, method=method, tolerance=tolerance, stages=log.stages)
