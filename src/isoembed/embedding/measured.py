"""Smooth surfaces fitted to edge lengths with known standard deviations, and their chi-square test."""

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass
from typing import Any

import numpy as np
from scipy.special import chdtri

from isoembed.embedding.embedding import Embedding

SIGNIFICANCE = 1e-3
"""Of the chi-square test: the true surface fails it at most once in a thousand."""


@dataclass(frozen=True, eq=False, repr=False)
class MeasuredSurface(Embedding):
    """Smooth surface fitted to edge lengths with known standard deviations.

    The residuals are judged as a whole: the surface has converged if `chi_square` is at most
    `chi_square_limit`.  That says that its lengths agree with those given, not that no other surface does.
    Deviations are of first order, and too small by a factor of about two where a vertex is flat within the
    errors.

    Parameters
    ----------
    metric, vertices, method, tolerance, stages
        As of an `Embedding`; the metric has `length_errors`.
    weight : float
        Of the roughness against the squares of the residuals, in squared mean edge lengths; 0 if the lengths
        are met exactly.
    """

    _: KW_ONLY
    weight: float

    def __post_init__(self) -> None:
        if self.length_errors is None:
            self._set(length_errors=self.metric.length_errors)
        super().__post_init__()

    @property
    def chi_square(self) -> float:
        """Sum of the squared residuals over their variances."""
        sigma = np.asarray(self.metric.length_errors, dtype=np.float64) / self.metric.mean_length
        return float(np.sum((self.residuals / sigma) ** 2))

    @property
    def chi_square_limit(self) -> float:
        """What chi-square exceeds with a probability of 0.001, with as many degrees of freedom as edges."""
        return float(chdtri(len(self.residuals), SIGNIFICANCE))

    @property
    def converged(self) -> bool:
        """Whether the lengths, measured on these vertices, agree with those of the metric (chi-square)."""
        return self.chi_square <= self.chi_square_limit

    def _sentence(self) -> str:
        return (
            f"the lengths {'agree' if self.converged else 'do not agree'} with those given within their "
            f"errors: chi-square is {self.chi_square:.4g} for {len(self.residuals)} edges, "
            f"{'at most' if self.converged else 'more than'} {self.chi_square_limit:.4g} "
            f"(significance {SIGNIFICANCE:g}); the largest residual is {self.residual:.1e} of the mean edge "
            "length"
        )

    @property
    def _reported(self) -> Mapping[str, Any]:
        """The test that the surface has passed, under ``measured``."""
        found = {
            "chi_square": self.chi_square,
            "chi_square_limit": self.chi_square_limit,
            "significance": SIGNIFICANCE,
            "weight": self.weight,
        }
        return {"measured": found}
