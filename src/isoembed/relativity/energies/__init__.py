"""Quasi-local energies with error estimates."""
