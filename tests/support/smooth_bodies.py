"""Good triangulations of smooth bodies, each made once, and how far apart two surfaces are."""

from functools import cache

import numpy as np

from isoembed.gallery import Drum, Ellipsoid, triangulate
from isoembed.progress.stages import Log, StageRecorder


@cache
def ellipsoid(n=200):
    """The paper's, with axes 3, 2, 1: (vertices, faces)."""
    return triangulate(Ellipsoid((3, 2, 1)), n)


@cache
def drum(n=400):
    """The paper's: (vertices, faces)."""
    return triangulate(Drum(), n)


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
