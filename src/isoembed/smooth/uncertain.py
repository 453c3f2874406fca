"""Functions on the sphere with errors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from isoembed.arrays import Floats


@dataclass(frozen=True)
class Uncertainty:
    """Errors of a function on the sphere of directions, in its unit.

    Attributes
    ----------
    pointwise : float
        Largest error at any point.
    mean : float
        Error of averages over the sphere with smooth weights: noise averages out, smooth errors do not.
    """

    pointwise: float = 0.0
    mean: float = 0.0

    def __add__(self, other: Uncertainty) -> Uncertainty:
        return Uncertainty(self.pointwise + other.pointwise, self.mean + other.mean)


EXACT = Uncertainty()


@dataclass(frozen=True)
class UncertainFunction:
    """Function of the direction with its errors.

    Attributes
    ----------
    values : callable
        Takes unit vectors u (n, 3) and returns (n,), or (n, 3) for tangent vectors.
    error : Uncertainty
    """

    values: Callable[[Floats], Floats]
    error: Uncertainty

    def __call__(self, u: Floats) -> Floats:
        """Values at unit vectors u (n, 3)."""
        return self.values(u)
