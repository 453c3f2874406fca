"""The default method: AIM by way of the nearest convex metric.

The paper's three steps, each of them replaced by one that does not fail:

1. uniformize, but only as far as convexity (`isoembed.aim.convexification`);
2. embed where it is easy, which for a convex metric is everywhere: the exact polyhedron of Alexandrov's
   theorem (`isoembed.alexandrov`);
3. pull back: where the given metric is convex or nearly so, Newton's method gets there in one leap, on the
   radii (`isoembed.aim.radii_newton`) or on the lengths; where it does not, step by step, guided by
   smoothness (`isoembed.aim.regularized_continuation`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from isoembed._embed import Method
from isoembed.aim.anneal import anneal
from isoembed.aim.best_fit import best_fit
from isoembed.aim.convexification import NEAR, convexified, is_convex, negative_curvature
from isoembed.aim.diagnosis import diagnosis
from isoembed.aim.nearby_realizations import nearby_realizations
from isoembed.aim.radii_newton import approach, leap
from isoembed.aim.regularized_continuation import Guide, regularized_continuation
from isoembed.alexandrov.method import Alexandrov
from isoembed.errors import InvalidMetric, InvalidParameter, NotEmbedded
from isoembed.linalg import SingularMatrix, chosen_backend
from isoembed.metric.conformal_sphere import conformal_sphere
from isoembed.metric.curvature import area
from isoembed.metric.delaunay import delaunay
from isoembed.metric.glued import GluedMetric
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.progress.stages import Log, StageRecorder
from isoembed.surface.convexity import umbrella_heights
from isoembed.surface.embedding import Embedding
from isoembed.surface.fitted import FittedSurface
from isoembed.surface.measures import edge_lengths, outward
from isoembed.surface.rigidity import LengthSystem, length_residuals

Floats = NDArray[np.float64]

PLACED = 1e-10  # residual asked of the waypoint's polyhedron
SHORTEST = 1e-9  # of a given length: where the start is a poor one, vertices may coincide
EXACT = 1e-11  # mean edge lengths: a start this good is left alone, as where faces are flat steps do harm
ON_THE_WAY = 1e-4  # mean edge lengths: where Newton's method has decided where it goes
POLISHED = 1e-13  # residual asked of the last Newton steps, whatever the tolerance: they are quadratic
CONVERGING = 0.5  # of the residual is left, or less, after each step of a leap
LOST = 0.5  # mean edge lengths: no leap comes back from so large a residual
POLISH = 10  # Newton steps at most
NEARLY = 1e-6  # mean edge lengths: between two neighbors Newton's method may get no further
STRAYED = 0.6  # root mean squares: of the heights above the neighbors, a trusted leap changes none by more
LITTLE = 0.03  # of 4 pi: a metric with less negative curvature may be nearly convex
LANDED = 0.25  # heights on a sphere: a trusted leap in the radii changes none by more
SAME = 1e-7  # mean edge lengths: surfaces as near as this are one


# Seconds that stages take as a rule, 40,000 vertices, for the time left.
LEAP = {"nearest waypoint": 0.5, "polytopes": 1.0, "leap": 0.8}
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
}


@dataclass(frozen=True)
class Aim(Method):
    """The adaptive method.

    Parameters
    ----------
    best_fit : bool
        Whether to return the smooth surface that comes nearest to the lengths, a `FittedSurface`, where none
        is found that has them.
    backend : {"superlu", "cholmod", "pardiso"}, optional
        Who factors the matrices; by default the fastest that is installed.
    """

    best_fit: bool = False
    backend: str | None = None

    name: ClassVar[str] = "aim"

    def __post_init__(self) -> None:
        if not isinstance(self.best_fit, bool):
            raise InvalidParameter(f"best_fit is {self.best_fit!r}, not True or False")
        chosen_backend(self.backend)

    def run(self, metric: PolyhedralMetric, tolerance: float, log: Log) -> Embedding:
        """Embed the metric; the answer may miss the tolerance, and says so.

        Parameters
        ----------
        metric : PolyhedralMetric
        tolerance : float
            Largest residual to count as converged.
        log : Log
            Records the stages.

        Returns
        -------
        Embedding
            The smoothest of the surfaces that were found to have these lengths; if there is none, the nearest
            attempt, with a diagnosis, or the best fit.
        """
        surface = partial(Embedding, metric, method=self.name, tolerance=tolerance)
        given = GluedMetric.of(metric)
        kept = _kept(log)
        if kept is None:
            if negative_curvature(given) < LITTLE:
                vertices = self._leapt(given, log)
                if vertices is not None:
                    embedding = surface(vertices)
                    if embedding.residual <= max(tolerance, EXACT):
                        return embedding.with_stages(log.stages)
            log.expect(PULL_BACK)
            with log.stage("waypoint") as recorder:
                waypoint = convexified(given, recorder, self.backend)
            start = self._embedded(metric, waypoint, log)
        else:
            log.expect(PULL_BACK)
            start = kept["start"]
        system = LengthSystem(metric.triangulation, backend=self.backend)
        surfaces = []
        with log.stage("pull back") as recorder:
            if kept is None:
                recorder.keep(start=start)
            recorder.show(t=1.0, vertices=start)
            vertices, branch_deviation = _leap(system, start, metric.lengths, min(tolerance, EXACT), recorder)
            if vertices is not None:
                recorder.show(t=0.0, vertices=vertices)
        if vertices is not None:
            surfaces.append(surface(vertices))
        if not (surfaces and surfaces[0].converged and (is_convex(given) or branch_deviation < STRAYED)):
            guided = None if kept is None else kept.get("guided")
            if guided is None:
                with log.stage("guided pull back") as recorder:
                    path, guide = _LogLinear(metric, start), Guide(metric, start, self.backend)
                    on_the_way = log.resumed_at("guided pull back")
                    guided = regularized_continuation(guide, start, path.lengths, recorder, on_the_way)
            with log.stage("polish") as recorder:
                recorder.keep(start=start, guided=guided)
                vertices = _polished(system, guided, metric.lengths, recorder)
                recorder.show(vertices=vertices)
            surfaces.append(surface(vertices))
            if surfaces[-1].residual < NEARLY:
                with log.stage("neighbors") as recorder:
                    met = nearby_realizations(
                        system, vertices, metric.lengths, recorder, residual_tolerance=EXACT
                    )
                surfaces += [surface(vertices) for vertices in met]
        embedding, fitted = _chosen(surfaces), None
        if embedding.residual > max(tolerance, EXACT):  # below that, the tolerance is beyond rounding
            with log.stage("best fit") as recorder:
                fit = best_fit(metric, start, recorder, self.backend)
                if fit is not None:  # it is one more start
                    polished = _polished(system, fit.vertices, metric.lengths, recorder)
                    surfaces += [surface(near) for near in (fit.vertices, polished)]
            if fit is not None:
                fitted = FittedSurface(
                    metric,
                    fit.vertices,
                    noise=fit.noise,
                    weight=fit.weight,
                    method=self.name,
                    tolerance=tolerance,
                )
            embedding = _chosen(surfaces)
            if not embedding.converged:
                if self.best_fit and fitted is not None:
                    embedding = fitted
                else:
                    embedding = embedding.with_message(diagnosis(embedding, fitted))
        return embedding.with_stages(log.stages)

    def _leapt(self, given: GluedMetric, log: Log) -> Floats | None:
        """The vertices, if a leap in the radii gets there without straying."""
        log.expect(LEAP)
        kept = log.resumed_at("leap")
        if kept is not None:
            start: Floats | None = kept["start"]
        else:
            with log.stage("nearest waypoint") as recorder:
                waypoint = convexified(given, recorder, self.backend, NEAR)
            start = None if waypoint is None else approach(given, waypoint, log, self.backend)
        landing = None if start is None else leap(given, start, log, self.backend)
        return landing.vertices if landing is not None and landing.branch_deviation < LANDED else None

    def _embedded(self, metric: PolyhedralMetric, waypoint: GluedMetric | None, log: Log) -> Floats:
        """The vertices of the waypoint's polyhedron, or what comes nearest."""
        if waypoint is not None:
            try:
                found = Alexandrov(backend=self.backend).run(waypoint.normalized, PLACED, log)
                return waypoint.unit * found.vertices
            except NotEmbedded as failure:
                return waypoint.unit * failure.embedding.vertices[: metric.triangulation.n_vertices]
            except InvalidMetric:  # so thin that fewer than three vertices have a deficit beyond rounding
                pass
        with log.stage("sphere") as recorder:
            x = outward(metric.faces, conformal_sphere(delaunay(metric), recorder, self.backend).points)
            return x * np.sqrt(area(metric) / area(PolyhedralMetric.from_mesh(x, metric.faces)))


