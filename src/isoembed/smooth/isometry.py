"""The isometry equations in spherical harmonics, X_a . X_b = delta_ab, by the Gauss-Newton method.

The derivatives X_a are taken along a frame that is orthonormal in the given metric, and the equations are
weighted by its area, so that neither scale nor coordinates count.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from isoembed.smooth.harmonics import Harmonics, gauss_rule
from isoembed.smooth.two_metric import TwoMetric, area_density, orthonormal_frame

Floats = NDArray[np.float64]

OVERSAMPLED = 1.25  # nodes over coefficients, each way, so that there are three equations to an unknown
FEWEST_AROUND = 8  # nodes about the axis
SHORTEST = 1e-3  # of a Newton step that does not help
SETTLED = 0.9  # of the error before: a step that gains less was the last one
MOST_STEPS = 30


@dataclass(frozen=True)
class MetricSamples:
    """A metric at the nodes of a Gauss rule.

    Attributes
    ----------
    u : ndarray, shape (n, 3)
    areas : ndarray, shape (n,)
        Of the nodes: they sum to the area of the surface.
    frames : ndarray, shape (n, 2, 3)
        Tangent vectors that are orthonormal in the metric; their cross product looks outward.
    """

    u: Floats
    areas: Floats
    frames: Floats

    @classmethod
    def of(cls, metric: TwoMetric, n: int, around: int) -> MetricSamples:
        """Sample at `n` heights and `around` angles about the axis."""
        u, weights = gauss_rule(n, around)
        q = metric.tensor(u)
        return cls(u, weights * area_density(q), orthonormal_frame(u, q))

    @classmethod
    def enough_for(cls, metric: TwoMetric, harmonics: Harmonics, oversampled: float) -> MetricSamples:
        """Sample so densely that harmonics and their products are told apart."""
        n = int(np.ceil(oversampled * (harmonics.degree + 1)))
        around = int(np.ceil(2.0 * oversampled * (harmonics.order + 1)))
        return cls.of(metric, n, max(FEWEST_AROUND, around))


def strains(tangents: Floats) -> Floats:
    """``X_a . X_b - delta_ab`` (n, 3), as 11, sqrt(2) 12, 22, of derivatives (n, 2, 3) along frames."""
    first, second = tangents[:, 0], tangents[:, 1]
    return np.stack(
        [
            np.einsum("ni,ni->n", first, first) - 1.0,
            np.sqrt(2.0) * np.einsum("ni,ni->n", first, second),
            np.einsum("ni,ni->n", second, second) - 1.0,
        ],
        axis=1,
    )


def gauss_newton(metric: TwoMetric, harmonics: Harmonics, coefficients: Floats) -> Floats:
    """Improve a map X until the squares of its strains, integrated over the area, are least.

    Parameters
    ----------
    metric : TwoMetric
    harmonics : Harmonics
    coefficients : ndarray, shape (size, 3)
        Of a map that is roughly right.

    Returns
    -------
    ndarray, shape (size, 3)
        The coefficients of the best map; that of the constant harmonic is as given.
    """
    samples = MetricSamples.enough_for(metric, harmonics, OVERSAMPLED)
    Y, B = harmonics.along(samples.u, samples.frames)
    root = np.sqrt(samples.areas / samples.areas.sum())
    # Translations are left alone: the constant harmonic is the first one and is no unknown.
    moving = slice(1, None)
    Y, B = Y[:, moving], np.ascontiguousarray(B[:, :, moving])
    C = coefficients.copy()
    error, tangents, residuals = _strained(B, C[moving], root)
    for _ in range(MOST_STEPS):
        J = _jacobian(B, tangents, root)
        turns = _turns(Y, C[moving], root)
        step = _least_squares(J, -residuals.T.ravel(), turns).reshape(3, -1).T
        length = 1.0
        while True:
            trial = C[moving] + length * step
            attained, tangents, residuals = _strained(B, trial, root)
            if attained < error or length < SHORTEST:
                break
            length *= 0.5
        if not attained < error:
            break
        C = np.concatenate([C[:1], trial])
        settled, error = attained > SETTLED * error, attained
        if settled:
            break
    return C


def _strained(B: Floats, C: Floats, root: Floats) -> tuple[float, Floats, Floats]:
    tangents = B @ C
    residuals = root[:, None] * strains(tangents)
    return float(np.linalg.norm(residuals)), tangents, residuals


def _jacobian(B: Floats, tangents: Floats, root: Floats) -> Floats:
    """Derivatives (3 n, 3 m) of the weighted strains by the coefficients of x, y and z."""
    n, _, m = B.shape
    J = np.empty((3, n, 3, m))
    first, second = B[:, 0] * root[:, None], B[:, 1] * root[:, None]
    for i in range(3):
        X1, X2 = tangents[:, 0, i, None], tangents[:, 1, i, None]
        J[0, :, i] = 2.0 * X1 * first
        J[1, :, i] = np.sqrt(2.0) * (X1 * second + X2 * first)
        J[2, :, i] = 2.0 * X2 * second
    return J.reshape(3 * n, 3 * m)


def _turns(Y: Floats, C: Floats, root: Floats) -> Floats:
    """Rows (3, 3 m) that are zero for steps without rotation."""
    X = Y @ C
    X = X / np.sqrt(np.einsum("ni,ni,n->", X, X, root**2))
    moments = (root[:, None] ** 2 * X).T @ Y  # (3, m)
    rows = np.zeros((3, 3, Y.shape[1]))
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        rows[k, j], rows[k, i] = moments[i], -moments[j]
    return rows.reshape(3, -1)


def _least_squares(J: Floats, right: Floats, turns: Floats) -> Floats:
    """The step by the normal equations: Newton's method makes up for the digits that they lose."""
    normal = J.T @ J + turns.T @ turns
    scale = 1.0 / np.sqrt(np.diag(normal))
    normal *= scale[:, None] * scale
    normal[np.diag_indices_from(normal)] += len(normal) * np.finfo(np.float64).eps
    return scale * cho_solve(cho_factor(normal, overwrite_a=True), scale * (right @ J))
