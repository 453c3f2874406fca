"""Wang-Yau functional E(tau), with gradient and Hessian.

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

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter
from isoembed.relativity.energies.time_function import TimeFunction
from isoembed.relativity.spacetimes.surface_data import (
    SurfaceData,
    momentum_of,
    normal_momentum_of,
    values_of,
)
from isoembed.smooth.embedding import SmoothEmbedding
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.isometry import MetricSamples, strains
from isoembed.smooth.matrix_free import MatrixFreeIsometry
from isoembed.smooth.sphere_transform import SphereTransform
from isoembed.smooth.transforms import resized
from isoembed.smooth.two_metric import angle_frame
from isoembed.smooth.uncertain import Uncertainty


class Shape(NamedTuple):
    """Geometry of a map X of the surface, in orthonormal frames of q; pairs are 11, 12, 22."""

    k0: Floats  # (n,)
    stretch: Floats  # (n,) dA0 / dA
    conjugate: Floats  # (n, 3) stretch times k0 g^ab - h^ab
    curvature: Floats  # (n,) Gauss's


class Slope(NamedTuple):
    """Derivatives of a time function in q at the nodes, and the terms of E."""

    gradient: Floats  # (n, 2) along the frames
    laplacian: Floats  # (n,)
    W: Floats  # (n,)
    S: Floats  # (n,)
    theta: Floats  # (n,)


@dataclass(frozen=True)
class Functional:
    """Functional E(tau), for tau and X in harmonics of different degrees.

    Attributes
    ----------
    system : MatrixFreeIsometry
        Isometry equations for X.
    X, tau : SphereTransform
        Transforms of X and of the time functions, at the same n nodes.
    frames : ndarray, shape (n, 2, 2)
        Orthonormal frames of q, as components along e_theta and e_phi.
    areas : ndarray, shape (n,)
    drift : ndarray, shape (n, 2)
        The Laplacian in q is the trace of the sphere's second derivatives along the frames minus the product
        of this vector with the gradient.
    H, psi : ndarray, shape (n,)
        Norm of the mean curvature vector, and the angle between it and the normal in the slice.
    j : ndarray, shape (n, 2)
        K(., n) of the slice along the frames.
    """

    system: MatrixFreeIsometry
    X: SphereTransform
    tau: SphereTransform
    frames: Floats
    areas: Floats
    drift: Floats
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
        """Functional of a surface.

        Raises `InvalidParameter`: k is not given, or the mean curvature vector is not spacelike and outward;
        the message says where.

        Parameters
        ----------
        data : SurfaceData
            Surface with its mean curvature.
        embedding : SmoothEmbedding
            Embedding of ``q + d tau d tau`` for one tau.
        at : TimeFunction
            That tau.
        harmonics, time : Harmonics
            Harmonics of X and of the time functions.
        """
        # Twice the degree, to avoid aliasing.
        n = max(int(np.ceil(2.0 * (harmonics.degree + 1))), time.degree + 1)
        samples = MetricSamples.of(data.metric, n, 2 * n)
        k, p, j = physical(data, samples)
        frames = samples.frames @ np.stack(angle_frame(samples.u), axis=2)
        transform = SphereTransform(harmonics, n, 2 * n)
        system = MatrixFreeIsometry.of(transform, samples)
        start = SphereTransform(at.harmonics, n, 2 * n)
        slope = (frames @ start.gradients(at.coefficients[:, None]))[:, :, 0]
        # (tau, X0) has the metric q in Minkowski space: the tangential part of its second derivatives is the
        # difference of the connections of q and of the sphere.
        X0 = resized(embedding.coefficients, embedding.harmonics, harmonics)
        X0 = _nearer(system, frames, X0, _stretch(slope))
        trace = traced(frames, transform.hessians(X0))
        drift = np.einsum("nac,nc->na", frames @ transform.gradients(X0), trace)
        drift -= slope * traced(frames, start.hessians(at.coefficients[:, None]))
        return cls(
            system=system,
            X=transform,
            tau=SphereTransform(time, n, 2 * n),
            frames=frames,
            areas=samples.areas,
            drift=drift,
            H=np.sqrt((k - p) * (k + p)),
            psi=np.arctanh(p / k),
            j=j,
        )

    def with_time(self, harmonics: Harmonics) -> Functional:
        """Functional for time functions in other harmonics, of no higher degree."""
        return replace(self, tau=replace(self.tau, harmonics=harmonics))

    def embedded(self, tau: Floats, start: Floats) -> EmbeddedTime:
        """Embedding for tau (m,), from the coefficients (size, 3) of X for a nearby tau."""
        return EmbeddedTime(self, tau, self.system.solved(start, self.stretch(tau)))

    def stretch(self, tau: Floats) -> Floats:
        """Strains (n, 3) from the term d tau d tau of the metric."""
        return _stretch(self.gradient(tau))

    def gradient(self, tau: Floats) -> Floats:
        """Derivatives (n, 2) along the frames of tau (m,), without the constant harmonic."""
        return np.asarray((self.frames @ self.tau.gradients(_whole(tau)))[:, :, 0])

    def slope(self, tau: Floats) -> Slope:
        """Terms of E, for tau (m,)."""
        gradient = self.gradient(tau)
        laplacian = traced(self.frames, self.tau.hessians(_whole(tau)))[:, 0]
        laplacian -= np.einsum("na,na->n", self.drift, gradient)
        W = np.sqrt(1.0 + np.einsum("na,na->n", gradient, gradient))
        S = np.hypot(self.H * W, laplacian)
        return Slope(gradient, laplacian, W, S, -np.arcsinh(laplacian / (self.H * W)))

    def derivatives(self, flow: Floats, weight: Floats) -> Floats:
        """Integrals (m,) of a flow (n, 2) times gradients of harmonics, and weight (n,) times Laplacians."""
        flow = self.areas[:, None] * (flow - weight[:, None] * self.drift)
        first = np.einsum("na,nab->nb", flow, self.frames)
        second = (self.areas * weight)[:, None] * _trace_weights(self.frames)
        result = self.tau.adjoint_gradients(first[:, :, None])
        result += self.tau.adjoint_hessians(second[:, :, None])
        return np.asarray(result[1:, 0])

    def shape(self, X: Floats) -> Shape:
        """Curvatures of the map with coefficients X (size, 3)."""
        X1, X2 = np.moveaxis(self.tangents(X), 1, 0)
        g11, g12, g22 = ((a * b).sum(axis=1) for a, b in ((X1, X1), (X1, X2), (X2, X2)))
        normals = np.cross(X1, X2)
        stretch = np.linalg.norm(normals, axis=1)
        second = paired(self.frames, self.X.hessians(X))
        h11, h12, h22 = -np.einsum("npc,nc->pn", second, normals / stretch[:, None])
        det = stretch**2
        k0 = (g22 * h11 - 2.0 * g12 * h12 + g11 * h22) / det
        # k0 g^ab - h^ab is the cofactor matrix of h over det g.
        conjugate = np.stack([h22, -h12, h11], axis=1) / stretch[:, None]
        return Shape(k0, stretch, conjugate, (h11 * h22 - h12**2) / det)

    def tangents(self, X: Floats) -> Floats:
        """Derivatives (n, 2, 3) along the frames of the map with coefficients X (size, 3)."""
        return np.asarray(self.frames @ self.X.gradients(X))


@dataclass(frozen=True)
class EmbeddedTime:
    """Time function tau with its embedding X, and E(tau) with its first derivatives.

    Attributes
    ----------
    functional : Functional
    tau : ndarray, shape (m,)
        Coefficients, without that of the constant harmonic.
    X : ndarray, shape (size, 3)
    """

    functional: Functional
    tau: Floats
    X: Floats

    def refined(self) -> EmbeddedTime:
        """Embedding with a more accurate X after one more linear solve, if that improves it."""
        f = self.functional
        X = _nearer(f.system, f.frames, self.X, f.stretch(self.tau))
        return self if X is self.X else EmbeddedTime(f, self.tau, X)

    @property
    def time_function(self) -> TimeFunction:
        """Time function, with zero constant harmonic."""
        return TimeFunction(self.functional.tau.harmonics, _whole(self.tau)[:, 0])

    @cached_property
    def misfit(self) -> float:
        """Largest relative error of a length at the nodes."""
        (a, b, c), s = self._off.T, self.slope
        off = np.stack([a, b / np.sqrt(2.0), b / np.sqrt(2.0), c], axis=1).reshape(-1, 2, 2)
        # Inverse square root of the metric 1 + d tau d tau.
        root = (
            np.eye(2) - s.gradient[:, :, None] * s.gradient[:, None, :] / (s.W * (s.W + 1.0))[:, None, None]
        )
        return 0.5 * float(np.abs(np.linalg.eigvalsh(root @ off @ root)).max())

    @cached_property
    def reference(self) -> float:
        """Integral of k0 dA0 / 8 pi, corrected to first order in the metric error of X."""
        shape, off = self.shape, self._off
        correction = np.einsum("np,np->n", shape.conjugate * [1.0, np.sqrt(2.0), 1.0], off)
        return float(self.functional.areas @ (shape.stretch * shape.k0 - 0.5 * correction)) / (8.0 * np.pi)

    @cached_property
    def energy(self) -> float:
        """E(tau)."""
        f, s = self.functional, self.slope
        physical = s.S + (s.theta - f.psi) * s.laplacian - np.einsum("na,na->n", f.j, s.gradient)
        return self.reference - float(f.areas @ physical) / (8.0 * np.pi)

    @cached_property
    def gradient(self) -> Floats:
        """Gradient (m,) of E; the change of X with tau enters int k0 dA0 through the conjugate only."""
        f, s = self.functional, self.slope
        flow = applied(self.shape.conjugate, s.gradient) - (s.S / s.W**2)[:, None] * s.gradient + f.j
        return f.derivatives(flow, f.psi - s.theta) / (8.0 * np.pi)

    def error(self, k: Uncertainty, p: Uncertainty, j: Uncertainty) -> float:
        """Error of E(tau) from those of k, p and K(., n)."""
        f, s = self.functional, self.slope
        cosh, sinh = np.cosh(f.psi), np.abs(np.sinh(f.psi))
        norm = cosh * k.mean + sinh * p.mean
        # Noise that averages out remains in squares.
        norm += 0.25 * (k.pointwise**2 + p.pointwise**2) / f.H
        angle = (cosh * p.mean + sinh * k.mean) / f.H
        total = s.W * norm + np.abs(s.laplacian) * angle
        total += np.linalg.norm(s.gradient, axis=1) * j.mean / f.system.unit
        return float(f.areas @ total) / (8.0 * np.pi)

    @cached_property
    def admissible(self) -> float:
        """Least ``K + det D^2 tau / W^2`` at the nodes; tau is admissible if it is positive."""
        return float((self.shape.curvature * self.slope.W**2).min())

    @cached_property
    def _off(self) -> Floats:
        """Excess of the metric of X (n, 3), in the form of `strains`."""
        f = self.functional
        return strains(f.tangents(self.X)) - f.stretch(self.tau)

    @cached_property
    def shape(self) -> Shape:
        """Curvatures of X."""
        return self.functional.shape(self.X)

    @cached_property
    def slope(self) -> Slope:
        """Derivatives of tau."""
        return self.functional.slope(self.tau)


def physical(data: SurfaceData, samples: MetricSamples) -> tuple[Floats, Floats, Floats]:
    """Curvature k and momentum p (n,) of the data, and K(., n) along the frames of the metric (n, 2)."""
    u = samples.u
    if data.mean_curvature is None:
        raise InvalidParameter("the Wang-Yau energy needs the mean curvature k of the surface")
    k = values_of(data.mean_curvature, u, "the mean curvature")
    p = momentum_of(data, u)
    if data.normal_momentum is None and np.any(p):
        raise InvalidParameter("with a momentum, the Wang-Yau energy needs the normal_momentum K(., n), too")
    worst = int(np.argmin(k - np.abs(p)))
    if not k[worst] > abs(p[worst]):
        theta, phi = np.arccos(u[worst, 2]), np.arctan2(u[worst, 1], u[worst, 0]) % (2.0 * np.pi)
        raise InvalidParameter(
            f"k = {k[worst]:.4g} does not exceed |p| = {abs(p[worst]):.4g} at theta = {theta:.3f}, "
            f"phi = {phi:.3f}: the Wang-Yau energy needs a spacelike, outward mean curvature vector"
        )
    return k, p, np.einsum("nai,ni->na", samples.frames, normal_momentum_of(data, u))


def _nearer(system: MatrixFreeIsometry, frames: Floats, X: Floats, stretch: Floats) -> Floats:
    """Coefficients (size, 3) of a map with strains closer to a stretch, or X if it is accurate enough."""

    def off(X: Floats) -> Floats:
        return strains(frames @ system.transform.gradients(X)) - stretch

    before = off(X)
    if np.abs(before).max() <= 1e-12:  # relative error of lengths that needs no further solve
        return X
    nearer = X + system.deformations(X, -before[None])[0]
    return nearer if np.linalg.norm(off(nearer)) < np.linalg.norm(before) else X


def _stretch(gradient: Floats) -> Floats:
    """Strains (n, 3) from d tau d tau, for the gradient (n, 2) along frames."""
    g1, g2 = gradient.T
    return np.stack([g1**2, np.sqrt(2.0) * g1 * g2, g2**2], axis=1)


def _whole(tau: Floats) -> Floats:
    """Coefficients (size, 1) with a zero constant harmonic prepended."""
    return np.concatenate([[0.0], tau])[:, None]


def paired(frames: Floats, tensors: Floats) -> Floats:
    """Components 11, 12, 22 of symmetric tensors (n, 3, c) along frames (n, 2, 2)."""
    (a, b), (c, d) = frames.transpose(1, 2, 0)[..., None]
    tt, tp, pp = np.moveaxis(tensors, 1, 0)
    return np.stack(
        [
            a * a * tt + 2.0 * a * b * tp + b * b * pp,
            a * c * tt + (a * d + b * c) * tp + b * d * pp,
            c * c * tt + 2.0 * c * d * tp + d * d * pp,
        ],
        axis=1,
    )


def traced(frames: Floats, tensors: Floats) -> Floats:
    """Traces (n, c) over frames (n, 2, 2) of symmetric tensors (n, 3, c)."""
    return np.asarray(np.einsum("np,npc->nc", _trace_weights(frames), tensors))


def _trace_weights(frames: Floats) -> Floats:
    """Weights (n, 3) of the components of a symmetric tensor in its trace over frames."""
    first, second = frames[:, :, 0], frames[:, :, 1]
    parts = (first * first, 2.0 * first * second, second * second)
    return np.stack([part.sum(axis=1) for part in parts], axis=1)


def applied(pairs: Floats, vectors: Floats) -> Floats:
    """Symmetric tensors (n, 3) or (n, 3, m) times vectors (n, 2) or (n, 2, m)."""
    extra = (1,) * (vectors.ndim - pairs.ndim)
    a, b, c = (part.reshape(*part.shape, *extra) for part in np.moveaxis(pairs, 1, 0))
    v, w = vectors[:, 0], vectors[:, 1]
    return np.stack([a * v + b * w, b * v + c * w], axis=1)
