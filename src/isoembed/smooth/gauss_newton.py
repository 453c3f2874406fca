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
    """Whether the coefficients are few enough for matrices."""
    return 3 * harmonics.size <= 1800  # more coefficients are solved for without matrices


def gauss_newton(
    metric: TwoMetric,
    harmonics: Harmonics,
    coefficients: Floats,
    target: float = 0.0,
    space: Space = EUCLIDEAN,
) -> Floats:
    """Coefficients (size, 3) of the map whose squared strains, integrated over the area, are least.

    The search begins at coefficients of a map that is roughly right; that of the constant harmonic is kept
    in Euclidean space, and makes the mean over the area zero in others.  The search may end where the root
    mean square of the strains is at most the target.

    Raises
    ------
    InvalidParameter
        The map that it begins at leaves the half of spherical space about the origin.
    """
    if is_direct(harmonics):
        n = int(np.ceil(OVERSAMPLING * (harmonics.degree + 1)))
        samples = MetricSamples.of(metric, n, around(n, harmonics))
        return IsometrySystem.of(harmonics, samples, space).solved(coefficients)
    n = int(np.ceil(ITERATIVE_OVERSAMPLING * (harmonics.degree + 1)))
    transform = SphereTransform(harmonics, n, around(n, harmonics))
    samples = MetricSamples.of(metric, n, transform.around)
    return MatrixFreeIsometry.of(transform, samples, space).solved(coefficients, target=target)
