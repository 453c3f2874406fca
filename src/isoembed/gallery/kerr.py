"""Kerr-Newman horizon and ergosphere as surfaces of revolution.

Section 3.2 of the paper with s = sin^2(theta) as the variable, in units of the mass.
"""

# ruff: noqa: N802, N806 (R, Sigma, Delta, P, Q are standard notation, also in the paper)
from abc import abstractmethod
from dataclasses import dataclass
from functools import cached_property
from math import hypot, sqrt
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.polynomial import Chebyshev

from isoembed.arrays import Floats
from isoembed.gallery.revolution import Profile, SurfaceOfRevolution
from isoembed.gallery.surface import option, positive


class Radius(NamedTuple):
    """R/M as a function of s, its first two derivatives with respect to s, and Delta/M^2, Eq. (delta)."""

    R: Floats
    R_s: Floats
    R_ss: Floats
    Delta: Floats


class Squares(NamedTuple):
    """The 2-metric in units of M: h_thth, P = h_phph / s and q^2 = (h_thth - rho_th^2) / s, Eq. (f).

    Derivatives are with respect to s. Where q^2 is negative, no surface of revolution exists.
    """

    h_thth: Floats
    P: Floats
    P_s: Floats
    P_ss: Floats
    q2: Floats
    q2_s: Floats


def horizon_radius(spin: float, charge: float, s: Floats) -> Radius:
    """Outer horizon r_+ for spin a and charge Q in units of the mass, a^2 + Q^2 <= 1."""
    r_plus = 1.0 + sqrt(max(0.0, 1.0 - hypot(spin, charge) ** 2))
    zero = np.zeros_like(s)
    return Radius(zero + r_plus, zero, zero, zero)


def ergosphere_radius(epsilon: float, spin: float, charge: float, s: Floats) -> Radius:
    """Distorted ergosphere, Eq. (rtheta), with charge; Delta is free of cancellation."""
    a2 = spin**2
    W = np.sqrt((1.0 - a2 - charge**2) + a2 * s)
    Delta = a2 * s + epsilon * (2.0 * W + epsilon)
    return Radius(1.0 + W + epsilon, a2 / (2.0 * W), -(a2**2) / (4.0 * W**3), Delta)


def smarr_limit(charge: float) -> float:
    """Largest spin, in units of the mass, for which the horizon with charge Q embeds in R^3."""
    # r_+ = 1 + sqrt(1 - a^2 - Q^2) >= sqrt(3) a, solved for a; always satisfied for Q^2 >= 2/3.
    Q2 = charge**2
    return (sqrt(3.0) + sqrt(3.0 - 4.0 * Q2)) / 4.0 if Q2 < 2.0 / 3.0 else sqrt(1.0 - Q2)


def squares(radius: Radius, spin: float, charge: float, s: Floats) -> Squares:
    """2-metric, Eq. (twosurf), of r = R(theta) at s = sin^2(theta); spin and charge in units of the mass."""
    a2, Q2 = spin**2, charge**2
    R, R_s, R_ss, Delta = radius
    c2 = 1.0 - s
    Sigma = R**2 + a2 * c2  # Eq. (sigma)
    Sigma_s = 2.0 * R * R_s - a2
    Sigma_ss = 2.0 * (R_s**2 + R * R_ss)
    m, m_s, m_ss = 2.0 * R - Q2, 2.0 * R_s, 2.0 * R_ss
    w = m / Sigma
    w_s = (m_s - w * Sigma_s) / Sigma
    w_ss = (m_ss - 2.0 * w_s * Sigma_s - w * Sigma_ss) / Sigma
    P = R**2 + a2 + a2 * s * w  # Eq. (gpp)
    P_s = 2.0 * R * R_s + a2 * (w + s * w_s)
    P_ss = Sigma_ss + a2 * (2.0 * w_s + s * w_ss)
    # q^2 = (h_thth - rho_th^2) / s, Eq. (f), with the 0/0 at the poles canceled analytically:
    # Sigma - P = -a^2 s (1 + w) and R_th^2 = 4 s c^2 R_s^2.
    if np.any(R_s):
        g = Sigma * R_s**2 / Delta
        g_s = (Sigma_s * R_s**2 + 2.0 * Sigma * R_s * R_ss - g * 2.0 * (R - 1.0) * R_s) / Delta
    else:  # a horizon has Delta = 0, and R_th = 0 removes the term
        g = g_s = np.zeros_like(s)
    f = P_s**2 / P
    f_s = (2.0 * P_s * P_ss - f * P_s) / P
    q2 = P - a2 * (1.0 + w) + c2 * (4.0 * g - 2.0 * P_s - s * f)
    q2_s = P_s - a2 * w_s - (4.0 * g - 2.0 * P_s - s * f) + c2 * (4.0 * g_s - 2.0 * P_ss - f - s * f_s)
    return Squares(Sigma + 4.0 * s * c2 * g, P, P_s, P_ss, q2, q2_s)


