"""Horizons of a whole evolution, each with its own slice: what is read of which moment, and embedded."""
