"""Local geometry of a surface in a slice: induced metric, normal, mean curvature, momentum and expansion."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from isoembed.arrays import Floats
from isoembed.relativity.spacetimes.checks import check_finite, check_slice, check_symmetric
from isoembed.relativity.spacetimes.jet import Jet
from isoembed.relativity.spacetimes.three_geometry import Numbers, ThreeGeometry
from isoembed.smooth.two_metric import angle_frame, from_angles

ASYMMETRY = 1e-6  # largest relative difference of entries ij and ji attributed to rounding


@dataclass(frozen=True, eq=False)
class SliceFields:
    """3-metric, its gradient and K_ij of a slice at points x (n, 3), evaluated lazily.

    Each raises `InvalidMetric` or `InvalidParameter` outside the domain of the slice; the message names a
    point.
    """

    geometry: ThreeGeometry
    x: Floats

    @cached_property
    def gamma(self) -> Floats:
        """``gamma_ij`` (n, 3, 3)."""
        gamma = self.geometry.metric(self.x)
        check_slice("the 3-metric", self.x, gamma)
        check_symmetric("the 3-metric", self.x, gamma, ASYMMETRY * float(np.abs(gamma).max(initial=0.0)))
        return gamma

    @cached_property
    def gradient(self) -> Floats:
        """``d_k gamma_ij`` (n, 3, 3, 3), in the order [point, k, i, j]."""
        return check_finite("the gradient of the 3-metric", self.x, self.geometry.gradient(self.x))

    @cached_property
    def K(self) -> Floats:
        """``K_ij`` (n, 3, 3)."""
        if self.geometry.time_symmetric:
            return np.zeros((len(self.x), 3, 3))
        K = check_finite("the extrinsic curvature", self.x, self.geometry.extrinsic_curvature(self.x))
        # Rounding of gradients is relative to the metric per length, also in components that should vanish.
        size = float(np.abs(self.gamma).max(initial=0.0)) / float(np.abs(self.x).max(initial=0.0) or 1.0)
        allowed = ASYMMETRY * max(float(np.abs(K).max(initial=0.0)), 1e-6 * size)
        check_symmetric("the extrinsic curvature", self.x, K, allowed)
        return K


class ComplexFields(NamedTuple):
    """Fields of a slice at complex points, for complex-step derivatives."""

    gamma: Numbers
    gradient: Numbers
    K: Numbers


@dataclass(frozen=True, eq=False)
class LocalGeometry:
    """Local geometry of a surface in a slice at n directions, holomorphic in the slice and the jet.

    Attributes
    ----------
    fields : SliceFields or ComplexFields
        Fields at the points of the surface.
    jet : Jet
    """

    fields: SliceFields | ComplexFields
    jet: Jet

    @classmethod
    def of(cls, geometry: ThreeGeometry, jet: Jet) -> LocalGeometry:
        """Local geometry of a surface in a slice."""
        return cls(SliceFields(geometry, jet.x), jet)

    @property
    def q(self) -> Floats:
        """Induced metric (n, 3, 3), in the form of `isoembed.smooth.TwoMetric`."""
        return from_angles(self.jet.u, *(self._q * self._unit**2).T)

    @cached_property
    def density(self) -> Numbers:
        """Area density (n,) relative to the unit sphere."""
        return np.sqrt(self._determinant) * self._unit**2

    @property
    def inverse(self) -> Numbers:
        """Inverse of the induced metric (n, 3): theta theta, theta phi, phi phi."""
        return self._inverse / self._unit**2

    @cached_property
    def normal(self) -> tuple[Numbers, Numbers]:
        """Outward unit normal, ``n_i`` and ``n^i``, each (n, 3)."""
        lower = np.cross(self._first[:, 0], self._first[:, 1])
        upper = np.linalg.solve(self.fields.gamma, lower[:, :, None])[:, :, 0]
        norm = np.sqrt(np.einsum("ni,ni->n", lower, upper))[:, None]
        return lower / norm, upper / norm

    @cached_property
    def mean_curvature(self) -> Numbers:
        """``k = k1 + k2`` (n,).

        This is the trace of ``h_AB = -n_i (D_A D_B X^i + Gamma^i_jk X^j_A X^k_B)``, with D the connection of
        the unit sphere; another connection would change the first term by a tangent vector.
        """
        lower, upper = self.normal
        second, gradient = self.jet.second / self._unit**2, self.fields.gradient
        bent = np.einsum("na,nai,ni->n", self._inverse * np.array([1.0, 2.0, 1.0]), second, lower)
        along = np.einsum("njk,njki->ni", self._tangent, gradient)
        across = np.einsum("nijk,njk->ni", gradient, self._tangent)
        return -bent - np.einsum("ni,ni->n", upper, along - 0.5 * across)

    @cached_property
    def momentum(self) -> Numbers:
        """``p = K_ij (gamma^ij - n^i n^j)`` (n,)."""
        return np.einsum("nij,nij->n", self._tangent, self.fields.K)

    @cached_property
    def expansion(self) -> Numbers:
        """``theta_+ = k - p`` (n,) of outgoing light rays."""
        return self.mean_curvature - self.momentum

    def normal_momentum(self) -> Floats:
        """``K(., n)`` as tangent vectors (n, 3) of the unit sphere: see `SurfaceData`."""
        along = np.einsum("nai,ni->na", self.jet.first, self._curvature_along_normal)
        return np.einsum("na,nai->ni", along, np.stack(angle_frame(self.jet.u), axis=1))

    def torque(self, center: Floats) -> Floats:
        """``K(e x (X - center), n)`` (n, 3), e the unit vectors along x, y and z: see `SurfaceData`."""
        return np.cross(self.jet.x - center, self._curvature_along_normal)

    @cached_property
    def _curvature_along_normal(self) -> Floats:
        """``K_ij n^j`` (n, 3)."""
        return np.einsum("nij,nj->ni", self.fields.K, self.normal[1])

    @cached_property
    def _metric(self) -> tuple[Numbers, float]:
        """Induced metric (n, 3) as tt, tp, pp in a squared unit, and this unit.

        The unit is a power of two near the size of the surface, to avoid overflow and rounding.
        """
        q = (self.jet.first @ self.fields.gamma) @ self.jet.first.transpose(0, 2, 1)
        unit = 2.0 ** round(0.5 * np.log2(q.real.max()))
        return np.stack([q[:, 0, 0], q[:, 0, 1], q[:, 1, 1]], axis=1) / unit**2, unit

    @property
    def _q(self) -> Numbers:
        return self._metric[0]

    @property
    def _unit(self) -> float:
        return self._metric[1]

    @cached_property
    def _determinant(self) -> Numbers:
        tt, tp, pp = self._q.T
        return tt * pp - tp * tp

    @cached_property
    def _inverse(self) -> Numbers:
        tt, tp, pp = self._q.T
        return np.stack([pp, -tp, tt], axis=1) / self._determinant[:, None]

    @cached_property
    def _first(self) -> Numbers:
        return self.jet.first / self._unit

    @cached_property
    def _tangent(self) -> Numbers:
        """``gamma^ij - n^i n^j`` (n, 3, 3)."""
        (t, p), inverse = (self._first[:, 0], self._first[:, 1]), self._inverse
        mixed = t[:, :, None] * p[:, None, :]
        return (
            inverse[:, 0, None, None] * t[:, :, None] * t[:, None, :]
            + inverse[:, 1, None, None] * (mixed + mixed.transpose(0, 2, 1))
            + inverse[:, 2, None, None] * p[:, :, None] * p[:, None, :]
        )
