"""Spheres r = const of Kerr black holes with a cosmological constant: Kerr-de Sitter, Kerr-anti-de Sitter.

In Boyer-Lindquist coordinates (Carter 1968), with lambda = cosmological constant / 3, the curvature of the
de Sitter or anti-de Sitter space far away from the hole,

    Sigma = r^2 + a^2 cos^2, Delta = (r^2 + a^2) (1 - lambda r^2) - 2 m r,
    Theta = 1 + lambda a^2 cos^2, Xi = 1 + lambda a^2, A = (r^2 + a^2)^2 Theta - a^2 sin^2 Delta:

    g_rr = Sigma / Delta, g_thth = Sigma / Theta, g_phph = A sin^2 / (Sigma Xi^2),
    lapse^2 = Delta Theta Sigma / A, omega = a Xi ((r^2 + a^2) Theta - Delta) / A.

References
----------
B. Carter, Commun. Math. Phys. 10 (1968) 280; G. W. Gibbons, M. J. Perry, C. N. Pope, Class. Quantum Grav. 22
(2005) 1503, arXiv:hep-th/0408217.
"""

# ruff: noqa: N802, N806 (Sigma, Delta, Theta, Xi, A as the field writes them)
from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import isfinite
from typing import NamedTuple

import numpy as np
from numpy.polynomial import Polynomial
from scipy.optimize import brentq

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter
from isoembed.relativity.spacetimes.checks import make_finite
from isoembed.relativity.spacetimes.kerr import rotation_about_z, sin2
from isoembed.relativity.spacetimes.surface_data import SurfaceData
from isoembed.smooth.two_metric import from_angles

NOTE = "Hawking energy and Christodoulou mass are those of their formulas without a cosmological constant"


class _Terms(NamedTuple):
    """Functions of theta on a sphere, in units of the mass."""

    Sigma: Floats
    Theta: Floats
    A: Floats
    A_r: Floats


@dataclass(frozen=True)
class KerrDeSitterSphere:
    """Sphere r = const in the slice t = const, a `TwoMetric` in the Boyer-Lindquist angles.

    Attributes
    ----------
    r : float
        Boyer-Lindquist radius, at least that of the black hole horizon and, for a positive cosmological
        constant, at most that of the cosmological horizon; the areal radius if the spin is 0.
    mass : float
        Parameter m; the mass is m / Xi^2 (Gibbons, Perry and Pope).
    spin : float
        Parameter a, a length.
    cosmological_constant : float
        Cosmological constant in 1/length^2; negative for anti-de Sitter space.

    Raises
    ------
    InvalidParameter
        There is no such black hole, or the sphere is not outside it.
    """

    r: float
    mass: float = 1.0
    spin: float = 0.0
    cosmological_constant: float = 0.0

    def __post_init__(self) -> None:
        make_finite(self, "a sphere r = const")
        lower, upper = horizon_radii(self.mass, self.spin, self.cosmological_constant)
        if not lower * (1.0 - 1e-15) <= self.r <= upper:
            bound = f" and at most the cosmological horizon's {upper:.12g}" if isfinite(upper) else ""
            raise InvalidParameter(f"r must be at least r_+ = {lower:.12g}{bound}, not {self.r:.12g}")

    @classmethod
    def horizon(
        cls, mass: float = 1.0, spin: float = 0.0, cosmological_constant: float = 0.0
    ) -> KerrDeSitterSphere:
        """The outer horizon of the black hole."""
        return cls(horizon_radii(mass, spin, cosmological_constant)[0], mass, spin, cosmological_constant)

    @cached_property
    def marginal(self) -> bool:
        """Whether the sphere is the horizon."""
        horizon, _ = horizon_radii(self.mass, self.spin, self.cosmological_constant)
        return self.r <= horizon * (1.0 + 1e-15)

    @property
    def physical_mass(self) -> float:
        """Conserved mass m / Xi^2, the limit of energies of large spheres in anti-de Sitter space."""
        return self.mass / self._Xi**2

    @property
    def angular_momentum(self) -> float:
        """J = a m / Xi^2."""
        return self.spin * self.physical_mass

    def tensor(self, u: Floats) -> Floats:
        """The metric (n, 3, 3) at unit vectors u (n, 3), in units of length^2; see `TwoMetric`."""
        f = self._terms(u)
        q_tt, around = f.Sigma / f.Theta, f.A / f.Sigma / self._Xi**2
        return from_angles(u, q_tt, np.zeros(len(u)), around) * self.mass * self.mass

    def mean_curvature(self, u: Floats) -> Floats:
        """``k = k1 + k2`` (n,) in the slice, for the outward normal, at unit vectors u (n, 3); 1/length."""
        f = self._terms(u)
        # The normal sqrt(Delta / Sigma) d_r acts on ln sqrt(g_thth g_phph), a half of ln A.
        return np.asarray(np.sqrt(self._Delta / f.Sigma) * f.A_r / (2.0 * f.A) / self.mass)

    def normal_momentum(self, u: Floats) -> Floats:
        """``K(., n)`` of the slice as tangent vectors (n, 3) at u (n, 3): see `SurfaceData`.

        Of ``K_ij = -g_phph d_i(omega) / (2 lapse)`` for j = phi.
        """
        f, (r, a, _) = self._terms(u), self._numbers
        r2 = r * r + a * a
        lagging = r2 * f.Theta - self._Delta
        omega_r = a * self._Xi * ((2.0 * r * f.Theta - self._Delta_r) - lagging * f.A_r / f.A) / f.A
        around = -0.5 * f.A**1.5 * omega_r / (self._Xi**2 * f.Sigma**2 * np.sqrt(f.Theta))
        return around[:, None] * rotation_about_z(u)

    def data(self) -> SurfaceData:
        """Data for quasi-local energies; p is zero as without a cosmological constant."""
        surface = "horizon" if self.marginal else f"sphere r = {self.r:.9g}"
        of = "Kerr-anti-de Sitter" if self.cosmological_constant < 0.0 else "Kerr-de Sitter"
        return SurfaceData(
            metric=self,
            mean_curvature=self.mean_curvature,
            normal_momentum=self.normal_momentum if self.spin else None,
            angular_momentum=self.angular_momentum,
            marginal=self.marginal,
            name=(
                f"{of} {surface} of mass {self.mass:.9g}, spin {self.spin:.9g}, "
                f"cosmological constant {self.cosmological_constant:.9g}"
            ),
            notes=(NOTE,) if self.cosmological_constant else (),
        )

    @property
    def _numbers(self) -> tuple[float, float, float]:
        """r, a and lambda in units of the mass."""
        return self.r / self.mass, self.spin / self.mass, _curvature(self.mass, self.cosmological_constant)

    @property
    def _Xi(self) -> float:
        _, a, lam = self._numbers
        return 1.0 + lam * a * a

    @cached_property
    def _Delta(self) -> float:
        """Delta, exactly 0 on the horizon."""
        if self.marginal:
            return 0.0
        r, a, lam = self._numbers
        return max(0.0, float(_delta(a, lam)(r)))

    @property
    def _Delta_r(self) -> float:
        r, a, lam = self._numbers
        return float(_delta(a, lam).deriv()(r))

    def _terms(self, u: Floats) -> _Terms:
        r, a, lam = self._numbers
        s = sin2(u)
        c2, r2 = 1.0 - s, r * r + a * a
        Theta = 1.0 + lam * a * a * c2
        return _Terms(
            Sigma=r * r + a * a * c2,
            Theta=Theta,
            A=r2**2 * Theta - a * a * s * self._Delta,
            A_r=4.0 * r * r2 * Theta - a * a * s * self._Delta_r,
        )


