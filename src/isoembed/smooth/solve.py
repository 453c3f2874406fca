"""From a smooth metric to its smooth embedding: a mesh finds the branch, spherical harmonics the digits."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from isoembed.errors import InvalidMetric, InvalidParameter, NotEmbedded
from isoembed.smooth.embedding import ROUNDING, SmoothEmbedding
from isoembed.smooth.grid_metric import GridMetric
from isoembed.smooth.harmonics import Harmonics, gauss_rule
from isoembed.smooth.hindrance import by_curvature, no_revolution
from isoembed.smooth.isometry import gauss_newton
from isoembed.smooth.triangulation import triangulate
from isoembed.smooth.two_metric import TwoMetric, angle_frame
from isoembed.verb import embed

Floats = NDArray[np.float64]

DEGREES = (8, 12, 16, 24, 32, 48, 64, 96, 128, 192)
UNKNOWNS = 3300  # more take minutes: degree 32 of all orders, degree 192 about an axis of symmetry
SYMMETRIC = 1e-12  # of the metric: less variation about the axis is none
MESHED, SYMMETRICALLY_MESHED = (96, 192), (768, 1)  # nodes in theta and phi, for meshes
FALLING = 0.6  # of the residual before: less of a decrease is none
ROUGH = 1e-2  # of an edge of the mesh: enough to be on a branch
HINDERED = 32  # degree of the best fit to what has no embedding
GRADED = 0.1  # vertices that follow the curvature, against one that follows the area


def embed_smooth(
    metric: TwoMetric,
    *,
    start: SmoothEmbedding | None = None,
    vertices: int = 1000,
    tolerance: float = 1e-4,
    accuracy: float = 1e-12,
    best_fit: bool = False,
) -> SmoothEmbedding:
    """Find the smooth surface in R^3 that realizes a smooth metric on the sphere.

    A triangulation of the metric is embedded (`isoembed.embed`), its vertices are fitted in spherical
    harmonics, and Gauss-Newton steps on the isometry equations with more and more harmonics make it exact,
    until int H dA has settled or the harmonics number a thousand.  Metrics that are symmetric
    about the z-axis need few harmonics of high degree and are cheap.

    Parameters
    ----------
    metric : TwoMetric
    start : SmoothEmbedding, optional
        Of a metric nearby, in the same directions: the mesh is left out.
    vertices : int
        Of the mesh.
    tolerance : float
        Largest relative error of a length that counts as an embedding.  The error of int H dA is about its
        square.
    accuracy : float
        Of int H dA, relative to it: where two degrees agree so well, no higher one is tried.
    best_fit : bool
        Return the surface that comes nearest to the metric, in the mean square of its strains, even if it
        misses the tolerance.

    Returns
    -------
    SmoothEmbedding

    Raises
    ------
    InvalidMetric
        The metric is not positive definite somewhere.
    NotEmbedded
        The tolerance was missed, or the metric is symmetric about the z-axis and is not that of a surface of
        revolution.  The message says what is in the way, if it can be seen, or whether more harmonics would
        help; the exception holds the best attempt.

    Notes
    -----
    For K > 0 the surface exists and is unique (Nirenberg 1953, Pogorelov 1952).  With K < 0 somewhere it is
    the branch that the mesh is on.
    """
    for name, value in (("tolerance", tolerance), ("accuracy", accuracy)):
        if not 0 < value < np.inf:
            raise InvalidParameter(f"the {name} is {value!r}, not a positive finite number")
    symmetric = not varies(metric)
    ladder = [h for h in (Harmonics(L, 1 if symmetric else L) for L in DEGREES) if 3 * h.size <= UNKNOWNS]
    hindrance = no_revolution(metric) if symmetric else ""
    if hindrance:
        ladder = [h for h in ladder if h.degree <= HINDERED]
    if start is None:
        first = 0
        guess = _branch(drawn(metric), ladder[0], vertices)
    else:
        first = max(0, sum(h.degree < start.harmonics.degree for h in ladder) - 1)
        guess = recast(start.coefficients, start.harmonics, ladder[first])
    residuals: list[float] = []
    for best in _ladder(metric, ladder[first:], guess, tolerance, hindrance):
        residuals.append(best.residual)
        settled = best.unsettled <= accuracy * abs(best.integrated_mean_curvature)
        if best.converged and (settled or best.residual <= ROUNDING):
            break
    if best.converged or best_fit:
        return best
    raise NotEmbedded(_diagnosis(best, residuals), best)


def recast(coefficients: Floats, old: Harmonics, new: Harmonics) -> Floats:
    """The coefficients (size, c) of functions in other harmonics: cut off or filled up with zeros."""
    place = {label: i for i, label in enumerate(zip(*new.labels, strict=True))}
    result = np.zeros((new.size, coefficients.shape[1]))
    for i, label in enumerate(zip(*old.labels, strict=True)):
        if label in place:
            result[place[label]] = coefficients[i]
    return result


def _ladder(
    metric: TwoMetric, ladder: list[Harmonics], guess: Floats, tolerance: float, hindrance: str
) -> Iterator[SmoothEmbedding]:
    """The best embeddings of growing degree."""
    last, harmonics, C = np.inf, ladder[0], guess
    for following in ladder:
        C, harmonics = recast(C, harmonics, following), following
        C = gauss_newton(metric, harmonics, C)
        surface = SmoothEmbedding(metric, harmonics, C, tolerance, last, hindrance)
        last = surface.integrated_mean_curvature
        yield surface


def _branch(metric: TwoMetric, harmonics: Harmonics, vertices: int) -> Floats:
    """Coefficients (size, 3) fitted to the embedded vertices of a triangulation."""
    mesh = triangulate(metric, vertices, grading=GRADED)
    try:
        embedding = embed(mesh.metric, tolerance=ROUGH)
    except NotEmbedded as error:
        embedding = error.embedding  # the isometry equations decide
    C = np.asarray(np.linalg.lstsq(harmonics.values(mesh.directions), embedding.vertices, rcond=None)[0])
    C[0] = 0.0  # the mean of X over the directions: no equation tells it
    return C


def varies(metric: TwoMetric) -> bool:
    """Whether the metric is not symmetric about the z-axis."""
    n, around = 24, 48
    u, _ = gauss_rule(n, around)
    q = metric.tensor(u)
    e = np.stack(angle_frame(u), axis=1)
    components = np.einsum("nai,nij,nbj->nab", e, q, e).reshape(n, around, 2, 2)
    return bool(np.ptp(components, axis=1).max() > SYMMETRIC * components.max())


def drawn(metric: TwoMetric) -> TwoMetric:
    """The metric as it is on a fine grid: good enough for meshes, and quick where the metric is slow."""
    try:
        return GridMetric.sampled(metric, *(MESHED if varies(metric) else SYMMETRICALLY_MESHED))
    except InvalidMetric:  # too coarse a grid for it
        return metric


def _diagnosis(best: SmoothEmbedding, residuals: list[float]) -> str:
    trend = ", ".join(f"{r:.1e}" for r in residuals[-3:])
    missed = (
        f"with more and more harmonics the lengths are off by {trend}, and {best.tolerance:.0e} is allowed"
    )
    if best.hindrance:
        return f"{best.hindrance}; {missed}"
    if len(residuals) > 1 and residuals[-1] < FALLING * residuals[-2]:
        missed += ": the metric has details that are too fine for so few"
    return f"{missed}; {by_curvature(best.metric)}"
