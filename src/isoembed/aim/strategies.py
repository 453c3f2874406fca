"""Strategies of the default method in the order in which they are tried.

The paper's three steps, uniformize, embed and pull back, are `NearestPolyhedron` and its successors up to
`GuidedPath`.  Earlier strategies solve convex and nearly convex metrics directly; later ones follow a
pull-back that missed the lengths.  Then one candidate is chosen (`isoembed.aim.decisions`).
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from isoembed.aim.acceptance import REALIZED, is_accepted, is_exact, is_near
from isoembed.aim.choice import FAR, FOLDED, no_convex, not_convex, reference_vertices, smoothest
from isoembed.aim.convexification import NEAR_MARGIN
from isoembed.aim.decisions import fitted_surface, has_small_errors, measured_candidate
from isoembed.aim.nearest_polyhedron import fresh, nearest_polyhedron, polished_polyhedron
from isoembed.aim.pipeline import Pipeline, State, Strategy
from isoembed.aim.polygon_planarity import has_planar_polygons
from isoembed.aim.problem import Problem
from isoembed.aim.stage_seconds import AT_ONCE, BY_A_POLYTOPE, GUIDED, LOCAL, PULL_BACK
from isoembed.arrays import Floats
from isoembed.embedding.embedding import Embedding
from isoembed.errors import InvalidMetric
from isoembed.progress.checkpoints import Arrays

if TYPE_CHECKING:
    from isoembed.aim.regularized_continuation import Continued

# Imports inside of strategies are slow, and not needed for convex bodies.

RADII_DEVIATION = 0.25  # largest trusted branch deviation, in heights on a sphere
LENGTHS_DEVIATION = 0.6  # largest trusted branch deviation, in heights (root mean square)
FIT = 36  # typical factorizations of the best fit


class NoConvexSurface(Strategy):
    """Refusal to search for a convex surface of exact lengths with a negative deficit."""

    key = "no convex surface"

    def applies(self, state: State, pipeline: Pipeline) -> bool:
        metric = pipeline.metric
        is_exact = metric.length_errors is None and metric.rounding is None
        return pipeline.method.which == "convex" and is_exact and not_convex(metric)

    def run(self, state: State, pipeline: Pipeline) -> State:
        start = nearest_polyhedron(fresh(pipeline.problem), pipeline)
        raise no_convex(pipeline.problem.surface(start))


class FitWithinErrors(Strategy):
    """Smooth surface that agrees with lengths within their errors, usually the answer.

    Needs nothing.  The surface with exactly these lengths is sought as well if no smooth one agrees or the
    errors are small.
    """

    key = "fit within errors"

    def applies(self, state: State, pipeline: Pipeline) -> bool:
        return pipeline.metric.length_errors is not None

    def run(self, state: State, pipeline: Pipeline) -> State:
        from isoembed.aim.best_fit import looks_noisy
        from isoembed.aim.creased_fit import convex_start, fit_with_creases

        metric = pipeline.metric
        start = convex_start(metric, pipeline)
        with pipeline.log.stage("fit within errors") as recorder:
            fit = fit_with_creases(metric, start, recorder)
        found = measured_candidate(fit, pipeline)
        # The start of a convex metric is its only convex surface.
        convex = pipeline.problem.surface(start)
        is_folded = pipeline.problem.is_convex and found.volume < FOLDED * convex.volume
        missed = not (found.converged or looks_noisy(metric, start))
        exact = has_small_errors(metric) or is_folded or missed
        return replace(state, measured=fit, answer=None if exact else found)


class NearReferenceSurface(Strategy):
    """Realization that damped Newton steps reach from the reference surface, if one is given by `which`.

    Needs nothing; finds a candidate, which is trusted if it is close to the reference surface.
    """

    key = "near reference surface"

    def applies(self, state: State, pipeline: Pipeline) -> bool:
        return isinstance(pipeline.method.which, tuple)

    def run(self, state: State, pipeline: Pipeline) -> State:
        from isoembed.aim.anneal import anneal, anneal_damped

        problem, lengths = pipeline.problem, pipeline.problem.metric.lengths
        reference = reference_vertices(problem.metric, np.array(pipeline.method.which))
        with pipeline.log.stage("nearest") as recorder:
            end = anneal_damped(  # J is singular where the surface flexes
                problem.system,
                reference,
                lengths,
                recorder,
                residual_tolerance=1e-13,  # mean edge lengths
                max_iterations=60,
            )
            if not end.converged:
                end = anneal(problem.system, end.vertices, lengths, recorder, max_iterations=30)
        found = problem.surface(end.vertices)
        if not is_accepted(found):
            return state
        return state.adding(found, trusted=problem.placed(reference).distance(found) < FAR)


class NewtonOnRadii(Strategy):
    """Newton's method on the radii for nearly convex metrics, on the given triangles alone.

    Needs nothing; finds a candidate that is trusted.
    """

    key = "newton on radii"

    def applies(self, state: State, pipeline: Pipeline) -> bool:
        return not state.trusted and pipeline.problem.is_nearly_convex

    def run(self, state: State, pipeline: Pipeline) -> State:
        from isoembed.aim.newton_on_radii import newton_on_radii

        problem = pipeline.problem
        pipeline.log.expect(AT_ONCE)
        vertices = newton_on_radii(
            problem.convexification.original, problem.analyses, pipeline.log, problem.in_original_order
        )
        return state if vertices is None else accepted(state, problem, vertices)


class NearestPolytope(Strategy):
    """Generalized polytope of a convex metric near a nearly convex one, with flips.

    Needs nothing; finds the start of Newton's method on the radii, or the polyhedron itself.
    """

    key = "nearest polytope"

    def applies(self, state: State, pipeline: Pipeline) -> bool:
        return not state.trusted and pipeline.problem.is_nearly_convex

    def run(self, state: State, pipeline: Pipeline) -> State:
        from isoembed.aim.newton_from_polytope import polytope_start

        problem, log = pipeline.problem, pipeline.log
        convexification = problem.convexification
        log.expect(BY_A_POLYTOPE)
        with log.stage("nearest waypoint") as recorder:
            convex = convexification.metric(NEAR_MARGIN, recorder)
        if convex is None:
            return state
        body = polytope_start(convexification.original, convex, problem.analyses, log)
        if body is not None and body.ndim == 2 and problem.is_convex:
            polyhedron = polished_polyhedron(problem.in_original_order(body), pipeline)
            if is_exact(polyhedron):
                return state.adding(polyhedron, trusted=True)
        return replace(state, body=body)


class NewtonFromPolytope(Strategy):
    """Newton's method on the radii from the generalized polytope of a nearby convex metric.

    Needs the body; finds a candidate that is trusted.
    """

    key = "newton from polytope"

    def applies(self, state: State, pipeline: Pipeline) -> bool:
        return not state.trusted and state.body is not None

    def run(self, state: State, pipeline: Pipeline) -> State:
        from isoembed.aim.newton_from_polytope import newton_from_polytope

        problem, body = pipeline.problem, state.body
        assert body is not None
        solution = newton_from_polytope(
            problem.convexification.original, body, problem.analyses, pipeline.log, problem.in_original_order
        )
        if solution is None or not solution.branch_deviation < RADII_DEVIATION:
            return state
        return accepted(state, problem, solution.vertices)


class NearestPolyhedron(Strategy):
    """Steps 1 and 2 of the paper: the polyhedron of a nearby convex metric.

    Needs nothing; finds the start of all later strategies.
    """

    key = "nearest polyhedron"

    def run(self, state: State, pipeline: Pipeline) -> State:
        pipeline.problem.forget_analyses()
        return replace(state, body=None, start=nearest_polyhedron(pipeline.problem, pipeline))


class NewtonOnLengths(Strategy):
    """Step 3 in one step: Newton's method on the lengths.

    Needs the start; finds a candidate that is trusted if it stays on the branch of the start.
    """

    key = "newton on lengths"

    def run(self, state: State, pipeline: Pipeline) -> State:
        from isoembed.aim.newton_on_lengths import newton_on_lengths

        problem, start = pipeline.problem, started(state)
        pipeline.log.expect(PULL_BACK)
        with pipeline.log.stage("pull back") as recorder:
            recorder.show(t=1.0, vertices=start)
            solution = newton_on_lengths(
                problem.system,
                start,
                problem.metric.lengths,
                min(problem.tolerance, REALIZED),
                recorder,
            )
            if solution is not None:
                recorder.show(t=0.0, vertices=solution.vertices)
                state = state.adding(problem.surface(solution.vertices))
        cost, polyhedron = pipeline.work.factorizations, problem.surface(start)
        if problem.is_convex and is_exact(polyhedron):
            return state.adding(polyhedron, trusted=True, cost=cost)
        on_branch = solution is not None and (
            problem.is_convex or solution.branch_deviation < LENGTHS_DEVIATION
        )
        return replace(state, trusted=on_branch and state.candidates[-1].converged, cost=cost)


class PlanarPolygons(Strategy):
    """Surface on which given polygons are planar, where none is found yet.

    Starts at the start and at accepted candidates; finds a candidate that is trusted.
    """

    key = "planar polygons"

    def applies(self, state: State, pipeline: Pipeline) -> bool:
        metric = pipeline.problem.metric
        return (
            len(metric.diagonals) > 0
            and metric.space.is_euclidean
            and not any(is_accepted(found) and has_planar_polygons(found) for found in state.candidates)
        )

    def run(self, state: State, pipeline: Pipeline) -> State:
        from isoembed.aim.planar_polygons import with_planar_polygons

        problem = pipeline.problem
        starts = [] if state.start is None else [state.start]
        starts += [found.vertices for found in state.candidates if is_accepted(found)]
        with pipeline.log.stage("planar polygons") as recorder:
            for start in starts:
                near = with_planar_polygons(problem.metric, start, recorder)
                found = problem.surface(near)
                if not is_exact(found):  # rounded coordinates, whose polygons are not exactly planar
                    found = problem.annealed(near, recorder)
                if is_exact(found) and has_planar_polygons(found):
                    return state.adding(found, trusted=True)
        return state


class FitOfNoise(Strategy):
    """Best fit, if requested, to noisy lengths, without a search for exact surfaces.

    Needs the start; usually the fit is the answer.
    """

    key = "fit of noise"

    def applies(self, state: State, pipeline: Pipeline) -> bool:
        if state.trusted or not pipeline.method.best_fit:
            return False
        from isoembed.aim.best_fit import looks_noisy

        return looks_noisy(pipeline.problem.metric, started(state))

    def run(self, state: State, pipeline: Pipeline) -> State:
        from isoembed.aim.diagnosis import UNLIKE

        state = with_best_fit(state, pipeline, np.inf)
        fit = state.fit
        if fit is None or fit.noise > UNLIKE or not is_unsolved(state, pipeline):
            return state
        return replace(state, answer=fitted_surface(fit, pipeline.problem))


class PatchReflections(Strategy):
    """Step 3 for metrics with dents: reflections of patches, each inward or outward.

    Needs the start; finds candidates that are trusted if they have the lengths.
    """

    key = "patch reflections"

    def applies(self, state: State, pipeline: Pipeline) -> bool:
        return not state.trusted and pipeline.problem.metric.space.is_euclidean

    def run(self, state: State, pipeline: Pipeline) -> State:
        from isoembed.aim.patch_reflections import reflected_realizations
        from isoembed.metric.dents import dents

        problem, start = pipeline.problem, started(state)
        patches = dents(problem.metric)
        if not patches:
            return state
        with pipeline.log.stage("mirrored patches") as recorder:
            choices = reflected_realizations(
                problem.metric, problem.system, problem.energy(start), start, patches, recorder
            )
            found = [problem.surface(vertices) for vertices in choices]
        state = state.adding(*found)
        realized = [surface for surface in found if is_exact(surface)]
        if realized:
            state = with_smoother(
                state, min(realized, key=lambda surface: surface.surface.fine_roughness), pipeline
            )
        return replace(state, trusted=bool(realized), cost=pipeline.work.factorizations)


class GuidedPath(Strategy):
    """Step 3 in all other cases: a guided path of metrics, multilevel for many vertices.

    Needs the start; finds a candidate, and the smooth end of the path.
    """

    key = "guided path"

    def run(self, state: State, pipeline: Pipeline) -> State:
        from isoembed.aim.regularized_continuation import Continued

        problem = pipeline.problem
        pipeline.log.expect(GUIDED)
        checkpoint = pipeline.checkpoints.resume()
        if checkpoint is not None and "guided" in checkpoint:
            guided = Continued(checkpoint["smooth"], checkpoint["guided"])
        else:
            guided = self._followed(started(state), pipeline, checkpoint)
        with pipeline.log.stage("polish") as recorder:
            recorder.keep(guided=guided.vertices, smooth=guided.smooth)
            found = problem.annealed(guided.vertices, recorder)
            recorder.show(vertices=found.vertices)
        state = with_smoother(state.adding(found, smooth=guided.smooth), found, pipeline)
        return replace(state, cost=pipeline.work.factorizations)

    def _followed(self, start: Floats, pipeline: Pipeline, checkpoint: Arrays | None) -> Continued:
        """End of the path, close enough to the lengths for Newton's method."""
        from isoembed.aim.levels import goes_by_levels, pulled_back_by_levels
        from isoembed.aim.regularized_continuation import Continued, log_linear, regularized_continuation
        from isoembed.linalg import SingularMatrix

        problem, metric = pipeline.problem, pipeline.problem.metric
        with pipeline.log.stage("guided pull back") as recorder:
            if goes_by_levels(metric, checkpoint):
                with suppress(SingularMatrix, InvalidMetric):  # coarse vertices on needle-shaped triangles
                    found = pulled_back_by_levels(metric, problem.system, start, recorder, checkpoint)
                    if found is not None:
                        return Continued(found, found)
                checkpoint = None
            path = log_linear(metric, start)
            return regularized_continuation(problem.energy(start), start, path, recorder, checkpoint)


