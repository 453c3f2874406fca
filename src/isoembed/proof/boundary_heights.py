"""Certificates of discs with prescribed boundary heights, and of convex caps.

The length equations of `nearby_realization` are supplemented by ``z_v = h_v + c`` for the B vertices of the
boundary, with an arbitrary number c: E + B = 3 V - 3 equations, invariant only under horizontal motions.  The
theorem holds unchanged.  The new equations are linear and contribute nothing to Q; and if no horizontal
motion brings y + d nearer to y, ``S^2 d`` is orthogonal to infinitesimal ones, which span the kernel of J.

If all heights are equal, let a polygon close the surface.  If `prove_nearby_hulls` shows that all points near
the given ones span convex polyhedra in which no edge of the surface is flat, then the exact surface is the
boundary of its convex hull without that polygon: the unique convex cap of its metric (Pogorelov; Izmestiev
2008).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from scipy.sparse import csr_array

from isoembed.arrays import Floats, Indices
from isoembed.errors import InvalidMetric
from isoembed.mesh.triangulation import Triangulation
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.proof.certificate import Certificate
from isoembed.proof.double_double import exact_difference
from isoembed.proof.length_equations import NotProven
from isoembed.proof.nearby_hulls import folds_of_polygons, prove_nearby_hulls
from isoembed.proof.nearby_realization import FARTHEST, NearbyRealization
from isoembed.proof.rounding import GUARD, U
from isoembed.reprs import rounded_down, rounded_up
from isoembed.surface.intersection import self_intersections


@dataclass(frozen=True)
class CapCertificate(Certificate):
    """Certificate of an exact surface with given boundary heights, with the constants of the proof.

    Constants that the proof did not reach are None.

    Attributes
    ----------
    certified, reason, radius, isolation, embedded, residual, sigma_min, kantorovich
        As of a `Certificate`.  The isolation is among surfaces with these heights, after a horizontal motion.
    convex : bool or None
        Whether the exact surface is proven to be the convex cap of its metric.
    smallest_dihedral : float or None
        Lower bound on the exterior dihedral angles of a cap's edges, radians.
    """

    convex: bool | None = None
    smallest_dihedral: float | None = None

    _THEOREMS: ClassVar[str] = f"{Certificate._THEOREMS} and heights"

    @property
    def _basis(self) -> str:
        return f"{self._THEOREMS}{'; and the convex cap theorem' if self.convex else ''}"


@dataclass(frozen=True, eq=False)
class HeightEquations:
    """Equations ``z_v = h_v + c``, with c such that the first one holds for the given vertices.

    Attributes
    ----------
    vertices : ndarray of int, shape (B,)
    heights : ndarray, shape (B,)
    points : ndarray, shape (V, 3)
        Given vertices.
    """

    vertices: Indices
    heights: Floats
    points: Floats

    def residuals(self, corrections: Floats) -> tuple[Floats, Floats]:
        """Residuals at the exact sums of points and corrections, and bounds on the rounding, each (B,)."""
        above, remainder = exact_difference(self.points[self.vertices, 2], self.heights)
        off = above - above[0]
        rest = remainder - remainder[0] + corrections[self.vertices, 2]
        sizes = np.abs(off) + np.abs(remainder) + np.abs(remainder[0]) + np.abs(corrections[self.vertices, 2])
        return off + rest, 4 * GUARD * U * sizes

    def matrix(self, weights: Floats) -> csr_array:
        """Jacobian divided by the weights of the vertices, (B, 3 V)."""
        count = len(self.vertices)
        columns = 3 * self.vertices.astype(np.int64) + 2
        entries = 1 / weights[self.vertices]
        return csr_array((entries, columns, np.arange(count + 1)), shape=(count, self.points.size))


def certify(metric: PolyhedralMetric, vertices: Floats, heights: Floats) -> CapCertificate:
    """Prove that exactly one disc with these lengths and boundary heights is near the vertices.

    Parameters
    ----------
    metric : PolyhedralMetric
        Flat triangles of a disc.
    vertices : ndarray, shape (V, 3)
        In the unit of the lengths.
    heights : ndarray, shape (B,)
        z coordinates of the vertices along the boundary, up to a constant; zero for a cap.

    Returns
    -------
    CapCertificate

    Raises
    ------
    InvalidMetric
        The surface is not a disc in R^3.
    """
    t = metric.triangulation
    if t.euler_characteristic != 1 or len(t.boundaries) != 1 or not metric.space.is_euclidean:
        raise InvalidMetric("heights of a boundary are certified for discs in R^3 only")

    def prove(found: dict[str, Any]) -> str:
        added = _prove(metric.normalized, vertices / metric.unit, heights / metric.unit, found)
        where = "at these heights" if np.ptp(heights) else "in a plane"
        return (
            f"a surface with these lengths and its boundary {where} is within {rounded_up(found['radius'])} "
            f"mean edge lengths of the vertices, and any other at least {rounded_down(found['isolation'])} "
            f"from it; {added}"
        )

    return CapCertificate._of(prove)


def _prove(metric: PolyhedralMetric, x: Floats, heights: Floats, found: dict[str, Any]) -> str:
    """Prove for a normalized metric: record constants, return further conclusions; raises NotProven."""
    t = metric.triangulation
    [loop] = t.boundaries
    equations = HeightEquations(loop, heights, x)
    residuals = np.abs(equations.residuals(np.zeros_like(x))[0])
    if not (residuals <= 2 * FARTHEST * metric.mean_length).all():
        v = int(np.argmax(residuals))
        raise NotProven(
            f"vertex {loop[v]} of the boundary misses its height over vertex {loop[0]} by "
            f"{residuals[v] / metric.mean_length:.1e} mean edge lengths"
        )
    nearby = NearbyRealization.of(metric, x, np.zeros(t.n_edges), found, equations)
    found["kantorovich"], radius = nearby.newton_kantorovich()
    found["radius"] = GUARD * nearby.distance(radius) / metric.mean_length
    found["isolation"] = nearby.isolation(radius) / (GUARD * metric.mean_length)
    convex = ""
    if not np.ptp(heights):
        try:
            found["smallest_dihedral"] = _smallest_dihedral(metric, x, nearby.reach(radius))
            found["convex"] = found["embedded"] = True
            return (
                "it is the convex cap, whose exterior dihedral angles are at least "
                f"{rounded_down(found['smallest_dihedral'])}"
            )
        except NotProven as obstacle:
            convex = f"it is not proven to be convex, because {obstacle}; "
    pairs = self_intersections(metric.faces, x, nearby.reach(radius))
    found["embedded"] = len(pairs) == 0
    return convex + (f"faces {pairs[0].tolist()} cross, or may" if len(pairs) else "its faces do not cross")


def _smallest_dihedral(metric: PolyhedralMetric, x: Floats, reach: float) -> float:
    """Lower bound on the dihedral angles inside a convex cap near points; raises NotProven if not convex.

    Of a flat cap, it is that across all edges.
    """
    t = metric.triangulation
    [loop] = t.boundaries
    a, b = x[loop, :2], np.roll(x[loop, :2], -1, axis=0)
    is_upward = np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) > 0  # as seen from above
    inside = ~t.boundary_edges
    joined = t.boundary_vertices[t.edges].all(axis=1) & inside
    chords = np.bincount(t.edges[joined].ravel(), minlength=t.n_vertices)[loop]
    around = np.roll(loop, -int(np.argmin(chords)))  # chords do not cross, so some vertex has none
    fan = np.column_stack([np.full(len(loop) - 2, around[0]), around[2:], around[1:-1]])
    faces = np.concatenate([t.faces, fan])
    closed = Triangulation(faces if is_upward else faces[:, ::-1])
    hulls = prove_nearby_hulls(closed, x, reach)
    own = closed.edge_indices(t.edges[inside])
    flat = hulls.flat[own]
    if flat.any():
        e = np.flatnonzero(inside)[np.argmax(flat)]
        raise NotProven(f"edge {e} {t.edges[e].tolist()} may be flat")
    folds = folds_of_polygons(metric, x)[inside]
    return float(hulls.dihedrals[own][folds | ~folds.any()].min())
