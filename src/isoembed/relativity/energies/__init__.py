"""Quasi-local energies of surfaces, each with an error."""
