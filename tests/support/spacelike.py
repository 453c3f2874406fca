"""Surfaces whose Wang-Yau energy is known: of Minkowski space, and round ones of Schwarzschild's."""

from dataclasses import dataclass
from functools import cache

import numpy as np

from isoembed.meshing.sphere import gauss_rule
from isoembed.relativity import SurfaceData, TimeFunction
from isoembed.smooth import Harmonics, PulledBack, embed_smooth
from isoembed.smooth.two_metric import orthonormal_frame, projected


def directions(n=30):
    u = np.random.default_rng(5).normal(size=(n, 3))
    return u / np.linalg.norm(u, axis=1, keepdims=True)


def nothing(u):
    return np.zeros((len(u), 3))


def round_sphere(r, mass=1.0):
    """A sphere of this areal radius in the static slice of Schwarzschild's spacetime."""
    f = np.sqrt(1.0 - 2.0 * mass / r)
    metric = PulledBack(lambda u: np.tile(r * np.eye(3), (len(u), 1, 1)))
    return SurfaceData(metric, mean_curvature=lambda u: np.full(len(u), 2.0 * f / r))


@cache
def static():
    """The sphere r = 4 M, and its embedding."""
    data = round_sphere(4.0)
    return data, embed_smooth(data.metric, vertices=100)


@dataclass(frozen=True)
class Map:
    """A map to R^3 in harmonics, coefficients (size, 3)."""

    harmonics: Harmonics
    coefficients: np.ndarray

    def values(self, u):
        return self.harmonics.values(u) @ self.coefficients

    def gradient(self, u):
        return self.harmonics.gradients(u)[1] @ self.coefficients


@dataclass(frozen=True)
class Spacelike:
    """The surface (tau, X) of Minkowski space, tau and X (size, 3) in harmonics, as seen from R^3.

    The unit normal nu of X in R^3 and the unit normal N of the surface in the cylinder above X are the
    frame of its normal bundle: k = -<H, nu>, p = -<H, N>, j = <D nu, N>.
    """

    tau: TimeFunction
    X: Map

    def tensor(self, u):
        dX, g = self.X.gradient(u), self.tau.gradient(u)
        return projected(np.einsum("nic,njc->nij", dX, dX) - g[:, :, None] * g[:, None, :], u)

    def lying(self, u):
        """k, p (n,) and j (n, 3)."""
        e = orthonormal_frame(u, self.tensor(u))
        X = self.X.harmonics.along(u, e)[1] @ self.X.coefficients
        S = self.X.harmonics.second_along(u, e, self.X.coefficients)
        g = self.tau.harmonics.along(u, e)[1] @ self.tau.coefficients
        s = self.tau.harmonics.second_along(u, e, self.tau.coefficients[:, None])[..., 0]
        drift = np.einsum("nabk,nck->nabc", S, X) - s[..., None] * g[:, None, None, :]
        H = np.einsum("naak->nk", S - drift @ X[:, None])
        upward = np.einsum("naa->n", s - np.einsum("nabc,nc->nab", drift, g))
        normals = np.cross(X[:, 0], X[:, 1])
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        up = np.linalg.solve(np.einsum("nac,nbc->nab", X, X), g[:, :, None])[:, :, 0]
        W = np.sqrt(1.0 + (g**2).sum(axis=1))
        k = -(H * normals).sum(axis=1)
        p = W * (-upward + np.einsum("nk,na,nak->n", H, up, X))
        h = -np.einsum("nabk,nk->nab", S, normals)
        j = W[:, None] * np.einsum("nab,nb->na", h, up)
        dual = np.linalg.inv(np.concatenate([e, u[:, None]], axis=1))[:, :, :2]
        return k, p, np.einsum("nia,na->ni", dual, j)

    def data(self, sign=1.0):
        return SurfaceData(
            self,
            mean_curvature=lambda u: self.lying(u)[0],
            momentum=lambda u: self.lying(u)[1],
            normal_momentum=lambda u: sign * self.lying(u)[2],
        )


@cache
def minkowski():
    """A surface of Minkowski space, its data, and the embedding of its own metric."""
    harmonics = Harmonics(2, 2)
    u, weights = gauss_rule(6, 12)
    x, y, z = u.T
    X = u * [1.0, 1.2, 0.9] + 0.05 * np.stack([y * z, x**2, x * y], axis=1)
    tau = TimeFunction.of(lambda u: 0.3 * (u[:, 0] * u[:, 1] + 0.5 * u[:, 2] ** 2) + 0.1 * u[:, 0], 2)
    surface = Spacelike(tau, Map(harmonics, harmonics.values(u).T @ (weights[:, None] * X)))
    return surface, surface.data(), embed_smooth(surface, vertices=100)
