"""Tolerances for accepting realizations and for telling them apart."""

REALIZED = 1e-11  # mean edge lengths: the largest residual of a realization
SAME = 1e-7  # mean edge lengths: realizations within this distance are the same
NEARLY = 1e-6  # mean edge lengths: the largest residual of a surface that is near a realization
PLACED = 1e-10  # mean edge lengths: residual asked of the convex polyhedron
NEWTON_BASIN = 1e-6  # mean edge lengths: Newton's method does not get lost from here
