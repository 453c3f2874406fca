"""Newton's method on the edge lengths of a surface: J d = r in least norm, or in least squares."""

from typing import Any

import numpy as np

from isoembed.arrays import Floats
from isoembed.nonlinear import FULL_STEPS, LineSearch, Point, Solution, newton
from isoembed.progress.stages import StageRecorder
from isoembed.surface.rigidity import LengthSystem, length_residuals


def length_newton(
    system: LengthSystem,
    start: Floats,
    lengths: Floats,
    acceptance: LineSearch = FULL_STEPS,
    *,
    recorder: StageRecorder | None = None,
    damping: float = 0.0,
    **stops: Any,
) -> Solution[Point]:
    """Bring the edges of a surface to given lengths.

    Parameters
    ----------
    system : LengthSystem
    start : ndarray, shape (V, 3)
    lengths : ndarray, shape (E,)
    acceptance : LineSearch
        Of the largest of the `length_residuals`.
    recorder : StageRecorder, optional
        Counts steps and factorizations, and shows residuals.
    damping : float
        The mu of `LengthSystem.step`.
    **stops
        Of `isoembed.nonlinear.newton`.
    """

    def residual(x: Floats) -> Floats:
        r = length_residuals(system.triangulation, x, lengths, system.space)
        if recorder is not None:
            recorder.show(residual=float(np.abs(r).max()))
        return r

    def solve(x: Floats, r: Floats) -> Floats:
        step = system.step(x, lengths, r, damping)
        if recorder is not None:
            recorder.iterations += 1
            recorder.factorizations += 1
        return step

    return newton(start, residual, solve, acceptance, **stops)
