"""Newton's method on the edge lengths of a surface: minimum-norm or damped solutions of J d = r."""

from typing import Any

import numpy as np

from isoembed.arrays import Floats
from isoembed.nonlinear.acceptance import FULL_STEPS, LineSearch
from isoembed.nonlinear.descent import Solution
from isoembed.nonlinear.newton import Point, newton
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
    """Solve for vertices, (V, 3), with given edge lengths, (E,), from a starting surface.

    The merit function is the maximum of the `length_residuals`; `damping` is the mu of `LengthSystem.step`,
    and the other parameters are those of `isoembed.nonlinear.newton.newton`.  A recorder counts the steps.
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
        return step

    return newton(start, residual, solve, acceptance, **stops)
