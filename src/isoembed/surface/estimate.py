"""Values with an error estimate."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, inf, isfinite, log10

MOST = 15  # digits of a double


@dataclass(frozen=True)
class Estimate:
    """Number with its uncertainty, in the same unit; ``float`` returns the number."""

    value: float
    error: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "value", float(self.value))
        object.__setattr__(self, "error", float(self.error))

    def __str__(self) -> str:
        return f"{self.rounded} {self.plus_minus}"

    @property
    def rounded(self) -> str:
        """Value with one digit more than the error determines, including trailing zeros."""
        if not 0.0 < self.error < inf:
            return f"{self.value:.{MOST}g}"
        return f"{self.value:#.{self.digits}g}".replace(".e", "e").rstrip(".") if self.value else "0"

    @property
    def plus_minus(self) -> str:
        """Error with its sign, "+- 3e-02"."""
        return f"+- {self.error:.0e}" if self.error else "+- 0"

    @property
    def digits(self) -> int:
        """Number of digits of `rounded`."""
        if not (isfinite(self.value) and self.value and 0.0 < self.error < inf):
            return MOST
        significant = log10(abs(self.value)) - log10(self.error)
        return min(max(ceil(min(significant, MOST)) + 1, 1), MOST)

    def __float__(self) -> float:
        return self.value

    def __add__(self, other: Estimate) -> Estimate:
        return Estimate(self.value + other.value, self.error + other.error)

    def __sub__(self, other: Estimate) -> Estimate:
        return Estimate(self.value - other.value, self.error + other.error)

    def scaled(self, factor: float) -> Estimate:
        """Product with an exact factor."""
        return Estimate(factor * self.value, abs(factor) * self.error)


def percent(fraction: float, digits: int = 2) -> str:
    """Fraction in percent with the given number of digits, without an exponent unless it is tiny: "110 %"."""
    return f"{float(f'{100.0 * fraction:.{digits}g}'):.15g} %"
