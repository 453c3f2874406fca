"""Schwarzschild's black hole in slices that are flat."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats
from isoembed.relativity.spacetimes.checks import positive_number, refuse_points
from isoembed.relativity.spacetimes.three_geometry import AnalyticGeometry, Numbers


@dataclass(frozen=True)
class PainleveGullstrand(AnalyticGeometry):
    """``gamma_ij = delta_ij``, ``K_ij = sqrt(2 M / r^3) (delta_ij - 3/2 n_i n_j)``, regular to r = 0.

    Lapse 1 and shift ``beta^i = sqrt(2 M / r) n^i``: the slices of observers that fall from rest at infinity.

    Attributes
    ----------
    mass : float
        M, the unit of length.
    """

    mass: float
    time_symmetric = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "mass", positive_number("the mass", self.mass))

    @property
    def black_holes(self) -> tuple[tuple[float, Sequence[float]], ...]:
        """The mass and the position of each."""
        return ((self.mass, (0.0, 0.0, 0.0)),)

    def metric(self, x: Numbers) -> Numbers:
        """See `ThreeGeometry`."""
        return np.tile(np.eye(3), (len(x), 1, 1))

    def extrinsic_curvature(self, x: Floats) -> Floats:
        """See `ThreeGeometry`."""
        xi = x / self.mass
        r = np.linalg.norm(xi, axis=1)
        refuse_points(r == 0.0, x, "is the singularity")
        n = xi / r[:, None]
        rate = np.sqrt(2.0 / r**3) / self.mass
        return rate[:, None, None] * (np.eye(3) - 1.5 * n[:, :, None] * n[:, None, :])
