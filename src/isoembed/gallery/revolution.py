"""Surfaces of revolution about z, and the Cassini peanut.

The profile is written rho = sin(theta) p(s), dz/d(theta) = -sin(theta) q(s) with s = sin^2(theta):
p and q are smooth and positive, and no formula divides by zero at the poles.
"""

from abc import abstractmethod
from dataclasses import dataclass
from functools import cached_property
from math import pi
from typing import ClassVar, NamedTuple

import numpy as np

from isoembed.arrays import Floats
from isoembed.gallery.quadrature import integrate, tanh_sinh
from isoembed.gallery.surface import Surface, option, positive


class Profile(NamedTuple):
    """Functions p and q of s = sin^2(theta) and their derivatives with respect to s, each (n,)."""

    p: Floats
    p_s: Floats
    p_ss: Floats
    q: Floats
    q_s: Floats


class SurfaceOfRevolution(Surface):
    """A surface of revolution about z that is symmetric under z -> -z.

    The direction with polar angles (theta, phi) is mapped to the point (rho cos phi, rho sin phi, z).
    """

    @abstractmethod
    def _profile(self, s: Floats) -> Profile:
        """Profile at s = sin^2(theta)."""

    @abstractmethod
    def _height(self, theta: Floats) -> Floats:
        """Coordinate z (n,) for theta in [0, pi/2]."""

    def _meridian(self, u: Floats) -> tuple[Floats, Profile, Floats, Floats, Floats]:
        """s, profile at s, c^2 = 1 - s, B = d(rho)/d(theta) / cos(theta) and the speed v."""
        s = u[:, 0] ** 2 + u[:, 1] ** 2
        profile = self._profile(s)
        c2 = u[:, 2] ** 2
        B = profile.p + 2.0 * s * profile.p_s
        return s, profile, c2, B, np.sqrt(c2 * B**2 + s * profile.q**2)

    def _points(self, u: Floats) -> Floats:
        sin = np.hypot(u[:, 0], u[:, 1])
        p = self._profile(sin**2).p
        z = np.sign(u[:, 2]) * self._height(np.arctan2(sin, np.abs(u[:, 2])))
        return np.stack([p * u[:, 0], p * u[:, 1], z], axis=1)

    def _normals(self, u: Floats) -> Floats:
        _, profile, _, B, v = self._meridian(u)
        return np.stack([profile.q * u[:, 0] / v, profile.q * u[:, 1] / v, B * u[:, 2] / v], axis=1)

    def _area_density(self, u: Floats) -> Floats:
        _, profile, _, _, v = self._meridian(u)
        return profile.p * v

    def _curvatures(self, u: Floats) -> tuple[Floats, Floats]:
        s, (p, p_s, p_ss, q, q_s), c2, B, v = self._meridian(u)
        along = c2 * B * (q + 2.0 * s * q_s) + s * q * (B - 2.0 * c2 * (3.0 * p_s + 2.0 * s * p_ss))
        k1, k2 = along / v**3, q / (p * v)
        return k1 * k2, 0.5 * (k1 + k2)

    def _moved(self, u: Floats, displacement: Floats) -> Floats:
        _, profile, _, B, v = self._meridian(u)
        sin = np.hypot(u[:, 0], u[:, 1])
        at_pole = sin == 0.0
        radial = np.where(at_pole[:, None], [1.0, 0.0], u[:, :2]) / np.where(at_pole, 1.0, sin)[:, None]
        outward = np.einsum("ij,ij->i", displacement[:, :2], radial)
        around = displacement[:, 1] * radial[:, 0] - displacement[:, 0] * radial[:, 1]
        d_theta = (u[:, 2] * B * outward - sin * profile.q * displacement[:, 2]) / v**2
        d_phi = around / profile.p  # multiplied by sin(theta)
        tangent = np.stack(
            [
                d_theta * u[:, 2] * radial[:, 0] - d_phi * radial[:, 1],
                d_theta * u[:, 2] * radial[:, 1] + d_phi * radial[:, 0],
                -d_theta * sin,
            ],
            axis=1,
        )
        moved = u + tangent
        return moved / np.linalg.norm(moved, axis=1)[:, None]

    @cached_property
    def _integrals(self) -> Floats:
        def hemispheres(n: int) -> Floats:
            theta, w = tanh_sinh(n)
            sin = np.sin(theta)
            u = np.stack([sin, np.zeros(n), np.cos(theta)], axis=1)
            profile = self._profile(sin**2)
            element = 4.0 * pi * w * sin * self._area_density(u)
            volume = 2.0 * pi * (w * sin**3 * profile.p**2 * profile.q).sum()
            return np.array([element.sum(), volume, element @ self._curvatures(u)[1]])

        return integrate(hemispheres)


@dataclass(frozen=True)
class CassiniPeanut(SurfaceOfRevolution):
    """The Cassini oval with foci (0, 0, +-a) and product of distances b^2, revolved about its long axis.

    It is connected for a < b, and a peanut with a waist (K < 0) for a > b / sqrt(2); at a = b two drops touch
    in a point.
    """

    name: ClassVar[str] = "cassini-peanut"
    a: float = option(0.9, "distance of the foci from the center, less than 0.9999 b", positive)
    b: float = option(1.0, "root of the product of distances to the foci", positive)

    def _check(self) -> None:
        if self.a >= 0.9999 * self.b:
            raise ValueError(
                f"{self.name}: a must be less than 0.9999 b = {0.9999 * self.b:.6g}, not {self.a}"
            )

    @property
    def _unit(self) -> float:
        return self.b

    def _radii(self, s: Floats) -> tuple[Floats, Floats, Floats]:
        """Distance r from the center and its first two derivatives with respect to s."""
        # r^2 = a^2 cos(2 theta) + w, w^2 = 1 - a^4 sin^2(2 theta), with b = 1.
        a2 = (self.a / self.b) ** 2
        w = np.sqrt(1.0 - 4.0 * a2**2 * s * (1.0 - s))
        w_s = -2.0 * a2**2 * (1.0 - 2.0 * s) / w
        w_ss = (4.0 * a2**2 - w_s**2) / w
        r = np.sqrt(a2 * (1.0 - 2.0 * s) + w)
        r_s = (w_s - 2.0 * a2) / (2.0 * r)
        return r, r_s, (w_ss - 2.0 * r_s**2) / (2.0 * r)

    def _profile(self, s: Floats) -> Profile:
        r, r_s, r_ss = self._radii(s)
        c2 = 1.0 - s
        return Profile(r, r_s, r_ss, r - 2.0 * c2 * r_s, 3.0 * r_s - 2.0 * c2 * r_ss)

    def _height(self, theta: Floats) -> Floats:
        return np.cos(theta) * self._radii(np.sin(theta) ** 2)[0]
