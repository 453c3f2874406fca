"""Decisions of the default method: the choice among the candidates, and corrections to it."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from isoembed.aim.acceptance import is_accepted
from isoembed.aim.choice import (
    convex_ones,
    is_convex_within,
    is_preferred,
    requested,
    smoothest,
    with_neighbors,
)
from isoembed.aim.pipeline import Decision, Pipeline, State
from isoembed.aim.problem import Problem
from isoembed.embedding.embedding import Embedding
from isoembed.embedding.fitted import FittedSurface

if TYPE_CHECKING:
    from isoembed.aim.best_fit import BestFit
    from isoembed.embedding.measured import MeasuredSurface
    from isoembed.metric.polyhedral import PolyhedralMetric

FEW = 150  # largest number of vertices with a search for neighbors


def choose(state: State, pipeline: Pipeline) -> Embedding:
    """The smoothest candidate with the lengths; otherwise the best fit or a diagnosed failure."""
    problem, fit, method = pipeline.problem, state.fit, pipeline.method
    found = smoothest(state.candidates, problem.is_convex, state.searched)
    if found.converged or (is_accepted(found) and fit is None):
        return found
    from isoembed.aim.diagnosis import diagnosis

    fitted = None if fit is None else fitted_surface(fit, problem)
    if method.best_fit and fitted is not None:
        return fitted
    return found._with_message(diagnosis(found, fitted, method.effort))


class Neighbors(Decision):
    """Search for other realizations near a directly found one.

    Convex surfaces are unique among convex ones.  With many vertices, neighbors differ clearly in smoothness,
    and the search would dominate the cost.
    """

    key = "neighbors"

    def applies(self, answer: Embedding, state: State, pipeline: Pipeline) -> bool:
        is_small = answer.triangulation.n_vertices <= FEW
        return (
            answer.converged
            and answer.uniqueness is None
            and pipeline.method.effort > 0  # 0 means no search
            and is_small
            and bool(answer.surface.concave_edges.any())
        )

    def run(self, answer: Embedding, state: State, pipeline: Pipeline) -> Embedding:
        return with_neighbors(answer, pipeline.log)


class FitWithinDigits(Decision):
    """Smooth surface that agrees with rounded lengths, in place of a rough exact surface or a failure.

    Rounded coordinates are those of an exact surface, which may have any shape; only if it may be convex is
    another one fitted.
    """

    key = "fit within digits"

    def applies(self, answer: Embedding, state: State, pipeline: Pipeline) -> bool:
        doubtful = answer.surface.rough_edges.any() if answer.converged else not pipeline.method.best_fit
        metric = pipeline.problem.metric
        error = metric.point_rounding
        return bool(doubtful) and (
            metric.rounding is not None or (error is not None and is_convex_within(metric, error))
        )

    def run(self, answer: Embedding, state: State, pipeline: Pipeline) -> Embedding:
        from isoembed.aim.creased_fit import convex_start, fit_with_creases
        from isoembed.aim.measured_lengths import measured_surface, with_errors_of_digits, within_digits

        metric = with_errors_of_digits(answer.metric)
        start = convex_start(metric, pipeline, state.start)
        with pipeline.log.stage("fit within errors") as recorder:
            fit = fit_with_creases(metric, start, recorder)
        return within_digits(answer, measured_surface(metric, fit, answer.method, answer.tolerance))


class AskedFor(Decision):
    """The requested realization among those found.

    Where none is convex, a fit to lengths with errors may be.
    """

    key = "asked for"

    def applies(self, answer: Embedding, state: State, pipeline: Pipeline) -> bool:
        which = pipeline.method.which
        if which is None or not answer.converged:
            return False
        return which != "convex" or state.measured is None or bool(convex_ones(answer))

    def run(self, answer: Embedding, state: State, pipeline: Pipeline) -> Embedding:
        which = pipeline.method.which
        return answer if which is None else requested(answer, which)


class SmootherWithinErrors(Decision):
    """Smooth fit to lengths with errors, or the exact surface if it is better.

    The exact surface is better if it `is_preferred`, or if the errors are too small for a fit.  A rougher one
    would follow blunders, and so would any if the fit agrees with all lengths but those it names.
    """

    key = "smoother within errors"

    def applies(self, answer: Embedding, state: State, pipeline: Pipeline) -> bool:
        return state.measured is not None

    def run(self, answer: Embedding, state: State, pipeline: Pipeline) -> Embedding:
        assert state.measured is not None
        found, exact = measured_candidate(state.measured, pipeline), answer
        if not exact.converged:
            return found
        if found._suspects and found._others_agree:
            return found._with_others([exact])
        if is_preferred(exact, found) or (not found.converged and has_small_errors(pipeline.metric)):
            found = replace(
                found,
                vertices=exact.vertices,
                weight=0.0,
                scatter=0.0,
                redundancy=0.0,
                predicted=None,
                alike=None,
                length_errors=None,
                message="",
            )
        elif not found.converged:
            found = found._with_others([exact])
        return found


def fitted_surface(fit: BestFit, problem: Problem) -> FittedSurface:
    """The surface of a best fit."""
    return FittedSurface(
        problem.metric,
        fit.vertices,
        noise=fit.scatter,
        weight=fit.weight,
        method=problem.name,
        tolerance=problem.tolerance,
    )


def has_small_errors(metric: PolyhedralMetric) -> bool:
    """Whether the errors of the lengths are so small that a surface with exactly these is sought as well."""
    from isoembed.aim.measured_lengths import SMALL

    return bool(np.max(np.asarray(metric.length_errors)) < SMALL * metric.mean_length)


def measured_candidate(fit: BestFit, pipeline: Pipeline) -> MeasuredSurface:
    """The smooth surface within the errors of the lengths."""
    from isoembed.aim.measured_lengths import measured_surface

    return measured_surface(pipeline.metric, fit, pipeline.problem.name, pipeline.problem.tolerance)


DECISIONS = Neighbors(), FitWithinDigits(), AskedFor(), SmootherWithinErrors()  # after the choice
