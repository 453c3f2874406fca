"""What a computation did and is doing: stages with their costs, and snapshots for whoever watches."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Stage:
    """The cost of one stage of a method.

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


@dataclass(frozen=True)
class Progress:
    """A snapshot of a running computation.

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
    """

    stage: str
    iteration: int
    t: float | None
    residual: float | None
    inverted: int | None
    partially_inverted: int | None
    seconds: float


Listener = Callable[[Progress], None]


@dataclass
class Tally:
    """The counters of one running stage.  A stage's code adds to them and calls `show` as it goes."""

    name: str
    log: Log
    iterations: int = 0
    factorizations: int = 0
    _last: dict[str, Any] = field(
        default_factory=lambda: dict.fromkeys(("t", "residual", "inverted", "partially_inverted"))
    )

    def show(
        self,
        *,
        t: float | None = None,
        residual: float | None = None,
        inverted: int | None = None,
        partially_inverted: int | None = None,
    ) -> None:
        """Tell the listener, if there is one, where the stage is.  What is not said stays as it was."""
        said = {"t": t, "residual": residual, "inverted": inverted, "partially_inverted": partially_inverted}
        self._last |= {key: value for key, value in said.items() if value is not None}
        if self.log.listener is not None:
            seconds = time.perf_counter() - self.log.start
            self.log.listener(Progress(self.name, self.iterations, **self._last, seconds=seconds))


@dataclass
class Log:
    """Collects the stages of one computation.

    Parameters
    ----------
    listener : callable, optional
        Receives a `Progress` at every iteration.
    """

    listener: Listener | None = None
    start: float = field(default_factory=time.perf_counter)
    _stages: list[Stage] = field(default_factory=list)

    @contextmanager
    def stage(self, name: str) -> Iterator[Tally]:
        """Open a stage; its costs are recorded when it closes, also when it fails."""
        tally, begin = Tally(name, self), time.perf_counter()
        tally.show()
        try:
            yield tally
        finally:
            seconds = time.perf_counter() - begin
            self._stages.append(Stage(name, seconds, tally.iterations, tally.factorizations))

    @property
    def stages(self) -> tuple[Stage, ...]:
        """The closed stages, in order."""
        return tuple(self._stages)
