"""Nonlinear iteration: Newton, Gauss-Newton and Levenberg-Marquardt methods, and continuation.

One loop, `descend`, goes from point to point along curves that a problem supplies: for Newton's and the
Gauss-Newton method the parameter of a curve is the fraction of a step, for Levenberg-Marquardt the damping.
An acceptance rule chooses the parameter, a stopping rule ends the loop, and a `Solution` says why it ended.
"""

from isoembed.nonlinear.acceptance import FULL_STEPS, Damping, LineSearch, contraction
from isoembed.nonlinear.continuation import extrapolated, penalty_continuation
from isoembed.nonlinear.descent import Curve, Reason, Solution, descend
from isoembed.nonlinear.newton import Point, damped_step, largest, newton
from isoembed.nonlinear.stopping import Stop, below, never, settled, short_step, stagnated

__all__ = ["FULL_STEPS", "Curve", "Damping", "LineSearch", "Point", "Reason", "Solution", "Stop", "below"]
__all__ += ["contraction", "damped_step", "descend", "extrapolated", "largest", "never", "newton"]
__all__ += ["penalty_continuation", "settled", "short_step", "stagnated"]
