"""Values of the tolerances by which surfaces are realizations, and differ."""

REALIZED = 1e-11  # mean edge lengths: the largest residual of a realization
SAME = 1e-7  # mean edge lengths: realizations as near as this are one
NEARLY = 1e-6  # mean edge lengths: the largest residual between two realizations
PLACED = 1e-10  # mean edge lengths: residual asked of the convex polyhedron
NEWTON_BASIN = 1e-6  # mean edge lengths: Newton's method does not get lost from here
