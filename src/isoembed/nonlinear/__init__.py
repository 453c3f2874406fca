"""Nonlinear iteration: Newton, Gauss-Newton and Levenberg-Marquardt methods, and continuation.

One loop, `descend`, goes from point to point along curves that a problem supplies: for Newton's and the
Gauss-Newton method the parameter of a curve is the fraction of a step, for Levenberg-Marquardt the damping.
An acceptance rule chooses the parameter, a stopping rule ends the loop, and a `Solution` says why it ended.
"""
