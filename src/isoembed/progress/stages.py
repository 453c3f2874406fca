"""Stages of a computation: their costs, and snapshots for a listener.

Stages are passive.  Factorizations, which determine the budgets, are counted by the solvers
(`isoembed.linalg.work`); no decision of a computation depends on stages or their names.
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
        Name of the stage in the method's description.
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
        Running stage.
    iteration : int
        Current iteration of the stage.
    t : float or None
        Position on the path of metrics: 1 is the uniform metric, 0 the given one.
    residual : float or None
        Current largest ``| |x_a - x_b| - l_ab |`` over the mean edge length, or the stage's own residual.
    inverted, partially_inverted : int or None
        Number of vertices of that kind.
    seconds : float
        Seconds since the start of the computation.
    level : str or None
        Current problem size, such as ``"40,000 vertices"``.
    remaining : float or None
        Estimated remaining seconds; None if there is no estimate.
    vertices : ndarray, shape (V, 3), or None
        Current surface in the unit of ``metric.normalized``, in any position; None in most snapshots, which
        belong to undecided trials.
    checkpoint : Checkpoint or None
        Checkpoint to resume from, to be kept in memory or written by `isoembed.io.write_checkpoint`.  None
        if there is none yet.
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

    The code of a stage counts its iterations here and calls `show` and `keep`.  Solvers created with its
    `work` count their factorizations; code that factors by other means adds them here.
    """

    name: str
    log: Log
    iterations: int = 0
    _begun: int = field(init=False)  # factorizations of the computation before the stage
    _last: dict[str, Any] = field(
        default_factory=lambda: dict.fromkeys(("t", "residual", "inverted", "partially_inverted", "level"))
    )

    def __post_init__(self) -> None:
        self._begun = self.work.factorizations

    @property
    def work(self) -> Work:
        """Work of the computation, which determines budgets."""
        return self.log.work

    @property
    def factorizations(self) -> int:
        """Sparse factorizations of the stage; setting them changes the work of the computation."""
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
        """Send a snapshot to the listener, if there is one; omitted values are unchanged.

        Parameters
        ----------
        t, residual, inverted, partially_inverted, level : optional
            See `Progress`.
        done : float, optional
            Completed fraction of the stage's work.
        vertices : ndarray, shape (V, 3), optional
            See `Progress`.  Vertices are not copied, so they must not be modified; they are sent once.
        """
        values = (t, residual, inverted, partially_inverted, level)
        self._last |= {key: value for key, value in zip(self._last, values, strict=True) if value is not None}
        log = self.log
        if done is not None:
            log.time_left.reach(done)
        if log.listener is not None:
            seconds, remaining = log.clock() - log.start, log.time_left.remaining
            now = {**self._last, "seconds": seconds, "remaining": remaining, "vertices": vertices}
            log.listener(Progress(self.name, self.iterations, **now, checkpoint=log.checkpoints.last))

    def keep(self, **arrays: ArrayLike) -> None:
        """Keep a checkpoint of the running strategy; see `Checkpoints.keep`."""
        self.log.checkpoints.keep(**arrays)


@dataclass
class Log:
    """Record of the stages of one computation, which sends snapshots to a listener.

    Parameters
    ----------
    listener : callable, optional
        Receives a `Progress` at every iteration.
    checkpoints : Checkpoints, optional
        Checkpoints and work of the computation.
    clock : callable
        Time in seconds; by default `time.perf_counter`.

    Attributes
    ----------
    start : float
        Start time.
    time_left : TimeLeft
        Estimate of the remaining time.
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
        """Announce the next stages and their costs; see `TimeLeft.expect`."""
        self.time_left.expect(weights)

    @contextmanager
    def stage(self, name: str) -> Iterator[StageRecorder]:
        """Open a stage; its costs are recorded when it closes, even after an exception."""
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
        """Closed stages, in order."""
        return tuple(self._stages)
