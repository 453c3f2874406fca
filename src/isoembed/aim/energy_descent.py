"""Newton descent of the regularized energy with exact Hessians.

Near vertices that lie almost in the plane of their neighbors the lengths change to second order only.
Gauss-Newton steps on ``|r|^2 + mu |R x|^2`` (`isoembed.aim.regularized_energy`) overshoot there for small mu,
and end far from any minimum.  The omitted part of the Hessian is sparse: ``r_ab / l_ab`` times the identity
for each edge.
"""

from __future__ import annotations

from collections.abc import Callable

from isoembed.aim.regularized_energy import RegularizedEnergy
from isoembed.arrays import Floats
from isoembed.nonlinear.acceptance import Damping
from isoembed.nonlinear.descent import Curve, descend
from isoembed.nonlinear.stopping import settled
from isoembed.progress.stages import StageRecorder


def minimize_energy(
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
        Energy of a metric in Euclidean space.
    vertices : ndarray, shape (V, 3)
    lengths : ndarray, shape (E,)
    mu : float
    recorder : StageRecorder
        Recorder of the steps.
    is_done : callable
        Whether a surface is good enough, or the budget is exhausted.

    Returns
    -------
    ndarray, shape (V, 3)
    """

    def step(x: Floats) -> Curve[Floats]:
        r = energy.residuals(x, lengths)
        gradient = energy.forces(x, lengths, r) + mu * energy.roughness(x, 0.0)
        recorder.iterations += 1

        def damped(w: float) -> Floats:
            return x - energy.solver(x, lengths, mu, w, r / lengths)(gradient)

        return damped

    return descend(
        vertices,
        step,
        Damping(1.0, tries=12),  # weight of K beside R
        value=lambda x: energy.value(x, lengths, mu),
        converged=settled(0.001),  # at the minimum
        max_iterations=30,
        exhausted=is_done,
    ).point
