"""Closed-form surfaces with boundary, and the torus: cap, cone, catenoid, Enneper's surface."""

from abc import abstractmethod
from dataclasses import dataclass
from math import cos, log, pi, sinh, sqrt, tanh
from typing import ClassVar

import numpy as np

from isoembed.arrays import Floats
from isoembed.gallery.surface import ClosedForm, option, positive
from isoembed.meshing.sphere import angles_of


class ZoneSurface(ClosedForm):
    """The image of a zone of the unit sphere, known in closed form: a disk, a band, or a torus.

    A direction is a pair of polar angles, theta within `zone` and phi.
    """

    is_ring: ClassVar[bool] = False

    @property
    @abstractmethod
    def _zone(self) -> tuple[float, float]:
        """Range of theta; see `zone`."""

    @property
    @abstractmethod
    def _integrals(self) -> tuple[float, float, float]:
        """Area, in units of ``_unit``, and the integrals of H^2 and k1^2 + k2^2."""

    @property
    def zone(self) -> tuple[float, float]:
        """Range of theta, starting at 0 for a disk."""
        return self._zone

    @property
    def area(self) -> float:
        """Area of the smooth surface, in length^2."""
        return self._integrals[0] * self._unit * self._unit

    @property
    def bending_energy(self) -> float:
        """Integral of H^2 dA with H = (k1 + k2) / 2."""
        return self._integrals[1]

    @property
    def second_form_energy(self) -> float:
        """Integral of k1^2 + k2^2 dA."""
        return self._integrals[2]

    @abstractmethod
    def _polar(self, theta: Floats, phi: Floats) -> tuple[Floats, Floats, Floats]:
        """Points and their derivatives with respect to theta and phi, each (n, 3)."""

    def _points(self, u: Floats) -> Floats:
        return self._polar(*angles_of(u))[0]

    def _derivatives(self, u: Floats) -> tuple[Floats, Floats]:
        """Derivatives (n, 3) along the unit vectors e_theta and e_phi."""
        theta, phi = angles_of(u)
        near = 1e-6  # to a pole, where derivatives with respect to phi vanish
        theta = np.clip(theta, near, np.pi - near)
        _, by_theta, by_phi = self._polar(theta, phi)
        return by_theta, by_phi / np.sin(theta)[:, None]

    def _area_density(self, u: Floats) -> Floats:
        return np.asarray(np.linalg.norm(np.cross(*self._derivatives(u)), axis=1))

    def _tensor(self, u: Floats) -> Floats:
        _, phi = angles_of(u)
        sin = np.hypot(u[:, 0], u[:, 1])
        e_theta = np.stack([u[:, 2] * np.cos(phi), u[:, 2] * np.sin(phi), -sin], axis=1)
        e_phi = np.stack([-np.sin(phi), np.cos(phi), np.zeros(len(u))], axis=1)
        X = np.stack(self._derivatives(u), axis=1)
        along = np.einsum("nak,nai->nki", X, np.stack([e_theta, e_phi], axis=1))
        return np.asarray(np.einsum("nki,nkj->nij", along, along))


