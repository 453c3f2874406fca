"""Existence and uniqueness of a realization near given vertices (Newton-Kantorovich).

Let l be the lengths, floats taken as exact numbers, and for points y

    F_ab(y) = (|y_a - y_b|^2 - l_ab^2) / (2 l_ab),

or the equations of `length_equations` in hyperbolic and spherical space.  With c_ab as there, 1 / l_ab in
Euclidean space, the vertices have weights s_a, ``s_a^2 = sum of c_ab^2``, and motions d the norms

    |d|_s = (sum of s_a^2 |d_a|^2)^(1/2),    |d|_max = max_a |d_a|.

Theorem.  Let z be points; J = F'(z) S^-1, with the diagonal matrix S of the weights; sigma > 0 a lower bound
on its E = 3 V - 6 singular values; rho an upper bound on |F(z)|; K = 2 / min_a s_a; and

    h = 2 K rho / sigma^2 <= 1,    r = 2 rho / (sigma (1 + (1 - h)^(1/2))).

If all y with |y - z|_s <= r are near z, one of them is a realization, F(y) = 0.  Any other realization, after
the isometry that brings it nearest to y in the norm |.|_s, has a vertex at a distance from that in y of at
least

    R = (sigma - 2^(3/2) r / min_a s_a) / 2^(1/2).

Proof.  F(z + d) = F(z) + F'(z) d + Q(d), and ``|Q_ab(d)| <= c_ab (|d_a|^2 + |d_b|^2)``.  So

    |Q(d)|^2 <= max_ab (|d_a|^2 + |d_b|^2) sum of c_ab^2 (|d_a|^2 + |d_b|^2),

where the sum is |d|_s^2, and the maximum is at most |d|_s^2 / min s^2, and 2 |d|_max^2.  By the first bound,
|Q(d)| <= K |d|_s^2 / 2.  J has full row rank; its pseudoinverse has norm at most 1 / sigma.  The map ``d ->
-S^-1 J^+ (F(z) + Q(d))`` is continuous, and maps the ball |d|_s <= r into itself: (rho + K r^2 / 2) / sigma =
r.  By Brouwer's theorem it has a fixed point, where F(z + d) = 0.

Second derivatives are bounded like Q, so a displacement by d changes J by at most 2^(3/2) |d|_max, and the
singular values at y are at least sigma' = 2^(1/2) R.  Let also F(y + d) = 0.  In Euclidean space, if no
motion brings y + d nearer to y, ``S^2 d`` is orthogonal to the infinitesimal motions of y + d, and also to
those of y, because d is orthogonal to ``q x d``.  Hence

    sigma' |d|_s <= |F'(y) d| = |Q(d)| <= 2^(1/2) |d|_max |d|_s,

and |d|_max >= R unless d = 0.  In curved space let J be that of y + d: ``S^2 d`` is orthogonal to the
infinitesimal isometries there.  Its singular values are at least sigma' - 2^(3/2) |d|_max, and |d|_max
is at least sigma' / (3 2^(1/2)), or y + d is not near y.

Existence only needs full row rank: surfaces with boundary have a smaller E, and y is one of a family.

Without weights, bounds for the finest part would be dominated by the softness of the coarsest.  With the
Euclidean norm over all vertices, R would be smaller by the square root of V.

Here z is x plus one step of Newton's method, an unevaluated sum, with F(z) computed to twice the digits of
floats.  Thus |F(z)| is some 1e-27, and the distance is the length of that step.  sigma is proven by
`prove_row_rank`, by positive definiteness of J J^T - s.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from scipy.sparse import csr_array, vstack

from isoembed.arrays import Floats
from isoembed.linalg import SingularMatrix, dissect
from isoembed.metric.curvature import deficits
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.proof.definite import PositiveDefinite
from isoembed.proof.length_equations import LengthEquations, NotProven
from isoembed.proof.rounding import GUARD, U, gamma
from isoembed.proof.row_rank import prove_row_rank
from isoembed.surface.projected import Projected

MAX_VERTICES = 100_000  # for more, the factors of J J^T do not fit
LARGEST_H = 0.5  # the theorem allows 1
FARTHEST = 1e-8  # largest error of the vertices, in mean edge lengths


class LinearEquations(Protocol):
    """Linear equations of the vertices, such as `isoembed.proof.boundary_heights.HeightEquations`."""

    def residuals(self, corrections: Floats) -> tuple[Floats, Floats]:
        """Residuals at the exact sums of points and corrections, and bounds on the rounding."""

    def matrix(self, weights: Floats) -> csr_array:
        """Jacobian divided by the weights of the vertices."""


@dataclass(frozen=True, eq=False)
class NearbyRealization:
    """Points z one Newton step from given vertices, with the constants of the theorem.

    Attributes
    ----------
    equations : LengthEquations
        Length equations near the given vertices.
    length_differences : ndarray, shape (E,)
        Upper bounds on the differences of the lengths at the given vertices from any within their errors.
    steps : ndarray, shape (V,)
        Norms of the Newton step.
    residuals : ndarray, shape (E,)
        Upper bounds on |F| at z for all lengths within their errors, with rounded sums.  Those of additional
        equations follow.
    sigma : float
        Lower bound on the singular values of J at z.
    mean_length : float
        Mean edge length.
    """

    equations: LengthEquations
    length_differences: Floats
    steps: Floats
    residuals: Floats
    sigma: float
    mean_length: float

    @classmethod
    def of(
        cls,
        metric: PolyhedralMetric,
        x: Floats,
        length_errors: Floats,
        found: dict[str, Any],
        beside: LinearEquations | None = None,
    ) -> NearbyRealization:
        """Realization of a normalized metric near vertices, (V, 3); constants are recorded in `found`.

        Linear equations `beside` those of the lengths are optional.

        Raises
        ------
        NotProven
            The vertices are far from any realization, or J may be singular.
        """
        if len(x) > MAX_VERTICES:
            raise NotProven(f"there are more than {MAX_VERTICES:,} vertices")
        _check_near(metric, x, length_errors)
        equations = LengthEquations.of(metric, x)
        values, errors = equations.residuals(np.zeros_like(x))
        length_differences = equations.length_differences(np.abs(values) + errors) + length_errors
        found["residual"] = float(GUARD * length_differences.max() / metric.mean_length)

        J = equations.matrix()
        if beside is not None:
            values = np.append(values, beside.residuals(np.zeros_like(x))[0])
            J = vstack([J, beside.matrix(equations.weights)], format="csr")
        factor, sigma = _factored(metric, x, J)
        sigma -= equations.matrix_error
        found["sigma_min"] = sigma / (GUARD * metric.mean_length)
        y = -(J.T @ factor.solve(values)).reshape(-1, 3) / equations.weights[:, None]
        steps = np.linalg.norm(y, axis=1)
        values, errors = equations.residuals(y)
        residuals = np.abs(values) + errors + equations.changes_by(length_errors)
        if beside is not None:
            residuals = np.append(residuals, np.sum(np.abs(beside.residuals(y)), axis=0))
        sigma -= GUARD * 8**0.5 * float(steps.max())
        return cls(equations, length_differences, steps, residuals, sigma, metric.mean_length)

    @cached_property
    def step(self) -> float:
        """Maximum of `steps`, rounded up."""
        return GUARD * float(self.steps.max())

    def newton_kantorovich(self, more: float = 0.0) -> tuple[float, float]:
        """Constant h, and the bound ``r / min s`` on the displacement of a vertex, rounded up.

        Parameters
        ----------
        more : float
            Increase of rho.

        Raises
        ------
        NotProven
            h is too large, or J may be singular.
        """
        rho, sigma, min_weight = (
            norm(self.residuals) + more,
            self.sigma,
            float(self.equations.weights.min()) / GUARD,
        )
        if not sigma > 0:
            raise NotProven("a motion of the vertices may change no length to first order, up to rounding")
        h = GUARD * 4 * rho / (min_weight * sigma**2)
        if not h <= LARGEST_H:
            raise NotProven(
                f"the residuals are too large: h = 2 K rho / sigma^2 is {h:.1e}, more than {LARGEST_H}"
            )
        return h, GUARD * 2 * rho / (sigma * (1 + float(np.sqrt(1 - h)))) / min_weight

    def reach(self, radius: float) -> float:
        """Bound on the distance of vertices from the exact ones in projective coordinates."""
        straight, off, stretch = self.equations.straight
        return stretch * (self.step + radius) + off + 4 * U * float(np.abs(straight).max())

    def distance(self, radius: float, near: float = np.inf) -> float:
        """Bound on the distance, in space, of a vertex from the exact one.

        Parameters
        ----------
        radius : float
            Bound on the distance of the exact vertices from z.
        near : float
            Largest permissible distance of the exact vertices, in the coordinates of the equations.

        Raises
        ------
        NotProven
            The bound exceeds `near`, or the errors of the vertices are too large.
        """
        distance, near = self.equations.distance(self.steps, radius), min(near, self.equations.room)
        largest = FARTHEST * self.mean_length
        if not (GUARD * (self.step + radius) <= near and distance <= largest):
            raise NotProven(
                f"the exact vertices may be {distance / self.mean_length:.1e} mean edge lengths away, "
                f"more than {min(near, largest) / self.mean_length:.1e}"
            )
        return distance

    def isolation(self, radius: float) -> float:
        """Isolation radius R in space, rounded down: other realizations are at least this far away."""
        lower = (self.sigma - GUARD * 8**0.5 * radius) / (2**0.5 * GUARD)
        if self.equations.space.is_euclidean:
            return max(0.0, lower)
        room = self.equations.room - GUARD * (self.step + radius)
        return max(0.0, self.equations.smallest_distance(min(lower / 3, room)))


def norm(bounds: Floats) -> float:
    """Upper bound on the Euclidean norm."""
    return GUARD * float(np.linalg.norm(bounds))


def _check_near(metric: PolyhedralMetric, x: Floats, length_errors: Floats) -> None:
    """Check that the vertices have nearly the given lengths, as those near an exact realization do."""
    a, b = metric.edges.T
    errors = np.abs(metric.space.distances(x[a], x[b]) - metric.lengths)
    beyond = errors - (2 * FARTHEST * metric.mean_length + length_errors)
    if not (beyond <= 0).all():
        e = int(np.argmax(beyond))
        raise NotProven(
            f"edge {e} {metric.edges[e].tolist()} misses its length by {errors[e] / metric.mean_length:.1e} "
            "of the mean edge length, more than any other"
        )


def _factored(metric: PolyhedralMetric, x: Floats, J: csr_array) -> tuple[PositiveDefinite, float]:
    """Factor J J^T, and bound the singular values of the exact J from below."""
    t = metric.triangulation
    try:
        # Edges with a common vertex are coupled already: additional equations, placed first, cause no fill.
        count, edges = len(metric.lengths), dissect(t.adjacency).edge_order(t.edges)
        factor, sigma = prove_row_rank(J, np.concatenate([np.arange(count, J.shape[0]), edges]))
    except SingularMatrix as error:
        epsilon = deficits(metric)
        v = int(np.argmin(np.abs(epsilon)))
        if (
            t.is_sphere and abs(epsilon[v]) > 1e-9
        ):  # no vertex is in the plane of its neighbors, which would explain the singularity
            from isoembed.proof.flexibility import described_flex  # needed for nonrigid surfaces only

            flex = described_flex(t, Projected.of(metric.space, x), metric.lengths)
            if flex is not None:
                raise NotProven(flex) from error
        raise NotProven(
            f"the lengths may not fix the vertices ({error}): vertex {v} is the flattest, "
            f"with a deficit of {epsilon[v]:.1e}"
        ) from error
    except MemoryError as error:
        raise NotProven("there is not enough memory for the factors of J J^T") from error
    # Each entry of J is the result of three roundings.
    sizes = abs(J)
    rounding = GUARD * gamma(4) * float(np.sqrt((sizes @ (sizes.T @ np.ones(J.shape[0]))).max()))
    return factor, sigma - rounding
