"""Nonlinear iteration: Newton, Gauss-Newton and Levenberg-Marquardt methods, and continuation.

One loop, `descend`, goes from point to point along curves that a problem supplies: for Newton's and the
Gauss-Newton method the parameter of a curve is the fraction of a step, for Levenberg-Marquardt the damping.
An acceptance rule chooses the parameter, a stopping rule ends the loop, and a `Solution` says why it ended.
"""

from isoembed.nonlinear.acceptance import FULL_STEPS, Damping, LineSearch, contraction
from isoembed.nonlinear.continuation import extrapolated, penalty_continuation
from isoembed.nonlinear.damped_step import damped_step
from isoembed.nonlinear.descent import Curve, Reason, Solution, descend
from isoembed.nonlinear.newton import Point, largest, newton
from isoembed.nonlinear.stopping import below, never, settled, short_step, stagnated

__all__ = [
    "FULL_STEPS",
    "Curve",
    "Damping",
    "LineSearch",
    "Point",
    "Reason",
    "Solution",
    "below",
    "contraction",
    "damped_step",
    "descend",
    "extrapolated",
    "largest",
    "never",
    "newton",
    "penalty_continuation",
    "settled",
    "short_step",
    "stagnated",
]
