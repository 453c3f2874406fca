"""Kerr-Newman horizon, spheres and ergosphere as surfaces of slices t = const; Smarr's limit of embedding.

Formulas are in units of the mass with s = sin^2(theta), as in `isoembed.gallery.kerr`, which has the same
2-metric; Schwarzschild is spin 0.
"""

# ruff: noqa: N802, N806 (R, Sigma, Delta, P, Q as the paper and the field write them)
from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from math import hypot, pi, sqrt
from typing import ClassVar

import numpy as np

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter
from isoembed.gallery import kerr
from isoembed.gallery.kerr import Radius, Squares
from isoembed.gallery.quadrature import integrate, tanh_sinh
from isoembed.relativity.spacetimes.checks import make_finite
from isoembed.relativity.spacetimes.surface_data import SurfaceData
from isoembed.smooth.axisymmetric import AxisymmetricEmbedding
from isoembed.smooth.two_metric import from_angles
from isoembed.space import EUCLIDEAN, Space


class KerrNewmanSurface(ABC):
    """Surface r = R(theta) of a slice t = const; a `TwoMetric` in the Boyer-Lindquist angles."""

    name: ClassVar[str]
    marginal: ClassVar[bool] = False
    mass: float
    spin: float
    charge: float

    def __post_init__(self) -> None:
        make_finite(self, self.name)
        if self.mass <= 0.0:
            raise InvalidParameter(f"{self.name}: mass must be positive, not {self.mass}")
        a, Q = self._ratios
        if hypot(a, Q) > 1.0 + 1e-15:
            raise InvalidParameter(
                f"{self.name}: spin^2 + charge^2 must be at most mass^2 for a horizon to exist,"
                f" not {a * a + Q * Q:.9g} mass^2"
            )

    @property
    def _ratios(self) -> tuple[float, float]:
        """Spin and charge over the mass."""
        return self.spin / self.mass, self.charge / self.mass

    @abstractmethod
    def _R(self, s: Floats) -> Radius:
        """R and its derivatives, with Delta free of cancellation."""

    def _squares(self, s: Floats) -> Squares:
        return kerr.squares(self._R(s), *self._ratios, s)

    def tensor(self, u: Floats) -> Floats:
        """Metric (n, 3, 3) at unit vectors u (n, 3), in units of length^2; see `TwoMetric`."""
        h = self._squares(sin2(u))
        return from_angles(u, h.h_thth, np.zeros(len(u)), h.P) * self.mass * self.mass

    def mean_curvature(self, u: Floats) -> Floats:
        """``k = k1 + k2`` (n,) in the slice, for the outward normal, at unit vectors u (n, 3); 1/length."""
        s = sin2(u)
        a, Q = self._ratios
        a2 = a * a
        R, R_s, R_ss, Delta = self._R(s)
        c2 = 1.0 - s
        Sigma = R**2 + a2 * c2
        w = (2.0 * R - Q * Q) / Sigma
        P = R**2 + a2 + a2 * s * w
        # Partial derivatives of P(r, s).
        P_r = 2.0 * R + 2.0 * a2 * s * (1.0 - w * R) / Sigma
        P_s = a2 * w * (1.0 + a2 * s / Sigma)
        slope2 = 4.0 * s * c2 * R_s**2  # R_th^2
        D = Delta + slope2
        # The normal is (Delta, -R_th) / sqrt(Sigma D); it acts on ln sqrt(g_phph) = ln(sin(theta) sqrt(P)).
        around = 0.5 * Delta * P_r / P - 2.0 * c2 * R_s * (1.0 + s * P_s / P)
        # Along the meridian, g_rr dr^2 + g_thth dth^2 = Sigma (dr^2 / Delta + dth^2) is conformally flat.
        R_thth = 2.0 * (1.0 - 2.0 * s) * R_s + 4.0 * s * c2 * R_ss
        along = (R * Delta + 2.0 * a2 * s * c2 * R_s) / Sigma
        along += _quotient(slope2 * (R - 1.0) - R_thth * Delta, D)
        # A horizon has D = 0, and k = 0 like sqrt(D).
        return _quotient(around + along, np.sqrt(Sigma * D)) / self.mass

    def normal_momentum(self, u: Floats) -> Floats:
        """``K(., n)`` of the slice as tangent vectors (n, 3) at u (n, 3): see `SurfaceData`.

        From ``K_ij = -g_phph d_i(omega) / (2 lapse)`` for j = phi, with lapse sqrt(Delta / P) and angular
        velocity omega of zero-angular-momentum observers.
        """
        s = sin2(u)
        a, Q = self._ratios
        a2 = a * a
        R, R_s, _, Delta = self._R(s)
        c2 = 1.0 - s
        Sigma = R**2 + a2 * c2
        m = 2.0 * R - Q * Q
        A = (R**2 + a2) ** 2 - a2 * Delta * s  # P Sigma
        omega_r = a * (2.0 - m * (4.0 * R * (R**2 + a2) - 2.0 * a2 * (R - 1.0) * s) / A) / A
        omega_s = a * a2 * m * Delta / A**2
        # The normal is (Delta, -R_th) / sqrt(Sigma D), and Delta / sqrt(Delta D) is 1 where R_th = 0.
        tilt = 4.0 * s * c2 * R_s * omega_s
        D = Delta + 4.0 * s * c2 * R_s**2
        steep = np.divide(Delta, D, out=np.ones_like(D), where=D > 0.0)
        rate = np.sqrt(steep) * (omega_r - _quotient(tilt, Delta))
        around = -0.5 * (A / Sigma) ** 1.5 * rate / np.sqrt(Sigma)
        return around[:, None] * rotation_about_z(u)

    def gaussian_curvature(self, u: Floats) -> Floats:
        """Gaussian curvature K (n,) of the surface at unit vectors u (n, 3), in 1/length^2."""
        s = sin2(u)
        h = self._squares(s)
        # As for a surface of revolution with rho^2 = s P and z_th^2 = s q^2; K needs no root of q^2.
        c2 = 1.0 - s
        slope = 1.0 + s * h.P_s / h.P  # B / sqrt(P) with B = d rho/d theta / cos(theta)
        bend = (3.0 * h.P_s + 2.0 * s * h.P_ss - s * h.P_s**2 / h.P) / h.P
        along = c2 * slope * (h.q2 + s * h.q2_s) + s * h.q2 * (slope - c2 * bend)
        return along / h.h_thth**2 / self.mass / self.mass

    @cached_property
    def area(self) -> float:
        """Area, by quadrature to rounding if there is no closed form."""

        def hemispheres(n: int) -> Floats:
            theta, weight = tanh_sinh(n)
            h = self._squares(np.sin(theta) ** 2)
            return np.array([4.0 * pi * (weight * np.sin(theta)) @ np.sqrt(h.h_thth * h.P)])

        return float(integrate(hemispheres)[0]) * self.mass * self.mass

    @property
    def angular_momentum(self) -> float | None:
        """J, spin times mass for every uncharged surface; None with charge, except for the horizon.

        With charge, the electromagnetic field outside a surface carries part of J, so that the integral of
        ``K_ij n^i phi^j / (8 pi)`` depends on the surface.
        """
        return self.spin * self.mass if self.charge == 0.0 else None

    @cached_property
    def electromagnetic_angular_momentum(self) -> float:
        """Electromagnetic part of J, which adds to the part of K_ij to give a M on every surface.

        ``int A_phi *F / 4 pi`` with the potential A that is regular on the axis, which vanishes at infinity.
        """
        a, Q = self._ratios
        a2 = a * a

        def hemisphere(n: int) -> Floats:
            theta, weight = tanh_sinh(n)
            sin, c2 = np.sin(theta), np.cos(theta) ** 2
            s = sin**2
            R, R_s, _, _ = self._R(s)
            N, Sigma = R**2 + a2, R**2 + a2 * c2
            # *F is the derivative of -Q cos(theta) N / Sigma along the meridian.
            flux = Q * sin * (N / Sigma - 2.0 * a2 * c2 * (N - 2.0 * s * R * R_s) / Sigma**2)
            return np.array([weight @ (Q * a * R * s / Sigma * flux)])

        return float(integrate(hemisphere)[0]) * self.mass * self.mass

    def data(self) -> SurfaceData:
        """Data for quasi-local energies.

        The momentum p is zero: the simultaneous reversal of t and phi is an isometry, so that only the
        components r phi and theta phi of K_ij do not vanish, which contribute neither to its trace nor to its
        normal component on an axisymmetric surface.
        """
        return SurfaceData(
            metric=self,
            mean_curvature=self.mean_curvature,
            momentum=None,
            normal_momentum=self.normal_momentum if self.spin else None,
            angular_momentum=self.angular_momentum,
            electromagnetic_angular_momentum=abs(self.electromagnetic_angular_momentum),
            charge=self.charge,
            marginal=self.marginal,
            name=f"{self.name} of mass {self.mass:.9g}, spin {self.spin:.9g}, charge {self.charge:.9g}",
        )

    def profile(self, space: Space = EUCLIDEAN) -> AxisymmetricEmbedding:
        """Surface of revolution in a space with this metric, or its bands that embed."""
        return AxisymmetricEmbedding.of(self, space=space)


