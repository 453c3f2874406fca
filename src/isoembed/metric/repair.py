"""Deficits that noise made negative, repaired by the smallest conformal change of the lengths.

The edge from i to j becomes ``l_ij exp((u_i + u_j) / 2)``.  To first order in the factors u the deficits
become ``delta + H u``, where H is the Laplacian with cotangent weights.  Wanted are factors ``u >= 0`` for
which no deficit is negative, and which vanish where a deficit is left positive: the negative curvature is
filled up from the nearest positive curvature, and lengths farther away stay as they are.

This is a linear complementarity problem.  On a Delaunay triangulation H is an M-matrix, and of all factors
``u >= 0`` without negative deficits the solution is the smallest at every vertex at once (Cottle, Pang and
Stone, The Linear Complementarity Problem, 1992, section 3.11).  As equal factors only change the unit, no
other conformal change without negative deficits has factors that differ less, ``max u - min u``.
"""

import math
from dataclasses import dataclass
from typing import TypeVar, cast

import numpy as np
from scipy.sparse import csc_array

from isoembed.arrays import Floats, Indices
from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.linalg import SingularMatrix, factor_general
from isoembed.mesh.triangulation import frozen
from isoembed.metric.conformal import equivalent
from isoembed.metric.convexity import check_convex, deficit_rounding
from isoembed.metric.glued import GluedMetric
from isoembed.metric.laplacian import cotangent_laplacian
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.thresholds import threshold

Metric = TypeVar("Metric", bound=PolyhedralMetric | GluedMetric)


@dataclass(frozen=True)
class RepairThresholds:
    """Thresholds of the repair of deficits."""

    newton_steps: int = threshold(20, "steps", "Far beyond what small deficits need: each squares the error.")
    blocks: int = threshold(10, "exchanges", "Of many vertices that may fail to help before single ones.")
    exchanges: int = threshold(200, "exchanges", "Far beyond what a Delaunay triangulation needs.")


REPAIR = RepairThresholds()


@dataclass(frozen=True, eq=False)
class Repair:
    """What `repaired` found and changed.

    Attributes
    ----------
    vertices : ndarray of int64, shape (k,)
        Those whose deficits were negative beyond rounding.
    deficits : ndarray, shape (k,)
        What they were, radians.
    factors : ndarray, shape (V,)
        The conformal factors u; not negative.
    largest_change : float
        Of a length, relative.
    """

    vertices: Indices
    deficits: Floats
    factors: Floats
    largest_change: float

    @property
    def largest_factor(self) -> float:
        """The largest of `factors`."""
        return float(self.factors.max())

    def as_json(self) -> dict[str, object]:
        """What changed, for a report."""
        return {
            "vertices": self.vertices.tolist(),
            "deficits": self.deficits.tolist(),
            "largest_factor": self.largest_factor,
            "largest_relative_length_change": self.largest_change,
        }


def repaired(metric: Metric, noise: float) -> tuple[Metric, Repair]:
    """Lift the deficits that are negative, but not below the noise, to zero.

    Parameters
    ----------
    metric : PolyhedralMetric or GluedMetric
    noise : float
        Radians, not negative.

    Returns
    -------
    metric : as given
        The same triangles, with deficits that are negative by rounding only; the metric itself if it was so.
    repair : Repair

    Raises
    ------
    InvalidMetric
        A deficit is below minus the noise, or is too negative to be repaired; the message names the worst.
    InvalidParameter
        The noise is negative or not finite.
    """
    if not (math.isfinite(noise) and noise >= 0):
        raise InvalidParameter(f"the noise is {noise!r}, not a number of radians from 0 on")
    given = GluedMetric.of(metric)
    before = given.deficits
    rounding = deficit_rounding(given.faces, given.face_lengths)
    check_convex(before, np.maximum(rounding, noise))
    negative = np.flatnonzero(before < -rounding)
    u = np.zeros(given.n_vertices)
    result = metric
    for _ in range(REPAIR.newton_steps):
        current = GluedMetric.of(result)
        delta = current.deficits
        if (delta >= -deficit_rounding(current.faces, current.face_lengths)).all():
            change = float(np.abs(current.face_lengths / given.face_lengths - 1).max())
            return result, Repair(frozen(negative), frozen(before[negative]), frozen(u), change)
        H = cotangent_laplacian(current)
        try:
            u = _least_factors(H, delta - H @ u, rounding / 2)
            result = _rescaled(metric, u)
        except (SingularMatrix, InvalidMetric):
            break
    v = int(np.argmin(before))
    raise InvalidMetric(
        f"vertex {v} has total angle {2 * np.pi - before[v]:.10g} > 2 pi (deficit {before[v]:.3g}): "
        "that is too much to be repaired by a conformal change"
    )


def _least_factors(H: csc_array, delta: Floats, slack: Floats) -> Floats:
    """Find ``u >= 0`` with ``H u + delta >= -slack``, where u is not zero equal to zero; shape (V,).

    By exchanging many vertices at a time, which on a Delaunay triangulation only adds to those with positive
    factors; one by one where that does not help (Judice and Pires, A block principal pivoting algorithm for
    large-scale strictly monotone linear complementarity problems, Computers Ops. Res. 21, 1994).
    """
    lifted = delta < -slack
    fewest, left = lifted.size + 1, REPAIR.blocks
    for _ in range(REPAIR.exchanges):
        u = np.zeros(delta.size)
        u[lifted] = factor_general(H[lifted][:, lifted]).solve(-delta[lifted])
        wrong = np.where(lifted, u < 0, H @ u + delta < -slack)
        count = int(wrong.sum())
        if count == 0:
            break
        if count < fewest:
            fewest, left = count, REPAIR.blocks
        elif left > 0:
            left -= 1
        else:
            wrong[: np.flatnonzero(wrong)[-1]] = False
        lifted ^= wrong
    return u


def _rescaled(metric: Metric, u: Floats) -> Metric:
    if isinstance(metric, GluedMetric):
        return cast(Metric, equivalent(metric, u))
    with np.errstate(over="ignore"):  # a length beyond the floats is refused as infinite
        return cast(Metric, metric.with_lengths(metric.lengths * np.exp(u / 2)[metric.edges].prod(axis=1)))
