"""Least-squares fits to lengths with errors, of surfaces with creases: lenses, boxes, cylinders, prisms.

A convex polyhedron gives the start, and its creases.  Where the most negative deficit is within the errors,
only negative deficits and those within the errors are changed (`isoembed.metric.repair`), and creases remain.
Other metrics, and bodies without creases, start from a diffusion of the curvature, which rounds all edges.
"""

from __future__ import annotations

from functools import partial
from itertools import islice

import numpy as np

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
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.metric.repair import repaired
from isoembed.progress.stages import StageRecorder
from isoembed.surface.measures import outward
from isoembed.surface.piecewise_smoothness import creases, piecewise_fit_residuals

CHANGED = 2.0
"""Root mean square change of the lengths, in standard deviations, by flattening vertices that are flat."""

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
    if not pipeline.problem.is_convex and not goes_by_levels(metric, None):
        convex = _convex_within_errors(metric)
        if convex is not None:
            try:
                found = convex_polyhedron(convex.normalized, PLACED, pipeline.log)
                start = outward(metric.faces, convex.unit * found.vertices)
                if next(creases(metric.triangulation, start), None) is not None:
                    return start
            except (InvalidMetric, NotEmbedded):  # too thin, or an iteration that failed
                pass
    return nearest_polyhedron(fresh(pipeline.problem), pipeline) if known is None else known


def _convex_within_errors(metric: PolyhedralMetric) -> PolyhedralMetric | None:
    """Metric without negative deficits, if errors explain those of the given one."""
    errors = np.asarray(metric.length_errors)
    error = float(np.max(errors)) / metric.mean_length
    if not is_convex_within(metric, error):
        return None
    spread = deficit_spread(metric.faces, metric.face_lengths, metric.triangulation.sides_across)
    noise = float(DEVIATIONS * error * spread.max())
    try:
        flattened = repaired(metric, noise)[0]
        if np.mean(((flattened.lengths - metric.lengths) / errors) ** 2) < CHANGED**2:
            return flattened
        return repaired(metric, noise, flat=np.zeros(metric.triangulation.n_vertices, dtype=np.bool_))[0]
    except InvalidMetric:  # the changed lengths break a triangle
        return None


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
        The one that best predicts each length from the others, of those that agree with the lengths and leave
        enough degrees of freedom to tell; if there is none, of all.

    Notes
    -----
    Without creases at the start, or if fits with them miss the lengths or follow them too closely for a
    comparison, a fit that is smooth everywhere is next.  It folds bodies with sharp edges, but mostly along
    these: they are the creases of further fits, as long as each predicts the lengths twice as well.

    A fit that encloses much less than a convex surface which agrees with the lengths, too, is folded: the
    convex one is taken.  So it is for rods one edge wide, whose creases leave no vertex to be smoothed.
    """
    errors, fits = np.asarray(metric.length_errors), list[BestFit]()
    error = root_mean_square(errors) / metric.mean_length

    def surface(fit: BestFit) -> MeasuredSurface:
        return measured_surface(metric, fit, "", 0.0)

    def misses(fit: BestFit) -> bool:
        is_vague = fit.degrees_of_freedom <= max(1.0, TELLING * len(metric.lengths))
        return is_vague or not surface(fit).converged

    def fitted(near: Floats, crease: Mask) -> BestFit:
        residuals = partial(piecewise_fit_residuals, metric.triangulation, crease, degree=2)
        return fit_within_errors(metric, errors, near, recorder, residuals)

    def is_enough(fit: BestFit) -> bool:
        return fit.weight == WEIGHT and not misses(fit)

    candidates = creases(metric.triangulation, start) if metric.space.is_euclidean else ()
    for crease in islice(candidates, MAX_FITS):
        fits.append(fitted(start, crease))
        if is_enough(fits[-1]):
            return fits[-1]
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
    best = min(fits, key=lambda fit: (misses(fit), fit.prediction_error(error)))
    convex = BestFit(start, weight=0.0, noise=0.0, degrees_of_freedom=1.0)
    is_folded = surface(best).volume < FOLDED * surface(convex).volume
    return convex if is_folded and is_convex_within(metric, error) and surface(convex).converged else best
