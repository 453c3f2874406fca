"""Spheres deformed by one spherical harmonic: saddles, trefoils, stars."""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.polynomial import Legendre, Polynomial
from numpy.typing import NDArray

from isoembed.arrays import Floats
from isoembed.gallery.mapped import MappedSurface
from isoembed.gallery.surface import integer, option, positive

Complex = NDArray[np.complex128]

MAX_DEGREE = 16
"""Each bump requires tens of vertices, and there are up to l^2 / 2 of them."""


@dataclass(frozen=True)
class HarmonicSurface(MappedSurface):
    """The sphere with a spherical harmonic Y on it, r = R (1 + A Y) with max |Y| = 1.

    Y is proportional to P_l^m(cos theta) cos(m phi). Degree 2, order 2, Y = x^2 - y^2, yields a saddle-shaped
    body; degree 3, order 3, Y = x^3 - 3 x y^2, a trefoil. K < 0 between the bumps unless A is small.
    """

    name: ClassVar[str] = "harmonic"
    degree: int = option(3, f"degree l, from 1 to {MAX_DEGREE}", integer)
    order: int = option(3, "order m, from 0 to the degree", integer)
    amplitude: float = option(0.3, "amplitude A, between -0.99 and 0.99")
    radius: float = option(1.0, "radius R of the sphere", positive)

    def _check(self) -> None:
        for name, value, lower, upper in (
            ("degree", self.degree, 1, MAX_DEGREE),
            ("order", self.order, 0, self.degree),
        ):
            if not lower <= value <= upper:
                raise ValueError(f"{self.name}: {name} must be between {lower} and {upper}, not {value}")
        if abs(self.amplitude) > 0.99:
            raise ValueError(f"{self.name}: amplitude must be between -0.99 and 0.99, not {self.amplitude}")

    @property
    def _unit(self) -> float:
        return self.radius

    @cached_property
    def _zonal(self) -> tuple[Legendre, Legendre, Legendre]:
        """Factor d^m P_l / dz^m of Y and its derivatives, scaled to max |Y| = 1."""
        m = self.order
        p = Legendre.basis(self.degree).deriv(m) if m else Legendre.basis(self.degree)
        # |Y| on a meridian is |p| (1 - z^2)^(m/2), maximal at an end or where its derivative vanishes.
        z = Legendre.cast(Polynomial([0.0, 1.0]))
        stationary = (p.deriv() * (1.0 - z * z) - m * z * p).roots()
        z = np.clip(np.concatenate([[-1.0, 1.0], stationary.real]), -1.0, 1.0)
        p = p / np.abs(p(z) * (1.0 - z**2) ** (0.5 * m)).max()
        return p, p.deriv(), p.deriv(2)

    def _powers(self, u: Floats) -> tuple[Complex, Complex, Complex]:
        """(x + i y)^m and its derivatives with respect to x."""
        m, w = self.order, [np.ones(len(u), dtype=np.complex128)]
        for _ in range(m):
            w.append(w[-1] * (u[:, 0] + 1j * u[:, 1]))
        return w[m], m * w[max(m - 1, 0)], m * (m - 1) * w[max(m - 2, 0)]

    def _radii(self, u: Floats) -> tuple[Floats, Floats]:
        """1 + A Y (n,) and A dY/du (n, 3), with Y as a polynomial in u."""
        p, p_z, _ = (series(u[:, 2]) for series in self._zonal)
        w, w_x, _ = self._powers(u)
        gradient = np.stack([p * w_x.real, -p * w_x.imag, p_z * w.real], axis=1)
        return 1.0 + self.amplitude * p * w.real, self.amplitude * gradient

    def _points(self, u: Floats) -> Floats:
        return self._radii(u)[0][:, None] * u

    def _differential(self, u: Floats) -> Floats:
        r, gradient = self._radii(u)
        return r[:, None, None] * np.eye(3) + u[:, :, None] * gradient[:, None, :]

    def _second_differential(self, u: Floats, normals: Floats) -> Floats:
        p, p_z, p_zz = (series(u[:, 2]) for series in self._zonal)
        w, w_x, w_xx = self._powers(u)
        xx, xy = p * w_xx.real, -p * w_xx.imag
        xz, yz, zz = p_z * w_x.real, -p_z * w_x.imag, p_zz * w.real
        hessian = np.stack([xx, xy, xz, xy, -xx, yz, xz, yz, zz], axis=1).reshape(-1, 3, 3)
        mixed = normals[:, :, None] * self._radii(u)[1][:, None, :]
        height = self.amplitude * np.einsum("ni,ni->n", normals, u)
        return mixed + mixed.transpose(0, 2, 1) + height[:, None, None] * hessian
