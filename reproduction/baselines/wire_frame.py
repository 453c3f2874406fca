"""The wire frame of Nollert and Herold (1996): vertices from edge lengths alone, by least squares.

Theirs: neighboring points of a coordinate grid get distances from the metric's components by a Taylor
expansion, and the positions minimize the squares of the differences between these distances and those in R^3.
Here the lengths are given, without the error of that expansion; the minimizer is Levenberg and Marquardt's,
and the start is a sphere.  As in theirs, nothing but the lengths tells one surface from another.

References
----------
H.-P. Nollert and H. Herold, Visualization in curved spacetimes II: Visualization of surfaces via embedding,
in Relativity and Scientific Computing, Springer 1996.
"""

import numpy as np
from numpy.typing import ArrayLike

from isoembed import Embedding, InvalidParameter, PolyhedralMetric
from isoembed.metric.conformal_sphere import conformal_sphere
from isoembed.metric.curvature import area
from isoembed.metric.delaunay import delaunay
from isoembed.progress.stages import Log
from reproduction.arrays import Floats
from reproduction.levenberg_marquardt import least_squares

TOLERANCE = 1e-10  # mean edge lengths, the default of `isoembed.embed`
STEPS = 200  # of the Levenberg-Marquardt method, at most


def sphere_layout(metric: PolyhedralMetric, noise: float = 0.0) -> Floats:
    """A start: vertices (V, 3) on the sphere of the same area, from the lengths alone.

    Parameters
    ----------
    metric : PolyhedralMetric
    noise : float
        Standard deviation of random displacements of every coordinate, in mean edge lengths.
    """
    given = metric.normalized
    with Log().stage("layout") as recorder:
        points = conformal_sphere(delaunay(given), recorder).points
    radius = np.sqrt(area(given) / (4.0 * np.pi))
    shifts = given.mean_length * noise * np.random.default_rng(0).standard_normal(points.shape)
    return np.asarray(metric.unit * (radius * points + shifts))


def wire_frame(metric: PolyhedralMetric, start: ArrayLike) -> Embedding:
    """Minimize the sum of ``(|x_a - x_b|^2 - l_ab^2)^2 / (2 l_ab)^2`` from a start.

    Parameters
    ----------
    metric : PolyhedralMetric
    start : array_like, shape (V, 3)

    Returns
    -------
    Embedding
        Where the search has ended, whatever that is.

    Raises
    ------
    InvalidParameter
        The start has another shape.
    """
    x = np.asarray(start, dtype=np.float64)
    if x.shape != (metric.triangulation.n_vertices, 3):
        raise InvalidParameter(
            f"the start has the shape {x.shape}, not ({metric.triangulation.n_vertices}, 3)"
        )
    return least_squares(
        metric, x / metric.unit, method="wire frame", tolerance=TOLERANCE, max_iterations=STEPS
    )
