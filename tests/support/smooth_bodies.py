"""Good triangulations of smooth bodies, each made once, and how far apart two surfaces are."""

from functools import cache

import numpy as np

from isoembed import PolyhedralMetric
from isoembed.gallery import Drum, Ellipsoid, HarmonicSurface, Sphere, triangulate
from isoembed.progress.stages import Log, StageRecorder


@cache
def ellipsoid(n=200):
    """The paper's, with axes 3, 2, 1: (vertices, faces)."""
    return triangulate(Ellipsoid((3, 2, 1)), n)


@cache
def drum(n=400):
    """The paper's: (vertices, faces)."""
    return triangulate(Drum(), n)


@cache
def dimpled(n, centers=((0.0, 0.0, 1.0),), depth=0.4, width=0.4):
    """The unit sphere less ``depth exp((u . c - 1) / width^2)`` for each center c: (vertices, faces)."""
    u, faces = triangulate(Sphere(), n)
    return u * (1 - depth * np.exp((u @ np.array(centers).T - 1) / width**2).sum(axis=1))[:, None], faces


def attempt_with_noise():
    """A metric in its own unit, the vertices of a saddle that has it, and these with noise."""
    vertices, faces = triangulate(HarmonicSurface(degree=2, order=2, amplitude=0.35), 100, irregular=1)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    noise = 0.02 * metric.mean_length * np.random.default_rng(0).normal(size=vertices.shape)
    return metric.normalized, vertices / metric.unit, (vertices + noise) / metric.unit


def recorder():
    """Counters that nobody watches."""
    return StageRecorder("test", Log())


def misfit(x, y):
    """Largest distance between vertices, over the size, after the best congruence, mirror images allowed."""
    x, y = x - x.mean(axis=0), y - y.mean(axis=0)
    size = np.abs(y).max()
    x, y = x / size, y / size
    left, _, right = np.linalg.svd(x.T @ y)
    return np.linalg.norm(x @ (left @ right) - y, axis=1).max()
