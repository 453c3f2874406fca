"""Smooth maps of the sphere to itself: changes of coordinates."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter
from isoembed.mesh.triangulation import frozen
from isoembed.meshing.sphere import fibonacci_directions, gauss_rule
from isoembed.reprs import short_repr
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.two_metric import PulledBack, TwoMetric
from isoembed.smooth.uncertain import EXACT, Uncertainty

FAILED = 1e-9  # largest error of the inverse, in radians


@short_repr
@dataclass(frozen=True, eq=False)
class SphereMap:
    """Diffeomorphism ``u = F(v) = G(v) / |G(v)|`` of the sphere of directions, with G in harmonics.

    The new directions v denote the same points as the old ones u = F(v).  Affine maps, projected from a point
    inside, have degree 1: ``u ~ A v - c``; these include rotations.

    Attributes
    ----------
    harmonics : Harmonics
    coefficients : ndarray, shape (harmonics.size, 3)
        Coefficients of G, up to a factor.

    Raises
    ------
    InvalidParameter
        The Jacobian is not positive everywhere; the message names a direction.
    """

    harmonics: Harmonics
    coefficients: Floats

    def __post_init__(self) -> None:
        coefficients = np.array(self.coefficients, dtype=np.float64, order="C")
        if coefficients.shape != (self.harmonics.size, 3):
            raise InvalidParameter(
                f"a map in {self.harmonics.size} harmonics takes as many triples, not {coefficients.shape}"
            )
        object.__setattr__(self, "coefficients", frozen(coefficients))
        n = 3 * (self.harmonics.degree + 2)
        v, _ = gauss_rule(n, 2 * n)
        jacobian = self.jacobian(v)
        if not jacobian.min() > 0.0:
            i = int(np.argmin(jacobian))
            raise InvalidParameter(
                f"the map of the sphere folds: its Jacobian is {jacobian[i]:.3g} "
                f"in the direction {_written(v[i])}"
            )

    @classmethod
    def linear(cls, A: Floats) -> SphereMap:
        """Map ``u ~ A v`` for a matrix A (3, 3) of positive determinant, such as a rotation."""
        harmonics = Harmonics(1, 1)
        # Degree 1 is z, x and y, times sqrt(3 / 4 pi).
        axes = np.linalg.inv(harmonics.values(np.eye(3))[:, 1:])
        return cls(harmonics, np.vstack([np.zeros(3), axes @ np.asarray(A, dtype=np.float64).T]))

    @cached_property
    def rotation(self) -> Floats | None:
        """Rotation (3, 3) that equals the map; None if it is not a rotation."""
        if self.harmonics.degree != 1 or self.coefficients[0].any():
            return None
        squares = self.coefficients.T @ self.coefficients
        # The columns of a rotation are orthogonal and of equal length.
        even = np.abs(squares / squares[0, 0] - np.eye(3)).max() <= 1e-13
        return self.forward(np.eye(3)).T if even else None

    def forward(self, v: Floats) -> Floats:
        """Old directions F(v) (n, 3) of the new ones v (n, 3)."""
        return self._evaluated(v)[0]

    def differential(self, v: Floats) -> Floats:
        """Differential dF (n, 3, 3): ``dF @ w`` is the derivative along w; ``dF @ v = 0``."""
        return self._evaluated(v)[1]

    def jacobian(self, v: Floats) -> Floats:
        """Jacobian (n,), the ratio of areas, negative where the map reverses the orientation."""
        u, slope = self._evaluated(v)
        return np.linalg.det(_extended(slope, u, v))

    def inverse(self, u: Floats) -> Floats:
        """New directions v (n, 3) of the old ones, F(v) = u, by Newton's method.

        Raises
        ------
        InvalidParameter
            Newton's method does not converge; the message names the direction.
        """
        u = np.asarray(u, dtype=np.float64)
        tree, starts = self._starts
        v = starts[tree.query(u)[1]]
        errors = np.linalg.norm(u - self.forward(v), axis=1)
        part = np.ones(len(u))  # damping factors
        active = np.arange(len(u))
        for _ in range(60):  # Newton's method
            if not active.size:
                break
            image, slope = self._evaluated(v[active])
            error = u[active] - image
            error -= np.einsum("ni,ni->n", error, image)[:, None] * image
            step = np.linalg.solve(_extended(slope, image, v[active]), error[:, :, None])[:, :, 0]
            trial = v[active] + part[active, None] * step
            trial /= np.linalg.norm(trial, axis=1)[:, None]
            misses = np.linalg.norm(u[active] - self.forward(trial), axis=1)
            nearer = misses < errors[active]
            v[active[nearer]] = trial[nearer]
            part[active] *= np.where(nearer, 2.0, 0.5)
            part = np.minimum(part, 1.0)
            rounding = ~nearer & (errors[active] <= FAILED)
            errors[active[nearer]] = misses[nearer]
            active = active[~rounding & (errors[active] > 1e-15)]
        if not errors.max(initial=0.0) <= FAILED:
            i = int(np.argmax(errors))
            raise InvalidParameter(
                f"the inverse map of the sphere has an error of {errors[i]:.3g} at {_written(u[i])}"
            )
        return v

    @cached_property
    def _starts(self) -> tuple[cKDTree, Floats]:
        v = fibonacci_directions(4000)
        return cKDTree(self.forward(v)), v

    def _evaluated(self, v: Floats) -> tuple[Floats, Floats]:
        """F (n, 3) and dF (n, 3, 3)."""
        v = np.asarray(v, dtype=np.float64)
        G, slope, _ = self.harmonics.derivatives(v, self.coefficients)
        length = np.linalg.norm(G, axis=1)
        u = G / length[:, None]
        slope -= u[:, :, None] * np.einsum("ni,nij->nj", u, slope)[:, None, :]
        return u, slope / length[:, None, None]


def metric_in(metric: TwoMetric, coordinates: SphereMap | None) -> TwoMetric:
    """Metric as a function of the new directions of ``coordinates``, if given; its errors are kept."""
    if coordinates is None:
        return metric
    error = getattr(metric, "error", None)
    return PulledBack(
        coordinates.differential,
        lambda v: metric.tensor(coordinates.forward(v)),
        error if isinstance(error, Uncertainty) else EXACT,
    )


def _extended(slope: Floats, u: Floats, v: Floats) -> Floats:
    """Differential (n, 3, 3) extended to map v to u: invertible where the map is."""
    return slope + u[:, :, None] * v[:, None, :]


def _written(u: Floats) -> str:
    return f"({', '.join(f'{x:.6g}' for x in u)})"
