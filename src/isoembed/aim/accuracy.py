"""Tolerances of realizations."""

REALIZED = 1e-11  # mean edge lengths: the largest residual of a realization
SAME = 1e-7  # mean edge lengths: realizations as near as this are one
NEWTON_BASIN = 1e-6  # mean edge lengths: Newton's method does not get lost from here
