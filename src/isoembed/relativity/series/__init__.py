"""Series: horizons of a whole evolution, embedded; readers for slices of Carpet, Chombo, AMReX, AthenaK."""
