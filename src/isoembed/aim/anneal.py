"""Annealing (paper, section 2.2): Newton's method on the lengths, Eq. (fmin), from given vertices."""

from dataclasses import dataclass

import numpy as np

from isoembed.aim.accuracy import STIFFER
from isoembed.arrays import Floats
from isoembed.linalg import SingularMatrix
from isoembed.progress.stages import StageRecorder
from isoembed.surface.rigidity import LengthSystem, VertexSystem, length_residuals

POLISH_STEPS = 10  # Newton steps of the last stage


@dataclass(frozen=True)
class Annealed:
    """Vertices after annealing.

    Attributes
    ----------
    vertices : ndarray, shape (V, 3)
    residual : float
        Largest length error.
    converged : bool
        Whether it, or the last step, is below its tolerance.
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
) -> Annealed:
    """Bring the edges of a surface to given lengths by Newton's method; by default to the rounding floor.

    Parameters
    ----------
    system : LengthSystem
    vertices : ndarray, shape (V, 3)
        The initial guess.
    lengths : ndarray, shape (E,)
        Of mean 1 or so: tolerances are relative to the unit.
    recorder : StageRecorder
    residual_tolerance : float
        Stop when every length is right to this (the paper's 1e-6).
    step_tolerance : float
        Stop when no vertex moves more than this (the paper's 1e-8).
    max_iterations : int

    Returns
    -------
    Annealed
        The best vertices met.
    """
    x, r = vertices, length_residuals(system.triangulation, vertices, lengths, system.space)
    best = Annealed(x, float(np.abs(r).max()), False)
    for iteration in range(max_iterations + 1):
        residual = float(np.abs(r).max())
        recorder.show(residual=residual)
        if residual < best.residual:
            best = Annealed(x, residual, False)
        # Mean edge lengths: a smaller residual that grows is rounding.
        elif best.residual < 1e-9 and iteration:
            return best
        if residual <= residual_tolerance:
            return Annealed(x, residual, True)
        # Mean edge lengths, from which no Newton iteration returns.
        if not residual < 10.0 or iteration == max_iterations:
            return best
        try:
            step = system.step(x, lengths, r)
        except SingularMatrix:
            return best
        recorder.iterations += 1
        recorder.factorizations += 1
        x = x - step
        r = length_residuals(system.triangulation, x, lengths, system.space)
        if np.abs(step).max() <= step_tolerance:
            return Annealed(x, float(np.abs(r).max()), True)
    return best


def anneal_on_sphere(
    system: VertexSystem,
    vertices: Floats,
    lengths: Floats,
    radius: float,
    recorder: StageRecorder,
    *,
    max_iterations: int,
) -> Floats:
    """Fit points near a sphere to lengths and radius together, in least squares, by Gauss-Newton.

    It spreads the inconsistencies of the embedding tree evenly, "annealing the coordinates on the sphere",
    before the radius is let go.

    Parameters
    ----------
    system : VertexSystem
    vertices : ndarray, shape (V, 3)
        About the origin.
    lengths : ndarray, shape (E,)
    radius : float
    recorder : StageRecorder
    max_iterations : int

    Returns
    -------
    ndarray, shape (V, 3)
    """
    x = vertices
    for _ in range(max_iterations):
        r = length_residuals(system.triangulation, x, lengths)
        recorder.show(residual=float(np.abs(r).max()))
        try:
            step = system.spherical_step(x, lengths, r, radius)
        except SingularMatrix:
            break
        recorder.iterations += 1
        recorder.factorizations += 1
        x = x - step
        if np.abs(step).max() < 1e-3:  # mean edge lengths
            break
    return x


def anneal_damped(
    system: LengthSystem,
    vertices: Floats,
    lengths: Floats,
    recorder: StageRecorder,
    *,
    residual_tolerance: float,
    max_iterations: int,
) -> Annealed:
    """Bring the edges to given lengths by Levenberg-Marquardt: slower than Newton's method, never uphill.

    It finds some surface nearby, be it crumpled.  Parameters and result as of `anneal`.
    """
    triangulation = system.triangulation
    x, mu = vertices, 1e-2  # Levenberg-Marquardt
    r = length_residuals(triangulation, x, lengths)
    energy = r @ r
    for _ in range(max_iterations):
        if np.abs(r).max() <= residual_tolerance:
            break
        try:
            trial = x - system.step(x, lengths, r, mu)
        except SingularMatrix:
            mu *= STIFFER
            continue
        recorder.iterations += 1
        recorder.factorizations += 1
        r_trial = length_residuals(triangulation, trial, lengths)
        energy_trial = r_trial @ r_trial
        if energy_trial < energy:
            mu *= 0.3 if energy_trial < energy / 2 else 1.0
            x, r, energy = trial, r_trial, energy_trial
            recorder.show(residual=float(np.abs(r).max()))
        else:
            mu *= STIFFER
    residual = float(np.abs(r).max())
    return Annealed(x, residual, residual <= residual_tolerance)
