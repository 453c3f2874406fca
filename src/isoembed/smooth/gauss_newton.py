"""Gauss-Newton method for the isometry equations."""

import numpy as np

from isoembed.arrays import Floats
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.isometry import OVERSAMPLING, IsometrySystem, MetricSamples, around
from isoembed.smooth.matrix_free import ITERATIVE_OVERSAMPLING, MatrixFreeIsometry
from isoembed.smooth.sphere_transform import SphereTransform
from isoembed.smooth.two_metric import TwoMetric
from isoembed.space import EUCLIDEAN, Space


def is_direct(harmonics: Harmonics) -> bool:
    """Whether the coefficients are few enough for dense matrices."""
    return 3 * harmonics.size <= 1800  # otherwise the matrix-free method is used


def gauss_newton(
    metric: TwoMetric,
    harmonics: Harmonics,
    coefficients: Floats,
    target: float = 0.0,
    space: Space = EUCLIDEAN,
) -> Floats:
    """Coefficients (size, 3) of the map that minimizes the integral of the squared strains over the area.

    The iteration starts from the coefficients of an approximate map.  The constant harmonic is kept in
    Euclidean space, and makes the mean over the area zero in curved space.  The iteration may stop if the
    root mean square of the strains is at most the target.

    Raises
    ------
    InvalidParameter
        The initial map leaves the hemisphere of spherical space about the origin.
    """
    if is_direct(harmonics):
        n = int(np.ceil(OVERSAMPLING * (harmonics.degree + 1)))
        samples = MetricSamples.of(metric, n, around(n, harmonics))
        return IsometrySystem.of(harmonics, samples, space).solved(coefficients)
    n = int(np.ceil(ITERATIVE_OVERSAMPLING * (harmonics.degree + 1)))
    transform = SphereTransform(harmonics, n, around(n, harmonics))
    samples = MetricSamples.of(metric, n, transform.around)
    return MatrixFreeIsometry.of(transform, samples, space).solved(coefficients, target=target)
