"""Smooth maps of the sphere onto itself: other coordinates for metrics and functions of the direction."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter
from isoembed.meshing.sphere import fibonacci_directions, gauss_rule
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.two_metric import PulledBack, TwoMetric
from isoembed.smooth.uncertain import EXACT, Uncertainty
from isoembed.thresholds import threshold


@dataclass(frozen=True)
class SphereMapThresholds:
    """Thresholds of maps of the sphere onto itself."""

    nodes: int = threshold(3, "count", "Heights of nodes for each degree at which the Jacobian is checked.")
    starts: int = threshold(4000, "count", "Directions whose images the inverse begins at.")
    steps: int = threshold(60, "count", "Most Newton steps of the inverse.")
    exact: float = threshold(1e-15, "radians", "Newton step that is the last, in the old directions.")
    failed: float = threshold(1e-9, "radians", "Error of the inverse that is a failure.")


SPHERE_MAP = SphereMapThresholds()


@dataclass(frozen=True, eq=False)
class SphereMap:
    """The diffeomorphism ``u = F(v) = G(v) / |G(v)|`` of the sphere of directions, G in harmonics.

    The new directions v name the same points as the old ones u = F(v).  Linear maps seen from any point inside
    are of degree 1: ``u ~ A v - c``, rotations among them.

    Attributes
    ----------
    harmonics : Harmonics
    coefficients : ndarray, shape (harmonics.size, 3)
        Those of G, up to a factor.

    Raises
    ------
    InvalidParameter
        The Jacobian is not positive everywhere; the message names a direction.
    """

    harmonics: Harmonics
    coefficients: Floats

    def __post_init__(self) -> None:
        coefficients = np.array(self.coefficients, dtype=np.float64)
        if coefficients.shape != (self.harmonics.size, 3):
            raise InvalidParameter(
                f"a map in {self.harmonics.size} harmonics takes as many triples, not {coefficients.shape}"
            )
        coefficients.setflags(write=False)
        object.__setattr__(self, "coefficients", coefficients)
        n = SPHERE_MAP.nodes * (self.harmonics.degree + 2)
        v, _ = gauss_rule(n, 2 * n)
        jacobian = self.jacobian(v)
        if not jacobian.min() > 0.0:
            i = int(np.argmin(jacobian))
            raise InvalidParameter(
                f"the map of the sphere folds: its Jacobian is {jacobian[i]:.3g} in the direction "
                f"{', '.join(f'{x:.6g}' for x in v[i])}"
            )

    @classmethod
    def linear(cls, A: Floats) -> SphereMap:
        """The map ``u ~ A v`` for a matrix A (3, 3) of positive determinant; a rotation, for one."""
        harmonics = Harmonics(1, 1)
        # Degree 1 is z, x and y, times the root of 3 / 4 pi.
        axes = np.linalg.inv(harmonics.values(np.eye(3))[:, 1:])
        return cls(harmonics, np.vstack([np.zeros(3), axes @ np.asarray(A, dtype=np.float64).T]))

    def forward(self, v: Floats) -> Floats:
        """The old directions F(v) (n, 3) of the new ones v (n, 3)."""
        return self._evaluated(v)[0]

    def differential(self, v: Floats) -> Floats:
        """The differential dF (n, 3, 3): ``dF @ w`` is the derivative along a tangent vector w, ``dF @ v = 0``."""
        return self._evaluated(v)[1]

    def jacobian(self, v: Floats) -> Floats:
        """The area (n,) of the images of small areas over these, negative where the map reverses them."""
        u, dF = self._evaluated(v)
        return np.linalg.det(dF + u[:, :, None] * v[:, None, :])

    def inverse(self, u: Floats) -> Floats:
        """The new directions v (n, 3) of the old ones, F(v) = u, by Newton's method.

        Raises
        ------
        InvalidParameter
            It does not converge; the message names the direction.
        """
        u = np.asarray(u, dtype=np.float64)
        tree, starts = self._starts
        v = starts[tree.query(u)[1]]
        image, dF = self._evaluated(v)
        distance = np.linalg.norm(u - image, axis=1)
        length = np.ones(len(u))
        active = np.arange(len(u))
        for _ in range(SPHERE_MAP.steps):
            # Of the error, the part that is tangent to the sphere at the image.
            error = u[active] - image[active]
            error -= np.einsum("ni,ni->n", error, image[active])[:, None] * image[active]
            step = np.linalg.solve(
                dF[active] + image[active][:, :, None] * v[active][:, None, :], error[:, :, None]
            )[:, :, 0]
            trial = v[active] + length[active, None] * step
            trial /= np.linalg.norm(trial, axis=1)[:, None]
            found, slope = self._evaluated(trial)
            apart = np.linalg.norm(u[active] - found, axis=1)
            better = apart < distance[active]
            good = active[better]
            v[good], image[good], dF[good] = trial[better], found[better], slope[better]
            distance[good] = apart[better]
            length[active] = np.where(better, np.minimum(1.0, 2.0 * length[active]), 0.5 * length[active])
            done = (distance[active] <= SPHERE_MAP.exact) | (
                ~better & (np.linalg.norm(error, axis=1) <= SPHERE_MAP.failed)
            )
            active = active[~done]
            if not active.size:
                break
        if not distance.max(initial=0.0) <= SPHERE_MAP.failed:
            i = int(np.argmax(distance))
            raise InvalidParameter(
                f"the map of the sphere could not be inverted: it misses {', '.join(f'{x:.6g}' for x in u[i])}"
                f" by {distance[i]:.3g}"
            )
        return v

    def turned(self, R: Floats) -> SphereMap:
        """The map followed by the rotation R (3, 3)."""
        return SphereMap(self.harmonics, self.coefficients @ np.asarray(R).T)

    @cached_property
    def _starts(self) -> tuple[cKDTree, Floats]:
        v = fibonacci_directions(SPHERE_MAP.starts)
        return cKDTree(self.forward(v)), v

    def _evaluated(self, v: Floats) -> tuple[Floats, Floats]:
        """F (n, 3) and dF (n, 3, 3)."""
        v = np.asarray(v, dtype=np.float64)
        G, dG = np.empty((len(v), 3)), np.empty((len(v), 3, 3))
        for i, c in enumerate(self.coefficients.T):
            G[:, i], dG[:, i], _ = self.harmonics.derivatives(v, np.ascontiguousarray(c))
        length = np.linalg.norm(G, axis=1)
        u = G / length[:, None]
        dG -= u[:, :, None] * np.einsum("ni,nij->nj", u, dG)[:, None, :]
        return u, dG / length[:, None, None]


def metric_in(metric: TwoMetric, coordinates: SphereMap) -> PulledBack:
    """The same metric as a function of the new directions; errors of its lengths are handed on."""
    error = getattr(metric, "error", None)
    return PulledBack(
        coordinates.differential,
        lambda v: metric.tensor(coordinates.forward(v)),
        error if isinstance(error, Uncertainty) else EXACT,
    )
