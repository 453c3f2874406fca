"""What the adaptive method tries where metrics are not convex, or not realized at once; and what it finds."""

from collections.abc import Mapping
from contextlib import suppress
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from isoembed.aim.accuracy import REALIZED, SAME
from isoembed.aim.anneal import POLISH_STEPS, anneal
from isoembed.aim.best_fit import best_fit
from isoembed.aim.convexification import FAR_MARGIN, NEAR_MARGIN
from isoembed.aim.diagnosis import diagnosis
from isoembed.aim.flipped_vertices import with_flipped_vertices
from isoembed.aim.lengths_newton import LENGTHS_DEVIATION, newton_on_lengths
from isoembed.aim.levels import goes_by_levels, pulled_back_by_levels
from isoembed.aim.local_search import COARSE, local_search, misses_locally
from isoembed.aim.mirrored_patches import mirrored_realizations
from isoembed.aim.nearby_realizations import NEAR, SOFTEST, nearby_realizations, sought
from isoembed.aim.radii_leap import RADII_DEVIATION, newton_on_radii, radii_start
from isoembed.aim.regularized_continuation import Continued, log_linear, regularized_continuation
from isoembed.aim.regularized_energy import RegularizedEnergy
from isoembed.aim.search import AT_ONCE, FIT, NEARLY, PATCH_EFFORT, PLACED, Search
from isoembed.alexandrov.method import convex_polyhedron
from isoembed.arrays import Floats
from isoembed.embedding.embedding import Embedding
from isoembed.embedding.fitted import FittedSurface
from isoembed.errors import InvalidMetric, NotEmbedded
from isoembed.evidence import Evidence
from isoembed.linalg import SingularMatrix
from isoembed.metric.conformal_sphere import conformal_sphere
from isoembed.metric.curvature import area
from isoembed.metric.delaunay import delaunay
from isoembed.metric.dents import dents
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.progress.stages import Log, StageRecorder
from isoembed.surface.measures import outward
from isoembed.surface.rigidity import LengthSystem

# Seconds that stages take as a rule, 40,000 vertices, for the time left.
BY_A_POLYHEDRON = {"nearest waypoint": 0.5, "polytopes": 1.0, "leap": 0.8}
PULL_BACK = {
    "waypoint": 1.0,
    "flat vertices": 0.05,
    "polytope": 1.0,
    "placement": 0.2,
    "edge paths": 0.1,
    "pull back": 2.0,
    "guided pull back": 100.0,
    "polish": 2.0,
    "neighbors": 15.0,
    "mirrored patches": 50.0,
    "local search": 100.0,
}


def _kept(log: Log) -> Mapping[str, NDArray[Any]]:
    """What an interrupted run kept in the pull-back: with ``start``, if it came that far."""
    stages = ("pull back", "guided pull back", "polish")
    return next((kept for stage in stages if (kept := log.resumed_at(stage)) is not None), {})


