"""Slices of Kerr black holes in closed form, in Kerr-Schild and Boyer-Lindquist coordinates."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import sqrt

import numpy as np

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter
from isoembed.relativity.spacetimes.checks import positive_number, refuse_points, vector
from isoembed.relativity.spacetimes.schwarzschild import OneHole
from isoembed.relativity.spacetimes.three_geometry import Numbers, complex_step, stationary_curvature


@dataclass(frozen=True)
class KerrSlice(OneHole):
    """Slice of a Kerr spacetime with a mass and a spin vector."""

    spin: Sequence[float]
    time_symmetric = False

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "spin", vector("the spin", self.spin))

    @property
    def horizon(self) -> float:
        """The Boyer-Lindquist radius ``r_+ = M + sqrt(M^2 - a^2)`` of the horizon.

        Raises `InvalidParameter`: the spin exceeds the mass.
        """
        return horizon_radius(self.mass, self.spin)

    @property
    def hindrance(self) -> str:
        """See `ThreeGeometry`: a spin that exceeds the mass."""
        try:
            horizon_radius(self.mass, self.spin)
        except InvalidParameter as error:
            return str(error)
        return ""

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
        """Distance (n,) of the surface of a Boyer-Lindquist radius, as a function of directions u (n, 3)."""
        positive_number("the radius", r)
        a = np.array(self.spin) / r
        return lambda u: r * np.sqrt((1.0 + a @ a) / (1.0 + (u @ a) ** 2))

    def metric(self, x: Numbers) -> Numbers:
        """See `ThreeGeometry`; x may be complex."""
        return _metric(*self._null_form(x))

    def extrinsic_curvature(self, x: Floats) -> Floats:
        """See `ThreeGeometry`."""

        def fields(x: Numbers) -> Numbers:
            """Metric, and the shift as a fourth row (n, 4, 3)."""
            H, l = self._null_form(x)
            shift = 2.0 * H[:, None] * l
            return np.concatenate([_metric(H, l), shift[:, None]], axis=1)

        H, l = self._null_form(x)
        lapse = 1.0 / np.sqrt(1.0 + 2.0 * H)
        rates = complex_step(fields, x)
        return stationary_curvature(
            rates[:, :, :3], _metric(H, l), lapse, 2.0 * H[:, None] * l, rates[:, :, 3]
        )

    def _null_form(self, x: Numbers) -> tuple[Numbers, Numbers]:
        """H (n,) and ``l_i`` (n, 3)."""
        x, a = x / self.mass, self._a
        aa, ax = a @ a, x @ a
        d = np.einsum("ni,ni->n", x, x) - aa
        root = np.sqrt(d * d + 4.0 * ax * ax)
        refuse_points(
            (ax.real == 0.0) & (d.real <= 0.0), x * self.mass, "lies on the disk that the singularity bounds"
        )
        # Inside the ball |x| = |a| the first form suffers from cancellation.
        outside = d.real >= 0.0
        r2 = np.where(outside, 0.5 * (d + root), 2.0 * ax * ax / np.where(outside, 1.0, root - d))
        r = np.sqrt(r2)
        H = r2 * r / (r2 * r2 + ax * ax)
        l = (r[:, None] * x + np.cross(x, a) + (ax / r)[:, None] * a) / (r2 + aa)[:, None]
        return H, l


def _metric(H: Numbers, l: Numbers) -> Numbers:
    """``delta_ij + 2 H l_i l_j`` (n, 3, 3)."""
    return np.eye(3) + 2.0 * H[:, None, None] * l[:, :, None] * l[:, None, :]


@dataclass(frozen=True)
class BoyerLindquist(KerrSlice):
    """Slice in coordinates x = r sin(theta) cos(phi), ... with Boyer-Lindquist r, theta and phi.

    With n = x / r and the vector a, free of coordinate singularities on the axis,
    ``gamma_ij = Sigma / r^2 delta_ij + Sigma (1 / Delta - 1 / r^2) n_i n_j
    + (1 + 2 M r / Sigma) (a x x)_i (a x x)_j / r^4``.

    Attributes
    ----------
    mass : float
        M, the unit of length.
    spin : three floats
        The vector a = J / M, a length, along any axis; at most the mass.
    """

    def __post_init__(self) -> None:
        super().__post_init__()
        horizon_radius(self.mass, self.spin)

    @property
    def hindrance(self) -> str:
        """See `ThreeGeometry`."""
        return (
            "Boyer-Lindquist coordinates are singular on the horizon: take KerrSchild, or "
            "KerrNewmanHorizon(mass, spin) for the horizon itself"
        )

    def metric(self, x: Numbers) -> Numbers:
        """See `ThreeGeometry`; x may be complex, and must lie outside the horizon.

        Raises
        ------
        InvalidParameter
            A point is not outside the horizon.
        """
        x, a, r, Sigma, Delta = self._functions(x)
        n, axial = x / r[:, None], np.cross(a, x) / (r * r)[:, None]
        return (
            (Sigma / r**2)[:, None, None] * np.eye(3)
            + (Sigma * (1.0 / Delta - 1.0 / r**2))[:, None, None] * n[:, :, None] * n[:, None, :]
            + (1.0 + 2.0 * r / Sigma)[:, None, None] * axial[:, :, None] * axial[:, None, :]
        )

    def extrinsic_curvature(self, x: Floats) -> Floats:
        """See `ThreeGeometry`.

        The shift ``-w a x x`` is a multiple of a Killing vector, so that only the gradient of w contributes.
        """
        lowered = np.einsum("nij,nj->ni", self.metric(x), np.cross(self._a, x))  # a length
        mixed = lowered[:, :, None] * complex_step(self._dragging, x)[:, None, :]
        _, _, r, Sigma, Delta = self._functions(x)
        lapse = np.sqrt(Delta * Sigma / self._spread(r, Sigma))
        return -(mixed + mixed.transpose(0, 2, 1)) / (2.0 * lapse[:, None, None] * self.mass)

    def _dragging(self, x: Numbers) -> Numbers:
        """``w = 2 M r / ((r^2 + a^2)^2 - Delta a^2 sin^2)`` (n,), times M^2."""
        _, _, r, Sigma, _ = self._functions(x)
        return 2.0 * r / self._spread(r, Sigma)

    def _spread(self, r: Numbers, Sigma: Numbers) -> Numbers:
        """``(r^2 + a^2)^2 - Delta a^2 sin^2 = Sigma (r^2 + a^2) + 2 M r a^2 sin^2``, in units of the mass."""
        a2 = sum((component / self.mass) ** 2 for component in self.spin)
        return Sigma * (r * r + a2) + 2.0 * r * (r * r + a2 - Sigma)

    def _functions(self, x: Numbers) -> tuple[Numbers, Floats, Numbers, Numbers, Numbers]:
        """x, a, r, Sigma and Delta, in units of the mass."""
        xi, a = x / self.mass, self._a
        r = np.sqrt(np.einsum("ni,ni->n", xi, xi))
        r_plus = self.horizon / self.mass
        refuse_points(r.real <= r_plus, x, f"does not lie outside the horizon r = {self.horizon:.6g}")
        Sigma = r * r + (xi @ a / r) ** 2
        return xi, a, r, Sigma, (r - r_plus) * (r - (2.0 - r_plus))


def horizon_radius(mass: float, spin: Sequence[float]) -> float:
    """``r_+ = M + sqrt(M^2 - a^2)``.  Raises `InvalidParameter`: the spin exceeds the mass."""
    a = sqrt(sum((component / mass) ** 2 for component in spin))
    if a > 1.0:
        raise InvalidParameter(f"there is no horizon: the spin {a * mass:.6g} exceeds the mass {mass:.6g}")
    return mass * (1.0 + sqrt((1.0 - a) * (1.0 + a)))
