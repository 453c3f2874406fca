"""Time-symmetric slices with ``gamma_ij = psi^4 delta_ij``: one black hole, or several at rest."""

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from isoembed.errors import InvalidParameter
from isoembed.relativity.spacetimes.checks import positive_number, refuse_points, vector
from isoembed.relativity.spacetimes.three_geometry import AnalyticGeometry, Numbers


class _Punctures(AnalyticGeometry):
    """Holes of given masses at given positions, ``psi = 1 + sum_k m_k / (2 |x - x_k|)``."""

    @property
    @abstractmethod
    def black_holes(self) -> tuple[tuple[float, Sequence[float]], ...]:
        """The mass and the position of each."""

    def conformal_factor(self, x: Numbers) -> Numbers:
        """The factor psi (n,) at the points x (n, 3), which may be complex."""
        psi = np.ones(len(x), dtype=x.dtype)
        for mass, position in self.black_holes:
            d = (x - np.array(position)) / mass
            r2 = np.einsum("ni,ni->n", d, d)
            refuse_points(r2.real <= 0.0, x, "is a puncture")
            psi = psi + 0.5 / np.sqrt(r2)
        return psi

    def metric(self, x: Numbers) -> Numbers:
        """See `ThreeGeometry`; x may be complex."""
        return (self.conformal_factor(x) ** 4)[:, None, None] * np.eye(3)


@dataclass(frozen=True)
class IsotropicSchwarzschild(_Punctures):
    """Schwarzschild's black hole in isotropic coordinates, ``psi = 1 + M / (2 |x|)``.

    Attributes
    ----------
    mass : float
        M, the unit of length.  The horizon lies at M / 2 from the puncture.
    """

    mass: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "mass", positive_number("the mass", self.mass))

    @property
    def black_holes(self) -> tuple[tuple[float, Sequence[float]], ...]:
        """The mass and the position of each."""
        return ((self.mass, (0.0, 0.0, 0.0)),)


@dataclass(frozen=True)
class BrillLindquist(_Punctures):
    """Black holes at a moment of time symmetry, ``psi = 1 + sum_k m_k / (2 |x - x_k|)``.

    Attributes
    ----------
    masses : sequence of float
        m_k, lengths; the mass at infinity is their sum.
    positions : sequence of three floats each
        x_k.

    References
    ----------
    Brill and Lindquist, Phys. Rev. 131 (1963) 471.
    """

    masses: Sequence[float]
    positions: Sequence[Sequence[float]]

    def __post_init__(self) -> None:
        masses = tuple(positive_number(f"mass {k}", mass) for k, mass in enumerate(self.masses))
        positions = tuple(vector(f"position {k}", position) for k, position in enumerate(self.positions))
        if len(masses) != len(positions) or not masses:
            raise InvalidParameter(
                f"{len(masses)} masses at {len(positions)} positions: there must be one for each"
            )
        object.__setattr__(self, "masses", masses)
        object.__setattr__(self, "positions", positions)

    @property
    def black_holes(self) -> tuple[tuple[float, Sequence[float]], ...]:
        """The mass and the position of each."""
        return tuple(zip(self.masses, self.positions, strict=True))
