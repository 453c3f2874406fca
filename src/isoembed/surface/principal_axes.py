"""Principal axes of inertia, insensitive to rounding."""

import numpy as np

from isoembed.arrays import Floats

EQUAL = 1e-4  # relative difference of moments of inertia below which they count as equal
SAME = 1e-6  # relative difference below which skews and distances count as equal


def principal_axes(points: Floats, moments: Floats) -> Floats:
    """Right-handed axes of a centered body as columns, longest first.

    Rounding does not rotate them: of axes with equal moments, the first points to the farthest vertex; an
    axis points along the heavier tail or, if the tails are equal, to the side of the farthest vertex.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    moments : ndarray, shape (3, 3)
        Second moments of their distribution, or of another one with the same symmetry.
    """
    values, axes = np.linalg.eigh(moments)
    values, axes = values[::-1], axes[:, ::-1].copy()
    for k in range(2):
        equal = slice(k, 3 - int(np.sum(values[k] - values[k:] > EQUAL * values[k])))
        across = points @ axes[:, equal]
        farthest = across[_farthest(np.linalg.norm(across, axis=1))]
        if across.shape[1] > 1:
            turned, _ = np.linalg.qr(np.column_stack([farthest, np.eye(across.shape[1])]))
            axes[:, equal] @= turned
        if points_backward(points @ axes[:, k]):
            axes[:, k] *= -1.0
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    return axes


def points_backward(along: Floats) -> bool:
    """Whether the heavier tail of coordinates along an axis, (n,), or else the farthest one, is negative."""
    skew = (along**3).sum()
    tails_alike = abs(skew) <= SAME * (np.abs(along) ** 3).sum()
    return bool((along[_farthest(np.abs(along))] if tails_alike else skew) < 0)


def _farthest(distances: Floats) -> int:
    """First of the vertices that are farthest up to rounding."""
    return int(np.argmax(distances >= (1 - SAME) * distances.max()))
