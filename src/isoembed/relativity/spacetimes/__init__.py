"""Slices of spacetime, in closed form or on grids, and the surfaces in them."""