class LocalSearch(Strategy):
    """Reflection of patches on the wrong side, after a pull-back that missed the lengths.

    Needs the start and candidates; finds two more.  The search starts from the nearest candidate for coarse
    surfaces, otherwise from the smooth end of the path, whose pits are in the right places.  It is skipped if
    lengths are missed everywhere, as with noise.
    """

    key = "local search"

    def applies(self, state: State, pipeline: Pipeline) -> bool:
        is_euclidean = pipeline.problem.metric.space.is_euclidean
        return is_euclidean and pipeline.method.effort > 0 and is_unsolved(state, pipeline)

    def run(self, state: State, pipeline: Pipeline) -> State:
        from isoembed.aim.local_search import COARSE, local_search, misses_locally

        problem, lengths = pipeline.problem, pipeline.problem.metric.lengths
        energy, start = problem.energy(started(state)), state.nearest.vertices
        left = pipeline.patch_budget(state) - FIT  # share of the best fit
        if len(start) > COARSE:
            start = start if state.smooth is None else state.smooth
            if not misses_locally(energy, start, lengths):
                return state
        pipeline.log.expect(LOCAL)
        with pipeline.log.stage("local search") as recorder:
            found = local_search(energy, problem.system, start, lengths, recorder, max(left, 0.0))
            recorder.show(vertices=found.end)
            end = problem.annealed(found.end, recorder)
        return with_smoother(state.adding(end, problem.surface(found.nearest)), end, pipeline)


