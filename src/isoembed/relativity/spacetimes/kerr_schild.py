"""Kerr's black hole in Kerr-Schild coordinates, regular through the horizon."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import sqrt

import numpy as np

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter
from isoembed.relativity.spacetimes.checks import positive_number, refuse_points, vector
from isoembed.relativity.spacetimes.three_geometry import (
    AnalyticGeometry,
    Numbers,
    complex_step,
    stationary_curvature,
)


@dataclass(frozen=True)
class KerrSlice(AnalyticGeometry):
    """A slice of the spacetime of a hole with a mass and a spin, a vector."""

    mass: float
    spin: Sequence[float]
    time_symmetric = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "mass", positive_number("the mass", self.mass))
        object.__setattr__(self, "spin", vector("the spin", self.spin))

    @property
    def horizon(self) -> float:
        """The Boyer-Lindquist radius ``r_+ = M + sqrt(M^2 - a^2)`` of the horizon.

        Raises `InvalidParameter`: the spin exceeds the mass: there is none.
        """
        return horizon_radius(self.mass, self.spin)

    @property
    def black_holes(self) -> tuple[tuple[float, Sequence[float]], ...]:
        """The mass and the position of each."""
        return ((self.mass, (0.0, 0.0, 0.0)),)

    @property
    def _a(self) -> Floats:
        """The spin over the mass."""
        return np.array(self.spin) / self.mass


@dataclass(frozen=True)
class KerrSchild(KerrSlice):
    """``gamma_ij = delta_ij + 2 H l_i l_j``, lapse ``(1 + 2 H)^(-1/2)``, shift ``beta_i = 2 H l_i``.

    Attributes
    ----------
    mass : float
        M, the unit of length.
    spin : three floats
        The vector a = J / M, a length, along any axis.

    References
    ----------
    Matzner, Huq and Shoemaker, Phys. Rev. D 59 (1998) 024015.
    """

    def spheroid(self, r: float) -> Callable[[Floats], Floats]:
        """Distance (n,), by direction u (n, 3), of the surface of one Boyer-Lindquist radius."""
        positive_number("the radius", r)
        a = np.array(self.spin) / r
        return lambda u: r * np.sqrt((1.0 + a @ a) / (1.0 + (u @ a) ** 2))

    def metric(self, x: Numbers) -> Numbers:
        """See `ThreeGeometry`; x may be complex."""
        H, l = self._null_form(x)
        return np.eye(3) + 2.0 * H[:, None, None] * l[:, :, None] * l[:, None, :]

    def extrinsic_curvature(self, x: Floats) -> Floats:
        """See `ThreeGeometry`."""

        def shift(x: Numbers) -> Numbers:
            H, l = self._null_form(x)
            return 2.0 * H[:, None] * l

        H, _ = self._null_form(x)
        lapse = 1.0 / np.sqrt(1.0 + 2.0 * H)
        return stationary_curvature(self.gradient(x), self.metric(x), lapse, shift(x), complex_step(shift, x))

    def _null_form(self, x: Numbers) -> tuple[Numbers, Numbers]:
        """H (n,) and ``l_i`` (n, 3)."""
        x, a = x / self.mass, self._a
        aa, ax = a @ a, x @ a
        d = np.einsum("ni,ni->n", x, x) - aa
        root = np.sqrt(d * d + 4.0 * ax * ax)
        refuse_points(
            (ax.real == 0.0) & (d.real <= 0.0), x * self.mass, "lies on the disk that the singularity bounds"
        )
        # Inside the ball |x| = |a| the first form would cancel.
        outside = d.real >= 0.0
        r2 = np.where(outside, 0.5 * (d + root), 2.0 * ax * ax / np.where(outside, 1.0, root - d))
        r = np.sqrt(r2)
        H = r2 * r / (r2 * r2 + ax * ax)
        l = (r[:, None] * x + np.cross(x, a) + (ax / r)[:, None] * a) / (r2 + aa)[:, None]
        return H, l


def horizon_radius(mass: float, spin: Sequence[float]) -> float:
    """``r_+ = M + sqrt(M^2 - a^2)``.  Raises `InvalidParameter`: the spin exceeds the mass."""
    a = sqrt(sum((component / mass) ** 2 for component in spin))
    if a > 1.0:
        raise InvalidParameter(f"there is no horizon: the spin {a * mass:.6g} exceeds the mass {mass:.6g}")
    return mass * (1.0 + sqrt((1.0 - a) * (1.0 + a)))
