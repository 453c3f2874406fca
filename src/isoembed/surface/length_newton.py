"""Newton's method on the edge lengths of a surface: J d = r in least norm, or in least squares."""

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
    """Bring the edges of a surface from given vertices, (V, 3), to given lengths, (E,).

    The value of a point is the largest of the `length_residuals`; `damping` is the mu of `LengthSystem.step`,
    and the rest is as of `isoembed.nonlinear.newton.newton`.  A recorder counts steps.
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
