"""Repair of negative deficits within the noise: a linear complementarity problem for conformal factors.

A vertex inside a face or an edge of a polyhedron has zero deficit; errors of the lengths cause deficits of
either sign.  The edge from i to j becomes ``l_ij exp((u_i + u_j) / 2)``, as a chord on the sphere and in the
hyperbolic plane.  To first order in the factors u the deficits become ``delta + H u``, where H is the
cotangent Laplacian or its analog in curved space.  With the set F of vertices to be flattened, the factors
satisfy

    (delta + H u)_i = 0                                                      at i in F,
    u_i >= 0,  (delta + H u)_i >= 0,  and one of the two is zero             at all others.

Missing or excess curvature is exchanged with the nearest vertices that keep a deficit; lengths farther away
are unchanged.  F is determined from the deficits: if all deficits above the noise are far larger than those
within, F consists of the vertices within.  Otherwise, deficits of that size belong to the body, F is empty,
and only negative deficits are lifted.  Noise leaves deficits of both signs: a positive deficit far larger
than the most negative one also belongs to the body.

This is a mixed linear complementarity problem.  Given the vertices where the deficits become zero, it is a
Poisson equation there, with u = 0 elsewhere.  Of all factors that make just these deficits zero, the solution
minimizes the Dirichlet energy ``u^T H u`` (Pinkall and Polthier, Computing discrete minimal surfaces and
their conjugates, Experimental Mathematics 2, 1993): at the minimum, ``H u = H w`` with multipliers w that
vanish elsewhere, so u equals w up to a constant, which only changes the unit.  On a Delaunay triangulation H
is an M-matrix, and the solution is the pointwise smallest of all factors that make the deficits in F zero and
none negative, and are nonnegative elsewhere (Cottle, Pang and Stone, The Linear Complementarity Problem,
1992, section 3.11).
"""

import math
from dataclasses import dataclass
from typing import TypeVar, cast

import numpy as np
from scipy.sparse import csc_array

from isoembed.arrays import Floats, Indices, Mask
from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.linalg import SingularMatrix, factor_general
from isoembed.mesh.triangulation import frozen
from isoembed.metric.conformal import equivalent
from isoembed.metric.convexity import (
    GAP,
    MAX_NOISE,
    check_convex,
    deficit_rounding,
    deficit_spread,
    largest_noise,
)
from isoembed.metric.glued import GluedMetric
from isoembed.metric.laplacian import deficit_laplacian
from isoembed.metric.polyhedral import PolyhedralMetric

Metric = TypeVar("Metric", bound=PolyhedralMetric | GluedMetric)


MAX_BLOCK_EXCHANGES = 10  # unsuccessful exchanges of many vertices before exchanging single ones


@dataclass(frozen=True, eq=False)
class Repair:
    """Findings and changes of `repaired`.

    Attributes
    ----------
    vertices : ndarray of int64, shape (k,)
        Repaired vertices: those to be flattened with a deficit beyond rounding, or with a negative one.
    deficits : ndarray, shape (k,)
        Their deficits before the repair, radians.
    factors : ndarray, shape (V,)
        Conformal factors u.
    largest_change : float
        Largest relative change of a length.
    """

    vertices: Indices
    deficits: Floats
    factors: Floats
    largest_change: float

    @property
    def largest_factor(self) -> float:
        """Maximum absolute value of `factors`."""
        return float(np.abs(self.factors).max())

    def as_json(self) -> dict[str, object]:
        """Changes, for a report."""
        return {
            "vertices": self.vertices.tolist(),
            "deficits": self.deficits.tolist(),
            "largest_factor": self.largest_factor,
            "largest_relative_length_change": self.largest_change,
        }


