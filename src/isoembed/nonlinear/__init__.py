"""Nonlinear iteration: Newton, Gauss-Newton and Levenberg-Marquardt methods, and continuation.

A single loop, `descend`, moves along curves supplied by the problem: for Newton's and the Gauss-Newton method
the parameter of a curve is the fraction of a step, for Levenberg-Marquardt the damping.  An acceptance rule
chooses the parameter, a stopping rule ends the loop, and the `Solution` has the reason.
"""
