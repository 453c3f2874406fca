"""Apparent horizons: finder, file formats, spin, multipoles, circumferences, stability."""
