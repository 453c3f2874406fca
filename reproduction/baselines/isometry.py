"""The isometry equations of a map from the sphere into R^3, in spherical harmonics at the nodes of a rule.

The rule is Gauss's.  The derivatives X_1, X_2 of the map are taken along a frame that is orthonormal in the
given metric, so that the equations are X_a . X_b = delta_ab; the nodes are weighted by their areas.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from isoembed.smooth import Harmonics, TwoMetric
from reproduction.arrays import Floats

OVERSAMPLING = 1.25  # nodes over coefficients, each way
AROUND = 8  # nodes about an axis of symmetry
STEPS = 30  # of the Gauss-Newton method, at most
EXACT = 1e-13  # relative size of its last step
SHORTEST = 1e-3  # part of a step that is tried, at least
LEVEL = 1.0 + 1e-6  # strain over the one before that is accepted: at the minimum it does not fall
SLOW = 0.9  # strain over the one before that is slow progress, and ends the iteration ...
SMALL = 1e-3  # ... unless the strain is below this


@dataclass(frozen=True)
class IsometrySystem:
    """The equations at the nodes.

    Attributes
    ----------
    u : ndarray, shape (n, 3)
        The nodes, unit vectors.
    unit : float
        Radius of the sphere with the metric's area: the unit of everything here.
    Y : ndarray, shape (n, m)
        The harmonics without the constant one, which only translates.
    B : ndarray, shape (n, 2, m)
        Their derivatives along the frames.
    root : ndarray, shape (n,)
        The square roots of the nodes' shares in the area.
    """

    u: Floats
    unit: float
    Y: Floats
    B: Floats
    root: Floats

    @classmethod
    def of(cls, metric: TwoMetric, harmonics: Harmonics, n: int | None = None) -> "IsometrySystem":
        """The equations at n heights, by default as many as resolve the harmonics."""
        n = n or int(np.ceil(OVERSAMPLING * (harmonics.degree + 1)))
        around = AROUND if harmonics.order < harmonics.degree else 2 * n
        u, weights = gauss_rule(n, around)
        q = metric.tensor(u)
        areas = weights * area_density(q)
        unit = float(np.sqrt(areas.sum() / (4.0 * np.pi)))
        Y, B = harmonics.along(u, orthonormal_frame(u, q))
        return cls(u, unit, Y[:, 1:], unit * B[:, :, 1:], np.sqrt(areas / areas.sum()))

    def deformation(self, coefficients: Floats, strains: Floats) -> Floats:
        """The change (size, 3) of the coefficients that changes the strains by (n, 3), to first order.

        It has no translation and no rotation.
        """
        C = coefficients[1:] / self.unit
        tangents = self.B @ C
        step = self._normal_equations(C, tangents)(self._gradient(tangents, strains))
        return np.concatenate([np.zeros((1, 3)), self.unit * step])

    def fitted(self, coefficients: Floats) -> Floats:
        """The coefficients (size, 3) of least strain near given ones, by the Gauss-Newton method.

        It ends where progress is slow, because the degree allows no surface with small strains.
        """
        C = coefficients[1:] / self.unit
        tangents = self.B @ C
        error = self._rms(tangents)
        for _ in range(STEPS):
            step = self._normal_equations(C, tangents)(-self._gradient(tangents, strains(tangents)))
            length = 1.0
            while (left := self._rms(self.B @ (C + length * step))) > LEVEL * error and length >= SHORTEST:
                length *= 0.5
            if left > LEVEL * error:
                break
            C = C + length * step
            tangents = self.B @ C
            if np.linalg.norm(step) < EXACT * np.linalg.norm(C) or left > max(SLOW * error, SMALL):
                break
            error = left
        return np.concatenate([coefficients[:1], self.unit * C])

    def _rms(self, tangents: Floats) -> float:
        """Root mean square of the strains over the area."""
        return float(np.linalg.norm(self.root[:, None] * strains(tangents)))

    def _gradient(self, tangents: Floats, strain: Floats) -> Floats:
        """Half the derivatives (m, 3) of the weighted sum of squares of strains by the coefficients."""
        r = self.root[:, None] * (self.root[:, None] * strain)
        X1, X2 = tangents[:, 0], tangents[:, 1]
        across = np.sqrt(2.0) * r[:, 1, None]
        first, second = 2.0 * r[:, 0, None] * X1 + across * X2, 2.0 * r[:, 2, None] * X2 + across * X1
        return np.asarray(self.B[:, 0].T @ first + self.B[:, 1].T @ second)

    def _normal_equations(self, C: Floats, tangents: Floats) -> Callable[[Floats], Floats]:
        """A solver of the normal equations, for right sides and solutions (m, 3)."""
        J, turns = self._jacobian(tangents), self._turns(C)
        normal = J.T @ J + turns.T @ turns
        scale = 1.0 / np.sqrt(np.diag(normal))
        normal *= scale[:, None] * scale
        normal[np.diag_indices_from(normal)] += len(normal) * np.finfo(np.float64).eps
        factor = cho_factor(normal, overwrite_a=True)

        def solve(right: Floats) -> Floats:
            return np.asarray(scale * cho_solve(factor, scale * right.T.ravel())).reshape(3, -1).T

        return solve

    def _jacobian(self, tangents: Floats) -> Floats:
        """Derivatives (3 n, 3 m) of the weighted strains by the coefficients of x, y and z."""
        n, _, m = self.B.shape
        J = np.empty((3, n, 3, m))
        first, second = self.B[:, 0] * self.root[:, None], self.B[:, 1] * self.root[:, None]
        for i in range(3):
            X1, X2 = tangents[:, 0, i, None], tangents[:, 1, i, None]
            J[0, :, i] = 2.0 * X1 * first
            J[1, :, i] = np.sqrt(2.0) * (X1 * second + X2 * first)
            J[2, :, i] = 2.0 * X2 * second
        return J.reshape(3 * n, 3 * m)

    def _turns(self, C: Floats) -> Floats:
        """Rows (3, 3 m) that vanish on steps without a rotation."""
        X = self.Y @ C
        X = X / np.sqrt(np.einsum("ni,ni,n->", X, X, self.root**2))
        moments = (self.root[:, None] ** 2 * X).T @ self.Y
        rows = np.zeros((3, 3, self.Y.shape[1]))
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            rows[k, j], rows[k, i] = moments[i], -moments[j]
        return rows.reshape(3, -1)


def strains(tangents: Floats) -> Floats:
    """``X_a . X_b - delta_ab`` (n, 3) of derivatives (n, 2, 3), as 11, sqrt(2) 12, 22."""
    first, second = tangents[:, 0], tangents[:, 1]
    return np.stack(
        [
            np.einsum("ni,ni->n", first, first) - 1.0,
            np.sqrt(2.0) * np.einsum("ni,ni->n", first, second),
            np.einsum("ni,ni->n", second, second) - 1.0,
        ],
        axis=1,
    )


def gauss_rule(n: int, around: int) -> tuple[Floats, Floats]:
    """Nodes (n * around, 3) and weights on the unit sphere: Gauss-Legendre in z times even angles."""
    z, weight = np.polynomial.legendre.leggauss(n)
    phi = 2.0 * np.pi / around * np.arange(around)
    sin = np.sqrt((1.0 - z) * (1.0 + z))[:, None]
    nodes = np.stack(np.broadcast_arrays(sin * np.cos(phi), sin * np.sin(phi), z[:, None]), axis=-1)
    return nodes.reshape(-1, 3), np.repeat(2.0 * np.pi / around * weight, around)


def area_density(q: Floats) -> Floats:
    """The area (n,) of metrics q (n, 3, 3) over that of the unit sphere."""
    trace = np.trace(q, axis1=1, axis2=2)
    shape = q / trace[:, None, None]
    return np.asarray(trace * np.sqrt(np.maximum(0.5 * (1.0 - np.einsum("nij,nij->n", shape, shape)), 0.0)))


def orthonormal_frame(u: Floats, q: Floats) -> Floats:
    """Tangent vectors (n, 2, 3) at u, orthonormal in q, the first along the meridian; u is no pole."""
    sin = np.hypot(u[:, 0], u[:, 1])
    cos_phi, sin_phi = u[:, 0] / sin, u[:, 1] / sin
    e_theta = np.stack([u[:, 2] * cos_phi, u[:, 2] * sin_phi, -sin], axis=1)
    e_phi = np.stack([-sin_phi, cos_phi, np.zeros(len(u))], axis=1)
    first = np.einsum("ni,nij->nj", e_theta, q)
    length = np.sqrt(np.einsum("ni,ni->n", first, e_theta))[:, None]
    e_1 = e_theta / length
    e_2 = e_phi - np.einsum("ni,ni->n", first, e_phi)[:, None] / length * e_1
    e_2 /= np.sqrt(np.einsum("ni,nij,nj->n", e_2, q, e_2))[:, None]
    return np.stack([e_1, e_2], axis=1)
