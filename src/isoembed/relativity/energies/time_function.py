"""Time functions tau of the Wang-Yau energy, and the metric g + d tau^2."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter
from isoembed.meshing.sphere import fibonacci_directions
from isoembed.relativity.spacetimes.surface_data import values_of
from isoembed.reprs import short_repr
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.sphere_map import SphereMap
from isoembed.smooth.sphere_transform import SphereTransform
from isoembed.smooth.two_metric import TwoMetric

DEGREE = 16  # degree of the projection of functions


@short_repr
@dataclass(frozen=True)
class TimeFunction:
    """Function tau on the sphere of directions, in spherical harmonics.

    Attributes
    ----------
    harmonics : Harmonics
    coefficients : ndarray, shape (size,)
        Coefficients in the unit of length.  That of the constant harmonic has no effect.
    coordinates : SphereMap, optional
        Map u = F(v) from the directions v of the harmonics, by default the identity; see `SmoothEmbedding`.
    """

    harmonics: Harmonics
    coefficients: Floats
    coordinates: SphereMap | None = None

    def __post_init__(self) -> None:
        if np.shape(self.coefficients) != (self.harmonics.size,):
            raise InvalidParameter(
                f"{self.harmonics.size} harmonics require as many coefficients, not "
                f"{np.shape(self.coefficients)}"
            )

    @classmethod
    def zero(cls) -> TimeFunction:
        """Time function tau = 0."""
        return cls.from_array(np.zeros(4))

    @classmethod
    def from_array(cls, coefficients: Floats) -> TimeFunction:
        """Time function with (L + 1)^2 coefficients in harmonics up to degree L, sorted as in `Harmonics`."""
        degree = int(np.sqrt(np.size(coefficients))) - 1
        if np.ndim(coefficients) != 1 or (degree + 1) ** 2 != np.size(coefficients) or degree < 1:
            raise InvalidParameter(
                f"the coefficients of tau have the shape {np.shape(coefficients)}, not ((L + 1)^2,), L >= 1"
            )
        return cls(Harmonics(degree, degree), np.asarray(coefficients, dtype=np.float64))

    @classmethod
    def of(cls, function: Callable[[Floats], ArrayLike], degree: int = DEGREE) -> TimeFunction:
        """Projection of a function of directions u (n, 3), with values (n,), onto harmonics up to a degree.

        Raises
        ------
        InvalidParameter
            The values have a wrong shape or are not finite, or the harmonics do not resolve the function.
        """
        harmonics = Harmonics(degree, degree)
        transform = SphereTransform(harmonics, 2 * degree + 2, 4 * degree + 4)
        tau = cls(harmonics, transform.analysis(values_of(function, transform.u, "tau")[:, None])[:, 0])
        u = fibonacci_directions(1000)  # check points of the projection
        values = values_of(function, u, "tau")
        misfit = float(np.abs(tau.values(u) - values).max())
        if misfit > 1e-7 * np.abs(values).max():  # of the largest value
            raise InvalidParameter(
                f"harmonics up to degree {degree} have an error of {misfit:.3g} for tau, which must be smooth"
            )
        return tau

    def in_coordinates(self, coordinates: SphereMap | None) -> TimeFunction:
        """Time function of the directions v of a map u = F(v), or of u itself, in harmonics of these.

        Raises
        ------
        InvalidParameter
            Harmonics of twice the default degree do not resolve it.
        """
        if self.coordinates is coordinates:
            return self if coordinates is None else replace(self, coordinates=None)
        if coordinates is None:
            return TimeFunction.of(self.values, 2 * DEGREE)
        rotated = self.coordinates is None and coordinates.rotation is not None
        degree = self.harmonics.degree if rotated else 2 * DEGREE
        return TimeFunction.of(lambda v: self.values(coordinates.forward(v)), degree)

    def values(self, u: Floats) -> Floats:
        """Tau (n,) in the directions u (n, 3)."""
        v = u if self.coordinates is None else self.coordinates.inverse(u)
        return self.harmonics.values(v) @ self.coefficients

    def gradient(self, u: Floats) -> Floats:
        """Gradient of tau as tangent vectors (n, 3) of the unit sphere."""
        if self.coordinates is None:
            return self.harmonics.gradients(u)[1] @ self.coefficients
        v = self.coordinates.inverse(u)
        slope = self.harmonics.gradients(v)[1] @ self.coefficients
        # dF maps v to 0; the added term makes it invertible without affecting tangent vectors.
        full = self.coordinates.differential(v) + u[:, :, None] * v[:, None, :]
        return np.asarray(np.linalg.solve(full.transpose(0, 2, 1), slope[:, :, None])[:, :, 0])


@dataclass(frozen=True)
class TimeRaisedMetric:
    """Metric ``q + d tau d tau`` of the projection of a surface in Minkowski space to R^3."""

    metric: TwoMetric
    tau: TimeFunction

    def tensor(self, u: Floats) -> Floats:
        """See `TwoMetric`."""
        slope = self.tau.gradient(u)
        return self.metric.tensor(u) + slope[:, :, None] * slope[:, None, :]
