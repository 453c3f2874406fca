"""How functions of this room are compiled."""

from numba import njit

kernel = njit(cache=True, error_model="numpy")
"""Decorator of functions that take half-edge structures whole.

A division by zero is infinite.  As an exception it would be another way out of a function, on which numba
counts the references to every array of a named tuple: to flip 100,000 vertices to Delaunay then takes 40 %
longer than with loose arrays.  As it is it takes as long, where named tuples do not hold named tuples.
"""
