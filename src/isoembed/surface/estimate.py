"""Numbers with an estimate of their error."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Estimate:
    """Number with its uncertainty, in the same unit."""

    value: float
    error: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "value", float(self.value))
        object.__setattr__(self, "error", float(self.error))

    def __str__(self) -> str:
        return f"{self.value:.15g} +- {self.error:.0e}"

    def __add__(self, other: Estimate) -> Estimate:
        return Estimate(self.value + other.value, self.error + other.error)

    def __sub__(self, other: Estimate) -> Estimate:
        return Estimate(self.value - other.value, self.error + other.error)

    def scaled(self, factor: float) -> Estimate:
        """The number times an exact one."""
        return Estimate(factor * self.value, abs(factor) * self.error)
