"""Estimate of the remaining time."""

from collections.abc import Callable, Mapping


class TimeLeft:
    """Estimate of the seconds left, from the weights of the stages and the time that they took so far.

    A stage that says which share of it is done goes on at its own pace, the more so the more is done, and
    until then, like those that do not say and those to come, at the pace of what is behind it.

    Parameters
    ----------
    clock : callable
        The time in seconds.
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._weights: dict[str, float] = {}
        self._pending: list[str] = []
        self._worked = self._seconds = 0.0  # of the stages that have ended: weight, time
        self._running = ""
        self._begun = self._reported = clock()
        self._done = 0.0

    def expect(self, weights: Mapping[str, float]) -> None:
        """Expect these stages next, in this order, and after them what was expected already.

        Parameters
        ----------
        weights : mapping of str to float
            Stage by stage its cost, in a unit that is the same in every call.  The running stage may be
            among them; a name that was there before changes its weight and its place.
        """
        self._weights.update(weights)
        coming = [name for name in weights if name != self._running]
        self._pending = coming + [name for name in self._pending if name not in weights]

    def begin(self, stage: str) -> None:
        """Begin a stage: those that were expected before it will not come."""
        if stage in self._pending:
            self._pending = self._pending[self._pending.index(stage) + 1 :]
        self._running, self._done = stage, 0.0
        self._begun = self._reported = self._clock()

    def reach(self, done: float) -> None:
        """Set the share of the running stage that is done."""
        self._done, self._reported = min(max(done, 0.0), 1.0), self._clock()

    def end(self) -> None:
        """End the running stage.  If it said what it had done, it did no more: it may have been given up."""
        if self._done == 0.0:
            self.reach(1.0)
        self._worked += self._done * self._weight
        self._seconds += self._reported - self._begun if self._weight else 0.0
        self._running = ""

    @property
    def remaining(self) -> float | None:
        """Seconds left; None as long as next to nothing is done, and in a stage that was not expected."""
        ahead = sum(self._weights[name] for name in self._pending)
        own = self._reported - self._begun
        worked = self._worked + self._done * self._weight
        # too little is done for an estimate
        if not self._weight or not worked > 0.03 * (self._worked + self._weight + ahead):
            return None
        pace = (self._seconds + own) / worked
        rest = (1 - self._done) * (own + (1 - self._done) * self._weight * pace)
        return max(rest - (self._clock() - self._reported), 0.0) + ahead * pace

    @property
    def _weight(self) -> float:
        """Weight of the running stage."""
        return self._weights.get(self._running, 0.0)
