"""Expansion of outgoing light rays on a surface, linearized in displacements of the surface.

At each point the expansion is a function of the point and of the first and second derivatives of the surface,
linear in the second.  Its linearization is a second-order differential operator.  The coefficients are
derivatives of that function: by the complex step, and by finite differences of the slice along displacements.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from isoembed.arrays import Floats
from isoembed.relativity.spacetimes.differences import SIXTH
from isoembed.relativity.spacetimes.jet import SurfaceFamily
from isoembed.relativity.spacetimes.local_geometry import ComplexFields, LocalGeometry, SliceFields
from isoembed.relativity.spacetimes.three_geometry import COMPLEX_STEP, Numbers

STEP = 1.0 / 256.0  # step of sixth-order differences along the displacement, in mean radii


@dataclass(frozen=True, eq=False)
class LinearizedExpansion:
    """Linearization of the expansion in f: ``second . Hess df + first . grad df + zeroth df``.

    Attributes
    ----------
    second : ndarray, shape (n, 3)
        Coefficients of the theta theta, theta phi (counted once) and phi phi derivatives.
    first : ndarray, shape (n, 2)
    zeroth : ndarray, shape (n,)
    tilt : ndarray, shape (n,)
        ``n_i D^i``, the normal displacement of the surface per unit of df.
    """

    second: Floats
    first: Floats
    zeroth: Floats
    tilt: Floats

    @property
    def scale(self) -> Floats:
        """Factors (n,) that scale the principal part to minus the Laplacian of the unit sphere on average."""
        return -2.0 / (self.second[:, 0] + self.second[:, 2])

    def applied(self, values: Floats, slopes: Floats, hessians: Floats) -> Floats:
        """Change (n, c) for functions with values (n, c), gradients (n, 2, c) and Hessians (n, 3, c)."""
        change = self.zeroth[:, None] * values
        for a in range(2):
            change += self.first[:, a, None] * slopes[:, a]
        for ab in range(3):
            change += self.second[:, ab, None] * hessians[:, ab]
        return change


def extent(x: Floats) -> float:
    """Root-mean-square distance of points (n, 3) from their mean."""
    return float(np.sqrt(np.mean(np.sum((x - x.mean(axis=0)) ** 2, axis=1))))


def linearized(family: SurfaceFamily, local: LocalGeometry) -> LinearizedExpansion:
    """Linearized expansion of a surface in a slice, for displacements in a family."""
    D, surface, fields = family.direction, local.jet, local.fields
    assert isinstance(fields, SliceFields)
    tilt = np.einsum("ni,ni->n", local.normal[0], D.x)
    second = -local.inverse * np.array([1.0, 2.0, 1.0]) * tilt[:, None]
    i_step = 1j * COMPLEX_STEP

    def derivative(fields: SliceFields | ComplexFields, first: Numbers, bend: Numbers) -> Floats:
        moved = replace(surface, first=first, second=surface.second + i_step * bend)
        return np.asarray(LocalGeometry(fields, moved).expansion.imag / COMPLEX_STEP)

    slopes = []
    for a in range(2):
        turned = surface.first.astype(complex)
        turned[:, a] += i_step * D.x
        slopes.append(derivative(fields, turned, family.bend(a)))
    zeroth = derivative(_displaced(fields, D.x), surface.first + i_step * D.first, D.second)
    return LinearizedExpansion(second, np.stack(slopes, axis=1), zeroth, tilt)


def _displaced(fields: SliceFields, D: Floats) -> ComplexFields:
    """Fields of the slice at the complex points ``x + i eps D``."""
    x = fields.x
    h = STEP * extent(x)
    gradient, K = np.zeros_like(fields.gradient), np.zeros_like(fields.K)
    for steps, weight in enumerate(SIXTH, 1):
        for sign in (1.0, -1.0):
            there = SliceFields(fields.geometry, x + sign * steps * h * D)
            gradient += sign * weight / h * there.gradient
            K += sign * weight / h * there.K
    i_step = 1j * COMPLEX_STEP
    along = np.einsum("nk,nkij->nij", D, fields.gradient)
    return ComplexFields(
        fields.gamma + i_step * along, fields.gradient + i_step * gradient, fields.K + i_step * K
    )
