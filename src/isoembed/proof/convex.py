"""Proof that a computed polyhedron is Alexandrov's, within a stated distance.

`prove_nearby_hulls` shows that all points y near the computed vertices span a convex polyhedron, whose faces
are the triangles or, where edges may be flat, polygons of them.  On its surface draw the edges: as edges, or
straight through the (unfolded) polygons, with lengths L_ab(y).  The surface, cut along them, is a gluing of
triangles like the given metric, and is the given metric if ``G = F + (L^2 - |y_a - y_b|^2) / (2 l)``
vanishes, F being that of `nearby_realization`.  The second term is that of the *detours*.

Theorem. With rho an upper bound on |F(z)| plus the norm of the detours at all y near x, and sigma, K, h and r
as in `nearby_realization`: if all y with |y - z|_s <= r are near x, one of them has G(y) = 0.  It spans a
convex polyhedron with the given metric.  By Alexandrov's theorem (1941) this polyhedron is, up to congruence,
the only one.

Proof. That of `nearby_realization`, for the map ``d -> -S^-1 J^+ (F(z) + Q(d) + detours(z + d))``.

In hyperbolic and spherical space convexity is that of projective coordinates, where planes are planes:
`prove_nearby_hulls` is told these, with a reach that covers the near points. A way on a roof from a to b is a
convex curve in a plane with the straight line ab, which it meets at angles of at most alpha: at both ends
``sin(alpha) <= 2 t max(w, 1 / w)^2``, t being the slope and w as in `Space.heights`, for translations to the
origin stretch differently along the radius and across. As perimeters of convex curves grow with the curves,
it is no longer than the sides of the isosceles triangle over ab with these angles, ``tn(L / 2) <= tn(l / 2) /
cos(alpha)``; and so, for links of corners on the unit sphere, no angle of an unfolded roof reaches pi where
alpha < pi / 2. Alexandrov's theorem holds in both spaces (Alexandrov, Convex polyhedra, 2005; Fillastre,
arXiv:1011.3123).

Errors of the lengths enter rho with their norm; the proof then holds for every metric within them.
"""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from isoembed.arrays import Floats
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.proof.certificate import Certificate
from isoembed.proof.length_equations import NotProven
from isoembed.proof.nearby_hulls import prove_nearby_hulls
from isoembed.proof.nearby_realization import FARTHEST, NearbyRealization, norm
from isoembed.proof.rounding import GUARD, U
from isoembed.thresholds import rounded_down, rounded_up


@dataclass(frozen=True)
class ConvexCertificate(Certificate):
    """Whether a polyhedron is proven to be Alexandrov's, and the numbers of the proof.

    A number that the proof did not get to is None.

    Attributes
    ----------
    certified, reason, radius, isolation, embedded, residual, sigma_min, kantorovich
        As of a `Certificate`.  The isolation is among realizations of the same triangles, convex or not.
    distance : float or None
        No vertex is farther than this from the exact one, after a rigid motion; in the unit of the lengths.
    smallest_dihedral : float or None
        Lower bound on the exterior dihedral angles between the faces of the exact polyhedron, radians; the
        farther from the origin in hyperbolic and spherical space, the lower.
    flat_edges : int or None
        Edges within polygonal faces: the exact polyhedron may have other diagonals in their place, or none.
    """

    distance: float | None = None
    smallest_dihedral: float | None = None
    flat_edges: int | None = None

    _THEOREMS: ClassVar[str] = f"{Certificate._THEOREMS}; and Alexandrov's theorem (1941)"


def certify(
    metric: PolyhedralMetric, vertices: Floats, length_errors: Floats | None = None
) -> ConvexCertificate:
    """Prove that vertices are those of the convex polyhedron of a metric, up to rounding.

    The theorem and its constants are in the module's documentation.

    Parameters
    ----------
    metric : PolyhedralMetric
        A triangulation of the polyhedron, oriented outward, without flat vertices; and its lengths.
    vertices : ndarray, shape (V, 3)
        In the unit of the lengths.  In hyperbolic and spherical space, as on hyperboloid or sphere, and about
        the origin.
    length_errors : ndarray, shape (E,), optional
        Upper bounds on the errors of the lengths, in their unit: the proof then holds for all metrics within
        them.  By default the lengths are exact.

    Returns
    -------
    ConvexCertificate
    """
    errors = np.zeros(len(metric.lengths)) if length_errors is None else length_errors / metric.unit
    found: dict[str, Any] = {}
    try:
        distance = _prove(metric.normalized, vertices / metric.unit, errors, found) * metric.unit
    except NotProven as obstacle:
        return ConvexCertificate(False, f"not certified, because {obstacle}", **found)
    found["distance"] = distance = float(np.nextafter(distance, np.inf))
    reason = (
        f"certified: the vertices are within {rounded_up(distance)} of those of the convex polyhedron of the "
        f"metric, whose exterior dihedral angles are at least {rounded_down(found['smallest_dihedral'])}"
    )
    return ConvexCertificate(True, reason, **found)


def _prove(metric: PolyhedralMetric, x: Floats, length_errors: Floats, found: dict[str, Any]) -> float:
    """Carry out the proof, in the unit of a normalized metric: return the distance, and note the rest.

    Raises
    ------
    NotProven
    """
    nearby = NearbyRealization.of(metric, x, length_errors, found)
    equations = nearby.equations
    found["kantorovich"], radius = nearby.newton_kantorovich()
    isolation = nearby.isolation(radius) / (GUARD * metric.mean_length)
    straight, off, stretch = equations.straight
    reach = 2 * stretch * (nearby.step + radius) + off
    reach += 4 * U * float(np.abs(straight - straight.mean(axis=0)).max())
    hulls = prove_nearby_hulls(metric.triangulation, straight, reach)
    found["smallest_dihedral"] = float((hulls.dihedrals * equations.dihedral_shares()).min())
    found["flat_edges"] = int(hulls.flat.sum())
    # No edge misses its length by more than twice the farthest, and both of its ends may be as far off.
    farther = 5 * FARTHEST * metric.mean_length + length_errors
    detours = norm(equations.detours(hulls.flat, hulls.slopes, reach, farther))
    found["kantorovich"], radius = nearby.newton_kantorovich(detours)
    distance = nearby.distance(radius, (reach - off) / stretch)
    found |= {"radius": GUARD * distance / metric.mean_length, "isolation": isolation, "embedded": True}
    return distance
