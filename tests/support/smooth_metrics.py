"""Smooth metrics on the sphere whose curvature and geodesics are known."""

import numpy as np

from isoembed.smooth.two_metric import AngleMetric, PulledBack

WARP = 0.2


def warp(u):
    """A map of the sphere to itself that takes great circles to no great circles."""
    x, y, z = u.T
    v = u + WARP * np.stack([y**2, z * x, x**2 - y * z], axis=1)
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def warp_differential(u):
    x, y, z = u.T
    v = u + WARP * np.stack([y**2, z * x, x**2 - y * z], axis=1)
    D = np.zeros((len(u), 3, 3)) + np.eye(3)
    D[:, 0, 1] += 2 * WARP * y
    D[:, 1, 2] += WARP * x
    D[:, 1, 0] += WARP * z
    D[:, 2, 0] += 2 * WARP * x
    D[:, 2, 1] -= WARP * z
    D[:, 2, 2] -= WARP * y
    size = np.linalg.norm(v, axis=1)[:, None]
    v /= size
    return (D - v[:, :, None] * np.einsum("nj,njk->nk", v, D)[:, None, :]) / size[:, :, None]


ROUND = PulledBack(warp_differential)
"""The round unit sphere in coordinates that do not show it."""


def ellipsoid(*axes):
    A = np.diag(np.array(axes, dtype=float))
    return PulledBack(lambda u: np.broadcast_to(A, (len(u), 3, 3)))


def kerr_surface(spin, epsilon=None):
    """The horizon of a black hole of mass 1; with epsilon its distorted ergosphere (paper, section 3.2)."""

    def components(theta, phi):
        a2, s, c2 = spin**2, np.sin(theta) ** 2, np.cos(theta) ** 2
        R, slope, Delta = 1 + np.sqrt(1 - a2), 0.0, 1.0
        if epsilon is not None:
            W = np.sqrt(1 - a2 + a2 * s)
            R, slope, Delta = 1 + W + epsilon, a2 / (2 * W), a2 * s + epsilon * (2 * W + epsilon)
        Sigma = R**2 + a2 * c2
        return Sigma * (1 + 4 * s * c2 * slope**2 / Delta), 0.0, (R**2 + a2 + a2 * s * 2 * R / Sigma) * s

    return AngleMetric(components)


class Dented:
    """The round metric, changed about the north pole along the circles of latitude."""

    def __init__(self, change):
        self.change = change

    def tensor(self, u):
        q = np.eye(3) - u[:, :, None] * u[:, None, :]
        e = np.cross(u, [0.0, 0.0, 1.0])
        e /= np.linalg.norm(e, axis=1, keepdims=True)
        q[u[:, 2] > 0.9] += self.change * (e[:, :, None] * e[:, None, :])[u[:, 2] > 0.9]
        return q
