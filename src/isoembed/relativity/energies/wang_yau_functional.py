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
from functools import cached_property
from typing import NamedTuple

import numpy as np

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter
from isoembed.relativity.energies.time_function import TimeFunction
from isoembed.relativity.spacetimes.surface_data import SurfaceData
from isoembed.smooth.embedding import SmoothEmbedding
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.isometry import IsometrySystem, MetricSamples, strains
from isoembed.smooth.transforms import resized
from isoembed.smooth.uncertain import Uncertainty
from isoembed.thresholds import threshold


@dataclass(frozen=True)
class FunctionalThresholds:
    """Thresholds of the Wang-Yau functional."""

    density: float = threshold(1.6, "relative", "Heights of nodes over the degree of the embedding.")
    step: float = threshold(
        1e-5, "radius of the area", "Step of differences of curvatures: ten digits are left."
    )


FUNCTIONAL = FunctionalThresholds()


class Shape(NamedTuple):
    """Geometry of a map X of the surface, in frames that are orthonormal in q; pairs are 11, 12, 22."""

    k0: Floats  # (n,)
    stretch: Floats  # (n,) dA0 / dA
    conjugate: Floats  # (n, 3) stretch times k0 g^ab - h^ab
    curvature: Floats  # (n,) Gauss's


@dataclass(frozen=True)
class Functional:
    """E(tau) for tau in the harmonics of one basis, X in others.

    Attributes
    ----------
    harmonics, time : Harmonics
        Of X, and of the time functions tau.
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

    harmonics: Harmonics
    time: Harmonics
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
        time: Harmonics,
    ) -> Functional:
        """The functional of a surface.

        Parameters
        ----------
        data : SurfaceData
            With the mean curvature.
        embedding : SmoothEmbedding
            Of ``q + d tau d tau`` for one tau.
        at : TimeFunction
            That tau.
        harmonics, time : Harmonics
            Of X, and of the time functions.

        Raises
        ------
        InvalidParameter
            k is not given, or the mean curvature vector is not spacelike and outward; the message says where.
        """
        n = int(np.ceil(FUNCTIONAL.density * (harmonics.degree + 1)))
        samples = MetricSamples.of(data.metric, n, 2 * n)
        u, e = samples.u, samples.frames
        k, p, j = _physical(data, u, e)
        X0 = resized(embedding.coefficients, embedding.harmonics, harmonics)
        first = harmonics.along(u, e)[1]
        second = _pairs(harmonics.second_along(u, e))
        gradients = time.along(u, e)[1][:, :, 1:]
        flat = _pairs(time.second_along(u, e))[:, :, 1:]
        # (tau, X0) has the metric q in Minkowski space: the tangent part of its second derivatives is how q's
        # derivative differs from that of the sphere.
        drift = np.einsum("npc,nac->npa", second @ X0, first @ X0)
        slope = at.harmonics.along(u, e)[1] @ at.coefficients
        bend = _pairs(at.harmonics.second_along(u, e, at.coefficients[:, None])[..., 0])
        drift -= bend[:, :, None] * slope[:, None, :]
        return cls(
            harmonics=harmonics,
            time=time,
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

    def embedded(self, tau: Floats, start: Floats) -> EmbeddedTime:
        """The embedding for tau (m,), from the coefficients (size, 3) of X for a tau nearby."""
        return EmbeddedTime(self, tau, self.system.solved(start, self.stretch(tau)))

    def stretch(self, tau: Floats) -> Floats:
        """Strains (n, 3) that d tau d tau adds to the metric."""
        g1, g2 = (self.gradients @ tau).T
        return np.stack([g1**2, np.sqrt(2.0) * g1 * g2, g2**2], axis=1)

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


@dataclass(frozen=True)
class EmbeddedTime:
    """A time function tau with its embedding X, and E(tau) with its derivatives.

    Attributes
    ----------
    functional : Functional
    tau : ndarray, shape (m,)
        Coefficients, without that of the constant.
    X : ndarray, shape (size, 3)
    """

    functional: Functional
    tau: Floats
    X: Floats

    @property
    def time_function(self) -> TimeFunction:
        """The time function, its constant harmonic being 0."""
        return TimeFunction(self.functional.time, np.concatenate([[0.0], self.tau]))

    @property
    def misfit(self) -> float:
        """The largest relative error of a length at the nodes."""
        off = strains(self.functional.first @ self.X) - self.functional.stretch(self.tau)
        return 0.5 * float((np.abs(off).max(axis=1) / self._fields[2] ** 2).max())

    @property
    def reference(self) -> float:
        """Int k0 dA0 / 8 pi."""
        return float(self.functional.areas @ (self._shape.stretch * self._shape.k0)) / (8.0 * np.pi)

    @cached_property
    def energy(self) -> float:
        """E(tau)."""
        f = self.functional
        slope, laplacian, _, S, theta = self._fields
        physical = S + (theta - f.psi) * laplacian - np.einsum("na,na->n", f.j, slope)
        return float(f.areas @ (self._shape.stretch * self._shape.k0 - physical)) / (8.0 * np.pi)

    @cached_property
    def gradient(self) -> Floats:
        """The derivatives (m,) of E; X changes with tau, but int k0 dA0 by its conjugate alone."""
        f = self.functional
        slope, _, W, S, theta = self._fields
        flow = _applied(self._shape.conjugate, slope) - (S / W**2)[:, None] * slope + f.j
        gradient = np.einsum("n,na,nam->m", f.areas, flow, f.gradients)
        gradient -= (f.areas * (theta - f.psi)) @ _traces(f.hessians)
        return np.asarray(gradient / (8.0 * np.pi))

    @cached_property
    def hessian(self) -> Floats:
        """The second derivatives (m, m) of E; X follows tau by the linearized isometry equations."""
        P, A = self.functional.gradients, self.functional.areas
        slope, laplacian, W, S, _ = self._fields
        total = np.einsum("n,nam,nal->ml", A, _applied(self._shape.conjugate, P), P, optimize=True)
        if np.any(self.tau):
            total += self._response(slope)
        dW = np.einsum("na,nam->nm", slope, P) / W[:, None]
        turn = _traces(self.functional.hessians) - (laplacian / W)[:, None] * dW  # -S d theta
        total += (turn.T * (A / S)) @ turn
        weight = A * S / W**2
        total -= np.einsum("n,nam,nal->ml", weight, P, P, optimize=True) - (dW.T * weight) @ dW
        return np.asarray(0.5 * (total + total.T) / (8.0 * np.pi))

    def error(self, k: Uncertainty, p: Uncertainty, j: Uncertainty) -> float:
        """Error of E(tau) by those of k, p and K(., n)."""
        f = self.functional
        slope, laplacian, W, _, _ = self._fields
        cosh, sinh = np.cosh(f.psi), np.abs(np.sinh(f.psi))
        norm = cosh * k.mean + sinh * p.mean
        # What averages out remains in squares.
        norm += 0.25 * (k.pointwise**2 + p.pointwise**2) / f.H
        angle = (cosh * p.mean + sinh * k.mean) / f.H
        total = W * norm + np.abs(laplacian) * angle + np.linalg.norm(slope, axis=1) * j.mean / f.system.unit
        return float(f.areas @ total) / (8.0 * np.pi)

    @property
    def admissible(self) -> float:
        """The least ``K + det D^2 tau / W^2`` at the nodes; tau is admissible if it is positive."""
        return float((self._shape.curvature * self._fields[2] ** 2).min())

    def _response(self, slope: Floats) -> Floats:
        """Part (m, m) of the second derivatives of int k0 dA0 that is due to the change of X with tau."""
        f = self.functional
        g1, g2 = slope.T[:, :, None]
        P1, P2 = f.gradients[:, 0], f.gradients[:, 1]
        strains = np.stack([2.0 * g1 * P1, np.sqrt(2.0) * (g1 * P2 + g2 * P1), 2.0 * g2 * P2], axis=1)
        changes = f.system.deformations(self.X, np.moveaxis(strains, 2, 0))
        sizes = np.abs(changes).max(axis=(1, 2))
        added = np.empty((len(self.tau),) * 2)
        for m, (change, size) in enumerate(zip(changes, sizes, strict=True)):
            step = FUNCTIONAL.step * f.system.unit / size
            ahead, behind = (f.shape(self.X + s * change).conjugate for s in (step, -step))
            flow = _applied((ahead - behind) / (2.0 * step), slope)
            added[m] = np.einsum("n,na,nal->l", f.areas, flow, f.gradients)
        return added

    @cached_property
    def _shape(self) -> Shape:
        return self.functional.shape(self.X)

    @cached_property
    def _fields(self) -> tuple[Floats, Floats, Floats, Floats, Floats]:
        """The gradient (n, 2) along the frames and the Laplacian of tau; W, S and theta (n,)."""
        f = self.functional
        slope, laplacian = f.gradients @ self.tau, _traces(f.hessians) @ self.tau
        W = np.sqrt(1.0 + (slope**2).sum(axis=1))
        return slope, laplacian, W, np.hypot(f.H * W, laplacian), -np.arcsinh(laplacian / (f.H * W))


def _physical(data: SurfaceData, u: Floats, frames: Floats) -> tuple[Floats, Floats, Floats]:
    """The curvature k and momentum p (n,) of the data and, along the frames (n, 2), K(., n)."""
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
