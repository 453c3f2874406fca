"""Proof that a computed polyhedron is Alexandrov's, within a stated distance.

`prove_nearby_hulls` shows that all points y near the computed vertices span a convex polyhedron whose faces
are the triangles or, where edges may be flat, polygons composed of them.  Draw the edges on its surface: as
edges, or straight through the (unfolded) polygons, with lengths L_ab(y).  The surface, cut along them, is a
gluing of triangles with the combinatorics of the given metric, and equals it if ``G = F + (L^2 - |y_a -
y_b|^2) / (2 l)`` vanishes, with F from `nearby_realization`.  The second term is due to the *detours*.

Theorem. Let rho be an upper bound on |F(z)| plus the norm of the detours at all y near x, and sigma, K, h and
r as in `nearby_realization`.  If all y with |y - z|_s <= r are near x, one of them has G(y) = 0.  It spans a
convex polyhedron with the given metric.  By Alexandrov's theorem (1941) this polyhedron is unique up to
congruence.

Proof. As in `nearby_realization`, for the map ``d -> -S^-1 J^+ (F(z) + Q(d) + detours(z + d))``.

In hyperbolic and spherical space, convexity is that in projective coordinates, which map planes to planes:
these are passed to `prove_nearby_hulls`, with a reach that covers the near points. A path on a roof from a to
b is a convex curve in a plane with the straight line ab, which it meets at angles of at most alpha: at both
ends ``sin(alpha) <= 2 t max(w, 1 / w)^2``, with the slope t and w as in `Space.heights`, because translations
to the origin stretch differently along the radius and across. As perimeters of convex curves are monotonic
under inclusion, the path is no longer than the sides of the isosceles triangle over ab with these angles,
``tn(L / 2) <= tn(l / 2) / cos(alpha)``; and likewise, for links of corners on the unit sphere, all angles of
an unfolded roof are less than pi if alpha < pi / 2. Alexandrov's theorem holds in both spaces (Alexandrov,
Convex polyhedra, 2005; Fillastre, arXiv:1011.3123).

Errors of the lengths enter rho by their norm; the proof then holds for every metric within them.
"""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from isoembed.arrays import Floats
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.proof.certificate import Certificate
from isoembed.proof.nearby_hulls import folds_of_polygons, prove_nearby_hulls
from isoembed.proof.nearby_realization import FARTHEST, NearbyRealization, norm
from isoembed.proof.rounding import GUARD, U
from isoembed.reprs import rounded_down, rounded_up


@dataclass(frozen=True)
class ConvexCertificate(Certificate):
    """Certificate of Alexandrov's polyhedron, with the constants of the proof.

    Constants that the proof did not reach are None.

    Attributes
    ----------
    certified, reason, radius, isolation, embedded, residual, sigma_min, kantorovich
        As of a `Certificate`.  The isolation is among realizations of the same triangles, convex or not.
    distance : float or None
        Bound on the distances of the vertices from the exact ones, after a rigid motion; in the unit of the
        lengths.
    smallest_dihedral : float or None
        Lower bound on the exterior dihedral angles between the faces of the exact polyhedron, radians; in
        hyperbolic and spherical space it decreases with the distance from the origin.
    flat_edges : int or None
        Number of edges within polygonal faces, which are flat up to rounding: the exact polyhedron may be
        bent by as little there, along these or other diagonals.
    """

    distance: float | None = None
    smallest_dihedral: float | None = None
    flat_edges: int | None = None

    _THEOREMS: ClassVar[str] = f"{Certificate._THEOREMS}; and Alexandrov's theorem (1941)"


def certify(
    metric: PolyhedralMetric, vertices: Floats, length_errors: Floats | None = None
) -> ConvexCertificate:
    """Prove that vertices are those of the convex polyhedron of a metric, up to rounding.

    The theorem and its constants are described in the module docstring.

    Parameters
    ----------
    metric : PolyhedralMetric
        Lengths on a triangulation of the polyhedron, oriented outward, without flat vertices.
    vertices : ndarray, shape (V, 3)
        In the unit of the lengths.  In hyperbolic and spherical space, coordinates on the hyperboloid or
        sphere, centered at the origin.
    length_errors : ndarray, shape (E,), optional
        Upper bounds on the errors of the lengths, in their unit: the proof then holds for all metrics within
        them.  By default the lengths are exact.

    Returns
    -------
    ConvexCertificate
    """
    errors = np.zeros(len(metric.lengths)) if length_errors is None else length_errors / metric.unit

    def prove(found: dict[str, Any]) -> str:
        distance = _prove(metric.normalized, vertices / metric.unit, errors, found) * metric.unit
        found["distance"] = distance = float(np.nextafter(distance, np.inf))
        flat = found["flat_edges"]
        within = f", but across {flat} diagonals of polygons that are flat up to rounding" if flat else ""
        return (
            f"the vertices are within {rounded_up(distance)} of those of the convex polyhedron of the "
            f"metric, whose exterior dihedral angles are at least {rounded_down(found['smallest_dihedral'])}"
            f"{within}"
        )

    return ConvexCertificate._of(prove)


def _prove(metric: PolyhedralMetric, x: Floats, length_errors: Floats, found: dict[str, Any]) -> float:
    """Prove for a normalized metric: record constants, return the distance; raises NotProven."""
    nearby = NearbyRealization.of(metric, x, length_errors, found)
    equations = nearby.equations
    found["kantorovich"], radius = nearby.newton_kantorovich()
    isolation = nearby.isolation(radius) / (GUARD * metric.mean_length)
    straight, off, stretch = equations.straight
    reach = 2 * stretch * (nearby.step + radius) + off
    reach += 4 * U * float(np.abs(straight - straight.mean(axis=0)).max())
    hulls = prove_nearby_hulls(metric.triangulation, straight, reach)
    folds = folds_of_polygons(metric, x) & ~hulls.flat
    found["smallest_dihedral"] = float((hulls.dihedrals * equations.dihedral_shares())[folds].min())
    found["flat_edges"] = int((~folds).sum())
    # The length error of an edge is at most twice the largest distance, by which each of its ends may move.
    farther = 5 * FARTHEST * metric.mean_length + length_errors
    detours = norm(equations.detours(hulls.flat, hulls.slopes, reach, farther))
    found["kantorovich"], radius = nearby.newton_kantorovich(detours)
    distance = nearby.distance(radius, (reach - off) / stretch)
    found |= {"radius": GUARD * distance / metric.mean_length, "isolation": isolation, "embedded": True}
    return distance