def repaired(
    metric: Metric, noise: float, tolerance: float = 0.0, *, flat: Mask | None = None
) -> tuple[Metric, Repair]:
    """Flatten vertices with deficits within the noise, or at least lift negative deficits to zero.

    Parameters
    ----------
    metric : PolyhedralMetric or GluedMetric
    noise : float
        Noise level in radians, nonnegative; with 0 the metric is only checked.
    tolerance : float
        Relative tolerance of the lengths: deficits negative by at most as many radians are accepted.
    flat : ndarray of bool, shape (V,), optional
        Vertices to be flattened; by default determined from the deficits.

    Returns
    -------
    metric : as given
        Metric on the same triangles in which negative deficits are within rounding, and also those that were
        within the noise, if all others are far larger; the given metric itself if it already satisfies this.
    repair : Repair

    Raises
    ------
    InvalidMetric
        A deficit is below minus the noise, or too negative to be repaired; the message names the worst.
    InvalidParameter
        The noise is negative or not finite.
    """
    if not (math.isfinite(noise) and noise >= 0):
        raise InvalidParameter(f"the noise is {noise!r}, not a non-negative number of radians")
    glued = GluedMetric.of(metric)
    before = glued.deficits
    rounding = deficit_rounding(glued)
    precision = metric.precision
    doubt = None
    if precision is not None and not precision.is_of_lengths:
        spread = deficit_spread(glued.faces, glued.face_lengths, glued.twins, glued.curvature)
        doubt = precision.name, precision.length_error * spread
    level = max(noise, min(tolerance, MAX_NOISE))
    check_convex(before, np.maximum(rounding, level), doubt)
    flat = small_by_far(before, min(level, largest_noise(before))) if flat is None else flat
    changed = (np.where(flat, np.abs(before), -before) > rounding) & (noise > 0)
    u = np.zeros(glued.n_vertices)
    result, left = metric, math.inf
    for _ in range(20):  # more than needed for small deficits: each step squares the error
        current = GluedMetric.of(result)
        delta = current.deficits
        errors = np.where(flat, np.abs(delta), -delta)
        before_step, left = left, max(float(errors.max()), 0.0)
        allowed = deficit_rounding(current)
        # a step that leaves more than half of the errors has reached rounding
        if not changed.any() or ((errors <= allowed).all() and left >= 0.5 * before_step):
            change = float(np.abs(current.face_lengths / glued.face_lengths - 1).max())
            vertices = np.flatnonzero(changed)
            return result, Repair(frozen(vertices), frozen(before[vertices]), frozen(u), change)
        H = deficit_laplacian(current)
        try:
            u = complementary_factors(H, delta - H @ u, rounding / 2, flat)
            result = _rescaled(metric, u)
        except (SingularMatrix, InvalidMetric):
            break
    v = int(np.argmax(np.where(changed, np.abs(before), 0.0)))
    raise InvalidMetric(
        f"vertex {v} has total angle {2 * np.pi - before[v]:.10g} (deficit {before[v]:.3g}): it is too "
        "large for repair by a conformal change"
    )


def small_by_far(deficits: Floats, noise: float) -> Mask:
    """Vertices within the noise, if the deficits of all others are far larger; otherwise none."""
    within = np.abs(deficits) <= noise
    if within.all() or deficits[~within].min() < GAP * np.abs(deficits[within]).max(initial=0.0):
        return np.zeros_like(within)
    return within


def complementary_factors(H: csc_array, delta: Floats, slack: Floats, flat: Mask) -> Floats:
    """Find ``u >= 0`` with ``H u + delta >= -slack``, and ``H u + delta = 0`` where u is not zero; (V,).

    At vertices to be flattened, u may have either sign, and ``H u + delta`` is zero.  By block principal
    pivoting, which on a Delaunay triangulation only adds vertices with positive factors, and single pivots
    if that stalls (Judice and Pires, A block principal pivoting algorithm for large-scale strictly monotone
    linear complementarity problems, Computers Ops. Res. 21, 1994).
    """
    lifted = flat | (delta < -slack)
    fewest, left = lifted.size + 1, MAX_BLOCK_EXCHANGES
    for _ in range(200):  # more than needed on a Delaunay triangulation
        u = np.zeros(delta.size)
        if lifted.any():
            u[lifted] = factor_general(H[lifted][:, lifted]).solve(-delta[lifted])
        wrong = ~flat & np.where(lifted, u < 0, H @ u + delta < -slack)
        count = int(wrong.sum())
        if count == 0:
            break
        if count < fewest:
            fewest, left = count, MAX_BLOCK_EXCHANGES
        elif left > 0:
            left -= 1
        else:
            wrong[: np.flatnonzero(wrong)[-1]] = False
        lifted ^= wrong
    return u


def _rescaled(metric: Metric, u: Floats) -> Metric:
    if isinstance(metric, GluedMetric):
        return cast(Metric, equivalent(metric, u))
    with np.errstate(over="ignore"):  # overflowing lengths are refused as infinite
        chords = metric.space.chord(metric.lengths) * np.exp(u / 2)[metric.edges].prod(axis=1)
        return cast(Metric, metric.with_lengths(metric.space.arc(chords)).rounded_as(metric))
