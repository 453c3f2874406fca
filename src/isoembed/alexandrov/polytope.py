"""The generalized convex polytope: pyramids over the triangles with a common apex, glued face to face.

Every vertex i has a radius r_i, its distance from the apex.  The pyramids fit around the apex except for the
curvatures kappa_i = 2 pi - (sum of the dihedral angles at the edge from i to the apex), and bound a convex
body if no edge of the triangulation is reflex.  When all kappa_i vanish, the body is the polyhedron.

Notation and formulas: Bobenko and Izmestiev, Alexandrov's theorem, weighted Delaunay triangulations, and
mixed volumes, Annales de l'Institut Fourier 58 (2008).  For half-edge i -> j with third corner k let
``c_ij = (l_ij^2 + r_i^2 - r_j^2) / 2`` be the product of the vectors from i to j and to the apex; d the
distance of the apex from the line ij, seen along the normal of the plane ijk, and h its height above that
plane.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

from isoembed.arrays import Floats, Indices
from isoembed.intrinsic.delaunay import make_delaunay, non_delaunay_edges
from isoembed.intrinsic.halfedges import HalfEdges
from isoembed.intrinsic.trigonometry import twice_area
from isoembed.intrinsic.vertex_matrix import vertex_matrix
from isoembed.kernel import kernel


@dataclass(frozen=True, eq=False)
class Polytope:
    """A generalized polytope: its triangles, radii, and what follows from them.

    Attributes
    ----------
    tables : HalfEdges
        A weighted Delaunay triangulation for the squared radii.
    radii : ndarray, shape (V,)
    curvatures : ndarray, shape (V,)
        kappa.
    coupling : ndarray, shape (3F,)
        ``d kappa_i / d r_j`` by half-edge i -> j.
    diagonal : ndarray, shape (V,)
        The part of ``d kappa_i / d r_i`` that does not come from loops.
    lowest : float
        The least squared height of the apex above a triangle, over the squared radius; positive.
    """

    tables: HalfEdges
    radii: Floats
    curvatures: Floats
    coupling: Floats
    diagonal: Floats
    lowest: float

    @classmethod
    def over(cls, tables: HalfEdges, radii: Floats) -> Polytope | None:
        """Flip a copy of the triangles until no edge is reflex; None if no polytope has these radii."""
        if not radii.min() > 0:  # not a number is no radius either
            return None
        mean = float(radii.mean())
        weights = (radii - mean) * (radii + mean)
        non_delaunay = non_delaunay_edges(tables, weights)
        if non_delaunay.size:
            tables = tables.copy()
            _, stuck = make_delaunay(tables, weights, non_delaunay)
            if stuck:
                return None
        return cls.on(tables, radii)

    @classmethod
    def on(cls, tables: HalfEdges, radii: Floats) -> Polytope | None:
        """Put pyramids over the triangles as they are; None if one of them does not exist."""
        kappa, coupling, diagonal, lowest = _evaluate(tables.corners, tables.twins, tables.lengths, radii)
        if not (lowest > 0 and np.isfinite(kappa).all() and np.isfinite(coupling).all()):
            return None
        return cls(tables, radii, kappa, coupling, diagonal, float(lowest))

    @classmethod
    def of_arrays(cls, arrays: Mapping[str, NDArray[Any]], prefix: str = "") -> Polytope | None:
        """The polytope of what `arrays` gave."""
        tables = HalfEdges._make(arrays[prefix + name] for name in HalfEdges._fields)
        return cls.on(tables, arrays[f"{prefix}radii"])

    def arrays(self, prefix: str = "") -> dict[str, NDArray[Any]]:
        """What defines it, for a checkpoint: the triangles as they were flipped, and the radii."""
        return {
            prefix + name: table for name, table in {**self.tables._asdict(), "radii": self.radii}.items()
        }

    def times_jacobian(self, v: Floats) -> Floats:
        """``(d kappa / d r) v`` for v of shape (V,) or (V, n)."""
        tables, columns = self.tables, v.reshape(len(v), -1)
        product = _product(tables.corners, self.coupling, self.diagonal, columns)
        return product.reshape(v.shape)

    def jacobian(self) -> csc_array:
        """``d kappa / d r`` as a sparse matrix, (V, V), symmetric, with its whole diagonal."""
        return vertex_matrix(self.tables.corners, self.tables.twins, self.coupling, self.diagonal)


@kernel
def _evaluate(
    corners: Indices, twins: Indices, lengths: Floats, r: Floats
) -> tuple[Floats, Floats, Floats, float]:
    # The dihedral angles at a radius are turns of a unit vector, (x, y), and only their sum is taken: one arc
    # tangent a vertex, and where it is near a full turn nothing cancels.
    n = r.size
    x, y, full = np.ones(n), np.zeros(n), np.ones(n)  # full turns that are left
    kappa = np.empty(n)
    slope = np.empty(corners.size)  # d / h
    diagonal = np.zeros(n)
    lowest = np.inf
    for f in range(0, corners.size, 3):
        i, j, k = corners[f], corners[f + 1], corners[f + 2]
        a, b, c = lengths[f], lengths[f + 1], lengths[f + 2]  # ij, jk, ki
        qi, qj, qk = r[i] * r[i], r[j] * r[j], r[k] * r[k]
        # Differences of squares, formed before they cancel.
        ij = (r[i] - r[j]) * (r[i] + r[j])
        jk = (r[j] - r[k]) * (r[j] + r[k])
        ki = (r[k] - r[i]) * (r[k] + r[i])
        area = twice_area(a, b, c)
        if area <= 0:
            return kappa, slope, diagonal, -1.0
        c_ij, c_ji = (a * a + ij) / 2, (a * a - ij) / 2
        c_jk, c_kj = (b * b + jk) / 2, (b * b - jk) / 2
        c_ki, c_ik = (c * c + ki) / 2, (c * c - ki) / 2
        at_i = (a * a + (c - b) * (c + b)) / 2  # products of the two sides at a corner
        at_j = (b * b + (a - c) * (a + c)) / 2
        at_k = (c * c + (b - a) * (b + a)) / 2
        d_ij = (a * c_ik - c_ij * at_i / a) / area
        d_jk = (b * c_ji - c_jk * at_j / b) / area
        d_ki = (c * c_kj - c_ki * at_k / c) / area
        # The squared height, from the corner where least is subtracted.
        if qi <= qj and qi <= qk:
            h2, q = qi - c_ij / a * (c_ij / a) - d_ij * d_ij, qi
        elif qj <= qk:
            h2, q = qj - c_jk / b * (c_jk / b) - d_jk * d_jk, qj
        else:
            h2, q = qk - c_ki / c * (c_ki / c) - d_ki * d_ki, qk
        lowest = min(lowest, h2 / q)
        if not h2 > 0:
            return kappa, slope, diagonal, lowest
        h = np.sqrt(h2)
        _turn(i, qi * at_i - c_ij * c_ik, r[i] * h * area, x, y, full)
        _turn(j, qj * at_j - c_jk * c_ji, r[j] * h * area, x, y, full)
        _turn(k, qk * at_k - c_ki * c_kj, r[k] * h * area, x, y, full)
        slope[f], slope[f + 1], slope[f + 2] = d_ij / h, d_jk / h, d_ki / h
    for i in range(n):
        kappa[i] = 2 * np.pi * full[i] - math.atan2(y[i], x[i])
    lower, count = (
        np.empty(corners.size // 2 + 1, dtype=np.int64),
        0,
    )  # without a branch that is hard to foresee
    for e in range(corners.size):
        lower[count] = e
        count += int(e < twins[e])
    for e in lower[:count]:
        t = twins[e]
        i, j = corners[e], corners[t]
        l = lengths[e]
        c_ij = (l * l + (r[i] - r[j]) * (r[i] + r[j])) / 2
        w = (slope[e] + slope[t]) / (l * (r[i] * r[i] - c_ij / l * (c_ij / l)))
        slope[e] = slope[t] = w * r[i] * r[j]
        both = w * (r[i] * r[i] - c_ij)  # the product of the vectors from the apex to i and j
        diagonal[i] -= both
        diagonal[j] -= both
    return kappa, slope, diagonal, lowest


@kernel
def _turn(i: int, cosine: float, sine: float, x: Floats, y: Floats, full: Floats) -> None:
    """Turn the vector of vertex i by the angle of these, whatever their size: by less than half a turn."""
    size = np.sqrt(cosine * cosine + sine * sine)
    c, s = cosine / size, sine / size
    before = y[i]
    x[i], y[i] = x[i] * c - before * s, x[i] * s + before * c
    full[i] -= int(before >= 0 > y[i])


@kernel
def _product(corners: Indices, coupling: Floats, diagonal: Floats, v: Floats) -> Floats:
    result = np.empty_like(v)
    for i in range(v.shape[0]):
        for c in range(v.shape[1]):
            result[i, c] = diagonal[i] * v[i, c]
    for f in range(0, corners.size, 3):  # every edge from both its faces, for one end each
        i, j, k = corners[f], corners[f + 1], corners[f + 2]
        for c in range(v.shape[1]):
            result[i, c] += coupling[f] * v[j, c]
            result[j, c] += coupling[f + 1] * v[k, c]
            result[k, c] += coupling[f + 2] * v[i, c]
    return result
