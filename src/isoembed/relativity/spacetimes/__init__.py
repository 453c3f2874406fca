"""Slices of spacetime, in closed form or on grids, and surfaces in them."""
