"""Values with an error estimate."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, isfinite, log10

MOST = 15  # digits of a double


@dataclass(frozen=True)
class Estimate:
    """Number with its uncertainty, in the same unit."""

    value: float
    error: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "value", float(self.value))
        object.__setattr__(self, "error", float(self.error))

    def __str__(self) -> str:
        return f"{self.rounded} +- {self.error:.0e}"

    @property
    def rounded(self) -> str:
        """The value to one digit more than the error leaves."""
        return f"{self.value:.{self.digits}g}"

    @property
    def digits(self) -> int:
        """How many digits that are."""
        if not (isfinite(self.value) and self.value and self.error > 0.0):
            return MOST
        known = log10(abs(self.value)) - log10(self.error)
        return min(max(ceil(min(known, MOST)) + 1, 1), MOST)

    def __add__(self, other: Estimate) -> Estimate:
        return Estimate(self.value + other.value, self.error + other.error)

    def __sub__(self, other: Estimate) -> Estimate:
        return Estimate(self.value - other.value, self.error + other.error)

    def scaled(self, factor: float) -> Estimate:
        """The number times an exact one."""
        return Estimate(factor * self.value, abs(factor) * self.error)