class BestFitting(Strategy):
    """Best fit to lengths that are still missed, which also serves as a further start.

    Needs the start; finds two candidates and the fit.
    """

    key = "best fit"

    def applies(self, state: State, pipeline: Pipeline) -> bool:
        return state.fit is None and is_unsolved(state, pipeline)

    def run(self, state: State, pipeline: Pipeline) -> State:
        from isoembed.aim.anneal import POLISH_STEPS

        requested = pipeline.method.best_fit
        return with_best_fit(
            state, pipeline, np.inf if requested else pipeline.patch_budget(state) - POLISH_STEPS
        )


class VertexReflections(Strategy):
    """Reflections of vertices on the wrong side of the nearest candidate, for ``effort > 1``.

    Needs the start and candidates; finds one more.
    """

    key = "vertex reflections"

    def applies(self, state: State, pipeline: Pipeline) -> bool:
        problem = pipeline.problem
        return (
            pipeline.method.effort > 1
            and not is_accepted(state.nearest)
            and problem.metric.space.is_euclidean
        )

    def run(self, state: State, pipeline: Pipeline) -> State:
        from isoembed.aim.reflection_search import with_reflected_vertices

        problem, energy = pipeline.problem, pipeline.problem.energy(started(state))
        pipeline.log.expect({"changes of sides": 500.0})
        with pipeline.log.stage("changes of sides") as recorder:
            vertices = with_reflected_vertices(
                energy,
                problem.system,
                state.nearest.vertices,
                problem.metric.lengths,
                recorder,
                pipeline.reflection_budget(state),
            )
        found = problem.surface(vertices)
        return with_smoother(state.adding(found), found, pipeline)