def _kept(log: Log) -> Mapping[str, NDArray[Any]] | None:
    """What an interrupted run kept in the pull-back, if it came that far: ``start`` is always among it."""
    stages = ("pull back", "guided pull back", "polish")
    return next((kept for stage in stages if (kept := log.resumed_at(stage)) is not None), None)


class _LogLinear:
    """The metrics ``l(t) = l(0)^{1-t} l(1)^t`` from an embedded one at t = 1 to the given one at t = 0.

    Linear in the conformal factors u, as the paper's path, as far as the edges are straight.
    """

    def __init__(self, metric: PolyhedralMetric, start: Floats) -> None:
        self._given = metric.lengths
        self._ratio = np.maximum(edge_lengths(metric.edges, start) / metric.lengths, SHORTEST)

    def lengths(self, t: float) -> Floats:
        return self._given * self._ratio**t


def _leap(
    system: LengthSystem, start: Floats, lengths: Floats, good: float, recorder: StageRecorder
) -> tuple[Floats | None, float]:
    """Newton's method while it converges; and by how much it strayed from where its first step pointed.

    It can cross over to a neighboring realization, with some vertices turned inside out, that has the same
    lengths.  Then a height above the neighbors changes by more than the first step's error explains.
    """
    triangulation = system.triangulation
    r = length_residuals(triangulation, start, lengths)
    residual = float(np.abs(r).max())
    if residual <= good:
        return start, 0.0
    x, pointed, before = start, start, np.inf
    while residual > ON_THE_WAY or x is start:
        recorder.iterations += 1
        recorder.factorizations += 1
        try:
            x = x - system.step(x, lengths, r)
        except SingularMatrix:
            return None, np.inf
        if not np.isfinite(x).all():
            return None, np.inf
        pointed = x if pointed is start else pointed
        r = length_residuals(triangulation, x, lengths)
        residual = float(np.abs(r).max())
        recorder.show(residual=residual)
        if not residual < CONVERGING * before or residual > LOST:
            return None, np.inf
        before = residual
    expected, heights = (umbrella_heights(triangulation, y) for y in (pointed, x))
    branch_deviation = float(np.abs(heights - expected).max() / np.sqrt(np.mean(heights**2)))
    return _polished(system, x, lengths, recorder), branch_deviation


def _polished(system: LengthSystem, vertices: Floats, lengths: Floats, recorder: StageRecorder) -> Floats:
    """Newton's method to the rounding floor."""
    return anneal(
        system, vertices, lengths, recorder, residual_tolerance=POLISHED, max_iterations=POLISH
    ).vertices


def _chosen(surfaces: list[Embedding]) -> Embedding:
    """The smoothest of the realizations, with the others beside it; if there is none, the nearest attempt."""
    different: list[Embedding] = []
    for surface in surfaces:
        realized = surface.converged and surface.residual < NEARLY  # whatever the tolerance
        if realized and all(surface.distance(other) > SAME for other in different):
            different.append(surface)
    if not different:
        return min(surfaces, key=lambda surface: surface.residual)
    if len(different) > 1:
        different.sort(key=lambda surface: surface.fine_roughness)
    return different[0].with_others(different[1:])
