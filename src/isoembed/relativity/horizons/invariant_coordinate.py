"""The invariant coordinate of a symmetric surface: what cos(theta) is on a round sphere.

A symmetry with the field phi, whose orbits close after 2 pi, has ``D_a zeta = (4 pi / A) eps_ba phi^b`` [1]_:
zeta goes from -1 to 1 and dA = A / 4 pi dzeta dphi.

References
----------
.. [1] A. Ashtekar, J. Engle, T. Pawlowski and C. Van Den Broeck, "Multipole moments of isolated horizons",
   Class. Quantum Grav. 21 (2004) 2549.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import legendre

from isoembed.arrays import Floats
from isoembed.meshing.sphere import fibonacci_directions, gauss_rule
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.transforms import analyzed, trimmed
from isoembed.smooth.two_metric import TwoMetric, area_density
from isoembed.thresholds import threshold


@dataclass(frozen=True)
class InvariantCoordinateThresholds:
    """Thresholds of invariant coordinates."""

    first_degree: int = threshold(32, "count", "Degree tried first for a metric symmetric about z.")
    highest_degree: int = threshold(512, "count", "Degree after which there is none.")
    settled: float = threshold(1e-15, "relative", "Size of the highest harmonics that are rounding.")
    nothing: float = threshold(5e-17, "relative", "Size of harmonics that are left out.")
    steps: int = threshold(20, "count", "Newton steps towards a pole, at most.")
    pole: float = threshold(1e-15, "radians", "Step towards a pole that is none.")


INVARIANT = InvariantCoordinateThresholds()


@dataclass(frozen=True, eq=False)
class InvariantCoordinate:
    """A function zeta of the direction that goes from one pole of a surface to the other.

    Attributes
    ----------
    harmonics : Harmonics
    coefficients : ndarray, shape (harmonics.size,)
        Of zeta.
    error : float
        How uncertain zeta is.
    axisymmetric : bool
        The metric is symmetric about the z-axis, and zeta a function of the height alone.
    """

    harmonics: Harmonics
    coefficients: Floats
    error: float
    axisymmetric: bool

    @classmethod
    def about_z(cls, metric: TwoMetric, relative_error: float = 0.0) -> InvariantCoordinate:
        """That of a metric which is symmetric about the z-axis, from the area of its caps."""
        t = INVARIANT
        degree = t.first_degree
        while True:
            u, weights = gauss_rule(degree + 1, 2)
            density, harmonics = analyzed(area_density(metric.tensor(u)), u, weights, degree, 0)
            sizes = np.abs(density) / density[0]
            tail = float(sizes[3 * degree // 4 :].max())
            if tail <= max(t.settled, relative_error) or 2 * degree > t.highest_degree:
                break
            degree *= 2
        density, harmonics = trimmed(density, harmonics, sizes > t.nothing)
        series = legendre.legint(density / density[0] * np.sqrt(2 * harmonics.labels[0] + 1), lbnd=0)
        ends = legendre.legval([-1.0, 1.0], series)
        series[0] -= 0.5 * (ends[0] + ends[1])
        norms = np.sqrt(4.0 * np.pi / (2 * np.arange(len(series)) + 1))
        return cls(Harmonics(len(series) - 1, 0), series * norms, t.settled + tail + relative_error, True)

    def derivatives(self, u: Floats) -> tuple[Floats, Floats]:
        """Zeta (n,) and its gradient (n, 3) on the unit sphere, at unit vectors u (n, 3)."""
        value, gradient, _ = self.harmonics.derivatives(u, self.coefficients)
        return value, gradient

    @property
    def poles(self) -> tuple[Floats, Floats]:
        """The directions (3,) where zeta is greatest and where it is least."""
        if self.axisymmetric:
            return np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, -1.0])
        return self._summit(1.0), self._summit(-1.0)

    def _summit(self, sign: float) -> Floats:
        u = fibonacci_directions(self.harmonics.size)
        u = u[[int(np.argmax(sign * self.derivatives(u)[0]))]]
        for _ in range(INVARIANT.steps):
            _, slope, bend = self.harmonics.derivatives(u, self.coefficients)
            # Along u, where the Hessian is nothing, its part is filled in.
            step = -np.linalg.solve(bend[0] - sign * np.outer(u[0], u[0]), slope[0])
            u = u + step
            u /= np.linalg.norm(u)
            if np.linalg.norm(step) <= INVARIANT.pole:
                break
        return np.asarray(u[0])
