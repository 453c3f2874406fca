"""The generalized convex polytope: pyramids over the triangles with a common apex, glued face to face.

Every vertex i has a radius r_i, its distance from the apex.  The pyramids fit around the apex except for the
curvatures kappa_i = 2 pi - (sum of the dihedral angles at the edge from i to the apex), and bound a convex
body if no edge of the triangulation is reflex.  When all kappa_i vanish, the body is the polyhedron.

Notation and formulas: Bobenko and Izmestiev, Alexandrov's theorem, weighted Delaunay triangulations, and
mixed volumes, Annales de l'Institut Fourier 58 (2008).  For half-edge i -> j with third corner k let
``c_ij = (l_ij^2 + r_i^2 - r_j^2) / 2`` be the product of the vectors from i to j and to the apex; d the
distance of the apex from the line ij, seen along the normal of the plane ijk, and h its height above that
plane.  In hyperbolic and spherical space these are the sines ``sn`` of distances, lengths and radii that are
squared are chords, and ``c_ij = sn(l_ij) sn(r_i) cos(rho_ij)``, by the law of cosines; all else is the same.
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
from isoembed.intrinsic.vertex_matrix import vertex_matrix
from isoembed.kernel import kernel
from isoembed.metric.curvature import Triangles
from isoembed.space import Space
from isoembed.space.trigonometry import twice_area


@dataclass(frozen=True, eq=False)
class Polytope:
    """A generalized polytope: its triangles, radii, and what follows from them.

    Attributes
    ----------
    tables : HalfEdges
        A weighted Delaunay triangulation for the squared radii, or triangles with edges that may be reflex.
    radii : ndarray, shape (V,)
    curvatures : ndarray, shape (V,)
        kappa.
    coupling : ndarray, shape (3F,)
        ``d kappa_i / d r_j`` by half-edge i -> j.
    diagonal : ndarray, shape (V,)
        The part of ``d kappa_i / d r_i`` that does not come from loops.
    lowest : float
        The least squared height of the apex above a triangle, over the squared radius, or sines of these;
        positive.
    """

    tables: HalfEdges
    radii: Floats
    curvatures: Floats
    coupling: Floats
    diagonal: Floats
    lowest: float

    @classmethod
    def over(cls, tables: HalfEdges, radii: Floats, *, flips: bool = True) -> Polytope | None:
        """Flip a copy of the triangles until no edge is reflex; None if no polytope has these radii.

        Without flips the triangles stay as they are, and any edges of theirs may be reflex.
        """
        space = Space(tables.curvature)
        if not radii.min() > 0:  # not a number is no radius either
            return None
        # Radii of curvature: hyperbolic sines of longer radii overflow.
        if not radii.max() * space.root < (np.pi if space.curvature > 0 else 100.0):
            return None
        if not flips:
            return cls.on(tables, radii)
        weights, _ = delaunay_weights(space, radii)
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
        space, lengths, amplitudes = Space(tables.curvature), tables.lengths, np.empty(0)
        chords = sines = lengths
        r = s = radii
        if not space.is_euclidean:
            triangles = Triangles.of(tables.face_lengths, space.curvature)
            with np.errstate(invalid="ignore"):
                amplitudes = triangles.amplitudes * triangles.unit * triangles.unit
            chords, sines, r, s = space.chord(lengths), space.sn(lengths), space.chord(radii), space.sn(radii)
        kappa, coupling, diagonal, lowest = _evaluate(
            tables.corners, tables.twins, chords, sines, amplitudes, r, s, space.curvature / 4
        )
        if not (lowest > 0 and np.isfinite(kappa).all() and np.isfinite(coupling).all()):
            return None
        return cls(tables, radii, kappa, coupling, diagonal, float(lowest))

    @classmethod
    def of_arrays(cls, arrays: Mapping[str, NDArray[Any]], prefix: str = "") -> Polytope | None:
        """The polytope of what `arrays` gave."""
        tables = HalfEdges._make(arrays[prefix + name] for name in HalfEdges._fields)
        tables = tables._replace(curvature=float(tables.curvature))
        return cls.on(tables, arrays[f"{prefix}radii"])

    def arrays(self, prefix: str = "") -> dict[str, NDArray[Any]]:
        """What defines it, for a checkpoint: the triangles as they were flipped, and the radii."""
        return {
            prefix + name: table for name, table in {**self.tables._asdict(), "radii": self.radii}.items()
        }

    @property
    def space(self) -> Space:
        """The space that it is in."""
        return Space(self.tables.curvature)

    def times_jacobian(self, v: Floats) -> Floats:
        """``(d kappa / d r) v`` for v of shape (V,) or (V, n)."""
        tables, columns = self.tables, v.reshape(len(v), -1)
        product = _product(tables.corners, self.coupling, self.diagonal, columns)
        return product.reshape(v.shape)

    def jacobian(self) -> csc_array:
        """``d kappa / d r`` as a sparse matrix, (V, V), symmetric, with its whole diagonal."""
        return vertex_matrix(self.tables.corners, self.tables.twins, self.coupling, self.diagonal)


def delaunay_weights(space: Space, radii: Floats) -> tuple[Floats, float]:
    """Weights of the Delaunay triangulation of a polytope: squared radii less a constant, or the like.

    The polytope is convex where the cosines of the radii, extended to a linear function over each triangle,
    are.  Such functions may be scaled: by the cosine of a mean radius, so that equal radii have no weight.

    Returns
    -------
    ndarray, float
        The weights; and the cosine by which tilts of this scale are to be multiplied.
    """
    mean = float(radii.mean())
    if space.is_euclidean:
        return (radii - mean) * (radii + mean), 1.0
    if space.curvature > 0:  # and well below pi / 2, where the cosine vanishes
        mean = min(mean, space.radius)
    cosine = float(space.cs(mean))
    return space.chord(radii - mean) * space.chord(radii + mean) / cosine, cosine


@kernel
def _evaluate(
    corners: Indices,
    twins: Indices,
    chords: Floats,
    sines: Floats,
    amplitudes: Floats,
    r: Floats,
    s: Floats,
    k4: float,
) -> tuple[Floats, Floats, Floats, float]:
    # Chords and sines of lengths and of radii, r and s; amplitudes of triangles, none in R^3; and k / 4.
    # The dihedral angles at a radius are turns of a unit vector, (x, y), and only their sum is taken: one arc
    # tangent a vertex, and where it is near a full turn nothing cancels.
    n = r.size
    x, y, full = np.ones(n), np.zeros(n), np.ones(n)  # full turns that are left
    kappa = np.empty(n)
    slope = np.empty(corners.size)  # d / h
    diagonal = np.zeros(n)
    lowest = np.inf
    for f in range(0, corners.size, 3):
        i, j, m = corners[f], corners[f + 1], corners[f + 2]
        a, b, c = chords[f], chords[f + 1], chords[f + 2]  # ij, jm, mi
        area = amplitudes[f // 3] if amplitudes.size else twice_area(a, b, c)
        if not area > 0:
            return kappa, slope, diagonal, -1.0
        # Differences of squares, formed before they cancel.
        ij = (r[i] - r[j]) * (r[i] + r[j])
        jm = (r[j] - r[m]) * (r[j] + r[m])
        mi = (r[m] - r[i]) * (r[m] + r[i])
        # Products of two sines and the cosine between, by chords: (a^2 + b^2 - c^2) / 2 - k a^2 b^2 / 4.
        ri, rj, rm = r[i] * r[i], r[j] * r[j], r[m] * r[m]
        aa, bb, cc = k4 * (a * a), k4 * (b * b), k4 * (c * c)
        c_ij, c_ji = (a * a + ij) / 2 - aa * ri, (a * a - ij) / 2 - aa * rj
        c_jm, c_mj = (b * b + jm) / 2 - bb * rj, (b * b - jm) / 2 - bb * rm
        c_mi, c_im = (c * c + mi) / 2 - cc * rm, (c * c - mi) / 2 - cc * ri
        at_i = (a * a + (c - b) * (c + b)) / 2 - aa * (c * c)  # at a corner
        at_j = (b * b + (a - c) * (a + c)) / 2 - bb * (a * a)
        at_m = (c * c + (b - a) * (b + a)) / 2 - cc * (b * b)
        a, b, c = sines[f], sines[f + 1], sines[f + 2]
        d_ij = (a * c_im - c_ij * at_i / a) / area
        d_jm = (b * c_ji - c_jm * at_j / b) / area
        d_mi = (c * c_mj - c_mi * at_m / c) / area
        # The squared height, from the corner where least is subtracted.
        qi, qj, qm = s[i] * s[i], s[j] * s[j], s[m] * s[m]
        if qi <= qj and qi <= qm:
            h2, q = qi - c_ij / a * (c_ij / a) - d_ij * d_ij, qi
        elif qj <= qm:
            h2, q = qj - c_jm / b * (c_jm / b) - d_jm * d_jm, qj
        else:
            h2, q = qm - c_mi / c * (c_mi / c) - d_mi * d_mi, qm
        lowest = min(lowest, h2 / q)
        if not h2 > 0:
            return kappa, slope, diagonal, lowest
        h = np.sqrt(h2)
        _turn(i, qi * at_i - c_ij * c_im, s[i] * h * area, x, y, full)
        _turn(j, qj * at_j - c_jm * c_ji, s[j] * h * area, x, y, full)
        _turn(m, qm * at_m - c_mi * c_mj, s[m] * h * area, x, y, full)
        slope[f], slope[f + 1], slope[f + 2] = d_ij / h, d_jm / h, d_mi / h
    for i in range(n):
        kappa[i] = 2 * np.pi * full[i] - math.atan2(y[i], x[i])
    # The half-edges below their twins, without a branch that is hard to foresee.
    lower, count = np.empty(corners.size // 2 + 1, dtype=np.int64), 0
    for e in range(corners.size):
        lower[count] = e
        count += int(e < twins[e])
    for e in lower[:count]:
        t = twins[e]
        i, j = corners[e], corners[t]
        a, l = chords[e], sines[e]
        c_ij = (a * a + (r[i] - r[j]) * (r[i] + r[j])) / 2 - k4 * (a * a) * (r[i] * r[i])
        w = (slope[e] + slope[t]) / (l * (s[i] * s[i] - c_ij / l * (c_ij / l)))
        slope[e] = slope[t] = w * s[i] * s[j]
        # the product of the vectors from the apex to i and j
        both = w * (s[i] * s[i] * (1 - 2 * k4 * (a * a)) - c_ij * (1 - 2 * k4 * (r[i] * r[i])))
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
