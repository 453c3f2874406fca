"""Generalized convex polytopes: pyramids with a common apex over the triangles of a metric.

Every vertex i has a radius r_i, its distance from the apex.  The pyramids fit together around the apex except
for the curvatures kappa_i = 2 pi - (sum of the dihedral angles at the edge from i to the apex), and form a
convex body if no edge of the triangulation is reflex.  If all kappa_i vanish, the body is the polyhedron.

Notation and formulas: Bobenko and Izmestiev, Alexandrov's theorem, weighted Delaunay triangulations, and
mixed volumes, Annales de l'Institut Fourier 58 (2008).  For half-edge i -> j with third corner k let
``c_ij = (l_ij^2 + r_i^2 - r_j^2) / 2`` be the scalar product of the vectors from i to j and to the apex; d
the distance of the apex from the line ij, as seen along the normal of the plane ijk, and h its height above
that plane.  In hyperbolic and spherical space these are the sines ``sn`` of distances, squared lengths and
radii become squared chords, and ``c_ij = sn(l_ij) sn(r_i) cos(rho_ij)``, by the law of cosines; everything
else is unchanged.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

from isoembed.alexandrov.loops import evaluated, jacobian_product
from isoembed.arrays import Floats
from isoembed.intrinsic.delaunay import make_delaunay
from isoembed.intrinsic.delaunay_loops import non_delaunay_edges
from isoembed.intrinsic.halfedges import HalfEdges
from isoembed.intrinsic.vertex_matrix import vertex_matrix
from isoembed.metric.triangles import Triangles
from isoembed.space import Space


@dataclass(frozen=True, eq=False)
class Polytope:
    """Generalized polytope: triangles, radii, curvatures and their derivatives.

    Attributes
    ----------
    tables : HalfEdges
        Weighted Delaunay triangulation for the squared radii, or triangles with possibly reflex edges.
    radii : ndarray, shape (V,)
    curvatures : ndarray, shape (V,)
        Curvatures kappa.
    coupling : ndarray, shape (3F,)
        Derivatives ``d kappa_i / d r_j`` by half-edge i -> j.
    diagonal : ndarray, shape (V,)
        Part of ``d kappa_i / d r_i`` not due to loops.
    lowest : float
        Smallest squared height of the apex above a triangle, over the squared radius (or sines of these);
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

        Without flips the triangles are unchanged, and edges may be reflex.
        """
        space = Space(tables.curvature)
        if not radii.min() > 0:  # also excludes NaN
            return None
        # The limit is in radii of curvature: hyperbolic sines of longer radii overflow.
        if not radii.max() * space.root < (np.pi if space.curvature > 0 else 100.0):
            return None
        if not flips:
            return cls.on(tables, radii)
        weights, _ = delaunay_weights(space, radii)
        non_delaunay = non_delaunay_edges(tables.views, weights)
        if non_delaunay.size:
            tables = tables.copy()
            _, stuck = make_delaunay(tables, weights, non_delaunay)
            if stuck:
                return None
        return cls.on(tables, radii)

    @classmethod
    def on(cls, tables: HalfEdges, radii: Floats) -> Polytope | None:
        """Construct pyramids over the given triangles; None if one of them does not exist."""
        space, lengths, amplitudes = Space(tables.curvature), tables.lengths, np.empty(0)
        chords = sines = lengths
        r = s = radii
        if not space.is_euclidean:
            triangles = Triangles.of(tables.face_lengths, space.curvature)
            with np.errstate(invalid="ignore"):
                amplitudes = triangles.amplitudes * triangles.unit * triangles.unit
            chords, sines, r, s = space.chord(lengths), space.sn(lengths), space.chord(radii), space.sn(radii)
        kappa, coupling, diagonal, lowest = evaluated(
            tables.corners, tables.twins, chords, sines, amplitudes, r, s, space.curvature / 4
        )
        if not (lowest > 0 and np.isfinite(kappa).all() and np.isfinite(coupling).all()):
            return None
        return cls(tables, radii, kappa, coupling, diagonal, float(lowest))

    @classmethod
    def of_arrays(cls, arrays: Mapping[str, NDArray[Any]], prefix: str = "") -> Polytope | None:
        """Polytope restored from the result of `arrays`."""
        tables = HalfEdges._make(arrays[prefix + name] for name in HalfEdges._fields)
        tables = tables._replace(curvature=float(tables.curvature))
        return cls.on(tables, arrays[f"{prefix}radii"])

    def arrays(self, prefix: str = "") -> dict[str, NDArray[Any]]:
        """Arrays that define the polytope, for a checkpoint: the flipped triangles and the radii."""
        return {
            prefix + name: table for name, table in {**self.tables._asdict(), "radii": self.radii}.items()
        }

    @property
    def space(self) -> Space:
        """Ambient space."""
        return Space(self.tables.curvature)

    def times_jacobian(self, v: Floats) -> Floats:
        """Product ``(d kappa / d r) v`` for v of shape (V,) or (V, n)."""
        tables, columns = self.tables, v.reshape(len(v), -1)
        product = jacobian_product(tables.corners, self.coupling, self.diagonal, columns)
        return product.reshape(v.shape)

    def jacobian(self) -> csc_array:
        """Jacobian ``d kappa / d r`` as a sparse symmetric matrix, (V, V), with its full diagonal."""
        return vertex_matrix(self.tables.corners, self.tables.twins, self.coupling, self.diagonal)


def delaunay_weights(space: Space, radii: Floats) -> tuple[Floats, float]:
    """Weights of the Delaunay triangulation of a polytope: squared radii minus a constant, or their analog.

    In curved space, the polytope is convex where the cosines of the radii, extended to a linear function over
    each triangle, are.  They are scaled by the cosine of a mean radius, so that equal radii have no weight.

    Returns
    -------
    ndarray, float
        Weights, and the cosine by which tilts must be multiplied to undo the scaling.
    """
    mean = float(radii.mean())
    if space.is_euclidean:
        return (radii - mean) * (radii + mean), 1.0
    if space.curvature > 0:  # well below pi / 2, where the cosine vanishes
        mean = min(mean, space.radius)
    cosine = float(space.cs(mean))
    return space.chord(radii - mean) * space.chord(radii + mean) / cosine, cosine
