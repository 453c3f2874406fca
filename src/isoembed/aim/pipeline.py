"""Pipeline of strategies and decisions: execution, budgets, checkpoints."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar

from numpy.typing import ArrayLike, NDArray

from isoembed.aim.problem import Problem
from isoembed.arrays import Floats
from isoembed.embedding.embedding import Embedding
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.progress.stages import Log

if TYPE_CHECKING:
    from isoembed.aim.adaptive import Aim
    from isoembed.aim.best_fit import BestFit

FITS = "measured", "fit"
OF_SUSPECTS = "predicted", "alike"  # parts of a fit on wrong lengths
SPENT = "spent"  # factorizations before a strategy
CHOICE = "choice"  # key of the choice among the candidates


@dataclass(frozen=True, eq=False)
class State:
    """Intermediate results between two strategies; all arrays except `body` have the given order of vertices.

    Attributes
    ----------
    candidates : tuple of Embedding
        Surfaces found so far, in order.
    trusted : bool
        Whether a candidate is accepted and on the branch of a convex surface.
    body : ndarray, shape (V,) or (V, 3), or None
        Radii or vertices of a convex body, in the order of the convexification, from which Newton's method on
        the radii starts.
    start : ndarray, shape (V, 3), or None
        The convex surface from which the pull-back starts.
    smooth : ndarray, shape (V, 3), or None
        End of the guided path, before the penalty vanished.
    searched : bool
        Whether the neighborhood of a candidate was searched for other realizations.
    cost : int
        Factorizations up to the end of the pull-back, the unit of the budgets of later searches.
    measured, fit : BestFit or None
        Smooth fits to the lengths, within their errors and with unknown errors.
    answer : Embedding or None
        The final answer, if no further strategy is to run.
    """

    candidates: tuple[Embedding, ...] = ()
    trusted: bool = False
    body: Floats | None = None
    start: Floats | None = None
    smooth: Floats | None = None
    searched: bool = False
    cost: int = 0
    measured: BestFit | None = None
    fit: BestFit | None = None
    answer: Embedding | None = None

    def adding(self, *surfaces: Embedding, **changes: Any) -> State:
        """The state with more candidates and other changes."""
        return replace(self, candidates=(*self.candidates, *surfaces), **changes)

    @property
    def nearest(self) -> Embedding:
        """The candidate with the smallest residual."""
        return min(self.candidates, key=lambda surface: surface.residual)

    def arrays(self) -> dict[str, ArrayLike]:
        """Arrays for a checkpoint: all fields except `answer`."""
        arrays: dict[str, ArrayLike] = {name: getattr(self, name) for name in ("trusted", "searched", "cost")}
        for name in ("body", "start", "smooth"):
            if getattr(self, name) is not None:
                arrays[name] = getattr(self, name)
        for name in FITS:
            fit = getattr(self, name)
            if fit is not None:
                arrays |= {
                    name: fit.vertices,
                    f"{name} numbers": [fit.weight, fit.noise, fit.degrees_of_freedom, fit.scatter],
                }
                arrays |= {
                    f"{name} {part}": found
                    for part in OF_SUSPECTS
                    if (found := getattr(fit, part)) is not None
                }
        return arrays | {f"candidate {k}": surface.vertices for k, surface in enumerate(self.candidates)}

    @classmethod
    def of_arrays(cls, arrays: Mapping[str, NDArray[Any]], problem: Problem) -> State:
        """The inverse of `arrays`."""
        surfaces: dict[str, Any] = {name: arrays.get(name) for name in ("body", "start", "smooth")}
        for name in FITS:
            if name in arrays:
                from isoembed.aim.best_fit import BestFit

                fit = BestFit(arrays[name], *arrays[f"{name} numbers"].tolist())
                parts: dict[str, Any] = {part: arrays.get(f"{name} {part}") for part in OF_SUSPECTS}
                surfaces[name] = replace(fit, **parts)
        count = sum(name.startswith("candidate ") for name in arrays)
        return cls(
            candidates=tuple(problem.placed(arrays[f"candidate {k}"]) for k in range(count)),
            trusted=bool(arrays["trusted"]),
            searched=bool(arrays["searched"]),
            cost=int(arrays["cost"]),
            **surfaces,
        )


INITIAL = State()


class Strategy(ABC):
    """A strategy of the default method: a condition and a transformation of the state.

    Attributes
    ----------
    key : str
        In checkpoints; never changed.
    """

    key: ClassVar[str]

    def applies(self, state: State, pipeline: Pipeline) -> bool:
        """Whether to run the strategy: by default, unless a candidate is trusted."""
        return not state.trusted

    @abstractmethod
    def run(self, state: State, pipeline: Pipeline) -> State:
        """Run the strategy and return the new state."""


class Decision(ABC):
    """A correction to the chosen answer; repeated when a run is resumed after it.

    Attributes
    ----------
    key : str
        In checkpoints; never changed.
    """

    key: ClassVar[str]

    @abstractmethod
    def applies(self, answer: Embedding, state: State, pipeline: Pipeline) -> bool:
        """Whether to apply the decision."""

    @abstractmethod
    def run(self, answer: Embedding, state: State, pipeline: Pipeline) -> Embedding:
        """Apply the decision and return the new answer."""


class Pipeline:
    """One run of the default method.

    Parameters
    ----------
    metric : PolyhedralMetric
        Normalized.
    method : Aim
    tolerance : float
    log : Log
        Listener, checkpoints and work of the run.

    Attributes
    ----------
    problem : Problem
        With the lengths taken as exact.
    checkpoints : Checkpoints
        Written at the start of each strategy or decision, and by these as they proceed.
    work : Work
        Factorizations so far.
    """

    def __init__(self, metric: PolyhedralMetric, method: Aim, tolerance: float, log: Log) -> None:
        self.metric, self.method, self.log = metric, method, log
        self.checkpoints, self.work, self._goal = log.checkpoints, log.work, ""
        self.problem = Problem(metric.exact, tolerance, method.name, self.work)

    def run(
        self,
        strategies: Sequence[Strategy],
        choose: Callable[[State, Pipeline], Embedding],
        decisions: Sequence[Decision],
    ) -> Embedding:
        """Run the strategies, choose a candidate and apply the decisions, or resume from a checkpoint."""
        state = self._resumed({CHOICE} | {each.key for each in strategies} | {each.key for each in decisions})
        for strategy in strategies:
            if self._goal == strategy.key or (not self._goal and strategy.applies(state, self)):
                self._begin(strategy.key, state)
                state = strategy.run(state, self)
            if state.answer is not None:
                return state.answer._with_stages(self.log.stages)
        self._begin(CHOICE, state)
        answer = choose(state, self)
        for decision in decisions:
            if self._goal == decision.key or decision.applies(answer, state, self):
                self._begin(decision.key, state)
                answer = decision.run(answer, state, self)
        return answer._with_stages(self.log.stages)

    # Budgets of searches after a failed pull-back, in factorizations

    def patch_budget(self, state: State) -> float:
        """Remaining budget of the local search and the best fit."""
        effort = min(self.method.effort, 10.0)  # more does not improve them
        return (2 + effort) * state.cost - self.work.factorizations

    def reflection_budget(self, state: State) -> float:
        """Budget of the vertex reflections."""
        return self.method.effort * state.cost

    # Checkpoints

    def _resumed(self, keys: set[str]) -> State:
        """The state to resume from; `_goal` is the key of the strategy or decision to resume, until then."""
        checkpoint = self.checkpoints.resumed
        self._goal = "" if checkpoint is None or checkpoint.key not in keys else checkpoint.key
        if checkpoint is None or not self._goal or not checkpoint.state:
            return INITIAL
        self.work.factorizations = int(checkpoint.state[SPENT])
        return State.of_arrays(checkpoint.state, self.problem)

    def _begin(self, key: str, state: State) -> None:
        """Begin a strategy or decision, with a checkpoint unless it is the first or the resumed one."""
        is_first = state is INITIAL and not self.work.factorizations
        kept = {} if is_first else {**state.arrays(), SPENT: self.work.factorizations}
        self.checkpoints.begin(key, kept)
        if kept and not self._goal:
            self.checkpoints.keep()
        if key == self._goal:
            self._goal = ""
