"""AIM as the paper prints it: uniformization, uniform surface embedding, guided adiabatic pull-back."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import ClassVar, Literal, get_args

import numpy as np

from isoembed.aim.adiabatic_pullback import pull_back
from isoembed.aim.anneal import Annealed, anneal, anneal_damped, anneal_on_sphere
from isoembed.aim.convexity import PRINTED, crumpled_vertices, reflect_and_anneal, reflected
from isoembed.aim.embedding_tree import EmbeddingTree, embedding_tree
from isoembed.aim.paths import path_factors, path_times
from isoembed.aim.uniformize import Uniformization, newton_uniformization, ricci_flow
from isoembed.arrays import Floats
from isoembed.embedding.embedding import Embedding
from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.method import Method
from isoembed.metric.conformal import rescaled
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.progress.stages import Log, StageRecorder
from isoembed.surface.placement import standard_position
from isoembed.surface.rigidity import LengthSystem
from isoembed.surface.vertex_system import VertexSystem

MOST_STEPS = 100_000

Flow = Literal["newton", "BDF", "Radau", "RK45", "RK23", "DOP853", "LSODA"]
PathName = Literal["linear", "exponential", "flow"]
Convexity = Literal["corrected", "printed", "none"]


@dataclass(frozen=True)
class Paper(Method):
    """AIM step by step, with the paper's parameters.

    The residual tolerance is that of `isoembed.embed`; the paper's is 1e-6.  All lengths are in units of the
    mean edge length.

    Parameters
    ----------
    flow : {"newton", "BDF", "Radau", "RK45", "RK23", "DOP853", "LSODA"}
        Solver for the fixed point of Eq. (ricci): Newton's method, or a SciPy integrator for the ordinary
        differential equation.
    epsilon : float
        The metric counts as uniform when the root mean square of ``k_a / kbar - 1`` is below this.
    t_f : float
        Longest time of the flow, in units of 1 / kbar.
    path : {"linear", "exponential", "flow"}
        Conformal factors along the pull-back.  ``"flow"`` needs the history of an integrator.
    alpha : float
        Rate of the exponential path.
    Tsteps : int
        Steps of the pull-back.
    root : int
        First face of the embedding tree.
    sphere : bool
        Whether anneal A begins on the sphere, with a fit of lengths and radius before Eq. (fmin) is
        minimized.  Without it, as printed, inconsistencies of the tree leave crumples on many meshes.
    convexity : {"corrected", "printed", "none"}
        The convexity routine with v - 2 v_diff, which reflects inverted vertices outward and is kept only if
        it helps; with the paper's v + 2 v_diff, applied always, for comparison; or none.
    step_tolerance : float
        Annealing stops when no vertex moves by more than this.
    max_iterations : int
        Largest number of Newton steps of one annealing.

    Examples
    --------
    The paper's non-smooth embeddings result from a single pull-back step without the convexity routine:

    >>> Paper(Tsteps=1, convexity="none").Tsteps
    1
    """

    flow: Flow = "newton"
    epsilon: float = 1e-6
    t_f: float = 1e4
    path: PathName = "linear"
    alpha: float = 0.1
    Tsteps: int = 10
    root: int = 0
    sphere: bool = True
    convexity: Convexity = "corrected"
    step_tolerance: float = 1e-8
    max_iterations: int = 50

    name: ClassVar[str] = "paper"
    shows_path: ClassVar[bool] = True

    def __post_init__(self) -> None:
        for parameter, choices in (("flow", Flow), ("path", PathName), ("convexity", Convexity)):
            value = getattr(self, parameter)
            if value not in get_args(choices):
                raise InvalidParameter(f"{parameter} is {value!r}, not one of {', '.join(get_args(choices))}")
        for parameter in ("Tsteps", "root", "max_iterations"):
            if not isinstance(getattr(self, parameter), int):
                raise InvalidParameter(f"{parameter} is {getattr(self, parameter)!r}, not a whole number")
        if not isinstance(self.sphere, bool):
            raise InvalidParameter(f"sphere is {self.sphere!r}, not True or False")
        for parameter in ("epsilon", "t_f", "alpha", "Tsteps", "max_iterations"):
            if not getattr(self, parameter) > 0:
                raise InvalidParameter(f"{parameter} is {getattr(self, parameter)}, not positive")
        for parameter in ("root", "step_tolerance"):
            if not getattr(self, parameter) >= 0:
                raise InvalidParameter(f"{parameter} is {getattr(self, parameter)}, which is negative")
        if self.Tsteps > MOST_STEPS:
            raise InvalidParameter(f"Tsteps is {self.Tsteps}, more than {MOST_STEPS}")
        if self.path == "flow" and self.flow == "newton":
            raise InvalidParameter(
                "path is 'flow', but flow is 'newton', which has no history: name an integrator"
            )
        path_times(self.path, self.Tsteps, self.alpha)

    def run(self, metric: PolyhedralMetric, tolerance: float, log: Log) -> Embedding:
        """Embed the metric; a result beyond the tolerance names the step that failed."""
        failure = ""
        with log.stage("uniformize") as recorder:  # 2.1
            uniform = self.uniformize(metric, recorder)
            if not uniform.converged:
                failure = (
                    f"the curvature did not become uniform (k / kbar is off 1 by {uniform.deviation:.1e})"
                )
        with log.stage("embedding tree") as recorder:  # 2.2
            vertices = self.embed_on_sphere(uniform, recorder).vertices
            recorder.show(t=1.0, vertices=vertices)
        system = LengthSystem(metric.triangulation, work=log.work)
        with log.stage("anneal A") as recorder:
            if self.sphere:
                vertices = self.anneal_on_sphere(uniform, vertices, recorder)
            annealed = self.anneal(system, vertices, uniform.metric.lengths, tolerance, recorder)
            self._show(system, annealed, 1.0, recorder)
        with log.stage("convexity and anneal B") as recorder:
            annealed = self.make_convex(system, annealed, uniform.metric.lengths, tolerance, recorder)
            self._show(system, annealed, 1.0, recorder)
            if not annealed.converged:
                failure = (
                    failure or f"the uniform surface could not be annealed (residual {annealed.residual:.1e})"
                )
        with log.stage("pull back") as recorder:  # 2.3

            def relax(guess: Floats, t: float) -> Annealed:
                try:
                    lengths = self.on_path(metric, uniform, t).lengths
                except InvalidMetric:  # lengths between two metrics need not be one
                    return Annealed(guess, np.inf, False)
                reached = self.anneal(system, guess, lengths, tolerance, recorder)
                return self.make_convex(system, reached, lengths, tolerance, recorder)

            way = self.pull_back(annealed.vertices, relax)
            for t, annealed in way:
                self._show(system, annealed, t, recorder)
                if not annealed.converged:
                    failure = failure or f"the pull-back lost the surface at t = {t:.3g} t_f"
        vertices = standard_position(metric.faces, annealed.vertices)
        embedding = Embedding(metric, vertices, method=self.name, tolerance=tolerance, stages=log.stages)
        if embedding.converged or not failure:
            return embedding
        return embedding._with_message(f"{embedding.message}; {failure}")

    def uniformize(self, metric: PolyhedralMetric, recorder: StageRecorder) -> Uniformization:
        """Section 2.1: conformal factors to the uniform metric."""
        if self.flow == "newton":
            return newton_uniformization(metric, recorder, epsilon=self.epsilon)
        return ricci_flow(metric, recorder, integrator=self.flow, epsilon=self.epsilon, t_f=self.t_f)

    def embed_on_sphere(self, uniform: Uniformization, recorder: StageRecorder) -> EmbeddingTree:
        """Section 2.2: the embedding tree, which places the uniform metric on a sphere."""
        return embedding_tree(uniform.metric, uniform.radius, self.root, recorder)

    def anneal_on_sphere(self, uniform: Uniformization, vertices: Floats, recorder: StageRecorder) -> Floats:
        """The vertices (V, 3) of the tree, fitted to the uniform lengths and the radius in least squares."""
        return anneal_on_sphere(
            VertexSystem(uniform.metric.triangulation, work=recorder.work),
            vertices,
            uniform.metric.lengths,
            uniform.radius,
            recorder,
            max_iterations=self.max_iterations,
        )

    def anneal(
        self,
        system: LengthSystem,
        vertices: Floats,
        lengths: Floats,
        tolerance: float,
        recorder: StageRecorder,
    ) -> Annealed:
        """Anneal A, anneal B and the corrector of GAP: Newton's method, damped if it does not converge."""
        annealed = anneal(
            system,
            vertices,
            lengths,
            recorder,
            residual_tolerance=tolerance,
            step_tolerance=self.step_tolerance,
            max_iterations=self.max_iterations,
        )
        if annealed.converged:
            return annealed
        return anneal_damped(
            system,
            vertices,
            lengths,
            recorder,
            residual_tolerance=tolerance,
            max_iterations=self.max_iterations,
        )

    def make_convex(
        self,
        system: LengthSystem,
        annealed: Annealed,
        lengths: Floats,
        tolerance: float,
        recorder: StageRecorder,
    ) -> Annealed:
        """The convexity routine and the annealing after it."""

        def relax(vertices: Floats) -> Annealed:
            return self.anneal(system, vertices, lengths, tolerance, recorder)

        if self.convexity == "none":
            return annealed
        if self.convexity == "corrected":
            return reflect_and_anneal(system.triangulation, annealed, relax)
        inverted, partial = crumpled_vertices(system.triangulation, annealed.vertices)
        if not (inverted | partial).any():
            return annealed
        return relax(reflected(system.triangulation, annealed.vertices, inverted | partial, PRINTED))

    def on_path(self, metric: PolyhedralMetric, uniform: Uniformization, t: float) -> PolyhedralMetric:
        """Section 2.3: the metric rho_t at the time t / t_f from 1, the uniform metric, to 0, the given one.

        Raises
        ------
        InvalidMetric
            The rescaled lengths violate a triangle inequality.
        """
        return rescaled(metric, path_factors(self.path, uniform, t))

    def pull_back(
        self, start: Floats, relax: Callable[[Floats, float], Annealed]
    ) -> Iterator[tuple[float, Annealed]]:
        """Section 2.3: follow the path from the uniform surface in `Tsteps` steps.

        Parameters
        ----------
        start : ndarray, shape (V, 3)
            The surface at t / t_f = 1.
        relax : callable
            Function of an initial guess (V, 3) and a time that returns the surface annealed to that metric.
            From the fourth step on, the guess is extrapolated from the three previous surfaces.

        Yields
        ------
        float, Annealed
            Each time after the first, with its surface.
        """
        return pull_back(start, path_times(self.path, self.Tsteps, self.alpha), relax)

    def _show(self, system: LengthSystem, annealed: Annealed, t: float, recorder: StageRecorder) -> None:
        inverted, partial = crumpled_vertices(system.triangulation, annealed.vertices)
        recorder.show(
            t=t,
            residual=annealed.residual,
            inverted=int(inverted.sum()),
            partially_inverted=int(partial.sum()),
            vertices=annealed.vertices,
        )
