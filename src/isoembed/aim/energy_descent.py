"""Descent to a minimum of the regularized energy, by Newton's method with all second derivatives.

Where vertices are nearly in the plane of their neighbors the lengths change in second order alone, and so
does J: Gauss-Newton steps on ``|r|^2 + mu |R x|^2`` (`isoembed.aim.regularized_energy`) overshoot there as
soon as mu is small, and end far from any minimum.  What they leave out is sparse: ``r_ab / l_ab`` times the
identity for each edge.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from isoembed.aim.regularized_energy import RegularizedEnergy
from isoembed.arrays import Floats
from isoembed.linalg import SingularMatrix
from isoembed.progress.stages import StageRecorder
from isoembed.thresholds import threshold


@dataclass(frozen=True)
class DescentThresholds:
    """Thresholds of the descent."""

    steps: int = threshold(30, "count", "Newton steps at most.")
    damping: float = threshold(1.0, "relative", "w, the weight of K beside R, of the first step's matrix.")
    stiffer: float = threshold(5.0, "relative", "Factor of w after a step uphill.")
    softer: float = threshold(0.2, "relative", "Factor of w after a step downhill.")
    uphill: int = threshold(12, "count", "Steps uphill in turn that end it.")
    settled: float = threshold(0.999, "relative", "Share of the energy that a step leaves at the minimum.")


DESCENT = DescentThresholds()


def descended(
    energy: RegularizedEnergy,
    vertices: Floats,
    lengths: Floats,
    mu: float,
    recorder: StageRecorder,
    is_done: Callable[[Floats], bool],
) -> Floats:
    """The local minimum of ``|r|^2 + mu |R x|^2``.

    Parameters
    ----------
    energy : RegularizedEnergy
        Of a metric in Euclidean space.
    vertices : ndarray, shape (V, 3)
    lengths : ndarray, shape (E,)
    mu : float
    recorder : StageRecorder
        Counts steps and factorizations.
    is_done : callable
        Whether a surface is good enough, or no more may be spent.

    Returns
    -------
    ndarray, shape (V, 3)
    """
    x, damping, value = vertices, DESCENT.damping, energy.value(vertices, lengths, mu)
    for _ in range(DESCENT.steps):
        r = energy.residuals(x, lengths)
        gradient = energy.forces(x, lengths, r) + mu * energy.roughness(x, 0.0)
        recorder.iterations += 1
        for _ in range(DESCENT.uphill):
            if is_done(x):
                return x
            recorder.factorizations += 1
            try:
                trial = x - energy.solver(x, lengths, mu, damping, r / lengths)(gradient)
            except SingularMatrix:
                damping *= DESCENT.stiffer
                continue
            reached = energy.value(trial, lengths, mu)
            if reached < value:
                break
            damping *= DESCENT.stiffer
        else:
            return x
        x, before, value = trial, value, reached
        damping *= DESCENT.softer
        if value > DESCENT.settled * before:
            break
    return x
