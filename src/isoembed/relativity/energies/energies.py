"""Hawking, Brown-York and Kijowski-Liu-Yau energies; Christodoulou mass from area, spin and charge.

Units are geometric, G = c = 1; ``k = k1 + k2`` in the slice, ``k0 = k1 + k2 = 2 H`` in Euclidean space,
``|H|^2 = k^2 - p^2`` the squared norm of the mean curvature vector.

======================  ============================================================================
irreducible mass        sqrt(A / 16 pi)
Christodoulou mass M    sqrt((m + Q^2 / 4 m)^2 + J^2 / 4 m^2), m the irreducible mass
dimensionless spin      J / M^2
Hawking energy          sqrt(A / 16 pi) (1 - int (k^2 - p^2) dA / 16 pi)
Brown-York energy       int (k0 - k) dA / 8 pi
Kijowski-Liu-Yau        int (k0 - sqrt(k^2 - p^2)) dA / 8 pi
======================  ============================================================================

References
----------
D. Christodoulou, R. Ruffini, Phys. Rev. D 4 (1971) 3552; S. Hawking, J. Math. Phys. 9 (1968) 598;
J. D. Brown, J. W. York, Phys. Rev. D 47 (1993) 1407; J. Kijowski, Gen. Rel. Grav. 29 (1997) 307;
C.-C. M. Liu, S.-T. Yau, Phys. Rev. Lett. 90 (2003) 231102.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from isoembed.arrays import Floats
from isoembed.reprs import short_repr
from isoembed.surface.estimate import Estimate

ROUNDING = 1e-14  # relative rounding error of an energy


@short_repr
@dataclass(frozen=True)
class Integrals:
    """Integrals over a surface that determine its energies.

    Attributes
    ----------
    area : Estimate
        int dA.
    reference : Estimate, optional
        int k0 dA = 2 int H dA, for the embedding in Euclidean space.
    k : Estimate, optional
        int k dA.
    norm : Estimate, optional
        int sqrt(k^2 - p^2) dA.
    squared : Estimate, optional
        int (k^2 - p^2) dA.
    """

    area: Estimate
    reference: Estimate | None = None
    k: Estimate | None = None
    norm: Estimate | None = None
    squared: Estimate | None = None


@short_repr
@dataclass(frozen=True)
class Energies:
    """Area, int H dA and energies with their errors; None for undefined numbers.

    Attributes
    ----------
    area : Estimate
    integrated_mean_curvature : Estimate or None
        None without an embedding.
    irreducible_mass : Estimate
    christodoulou_mass : Estimate or None
        None if the angular momentum is not known, or the surface is not a horizon.
    dimensionless_spin : Estimate or None
        J over the square of the Christodoulou mass.
    hawking, brown_york, liu_yau : Estimate or None
    notes : tuple of str
        Reasons for missing numbers, and remarks on their interpretation.
    """

    area: Estimate
    integrated_mean_curvature: Estimate | None
    irreducible_mass: Estimate
    christodoulou_mass: Estimate | None
    dimensionless_spin: Estimate | None
    hawking: Estimate | None
    brown_york: Estimate | None
    liu_yau: Estimate | None
    notes: tuple[str, ...] = ()

    @classmethod
    def of(
        cls,
        integrals: Integrals,
        *,
        angular_momentum: Estimate | float | None = None,
        charge: float = 0.0,
        notes: tuple[str, ...] = (),
    ) -> Energies:
        """Energies of a surface from its integrals.

        Parameters
        ----------
        integrals : Integrals
        angular_momentum : Estimate or float, optional
            J, in units of length^2.
        charge : float
            Q, in units of length.
        notes : tuple of str
            Notes to keep.
        """
        A, reference = integrals.area, integrals.reference
        m = np.sqrt(A.value / (16.0 * np.pi))
        irreducible = Estimate(m, 0.5 * m * (A.error / A.value))
        christodoulou = dimensionless = None
        if angular_momentum is not None:
            J = (
                angular_momentum
                if isinstance(angular_momentum, Estimate)
                else Estimate(angular_momentum, 0.0)
            )
            christodoulou, dimensionless = _with_spin(irreducible, J, charge)
        hawking = None
        if integrals.squared is not None:
            fraction = integrals.squared.scaled(1.0 / (16.0 * np.pi))
            value = m * (1.0 - fraction.value)
            hawking = Estimate(value, m * fraction.error + abs(1.0 - fraction.value) * irreducible.error)
        brown_york, liu_yau = (
            None if reference is None or part is None else (reference - part).scaled(1.0 / (8.0 * np.pi))
            for part in (integrals.k, integrals.norm)
        )
        imc = reference and reference.scaled(0.5)
        return cls(A, imc, irreducible, christodoulou, dimensionless, hawking, brown_york, liu_yau, notes)

    @property
    def error_estimate(self) -> float:
        """Largest error of the energies, in the unit of mass."""
        return max(
            e.error
            for name in ("irreducible_mass", "christodoulou_mass", "hawking", "brown_york", "liu_yau")
            if (e := getattr(self, name)) is not None
        )

    @property
    def report(self) -> dict[str, Any]:
        """Plain numbers, for JSON: the values by name, ``errors`` by name, and ``error_estimate``."""
        estimates = {f.name: getattr(self, f.name) for f in fields(self) if f.name != "notes"}
        return {
            **{name: e and e.value for name, e in estimates.items()},
            "errors": {name: e and e.error for name, e in estimates.items()},
            "error_estimate": self.error_estimate,
            "notes": list(self.notes),
        }


def _with_spin(irreducible: Estimate, J: Estimate, charge: float) -> tuple[Estimate, Estimate]:
    """Christodoulou mass M, and J / M^2."""
    m = irreducible.value
    rest, spin = m + charge**2 / (4.0 * m), J.value / (2.0 * m)
    M = float(np.hypot(rest, spin))
    slope = (rest * (1.0 - charge**2 / (4.0 * m**2)) - spin**2 / m) / M  # of M along m
    steep = spin / (2.0 * m * M)  # along J
    # These vanish for extreme and zero spin; the second order and rounding remain.
    shrunk, turned = irreducible.error / m, J.error / (2.0 * m * M)
    error = abs(slope) * irreducible.error + abs(steep) * J.error + (shrunk**2 + 0.5 * turned**2) * M
    mass = Estimate(M, error + ROUNDING * M)
    ratio = J.value / M / M
    error = abs(2.0 * ratio * slope / M) * irreducible.error
    error += abs(1.0 - 2.0 * ratio * M * steep) / M * (J.error / M)
    return mass, Estimate(ratio, error + 2.0 * (shrunk + turned) ** 2 + ROUNDING)


def norm_hindrance(
    k: Floats, squared: Floats, place: Callable[[int], str], allowed: tuple[float, float] = (0.0, 0.0)
) -> str:
    """Sentence on why ``sqrt(k^2 - p^2)`` cannot be integrated; empty if it can.

    Parameters
    ----------
    k, squared : ndarray, shape (n,)
        k and ``k^2 - p^2`` at points of the surface.
    place : callable
        Takes an index i and returns a description of the i-th point.
    allowed : tuple of float
        Magnitudes of negative k and ``k^2 - p^2`` that count as rounding.
    """
    for name, values, lower, kind in (
        ("k^2 - p^2", squared, -allowed[1], "spacelike there"),
        ("k", k, -allowed[0], "spacelike and outward everywhere"),
    ):
        i = int(np.argmin(values))
        if values[i] < lower:
            return (
                f"{name} = {values[i]:.3g} < 0 at {place(i)}: the mean curvature vector is not {kind}, and "
                "there is no Kijowski-Liu-Yau energy"
            )
    return ""
