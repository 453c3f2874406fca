"""The expansion of outgoing light rays on a surface, and how it changes with the surface.

At each point the expansion is a function of the point and of the first and second derivatives of the surface,
linear in the second.  So its linearization is a differential operator of second order whose coefficients are
derivatives of that function: by the complex step, and by differences of the slice along the displacement.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats
from isoembed.relativity.horizons.surface_family import Jet, SurfaceFamily
from isoembed.relativity.spacetimes.checks import check_finite, check_slice
from isoembed.relativity.spacetimes.three_geometry import COMPLEX_STEP, Numbers, ThreeGeometry

STEP = 1.0 / 256.0  # of differences of sixth order along the displacement, over the mean radius


@dataclass(frozen=True, eq=False)
class Fields:
    """The 3-metric (n, 3, 3), its gradient (n, 3, 3, 3) and K_ij (n, 3, 3) at points; see `ThreeGeometry`."""

    gamma: Numbers
    gradient: Numbers
    K: Numbers

    @classmethod
    def of(cls, geometry: ThreeGeometry, x: Floats) -> Fields:
        """Those of a slice at the points x (n, 3).

        Raises
        ------
        InvalidMetric, InvalidParameter
            A point lies where the slice is not known.
        """
        gamma = geometry.metric(x)
        check_slice("the 3-metric", x, gamma)
        gradient = check_finite("the gradient of the 3-metric", x, geometry.gradient(x))
        return cls(gamma, gradient, curvature_at(geometry, x))


def curvature_at(geometry: ThreeGeometry, x: Floats) -> Floats:
    """K_ij (n, 3, 3) at the points x (n, 3)."""
    if geometry.time_symmetric:
        return np.zeros((len(x), 3, 3))
    return check_finite("the extrinsic curvature", x, geometry.extrinsic_curvature(x))


@dataclass(frozen=True, eq=False)
class LocalSurface:
    """The geometry of a surface at its points, holomorphic in all that it is made of.

    Attributes
    ----------
    inverse : ndarray, shape (n, 3)
        The inverse of the induced metric: theta theta, theta phi, phi phi.
    density : ndarray, shape (n,)
        The area over that of the unit sphere.
    normal : ndarray, shape (n, 3)
        The outward unit normal n_i.
    expansion : ndarray, shape (n,)
    """

    inverse: Numbers
    density: Numbers
    normal: Numbers
    expansion: Numbers

    @classmethod
    def of(cls, fields: Fields, first: Numbers, second: Numbers) -> LocalSurface:
        """From the slice and the derivatives of the surface, as `Jet` has them."""
        lowered = first @ fields.gamma
        q = lowered @ first.transpose(0, 2, 1)
        tt, tp, pp = q[:, 0, 0], q[:, 0, 1], q[:, 1, 1]
        det = tt * pp - tp * tp
        inverse = np.stack([pp, -tp, tt], axis=1) / det[:, None]
        lower = np.cross(first[:, 0], first[:, 1])
        upper = np.linalg.solve(fields.gamma, lower[:, :, None])[:, :, 0]
        norm = np.sqrt(np.einsum("ni,ni->n", lower, upper))[:, None]
        lower, upper = lower / norm, upper / norm
        t, p = first[:, 0], first[:, 1]
        mixed = t[:, :, None] * p[:, None, :]
        tangent = (
            inverse[:, 0, None, None] * t[:, :, None] * t[:, None, :]
            + inverse[:, 1, None, None] * (mixed + mixed.transpose(0, 2, 1))
            + inverse[:, 2, None, None] * p[:, :, None] * p[:, None, :]
        )
        weights = inverse * np.array([1.0, 2.0, 1.0])
        bent = np.einsum("na,nai,ni->n", weights, second, lower)
        along = np.einsum("njk,njki->ni", tangent, fields.gradient)
        across = np.einsum("nijk,njk->ni", fields.gradient, tangent)
        k = -bent - np.einsum("ni,ni->n", upper, along - 0.5 * across)
        return cls(inverse, np.sqrt(det), lower, k - np.einsum("nij,nij->n", tangent, fields.K))


@dataclass(frozen=True, eq=False)
class LinearizedExpansion:
    """How the expansion changes when f does: ``second . Hess df + first . grad df + zeroth df``.

    Attributes
    ----------
    second : ndarray, shape (n, 3)
        For theta theta, theta phi (counted once) and phi phi.
    first : ndarray, shape (n, 2)
    zeroth : ndarray, shape (n,)
    tilt : ndarray, shape (n,)
        ``n_i D^i``: the surface moves outward by that times df.
    """

    second: Floats
    first: Floats
    zeroth: Floats
    tilt: Floats

    @property
    def scale(self) -> Floats:
        """Factors (n,) that make of the second derivatives a Laplacian of the unit sphere, in the mean."""
        return -2.0 / (self.second[:, 0] + self.second[:, 2])

    def applied(self, values: Floats, slopes: Floats, hessians: Floats) -> Floats:
        """The change (n, c) for functions with these derivatives, (n, c), (n, 2, c) and (n, 3, c)."""
        change = self.zeroth[:, None] * values
        for a in range(2):
            change += self.first[:, a, None] * slopes[:, a]
        for ab in range(3):
            change += self.second[:, ab, None] * hessians[:, ab]
        return change


def linearized(
    geometry: ThreeGeometry, family: SurfaceFamily, surface: Jet, fields: Fields, local: LocalSurface
) -> LinearizedExpansion:
    """The linearized expansion of a surface in a family.

    Parameters
    ----------
    geometry : ThreeGeometry
    family : SurfaceFamily
    surface : Jet
    fields, local : Fields, LocalSurface
        Those of the surface.
    """
    D = family.direction
    tilt = np.einsum("ni,ni->n", local.normal, D.value)
    second = -local.inverse * np.array([1.0, 2.0, 1.0]) * tilt[:, None]
    i_step = 1j * COMPLEX_STEP

    def derivative(fields: Fields, first: Numbers, bend: Numbers) -> Floats:
        moved = LocalSurface.of(fields, first, surface.second + i_step * bend)
        return np.asarray(moved.expansion.imag / COMPLEX_STEP)

    slopes = []
    for a in range(2):
        turned = surface.first.astype(complex)
        turned[:, a] += i_step * D.value
        slopes.append(derivative(fields, turned, family.bend(a)))
    there = _displaced(geometry, surface.value, D.value, fields)
    zeroth = derivative(there, surface.first + i_step * D.first, D.second)
    return LinearizedExpansion(second, np.stack(slopes, axis=1), zeroth, tilt)


def _displaced(geometry: ThreeGeometry, x: Floats, D: Floats, fields: Fields) -> Fields:
    """The slice at the points ``x + i eps D``."""
    size = np.sqrt(np.mean(np.sum((x - x.mean(axis=0)) ** 2, axis=1)))
    h = STEP * float(size)
    gradient, K = np.zeros_like(fields.gradient), np.zeros_like(fields.K)
    for steps, weight in ((1, 45.0 / 60.0), (2, -9.0 / 60.0), (3, 1.0 / 60.0)):
        for sign in (1.0, -1.0):
            moved = x + sign * steps * h * D
            there = check_finite("the gradient of the 3-metric", moved, geometry.gradient(moved))
            gradient += sign * weight / h * there
            K += sign * weight / h * curvature_at(geometry, moved)
    i_step = 1j * COMPLEX_STEP
    along = np.einsum("nk,nkij->nij", D, fields.gradient)
    return Fields(fields.gamma + i_step * along, fields.gradient + i_step * gradient, fields.K + i_step * K)
