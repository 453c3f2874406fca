"""A proof that a computed polyhedron is Alexandrov's, up to a stated distance.

Let x be the computed vertices and l the lengths of the edges of a triangulation, all of them floats, taken
as exact numbers. For points y near x let

    F_ab(y) = (|y_a - y_b|^2 - l_ab^2) / (2 l_ab).

`prove_nearby_hulls` shows that they span a convex polyhedron, whose faces are the triangles or, where edges
may be flat, polygons of them. On its surface draw the edges: as edges, or straight through the (unfolded)
polygons, with lengths L_ab(y). The surface, cut along them, is a gluing of triangles like the given metric,
and is the given metric if ``G = F + (L^2 - |y_a - y_b|^2) / (2 l)`` vanishes. The second term is that of
the *detours*.

Theorem. Let z be points near x; J = F'(z), which has a row ``(z_a - z_b)^T / l_ab`` at a and its negative
at b for every edge; sigma > 0 a lower bound on its E = 3 V - 6 singular values; rho an upper bound on
|F(z)| plus the norm of the detours at all y near x; K = 2 max_a (sum of 1 / l^2 over the edges at a)^(1/2);
and

    h = 2 K rho / sigma^2 <= 1,    r = 2 rho / (sigma (1 + (1 - h)^(1/2))).

If all y with |y - z| <= r are near x, one of them has G(y) = 0: it spans a convex polyhedron with the given
metric. By Alexandrov's theorem (1941) this polyhedron is, up to congruence, the only one.

Proof. With d = y - z, F(y) = F(z) + J d + Q(d), where Q_ab(d) = |d_a - d_b|^2 / (2 l_ab). As |d_a - d_b|^2
<= 2 |d|^2 and the sum of |d_a - d_b|^2 / l_ab^2 is at most (K^2 / 2) |d|^2, |Q(d)| <= K |d|^2 / 2. J has
full row rank; its pseudoinverse J^+ has norm 1 / sigma at most. The map ``d -> -J^+ (F(z) + Q(d) +
detours(z + d))`` is continuous, and takes the ball |d| <= r into itself because (rho + K r^2 / 2) / sigma =
r. By Brouwer it has a fixed point, and there J d = -F(z) - Q(d) - detours, that is G(z + d) = 0.

Without detours this is the theorem of Newton and Kantorovich, and h its number. No vertex is pinned: the
distances are those after the best rigid motion, and sigma is larger than that of the pinned equations.

Here z is x plus one step of Newton's method, as a sum that is never rounded, with F(z) evaluated to twice
the digits of floats. So |F(z)| is some 1e-27, r is negligible, and the stated distance is that step. sigma
comes from a proof that J J^T - s is positive definite (`prove_definite`). Every bound covers the rounding
of its own evaluation. Errors of the lengths enter rho with their norm; the proof then holds for every
metric within them.
"""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from scipy.sparse import csc_array, csr_array

from isoembed.alexandrov.enclosed_residuals import enclosed_residuals
from isoembed.alexandrov.nearby_hulls import NearbyHulls, NotProven, prove_nearby_hulls
from isoembed.arrays import Floats
from isoembed.linalg import SingularMatrix, dissect
from isoembed.linalg.definite import PositiveDefinite, prove_definite
from isoembed.linalg.rounding import GUARD, U, gamma
from isoembed.mesh.triangulation import Triangulation
from isoembed.metric.curvature import deficits
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.surface.rigidity import edge_rows
from isoembed.thresholds import threshold


@dataclass(frozen=True)
class CertificateThresholds:
    """Thresholds of the certificate."""

    most_vertices: int = threshold(30_000, "vertices", "For more, the factors of J J^T outgrow the solve.")
    largest_h: float = threshold(0.5, "relative", "Largest h; the theorem allows 1.")
    farthest: float = threshold(1e-8, "mean edge lengths", "Farthest that vertices may be off.")


CERTIFICATE = CertificateThresholds()