class Strategies:
    """What the adaptive method tries where the given triangles do not lead to the surface at once.

    Parameters
    ----------
    search : Search

    Attributes
    ----------
    good : float
        Residual of a surface that is taken.
    kept : mapping of str to ndarray
        What an interrupted run kept in the pull-back.
    start : ndarray, shape (V, 3)
        A convex surface near the one that is sought.
    surfaces : list of Embedding
        What was found, in order.
    smooth : ndarray, shape (V, 3), or None
        Where the guided path ended, before what guides was let go.
    sought : bool
        Whether other realizations were sought near one.
    """

    start: Floats

    def __init__(self, search: Search) -> None:
        self.search, self.metric, self.log = search, search.metric, search.log
        self.good = search.good
        self.kept = _kept(search.log)
        self.surfaces: list[Embedding] = []
        self.smooth: Floats | None = None
        self.sought = False

    def surface(self, vertices: Floats) -> Embedding:
        """The surface with these vertices."""
        return self.search.surface(vertices)

    @cached_property
    def system(self) -> LengthSystem:
        """The equations for the lengths."""
        return LengthSystem(self.metric.triangulation, space=self.metric.space)

    @cached_property
    def energy(self) -> RegularizedEnergy:
        """The regularized energy about the start."""
        return RegularizedEnergy(self.metric, self.start)

    def run(self, best_fit: bool, effort: float) -> Embedding:
        """Try one after the other; the parameters are those of `isoembed.Aim`."""
        found = self.leap()
        vars(self.search).pop("analyses", None)  # nobody needs it any more, and large bodies need the room
        if found is not None:
            return found
        self.start = self.convex_start()
        if not self.newton_on_lengths():
            self.continue_regularized()
        embedding = self.smoothest()
        first = self.log.factorizations
        most = (2 + min(effort, PATCH_EFFORT)) * first  # of what was done so far, and what follows
        if embedding.residual > self.good and effort > 0:
            self.turn_patches(most)
            embedding = self.smoothest()
        if embedding.residual > self.good:
            fitted = self.best_fit(np.inf if best_fit else most)
            if effort > 1:
                self.change_sides(effort * first)
            embedding = self.smoothest()
            if not embedding.converged:
                told = embedding._with_message(diagnosis(embedding, fitted, effort))
                embedding = fitted if best_fit and fitted is not None else told
        return embedding

    def leap(self) -> Embedding | None:
        """Realize a metric that is convex or nearly so by a polyhedron; None where that cannot be trusted."""
        search, log = self.search, self.log
        if log.begun not in (None, *AT_ONCE, *BY_A_POLYHEDRON) or not search.is_nearly_convex:
            return None
        convexification, given = search.convexification, search.convexification.given
        log.expect(BY_A_POLYHEDRON)
        kept = log.resumed_at("leap")
        if kept is not None:
            start: Floats | None = kept["start"]
        else:
            with log.stage("nearest waypoint") as recorder:
                convex = convexification.metric(NEAR_MARGIN, recorder)
            start = None if convex is None else radii_start(given, convex, search.analyses, log)
        if start is None:
            return None
        if convexification.is_convex and start.ndim == 2:
            polyhedron = self.polyhedron(self.in_given_order(start))
            if polyhedron is not None:
                return polyhedron
        solution = newton_on_radii(given, start, search.analyses, log, search.numbers)
        if solution is None or not solution.branch_deviation < RADII_DEVIATION:
            return None
        found = self.surface(solution.vertices)
        return found if found.residual <= self.good else None

    def in_given_order(self, vertices: Floats) -> Floats:
        """What the convexification has by its own numbers."""
        return vertices[np.argsort(self.search.numbers)]

    def polyhedron(self, vertices: Floats) -> Embedding | None:
        """The polyhedron of a convex metric, if it has the given triangles, or others of its faces."""
        found = self.surface(vertices)
        if REALIZED < found.residual < NEARLY:
            with self.log.stage("polish") as recorder:
                polished = self.surface(anneal(self.system, vertices, self.metric.lengths, recorder).vertices)
            if not polished.surface.concave_edges.any():
                found = polished
        return found if self.is_exact(found) else None

    def is_exact(self, surface: Embedding) -> bool:
        """Whether a surface is a realization, whatever the tolerance, as far as rounding allows."""
        return surface.residual <= min(self.good, PLACED)

    def convex_start(self) -> Floats:
        """The vertices of the polyhedron of a convex metric, or what comes nearest."""
        self.log.expect(PULL_BACK)
        if self.kept:
            return self.kept["start"]
        with self.log.stage("waypoint") as recorder:
            convex = self.search.convexification.metric(FAR_MARGIN, recorder)
        if convex is not None:
            try:
                found = convex_polyhedron(convex.normalized, PLACED, self.log)
                return self.in_given_order(convex.unit * found.vertices)
            except NotEmbedded as failure:
                nearest = failure.embedding.vertices[: self.search.numbers.size]
                return self.in_given_order(convex.unit * nearest)
            except InvalidMetric:  # so thin that fewer than three vertices have a deficit beyond rounding
                pass
        faces = self.metric.faces
        with self.log.stage("sphere") as recorder:
            x = outward(faces, conformal_sphere(delaunay(self.metric), recorder).points)
            return x * np.sqrt(area(self.metric) / area(PolyhedralMetric.from_mesh(x, faces)))

    def newton_on_lengths(self) -> bool:
        """Go from the start to the lengths at once; return whether what is found can be trusted."""
        with self.log.stage("pull back") as recorder:
            if not self.kept:
                recorder.keep(start=self.start)
            recorder.show(t=1.0, vertices=self.start)
            solution = newton_on_lengths(
                self.system,
                self.start,
                self.metric.lengths,
                min(self.search.tolerance, REALIZED),
                recorder,
            )
            if solution is not None:
                recorder.show(t=0.0, vertices=solution.vertices)
                self.surfaces.append(self.surface(solution.vertices))
        convex = self.search.convexification.is_convex
        if convex and self.is_exact(polyhedron := self.surface(self.start)):
            self.surfaces.append(polyhedron)
            return True
        trusted = solution is not None and (convex or solution.branch_deviation < LENGTHS_DEVIATION)
        return trusted and self.surfaces[-1].converged

    def continue_regularized(self) -> None:
        """Go from the start to the lengths step by step, then to smoother realizations nearby."""
        if self.mirror_patches():
            return
        if "smooth" in self.kept:
            guided = Continued(self.kept["smooth"], self.kept["guided"])
        else:
            with self.log.stage("guided pull back") as recorder:
                guided = self.guided(recorder)
        self.smooth = guided.smooth
        with self.log.stage("polish") as recorder:
            recorder.keep(start=self.start, guided=guided.vertices, smooth=guided.smooth)
            vertices = anneal(self.system, guided.vertices, self.metric.lengths, recorder).vertices
            recorder.show(vertices=vertices)
        self.surfaces.append(self.surface(vertices))
        self.search_nearby(self.surfaces[-1])

    def search_nearby(self, surface: Embedding) -> None:
        """Go to smoother realizations near one."""
        if surface.residual < NEARLY:
            with self.log.stage("neighbors") as recorder:
                met = nearby_realizations(
                    self.system,
                    surface.vertices,
                    self.metric.lengths,
                    recorder,
                    residual_tolerance=REALIZED,
                )
            self.surfaces += [self.surface(vertices) for vertices in met]
            self.sought = True

    def mirror_patches(self) -> bool:
        """Make the dents of the metric, each pushed in or out; return whether a realization is found."""
        if self.kept.keys() - {"start"} or not self.metric.space.is_euclidean:
            return False
        patches = dents(self.metric)
        if not patches:
            return False
        with self.log.stage("mirrored patches") as recorder:
            choices = mirrored_realizations(
                self.metric, self.system, self.energy, self.start, patches, recorder
            )
            found = [self.surface(vertices) for vertices in choices]
        self.surfaces += found
        realized = [surface for surface in found if self.is_exact(surface)]
        if realized:
            self.search_nearby(min(realized, key=lambda surface: surface.surface.fine_roughness))
        return bool(realized)

    def turn_patches(self, most: float) -> None:
        """Turn over what is on the wrong side, leaving the best fit its share of so many factorizations.

        Coarse surfaces are searched from the nearest attempt, others from the smooth end of the path: its
        pits are where they should be, which is more than that lengths are nearly right.  Where lengths are
        missed all over, as those with noise are, there is nothing to turn.
        """
        if not self.metric.space.is_euclidean:
            return
        start = min(self.surfaces, key=lambda surface: surface.residual).vertices
        left = most - self.log.factorizations - FIT
        if self.search.numbers.size > COARSE:
            start = start if self.smooth is None else self.smooth
            if not misses_locally(self.energy, start, self.metric.lengths):
                return
        with self.log.stage("local search") as recorder:
            found = local_search(
                self.energy, self.system, start, self.metric.lengths, recorder, max(left, 0.0)
            )
            recorder.show(vertices=found.end)
            polished = anneal(self.system, found.end, self.metric.lengths, recorder).vertices
        end = self.surface(polished)
        self.surfaces += [end, self.surface(found.nearest)]
        self.search_nearby(end)

    def change_sides(self, most: float) -> None:
        """Reflect what is on the wrong side of the nearest attempt, with so many factorizations."""
        nearest = min(self.surfaces, key=lambda surface: surface.residual)
        if nearest.residual > self.good and self.metric.space.is_euclidean:
            self.log.expect({"changes of sides": 500.0})
            with self.log.stage("changes of sides") as recorder:
                found = with_flipped_vertices(
                    self.energy, self.system, nearest.vertices, self.metric.lengths, recorder, most
                )
            self.surfaces.append(self.surface(found))
            self.search_nearby(self.surfaces[-1])

    def guided(self, recorder: StageRecorder) -> Continued:
        """Where the guided path ends, near enough to the lengths for Newton's method."""
        kept = self.log.resumed_at("guided pull back")
        if goes_by_levels(self.metric, kept):
            with suppress(SingularMatrix, InvalidMetric):  # of the chosen vertices, on needles
                found = pulled_back_by_levels(self.metric, self.system, self.start, recorder, kept)
                if found is not None:
                    return Continued(found, found)
            kept = None
        path = log_linear(self.metric, self.start)
        return regularized_continuation(self.energy, self.start, path, recorder, kept)

    def best_fit(self, most: float) -> FittedSurface | None:
        """The smooth surface that comes nearest to the lengths; it is one more start, too."""
        left = most - self.log.factorizations - POLISH_STEPS
        with self.log.stage("best fit") as recorder:
            fit = best_fit(self.metric, self.energy, self.start, recorder, left)
            if fit is None:
                return None
            polished = anneal(self.system, fit.vertices, self.metric.lengths, recorder).vertices
            self.surfaces += [self.surface(near) for near in (fit.vertices, polished)]
        return FittedSurface(
            self.metric,
            fit.vertices,
            noise=fit.noise,
            weight=fit.weight,
            method=self.search.name,
            tolerance=self.search.tolerance,
        )

    def smoothest(self) -> Embedding:
        """The smoothest of the realizations, with the others beside it; if none, the nearest attempt.

        Of a convex metric the convex one goes before all others.
        """
        different: list[Embedding] = []
        for surface in self.surfaces:
            realized = surface.converged and surface.residual < NEARLY  # whatever the tolerance
            if realized and all(surface.distance(other) > SAME for other in different):
                different.append(surface)
        if not different:
            return min(self.surfaces, key=lambda surface: surface.residual)
        if len(different) > 1:
            convex = self.search.convexification.is_convex
            different.sort(key=lambda s: (convex and s.surface.concave_edges.any(), s.surface.fine_roughness))
        if not self.sought:
            return different[0]._with_others(different[1:])
        said = sought(SOFTEST, NEAR)
        found = different[0]._with_others(different[1:], Evidence("searched", said))
        return found._with_message(f"{found.message}; {said}")
