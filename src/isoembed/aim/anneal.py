"""Newton's method on the lengths from given vertices: the paper's annealing (section 2.2)."""

from dataclasses import dataclass

import numpy as np

from isoembed.aim.acceptance import NEARLY
from isoembed.arrays import Floats
from isoembed.nonlinear.acceptance import Damping
from isoembed.nonlinear.descent import Curve, Reason, descend
from isoembed.nonlinear.newton import Point, largest, newton
from isoembed.nonlinear.stopping import short_step, stagnated
from isoembed.progress.stages import StageRecorder
from isoembed.surface.length_newton import length_newton
from isoembed.surface.rigidity import LengthSystem, edge_rows, length_residuals
from isoembed.surface.vertex_system import VertexSystem

POLISH_STEPS = 10  # Newton steps of the last stage
DAMPED_STEPS = 25  # Levenberg-Marquardt steps of the last stage


@dataclass(frozen=True)
class Annealed:
    """Vertices after annealing.

    Attributes
    ----------
    vertices : ndarray, shape (V, 3)
    residual : float
        Largest length error.
    converged : bool
        Whether the residual or the last step is below its tolerance.
    """

    vertices: Floats
    residual: float
    converged: bool


def anneal(
    system: LengthSystem,
    vertices: Floats,
    lengths: Floats,
    recorder: StageRecorder,
    *,
    residual_tolerance: float = 1e-13,  # mean edge lengths
    step_tolerance: float = 0.0,
    max_iterations: int = POLISH_STEPS,
    max_damped: int = 0,
) -> Annealed:
    """Solve the length equations by Newton's method; by default to rounding.

    Parameters
    ----------
    system : LengthSystem
    vertices : ndarray, shape (V, 3)
        The initial guess.
    lengths : ndarray, shape (E,)
        Scaled to a mean of about 1: tolerances refer to this unit.
    recorder : StageRecorder
    residual_tolerance : float
        Stop when all length errors are at most this (the paper's 1e-6).
    step_tolerance : float
        Stop when no vertex moves by more than this (the paper's 1e-8).
    max_iterations : int
    max_damped : int
        Levenberg-Marquardt steps that follow where J is singular near a realization, as with flat faces:
        Newton steps halve the error there, until the factorization fails.

    Returns
    -------
    Annealed
        The iterate with the smallest residual.
    """
    rounding, diverged = stagnated(1e-9), 10.0  # residual beyond recovery, in mean edge lengths
    found = length_newton(
        system,
        vertices,
        lengths,
        recorder=recorder,
        converged=lambda p, size, _: size <= residual_tolerance or p.moved <= step_tolerance,
        stalled=lambda p, size, before: rounding(p, size, before) or not size < diverged,
        max_iterations=max_iterations,
    )
    annealed = Annealed(found.best.x, found.best_value, found.converged)
    if found.reason is not Reason.SINGULAR or not annealed.residual < NEARLY:
        return annealed
    damped = anneal_damped(
        system,
        found.best.x,
        lengths,
        recorder,
        residual_tolerance=residual_tolerance,
        max_iterations=max_damped,
        damping=1e-12,
    )
    return damped if damped.residual < annealed.residual else annealed


def anneal_on_sphere(
    system: VertexSystem,
    vertices: Floats,
    lengths: Floats,
    radius: float,
    recorder: StageRecorder,
    *,
    max_iterations: int,
) -> Floats:
    """Least-squares fit of points near a sphere to lengths and radius, by the Gauss-Newton method.

    It distributes the inconsistencies of the embedding tree evenly, "annealing the coordinates on the
    sphere", before the radius is released.

    Parameters
    ----------
    system : VertexSystem
    vertices : ndarray, shape (V, 3)
        Centered on the origin.
    lengths : ndarray, shape (E,)
    radius : float
    recorder : StageRecorder
    max_iterations : int

    Returns
    -------
    ndarray, shape (V, 3)
    """

    def residual(x: Floats) -> Floats:
        r = length_residuals(system.triangulation, x, lengths)
        recorder.show(residual=float(np.abs(r).max()))
        return r

    def solve(x: Floats, r: Floats) -> Floats:
        step = system.spherical_step(x, edge_rows(system.triangulation, x, lengths), r, radius)
        recorder.iterations += 1
        return step

    close = short_step(1e-3)  # mean edge lengths
    return newton(vertices, residual, solve, converged=close, max_iterations=max_iterations).point.x


def anneal_damped(
    system: LengthSystem,
    vertices: Floats,
    lengths: Floats,
    recorder: StageRecorder,
    *,
    residual_tolerance: float,
    max_iterations: int,
    damping: float = 1e-2,
) -> Annealed:
    """Minimize the length errors by the Levenberg-Marquardt method, which never goes uphill.

    The surface found nearby may be crumpled.  `damping` is the mu of the first step (`LengthSystem.step`);
    other parameters and the result as for `anneal`.
    """

    def at(x: Floats) -> Point:
        return Point(x, length_residuals(system.triangulation, x, lengths, system.space))

    def converged(p: Point, *_: float) -> bool:
        recorder.show(residual=largest(p))
        return largest(p) <= residual_tolerance

    def step(p: Point) -> Curve[Point]:
        def damped(mu: float) -> Point:
            d = system.step(p.x, lengths, p.residual, mu)
            recorder.iterations += 1
            return at(p.x - d)

        return damped

    found = descend(
        at(vertices),
        step,
        Damping(damping, softer=0.3, eased_below=0.5),
        value=lambda p: float(p.residual @ p.residual),
        converged=converged,
        max_iterations=max_iterations,
        max_trials=max_iterations,
    )
    return Annealed(found.point.x, largest(found.point), found.converged)