@dataclass(frozen=True)
class Certificate:
    """Whether a polyhedron is proven to be Alexandrov's, and the numbers of the proof.

    A number that the proof did not get to is None.

    Attributes
    ----------
    certified : bool
    reason : str
        A sentence: what is proven, or why nothing is.
    distance : float or None
        No vertex is farther than this from the exact one, after a rigid motion; in the unit of the lengths.
    residual : float or None
        Upper bound on ``| |x_a - x_b| - l_ab |`` over the mean edge length.
    sigma_min : float or None
        Lower bound on the singular values of the rigidity matrix J.
    kantorovich : float or None
        The number h; at most 1.
    smallest_dihedral : float or None
        Lower bound on the exterior dihedral angles between the faces of the exact polyhedron, radians.
    flat_edges : int or None
        Edges within polygonal faces: the exact polyhedron may have other diagonals in their place, or none.
    """

    certified: bool
    reason: str
    distance: float | None = None
    residual: float | None = None
    sigma_min: float | None = None
    kantorovich: float | None = None
    smallest_dihedral: float | None = None
    flat_edges: int | None = None

    def as_json(self) -> dict[str, Any]:
        """Return the fields, as they stand in a report."""
        return asdict(self)


def certify(metric: PolyhedralMetric, vertices: Floats, length_errors: Floats | None = None) -> Certificate:
    """Prove that vertices are those of the convex polyhedron of a metric, up to rounding.

    The theorem and its constants are in the module's documentation.

    Parameters
    ----------
    metric : PolyhedralMetric
        A triangulation of the polyhedron, oriented outward, without flat vertices; and its lengths.
    vertices : ndarray, shape (V, 3)
        In the unit of the lengths.
    length_errors : ndarray, shape (E,), optional
        Upper bounds on the errors of the lengths, in their unit: the proof then holds for all metrics within
        them.  By default the lengths are exact.

    Returns
    -------
    Certificate
    """
    errors = np.zeros(len(metric.lengths)) if length_errors is None else length_errors / metric.unit
    found: dict[str, Any] = {}
    try:
        distance = _prove(metric.normalized, vertices / metric.unit, errors, found) * metric.unit
    except NotProven as obstacle:
        return Certificate(False, f"not certified, because {obstacle}", **found)
    found["distance"] = distance = float(np.nextafter(distance, np.inf))
    # Two digits may be 5 % off, and what is printed is to be proven, too.
    reason = (
        f"certified: the vertices are within {1.05 * distance:.1e} of those of the convex polyhedron of the "
        f"metric, whose exterior dihedral angles are at least {0.95 * found['smallest_dihedral']:.1e}"
    )
    return Certificate(True, reason, **found)


def _prove(metric: PolyhedralMetric, x: Floats, length_errors: Floats, found: dict[str, Any]) -> float:
    """Carry out the proof, in the unit of a normalized metric: return the distance, and note the rest.

    Raises
    ------
    NotProven
    """
    t, lengths = metric.triangulation, metric.lengths
    if t.n_vertices > CERTIFICATE.most_vertices:
        raise NotProven(f"there are more than {CERTIFICATE.most_vertices:,} vertices")
    _check_near(metric, x, length_errors)
    values, errors = enclosed_residuals(t.edges, x, np.zeros_like(x), lengths)
    a, b = t.edges.T
    halved = lengths / (np.linalg.norm(x[a] - x[b], axis=1) + lengths)  # |F| as a difference of lengths
    missed = 2 * GUARD * (np.abs(values) + errors) * halved + length_errors
    found["residual"] = float(GUARD * missed.max() / metric.mean_length)

    J = _rigidity_matrix(t, x, lengths)
    factor, sigma = _factored(metric, J)
    found["sigma_min"] = sigma
    y = -(J.T @ factor.solve(values)).reshape(-1, 3)
    step = GUARD * float(np.linalg.norm(y, axis=1).max())
    values, errors = enclosed_residuals(t.edges, x, y, lengths)
    rho = _norm(np.abs(values) + errors + length_errors * (1 + length_errors / (2 * lengths)))
    at_ends = np.bincount(t.edges.ravel(), np.repeat(1 / lengths**2, 2))
    K = 2 * GUARD * float(np.sqrt(at_ends.max()))
    sigma -= K * 2 * step  # at z; J changes by less than K times the change of |x_a - x_b|

    found["kantorovich"], radius = _newton_kantorovich(rho, K, sigma)
    reach = 2 * (step + radius) + 4 * U * float(np.abs(x - x.mean(axis=0)).max())
    hulls = prove_nearby_hulls(t, x, reach)
    found["smallest_dihedral"], found["flat_edges"] = hulls.dihedral, int(hulls.flat.sum())
    rho += _norm(_detours(t, x, lengths, reach, hulls))
    found["kantorovich"], radius = _newton_kantorovich(rho, K, sigma)
    distance, farthest = GUARD * (step + radius), min(reach, CERTIFICATE.farthest * metric.mean_length)
    if not distance <= farthest:
        raise NotProven(
            f"the exact vertices may be {distance / metric.mean_length:.1e} mean edge lengths away, "
            f"more than {farthest / metric.mean_length:.1e}"
        )
    return distance


