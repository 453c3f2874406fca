"""Nearby realizations with the same lengths, along the softest modes of a surface.

Along motions v_j of the vertices the errors of the lengths are ``r + sum_j s_j J v_j + 1/2 sum_jk s_j s_k
Q(v_j, v_k)`` (`length_expansion`).  Projected on the ``J v_i``, these are a few quadratic equations, exact in
Euclidean space except for the response of other motions.  All of their roots (`quadratic_roots`) predict
realizations, from which Newton's method starts.

A pull-back may end at any of them; the smoothest is the intended one.
"""

from typing import NamedTuple

import numpy as np

from isoembed.aim.acceptance import REALIZED, identical_within
from isoembed.aim.length_expansion import LengthExpansion
from isoembed.aim.quadratic_roots import quadratic_roots
from isoembed.arrays import Floats
from isoembed.linalg import SingularMatrix
from isoembed.nonlinear.acceptance import contraction
from isoembed.nonlinear.stopping import below
from isoembed.progress.stages import StageRecorder
from isoembed.surface.length_newton import length_newton
from isoembed.surface.rigidity import LengthSystem, length_residuals
from isoembed.surface.smoothness import QuinticResiduals

SOFTEST = 4  # motions; others lead to distant realizations
NEAR = 0.03  # mean edge lengths; range of the quadratic approximation
APART = 0.1  # share of the predicted distance; if nearer, Newton's method fell back


def sought(motions: int, near: float) -> str:
    """Clause on a search along the softest motions, within a distance in mean edge lengths."""
    return (
        f"that there are no others is not known: they were sought along the {motions} softest motions "
        f"within {near:g} mean edge lengths only; isoembed.realizations(embedding) searches further"
    )


def nearby_realizations(
    system: LengthSystem,
    vertices: Floats,
    lengths: Floats,
    recorder: StageRecorder,
    *,
    residual_tolerance: float,
) -> list[Floats]:
    """The smoothest realization among neighbors of neighbors, and the intermediate ones.

    Parameters
    ----------
    system : LengthSystem
    vertices : ndarray, shape (V, 3)
        A surface with these lengths.
    lengths : ndarray, shape (E,)
        Scaled to a mean of about 1.
    recorder : StageRecorder
    residual_tolerance : float
        Largest residual of a neighbor.

    Returns
    -------
    list of ndarray, shape (V, 3)
        The smoothest comes first, a rougher neighbor of it, if found, last.  Empty if neither the vertices
        nor any neighbor has these lengths.
    """
    triangulation = system.triangulation
    errors = length_residuals(triangulation, vertices, lengths, system.space)
    best, found = vertices, [vertices] if np.abs(errors).max() <= residual_tolerance else []
    for _ in range(4):  # from realization to realization
        expansion = LengthExpansion(system, best, lengths)
        softest = softest_motions(expansion, SOFTEST)
        predicted = predicted_motions(expansion, softest, NEAR).motions
        if not predicted:
            return found
        charts = QuinticResiduals.of(triangulation, best)
        roughness = charts.roughness(best) if found else np.inf
        expected = [charts.roughness(best + motion) for motion in predicted]
        motion = predicted[int(np.argmin(expected)) if min(expected) < roughness else 0]
        neighbor = _realized(system, best, motion, lengths, recorder, residual_tolerance)
        if neighbor is None:
            return found
        if charts.roughness(neighbor) >= roughness:
            return [*found, neighbor]
        best, found = neighbor, [neighbor, *found]
    return found


class Predicted(NamedTuple):
    """Predicted motions, each (V, 3), and whether all roots were found."""

    motions: list[Floats]
    complete: bool


def softest_motions(expansion: LengthExpansion, count: int) -> Floats:
    """The motions with the smallest changes of the lengths, (m, V, 3); none if the surface is flexible."""
    available = min(count, len(expansion.lengths) - 1)
    try:
        return expansion.system.smallest_singular_values(expansion.vertices, expansion.lengths, available)[1]
    except SingularMatrix:
        return np.empty((0, *expansion.vertices.shape))


def predicted_motions(
    expansion: LengthExpansion,
    directions: Floats,
    near: float,
    imaginary: float = 1e-8,  # of real roots, by rounding
) -> Predicted:
    """Motions to the given lengths within the span of some directions, the shortest first.

    Parameters
    ----------
    expansion : LengthExpansion
    directions : ndarray, shape (k, V, 3)
    near : float
        Largest displacement of a vertex, in mean edge lengths.
    imaginary : float
        Largest imaginary part of a root, relative to the root.
    """
    if not len(directions):
        return Predicted([], True)
    unit = float(expansion.lengths.mean())
    scaled = near * unit / np.linalg.norm(directions, axis=2).max(axis=1)[:, None, None] * directions
    projection = np.linalg.pinv(expansion.rates(scaled).T)
    Q = expansion.bends(scaled[:, None], scaled) @ projection.T
    found = quadratic_roots(projection @ expansion.residuals, np.eye(len(scaled)), Q.transpose(2, 0, 1))
    motions = [np.tensordot(root, scaled, axes=1) for root in found.near_real(imaginary)]
    reach = [float(np.linalg.norm(motion, axis=1).max()) for motion in motions]
    error = float(np.abs(expansion.residuals).max()) / unit
    # Mean edge lengths; shorter motions lead to the surface itself.
    min_reach = identical_within(error) if error <= REALIZED else APART * max(error, 1e-9)
    selected = [motions[k] for k in np.argsort(reach) if min_reach * unit < reach[k] < near * unit]
    return Predicted(selected, found.complete)


def _realized(
    system: LengthSystem,
    vertices: Floats,
    motion: Floats,
    lengths: Floats,
    recorder: StageRecorder,
    residual_tolerance: float,
) -> Floats | None:
    """Realization that Newton's method finds from the end of a motion; None if it is not a different one."""
    # Where a step does not halve the residual, the start is outside of the region of quadratic convergence.
    found = length_newton(
        system,
        vertices + motion,
        lengths,
        contraction(0.5),
        recorder=recorder,
        converged=below(1e-13),  # mean edge lengths
        max_iterations=4,
    )
    moved = np.abs(found.point.x - vertices).max()
    apart = moved > APART * np.abs(motion).max()
    return found.point.x if apart and found.value <= residual_tolerance else None
