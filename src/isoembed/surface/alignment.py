"""How far two placements of the same vertices are apart, rigid motions aside."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def distance(vertices: Floats, others: Floats) -> float:
    """The largest distance of a vertex from its other place, after the best rotation and translation.

    Best in least squares (Kabsch, Acta Cryst. A32, 1976).

    Parameters
    ----------
    vertices, others : ndarray, shape (V, 3)
    """
    x, y = vertices - vertices.mean(axis=0), others - others.mean(axis=0)
    left, _, right = np.linalg.svd(x.T @ y)
    proper = np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
    return float(np.linalg.norm(x @ (left @ proper @ right) - y, axis=1).max())