@dataclass(frozen=True)
class KerrNewmanHorizon(KerrNewmanSurface):
    """Outer horizon r = r_+, not a surface of revolution in R^3 beyond `smarr_limit`.

    Attributes
    ----------
    mass, spin, charge : float
        M, a and Q in units of length, a^2 + Q^2 <= M^2.
    """

    name: ClassVar[str] = "Kerr-Newman horizon"
    marginal: ClassVar[bool] = True
    mass: float = 1.0
    spin: float = 0.0
    charge: float = 0.0

    @property
    def radius(self) -> float:
        """Boyer-Lindquist radius r_+."""
        return float(self._R(np.zeros(1)).R[0]) * self.mass

    @cached_property
    def area(self) -> float:
        """Area, 4 pi (r_+^2 + a^2)."""
        return 4.0 * pi * (self.radius * self.radius + self.spin * self.spin)

    @property
    def angular_momentum(self) -> float:
        """J = a M, including the electromagnetic part with charge.

        This is J in the mass formula of Christodoulou and Ruffini (1971) and of isolated horizons (Ashtekar,
        Beetle and Lewandowski 2001).
        """
        return self.spin * self.mass

    def gaussian_curvature(self, u: Floats) -> Floats:
        """K (n,), in 1/length^2: negative where cos^2(theta) > r_+^2 / (3 a^2) (Smarr 1973)."""
        r2, a2 = (self.radius / self.mass) ** 2, self._ratios[0] ** 2
        c2 = 1.0 - sin2(u)
        return (r2 + a2) * (r2 - 3.0 * a2 * c2) / (r2 + a2 * c2) ** 3 / self.mass / self.mass

    def _R(self, s: Floats) -> Radius:
        return kerr.horizon_radius(*self._ratios, s)


