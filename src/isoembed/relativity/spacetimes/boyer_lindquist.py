"""Kerr's black hole outside its horizon, in the Boyer-Lindquist slicing."""

from dataclasses import dataclass

import numpy as np

from isoembed.relativity.spacetimes.checks import refuse_points
from isoembed.relativity.spacetimes.kerr_schild import KerrSlice, horizon_radius
from isoembed.relativity.spacetimes.three_geometry import Floats, Numbers, complex_step


@dataclass(frozen=True)
class BoyerLindquist(KerrSlice):
    """The coordinates are x = r sin(theta) cos(phi), ... with the Boyer-Lindquist r, theta and phi.

    In them, with n = x / r and the vector a, free of coordinate singularities on the axis,
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

    def metric(self, x: Numbers) -> Numbers:
        """See `ThreeGeometry`; x may be complex, and lies outside the horizon.

        Raises
        ------
        InvalidParameter
            A point does not.
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

        Of the shift ``-w a x x``, a multiple of a Killing vector, only the gradient of w contributes.
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
