"""Smooth surfaces fitted to edge lengths with known standard deviations, and their chi-square test."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.special import chdtri, ndtri

from isoembed.arrays import Floats
from isoembed.embedding.embedding import Embedding

if TYPE_CHECKING:
    from isoembed.proof.certificate import Certificate

SIGNIFICANCE = 1e-3
"""Significance level of each test: the true lengths of all edges fail it once in a thousand."""
SUSPECTS = 3
"""Edges that the message of a failure names at most: a blunder is as a rule the first, or beside it."""


def outlier_limit(count: int) -> float:
    """Limit that the largest of so many normal errors exceeds once in a thousand, in standard deviations."""
    return float(-ndtri(SIGNIFICANCE / 2 / count))


@dataclass(frozen=True, eq=False, repr=False)
class MeasuredSurface(Embedding):
    """Smooth surface fitted to edge lengths with known standard deviations.

    It has converged if its residuals pass two tests: as a whole, `chi_square` is at most `chi_square_limit`,
    and no single one stands out (Baarda's test).  That says that its lengths agree with those given, not that
    no other surface does.  As the fit follows the errors in part, true lengths fail less often than stated.
    Deviations include what the quantities change, to first order, if all lengths are met.

    Parameters
    ----------
    metric, vertices, method, tolerance, stages
        As of an `Embedding`; the metric has `length_errors`.
    weight : float
        Of the roughness against the squares of the residuals, in squared mean edge lengths; 0 if the lengths
        are met exactly.

    References
    ----------
    Baarda, A testing procedure for use in geodetic networks, Netherlands Geodetic Commission 2/5 (1968).
    """

    _: KW_ONLY
    weight: float

    def __post_init__(self) -> None:
        if self.length_errors is None:
            self._set(length_errors=self.metric.length_errors)
        super().__post_init__()

    @property
    def _missed(self) -> Floats:
        """Parts of the lengths that the fit has smoothed away, by which its quantities may be off."""
        return self.metric.normalized.lengths - self.surface._lengths

    @property
    def _standardized(self) -> Floats:
        """The residuals over their standard deviations, shape (E,)."""
        sigma = np.asarray(self.metric.length_errors, dtype=np.float64) / self.metric.mean_length
        return self.residuals / sigma

    @property
    def chi_square(self) -> float:
        """Sum of the squared residuals over their variances."""
        return float(np.sum(self._standardized**2))

    @property
    def chi_square_limit(self) -> float:
        """Limit that chi-square, with a degree of freedom for each edge, exceeds with probability 0.001."""
        return float(chdtri(len(self.residuals), SIGNIFICANCE))

    @property
    def _outlier_limit(self) -> float:
        return outlier_limit(len(self.residuals))

    @property
    def converged(self) -> bool:
        """Whether the lengths, measured on these vertices, agree with those of the metric: by both tests."""
        agree = self.chi_square <= self.chi_square_limit
        return agree and bool(self._standardized.max() <= self._outlier_limit)

    @cached_property
    def _certificate(self) -> Certificate:
        """None: a certificate is of exact lengths."""
        from isoembed.proof.certificate import Certificate

        return Certificate(
            False, "not certified: the surface is fitted to measured lengths, and has none of them exactly"
        )

    @property
    def _suspects(self) -> list[int]:
        """The edges with the largest residuals, the largest first, that a single one should not have."""
        worst = np.argsort(-self._standardized, kind="stable")[:SUSPECTS].tolist()
        return [e for e in worst if self._standardized[e] > self._outlier_limit]

    @property
    def _advice(self) -> str:
        """Advice on lengths to check, if the surface misses some; else empty."""
        suspects = self._suspects
        if not suspects:
            return ""
        changes = 100 * (self.lengths / self.metric.lengths - 1)
        named = ", ".join(f"edge {e} {self.edges[e].tolist()} ({changes[e]:+.2g} %)" for e in suspects)
        others = np.delete(self._standardized, suspects)
        agree = others @ others <= self.chi_square_limit and others.max() <= self._outlier_limit
        return (
            f"check these lengths first, and how much longer they are on the nearest smooth surface: {named}"
            f"{', with which all other lengths agree' if agree else ''}"
        )

    def _sentence(self) -> str:
        off, limit = self._standardized, self._outlier_limit
        e = int(np.argmax(off))
        largest = (
            f"the largest residual is {self.residuals[e]:.1e} of the mean edge length, "
            f"{off[e]:.1f} standard deviations, at edge {e} {self.edges[e].tolist()}"
        )
        test = (
            f"chi-square is {self.chi_square:.4g} for {len(off)} edges, "
            f"{'at most' if self.chi_square <= self.chi_square_limit else 'more than'} "
            f"{self.chi_square_limit:.4g}, and {largest}, "
            f"{'at most' if off[e] <= limit else 'more than'} {limit:.1f} (significance {SIGNIFICANCE:g})"
        )
        if self.converged:
            sigma = np.asarray(self.metric.length_errors) / self.metric.mean_length
            rms = float(np.sqrt(np.mean(sigma**2)))
            return (
                f"the lengths agree with those given within their errors, {rms:.2g} of the mean edge length: "
                f"{test}"
            )
        found = "no smooth surface was found whose lengths agree with those given within their errors"
        remedy = self._advice or "the errors may be larger than stated"
        return f"{found}: on the nearest surface {test}; {remedy}"

    @property
    def _reported(self) -> Mapping[str, Any]:
        """The test that the surface has passed, under ``measured``."""
        found = {
            "chi_square": self.chi_square,
            "chi_square_limit": self.chi_square_limit,
            "largest_standardized_residual": float(self._standardized.max()),
            "largest_standardized_residual_limit": self._outlier_limit,
            "significance": SIGNIFICANCE,
            "weight": self.weight,
        }
        return {"measured": found}
