"""Pipeline of strategies and decisions: runs them, spends the budget, keeps and resumes checkpoints."""

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
SPENT = "spent"  # factorizations before a strategy
CHOICE = "choice"  # key of the choice among the candidates


@dataclass(frozen=True, eq=False)
class State:
    """Intermediate results between two strategies; all arrays but `body` have the given order of vertices.

    Attributes
    ----------
    candidates : tuple of Embedding
        Surfaces that were found, in order.
    trusted : bool
        Whether one of them is accepted, and on the branch of a convex surface.
    body : ndarray, shape (V,) or (V, 3), or None
        Radii or vertices of a convex body, in the order of the convexification, from which Newton's method on
        the radii starts.
    start : ndarray, shape (V, 3), or None
        The convex surface from which the pull-back starts.
    smooth : ndarray, shape (V, 3), or None
        End of the guided path, before the penalty vanished.
    searched : bool
        Whether other realizations were sought near a candidate.
    cost : int
        Factorizations until the end of the pull-back, by which those of a search after it are measured.
    measured, fit : BestFit or None
        The smooth surface within the errors of the lengths, and the nearest one if their errors are unknown.
    answer : Embedding or None
        The answer, where nothing else is to be tried.
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
        """The state with more candidates, and other changes."""
        return replace(self, candidates=(*self.candidates, *surfaces), **changes)

    @property
    def nearest(self) -> Embedding:
        """The candidate with the smallest residual."""
        return min(self.candidates, key=lambda surface: surface.residual)

    def arrays(self) -> dict[str, ArrayLike]:
        """Arrays for a checkpoint: all fields except `answer`."""
        kept: dict[str, ArrayLike] = {name: getattr(self, name) for name in ("trusted", "searched", "cost")}
        for name in ("body", "start", "smooth"):
            if getattr(self, name) is not None:
                kept[name] = getattr(self, name)
        for name in FITS:
            fit = getattr(self, name)
            if fit is not None:
                kept |= {
                    name: fit.vertices,
                    f"{name} numbers": [fit.weight, fit.noise, fit.score, fit.scatter],
                }
                if fit.predicted is not None:
                    kept[f"{name} predicted"] = fit.predicted
        return kept | {f"candidate {k}": surface.vertices for k, surface in enumerate(self.candidates)}

    @classmethod
    def of_arrays(cls, kept: Mapping[str, NDArray[Any]], problem: Problem) -> State:
        """The state that `arrays` gave."""
        known: dict[str, Any] = {name: kept.get(name) for name in ("body", "start", "smooth")}
        for name in FITS:
            if name in kept:
                from isoembed.aim.best_fit import BestFit

                fit = BestFit(kept[name], *kept[f"{name} numbers"].tolist())
                known[name] = replace(fit, predicted=kept.get(f"{name} predicted"))
        count = sum(name.startswith("candidate ") for name in kept)
        return cls(
            candidates=tuple(problem.placed(kept[f"candidate {k}"]) for k in range(count)),
            trusted=bool(kept["trusted"]),
            searched=bool(kept["searched"]),
            cost=int(kept["cost"]),
            **known,
        )


INITIAL = State()


class Strategy(ABC):
    """A strategy of the default method: when it applies, and what it makes of a state.

    Attributes
    ----------
    key : str
        In checkpoints; never changed.
    """

    key: ClassVar[str]

    def applies(self, state: State, pipeline: Pipeline) -> bool:
        """Whether it is to be tried: as a rule, unless a candidate is trusted."""
        return not state.trusted

    @abstractmethod
    def run(self, state: State, pipeline: Pipeline) -> State:
        """Run the strategy and return the new state."""


class Decision(ABC):
    """A decision on the answer that was chosen; repeated where a run goes on behind it.

    Attributes
    ----------
    key : str
        In checkpoints; never changed.
    """

    key: ClassVar[str]

    @abstractmethod
    def applies(self, answer: Embedding, state: State, pipeline: Pipeline) -> bool:
        """Whether it is to be taken."""

    @abstractmethod
    def run(self, answer: Embedding, state: State, pipeline: Pipeline) -> Embedding:
        """Take the decision and return the answer from then on."""


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
        With the lengths as if exact.
    checkpoints : Checkpoints
        Kept when a strategy or decision begins, and by these as they go.
    work : Work
        Factorizations so far.
    """

    def __init__(self, metric: PolyhedralMetric, method: Aim, tolerance: float, log: Log) -> None:
        self.metric, self.method, self.log = metric, method, log
        self.checkpoints, self.work, self._goal = log.checkpoints, log.work, ""
        exact = metric if metric.length_errors is None else metric.with_length_errors(0.0)
        self.problem = Problem(exact, tolerance, method.name, self.work)

    def run(
        self,
        strategies: Sequence[Strategy],
        choose: Callable[[State, Pipeline], Embedding],
        decisions: Sequence[Decision],
    ) -> Embedding:
        """Try strategies in turn, choose among the candidates, decide; or go on from a checkpoint."""
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

    # Budgets: factorizations that a failure may cost, by those of the pull-back

    def patch_budget(self, state: State) -> float:
        """Budget left for patches and the best fit, in factorizations."""
        effort = min(self.method.effort, 10.0)  # more does not make them better
        return (2 + effort) * state.cost - self.work.factorizations

    def reflection_budget(self, state: State) -> float:
        """Budget of the vertex reflections, in factorizations."""
        return self.method.effort * state.cost

    # Checkpoints

    def _resumed(self, keys: set[str]) -> State:
        """The state to go on from; `_goal` is the key of what goes on, until it does."""
        kept = self.checkpoints.resumed
        self._goal = "" if kept is None or kept.key not in keys else kept.key
        if kept is None or not self._goal or not kept.state:
            return INITIAL
        self.work.factorizations = int(kept.state[SPENT])
        return State.of_arrays(kept.state, self.problem)

    def _begin(self, key: str, state: State) -> None:
        """Begin a strategy or decision: a checkpoint, unless it is the first, or the run goes on from it."""
        is_first = state is INITIAL and not self.work.factorizations
        known = {} if is_first else {**state.arrays(), SPENT: self.work.factorizations}
        self.checkpoints.begin(key, known)
        if known and not self._goal:
            self.checkpoints.keep()
        if key == self._goal:
            self._goal = ""
