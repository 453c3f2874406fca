"""Certificates of arbitrary surfaces: existence, uniqueness, embeddedness; none if overdetermined.

The theorem is that of `nearby_realization`.  Embeddedness is verified for all vertices in the neighborhood
that contains the exact ones.
"""

from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any, ClassVar, Self

import numpy as np

from isoembed.arrays import Floats
from isoembed.evidence import Evidence
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.proof.length_equations import NotProven
from isoembed.proof.nearby_realization import NearbyRealization
from isoembed.proof.rounding import GUARD
from isoembed.reprs import counted, rounded_down, rounded_up, short_repr
from isoembed.surface.intersection import self_intersections


@short_repr
@dataclass(frozen=True)
class Certificate:
    """Certificate of a nearby exact realization, with the constants of the proof.

    Constants that the proof did not reach are None.

    Attributes
    ----------
    certified : bool
    reason : str
        Statement proven, or reason why nothing is.
    radius : float or None
        Bound on the distances of an exact realization's vertices from the given ones, in mean edge lengths.
    isolation : float or None
        Lower bound on the largest vertex distance between any other realization and that one, after the best
        isometry in weighted least squares, in mean edge lengths.  None for surfaces with boundary that belong
        to a family of realizations.
    embedded : bool or None
        Whether the faces of the exact surface are proven to meet only in their common corners and edges.
    residual : float or None
        Upper bound on ``| |x_a - x_b| - l_ab |`` over the mean edge length.
    sigma_min : float or None
        Lower bound on the singular values of the weighted rigidity matrix, over the mean edge length.
    kantorovich : float or None
        Constant h of the theorem; at most 1.
    """

    certified: bool
    reason: str
    radius: float | None = None
    isolation: float | None = None
    embedded: bool | None = None
    residual: float | None = None
    sigma_min: float | None = None
    kantorovich: float | None = None

    _THEOREMS: ClassVar[str] = (
        "a theorem of Newton-Kantorovich type for the length equations, with bounds on rounding"
    )

    @classmethod
    def _of(cls, prove: Callable[[dict[str, Any]], str]) -> Self:
        """Certificate from a proof, which records the constants that it reaches and returns its statement."""
        found: dict[str, Any] = {}
        try:
            return cls(True, f"certified: {prove(found)}", **found)
        except NotProven as obstacle:
            return cls(False, f"not certified, because {obstacle}", **found)

    @property
    def evidence(self) -> Evidence | None:
        """Evidence for the uniqueness stated in `reason`; None if nothing is proven."""
        return Evidence("proved", self._basis) if self.certified else None

    @property
    def _basis(self) -> str:
        return self._THEOREMS

    def as_json(self) -> dict[str, Any]:
        """Return the fields and the evidence for a report."""
        return {**asdict(self), **(self.evidence.report if self.evidence else {})}


NOT_ASKED = Certificate(False, "not certified, because reports omit certificates for so many vertices")


def overdetermined(more: int, residual: float) -> Certificate:
    """Failed certificate of an overdetermined problem, given its residual in mean edge lengths."""
    open_question = (
        "so that nearly all lengths have no exact surface, and within rounding none can be proven to exist"
        if residual < 1e-10  # within the effect of rounding
        else f"and the surface misses the lengths by up to {residual:.1e} mean edge lengths: no rounding"
    )
    return Certificate(
        False,
        f"not certified: there {'is 1 more equation' if more == 1 else f'are {more} more equations'} than "
        f"unknowns, {open_question}",
    )


def certify(metric: PolyhedralMetric, vertices: Floats, length_errors: Floats | None = None) -> Certificate:
    """Prove that exactly one realization of a metric, with its triangles, is near the vertices.

    For surfaces with boundary that have fewer lengths than unknowns, only existence is proven, as there is a
    family of nearby realizations.  Surfaces with more lengths than unknowns, such as those with handles, have
    no certificate.

    Parameters
    ----------
    metric : PolyhedralMetric
    vertices : ndarray, shape (V, 3)
        In the unit of the lengths.  In hyperbolic and spherical space, coordinates on the hyperboloid or
        sphere, centered at the origin.
    length_errors : ndarray, shape (E,), optional
        Upper bounds on the errors of the lengths, in their unit: the proof then holds for all metrics within
        them.  By default the lengths are exact.

    Returns
    -------
    Certificate
    """
    t = metric.triangulation
    motions = 3 * t.n_vertices - 6 - t.n_edges
    if motions < 0:
        a, b = t.edges.T
        residuals = metric.space.distances(vertices[a], vertices[b]) - metric.lengths
        return overdetermined(-motions, float(np.abs(residuals).max() / metric.mean_length))
    errors = np.zeros(len(metric.lengths)) if length_errors is None else length_errors / metric.unit
    return Certificate._of(partial(_prove, metric.normalized, vertices / metric.unit, errors))


def _prove(metric: PolyhedralMetric, x: Floats, length_errors: Floats, found: dict[str, Any]) -> str:
    """Prove for a normalized metric: record constants, return the statement; raises NotProven."""
    t = metric.triangulation
    motions = 3 * t.n_vertices - 6 - t.n_edges
    nearby = NearbyRealization.of(metric, x, length_errors, found)
    found["kantorovich"], radius = nearby.newton_kantorovich()
    found["radius"] = GUARD * nearby.distance(radius) / metric.mean_length
    if motions:
        others = f"in a family with {counted(motions, 'parameter')}"
    else:
        found["isolation"] = nearby.isolation(radius) / (GUARD * metric.mean_length)
        others = f"and any other at least {rounded_down(found['isolation'])} from it"
    pairs = self_intersections(metric.faces, nearby.equations.straight[0], nearby.reach(radius))
    found["embedded"] = len(pairs) == 0
    return (
        f"a realization of these lengths is within {rounded_up(found['radius'])} mean edge lengths of the "
        f"vertices, {others}; "
        + (f"faces {pairs[0].tolist()} may cross" if len(pairs) else "its faces do not cross")
    )