# Shared by strategies


def started(state: State) -> Floats:
    """The start of the pull-back, needed by all strategies after `NearestPolyhedron`."""
    assert state.start is not None
    return state.start


def accepted(state: State, problem: Problem, vertices: Floats) -> State:
    """The state with a trusted surface added, if its residual is small."""
    found = problem.surface(vertices)
    return state.adding(found, trusted=True) if is_accepted(found) else state


def with_best_fit(state: State, pipeline: Pipeline, max_cost: float) -> State:
    """The state with the best fit, if there is one, and the surface that Newton's method reaches from it."""
    from isoembed.aim.best_fit import best_fit
    from isoembed.aim.levels import smooth_start
    from isoembed.aim.smoothing_energy import SmoothingEnergy

    problem, start = pipeline.problem, started(state)
    with pipeline.log.stage("best fit") as recorder:
        near = smooth_start(problem.metric, start, recorder)
        fit = best_fit(
            problem.metric, SmoothingEnergy(problem.metric, near, recorder.work), near, recorder, max_cost
        )
        if fit is None:
            return state
        polished = problem.annealed(fit.vertices, recorder)
    return state.adding(problem.surface(fit.vertices), polished, fit=fit)


def is_unsolved(state: State, pipeline: Pipeline) -> bool:
    """Whether no candidate is accepted."""
    return not is_accepted(smoothest(state.candidates, pipeline.problem.is_convex, searched=False))


def with_smoother(state: State, surface: Embedding, pipeline: Pipeline) -> State:
    """The state with realizations near a surface, if its residual is small."""
    from isoembed.aim.nearby_realizations import nearby_realizations

    problem = pipeline.problem
    if not is_near(surface):
        return state
    with pipeline.log.stage("neighbors") as recorder:
        neighbors = nearby_realizations(
            problem.system,
            surface.vertices,
            problem.metric.lengths,
            recorder,
            residual_tolerance=REALIZED,
        )
    return state.adding(*map(problem.surface, neighbors), searched=True)


STRATEGIES = (
    NoConvexSurface(),
    FitWithinErrors(),
    NearReferenceSurface(),
    NewtonOnRadii(),
    NearestPolytope(),
    NewtonFromPolytope(),
    NearestPolyhedron(),
    NewtonOnLengths(),
    PlanarPolygons(),
    FitOfNoise(),
    PatchReflections(),
    GuidedPath(),
    LocalSearch(),
    BestFitting(),
    VertexReflections(),
)