class KerrSurface(SurfaceOfRevolution):
    """A surface t = const, r = R(theta) of the Kerr-Newman geometry in Boyer-Lindquist coordinates.

    Directions are the Boyer-Lindquist angles. With the spin a and charge Q in units of the mass, the
    2-metric, Eq. (twosurf), is h_thth = Sigma (1 + R_th^2 / Delta) and h_phph = P sin^2(theta).
    """

    mass: float
    spin: float
    charge: float

    @abstractmethod
    def _R(self, s: Floats) -> Radius:
        """R and its derivatives, with Delta free of cancellation."""

    @property
    def _unit(self) -> float:
        return self.mass

    def _profile(self, s: Floats) -> Profile:
        spin, charge = self.spin / self.mass, self.charge / self.mass
        _, P, P_s, P_ss, q2, q2_s = squares(self._R(s), spin, charge, s)
        p = np.sqrt(P)
        p_s = P_s / (2.0 * p)
        q = np.sqrt(np.maximum(q2, 0.0))
        # q = 0 only at the poles of a horizon at its spin limit, where q_s is multiplied by s = 0.
        q_s = np.divide(q2_s, 2.0 * q, out=np.zeros_like(q), where=q > 0.0)
        return Profile(p, p_s, (P_ss - 2.0 * p_s**2) / (2.0 * p), q, q_s)

    @cached_property
    def _height_series(self) -> Chebyshev:
        """Antiderivative of sin(theta) q on [0, pi/2]: -z up to a constant."""
        degree, quarter = 32, [0.0, 0.5 * np.pi]
        while True:
            series = Chebyshev.interpolate(
                lambda theta: np.sin(theta) * self._profile(np.sin(theta) ** 2).q, degree, domain=quarter
            )
            tail = np.abs(series.coef[-4:]).max()
            if tail <= 1e-13 * np.abs(series.coef).max() or degree >= 1024:
                return series.integ()
            degree *= 2

    def _height(self, theta: Floats) -> Floats:
        return self._height_series(0.5 * np.pi) - self._height_series(theta)


@dataclass(frozen=True)
class KerrHorizon(KerrSurface):
    """The outer horizon r = r_+ of a Kerr-Newman black hole.

    It embeds while its curvature at the poles is nonnegative, r_+ >= sqrt(3) a (Smarr 1973):
    a <= sqrt(3)/2 M without charge.
    """

    name: ClassVar[str] = "kerr-horizon"
    mass: float = option(1.0, "mass M", positive)
    spin: float = option(0.5, "spin a, at most sqrt(3)/2 M without charge")
    charge: float = option(0.0, "charge Q")

    def _check(self) -> None:
        a, Q = abs(self.spin) / self.mass, abs(self.charge) / self.mass
        if Q > 1.0:
            raise ValueError(f"{self.name}: |charge| must be at most the mass {self.mass}, not {self.charge}")
        limit = smarr_limit(Q)
        if a > limit * (1.0 + 1e-15):
            reason = "for the horizon to embed in R^3" if a * a + Q * Q <= 1.0 else "for a horizon to exist"
            raise ValueError(
                f"{self.name}: |spin| must be at most {limit * self.mass:.12g} {reason}, not {self.spin}"
            )

    def _R(self, s: Floats) -> Radius:
        return horizon_radius(self.spin / self.mass, self.charge / self.mass, s)


@dataclass(frozen=True)
class Ergosphere(KerrSurface):
    """The distorted ergosphere of a Kerr black hole, r = r_ergo(theta) + epsilon M, Eq. (rtheta).

    At epsilon = 0 the poles are conical; for the paper's spin, K < 0 near them until epsilon = 1.29773.
    Outside the bounds on epsilon and the spin, the tips are conical to rounding.
    """

    name: ClassVar[str] = "ergosphere"
    epsilon: float = option(0.3, "distance from the ergosphere over M, from 1e-6 to 1e6", positive)
    mass: float = option(1.0, "mass M", positive)
    spin: float = option(0.975, "spin a, at most 0.9999 M")

    def _check(self) -> None:
        if not 1e-6 <= self.epsilon <= 1e6:
            raise ValueError(f"{self.name}: epsilon must be between 1e-6 and 1e6, not {self.epsilon}")
        if abs(self.spin) > 0.9999 * self.mass:
            raise ValueError(
                f"{self.name}: |spin| must be at most 0.9999 times the mass {self.mass}, not {self.spin}"
            )

    @property
    def charge(self) -> float:  # type: ignore[override]
        """Charge of the hole: zero."""
        return 0.0

    def _R(self, s: Floats) -> Radius:
        return ergosphere_radius(self.epsilon, self.spin / self.mass, 0.0, s)