def _check_near(metric: PolyhedralMetric, x: Floats, length_errors: Floats) -> None:
    """Vertices that are near enough to exact ones have almost their lengths."""
    a, b = metric.edges.T
    missed = np.abs(np.linalg.norm(x[a] - x[b], axis=1) - metric.lengths)
    wrong = ~(missed <= 2 * CERTIFICATE.farthest * metric.mean_length + length_errors)
    if wrong.any():
        e = int(np.argmax(wrong))
        raise NotProven(
            f"edge {e} {metric.edges[e].tolist()} misses its length by {missed[e] / metric.mean_length:.1e} "
            "of the mean edge length"
        )


def _rigidity_matrix(t: Triangulation, x: Floats, lengths: Floats) -> csr_array:
    """J, shape (E, 3 V): every entry within two roundings of ``+-(x_a - x_b) / l_ab``."""
    rows = edge_rows(t, x, lengths)
    columns = (3 * t.edges[:, :, None] + np.arange(3)).ravel()
    pointers = np.arange(0, columns.size + 1, 6)
    return csr_array((np.stack([rows, -rows], axis=1).ravel(), columns, pointers), shape=(len(rows), x.size))


def _factored(metric: PolyhedralMetric, J: csr_array) -> tuple[PositiveDefinite, float]:
    """Factor J J^T, and bound the singular values of the exact J from below."""
    t = metric.triangulation
    try:
        factor = prove_definite(csc_array(J @ J.T), dissect(t.adjacency).edge_order(t.edges))
    except SingularMatrix as error:
        epsilon = deficits(metric)
        v = int(np.argmin(epsilon))
        raise NotProven(
            f"the lengths may not fix the vertices ({error}): vertex {v} is the flattest, "
            f"with a deficit of {epsilon[v]:.1e}"
        ) from error
    sizes = abs(J)
    # An entry of J J^T is a sum of at most six products of entries that took two roundings each.
    rounding = GUARD * gamma(12) * float((sizes @ (sizes.T @ np.ones(len(t.edges)))).max())
    return factor, float(np.sqrt(max(0.0, factor.eigenvalue - rounding))) / GUARD


def _newton_kantorovich(rho: float, K: float, sigma: float) -> tuple[float, float]:
    """The numbers h and r of the theorem, rounded up."""
    h = GUARD * 2 * K * rho / sigma**2 if sigma > 0 else np.inf
    if not h <= CERTIFICATE.largest_h:
        raise NotProven(
            f"the residuals are too large: h = 2 K rho / sigma^2 is {h:.1e}, "
            f"more than {CERTIFICATE.largest_h}"
        )
    return h, GUARD * 2 * rho / (sigma * (1 + float(np.sqrt(1 - h))))


def _detours(t: Triangulation, x: Floats, lengths: Floats, reach: float, hulls: NearbyHulls) -> Floats:
    """Upper bounds on ``(L^2 - |y_a - y_b|^2) / (2 l)`` at the points y within reach of x, shape (E,)."""
    a, b = t.edges.T
    chords = np.linalg.norm(x[a] - x[b], axis=1) + 2 * reach
    return np.where(hulls.flat, (chords * hulls.slopes) ** 2 / (2 * lengths), 0.0)


def _norm(bounds: Floats) -> float:
    return GUARD * float(np.linalg.norm(bounds))
