"""The Wang-Yau energy E(tau) of one surface, with its first and second derivatives in the time function tau.

With |H|^2 = k^2 - p^2, W^2 = 1 + |grad tau|^2, S^2 = |H|^2 W^2 + (lap tau)^2 and theta the angle of
sinh theta = -lap tau / (|H| W),

    8 pi E(tau) = int k0 dA0 - int [ S + theta lap tau - alpha(grad tau) ] dA,

k0 and dA0 of the embedding in R^3 of the metric q + d tau d tau.  In the frame of the slice, with tanh psi =
p / k and j = K(., n), the connection of the normal bundle is alpha = j - d psi, and the derivative of psi is
thrown on tau: alpha(grad tau) becomes j(grad tau) + psi lap tau.

References
----------
M.-T. Wang and S.-T. Yau, Phys. Rev. Lett. 102 (2009) 021101; Commun. Math. Phys. 288 (2009) 919.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from isoembed.errors import InvalidParameter
from isoembed.relativity.energies.time_function import TimeFunction
from isoembed.relativity.spacetimes.surface_data import SurfaceData
from isoembed.smooth.embedding import SmoothEmbedding
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.isometry import IsometrySystem, MetricSamples, strains
from isoembed.smooth.transforms import resized

Floats = NDArray[np.float64]

DENSER = 1.6  # heights of nodes over degrees
NUDGE = 1e-5  # of the surface's size: differences of curvatures to ten digits


class Shape(NamedTuple):
    """What a map X makes of the surface, in frames that are orthonormal in q; pairs are 11, 12, 22."""

    k0: Floats  # (n,)
    stretch: Floats  # (n,) dA0 / dA
    conjugate: Floats  # (n, 3) stretch times k0 g^ab - h^ab
    curvature: Floats  # (n,) Gauss's


@dataclass(frozen=True)
class Functional:
    """E(tau) for tau in the harmonics of one basis, X in others.

    Attributes
    ----------
    system : IsometrySystem
        Of q: the equations for X at the nodes.
    first, second : ndarray, shapes (n, 2, size), (n, 3, size)
        The derivatives of the harmonics of X along the frames, the second ones covariant on the sphere.
    areas : ndarray, shape (n,)
    gradients : ndarray, shape (n, 2, m)
        Of tau's harmonics, without the constant one, along the frames.
    hessians : ndarray, shape (n, 3, m)
        Their covariant second derivatives in q.
    H, psi : ndarray, shape (n,)
        The norm of the mean curvature vector, and the angle between it and the normal in the slice.
    j : ndarray, shape (n, 2)
        K(., n) of the slice along the frames.
    """

    system: IsometrySystem
    first: Floats
    second: Floats
    areas: Floats
    gradients: Floats
    hessians: Floats
    H: Floats
    psi: Floats
    j: Floats

    @classmethod
    def of(
        cls,
        data: SurfaceData,
        embedding: SmoothEmbedding,
        at: TimeFunction,
        harmonics: Harmonics,
        tau: Harmonics,
    ) -> Functional:
        """Prepare the functional.

        Parameters
        ----------
        data : SurfaceData
            With the mean curvature.
        embedding : SmoothEmbedding
            Of ``q + d tau d tau`` for one tau.
        at : TimeFunction
            That tau.
        harmonics, tau : Harmonics
            Of X, and of the time functions.

        Raises
        ------
        InvalidParameter
            k is not given, or the mean curvature vector is not spacelike and outward; the message says where.
        """
        n = int(np.ceil(DENSER * (harmonics.degree + 1)))
        samples = MetricSamples.of(data.metric, n, 2 * n)
        u, e = samples.u, samples.frames
        k, p, j = _physical(data, u, e)
        X0 = resized(embedding.coefficients, embedding.harmonics, harmonics)
        first = harmonics.along(u, e)[1]
        second = _pairs(harmonics.second_along(u, e, np.eye(harmonics.size)))
        gradients = tau.along(u, e)[1][:, :, 1:]
        flat = _pairs(tau.second_along(u, e, np.eye(tau.size)))[:, :, 1:]
        # (tau, X0) has the metric q in Minkowski space: the tangent part of its second derivatives is how q's
        # derivative differs from that of the sphere.
        drift = np.einsum("npc,nac->npa", second @ X0, first @ X0)
        slope = at.harmonics.along(u, e)[1] @ at.coefficients
        bend = _pairs(at.harmonics.second_along(u, e, at.coefficients[:, None])[..., 0])
        drift -= bend[:, :, None] * slope[:, None, :]
        return cls(
            system=IsometrySystem.of(harmonics, samples),
            first=first,
            second=second,
            areas=samples.areas,
            gradients=gradients,
            hessians=flat - drift @ gradients,
            H=np.sqrt((k - p) * (k + p)),
            psi=np.arctanh(p / k),
            j=j,
        )

    def embedded(self, tau: Floats, start: Floats) -> Floats:
        """The coefficients (size, 3) of X for tau (m,), from those of a tau nearby."""
        return self.system.solved(start, self._stretch(tau))

    def misfit(self, tau: Floats, X: Floats) -> float:
        """The largest relative error of a length at the nodes."""
        off = np.abs(strains(self.first @ X) - self._stretch(tau)).max(axis=1)
        return 0.5 * float((off / self._fields(tau)[2] ** 2).max())

    def reference(self, X: Floats) -> float:
        """Int k0 dA0 / 8 pi."""
        shape = self.shape(X)
        return float(self.areas @ (shape.stretch * shape.k0)) / (8.0 * np.pi)

    def value(self, tau: Floats, X: Floats) -> float:
        """E(tau), with the coefficients of X for this tau."""
        shape = self.shape(X)
        slope, laplacian, _, S, theta = self._fields(tau)
        physical = S + (theta - self.psi) * laplacian - np.einsum("na,na->n", self.j, slope)
        return float(self.areas @ (shape.stretch * shape.k0 - physical)) / (8.0 * np.pi)

    def gradient(self, tau: Floats, X: Floats) -> Floats:
        """The derivatives (m,) of E; X changes with tau, but int k0 dA0 by its conjugate alone."""
        slope, _, W, S, theta = self._fields(tau)
        flow = _applied(self.shape(X).conjugate, slope) - (S / W**2)[:, None] * slope + self.j
        gradient = np.einsum("n,na,nam->m", self.areas, flow, self.gradients)
        gradient -= (self.areas * (theta - self.psi)) @ _traces(self.hessians)
        return np.asarray(gradient / (8.0 * np.pi))

    def hessian(self, tau: Floats, X: Floats) -> Floats:
        """The second derivatives (m, m) of E; X follows tau by the linearized isometry equations."""
        slope, laplacian, W, S, _ = self._fields(tau)
        P, A = self.gradients, self.areas
        total = np.einsum("n,nam,nal->ml", A, _applied(self.shape(X).conjugate, P), P, optimize=True)
        if np.any(tau):
            total += self._following(slope, X)
        dW = np.einsum("na,nam->nm", slope, P) / W[:, None]
        turn = _traces(self.hessians) - (laplacian / W)[:, None] * dW  # -S d theta
        total += (turn.T * (A / S)) @ turn
        weight = A * S / W**2
        total -= np.einsum("n,nam,nal->ml", weight, P, P, optimize=True) - (dW.T * weight) @ dW
        return np.asarray(0.5 * (total + total.T) / (8.0 * np.pi))

    def least_admissible(self, tau: Floats, X: Floats) -> float:
        """The least ``K + det D^2 tau / W^2`` at the nodes; tau is admissible if it is positive."""
        W2 = self._fields(tau)[2] ** 2
        return float((self.shape(X).curvature * W2).min())

    def shape(self, X: Floats) -> Shape:
        """Curvatures of the map with these coefficients, (size, 3)."""
        X1, X2 = np.moveaxis(self.first @ X, 1, 0)
        g11, g12, g22 = ((a * b).sum(axis=1) for a, b in ((X1, X1), (X1, X2), (X2, X2)))
        normals = np.cross(X1, X2)
        stretch = np.linalg.norm(normals, axis=1)
        h11, h12, h22 = -np.einsum("npc,nc->pn", self.second @ X, normals / stretch[:, None])
        det = stretch**2
        k0 = (g22 * h11 - 2.0 * g12 * h12 + g11 * h22) / det
        # k0 g^ab - h^ab is the matrix of cofactors of h, over det g.
        conjugate = np.stack([h22, -h12, h11], axis=1) / stretch[:, None]
        return Shape(k0, stretch, conjugate, (h11 * h22 - h12**2) / det)

    def _stretch(self, tau: Floats) -> Floats:
        """What d tau d tau adds to the metric, as strains."""
        g1, g2 = (self.gradients @ tau).T
        return np.stack([g1**2, np.sqrt(2.0) * g1 * g2, g2**2], axis=1)

    def _following(self, slope: Floats, X: Floats) -> Floats:
        """What the change of X with tau adds to the second derivatives of int k0 dA0."""
        g1, g2 = slope.T[:, :, None]
        P1, P2 = self.gradients[:, 0], self.gradients[:, 1]
        strains = np.stack([2.0 * g1 * P1, np.sqrt(2.0) * (g1 * P2 + g2 * P1), 2.0 * g2 * P2], axis=1)
        changes = self.system.deformations(X, np.moveaxis(strains, 2, 0))
        sizes = np.abs(changes).max(axis=(1, 2))
        added = np.empty((self.gradients.shape[2],) * 2)
        for m, (change, size) in enumerate(zip(changes, sizes, strict=True)):
            step = NUDGE * self.system.unit / size
            ahead, behind = (self.shape(X + s * change).conjugate for s in (step, -step))
            flow = _applied((ahead - behind) / (2.0 * step), slope)
            added[m] = np.einsum("n,na,nal->l", self.areas, flow, self.gradients)
        return added

    def _fields(self, tau: Floats) -> tuple[Floats, Floats, Floats, Floats, Floats]:
        """The gradient (n, 2) and the Laplacian of tau, W, S and theta (n,)."""
        slope, laplacian = self.gradients @ tau, _traces(self.hessians) @ tau
        W = np.sqrt(1.0 + (slope**2).sum(axis=1))
        theta = -np.arcsinh(laplacian / (self.H * W))
        return slope, laplacian, W, np.hypot(self.H * W, laplacian), theta


def _physical(data: SurfaceData, u: Floats, frames: Floats) -> tuple[Floats, Floats, Floats]:
    """What the data say of k, p (n,) and, along the frames (n, 2), of K(., n)."""
    if data.mean_curvature is None:
        raise InvalidParameter("the Wang-Yau energy needs the mean curvature k of the surface")
    if data.marginal:
        raise InvalidParameter(
            "the mean curvature vector of a horizon has no norm: only tau = 0 has a Wang-Yau energy, which "
            "is that of Kijowski, Liu and Yau"
        )
    if data.momentum is not None and data.normal_momentum is None:
        raise InvalidParameter("with a momentum, the Wang-Yau energy needs the normal_momentum K(., n), too")
    k = data.mean_curvature(u)
    p = np.zeros(len(u)) if data.momentum is None else data.momentum(u)
    worst = int(np.argmin(k - np.abs(p)))
    if not k[worst] > abs(p[worst]):
        theta, phi = np.arccos(u[worst, 2]), np.arctan2(u[worst, 1], u[worst, 0]) % (2.0 * np.pi)
        raise InvalidParameter(
            f"k = {k[worst]:.4g} does not exceed |p| = {abs(p[worst]):.4g} at theta = {theta:.3f}, "
            f"phi = {phi:.3f}: the Wang-Yau energy needs a spacelike, outward mean curvature vector"
        )
    if data.normal_momentum is None:
        return k, p, np.zeros((len(u), 2))
    return k, p, np.einsum("nai,ni->na", frames, data.normal_momentum(u))


def _pairs(tensors: Floats) -> Floats:
    """The components 11, 12, 22 of symmetric tensors (n, 2, 2, ...), (n, 3, ...)."""
    return np.stack([tensors[:, 0, 0], tensors[:, 0, 1], tensors[:, 1, 1]], axis=1)


def _traces(pairs: Floats) -> Floats:
    return np.asarray(pairs[:, 0] + pairs[:, 2])


def _applied(pairs: Floats, vectors: Floats) -> Floats:
    """Symmetric tensors (n, 3) times vectors (n, 2) or (n, 2, m)."""
    a, b, c = (part.reshape(-1, *(1,) * (vectors.ndim - 2)) for part in pairs.T)
    v, w = vectors[:, 0], vectors[:, 1]
    return np.stack([a * v + b * w, b * v + c * w], axis=1)
