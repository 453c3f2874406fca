"""Rigid motions: standard position of a smooth surface in space, independent of the initial mesh."""

from collections.abc import Callable

import numpy as np

from isoembed.arrays import Floats
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.isometry import around
from isoembed.smooth.sphere_transform import SphereTransform
from isoembed.smooth.two_metric import TwoMetric, area_density
from isoembed.space import EUCLIDEAN, Space
from isoembed.surface.alignment import best_rotation


def oriented(
    metric: TwoMetric,
    harmonics: Harmonics,
    coefficients: Floats,
    shape: Callable[[Floats], Floats] | None = None,
    space: Space = EUCLIDEAN,
) -> Floats:
    """Coefficients (size, 3) of a map X after the rotation that best aligns it with a shape.

    The rotation minimizes the mean squared distance over the area of the metric.  The centroid of X is moved
    to the origin, where it already is in curved space.

    Parameters
    ----------
    metric : TwoMetric
        Metric realized by X.
    harmonics : Harmonics
    coefficients : ndarray, shape (size, 3)
    shape : callable, optional
        Takes directions u (n, 3) and returns points (n, 3), in any unit; by default the directions.
    space : Space
        Ambient space of X.
    """
    n = int(np.ceil(2.0 * (harmonics.degree + 1)))
    transform = SphereTransform(harmonics, n, around(n, harmonics))
    u = transform.u
    areas = transform.weights * area_density(metric.tensor(u))
    areas /= areas.sum()
    points, onto = transform.values(coefficients), u if shape is None else shape(u)
    centroid = areas @ points
    found = coefficients.copy()
    if space.is_euclidean:
        # The constant harmonic is 1 / sqrt(4 pi).
        found[0] -= np.sqrt(4.0 * np.pi) * centroid
    return found @ best_rotation(points - centroid, onto - areas @ onto, areas)
