"""Isometry equations in many harmonics, by matrix-free conjugate gradients.

No matrix is stored: the Jacobian of the strains and its adjoint are applied by fast transforms.  The unknowns
are scaled by their degree, which makes the equations of the round sphere well conditioned in all degrees;
conjugate gradients for least squares (CGLS) then take a few hundred iterations, more if the Gaussian
curvature is negative.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from isoembed.arrays import Floats
from isoembed.nonlinear.acceptance import LineSearch
from isoembed.smooth.isometry import MetricSamples, Tangents, check_start, flat_tangents, tangents_in
from isoembed.smooth.sphere_transform import SphereTransform
from isoembed.smooth.two_metric import angle_frame
from isoembed.space import EUCLIDEAN, Space

ITERATIVE_OVERSAMPLING = 1.3  # ratio of nodes to coefficients in each direction
SEARCH = LineSearch(decrease=0.0, shortest=2.0**-7)
EXACT = 1e-5  # relative gradient and residual of deformations, which are not corrected by later steps


@dataclass(frozen=True, eq=False)
class MatrixFreeIsometry:
    """Equations ``X_a . X_b = delta_ab``, or with another right-hand side, at the nodes of a transform.

    Attributes
    ----------
    transform : SphereTransform
    unit : float
        Unit of length of the equations: the radius of the sphere with the area of the metric.
    frames : ndarray, shape (n, 2, 2)
        Orthonormal vectors of the metric, as components along e_theta and e_phi.
    root : ndarray, shape (n,)
        Square roots of the fractions of the area at the nodes.
    space : Space
        Ambient space, in that unit.  In curved space the centroid is the origin.
    """

    transform: SphereTransform
    unit: float
    frames: Floats
    root: Floats
    space: Space = EUCLIDEAN

    @classmethod
    def of(
        cls, transform: SphereTransform, samples: MetricSamples, space: Space = EUCLIDEAN
    ) -> MatrixFreeIsometry:
        """Equations of a metric sampled at the nodes of a transform."""
        area = float(samples.areas.sum())
        unit = float(np.sqrt(area / (4.0 * np.pi)))
        angles = np.stack(angle_frame(samples.u), axis=1)
        frames = unit * np.einsum("nai,nbi->nab", samples.frames, angles)
        return cls(transform, unit, frames, np.sqrt(samples.areas / area), space.scaled(1.0 / unit))

    def solved(self, coefficients: Floats, stretch: Floats | float = 0.0, target: float = 0.0) -> Floats:
        """Coefficients (size, 3) of X near given ones, by least squares of the strains minus a stretch.

        Parameters
        ----------
        coefficients : ndarray, shape (size, 3)
        stretch : ndarray, shape (n, 3), or 0
            Prescribed strains, in the form of `isoembed.smooth.isometry.strains`.
        target : float
            Root mean square of the strains at which to stop, or the estimated contribution of the truncated
            degrees if that is larger.  With 0 the strains are minimized.

        Notes
        -----
        High degrees are damped in proportion to the strains: where K < 0 they contain nearly isometric
        deformations, excited by noise and truncation.  With too few harmonics the minimum may belong to
        another surface.
        """
        C = coefficients / self.unit
        tangents, residuals = self._strained(C, stretch)
        error = float(np.linalg.norm(residuals))
        check_start(error)
        enough, eased, slow = max(target, 1e-14), 1.0, 0  # 1e-14 is rounding
        for _ in range(40):
            if error <= enough or (target and error <= self._beyond(C)):
                break
            damping = eased * error / np.sqrt(4.0 * np.pi)
            step = self._least_squares(C, tangents, -residuals[..., None], damping)[..., 0]
            for length in SEARCH.parameters():
                trial = C + length * step
                tangents, residuals = self._strained(trial, stretch)
                attained = float(np.linalg.norm(residuals))
                if SEARCH.accepts(attained, error, length):
                    break
            else:
                break
            slow = slow + 1 if attained > 0.8 * error else 0
            C, error = trial, attained
            eased *= 0.2 if length == 1.0 else 1.0  # less damping after a full step
            if slow == 3:  # successive steps
                break
        C[0] = coefficients[0] / self.unit
        if not self.space.is_euclidean:
            C[0] -= np.sqrt(4.0 * np.pi) * (self.root**2 @ self.transform.values(C))
        return self.unit * C

    def deformations(self, coefficients: Floats, strains: Floats) -> Floats:
        """First-order changes (k, size, 3) of the coefficients of X for changes (k, n, 3) of the strains.

        They are free of translations and rotations.
        """
        C = coefficients / self.unit
        right = np.moveaxis(self.root[:, None] * strains, 0, 2)
        return self.unit * np.moveaxis(self._least_squares(C, self._tangents(C), right, 0.0), 2, 0)

    def _tangents(self, C: Floats) -> Tangents:
        vectors = np.asarray(self.frames @ self.transform.gradients(C))
        if self.space.is_euclidean:
            return flat_tangents(vectors)
        return tangents_in(self.space, self._centered(C), vectors)

    def _centered(self, C: Floats) -> Floats:
        """Values (n, c) of functions minus their means over the area."""
        values = self.transform.values(C)
        return values - self.root**2 @ values

    def _strained(self, C: Floats, stretch: Floats | float) -> tuple[Tangents, Floats]:
        tangents = self._tangents(C)
        return tangents, self.root[:, None] * (tangents.strains - stretch)

    def _beyond(self, C: Floats) -> float:
        """Root mean square of the strains in the truncated degrees, estimated from the last degrees."""
        degrees = self.transform.harmonics.labels[0]
        last = degrees > degrees.max() - 3  # degrees used for the estimate
        return 2.0 * float(np.linalg.norm(degrees[last, None] * C[last])) / np.sqrt(4.0 * np.pi)

    @cached_property
    def _scale(self) -> Floats:
        """Coefficients (size, 1) of unit strain: the inverse degree, and 0 for translations."""
        degrees = self.transform.harmonics.labels[0].astype(np.float64)[:, None]
        return np.divide(1.0, degrees, out=np.zeros_like(degrees), where=degrees > 0.0)

    def _least_squares(self, C: Floats, tangents: Tangents, right: Floats, damping: float) -> Floats:
        """Least-squares changes (size, 3, k) of the coefficients C for right-hand sides (n, 3, k) of strains.

        Conjugate gradients for least squares (CGLS) with all right-hand sides at once.  High degrees of the
        changed coefficients are damped.
        """
        X1, X2 = tangents.lowered[:, 0], tangents.lowered[:, 1]
        W = np.zeros((len(X1), 3, 2, 3))
        W[:, 0, 0], W[:, 2, 1] = 2.0 * X1, 2.0 * X2
        W[:, 1, 0], W[:, 1, 1] = np.sqrt(2.0) * X2, np.sqrt(2.0) * X1
        # The derivatives D_a of displacements are those of the harmonics plus the drift times their values.
        drifted = np.einsum("nsac,na->nsc", W, self.root[:, None] * tangents.drift)
        W = np.einsum("nsac,nab->nsbc", W, self.root[:, None, None] * self.frames).reshape(len(X1), 3, 6)
        curved = not self.space.is_euclidean
        count = right.shape[2]
        scale, size = self._scale[..., None], self.transform.harmonics.size
        degrees = self.transform.harmonics.labels[0][:, None, None]
        damp = damping * degrees * (degrees / degrees.max()) ** 2.0  # damping grows with the degree

        def strained(y: Floats) -> Floats:
            changes = (scale * y).reshape(size, 3 * count)
            slopes = self.transform.gradients(changes)
            strain = np.einsum("nsk,nkj->nsj", W, slopes.reshape(-1, 6, count))
            if curved:
                strain += np.einsum("nsc,ncj->nsj", drifted, self._centered(changes).reshape(-1, 3, count))
            return strain

        def adjoint(r: Floats) -> Floats:
            slopes = np.einsum("nsk,nsj->nkj", W, r).reshape(-1, 2, 3 * count)
            total = self.transform.adjoint_gradients(slopes)
            if curved:
                values = np.einsum("nsc,nsj->ncj", drifted, r).reshape(-1, 3 * count)
                values -= self.root[:, None] ** 2 * values.sum(axis=0)
                total += self.transform.adjoint_values(values)
            return scale * total.reshape(size, 3, count)

        def squares(a: Floats) -> Floats:
            return np.einsum("isj,isj->j", a, a)

        y = np.zeros((size, 3, count))
        rest, damped = right.copy(), np.broadcast_to(-damp * degrees * C[..., None], y.shape)
        gradient = adjoint(rest) + damp * damped
        along, square = gradient, squares(gradient)
        tight = 1e-3 if damping else EXACT
        small = tight**2 * square
        near = (0.05 if damping else EXACT) ** 2 * squares(right)
        for _ in range(2000):  # conjugate gradients
            moved, pulled = strained(along), damp * along
            length = square / np.maximum(squares(moved) + squares(pulled), np.finfo(np.float64).tiny)
            y = y + length * along
            rest, damped = rest - length * moved, damped - length * pulled
            gradient = adjoint(rest) + damp * damped
            before, square = square, squares(gradient)
            if np.all((square <= small) | (squares(rest) + squares(damped) <= near)):
                break
            along = (
                gradient + np.divide(square, before, out=np.zeros_like(square), where=before > 0.0) * along
            )
        return np.asarray(scale * y)