class ZoneOfRevolution(ZoneSurface):
    """The image of a zone that is a surface of revolution about z."""

    @abstractmethod
    def _meridian(self, theta: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Distance from the axis, height, and their derivatives with respect to theta, each (n,)."""

    def _polar(self, theta: Floats, phi: Floats) -> tuple[Floats, Floats, Floats]:
        rho, z, rho_theta, z_theta = self._meridian(theta)
        c, s = np.cos(phi), np.sin(phi)
        return (
            np.stack([rho * c, rho * s, z], axis=1),
            np.stack([rho_theta * c, rho_theta * s, z_theta], axis=1),
            np.stack([-rho * s, rho * c, np.zeros(len(rho))], axis=1),
        )


@dataclass(frozen=True)
class Cap(ZoneOfRevolution):
    """The part of a sphere within an angle of its pole."""

    name: ClassVar[str] = "cap"
    radius: float = option(1.0, "radius of the sphere", positive)
    angle: float = option(1.0, "angle between pole and boundary, in radians, less than 3.1", positive)

    def _check(self) -> None:
        if self.angle >= 3.1:
            raise ValueError(f"{self.name}: angle must be less than 3.1, not {self.angle}")

    @property
    def _unit(self) -> float:
        return self.radius

    @property
    def _zone(self) -> tuple[float, float]:
        return 0.0, self.angle

    @property
    def _integrals(self) -> tuple[float, float, float]:
        whole = 2.0 * pi * (1.0 - cos(self.angle))
        return whole, whole, 2.0 * whole

    def _meridian(self, theta: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        sin, cosine = np.sin(theta), np.cos(theta)
        return sin, cosine, cosine, -sin


@dataclass(frozen=True)
class Cone(ZoneOfRevolution):
    """The part of a cone between two distances from its tip, along it; with slope 1 an annulus."""

    name: ClassVar[str] = "cone"
    slope: float = option(0.8, "sine of the angle between the cone and its axis, at most 1", positive)
    inner: float = option(0.3, "distance of the inner boundary from the tip", positive)
    outer: float = option(1.0, "distance of the outer boundary from the tip", positive)

    def _check(self) -> None:
        if self.slope > 1.0:
            raise ValueError(f"{self.name}: slope must be at most 1, not {self.slope}")
        if not self.inner <= 0.999 * self.outer:
            raise ValueError(
                f"{self.name}: inner must be at most 0.999 outer = {0.999 * self.outer:.6g}, not {self.inner}"
            )

    @property
    def _unit(self) -> float:
        return self.outer

    @property
    def _zone(self) -> tuple[float, float]:
        return self.inner / self.outer, 1.0

    @property
    def _integrals(self) -> tuple[float, float, float]:
        ratio = self.inner / self.outer
        squares = 2.0 * pi * (1.0 / self.slope - self.slope) * -log(ratio)
        return pi * self.slope * (1.0 - ratio * ratio), 0.25 * squares, squares

    def _meridian(self, theta: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        fall = sqrt((1.0 - self.slope) * (1.0 + self.slope))
        one = np.ones_like(theta)
        return self.slope * theta, -fall * theta, self.slope * one, -fall * one


@dataclass(frozen=True)
class Catenoid(ZoneOfRevolution):
    """The minimal surface of revolution, rho = c cosh(z / c), about its waist."""

    name: ClassVar[str] = "catenoid"
    waist: float = option(1.0, "radius c of the waist", positive)
    height: float = option(2.0, "distance of the boundaries, at most 10 c", positive)

    def _check(self) -> None:
        if self.height > 10.0 * self.waist:
            maximum = 10.0 * self.waist
            raise ValueError(
                f"{self.name}: height must be at most 10 waist = {maximum:.6g}, not {self.height}"
            )

    @property
    def _unit(self) -> float:
        return self.waist

    @property
    def _end(self) -> float:
        """Height of a boundary above the waist, in units of the waist's radius."""
        return 0.5 * self.height / self.waist

    @property
    def _zone(self) -> tuple[float, float]:
        return 0.25 * pi, 0.75 * pi

    @property
    def _integrals(self) -> tuple[float, float, float]:
        return pi * (2.0 * self._end + sinh(2.0 * self._end)), 0.0, 8.0 * pi * tanh(self._end)

    def _meridian(self, theta: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        turn = self._end / (0.25 * pi)
        t = turn * (theta - 0.5 * pi)
        return np.cosh(t), -t, turn * np.sinh(t), np.full_like(t, -turn)


@dataclass(frozen=True)
class Enneper(ZoneSurface):
    """Enneper's minimal surface (u - u^3/3 + u v^2, -v + v^3/3 - u^2 v, u^2 - v^2) over a disc."""

    name: ClassVar[str] = "enneper"
    radius: float = option(
        0.8, "radius of the disc of u and v, at most 1.7: the surface crosses itself from 3^(1/2)", positive
    )

    def _check(self) -> None:
        if self.radius > 1.7:
            raise ValueError(f"{self.name}: radius must be at most 1.7, not {self.radius}")

    @property
    def _unit(self) -> float:
        return 1.0

    @property
    def _zone(self) -> tuple[float, float]:
        return 0.0, 1.0

    @property
    def _integrals(self) -> tuple[float, float, float]:
        s = self.radius**2
        return pi * s * (1.0 + s + s * s / 3.0), 0.0, 8.0 * pi * s / (1.0 + s)

    def _polar(self, theta: Floats, phi: Floats) -> tuple[Floats, Floats, Floats]:
        w = self.radius * theta * np.exp(1j * phi)  # u + i v
        X = np.stack([(w - w**3 / 3.0).real, -(w + w**3 / 3.0).imag, (w * w).real], axis=1)
        # The points are real parts of a holomorphic curve.
        slope = np.stack([1.0 - w * w, 1j * (1.0 + w * w), 2.0 * w], axis=1)
        by_theta = (slope * (self.radius * np.exp(1j * phi))[:, None]).real
        return X, by_theta, (slope * (1j * w)[:, None]).real


@dataclass(frozen=True)
class Torus(ZoneOfRevolution):
    """The torus of revolution, a closed surface of genus 1."""

    name: ClassVar[str] = "torus"
    is_ring: ClassVar[bool] = True
    ring: float = option(2.0, "radius R of the center circle of the tube", positive)
    tube: float = option(0.8, "radius r of the tube, at most 0.999 R", positive)

    def _check(self) -> None:
        if self.tube > 0.999 * self.ring:
            raise ValueError(
                f"{self.name}: tube must be at most 0.999 ring = {0.999 * self.ring:.6g}, not {self.tube}"
            )

    @property
    def _unit(self) -> float:
        return self.ring

    @property
    def _zone(self) -> tuple[float, float]:
        return 0.25 * pi, 0.75 * pi

    @property
    def _integrals(self) -> tuple[float, float, float]:
        t = self.tube / self.ring
        bending = pi**2 / (t * sqrt((1.0 - t) * (1.0 + t)))
        return 4.0 * pi**2 * t, bending, 4.0 * bending  # the integral of K is 0

    def _meridian(self, theta: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        t, turn = self.tube / self.ring, 4.0 * (theta - 0.25 * pi)
        cosine, sin = np.cos(turn), np.sin(turn)
        return 1.0 + t * cosine, -t * sin, -4.0 * t * sin, -4.0 * t * cosine