@dataclass(frozen=True)
class KerrNewmanSphere(KerrNewmanSurface):
    """Surface r = const on or outside the horizon.

    Attributes
    ----------
    r : float
        Boyer-Lindquist radius, at least r_+; the areal radius if the spin is 0.
    mass, spin, charge : float
        M, a and Q in units of length, a^2 + Q^2 <= M^2.
    """

    name: ClassVar[str] = "Kerr-Newman surface r = const"
    r: float
    mass: float = 1.0
    spin: float = 0.0
    charge: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.r / self.mass < self._r_plus * (1.0 - 1e-15):
            raise InvalidParameter(
                f"{self.name}: r must be at least r_+ = {self._r_plus * self.mass:.12g}, not {self.r}"
            )

    @property
    def _r_plus(self) -> float:
        return float(kerr.horizon_radius(*self._ratios, np.zeros(1)).R[0])

    def _R(self, s: Floats) -> Radius:
        r, zero = self.r / self.mass, np.zeros_like(s)
        # Delta = (r - r_+) (r - r_-)
        Delta = max(0.0, r - self._r_plus) * (r - 2.0 + self._r_plus)
        return Radius(zero + r, zero, zero, zero + Delta)


@dataclass(frozen=True)
class KerrNewmanErgosphere(KerrNewmanSurface):
    """Distorted ergosphere r = r_ergo(theta) + epsilon M, Eq. (rtheta) of the paper, with charge.

    Attributes
    ----------
    epsilon : float
        Distance over M, from 1e-6 to 1e6; at 0 the poles are conical.
    mass, spin, charge : float
        M, a and Q in units of length, a^2 + Q^2 <= 0.9998 M^2; beyond, the poles are conical to rounding.
    """

    name: ClassVar[str] = "distorted ergosphere"
    epsilon: float = 0.3
    mass: float = 1.0
    spin: float = 0.975
    charge: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if not 1e-6 <= self.epsilon <= 1e6:
            raise InvalidParameter(f"{self.name}: epsilon must be between 1e-6 and 1e6, not {self.epsilon}")
        a, Q = self._ratios
        if hypot(a, Q) > 0.9999:
            raise InvalidParameter(
                f"{self.name}: the root of spin^2 + charge^2 must be at most 0.9999 mass,"
                f" not {hypot(a, Q):.9g} mass"
            )

    def _R(self, s: Floats) -> Radius:
        return kerr.ergosphere_radius(self.epsilon, *self._ratios, s)


