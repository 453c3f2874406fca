"""Regularized fit to edge lengths with known standard deviations or rounded digits: discrepancy principle.

The exact surface of lengths with errors is often crumpled, or does not exist.  This fit minimizes
``sum (r / s)^2 + mu |R x|^2`` with the standard deviations s and the roughness R
(`isoembed.aim.regularized_energy`).  mu decreases from a large value, so that the surface stays smooth, until
``sum (r / s)^2`` is at most its expected value, E - trace H, where H is the matrix from given to fitted
lengths: the discrepancy principle, corrected for the degrees of freedom of the fit.  If no mu reaches it, the
smoothest fit is taken that the chi-square test does not reject, or the nearest to that.

A blunder, one length that is wrong by many deviations, is followed by fits with small mu.  In those with
large mu it is an outlier of the studentized residuals, r over ``s sqrt(1 - H_ee)`` with s estimated from the
other residuals but at least the errors.  If one is too large, the fits are repeated without that length.  The
charts of a large mu are those of the start, which may have followed the length: it is sought once more where
mu is small enough to release them.  Of
320 rocks, ellipsoids, domes, boxes and Johnson solids with right lengths none had one above seven (the
largest of as many normal errors is at most 4.6); of 46 with one length wrong by 35 deviations 35 had one, and
it was the wrong length.

Bodies with sharp edges are fitted in `isoembed.aim.creased_fit`.

On rough ellipsoids of 80 vertices this was closer to the true vertices than generalized cross-validation,
marginal likelihood and a fixed mu.

References
----------
Wahba, Bayesian "confidence intervals" for the cross-validated smoothing spline, J. R. Stat. Soc. B 45 (1983).
Baarda, A testing procedure for use in geodetic networks, Netherlands Geodetic Commission 2/5 (1968).
Morozov, On the solution of functional equations by the method of regularization, Soviet Math. Dokl. 7 (1966).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import compress
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array
from scipy.special import chdtri

from isoembed.aim.best_fit import FREE, UNBIASED, WEIGHT, BestFit, Fits
from isoembed.aim.choice import is_preferred
from isoembed.aim.levels import goes_by_levels
from isoembed.aim.smoothing_energy import SmoothingEnergy
from isoembed.arrays import Floats, Indices
from isoembed.embedding.embedding import Embedding
from isoembed.embedding.measured import (
    MARGIN,
    OUTLIER,
    SCATTERED,
    SIGNIFICANCE,
    SUSPECTS,
    MeasuredSurface,
    outlier_limit,
    standing_out,
)
from isoembed.linalg.work import Budget
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.progress.stages import StageRecorder
from isoembed.surface.rigidity import length_residuals

Residuals = Callable[[Floats], csr_array]
"""The matrix R of residuals of fits about given vertices."""

LEAST_WEIGHT = 1e-14
"""Least mu, in squared mean edge lengths, at which lengths are met to rounding."""

RISES = 5
"""Successive fits without improvement that end the search, a factor of 300 in mu."""

START = 0.01
"""Roughness of the start at the first mu, as a share of the sum of squared lengths."""

BELOW_NOISE = 0.1
"""Root mean square of the residuals, over that of the errors, below which lengths do not determine mu."""

SMALL = 1e-5
"""Errors, over the mean edge length, below which the exact surface is sought as well.
Both are near to the truth if on its branch; they may differ in vertices reflected through their neighbors,
and the smoother one is right more often."""


def measured_surface(metric: PolyhedralMetric, fit: BestFit, name: str, tolerance: float) -> MeasuredSurface:
    """Surface of a fit to the lengths of a metric with errors, with the name of the method."""
    free = fit.degrees_of_freedom
    return MeasuredSurface(
        metric,
        fit.vertices,
        method=name,
        tolerance=tolerance,
        weight=fit.weight,
        scatter=fit.scatter,
        redundancy=free / len(metric.lengths) if free > 1.0 + 1e-9 else 0.0,  # 1 is the least estimate
        predicted=fit.predicted,
        alike=fit.alike,
    )


def with_errors_of_digits(metric: PolyhedralMetric) -> PolyhedralMetric:
    """Metric of rounded lengths or coordinates with the errors of their last digit."""
    return metric.with_length_errors(_digits(metric) * metric.mean_length)


def _digits(metric: PolyhedralMetric) -> float:
    """Standard deviation of rounded lengths, or of lengths between rounded points, in mean edge lengths."""
    error = metric.point_rounding if metric.rounding is None else metric.rounding
    assert error is not None
    return error


def within_digits(exact: Embedding, found: MeasuredSurface) -> Embedding:
    """Smooth surface that agrees with rounded lengths, in place of a rough one or of a failure.

    Parameters
    ----------
    exact : Embedding
        Exact surface or nearest attempt, of a normalized metric with a `rounding`.
    found : MeasuredSurface
        Smooth surface.

    Returns
    -------
    Embedding
        A `MeasuredSurface`, with the exact one among its `others`; or the exact one, if no smooth surface
        agrees with the lengths within their digits, or none that is smoother.
    """
    if exact.converged and is_preferred(exact, found):
        return exact
    if found.converged:
        return found._with_others([exact] if exact.converged else [])
    of_points = exact.metric.rounding is None
    origin = "coordinates" if of_points else "their last digit"
    digits = f"errors of {origin}, {_digits(exact.metric):.1e} of the mean edge length"
    if found._suspects and not of_points:
        doubt = f"no smooth surface has the lengths within {digits}: {found._advice(in_percent=True)}"
    elif exact.converged:
        doubt = f"no smooth surface has the lengths within {digits}; the errors may be larger"
    else:
        return exact
    return exact._with_message(f"{exact.message}\n{doubt}")


def fit_within_errors(
    metric: PolyhedralMetric,
    errors: Floats,
    start: Floats,
    recorder: StageRecorder,
    residuals: Residuals | None = None,
) -> BestFit:
    """Fit a surface to lengths with errors, as smooth as their residuals allow.

    Parameters
    ----------
    metric : PolyhedralMetric
        Scaled to a mean edge length of about 1.
    errors : ndarray, shape (E,)
        Standard deviations of the lengths.
    start : ndarray, shape (V, 3)
        A surface of similar shape and size, smooth between its creases.
    recorder : StageRecorder
    residuals : callable, optional
        The matrix R about given vertices, of a surface that is not smooth everywhere.

    Returns
    -------
    BestFit
    """
    errors = np.maximum(errors, np.finfo(float).eps * metric.mean_length)  # of doubles
    known, begin = np.array(errors), _Start.of(metric, start, recorder, residuals)
    for _ in range(SUSPECTS):
        fit, suspect = _fit_of_smooth_start(metric, known, begin, recorder)
        wrong = _followed(metric, known, fit, begin, recorder) if suspect is None else [suspect]
        if not wrong:
            break
        known[wrong] = metric.mean_length
        begin = _start_without(metric, known, begin, recorder)
    else:
        fit = _fit_of_smooth_start(metric, known, begin, recorder, most=np.inf)[0]
    off = np.abs(_lengths(metric, fit) - metric.lengths) / errors
    without, doubt = fit, standing_out(off) if (known == errors).all() else None
    if doubt is not None and _stands_out(metric, known, fit, doubt, begin, recorder):
        known[doubt] = metric.mean_length
        begin = _start_without(metric, known, begin, recorder)
        without = _fit_of_smooth_start(metric, known, begin, recorder, most=np.inf)[0]
    left_out = known != errors
    suspected = np.flatnonzero(left_out)
    if suspected.size or doubt is not None:
        predicted = np.where(left_out, _lengths(metric, without) / metric.mean_length, np.nan)
        fit = replace(fit, predicted=predicted)
    if not suspected.size and off.max() > outlier_limit(len(off)):
        suspected = np.argmax(off, keepdims=True)
    if suspected.size:
        fit = replace(fit, alike=_alike(metric, errors, known, suspected, without, begin, recorder))
    return fit


def _lengths(metric: PolyhedralMetric, fit: BestFit) -> Floats:
    a, b = fit.vertices[metric.edges.T]
    return metric.space.distances(a, b)


class _Start(NamedTuple):
    """Start of fits, and the energy in its charts, whose analysis and factors they share."""

    vertices: Floats
    energy: SmoothingEnergy
    residuals: Residuals | None

    @classmethod
    def of(
        cls,
        metric: PolyhedralMetric,
        vertices: Floats,
        recorder: StageRecorder,
        residuals: Residuals | None,
    ) -> _Start:
        R = None if residuals is None else residuals(vertices)
        return cls(vertices, SmoothingEnergy(metric, vertices, recorder.work, R), residuals)


def _start_without(
    metric: PolyhedralMetric, errors: Floats, start: _Start, recorder: StageRecorder
) -> _Start:
    """Start for fits without the lengths with large errors; the given start bulges at wrong lengths.

    Starts interpolated from a coarse level are too smooth for that.
    """
    if goes_by_levels(metric, None):
        return start
    fit = _fit_of_smooth_start(metric, errors, start, recorder, most=np.inf)[0]
    return _Start.of(metric, fit.vertices, recorder, start.residuals)


def _followed(
    metric: PolyhedralMetric, errors: Floats, fit: BestFit, start: _Start, recorder: StageRecorder
) -> list[int]:
    """The length that causes most of the scatter of a fit, a blunder that the fit has followed.

    It is an outlier of fits to errors as large as the scatter, and without it the scatter is at most half as
    large.  On a doubled cap it is the length of two edges.
    """
    scatter, wrong = fit.scatter * metric.mean_length, list[int]()
    if scatter <= SCATTERED * root_mean_square(errors):
        return wrong
    known = np.maximum(errors, scatter)
    for _ in range(2):
        last, suspect = _fit_of_smooth_start(metric, known, start, recorder)
        if wrong and _halves(last, fit):
            return wrong
        if suspect is None:
            r = length_residuals(metric.triangulation, last.vertices, metric.lengths, metric.space)
            suspect = int(np.argmax(np.abs(r) / known))
        if wrong and metric.lengths[suspect] != metric.lengths[wrong[0]]:
            return []
        wrong.append(suspect)
        known = np.maximum(errors, scatter / SCATTERED**2)
        known[wrong] = metric.mean_length
        start = _Start.of(metric, last.vertices, recorder, start.residuals)
    last = _fit_of_smooth_start(metric, known, start, recorder, most=np.inf)[0]
    return wrong if _halves(last, fit) else []


def _stands_out(
    metric: PolyhedralMetric,
    errors: Floats,
    fit: BestFit,
    edge: int,
    start: _Start,
    recorder: StageRecorder,
) -> bool:
    """Whether a residual stands out of those nearby in a fit, or in one with a smaller mu."""
    energy = start.energy.weighted(root_mean_square(errors) / errors)
    fits = Fits(metric, energy, recorder, Budget(recorder.work, np.inf))
    limit = MARGIN * outlier_limit(len(errors))
    for weight in (fit.weight, fit.weight / np.sqrt(10.0)):
        fit = fits.fit(fit.vertices, weight)
        if fits.stands_out(fit, edge, limit):
            return True
    return False


def _alike(
    metric: PolyhedralMetric,
    errors: Floats,
    known: Floats,
    suspected: Indices,
    without: BestFit,
    start: _Start,
    recorder: StageRecorder,
) -> Indices:
    """Other edges, an error of which explains the lengths as well as one of those suspected, the best first.

    The fits have the mu of a fit without these, and begin at it.
    """
    found = list[Indices]()
    for e in suspected.tolist():
        sigma = np.where(np.arange(len(errors)) == e, errors, known)
        rms = root_mean_square(sigma)
        energy = start.energy.weighted(rms / sigma)
        fits = Fits(metric, energy, recorder, Budget(recorder.work, np.inf))
        found.append(fits.alike(fits.fit(without.vertices, without.weight), e, rms))
    return other_edges(np.concatenate(found), suspected)


def other_edges(edges: Indices, suspected: Indices) -> Indices:
    """The edges that are not suspected, each once, in their order."""
    return np.array([e for e in dict.fromkeys(edges.tolist()) if e not in suspected], dtype=np.int64)


def _halves(without: BestFit, fit: BestFit) -> bool:
    """Whether a fit without a length has at most half the scatter, with enough degrees of freedom."""
    return without.degrees_of_freedom > FREE and 0 < without.scatter <= fit.scatter / SCATTERED


def root_mean_square(errors: Floats) -> float:
    """Root mean square of errors, weighted so that large ones have no influence."""
    least = errors.min()
    return float(least / np.sqrt(np.mean((least / errors) ** 2)))


def _fit_of_smooth_start(
    metric: PolyhedralMetric, errors: Floats, start: _Start, recorder: StageRecorder, most: float = OUTLIER
) -> tuple[BestFit, int | None]:
    """The fit, and the first length whose studentized residual exceeds the limit, which ends the search."""
    rms = root_mean_square(errors)
    energy = start.energy.weighted(rms / errors)
    fits = Fits(metric, energy, recorder, Budget(recorder.work, np.inf))
    # The energy does not increase, so that the sum of squared residuals grows by at most this share of the
    # sum of squared lengths: no body collapses, however sharp its corners.
    penalty = float(np.sum(start.vertices * energy.roughness(start.vertices, 0.0)))
    bound = START * float(metric.lengths @ metric.lengths) / metric.mean_length**2
    weight = min(WEIGHT, bound / penalty) if penalty > 0 else WEIGHT
    known = rms / metric.mean_length  # comparable to the noise of a fit, over the mean edge length
    limit = outlier_limit(len(errors)) * rms
    found: list[BestFit] = []
    vertices, suspect, worst = start.vertices, None, None
    while True:
        fit = fits.fit(vertices, weight)
        if suspect is not None and fits.persists(fit, suspect, most):
            return fit, suspect.edge
        if worst is not None and fits.persists(fit, worst, limit / rms):
            return found[-1], None
        found.append(fit)
        r = energy.residuals(fit.vertices, metric.lengths)
        suspect = fits.outlier(fit, rms, most)
        if fit.noise <= known:
            e = int(np.argmax(np.abs(r)))
            exceeds = abs(r[e]) > limit
            worst = fits.tested(fit, e) if exceeds else None
            if not exceeds and suspect is None:
                break
        if np.sqrt(np.mean(r**2)) < BELOW_NOISE * rms:
            return fit, None
        least = int(np.argmin([one.noise for one in found]))
        if fit.weight <= LEAST_WEIGHT or len(found) - least > RISES:
            agrees = (one.noise / known < _largest_ratio(one.degrees_of_freedom) for one in found)
            return next(compress(found, agrees), found[least]), None
        vertices, weight = fit.vertices, fit.weight / np.sqrt(10.0)
    wrong = _released_outlier(fits, fit, rms, most)
    if wrong is not None:
        return fit, wrong
    before = found[-2:][0]
    passes = np.abs(energy.residuals(before.vertices, metric.lengths)).max() <= limit
    # The nearer, by the ratio to the standard deviation.
    nearer = before.noise > known and before.noise * fit.noise < known**2
    return before if passes and nearer else fit, None


def _released_outlier(fits: Fits, fit: BestFit, error: float, most: float) -> int | None:
    """The length that is an outlier where mu is small enough to release the charts, if one is.

    The charts of a large mu are those of the start, which has followed a wrong length.
    """
    if fit.weight <= UNBIASED or np.isinf(most):
        return None
    released = fits.fit(fit.vertices, UNBIASED)
    suspect = fits.outlier(released, error, most)
    if suspect is None:
        return None
    released = fits.fit(released.vertices, UNBIASED / np.sqrt(10.0))
    return suspect.edge if fits.persists(released, suspect, most) else None


def _largest_ratio(degrees_of_freedom: float) -> float:
    """Largest ratio of the noise of a fit to the given errors that the chi-square test accepts."""
    return float(np.sqrt(chdtri(degrees_of_freedom, SIGNIFICANCE) / degrees_of_freedom))
