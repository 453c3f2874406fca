"""Undamped Newton's method on the edge lengths, from a nearby surface, and its deviation from the branch."""

from dataclasses import dataclass

import numpy as np

from isoembed.aim.anneal import anneal
from isoembed.arrays import Floats
from isoembed.nonlinear.acceptance import contraction
from isoembed.nonlinear.newton import Point
from isoembed.nonlinear.stopping import below
from isoembed.progress.stages import StageRecorder
from isoembed.surface.convexity import umbrella_heights
from isoembed.surface.length_newton import length_newton
from isoembed.surface.rigidity import LengthSystem

LOST = 0.5  # mean edge lengths; residual from which Newton's method is not continued


@dataclass(frozen=True, eq=False)
class BranchSolution:
    """Result of Newton's method on the lengths, or on the radii (`isoembed.aim.newton_from_polytope`).

    Attributes
    ----------
    vertices : ndarray, shape (V, 3)
    branch_deviation : float
        Largest deviation of the height of a vertex above its neighbors from the prediction of the first step,
        over the root mean square of these heights, or for radii over their value on a sphere.  Newton's
        method can cross to a neighboring realization of the same lengths, with some vertices pushed in; a
        height then changes by more than the error of the first step.
    """

    vertices: Floats
    branch_deviation: float


def newton_on_lengths(
    system: LengthSystem, start: Floats, lengths: Floats, good: float, recorder: StageRecorder
) -> BranchSolution | None:
    """Realize lengths close to those of a surface.

    Parameters
    ----------
    system : LengthSystem
    start : ndarray, shape (V, 3)
    lengths : ndarray, shape (E,)
        Scaled to a mean of about 1.
    good : float
        Residual at which the start is accepted, in mean edge lengths.
    recorder : StageRecorder

    Returns
    -------
    BranchSolution or None
        None if Newton's method does not converge immediately.
    """
    unit = float(lengths.mean())
    lost = LOST * unit

    def loses(p: Point, *_: float) -> bool:
        return system.space.is_euclidean and least_residual_after_step(p.residual, lengths) > lost

    begun = length_newton(
        system,
        start,
        lengths,
        recorder=recorder,
        converged=below(good * unit),
        stalled=loses,
        max_iterations=1,
    )
    if begun.iterations == 0:
        return BranchSolution(start, 0.0) if begun.converged else None
    found = length_newton(
        system,
        begun.point.x,
        lengths,
        contraction(0.5),
        converged=below(1e-4 * unit),  # the limit is determined from here
        stalled=lambda _, size, __: size > lost,
        max_iterations=100,
        recorder=recorder,
    )
    if not found.converged:
        return None
    expected, heights = (umbrella_heights(system.triangulation, p.x) for p in (begun.point, found.point))
    deviation = float(np.abs(heights - expected).max() / np.sqrt(np.mean(heights**2)))
    return BranchSolution(anneal(system, found.point.x, lengths, recorder).vertices, deviation)


def least_residual_after_step(residuals: Floats, lengths: Floats) -> float:
    """Lower bound on the largest residual after a Newton step in Euclidean space, without the step.

    The step moves the ends of an edge e of length l by d relative to one another, with ``e . d = r l``.  It
    leaves the residual ``|d|^2 / (2 l)``, with ``|d| >= |r| l / |e|`` and ``|e|^2 = l^2 + 2 r l``.
    """
    with np.errstate(divide="ignore"):  # an edge of length zero
        return float((residuals**2 / (2 * (lengths + 2 * residuals))).max())