def smarr_limit(mass: float = 1.0, charge: float = 0.0) -> float:
    """Largest spin of a horizon that is a surface of revolution in R^3, r_+ = sqrt(3) a.

    It is sqrt(3)/2 M without charge; for charge^2 >= 2/3 M^2 every horizon embeds.

    Raises
    ------
    InvalidParameter
        There is no horizon of this mass and charge.

    References
    ----------
    L. Smarr, "Surface geometry of charged rotating black holes", Phys. Rev. D 7, 289 (1973).
    """
    KerrNewmanHorizon(mass, 0.0, charge)
    return kerr.smarr_limit(charge / mass) * mass


def embeddability(surface: KerrNewmanSurface) -> str:
    """Sentence on whether a surface embeds in R^3, and if not, on the obstruction and the bands that embed.

    For a horizon it includes the bound on the spin.  K < 0 on a small cap at a pole.  By the Gauss-Bonnet
    theorem the total curvature of a cap is 2 pi (1 - d rho/d(arc length)), which is not negative for a
    surface of revolution; the band that embeds begins where positive curvature around the cap makes it zero.
    """
    explanation = surface.profile().explanation
    if not isinstance(surface, KerrNewmanHorizon):
        return f"{surface.name}: {explanation}"
    r, a, limit = surface.radius, abs(surface.spin), smarr_limit(surface.mass, surface.charge)
    relation = ">=" if r >= sqrt(3.0) * a * (1.0 - 1e-15) else "<"
    return (
        f"{surface.name} with r_+ = {r:.9g} {relation} sqrt(3) a = {sqrt(3.0) * a:.9g}"
        f" (it embeds up to spin {limit:.9g}; Smarr 1973): {explanation}"
    )


def sin2(u: Floats) -> Floats:
    """``sin^2(theta)`` (n,) at unit vectors u (n, 3)."""
    return np.asarray(u[:, 0] ** 2 + u[:, 1] ** 2, dtype=np.float64)


def rotation_about_z(u: Floats) -> Floats:
    """Velocities (n, 3) of unit vectors under rotation about the z-axis."""
    return np.stack([-u[:, 1], u[:, 0], np.zeros(len(u))], axis=1)


def _quotient(a: Floats, b: Floats) -> Floats:
    """Quotient a / b where b > 0, otherwise 0."""
    return np.divide(a, b, out=np.zeros_like(b), where=b > 0.0)
