"""Mass and spin multipoles of an axisymmetric horizon.

With zeta the invariant coordinate and R the areal radius, the geometric multipoles [1]_ are
``I_n = 1/2 int K Y_n0(zeta) dA`` and ``L_n = -int Im Psi_2 Y_n0(zeta) dA``, where ``2 Im Psi_2`` is the
curl of the rotation one-form.  That is ``-K(., n)`` but for a gradient, and by parts L_n takes no derivative
of it: ``L_n = R^-2 / 2 int K(phi, n) Y_n0'(zeta) dA`` with the rotation phi that belongs to zeta.

References
----------
.. [1] A. Ashtekar, J. Engle, T. Pawlowski and C. Van Den Broeck, "Multipole moments of isolated horizons",
   Class. Quantum Grav. 21 (2004) 2549.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial import legendre

from isoembed.arrays import Floats
from isoembed.relativity.horizons.invariant_coordinate import (
    FEWEST_NODES,
    GROWTH,
    MOST_NODES,
    InvariantCoordinate,
)
from isoembed.relativity.spacetimes.surface_data import SurfaceData
from isoembed.reprs import short_repr
from isoembed.smooth.spectral_curvature import spectral_curvature
from isoembed.smooth.two_metric import area_density
from isoembed.smooth.uncertain import UncertainFunction
from isoembed.surface.estimate import Estimate

ORDER = 8  # of the highest multipole
STEEPER = 0.125  # growth, over l^2, of the error that uncertain lengths make
ROUNDING = 5e-14  # in a geometric multipole


@short_repr
@dataclass(frozen=True)
class Multipoles:
    """Multipoles n = 0, ..., 8 of a horizon.

    Attributes
    ----------
    shape : tuple of Estimate
        I_n, of the Gaussian curvature; I_0 = sqrt(pi), and I_1 = 0 where there is a symmetry.
    rotation : tuple of Estimate or None
        L_n; None where the normal momentum is not known.  L_0 = 0.
    mass : tuple of Estimate or None
        ``M_n = sqrt(4 pi / (2 n + 1)) M R^n / (2 pi) I_n``, M_0 = M the Christodoulou mass.
    spin : tuple of Estimate or None
        ``J_n = sqrt(4 pi / (2 n + 1)) R^(n + 1) / (4 pi) L_n``, J_1 = J.
    """

    shape: tuple[Estimate, ...]
    rotation: tuple[Estimate, ...] | None
    mass: tuple[Estimate, ...] | None
    spin: tuple[Estimate, ...] | None

    @classmethod
    def of(cls, data: SurfaceData, zeta: InvariantCoordinate) -> Multipoles:
        """The multipoles of a horizon with an invariant coordinate."""
        K = spectral_curvature(data.metric, data.relative_error)
        most = 1000 if zeta.axisymmetric else MOST_NODES
        n, before = FEWEST_NODES, np.full((2, ORDER + 1), np.inf)
        while True:
            moments, area = _moments(data, zeta, K, n)
            change = np.abs(moments - before)
            if change.max() <= 1e-13 or GROWTH * n > most:  # change with more nodes
                break
            n, before = int(GROWTH * n), moments
        l = np.arange(ORDER + 1)
        # By parts twice; and what is only seen by higher multipoles is less certain than the mean.
        steep = l * (l + 1) * (1.0 + STEEPER * l**2)
        errors = change + ROUNDING + steep * (data.relative_error + zeta.error)
        errors[0] += K.error.mean * area
        if isinstance(data.normal_momentum, UncertainFunction):
            errors[1] += steep * np.pi * data.normal_momentum.error.mean
        return cls._scaled(data, np.sqrt(area / (4.0 * np.pi)), moments, errors)

    @classmethod
    def _scaled(cls, data: SurfaceData, R: float, moments: Floats, errors: Floats) -> Multipoles:
        """Multipoles from the geometric ones, as far as the mass and the spin are known.

        Their errors hold a displacement of the horizon from the surface, which changes all but J_1.
        """
        l = np.arange(len(moments[0]))
        displaced = l * (l + 1) * data.displacement
        shape, rotation = (_estimates(*pair) for pair in zip(moments, errors + displaced, strict=True))
        scale = np.sqrt(4.0 * np.pi / (2 * l + 1)) * R**l
        lengths = (l + 2) * (data.relative_error + ROUNDING)
        moved = (l + 1) * data.displacement
        spins = scale * R / (4.0 * np.pi) * moments[1]
        uncertain = scale * R / (4.0 * np.pi) * (errors[1] + np.where(l == 1, 0.0, displaced))
        uncertain += (lengths + np.where(l == 1, 0.0, moved)) * np.abs(spins)
        found = None if data.normal_momentum is None else _estimates(spins, uncertain)
        known = data.angular_momentum if found is None or data.charge else found[1].value
        if known is None:
            return cls(shape, None if found is None else rotation, None, found)
        m = 0.5 * R
        mass = np.hypot(m + data.charge**2 / (4.0 * m), known / (2.0 * m))
        masses = scale * mass / (2.0 * np.pi) * moments[0]
        of_mass = abs(known) / (2.0 * m * mass) * (uncertain[1] / (2.0 * m * mass))
        uncertain = scale * mass / (2.0 * np.pi) * (errors[0] + displaced)
        heavy = _estimates(masses, uncertain + (lengths + moved + of_mass) * np.abs(masses))
        if found is None and known != 0.0:
            return cls(shape, None, heavy, None)
        return cls(shape, rotation, heavy, found or rotation)

    @property
    def report(self) -> dict[str, Any]:
        """Plain numbers, for JSON."""
        named = {"I": self.shape, "L": self.rotation, "M": self.mass, "J": self.spin}
        return {
            **{name: found and [e.value for e in found] for name, found in named.items()},
            "errors": {name: found and [e.error for e in found] for name, found in named.items()},
        }


def _moments(
    data: SurfaceData, zeta: InvariantCoordinate, K: Callable[[Floats], Floats], n: int
) -> tuple[Floats, float]:
    """I_l and L_l (2, order + 1), and the area, from n heights of nodes."""
    u, weights = zeta.rule(n, 8 if zeta.axisymmetric else 2 * n)  # circles are orbits of the symmetry
    dA = weights * area_density(data.metric.tensor(u))
    value, gradient = zeta.derivatives(u)
    l = np.arange(ORDER + 1)
    norms = 0.5 * np.sqrt((2 * l + 1) / (4.0 * np.pi))
    shape = norms * ((dA * K(u)) @ legendre.legvander(value, l[-1]))
    if data.normal_momentum is None:
        return np.stack([shape, np.zeros(len(l))]), float(dA.sum())
    # phi dA is R^2 (grad zeta x u) on the unit sphere, whatever the metric.
    around = np.einsum("ni,ni->n", data.normal_momentum(u), np.cross(gradient, u))
    slopes = np.stack([legendre.legval(value, legendre.legder(row)) for row in np.eye(len(l))])
    return np.stack([shape, norms * (slopes @ (weights * around))]), float(dA.sum())


def _estimates(values: Floats, errors: Floats) -> tuple[Estimate, ...]:
    return tuple(Estimate(*pair) for pair in zip(values, errors, strict=True))
