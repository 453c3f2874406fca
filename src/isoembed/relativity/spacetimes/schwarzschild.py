"""Closed-form slices of nonspinning black holes: Schwarzschild, several at rest, or boosted."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter
from isoembed.relativity.spacetimes.checks import positive_number, refuse_points, vector
from isoembed.relativity.spacetimes.three_geometry import AnalyticGeometry, Numbers


@dataclass(frozen=True)
class OneHole(AnalyticGeometry):
    """Slice with one black hole, whose mass M is the unit of length."""

    mass: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "mass", positive_number("the mass", self.mass))

    @property
    def black_holes(self) -> tuple[tuple[float, Sequence[float]], ...]:
        """See `ThreeGeometry`: one hole at the origin."""
        return ((self.mass, (0.0, 0.0, 0.0)),)


class _Punctures(AnalyticGeometry):
    """Punctures of given masses and positions, ``psi = 1 + sum_k m_k / (2 |x - x_k|)``."""

    def conformal_factor(self, x: Numbers) -> Numbers:
        """Conformal factor psi (n,) at points x (n, 3), which may be complex."""
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
class IsotropicSchwarzschild(OneHole, _Punctures):
    """Schwarzschild black hole in isotropic coordinates, ``psi = 1 + M / (2 |x|)``.

    Attributes
    ----------
    mass : float
        M, the unit of length.  The horizon lies at M / 2 from the puncture.
    """


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
        """See `ThreeGeometry`."""
        return tuple(zip(self.masses, self.positions, strict=True))


@dataclass(frozen=True)
class PainleveGullstrand(OneHole):
    """Schwarzschild black hole in flat slices, ``K_ij = sqrt(2 M / r^3) (delta_ij - 3/2 n_i n_j)``.

    The slices are regular for all r > 0.  Lapse 1 and shift ``beta^i = sqrt(2 M / r) n^i`` are those of
    observers in free fall from rest at infinity.

    Attributes
    ----------
    mass : float
        M, the unit of length.
    """

    time_symmetric = False

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


@dataclass(frozen=True)
class BoostedSchwarzschild(OneHole):
    """Boosted black hole: slice t = 0 of Schwarzschild spacetime in moving isotropic coordinates t', x'.

    With ``t' = W (t - v . x)`` and ``|x'|^2 = |x|^2 + W^2 (v . x)^2`` at t = 0, W the Lorentz factor and x
    relative to the hole, ``-N^2 dt'^2 + psi^4 dx'^2`` induces the metric
    ``gamma_ij = psi^4 delta_ij + W^2 (psi^4 - N^2) v_i v_j``.  Energy and momentum at infinity are W M and
    W M v.

    Attributes
    ----------
    mass : float
        M, the unit of length.
    velocity : three floats
        Velocity v of the hole, in units of the speed of light.
    position : three floats
        Position of the puncture.

    Raises
    ------
    InvalidParameter
        The mass is not positive, or the speed is not less than 1.

    Notes
    -----
    With K_ij as in `three_geometry` and d_t = -v . d, the factors N of the lapse cancel, so that K_ij is also
    regular on the throat |x'| = M / 2.

    References
    ----------
    Huq, Choptuik and Matzner, Phys. Rev. D 66 (2002) 084024, on boosted holes.
    """

    velocity: Sequence[float]
    position: Sequence[float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "velocity", vector("the velocity", self.velocity))
        object.__setattr__(self, "position", vector("the position", self.position))
        speed = float(np.linalg.norm(self.velocity))
        if not speed < 1.0:
            raise InvalidParameter(f"the speed must be less than that of light, 1, not {speed:.6g}")

    @property
    def black_holes(self) -> tuple[tuple[float, Sequence[float]], ...]:
        """See `ThreeGeometry`."""
        return ((self.mass, self.position),)

    @property
    def time_symmetric(self) -> bool:
        """See `ThreeGeometry`."""
        return not any(self.velocity)

    @property
    def lorentz_factor(self) -> float:
        """``W = (1 - v^2)^(-1/2)``."""
        speed = float(np.linalg.norm(self.velocity))
        return float(1.0 / np.sqrt((1.0 - speed) * (1.0 + speed)))

    def spheroid(self, radius: float) -> Callable[[Floats], Floats]:
        """Distance (n,) of the surface of an isotropic radius |x'| from the hole, by direction."""
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
        """Points relative to the hole (n, 3) and isotropic radii (n,), over M; psi (n,) and lapse N (n,).

        N is negative beyond the throat.
        """
        d = (x - np.array(self.position)) / self.mass
        rho2 = np.einsum("ni,ni->n", d, d) + (d @ self._proper_velocity) ** 2
        refuse_points(rho2.real <= 0.0, x, "is a puncture")
        rho = np.sqrt(rho2)
        return d, rho, 1.0 + 0.5 / rho, (rho - 0.5) / (rho + 0.5)


@dataclass(frozen=True)
class Superposed(AnalyticGeometry):
    """Superposition of slices: ``gamma = delta + sum (gamma_k - delta)``, ``K = sum K_k``.

    This is not a solution of the constraints of Einstein's equations, which are violated by products of the
    fields of the holes, of the order M^2 / d^4 at a distance d.  For demonstrations with moving holes.

    Attributes
    ----------
    holes : sequence of AnalyticGeometry
        Slices of single holes, such as `BoostedSchwarzschild`.

    Raises
    ------
    InvalidParameter
        There are no holes.
    """

    holes: Sequence[AnalyticGeometry]

    def __post_init__(self) -> None:
        object.__setattr__(self, "holes", tuple(self.holes))
        if not self.holes:
            raise InvalidParameter("there are no holes to superpose")

    @property
    def time_symmetric(self) -> bool:
        """See `ThreeGeometry`."""
        return all(hole.time_symmetric for hole in self.holes)

    @property
    def black_holes(self) -> tuple[tuple[float, Sequence[float]], ...]:
        """See `ThreeGeometry`."""
        return tuple(each for hole in self.holes for each in hole.black_holes)

    def metric(self, x: Numbers) -> Numbers:
        """See `ThreeGeometry`; x may be complex."""
        flat = np.eye(3)
        return np.asarray(flat + sum(hole.metric(x) - flat for hole in self.holes))

    def gradient(self, x: Floats) -> Floats:
        """See `ThreeGeometry`."""
        return np.asarray(sum(hole.gradient(x) for hole in self.holes))

    def extrinsic_curvature(self, x: Floats) -> Floats:
        """See `ThreeGeometry`."""
        return np.asarray(sum(hole.extrinsic_curvature(x) for hole in self.holes))
