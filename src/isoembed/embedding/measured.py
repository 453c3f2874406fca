"""Smooth surfaces fitted to edge lengths with known standard deviations, and their chi-square test."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.special import chdtri

from isoembed.arrays import Floats
from isoembed.embedding.embedding import Embedding

if TYPE_CHECKING:
    from isoembed.proof.certificate import Certificate

SIGNIFICANCE = 1e-3
"""Of the chi-square test: the true surface fails it at most once in a thousand."""
SUSPECTS = 3
"""Edges that the message of a failure names: a blunder is as a rule the first, or beside it."""


@dataclass(frozen=True, eq=False, repr=False)
class MeasuredSurface(Embedding):
    """Smooth surface fitted to edge lengths with known standard deviations.

    The residuals are judged as a whole: the surface has converged if `chi_square` is at most
    `chi_square_limit`.  That says that its lengths agree with those given, not that no other surface does.
    The test is the global model test of adjustments in surveying, and the edge that the message of a failure
    names is the one by which Baarda's data snooping would begin.
    Deviations are of first order, and too small by a factor of about two where a vertex is flat within the
    errors.

    Parameters
    ----------
    metric, vertices, method, tolerance, stages
        As of an `Embedding`; the metric has `length_errors`.
    weight : float
        Of the roughness against the squares of the residuals, in squared mean edge lengths; 0 if the lengths
        are met exactly.
    degrees_of_freedom : float
        Of the residuals: the number of edges, less the trace of the matrix from given to fitted lengths.

    References
    ----------
    Baarda, A testing procedure for use in geodetic networks, Netherlands Geodetic Commission 2/5 (1968).
    """

    _: KW_ONLY
    weight: float
    degrees_of_freedom: float

    def __post_init__(self) -> None:
        if self.length_errors is None:
            self._set(length_errors=self.metric.length_errors)
        super().__post_init__()

    @property
    def chi_square(self) -> float:
        """Sum of the squared residuals over their variances."""
        return float(np.sum(self._standardized**2))

    @property
    def _standardized(self) -> Floats:
        """The residuals over their standard deviations, shape (E,)."""
        sigma = np.asarray(self.metric.length_errors, dtype=np.float64) / self.metric.mean_length
        return self.residuals / sigma

    @property
    def chi_square_limit(self) -> float:
        """What chi-square with these degrees of freedom exceeds with a probability of 0.001."""
        return float(chdtri(self.degrees_of_freedom, SIGNIFICANCE))

    @property
    def converged(self) -> bool:
        """Whether the lengths, measured on these vertices, agree with those of the metric (chi-square)."""
        return self.chi_square <= self.chi_square_limit

    @cached_property
    def _certificate(self) -> Certificate:
        """None: a certificate is of exact lengths."""
        from isoembed.proof.certificate import Certificate

        return Certificate(
            False, "not certified: the surface is fitted to measured lengths, and has none of them exactly"
        )

    def _sentence(self) -> str:
        off = self._standardized
        suspects = np.argsort(-off, kind="stable")[:SUSPECTS].tolist()
        test = (
            f"chi-square is {self.chi_square:.4g} with {self.degrees_of_freedom:.1f} degrees of freedom of "
            f"{len(off)} edges, {'at most' if self.converged else 'more than'} {self.chi_square_limit:.4g} "
            f"(significance {SIGNIFICANCE:g})"
        )
        if self.converged:
            return (
                f"the lengths agree with those given within their errors: {test}; the largest residual is "
                f"{self.residual:.1e} of the mean edge length, {off[suspects[0]]:.1f} standard deviations, "
                f"at edge {suspects[0]} {self.edges[suspects[0]].tolist()}"
            )
        ratios = self.lengths / self.metric.lengths
        named = ", ".join(
            f"edge {e} {self.edges[e].tolist()} (off by {off[e]:.3g} standard deviations, {ratios[e]:.4g} "
            "times as long as given)"
            for e in suspects
        )
        return (
            "no smooth surface was found whose lengths agree with those given within their errors: on the "
            f"nearest, {test}; check first {named}"
        )

    @property
    def _reported(self) -> Mapping[str, Any]:
        """The test that the surface has passed, under ``measured``."""
        found = {
            "chi_square": self.chi_square,
            "chi_square_limit": self.chi_square_limit,
            "degrees_of_freedom": self.degrees_of_freedom,
            "significance": SIGNIFICANCE,
            "weight": self.weight,
        }
        return {"measured": found}
