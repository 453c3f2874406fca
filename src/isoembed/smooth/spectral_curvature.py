"""Gaussian curvature of a smooth metric by spectral differentiation.

The Cartesian components of the tensor are smooth functions on the sphere, including the poles.  Their
series in scalar harmonics are differentiated exactly, and converge exponentially if the metric is analytic.
"""

import numpy as np

from isoembed.arrays import Floats
from isoembed.meshing.sphere import directions_at, fibonacci_directions
from isoembed.smooth.gaussian_curvature import brioschi
from isoembed.smooth.geodesics import in_own_unit
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.sphere_transform import SphereTransform
from isoembed.smooth.transforms import NEGLIGIBLE, ROUNDING, resized, trimmed
from isoembed.smooth.two_metric import TwoMetric, angle_frame, is_axisymmetric
from isoembed.smooth.uncertain import UncertainFunction, Uncertainty

PAIRS = np.triu_indices(3)


def spectral_curvature(metric: TwoMetric, relative_error: float = 0.0) -> UncertainFunction:
    """Gaussian curvature of a metric as a function of the direction.

    Parameters
    ----------
    metric : TwoMetric
    relative_error : float
        Relative error of lengths; much smaller harmonics are not computed.

    Returns
    -------
    UncertainFunction
        Function of unit vectors u (n, 3), in 1/length^2.  The error is that of rounding or of the lengths,
        amplified by l^2 by second derivatives of harmonics of degree l, plus the change from three quarters
        of the degree if the series is not resolved.  Errors of smooth averages of K are not amplified, by
        integration by parts.

    Raises
    ------
    InvalidMetric
        Raised by the metric.

    Notes
    -----
    Brioschi's formula in the central projection onto the tangent plane of the sphere at u, where first and
    second derivatives equal the covariant ones of the sphere.
    """
    unit, own = in_own_unit(metric)
    harmonics, coefficients, settled = metric_series(own, relative_error)
    degree, u = harmonics.degree, _everywhere(harmonics)
    K = _curvature(u, harmonics, coefficients)
    noise = (2e-15 + relative_error) * float(np.abs(K).max())  # 2e-15 is rounding
    pointwise, mean = degree**2 * noise, noise
    if not settled:
        low = (3 * degree) // 4
        lower = Harmonics(low, min(low, harmonics.order))
        change = np.abs(K - _curvature(u, lower, resized(coefficients, harmonics, lower)))
        pointwise, mean = pointwise + float(change.max()), mean + float(change.mean())
    error = Uncertainty(pointwise / unit / unit, mean / unit / unit)
    return UncertainFunction(lambda u: _curvature(u, harmonics, coefficients) / unit / unit, error)


def metric_series(metric: TwoMetric, relative_error: float) -> tuple[Harmonics, Floats, bool]:
    """Components xx, xy, xz, yy, yz, zz (size, 6) in harmonics, and whether these resolve the metric."""
    symmetric = is_axisymmetric(metric)
    degree, max_degree = 16, 512 if symmetric else 64  # initial degree, which is doubled
    while True:
        # Cartesian components of a tensor symmetric about the z-axis have orders of at most 2.
        harmonics = Harmonics(degree, 2 if symmetric else degree)
        # 32 angles average out rounding.
        transform = SphereTransform(harmonics, degree + 1, max(2 * harmonics.order + 2, 32))
        coefficients = transform.analysis(metric.tensor(transform.u)[:, PAIRS[0], PAIRS[1]])
        sizes = np.abs(coefficients).max(axis=1)
        size, high = sizes.max(), harmonics.labels[0] > 3 * degree // 4
        if sizes[high].max() <= max(ROUNDING, relative_error) * size:
            needed = sizes > max(NEGLIGIBLE, 0.1 * relative_error) * size
            coefficients[sizes <= NEGLIGIBLE * size] = 0.0  # rounding, amplified by second derivatives
            coefficients, harmonics = trimmed(coefficients, harmonics, needed)
            return harmonics, coefficients, True
        if 2 * degree > max_degree:
            return harmonics, coefficients, False
        degree *= 2


def _everywhere(harmonics: Harmonics) -> Floats:
    """Directions from pole to pole, dense enough for all harmonics."""
    if harmonics.order == harmonics.degree:
        return fibonacci_directions(harmonics.size)
    theta = np.linspace(0.0, np.pi, 4 * harmonics.degree)
    return directions_at(np.cos(theta), 0.0)


def _curvature(u: Floats, harmonics: Harmonics, coefficients: Floats) -> Floats:
    u = np.asarray(u, dtype=np.float64)
    values, gradients, hessians = harmonics.derivatives(u, coefficients)
    e, f = angle_frame(u)
    first = np.stack([np.einsum("nck,nk->nc", gradients, a) for a in (e, f)], axis=1)
    of_e, of_f = ((a[:, None, None] @ hessians)[:, :, 0] for a in (e, f))
    second = np.stack([(h @ a[:, :, None])[..., 0] for h, a in ((of_e, e), (of_e, f), (of_f, f))], axis=1)
    return curvature_of_derivatives(u, values, first, second)


def curvature_of_derivatives(u: Floats, values: Floats, first: Floats, second: Floats) -> Floats:
    """Gaussian curvature from the Cartesian components of a metric and their derivatives.

    Parameters
    ----------
    u : ndarray, shape (n, 3)
    values : ndarray, shape (n, 6)
        Components xx, xy, xz, yy, yz and zz.
    first : ndarray, shape (n, 2, 6)
        Derivatives along the unit vectors e_theta and e_phi.
    second : ndarray, shape (n, 3, 6)
        Covariant second derivatives on the unit sphere: theta theta, theta phi, phi phi.
    """
    e, f = angle_frame(u)
    # Products of two vectors with a symmetric tensor as sums over its six components.
    double = np.where(PAIRS[0] == PAIRS[1], 0.5, 1.0)
    ee, ef, ff = (
        double * (a[:, PAIRS[0]] * b[:, PAIRS[1]] + a[:, PAIRS[1]] * b[:, PAIRS[0]])
        for a, b in ((e, e), (e, f), (f, f))
    )

    def along(weights: Floats, components: Floats) -> Floats:
        return np.asarray(np.einsum("nc,nc->n", weights, components))

    metric = np.stack([along(pair, values) for pair in (ee, ef, ff)])
    x, y = (np.stack([along(pair, first[:, k]) for pair in (ee, ef, ff)]) for k in (0, 1))
    xy, yy, xx = along(ef, second[:, 1]), along(ee, second[:, 2]), along(ff, second[:, 0])
    # The projection contracts lengths by 1 + x^2 + y^2, which contributes to second derivatives of E and G.
    mixed = xy - 0.5 * (yy - 2.0 * metric[0] + xx - 2.0 * metric[2])
    return brioschi(metric, x, y, mixed)
