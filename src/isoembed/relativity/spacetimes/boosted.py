"""Black holes in motion: Schwarzschild's in a slice of an observer whom it passes, and several superposed."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter
from isoembed.relativity.spacetimes.checks import positive_number, refuse_points, vector
from isoembed.relativity.spacetimes.three_geometry import AnalyticGeometry, Numbers


@dataclass(frozen=True)
class BoostedSchwarzschild(AnalyticGeometry):
    """The slice t = 0 of Schwarzschild's spacetime in isotropic coordinates t', x' that move: a boosted hole.

    ``t' = W (t - v . x)`` and ``|x'|^2 = |x|^2 + W^2 (v . x)^2`` at t = 0, W Lorentz's factor, x from the
    hole, make of ``-N^2 dt'^2 + psi^4 dx'^2`` the metric
    ``gamma_ij = psi^4 delta_ij + W^2 (psi^4 - N^2) v_i v_j``.  Energy and momentum at infinity are W M and
    W M v.

    Attributes
    ----------
    mass : float
        M, the unit of length.
    velocity : three floats
        The vector v of the hole, over that of light.
    position : three floats
        Of the puncture.

    Raises
    ------
    InvalidParameter
        The mass is not positive, or the speed not below 1.

    Notes
    -----
    With K_ij as in `three_geometry` and d_t = -v . d, the factors N of the lapse cancel, and K_ij is regular
    on the throat |x'| = M / 2, too.

    References
    ----------
    Huq, Choptuik and Matzner, Phys. Rev. D 66 (2002) 084024, on boosted holes.
    """

    mass: float
    velocity: Sequence[float]
    position: Sequence[float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        object.__setattr__(self, "mass", positive_number("the mass", self.mass))
        object.__setattr__(self, "velocity", vector("the velocity", self.velocity))
        object.__setattr__(self, "position", vector("the position", self.position))
        speed = float(np.linalg.norm(self.velocity))
        if not speed < 1.0:
            raise InvalidParameter(f"the speed must be less than that of light, 1, not {speed:.6g}")

    @property
    def time_symmetric(self) -> bool:
        """See `ThreeGeometry`."""
        return not any(self.velocity)

    @property
    def black_holes(self) -> tuple[tuple[float, Sequence[float]], ...]:
        """The mass and the position of each."""
        return ((self.mass, self.position),)

    @property
    def lorentz_factor(self) -> float:
        """``W = (1 - v^2)^(-1/2)``."""
        speed = float(np.linalg.norm(self.velocity))
        return float(1.0 / np.sqrt((1.0 - speed) * (1.0 + speed)))

    def spheroid(self, radius: float) -> Callable[[Floats], Floats]:
        """Distance (n,) from the hole, by direction, of the surface of one isotropic radius |x'|."""
        positive_number("the radius", radius)
        w = self._proper_velocity
        return lambda u: radius / np.sqrt(1.0 + (u @ w) ** 2)

    def metric(self, x: Numbers) -> Numbers:
        """See `ThreeGeometry`; x may be complex."""
        (_, _, psi, N), w = self._at_rest(x), self._proper_velocity
        A = psi**4
        return A[:, None, None] * np.eye(3) + (A - N**2)[:, None, None] * np.outer(w, w)

    def extrinsic_curvature(self, x: Floats) -> Floats:
        """See `ThreeGeometry`."""
        d, rho, psi, N = self._at_rest(x)
        v, W = np.array(self.velocity), self.lorentz_factor
        A, m = psi**4, 0.5 / rho
        slope = (d + W**2 * (d @ v)[:, None] * v) / rho[:, None]  # d_i rho
        F = (4.0 * m * psi**2 * (2.0 - m) / rho)[:, None] * slope  # 2 A d_i N - N d_i A
        stretching = -4.0 * psi**3 * m / rho * (slope @ v)  # v . d A
        mixing = stretching - 4.0 * N * m / (rho * psi**2) * (slope @ v)  # of B = A - N^2
        mixed = W**2 * F[:, :, None] * v
        total = mixed + mixed.transpose(0, 2, 1)
        total += (N * stretching)[:, None, None] * np.eye(3)
        total += (N * mixing)[:, None, None] * W**2 * np.outer(v, v)
        E = A + W**2 * (A - N**2) * (v @ v)
        return np.asarray(total / (2.0 * np.sqrt(A * E))[:, None, None] / self.mass)

    @property
    def _proper_velocity(self) -> Floats:
        """``W v``."""
        return self.lorentz_factor * np.array(self.velocity)

    def _at_rest(self, x: Numbers) -> tuple[Numbers, Numbers, Numbers, Numbers]:
        """Points from the hole (n, 3) and their isotropic radii (n,), over M; psi (n,), and the lapse N (n,).

        N is negative beyond the throat.
        """
        d = (x - np.array(self.position)) / self.mass
        rho2 = np.einsum("ni,ni->n", d, d) + (d @ self._proper_velocity) ** 2
        refuse_points(rho2.real <= 0.0, x, "is a puncture")
        rho = np.sqrt(rho2)
        return d, rho, 1.0 + 0.5 / rho, (rho - 0.5) / (rho + 0.5)


@dataclass(frozen=True)
class Superposed(AnalyticGeometry):
    """Several slices added: ``gamma = delta + sum (gamma_k - delta)``, ``K = sum K_k``.  No solution.

    The constraints of Einstein's equations are violated by products of what the holes do to one another: of
    the order M^2 / d^4 at a distance d from them.  For demonstrations on surfaces around holes in motion.

    Attributes
    ----------
    holes : sequence of AnalyticGeometry
        Such as `BoostedSchwarzschild`.

    Raises
    ------
    InvalidParameter
        There is none.
    """

    holes: Sequence[AnalyticGeometry]

    def __post_init__(self) -> None:
        object.__setattr__(self, "holes", tuple(self.holes))
        if not self.holes:
            raise InvalidParameter("there is no hole to superpose")

    @property
    def time_symmetric(self) -> bool:
        """See `ThreeGeometry`."""
        return all(hole.time_symmetric for hole in self.holes)

    @property
    def black_holes(self) -> tuple[tuple[float, Sequence[float]], ...]:
        """The mass and the position of each."""
        return tuple(each for hole in self.holes for each in getattr(hole, "black_holes", ()))

    def metric(self, x: Numbers) -> Numbers:
        """See `ThreeGeometry`; x may be complex."""
        flat = np.eye(3)
        return np.asarray(flat + sum(hole.metric(x) - flat for hole in self.holes))

    def extrinsic_curvature(self, x: Floats) -> Floats:
        """See `ThreeGeometry`."""
        return np.asarray(sum(hole.extrinsic_curvature(x) for hole in self.holes))
