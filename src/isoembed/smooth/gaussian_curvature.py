"""Gaussian curvature of a smooth metric by finite differences."""

import numpy as np
from numpy.typing import ArrayLike

from isoembed.arrays import Floats, chunks
from isoembed.smooth.geodesics import definite_tensor, in_own_unit
from isoembed.smooth.two_metric import TwoMetric, angle_frame

STEP = 2e-3  # in radians; balances truncation and rounding errors of the differences
AXIS = [(k, 0) for k in (-2, -1, 1, 2)] + [(0, k) for k in (-2, -1, 1, 2)]
DIAGONAL = [(k, sign * k) for sign in (1, -1) for k in (-2, -1, 1, 2)]
STENCIL = np.array([(0, 0), *AXIS, *DIAGONAL], dtype=np.float64)

FIRST = np.array([1.0, -8.0, 8.0, -1.0]) / (12.0 * STEP)
SECOND = np.array([-1.0, 16.0, 16.0, -1.0]) / (12.0 * STEP**2)
SECOND_CENTER = -30.0 / (12.0 * STEP**2)


def gaussian_curvature(metric: TwoMetric, u: ArrayLike) -> Floats:
    """Gaussian curvature at given directions.

    Parameters
    ----------
    metric : TwoMetric
    u : array_like, shape (n, 3)
        Unit vectors.

    Returns
    -------
    ndarray, shape (n,)
        Gaussian curvature in 1/length^2, in the unit of the metric, to about eight digits.  The error is of
        fourth order in a step of 0.002 radians, hence larger if the metric varies within 0.01 radians.

    Raises
    ------
    InvalidMetric
        The metric is not positive definite at or near one of the directions.

    Notes
    -----
    Brioschi's formula in coordinates of the tangent plane of the sphere at u, with derivatives from 17
    samples of the metric.
    """
    directions = np.asarray(u, dtype=np.float64)
    K = np.empty(len(directions))
    if len(directions) == 0:
        return K
    unit, own = in_own_unit(metric, directions[:1])
    for part in chunks(len(directions), 4096):  # bounds the memory
        K[part] = _brioschi(_sampled(own, directions[part]))
    return K / unit / unit


def _sampled(metric: TwoMetric, u: Floats) -> Floats:
    """Components E, F, G (3, 17, n) of the metric around each direction, in its tangent plane."""
    frame = np.stack(angle_frame(u))  # (2, n, 3)
    x = u + np.einsum("ka,ani->kni", STEP * STENCIL, frame)
    square = np.einsum("kni,kni->kn", x, x)
    q = definite_tensor(metric, (x / np.sqrt(square)[..., None]).reshape(-1, 3)).reshape(*x.shape, 3)
    E, F, G = (np.einsum("ni,knij,nj->kn", frame[a], q, frame[b]) for a, b in ((0, 0), (0, 1), (1, 1)))
    return np.stack([E, F, G]) / square


def _brioschi(samples: Floats) -> Floats:
    center, x, y = samples[:, 0], samples[:, 1:5], samples[:, 5:9]
    E, _, G = center
    yy = SECOND @ y[0] + SECOND_CENTER * E
    xx = SECOND @ x[2] + SECOND_CENTER * G
    # Second differences along the diagonals are f_xx + f_yy +- 2 f_xy; the center cancels in f_xy.
    xy = (SECOND @ samples[1, 9:13] - SECOND @ samples[1, 13:17]) / 4.0
    first_x, first_y = (np.einsum("k,ckn->cn", FIRST, along) for along in (x, y))
    return brioschi(center, first_x, first_y, xy - 0.5 * (yy + xx))


def brioschi(metric: Floats, x: Floats, y: Floats, second: Floats) -> Floats:
    """Gaussian curvature by Brioschi's formula.

    Parameters
    ----------
    metric, x, y : ndarray, shape (3, n)
        Components E, F and G in coordinates x and y, and their derivatives.
    second : ndarray, shape (n,)
        ``F_xy - (E_yy + G_xx) / 2``.
    """
    E, F, G = metric
    e_x, f_x, g_x = x
    e_y, f_y, g_y = y
    zero = np.zeros_like(E)
    bent = _determinant(second, 0.5 * e_x, f_x - 0.5 * e_y, f_y - 0.5 * g_x, E, F, 0.5 * g_y, F, G)
    turned = _determinant(zero, 0.5 * e_y, 0.5 * g_x, 0.5 * e_y, E, F, 0.5 * g_x, F, G)
    return np.asarray((bent - turned) / (E * G - F**2) ** 2)


def _determinant(*entries: Floats) -> Floats:
    """Determinants (n,) of 3x3 matrices with entries in row-major order, each (n,)."""
    a, b, c, d, e, f, g, h, i = entries
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
