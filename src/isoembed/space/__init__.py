"""Euclidean, hyperbolic and spherical space: one curvature, its trigonometry, its points and its models."""

from isoembed.space.space import EUCLIDEAN, Euclidean, Hyperbolic, Space, Spherical

__all__ = ["EUCLIDEAN", "Euclidean", "Hyperbolic", "Space", "Spherical"]
