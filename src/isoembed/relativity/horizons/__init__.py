"""Horizons: the finder, files of simulation codes, spin, multipoles, circumferences, stability."""
