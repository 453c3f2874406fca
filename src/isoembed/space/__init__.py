"""Spaces of constant curvature: Euclidean, hyperbolic and spherical."""

from isoembed.space.space import EUCLIDEAN, Euclidean, Hyperbolic, Space, Spherical

__all__ = ["EUCLIDEAN", "Euclidean", "Hyperbolic", "Space", "Spherical"]
