"""Stages of a computation: their costs, and snapshots for a listener.

They only watch.  The factorizations, by which budgets are measured, are counted by the solvers
(`isoembed.linalg.work`); no decision of a computation depends on stages, least of all on their names.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

from numpy.typing import ArrayLike

from isoembed.arrays import Floats
from isoembed.linalg import Work
from isoembed.progress.checkpoints import Checkpoint, Checkpoints
from isoembed.progress.time_left import TimeLeft


@dataclass(frozen=True)
class Stage:
    """Cost of one stage of a method.

    Attributes
    ----------
    name : str
        What the stage is called in the method's description.
    seconds : float
        Wall-clock time.
    iterations : int
        Iterations of the stage's outer loop (Newton steps, right-hand sides, layers).
    factorizations : int
        Sparse factorizations.
    """

    name: str
    seconds: float
    iterations: int
    factorizations: int


@dataclass(frozen=True, eq=False)
class Progress:
    """Snapshot of a running computation.

    Attributes
    ----------
    stage : str
        The running stage.
    iteration : int
        Its iteration so far.
    t : float or None
        Position on the path of metrics: 1 is the uniform metric, 0 the given one.
    residual : float or None
        Current largest ``| |x_a - x_b| - l_ab |`` over the mean edge length, or the stage's own residual.
    inverted, partially_inverted : int or None
        Vertices of that kind.
    seconds : float
        Since the computation began.
    level : str or None
        What size of problem the stage is working on, such as ``"40,000 vertices"``.
    remaining : float or None
        Seconds left, an estimate; None while there is nothing to go by.
    vertices : ndarray, shape (V, 3), or None
        The surface that the stage has reached, in the unit of ``metric.normalized``, in any position; None in
        snapshots of what is not decided yet, which are most.
    checkpoint : Checkpoint or None
        What another run could go on from: it can be kept in memory, or in a file by
        `isoembed.io.write_checkpoint`.  None as long as there is nothing.
    """

    stage: str
    iteration: int
    t: float | None
    residual: float | None
    inverted: int | None
    partially_inverted: int | None
    seconds: float
    level: str | None = None
    remaining: float | None = None
    vertices: Floats | None = None
    checkpoint: Checkpoint | None = None


Listener = Callable[[Progress], None]


@dataclass
class StageRecorder:
    """Recorder of one running stage, its snapshots and checkpoints.

    A stage's code counts its iterations here, calls `show`, and `keep` with what it could go on from.
    Solvers made with its `work` count their factorizations; code that factors by other means adds them here.
    """

    name: str
    log: Log
    iterations: int = 0
    _begun: int = field(init=False)  # factorizations of the computation when the stage began
    _last: dict[str, Any] = field(
        default_factory=lambda: dict.fromkeys(("t", "residual", "inverted", "partially_inverted", "level"))
    )

    def __post_init__(self) -> None:
        self._begun = self.work.factorizations

    @property
    def work(self) -> Work:
        """Work of the computation, by which budgets are measured."""
        return self.log.work

    @property
    def factorizations(self) -> int:
        """Sparse factorizations of the stage, which are work of the computation."""
        return self.work.factorizations - self._begun

    @factorizations.setter
    def factorizations(self, count: int) -> None:
        self.work.factorizations = self._begun + count

    def show(
        self,
        *,
        t: float | None = None,
        residual: float | None = None,
        inverted: int | None = None,
        partially_inverted: int | None = None,
        level: str | None = None,
        done: float | None = None,
        vertices: Floats | None = None,
    ) -> None:
        """Send a snapshot to the listener, if there is one.  What is not given stays as it was.

        Parameters
        ----------
        t, residual, inverted, partially_inverted, level : optional
            As in `Progress`.
        done : float, optional
            The share of the stage's work that is done, from 0 to 1.
        vertices : ndarray, shape (V, 3), optional
            As in `Progress`.  They are not copied, so they must not change any more, and are sent once.
        """
        given = (t, residual, inverted, partially_inverted, level)
        self._last |= {key: value for key, value in zip(self._last, given, strict=True) if value is not None}
        log = self.log
        if done is not None:
            log.time_left.reach(done)
        if log.listener is not None:
            seconds, remaining = log.clock() - log.start, log.time_left.remaining
            now = {**self._last, "seconds": seconds, "remaining": remaining, "vertices": vertices}
            log.listener(Progress(self.name, self.iterations, **now, checkpoint=log.checkpoints.last))

    def keep(self, **arrays: ArrayLike) -> None:
        """Replace the checkpoint by what the running strategy could go on from; see `Checkpoints.keep`."""
        self.log.checkpoints.keep(**arrays)


@dataclass
class Log:
    """Record of the stages of one computation, which sends snapshots of them to a listener.

    Parameters
    ----------
    listener : callable, optional
        Receives a `Progress` at every iteration.
    checkpoints : Checkpoints, optional
        Of the computation, with its work.
    clock : callable
        The time in seconds; by default it stands still while functions are compiled.

    Attributes
    ----------
    start : float
        When it began.
    time_left : TimeLeft
        Estimate of how long it will still take.
    """

    listener: Listener | None = None
    checkpoints: Checkpoints = field(default_factory=Checkpoints)
    clock: Callable[[], float] = time.perf_counter
    start: float = field(init=False)
    time_left: TimeLeft = field(init=False)
    _stages: list[Stage] = field(init=False, default_factory=list)

    def __post_init__(self) -> None:
        self.start = self.clock()
        self.time_left = TimeLeft(self.clock)

    @property
    def work(self) -> Work:
        """Work of the computation."""
        return self.checkpoints.work

    def expect(self, weights: Mapping[str, float]) -> None:
        """Announce which stages come next and what they cost; see `TimeLeft.expect`."""
        self.time_left.expect(weights)

    @contextmanager
    def stage(self, name: str) -> Iterator[StageRecorder]:
        """Open a stage; its costs are recorded when it closes, also when it fails."""
        recorder, begin = StageRecorder(name, self), self.clock()
        self.time_left.begin(name)
        try:
            recorder.show()
            yield recorder
        finally:
            seconds = self.clock() - begin
            self._stages.append(Stage(name, seconds, recorder.iterations, recorder.factorizations))
            self.time_left.end()

    @property
    def stages(self) -> tuple[Stage, ...]:
        """The closed stages, in order."""
        return tuple(self._stages)
