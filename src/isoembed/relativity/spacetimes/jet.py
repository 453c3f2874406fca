"""Second-order jets of maps of the unit sphere, and families of maps parametrized by a function."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats
from isoembed.relativity.spacetimes.three_geometry import Numbers
from isoembed.smooth.sphere_transform import SphereTransform
from isoembed.smooth.two_metric import angle_frame


@dataclass(frozen=True, eq=False)
class Jet:
    """Second-order jet of a map X of the unit sphere at n directions.

    Attributes
    ----------
    u : ndarray, shape (n, 3)
        Directions.
    x : ndarray, shape (n, 3)
        Images of the directions.
    first : ndarray, shape (n, 2, 3)
        Derivatives along e_theta and e_phi of `isoembed.smooth.two_metric.angle_frame`; complex for the
        complex-step method.
    second : ndarray, shape (n, 3, 3)
        Covariant second derivatives on the unit sphere: theta theta, theta phi, phi phi.
    """

    u: Floats
    x: Floats
    first: Numbers
    second: Numbers

    @classmethod
    def of_tensors(cls, u: Floats, x: Floats, differential: Floats, hessian: Floats) -> Jet:
        """Jet from covariant derivatives along tangent vectors, (n, 3, 3) and (n, 3, 3, 3).

        ``differential @ v`` is the derivative along v, ``v . hessian[:, i] @ w`` the second one of X_i.
        """
        return cls(u, x, *in_angle_frame(u, differential, hessian))

    @classmethod
    def at_nodes(cls, transform: SphereTransform, coefficients: Floats) -> Jet:
        """Jet of a map with coefficients (size, 3) at the nodes of a transform."""
        T, c = transform, coefficients
        return cls(T.u, T.values(c), T.gradients(c), T.hessians(c))

    def __getitem__(self, part: slice) -> Jet:
        return Jet(self.u[part], self.x[part], self.first[part], self.second[part])

    def scaled(self, factor: float) -> Jet:
        """Jet of X times a factor."""
        return Jet(self.u, factor * self.x, factor * self.first, factor * self.second)


@dataclass(frozen=True, eq=False)
class SurfaceFamily:
    """Family of surfaces ``X = base + f direction``, with f a function on the sphere.

    Attributes
    ----------
    base, direction : Jet
    """

    base: Jet
    direction: Jet

    @classmethod
    def star(cls, center: Sequence[float], u: Floats) -> SurfaceFamily:
        """Star-shaped surfaces, with f the radius."""
        n = len(u)
        base = Jet(u, np.broadcast_to(np.array(center), (n, 3)), np.zeros((n, 2, 3)), np.zeros((n, 3, 3)))
        curved = np.zeros((n, 3, 3))
        curved[:, 0] = curved[:, 2] = -u
        return cls(base, Jet(u, u, np.stack(angle_frame(u), axis=1), curved))

    def at(self, f: Floats, slope: Floats, hessian: Floats) -> Jet:
        """Surface of a function f (n,) with derivatives (n, 2) and (n, 3), ordered as in `Jet`."""
        X, D = self.base, self.direction
        return Jet(
            X.u,
            X.x + f[:, None] * D.x,
            X.first + f[:, None, None] * D.first + slope[:, :, None] * D.x[:, None, :],
            X.second
            + f[:, None, None] * D.second
            + hessian[:, :, None] * D.x[:, None, :]
            + self.bend(0) * slope[:, 0, None, None]
            + self.bend(1) * slope[:, 1, None, None],
        )

    def at_nodes(self, transform: SphereTransform, f: Floats) -> Jet:
        """Surface of a function with coefficients f (size,), at the nodes of a transform."""
        T, c = transform, f[:, None]
        return self.at(T.values(c)[:, 0], T.gradients(c)[:, :, 0], T.hessians(c)[:, :, 0])

    def bend(self, a: int) -> Floats:
        """Derivative of `second` (n, 3, 3) with respect to the a-th derivative of f."""
        first = self.direction.first
        bend = np.zeros_like(self.direction.second)
        bend[:, 2 * a] = 2.0 * first[:, a]
        bend[:, 1] = first[:, 1 - a]
        return bend


def in_angle_frame(u: Floats, gradient: Floats, hessian: Floats) -> tuple[Floats, Floats]:
    """Components of tangent gradients (n, c, 3) and Hessians (n, c, 3, 3), ordered as in `Jet`."""
    e = np.stack(angle_frame(u), axis=1)
    second = e[:, None] @ hessian @ e[:, None].transpose(0, 1, 3, 2)
    return e @ gradient.transpose(0, 2, 1), second[:, :, [0, 0, 1], [0, 1, 1]].transpose(0, 2, 1)
