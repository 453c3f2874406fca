"""Smooth surfaces fitted to edge lengths with known standard deviations: chi-square test, outliers."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from scipy.special import chdtri, ndtri

from isoembed.arrays import Floats, Indices
from isoembed.embedding.embedding import Embedding
from isoembed.mesh.triangulation import frozen
from isoembed.metric.precision import Precision, rounded_unit, rounding_error
from isoembed.reprs import listed
from isoembed.surface.deviation import largest_vertex_error, vertex_error
from isoembed.surface.estimate import Estimate
from isoembed.surface.flat_faces import coplanar_faces

if TYPE_CHECKING:
    from isoembed.mesh.triangulation import Triangulation
    from isoembed.metric.glued import GluedMetric
    from isoembed.metric.polyhedral import PolyhedralMetric
    from isoembed.proof.certificate import Certificate

SIGNIFICANCE = 1e-3
"""Significance level of each test: the true lengths of all edges fail it once in a thousand."""
SUSPECTS = 3
"""Edges that the message of a failure names at most."""
OUTLIER = 7.0
"""Largest residual of a length from a fit to the others, over its standard deviation, that is no blunder."""
SCATTERED = 2.0
"""Ratio of the scatter of the lengths to their errors above which a smooth surface has larger ones."""
MARGIN = 1.1
"""Factor by which a residual that stands out exceeds its limits: of 87 bodies with right lengths none did."""


def outlier_limit(count: int) -> float:
    """Limit that the largest of so many normal errors exceeds once in a thousand, in standard deviations."""
    return float(-ndtri(SIGNIFICANCE / 2 / count))


def edges_near(triangulation: Triangulation, edge: int) -> Indices:
    """Other edges between the vertices at most two edges away from an edge."""
    near = np.zeros(triangulation.n_vertices, dtype=bool)
    near[triangulation.edges[edge]] = True
    for _ in range(2):
        near[triangulation.edges[near[triangulation.edges].any(axis=1)]] = True
    inside = np.flatnonzero(near[triangulation.edges].all(axis=1))
    return inside[inside != edge]


def standing_out(off: Floats) -> int | None:
    """The edge whose residual, in standard deviations, stands out of the others, if one does.

    It is beyond one deviation and, in those of the other residuals, beyond Baarda's limit, by a margin.  A
    fit that has followed a blunder in part is left with such a residual; it follows blunders where few other
    lengths contradict them.
    """
    e = int(np.argmax(off))
    stands_out = off[e] > MARGIN * outlier_limit(len(off)) * np.sqrt(np.mean(np.delete(off, e) ** 2))
    return e if off[e] > MARGIN and stands_out else None


@dataclass(frozen=True, eq=False, repr=False)
class MeasuredSurface(Embedding):
    """Smooth surface fitted to edge lengths with known standard deviations.

    It has converged if its residuals pass two tests: as a whole, `chi_square` is at most `chi_square_limit`,
    and no single one stands out (Baarda's test).  That says that its lengths agree with those given, not that
    no other surface does.  As the fit follows the errors in part, true lengths fail less often than stated.
    Deviations include the first-order changes of the quantities if all lengths were exact.  If the
    errors are those of the last digit, which the surface is too close to the lengths to test, and the scatter
    is more than twice as large, but less than 1 / 200 of an edge, `length_errors` are scaled to it.

    Parameters
    ----------
    metric, vertices, method, tolerance, stages
        As of an `Embedding`; the metric has `length_errors`.
    weight : float
        Of the roughness against the squares of the residuals, in squared mean edge lengths; 0 if the lengths
        are met exactly.
    scatter : float
        Root mean square of the errors of the lengths, over the mean edge length, by the account of the smooth
        surface that best predicts each from the others (generalized cross-validation); 0 if none tells.
    redundancy : float
        Mean share of an error of a length that its residual shows: the degrees of freedom of the residuals
        over the number of edges; 0 if not known.
    predicted : ndarray, shape (E,), or None
        Lengths of the edges that are suspected, on fits without them, over the mean edge length; NaN for the
        others.
    alike : ndarray of int, or None
        Other edges, an error of which explains the lengths as well as one of those suspected, the best first:
        the ratio of the likelihoods is less than 1000.

    References
    ----------
    Baarda, A testing procedure for use in geodetic networks, Netherlands Geodetic Commission 2/5 (1968).
    """

    _: KW_ONLY
    weight: float
    scatter: float = 0.0
    redundancy: float = 0.0
    predicted: Floats | None = None
    alike: Indices | None = None

    def __post_init__(self) -> None:
        if self.length_errors is None:
            self._set(length_errors=self.metric.length_errors)
        super().__post_init__()

    def _in_unit_of(self, target: PolyhedralMetric | GluedMetric) -> Self:
        """Return the same surface in the unit of a metric, with deviations of the scatter if need be."""
        found = super()._in_unit_of(target)
        if found._has_scaled_errors:
            larger = found.scatter / found._root_mean_square
            found = found._with(length_errors=frozen(larger * np.asarray(found.metric.length_errors)))
        return found._with_flat_faces()

    def _with_flat_faces(self) -> Self:
        """Return the same surface, with the precision of its vertices if it has polygons within it.

        Smooth surfaces have none: on them, a larger tolerance would merge more triangles.
        """
        metric, t = self.metric.normalized, self.triangulation
        if metric.precision is not None or not self._takes_length_errors:
            return self
        x, sigma = self.vertices / self.metric.unit, np.asarray(self.length_errors) / self.metric.unit
        error = float(np.sqrt(np.mean(sigma**2)))
        last_face = int(coplanar_faces(t, x, error=largest_vertex_error(metric, error)).max())
        if last_face == t.n_faces - 1:
            return self
        error_bound = vertex_error(metric, x, error)
        if int(coplanar_faces(t, x, error=error_bound).max()) != last_face:
            return self
        precision = Precision.of_lengths(error_bound / metric.mean_length)
        changed = self._with(metric=self.metric._knowing(precision=precision))
        changed.__dict__.pop("surface", None)
        return changed

    @property
    def _smoothed_parts(self) -> Floats:
        """Parts of the lengths that the fit has smoothed away, by which its quantities may be off."""
        return self.metric.normalized.lengths - self.surface._lengths

    @property
    def _standardized(self) -> Floats:
        """The residuals over their standard deviations, at least the rounding of doubles, shape (E,)."""
        sigma = np.asarray(self.metric.length_errors, dtype=np.float64) / self.metric.mean_length
        return self.residuals / np.maximum(sigma, np.finfo(float).eps)

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
        """Edges whose residuals no single one should have, the largest first: those fitted without, if any.

        Residuals of others beside them are as a rule those of the fit that a wrong length has bent.
        """
        off = self._standardized
        large = [e for e in np.argsort(-off, kind="stable").tolist() if off[e] > self._outlier_limit]
        return list(filter(self._is_left_out, large))[:SUSPECTS] or large[:1]

    @property
    def _others_agree(self) -> bool:
        """Whether all lengths agree but those that are suspected, by both tests."""
        others = np.delete(self._standardized, self._suspects)
        return bool(others @ others <= self.chi_square_limit and others.max() <= self._outlier_limit)

    @property
    def _doubtful(self) -> int | None:
        """The edge whose residual stands out of the others of a surface that has converged, if one does.

        It is not doubted if fits have not left it out: then its residual is due to smoothing.
        """
        e = standing_out(self._standardized) if self.weight else None
        return e if e is None or self.predicted is None or self._is_left_out(e) else None

    @property
    def _follows(self) -> bool:
        """Whether the surface follows the lengths so closely that it does not test their errors."""
        return self.chi_square < 0.05 * len(self.residuals)

    @property
    def _understates(self) -> bool:
        """Whether the errors are much less than the scatter of the lengths, and nothing tests them."""
        # Of more than 1 / 200 of an edge, the body is rough or has a sharp rim: errors are less.
        larger = SCATTERED * self._root_mean_square < self.scatter < 0.005
        return self._follows and larger

    @property
    def _has_scaled_errors(self) -> bool:
        """Whether deviations are those of the scatter, in the place of errors of the last digit."""
        return self._understates and self._rounding is not None

    @property
    def _errors(self) -> str:
        """The errors of the lengths in their unit, root mean square."""
        return f"{self._root_mean_square * self.metric.mean_length:.2g}"

    @property
    def _root_mean_square(self) -> float:
        """Root mean square of the errors of the lengths, over the mean edge length."""
        sigma = np.asarray(self.metric.length_errors) / self.metric.mean_length
        return float(np.sqrt(np.mean(sigma**2)))

    def _is_left_out(self, e: int) -> bool:
        """Whether a fit without the length of an edge tells it."""
        return self.predicted is not None and bool(np.isfinite(self.predicted[e]))

    def _told(self, e: int) -> float:
        """Length of an edge on a fit without it, or else on the surface."""
        if self.predicted is None or not self._is_left_out(e):
            return float(self.lengths[e])
        return float(self.predicted[e]) * self.metric.mean_length

    def _name(self, e: int) -> str:
        return f"edge {e} {self.edges[e].tolist()}"

    def _named(self, e: int, *, in_percent: bool) -> str:
        """An edge and how much longer it is on a fit without it: lengths in their unit, or only percent."""
        given, found = float(self.metric.given_lengths[e]), self._told(e)
        lengths = f": from {given:.10g} to {Estimate(found, 0.02 * abs(found - given)).rounded}"
        change = f"{100 * (found / given - 1):+.2g} %{'' if in_percent else lengths}"
        return f"{self._name(e)} ({change})"

    def _or_instead(self, suspects: list[int]) -> str:
        """Clause on edges that may be wrong in the place of those named; empty if there are none."""
        if self.alike is None or not self.alike.size:
            return ""
        others = listed([self._name(e) for e in self.alike.tolist()], most=8)
        return (
            f"; the lengths do not tell {'it' if len(suspects) == 1 else 'them'} from "
            f"{others}, an error of which explains them as well"
        )

    def _advice(self, *, in_percent: bool = False) -> str:
        """Advice on lengths to check, if the surface misses some; else empty."""
        suspects = self._suspects
        if not suspects:
            return ""
        named = ", ".join(self._named(e, in_percent=in_percent) for e in suspects)
        agree = ", with which all other lengths agree" if self._others_agree else ""
        without = all(map(self._is_left_out, suspects))
        surface = "a smooth surface fitted without them" if without else "the nearest smooth surface"
        return (
            f"check these lengths first, and how much longer they are on {surface}: {named}"
            f"{agree}{self._or_instead(suspects)}"
        )

    def _sentence(self) -> str:
        off, limit = self._standardized, self._outlier_limit
        e = int(np.argmax(off))
        largest = (
            f"the largest residual is {self.residuals[e]:.1e} of the mean edge length, "
            f"{off[e]:.1f} standard deviations, at {self._name(e)}"
        )
        test = (
            f"chi-square is {self.chi_square:.4g} for {len(off)} edges, "
            f"{'at most' if self.chi_square <= self.chi_square_limit else 'more than'} "
            f"{self.chi_square_limit:.4g}, and {largest}, "
            f"{'at most' if off[e] <= limit else 'more than'} {limit:.1f} (significance {SIGNIFICANCE:g})"
        )
        if self.converged and not self.weight:
            return (
                "the surface reproduces the given lengths together with their errors, "
                f"{self._errors}, which it may be bent by: no smoother one was found that agrees with them "
                f"within these{self._of_digits()}"
            )
        if self.converged:
            return (
                f"the lengths agree with those given within their errors, {self._errors}: "
                f"{test}{self._doubts()}{self._of_digits()}"
            )
        found = "no smooth surface was found whose lengths agree with those given within their errors"
        remedy = (self._advice() or "the errors may be larger than stated") + self._of_digits()
        rougher = "; a surface that has the lengths exactly was found, too, but it is rougher"
        return f"{found}: on the nearest surface {test}; {remedy}{rougher if self.others else ''}"

    def _doubts(self) -> str:
        """Clauses on doubts that remain after the tests: understated errors, a length that stands out."""
        clauses, larger = "", f"{self.scatter * self.metric.mean_length:.2g}"
        if self._follows:
            clauses = (
                "; the surface follows the lengths so closely that they do not tell whether the errors are "
                "right"
            )
            if self._understates:
                clauses += (
                    f": it is rough, or the errors are larger, about {larger} if it is smooth, which "
                    f"length_errors={larger} takes as given"
                    f"{' and the deviations are of' if self._has_scaled_errors else ''}"
                )
        e = self._doubtful
        if e is not None:
            clauses += (
                f"; if one length is wrong, it is probably that of {self._named(e, in_percent=False)}, "
                f"though too few others contradict it to tell{self._or_instead([e])}"
            )
        return clauses

    @property
    def _rounding(self) -> float | None:
        """The error of the last digit of the lengths, if their errors are this; None if not."""
        sigma = np.asarray(self.metric.length_errors)
        if unit := rounded_unit(self.metric.lengths, sigma):
            return unit / math.sqrt(12)  # of few different lengths, too
        rounding = (rounding_error(self.metric.lengths) or 0.0) * self.metric.mean_length
        typed = np.allclose(sigma, rounding, rtol=0.01, atol=0.0)  # with two digits
        return rounding if typed else None

    def _of_digits(self) -> str:
        """Clause on errors that are those of the last digit of the lengths, as they are assumed to be."""
        rounding, precision = self._rounding, self.metric.precision
        error = 0.0 if precision is None else precision.length_error * self.metric.mean_length
        if precision is not None and np.allclose(np.asarray(self.metric.length_errors), error, atol=0.0):
            hint = ": length_errors=0 takes the lengths as exact" if self.others else ""
            return f"; the errors, {error:.2g}, are those of coordinates {precision.origin}{hint}"
        if rounding is None:
            return ""
        rougher = ", and the surface that has the lengths exactly is rougher" if self.others else ""
        unit = math.sqrt(12) * rounding
        is_decimal = abs(math.log10(unit) - round(math.log10(unit))) < 1e-6
        origin = "the last digit" if is_decimal else f"rounding to multiples of {unit:.4g}"
        return (
            f"; the errors, {rounding:.2g}, are those of {origin}{rougher}: if the lengths were "
            "measured with larger ones, give length_errors=E; length_errors=0 takes them as exact"
        )

    @property
    def _smallest_detectable_error(self) -> float | None:
        """Error of a length, in its unit, that is found with probability 0.8 (Baarda's internal reliability).

        Of an edge with root mean square errors and the mean redundancy; None if it is not known.
        """
        if not self.redundancy:
            return None
        error = self._root_mean_square * self.metric.mean_length
        # The normal quantile of 80 % is .84.
        return (OUTLIER + 0.84) * error / math.sqrt(self.redundancy)

    @property
    def _reported(self) -> Mapping[str, Any]:
        """The test that the surface has passed, under ``measured``."""
        doubtful = [] if self._doubtful is None else [self._doubtful]
        suspects = doubtful if self.converged else self._suspects
        found = {
            "chi_square": self.chi_square,
            "chi_square_limit": self.chi_square_limit,
            "largest_standardized_residual": float(self._standardized.max()),
            "largest_standardized_residual_limit": self._outlier_limit,
            "significance": SIGNIFICANCE,
            "weight": self.weight,
            "scatter": self.scatter or None,
            "redundancy": self.redundancy or None,
            "smallest_detectable_error": self._smallest_detectable_error,
            "suspects": [
                {
                    "edge": self.edges[e].tolist(),
                    "given_length": self.metric.given_lengths[e],
                    "predicted_length": self._told(e),
                }
                for e in suspects
            ],
            "other_suspects": self.edges[self.alike if suspects and self.alike is not None else []].tolist(),
        }
        return {"measured": found}
