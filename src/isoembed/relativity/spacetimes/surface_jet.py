"""Maps of the unit sphere into a slice, to second order."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats


@dataclass(frozen=True)
class SurfaceJet:
    """A map X of the unit sphere to second order, at n directions u.

    Derivatives are covariant ones of the unit sphere, along tangent vectors: no direction is singular.

    Attributes
    ----------
    x : ndarray, shape (n, 3)
        The points.
    first : ndarray, shape (n, 3, 3)
        The differential dX: ``first @ v`` is the derivative along a tangent vector v.
    second : ndarray, shape (n, 3, 3, 3)
        ``v . second[:, i] @ w`` is the second derivative of X_i along the tangent vectors v and w.
    """

    x: Floats
    first: Floats
    second: Floats

    @classmethod
    def of_radius(cls, center: Floats, u: Floats, r: Floats, slope: Floats, hessian: Floats) -> SurfaceJet:
        """The map ``center + r(u) u``, of r (n,), its gradient (n, 3) and its Hessian (n, 3, 3)."""
        mixed = slope[:, None, :, None] * np.eye(3)[:, None, :]
        second = u[:, :, None, None] * (hessian - r[:, None, None] * np.eye(3))[:, None]
        second += mixed + mixed.transpose(0, 1, 3, 2)
        first = u[:, :, None] * slope[:, None, :] + r[:, None, None] * np.eye(3)
        return cls(center + r[:, None] * u, first, second)
