"""Surfaces with boundary and of any genus: convex caps, boundary value problems, least bending."""
