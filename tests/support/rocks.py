"""Rocks: rough ellipsoids, and their lengths in whole millimeters."""

import numpy as np
from scipy.spatial import ConvexHull

from isoembed import PolyhedralMetric


def rock(seed, rough=3.0, n=80):
    """Vertices about an ellipsoid of 300 x 240 x 200 mm, off by white noise, and triangles between them."""
    rng, i = np.random.default_rng(seed), np.arange(n)
    z, phi = 1 - (2 * i + 1) / n, np.pi * (1 + 5**0.5) * i
    x = np.c_[np.sqrt(1 - z * z) * np.cos(phi), np.sqrt(1 - z * z) * np.sin(phi), z] * [150.0, 120.0, 100.0]
    faces = ConvexHull(x).simplices
    a, b, c = x[faces].swapaxes(0, 1)
    turned = np.einsum("fi,fi->f", np.cross(b - a, c - a), a + b + c) < 0
    faces[turned] = faces[turned][:, ::-1]
    return x + rough * rng.standard_normal(x.shape), faces


def in_millimeters(x, faces):
    exact = PolyhedralMetric.from_mesh(x, faces)
    return PolyhedralMetric(faces, np.round(exact.lengths), exact.edges)


ERROR = 1 / np.sqrt(12)
