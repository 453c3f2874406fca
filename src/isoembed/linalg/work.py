"""Computational work, counted in sparse factorizations, and budgets that limit it."""

from dataclasses import dataclass, field


@dataclass
class Work:
    """Count of the work that a computation has done.

    Attributes
    ----------
    factorizations : int
        Sparse factorizations.  What is done again to go on from a checkpoint counts once, so that an
        interruption changes nothing.
    """

    factorizations: int = 0


@dataclass
class Budget:
    """Limit on the work of a search, in factorizations, from when the budget is made.

    Parameters
    ----------
    work : Work
        Of the computation.
    limit : float

    Attributes
    ----------
    shares : float
        Work that is not counted in factorizations, as shares of one, added up.
    """

    work: Work
    limit: float
    shares: float = 0.0
    _begun: int = field(init=False)

    def __post_init__(self) -> None:
        self._begun = self.work.factorizations

    def spend(self, share: float) -> None:
        """Add work that counts as a share of a factorization."""
        self.shares += share

    def close(self) -> None:
        """Count the shares as whole factorizations."""
        self.work.factorizations += round(self.shares)
        self.shares = 0.0

    @property
    def spent(self) -> float:
        """Factorizations, and what counts as shares of one."""
        return self.work.factorizations - self._begun + self.shares

    @property
    def exhausted(self) -> bool:
        """Whether nothing is left."""
        return self.spent >= self.limit

    @property
    def left(self) -> float:
        """Remaining work, at least 0."""
        return max(self.limit - self.spent, 0.0)
