"""Local geometry of a surface in a slice: its metric, normal, curvature and momentum."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from isoembed.arrays import Floats
from isoembed.relativity.spacetimes.checks import check_finite, check_slice
from isoembed.relativity.spacetimes.surface_jet import SurfaceJet
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry
from isoembed.smooth.two_metric import orthonormal_frame, projected


@dataclass(frozen=True)
class SurfaceFrame:
    """A surface in a slice at n directions u of the unit sphere that is mapped onto it.

    Attributes
    ----------
    geometry : ThreeGeometry
    u : ndarray, shape (n, 3)
    jet : SurfaceJet
        The map at u.
    center : ndarray, shape (3,)
        About which torques are.
    """

    geometry: ThreeGeometry
    u: Floats
    jet: SurfaceJet
    center: Floats

    @property
    def x(self) -> Floats:
        """The points (n, 3)."""
        return self.jet.x

    @cached_property
    def q(self) -> Floats:
        """The metric (n, 3, 3) that the slice induces."""
        return projected(self.jet.first.transpose(0, 2, 1) @ self._gamma @ self.jet.first, self.u)

    @cached_property
    def normal(self) -> tuple[Floats, Floats]:
        """The outward unit normal, ``n_i`` and ``n^i``, each (n, 3)."""
        lower = np.cross(self._images[:, 0], self._images[:, 1])
        upper = np.linalg.solve(self._gamma, lower[:, :, None])[:, :, 0]
        length = np.sqrt(np.einsum("ni,ni->n", lower, upper))[:, None]
        return lower / length, upper / length

    def mean_curvature(self) -> Floats:
        """``k = k1 + k2`` (n,).

        It is the trace of ``h_AB = -n_i (D_A D_B X^i + Gamma^i_jk X^j_A X^k_B)``, D the derivative of the
        unit sphere: another one would change the first term by a tangent vector.
        """
        lower, upper = self.normal
        inverse = self._e.transpose(0, 2, 1) @ self._e  # of q
        flat = np.einsum("ni,ni->n", lower, np.einsum("nijk,njk->ni", self.jet.second, inverse))
        gradient = check_finite("the gradient of the 3-metric", self.x, self.geometry.gradient(self.x))
        along = np.einsum("nkj,nkji->ni", self._tangent, gradient)
        across = np.einsum("nijk,njk->ni", gradient, self._tangent)
        return -flat - np.einsum("ni,ni->n", upper, along - 0.5 * across)

    @cached_property
    def curvature_along_normal(self) -> Floats:
        """``K_ij n^j`` (n, 3)."""
        return np.einsum("nij,nj->ni", self._extrinsic, self.normal[1])

    def momentum(self) -> Floats:
        """``p = K_ij (gamma^ij - n^i n^j)`` (n,)."""
        return np.einsum("nij,nij->n", self._tangent, self._extrinsic)

    def normal_momentum(self) -> Floats:
        """``K(., n)`` as tangent vectors (n, 3) of the unit sphere: see `SurfaceData`."""
        pulled = np.einsum("nki,nk->ni", self.jet.first, self.curvature_along_normal)
        return pulled - np.einsum("ni,ni->n", pulled, self.u)[:, None] * self.u

    def torque(self) -> Floats:
        """``K(e x (X - center), n)`` (n, 3), e the unit vectors along x, y and z: see `SurfaceData`."""
        return np.cross(self.x - self.center, self.curvature_along_normal)

    @cached_property
    def _gamma(self) -> Floats:
        gamma = self.geometry.metric(self.x)
        check_slice("the 3-metric", self.x, gamma)
        return gamma

    @cached_property
    def _extrinsic(self) -> Floats:
        return check_finite("the extrinsic curvature", self.x, self.geometry.extrinsic_curvature(self.x))

    @cached_property
    def _e(self) -> Floats:
        """Two tangent vectors of the unit sphere (n, 2, 3), orthonormal for q."""
        return orthonormal_frame(self.u, self.q)

    @cached_property
    def _images(self) -> Floats:
        """Their images (n, 2, 3) in the slice."""
        return self._e @ self.jet.first.transpose(0, 2, 1)

    @cached_property
    def _tangent(self) -> Floats:
        """``gamma^ij - n^i n^j`` (n, 3, 3)."""
        return self._images.transpose(0, 2, 1) @ self._images
