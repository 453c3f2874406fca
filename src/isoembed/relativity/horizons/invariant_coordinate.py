"""Invariant coordinate of an axisymmetric surface, as cos(theta) on a round sphere.

A symmetry with the field phi, whose orbits close after 2 pi, has ``D_a zeta = (4 pi / A) eps_ba phi^b`` [1]_:
zeta goes from -1 to 1 and dA = A / 4 pi dzeta dphi.

References
----------
.. [1] A. Ashtekar, J. Engle, T. Pawlowski and C. Van Den Broeck, "Multipole moments of isolated horizons",
   Class. Quantum Grav. 21 (2004) 2549.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial import legendre

from isoembed.arrays import Floats
from isoembed.meshing.sphere import fibonacci_directions, gauss_rule
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.isometry import SYMMETRIC_ANGLES
from isoembed.smooth.sphere_transform import SphereTransform
from isoembed.smooth.transforms import NEGLIGIBLE, ROUNDING, trimmed
from isoembed.smooth.two_metric import TwoMetric, area_density, is_axisymmetric

FEWEST_NODES, MOST_NODES = 24, 96  # heights of nodes of integrals over zeta
GROWTH = 1.5  # ratio of successive numbers of heights


@dataclass(frozen=True)
class Turned:
    """A metric as it is for directions w whose components are along other axes; a `TwoMetric`.

    Attributes
    ----------
    metric : TwoMetric
    frame : ndarray, shape (3, 3)
        The other axes: u is ``w @ frame``.
    """

    metric: TwoMetric
    frame: Floats

    def tensor(self, w: Floats) -> Floats:
        """See `TwoMetric`."""
        return self.frame @ self.metric.tensor(w @ self.frame) @ self.frame.T


@dataclass(frozen=True, eq=False)
class InvariantCoordinate:
    """A function zeta of the direction that goes from one pole of a surface to the other.

    Attributes
    ----------
    harmonics : Harmonics
    coefficients : ndarray, shape (harmonics.size,)
        Of zeta as a function of the components of directions in the frame.
    error : float
        How uncertain zeta is.
    frame : ndarray, shape (3, 3)
        Three axes at right angles.
    axisymmetric : bool
        The metric is symmetric about the third axis, and zeta a function of the height along it alone.
    """

    harmonics: Harmonics
    coefficients: Floats
    error: float
    frame: Floats
    axisymmetric: bool

    @classmethod
    def about(
        cls, metric: TwoMetric, axis: Sequence[float] = (0.0, 0.0, 1.0), relative_error: float = 0.0
    ) -> InvariantCoordinate | None:
        """Coordinate of a metric that is symmetric about an axis, from the area of caps; None if it is not.

        Parameters
        ----------
        metric : TwoMetric
        axis : three floats
            A unit vector.
        relative_error : float
            The uncertainty of lengths.
        """
        # Rounding in a frame that is that of the coordinates would be seen as less symmetry.
        frame = np.eye(3) if tuple(axis) == (0.0, 0.0, 1.0) else np.roll(_frame(np.array(axis)), -1, axis=0)
        turned = Turned(metric, frame)
        if not is_axisymmetric(turned):
            return None
        degree = 32  # first degree; it is doubled
        while True:
            harmonics = Harmonics(degree, 0)
            transform = SphereTransform(harmonics, degree + 1, SYMMETRIC_ANGLES)
            density = transform.analysis(area_density(turned.tensor(transform.u))[:, None])[:, 0]
            sizes = np.abs(density) / density[0]
            tail = float(sizes[3 * degree // 4 :].max())
            if tail <= max(ROUNDING, relative_error) or 2 * degree > 512:
                break
            degree *= 2
        density, harmonics = trimmed(density, harmonics, sizes > NEGLIGIBLE)
        series = legendre.legint(density / density[0] * np.sqrt(2 * harmonics.labels[0] + 1), lbnd=0)
        ends = legendre.legval([-1.0, 1.0], series)
        series[0] -= 0.5 * (ends[0] + ends[1])
        norms = np.sqrt(4.0 * np.pi / (2 * np.arange(len(series)) + 1))
        error = ROUNDING + tail + relative_error
        return cls(Harmonics(len(series) - 1, 0), series * norms, error, frame, True)

    @classmethod
    def of_potential(cls, coefficients: Floats, harmonics: Harmonics, error: float) -> InvariantCoordinate:
        """Coordinate of a rotation from its potential over A / 4 pi, and the error of that."""
        return cls(harmonics, coefficients, error, np.eye(3), False)

    def derivatives(self, u: Floats) -> tuple[Floats, Floats]:
        """Zeta (n,) and its gradient (n, 3) on the unit sphere, at unit vectors u (n, 3)."""
        value, gradient, _ = self.harmonics.derivatives(u @ self.frame.T, self.coefficients)
        return value, gradient @ self.frame

    def rule(self, n: int, around: int) -> tuple[Floats, Floats]:
        """Nodes (n * around, 3) and weights of a `gauss_rule` about the third axis of the frame."""
        w, weights = gauss_rule(n, around)
        return w @ self.frame, weights

    @property
    def axis(self) -> Floats:
        """The unit vector (3,) along which zeta rises, in the mean over directions."""
        degrees, orders = self.harmonics.labels
        x, y, z = (self.coefficients[(degrees == 1) & (orders == m)].sum() for m in (1, -1, 0))
        axis = np.array([x, y, z]) @ self.frame  # of a symmetry, there are no x and y
        return np.asarray(axis / np.linalg.norm(axis))

    def reversed(self) -> InvariantCoordinate:
        """The coordinate with the poles exchanged."""
        return replace(self, coefficients=-self.coefficients)

    @property
    def poles(self) -> tuple[Floats, Floats]:
        """The directions (3,) where zeta is greatest and where it is least."""
        if self.axisymmetric:
            return self.frame[2], -self.frame[2]
        return self._summit(1.0), self._summit(-1.0)

    def _summit(self, sign: float) -> Floats:
        u = fibonacci_directions(self.harmonics.size)
        u = u[[int(np.argmax(sign * self.harmonics.derivatives(u, self.coefficients)[0]))]]
        for _ in range(20):  # Newton's method
            _, slope, bend = self.harmonics.derivatives(u, self.coefficients)
            # Along u, where the Hessian is nothing, its part is filled in.
            step = -np.linalg.solve(bend[0] - sign * np.outer(u[0], u[0]), slope[0])
            u = u + step
            u /= np.linalg.norm(u)
            if np.linalg.norm(step) <= 1e-15:  # rounding
                break
        return np.asarray(u[0] @ self.frame)


def _frame(axis: Floats) -> Floats:
    """An axis and two more at right angles to it and to one another, as rows."""
    across = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    across /= np.linalg.norm(across)
    return np.stack([axis, across, np.cross(axis, across)])
