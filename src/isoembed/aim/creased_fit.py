"""Least-squares fits to lengths with errors, of surfaces with creases: lenses, boxes, cylinders, prisms.

A convex polyhedron gives the start, and its creases: that of the nearest lengths without negative deficits
(`isoembed.metric.nearest_convex`), if these are near the given ones.  Errors, dents between the rings of a
cone, and a wrong length leave them near.  Other metrics, and bodies without creases, start from a diffusion
of the curvature, which rounds all edges.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from itertools import islice

import numpy as np
from scipy.special import chdtri

from isoembed.aim.acceptance import PLACED
from isoembed.aim.best_fit import TELLING, WEIGHT, BestFit
from isoembed.aim.choice import FOLDED, is_convex_within
from isoembed.aim.levels import goes_by_levels, smooth_start
from isoembed.aim.measured_lengths import fit_within_errors, measured_surface, root_mean_square
from isoembed.aim.nearest_polyhedron import fresh, nearest_polyhedron
from isoembed.aim.pipeline import Pipeline
from isoembed.alexandrov.method import convex_polyhedron
from isoembed.arrays import Floats, Mask
from isoembed.embedding.measured import MeasuredSurface
from isoembed.errors import InvalidMetric, NotEmbedded
from isoembed.metric.convexity import DEVIATIONS, deficit_spread
from isoembed.metric.nearest_convex import nearest_convex
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.progress.stages import StageRecorder
from isoembed.surface.measures import outward
from isoembed.surface.piecewise_smoothness import creases, piecewise_fit_residuals

CHANGED = 0.01
"""Largest root mean square change, in mean edge lengths, to lengths of a convex body that keeps sharp edges:
0.007 for cones, whose edges between rings are dents, and 0.016 for the bean."""

DOUBTED = 0.05
"""Probability of a larger chi-square, below which vertices are not flat within the errors."""

MAX_FITS = 3
"""Fits with creases of the start."""

MAX_REFITS = 4
"""Fits with creases of earlier ones."""

GAIN = 0.5
"""Prediction error of such a fit, over that of the one before, at which another follows."""


def convex_start(metric: PolyhedralMetric, pipeline: Pipeline, known: Floats | None = None) -> Floats:
    """Vertices of a convex polyhedron near a metric with `length_errors`, (V, 3), or an approximation of it.

    `known`: vertices of the `nearest_polyhedron`, if computed already.
    """
    is_closed = metric.triangulation.is_sphere and metric.space.is_euclidean
    if is_closed and not pipeline.problem.is_convex and not goes_by_levels(metric, None):
        for convex in _convex_metrics(metric):
            try:
                found = convex_polyhedron(convex.normalized, PLACED, pipeline.log)
            except (InvalidMetric, NotEmbedded):  # too thin, or an iteration that failed
                continue
            start = outward(metric.faces, convex.unit * found.vertices)
            if next(creases(metric.triangulation, start), None) is not None:
                return start
    return nearest_polyhedron(fresh(pipeline.problem), pipeline) if known is None else known


def _convex_metrics(metric: PolyhedralMetric) -> Iterator[PolyhedralMetric]:
    """Yield the nearest metrics without negative deficits.

    First that in which all vertices are flat that may be by the errors of the lengths; not if these do not
    explain all negative deficits, or if the chi-square test contradicts that all those vertices are flat.
    """
    errors = np.maximum(np.asarray(metric.length_errors), np.finfo(float).eps * metric.mean_length)
    spread = deficit_spread(metric.faces, metric.face_lengths, metric.triangulation.sides_across)
    noise = DEVIATIONS * errors.max() / metric.mean_length * spread
    flat = np.abs(metric.deficits) <= noise
    try:
        if flat.any() and (metric.deficits >= -noise).all():
            flattened = nearest_convex(metric, errors, flat, CHANGED)
            if np.sum(((flattened.lengths - metric.lengths) / errors) ** 2) < chdtri(flat.sum(), DOUBTED):
                yield flattened
    except InvalidMetric:  # the vertices are not flat
        pass
    try:
        yield nearest_convex(metric, errors, np.zeros_like(flat), CHANGED)
    except InvalidMetric:  # far from that of a convex body
        return


def fit_with_creases(metric: PolyhedralMetric, start: Floats, recorder: StageRecorder) -> BestFit:
    """Fit a surface to a metric with `length_errors`, smooth between the creases of the start if it has any.

    Parameters
    ----------
    metric : PolyhedralMetric
        Scaled to a mean edge length of about 1.
    start : ndarray, shape (V, 3)
        A convex surface of similar shape and size: the `convex_start`.
    recorder : StageRecorder

    Returns
    -------
    BestFit
        The one that best predicts each length from the others, of those that agree with the lengths, but for
        wrong ones that they name, and leave enough degrees of freedom to tell; if there is none, of all.

    Notes
    -----
    Without creases at the start, or if fits with them miss the lengths or follow them too closely for a
    comparison, a fit that is smooth everywhere is next.  It folds bodies with sharp edges, but mostly along
    these: they are the creases of further fits, as long as each predicts the lengths twice as well.

    A fit that encloses much less than one with the creases of the start which agrees with the lengths, too,
    is folded: the latter is taken.  So it is for rods one edge wide, whose creases leave no vertex to be
    smoothed.
    """
    errors, fits = np.asarray(metric.length_errors), list[BestFit]()
    error = root_mean_square(errors) / metric.mean_length

    def surface(fit: BestFit) -> MeasuredSurface:
        return measured_surface(metric, fit, "", 0.0)

    def misses(fit: BestFit) -> bool:
        is_vague = fit.degrees_of_freedom <= max(1.0, TELLING * len(metric.lengths))
        return is_vague or not surface(fit)._others_agree

    def fitted(near: Floats, crease: Mask) -> BestFit:
        residuals = partial(piecewise_fit_residuals, metric.triangulation, crease, degree=2)
        return fit_within_errors(metric, errors, near, recorder, residuals)

    def is_enough(fit: BestFit) -> bool:
        return fit.weight >= WEIGHT and not misses(fit)

    def best(found: list[BestFit]) -> BestFit:
        return min(found, key=lambda fit: (misses(fit), fit.prediction_error(error)))

    candidates = creases(metric.triangulation, start) if metric.space.is_euclidean else ()
    for crease in islice(candidates, MAX_FITS):
        fits.append(fitted(start, crease))
        if is_enough(fits[-1]):
            return best(fits)
    n_sharp = len(fits)
    if all(map(misses, fits)):
        fits.append(fit_within_errors(metric, errors, smooth_start(metric, start, recorder), recorder))
    last = min(fits, key=lambda fit: fit.prediction_error(error))
    for _ in range(MAX_REFITS if metric.space.is_euclidean else 0):
        sharpest = list(islice(creases(metric.triangulation, last.vertices), 1))
        if not sharpest:
            break
        fits.append(fitted(last.vertices, sharpest[0]))
        if is_enough(fits[-1]) or fits[-1].prediction_error(error) > GAIN * last.prediction_error(error):
            break
        last = fits[-1]
    chosen = best(fits)
    for fit in fits[:n_sharp] if is_convex_within(metric, error) else ():
        if surface(fit).converged and surface(chosen).volume < FOLDED * surface(fit).volume:
            return fit
    return chosen
