"""Horizons from files: formats of simulation codes, and the shapes that they hold."""
