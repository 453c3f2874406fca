"""Superellipsoids |x/a|^p + |y/b|^q + |z/c|^r = 1: ellipsoid, sphere, drum."""

from dataclasses import dataclass
from functools import cached_property
from math import pi, prod, sqrt
from typing import ClassVar

import numpy as np
from scipy.special import elliprg

from isoembed.arrays import Floats
from isoembed.gallery.quadrature import integrate, tanh_sinh
from isoembed.gallery.surface import SurfaceWithAxes, Triple, option, positive, semiaxes


class ImplicitSurface(SurfaceWithAxes):
    """The level set g = 1 of g = sum |x_i / s_i|^p_i, with s the semi-axes and every p_i >= 2.

    A direction u is mapped to the point s t(u) u: the radial projection of the sphere, stretched by the axes.
    The surface is symmetric in the three coordinate planes, and integrals are computed over one octant.
    """

    @property
    def _powers(self) -> Triple:
        """The exponents p, by default those of an ellipsoid."""
        return 2.0, 2.0, 2.0

    def _stretch(self, u: Floats) -> Floats:
        """Factor t > 0 (n,) with sum |t u_i|^p_i = 1, by default that of an ellipsoid."""
        return np.ones(len(u))

    def _gradient(self, u: Floats) -> tuple[Floats, Floats]:
        """Factor t (n,) and gradient (n, 3) of g with respect to x_i / s_i."""
        t, p = self._stretch(u), np.array(self._powers)
        y = t[:, None] * u
        return t, p * np.sign(y) * np.abs(y) ** (p - 1.0)

    def _points(self, u: Floats) -> Floats:
        return self._stretch(u)[:, None] * u * self._semiaxes

    def _normals(self, u: Floats) -> Floats:
        n = self._gradient(u)[1] / self._semiaxes
        return n / np.linalg.norm(n, axis=1)[:, None]

    def _area_density(self, u: Floats) -> Floats:
        # n dA = t^2 grad g / (u . grad g) d(omega) for a radial map; the axes act by their cofactors.
        t, g = self._gradient(u)
        stretched = np.linalg.norm(g / self._semiaxes, axis=1) * self._semiaxes.prod()
        return t**2 * stretched / np.einsum("ij,ij->i", g, u)

    def _curvatures(self, u: Floats) -> tuple[Floats, Floats]:
        t, g = self._gradient(u)
        s, p = self._semiaxes, np.array(self._powers)
        # The Hessian of g is diagonal.
        d, e, f = (p * (p - 1.0) * np.abs(t[:, None] * u) ** (p - 2.0) / s**2).T
        x2, y2, z2 = ((g / s) ** 2).T
        norm2 = x2 + y2 + z2
        K = (x2 * e * f + y2 * f * d + z2 * d * e) / norm2**2
        H = (x2 * (e + f) + y2 * (f + d) + z2 * (d + e)) / (2.0 * norm2**1.5)
        return K, H

    def _moved(self, u: Floats, displacement: Floats) -> Floats:
        y = self._stretch(u)[:, None] * u + displacement / self._semiaxes
        return y / np.linalg.norm(y, axis=1)[:, None]

    @cached_property
    def _integrals(self) -> Floats:
        det = self._semiaxes.prod()

        def octants(n: int) -> Floats:
            x, w = tanh_sinh(n)
            theta, phi = (a.ravel() for a in np.meshgrid(x, x, indexing="ij"))
            weight = 8.0 * np.sin(theta) * np.outer(w, w).ravel()
            u = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=1)
            element = weight * self._area_density(u)
            volume = det / 3.0 * weight @ self._stretch(u) ** 3
            return np.array([element.sum(), volume, element @ self._curvatures(u)[1]])

        return integrate(octants)


@dataclass(frozen=True)
class Ellipsoid(ImplicitSurface):
    """The ellipsoid (x/a)^2 + (y/b)^2 + (z/c)^2 = 1, Eq. (ellipse) of the paper."""

    name: ClassVar[str] = "ellipsoid"
    axes: tuple[float, float, float] = option((3.0, 2.0, 1.0), "semi-axes a b c", semiaxes)

    @cached_property
    def _integrals(self) -> Floats:
        # Carlson's symmetric integral R_G yields both (DLMF 19.33.2 and Minkowski's duality).
        a2, b2, c2 = self._semiaxes**2
        area, imc = 4.0 * pi * elliprg(a2 * b2, a2 * c2, b2 * c2), 4.0 * pi * elliprg(a2, b2, c2)
        return np.array([area, 4.0 / 3.0 * pi * prod(self._semiaxes), imc])


@dataclass(frozen=True)
class Sphere(ImplicitSurface):
    """The round sphere."""

    name: ClassVar[str] = "sphere"
    radius: float = option(1.0, "radius", positive)

    @property
    def axes(self) -> Triple:  # type: ignore[override]
        """The three semi-axes, all equal to the radius."""
        return self.radius, self.radius, self.radius

    @cached_property
    def _integrals(self) -> Floats:
        return np.array([4.0 * pi, 4.0 / 3.0 * pi, 4.0 * pi])


@dataclass(frozen=True)
class Drum(ImplicitSurface):
    """The drum (x/d)^2 + (y/e)^2 + (z/f)^4 = 1, Eq. (drum) of the paper.

    Its Gaussian curvature vanishes along the equator z = 0.
    """

    name: ClassVar[str] = "drum"
    axes: tuple[float, float, float] = option((2.0, 1.0, sqrt(1.5)), "semi-axes d e f", semiaxes)

    @property
    def _powers(self) -> Triple:
        return 2.0, 2.0, 4.0

    def _stretch(self, u: Floats) -> Floats:
        # A t^2 + B t^4 = 1, solved for t^2 without cancellation.
        A, B = u[:, 0] ** 2 + u[:, 1] ** 2, u[:, 2] ** 4
        return np.sqrt(2.0 / (A + np.sqrt(A**2 + 4.0 * B)))


@dataclass(frozen=True)
class Superellipsoid(ImplicitSurface):
    """The superellipsoid |x/a|^p + |y/b|^p + |z/c|^p = 1, 2 <= p <= 20: a rounded box.

    For p > 2 its Gaussian curvature vanishes on the coordinate planes.
    """

    name: ClassVar[str] = "superellipsoid"
    axes: tuple[float, float, float] = option((1.0, 1.0, 1.0), "semi-axes a b c", semiaxes)
    power: float = option(4.0, "exponent p, from 2 to 20")

    def _check(self) -> None:
        if not 2.0 <= self.power <= 20.0:
            raise ValueError(f"{self.name}: power must be between 2 and 20, not {self.power}")

    @property
    def _powers(self) -> Triple:
        return self.power, self.power, self.power

    def _stretch(self, u: Floats) -> Floats:
        largest = np.abs(u).max(axis=1)
        return ((np.abs(u) / largest[:, None]) ** self.power).sum(axis=1) ** (-1.0 / self.power) / largest