def horizon_radii(mass: float, spin: float, cosmological_constant: float) -> tuple[float, float]:
    """Boyer-Lindquist radii of the black hole horizon and of the cosmological horizon, possibly infinite.

    Raises `InvalidParameter`: there is no black hole with these parameters.
    """
    if not mass > 0.0:
        raise InvalidParameter(f"mass must be positive, not {mass}")
    a, lam = spin / mass, _curvature(mass, cosmological_constant)
    if not 1.0 + lam * a * a > 0.0:
        raise InvalidParameter(
            f"spin must be below {(-lam) ** -0.5 * mass:.9g}, the radius of this anti-de Sitter space, "
            f"not {spin}"
        )
    Delta = _delta(a, lam)
    turns = np.asarray(Delta.deriv().roots(), dtype=np.complex128)
    there = (turns.real > 0.0) & (np.abs(turns.imag) <= 1e-12 * np.abs(turns))
    turns = np.sort(turns.real[there])  # minimum of Delta, and for lambda > 0 its maximum
    if turns.size != 1 + (lam > 0.0) or Delta(turns[0]) > 1e-14 or Delta(turns[-1]) * lam < 0.0:
        raise InvalidParameter(
            f"there is no horizon for spin {spin:.9g}, cosmological_constant {cosmological_constant:.9g} "
            f"and mass {mass:.9g}"
        )
    outward = float(turns[1]) if lam > 0.0 else 2.0
    inner = float(turns[0])
    black_hole = inner if Delta(inner) >= 0.0 else float(brentq(Delta, inner, outward, xtol=1e-300))
    cosmological = float(brentq(Delta, outward, lam**-0.5, xtol=1e-300)) if lam > 0.0 else np.inf
    return black_hole * mass, cosmological * mass


def _delta(a: float, lam: float) -> Polynomial:
    """Delta as a polynomial of r, in units of the mass."""
    return Polynomial([a * a, -2.0, 1.0 - lam * a * a, *((0.0, -lam) if lam else ())])


def _curvature(mass: float, cosmological_constant: float) -> float:
    """Lambda / 3 in units of the mass."""
    return cosmological_constant * mass * mass / 3.0
