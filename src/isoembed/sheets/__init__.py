"""Surfaces with boundary, and of any genus: convex caps, given boundary curves, least bending."""
