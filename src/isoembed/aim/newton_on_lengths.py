"""Newton's method on the lengths, undamped, from a surface nearby to the given lengths at once."""

from dataclasses import dataclass

import numpy as np

from isoembed.aim.anneal import anneal
from isoembed.arrays import Floats
from isoembed.linalg import SingularMatrix
from isoembed.progress.stages import StageRecorder
from isoembed.surface.convexity import umbrella_heights
from isoembed.surface.rigidity import LengthSystem, length_residuals


@dataclass(frozen=True, eq=False)
class LengthsSolution:
    """Where Newton's method on the lengths ends.

    Attributes
    ----------
    vertices : ndarray, shape (V, 3)
    branch_deviation : float
        The most that the height of a vertex above its neighbors differs from where the first step pointed,
        over the root mean square of such heights.  Newton's method can cross over to a neighboring
        realization, with some vertices turned inside out, that has the same lengths; then a height changes
        by more than the first step's error explains.
    """

    vertices: Floats
    branch_deviation: float


def newton_on_lengths(
    system: LengthSystem, start: Floats, lengths: Floats, good: float, recorder: StageRecorder
) -> LengthsSolution | None:
    """Realize lengths that are near those of a surface.

    Parameters
    ----------
    system : LengthSystem
    start : ndarray, shape (V, 3)
    lengths : ndarray, shape (E,)
        Of mean 1 or so.
    good : float
        Residual at which the start itself is taken, in mean edge lengths.
    recorder : StageRecorder

    Returns
    -------
    LengthsSolution or None
        None where Newton's method does not converge at once.
    """
    triangulation, unit = system.triangulation, float(lengths.mean())
    r = length_residuals(triangulation, start, lengths, system.space)
    residual = float(np.abs(r).max()) / unit
    if residual <= good:
        return LengthsSolution(start, 0.0)
    x, pointed, before = start, start, np.inf
    while residual > 1e-4 or x is start:  # mean edge lengths: below it is decided where the iteration goes
        recorder.iterations += 1
        recorder.factorizations += 1
        try:
            x = x - system.step(x, lengths, r)
        except SingularMatrix:
            return None
        if not np.isfinite(x).all():
            return None
        pointed = x if pointed is start else pointed
        r = length_residuals(triangulation, x, lengths, system.space)
        residual = float(np.abs(r).max()) / unit
        recorder.show(residual=residual)
        # Each step must halve the residual; from half a mean edge length on it is lost.
        if not residual < 0.5 * before or residual > 0.5:
            return None
        before = residual
    expected, heights = (umbrella_heights(triangulation, y) for y in (pointed, x))
    deviation = float(np.abs(heights - expected).max() / np.sqrt(np.mean(heights**2)))
    return LengthsSolution(anneal(system, x, lengths, recorder).vertices, deviation)
