"""Estimate of the remaining time."""

from collections.abc import Callable, Mapping


class TimeLeft:
    """Estimate of the remaining seconds, from the weights of the stages and the time taken so far.

    A stage that reports its completed fraction is extrapolated at its own pace, with a weight that increases
    with the fraction; all other stages are extrapolated at the pace of the completed work.

    Parameters
    ----------
    clock : callable
        Function that returns the time in seconds.
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._weights: dict[str, float] = {}
        self._pending: list[str] = []
        self._worked = self._seconds = 0.0  # weight and time of completed stages
        self._running = ""
        self._begun = self._reported = clock()
        self._fraction = 0.0

    def expect(self, weights: Mapping[str, float]) -> None:
        """Expect the given stages next, in this order, before those expected already.

        Parameters
        ----------
        weights : mapping of str to float
            Cost of each stage, in the same unit in every call.  The running stage may be included; a repeated
            name changes its weight and position.
        """
        self._weights.update(weights)
        coming = [name for name in weights if name != self._running]
        self._pending = coming + [name for name in self._pending if name not in weights]

    def begin(self, stage: str) -> None:
        """Begin a stage; stages expected before it are skipped."""
        if stage in self._pending:
            self._pending = self._pending[self._pending.index(stage) + 1 :]
        self._running, self._fraction = stage, 0.0
        self._begun = self._reported = self._clock()

    def reach(self, fraction: float) -> None:
        """Set the completed fraction of the running stage."""
        self._fraction, self._reported = min(max(fraction, 0.0), 1.0), self._clock()

    def end(self) -> None:
        """End the running stage; its last reported fraction is final, as it may have been abandoned."""
        if self._fraction == 0.0:
            self.reach(1.0)
        self._worked += self._fraction * self._weight
        self._seconds += self._reported - self._begun if self._weight else 0.0
        self._running = ""

    @property
    def remaining(self) -> float | None:
        """Remaining seconds; None if almost nothing is done, or the stage was not expected."""
        ahead = sum(self._weights[name] for name in self._pending)
        own = self._reported - self._begun
        worked = self._worked + self._fraction * self._weight
        # Too little is done for an estimate.
        if not self._weight or not worked > 0.03 * (self._worked + self._weight + ahead):
            return None
        pace = (self._seconds + own) / worked
        rest = (1 - self._fraction) * (own + (1 - self._fraction) * self._weight * pace)
        return max(rest - (self._clock() - self._reported), 0.0) + ahead * pace

    @property
    def _weight(self) -> float:
        """Weight of the running stage."""
        return self._weights.get(self._running, 0.0)
