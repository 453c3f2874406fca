"""Surfaces that differ by a function: ``X = X_0 + f D`` for fixed X_0 and D, to second order at nodes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats
from isoembed.smooth.sphere_transform import SphereTransform
from isoembed.smooth.two_metric import angle_frame


@dataclass(frozen=True, eq=False)
class Jet:
    """A map of the unit sphere into space, to second order at n directions.

    Attributes
    ----------
    value : ndarray, shape (n, 3)
    first : ndarray, shape (n, 2, 3)
        Derivatives along e_theta and e_phi.
    second : ndarray, shape (n, 3, 3)
        Covariant second derivatives on the unit sphere: theta theta, theta phi, phi phi.
    """

    value: Floats
    first: Floats
    second: Floats

    @classmethod
    def directions(cls, u: Floats) -> Jet:
        """The identity, ``X(u) = u``."""
        curved = np.zeros((len(u), 3, 3))
        curved[:, 0] = curved[:, 2] = -u
        return cls(u, np.stack(angle_frame(u), axis=1), curved)

    @classmethod
    def of(cls, transform: SphereTransform, coefficients: Floats) -> Jet:
        """A map by its coefficients (size, 3), at the nodes of the transform."""
        return cls(
            transform.values(coefficients),
            transform.gradients(coefficients),
            transform.hessians(coefficients),
        )


@dataclass(frozen=True, eq=False)
class SurfaceFamily:
    """The surfaces ``X = base + f direction``, f a function on the sphere.

    Attributes
    ----------
    base, direction : Jet
    """

    base: Jet
    direction: Jet

    @classmethod
    def star(cls, center: Sequence[float], u: Floats) -> SurfaceFamily:
        """Star-shaped surfaces: f is the radius."""
        n = len(u)
        base = Jet(np.broadcast_to(np.array(center), (n, 3)), np.zeros((n, 2, 3)), np.zeros((n, 3, 3)))
        return cls(base, Jet.directions(u))

    def at(self, f: Floats, slope: Floats, hessian: Floats) -> Jet:
        """The surface of a function f (n,) with derivatives (n, 2) and (n, 3), as `Jet` has them."""
        X, D = self.base, self.direction
        return Jet(
            X.value + f[:, None] * D.value,
            X.first + f[:, None, None] * D.first + slope[:, :, None] * D.value[:, None, :],
            X.second
            + f[:, None, None] * D.second
            + hessian[:, :, None] * D.value[:, None, :]
            + self.bend(0) * slope[:, 0, None, None]
            + self.bend(1) * slope[:, 1, None, None],
        )

    def bend(self, a: int) -> Floats:
        """By what the second derivatives (n, 3, 3) change with the a-th derivative of f."""
        first = self.direction.first
        bend = np.zeros_like(self.direction.second)
        bend[:, 2 * a] = 2.0 * first[:, a]
        bend[:, 1] = first[:, 1 - a]
        return bend
