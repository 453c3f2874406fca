"""The embedding flow of Jasiulek and Korzynski (2012): from the round sphere along a conformal path.

Theirs: Ricci flow leads from the given metric g to a round one, which makes them conformal; from the embedded
round sphere the surface flows back along a path of conformal metrics, its velocity at every time being the
solution of the linearized embedding equation, found spectrally.  They reduce that equation to an elliptic
one, which takes the inverse of the extrinsic curvature and thus K > 0.

Here Newton's method finds the conformal factor that they get by Ricci flow (`uniformization`); the path is
``g(t) = e^{2 (1 - t) u} g``, t from 0 to 1, along which K > 0 if it is at the ends; the linearized equation
``2 X_(a . Xdot_b) = gdot_ab`` is solved for the harmonics' coefficients in least squares, which inverts
no curvature; and the time steps are fixed Runge-Kutta ones.  As in theirs nothing corrects the surface: what
the steps miss of the lengths stays.

References
----------
M. Jasiulek and M. Korzynski, Isometric embeddings of 2-spheres by embedding flow for applications in
numerical relativity, Class. Quantum Grav. 29 (2012) 155010, arXiv:1111.6523.
"""

from dataclasses import replace

import numpy as np

from isoembed import InvalidParameter
from isoembed.smooth import TwoMetric
from reproduction.arrays import Floats
from reproduction.baselines.isometry import IsometrySystem, strains
from reproduction.baselines.spherical_harmonics import HarmonicMap
from reproduction.baselines.uniformization import RoundSphere

STAGES = {
    1: ((0.0, 1.0),),
    2: ((0.0, 0.0), (0.5, 1.0)),
    4: ((0.0, 1.0 / 6.0), (0.5, 1.0 / 3.0), (0.5, 1.0 / 3.0), (1.0, 1.0 / 6.0)),
}
"""Times and weights of Euler's, the midpoint and the classical rule, by order; stages follow one another."""


def embedding_flow(metric: TwoMetric, start: RoundSphere, steps: int, order: int = 4) -> HarmonicMap:
    """Flow from the round sphere to the surface with the given metric.

    Parameters
    ----------
    metric : TwoMetric
        Of positive curvature, for the method to be the published one; where K < 0 nothing is promised.
    start : RoundSphere
        From `reproduction.baselines.uniformization.uniformized`; its harmonics are those of the surface.
    steps : int
        Of the same length in t.
    order : {1, 2, 4}
        Of the Runge-Kutta rule: Euler's, the midpoint or the classical one.

    Returns
    -------
    HarmonicMap
        With the number of steps as its iterations.

    Raises
    ------
    InvalidParameter
        There is no rule of this order, or there are no steps.
    """
    if order not in STAGES:
        raise InvalidParameter(f"the order is {order!r}, not one of 1, 2 and 4")
    if steps < 1:
        raise InvalidParameter(f"the number of steps is {steps}, but at least 1 is needed")
    system = IsometrySystem.of(metric, start.harmonics)
    u = system.Y @ start.factors[1:] + start.factors[0] / np.sqrt(4.0 * np.pi)

    def velocity(t: float, C: Floats) -> Floats:
        """The change of X, without a rotation, that changes the metric as d/dt of g(t) demands."""
        scale = np.exp((1.0 - t) * u)
        here = replace(system, B=system.B / scale[:, None, None], root=system.root * scale)
        rates = -2.0 * np.stack([u, np.zeros_like(u), u], axis=1)
        return here.deformation(C, rates)

    C, h = start.coefficients, 1.0 / steps
    for step in range(steps):
        k, change = np.zeros_like(C), np.zeros_like(C)
        for time, weight in STAGES[order]:
            k = velocity((step + time) * h, C + time * h * k)
            change += weight * k
        C = C + h * change
    residuals = strains(system.B @ (C[1:] / system.unit))
    strain = float(np.sqrt(np.sum(system.root[:, None] ** 2 * residuals**2)))
    return HarmonicMap(start.harmonics, C, strain, steps, start.settled)
