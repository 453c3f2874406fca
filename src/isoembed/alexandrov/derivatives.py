"""Derivatives of the convex polyhedron of a metric in R^3 with respect to the lengths.

A given edge is a geodesic path on the polyhedron, whose length depends on those of the polyhedron's edges
(`path_derivatives`); solving for the latter gives the effect of intrinsic flips on changes of the lengths.
The derivatives of the vertices follow from the rigidity matrix J.

A vertex inside a face is flat, and may move normal to the face without changing lengths to first order.  A
change that gives it a positive deficit lifts it by the square root of the deficit, and with a negative one
there is no convex polyhedron: derivatives exist only along changes that keep it flat.  Along these it stays
in its face,

    [ J  W ] [ dx ]   [ dl ]
    [ N  0 ] [  0 ] = [ 0  ],

where the columns of W are the derivatives of the deficits of such vertices, which are orthogonal to all J dx,
and the rows of N keep a vertex in the plane of three corners of its face.  Six more rows fix the rigid
motions.  Faces with more corners may break along a diagonal that depends on the sign of the change; to first
order this does not affect the lengths, but it does affect vertices inside.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import SuperLU

from isoembed.arrays import Floats, Indices, Mask
from isoembed.embedding.polyhedron import Polyhedron
from isoembed.errors import InvalidParameter
from isoembed.intrinsic.edge_paths import EdgePaths
from isoembed.intrinsic.path_derivatives import path_derivatives
from isoembed.linalg.superlu import checked_lu
from isoembed.metric.variation import deficit_derivative
from isoembed.surface.projected import Projected
from isoembed.surface.rigidity import edge_rows

ROUNDING = 1e-7  # relative normal velocity of a corner of a face attributed to rounding


@dataclass(frozen=True, eq=False)
class GivenLengthDerivatives:
    """Derivatives of a convex polyhedron in R^3 with respect to the given lengths, in the normalized unit.

    Attributes
    ----------
    flat : ndarray of int
        Flat vertices.
    inside : ndarray of int
        Flat vertices inside faces.
    """

    flat: Indices
    inside: Indices
    _paths: SuperLU  # derivatives of given lengths by own ones
    _motion: SuperLU
    _deficits: sp.csr_array  # derivatives at the flat vertices by own lengths
    _planes: sp.csr_array  # (k, 3V): heights of those inside over three corners of their faces
    _faces: sp.csr_array  # heights of the other corners over these three, (m, 3V)
    _broken: Indices  # the vertex inside that requires each of these
    _rigid: Floats

    @classmethod
    def of(cls, body: Polyhedron, paths: EdgePaths, flat: Mask) -> GivenLengthDerivatives:
        """Factor the matrices.

        Parameters
        ----------
        body : Polyhedron
        paths : EdgePaths
            Paths of the given edges on its triangles.
        flat : ndarray of bool, shape (V,)

        Raises
        ------
        InvalidParameter
            The polyhedron is not in R^3, or its number of edges differs from that of the given ones.
        SingularMatrix
            The polyhedron is too thin for floats.
        """
        metric, t = body.metric.normalized, body.triangulation
        if not metric.space.is_euclidean:
            raise InvalidParameter(
                f"derivatives by given lengths need polyhedra in R^3, not in {body.space!r}"
            )
        if len(paths.ends) != t.n_edges:
            raise InvalidParameter(f"{len(paths.ends)} edges were given, and the polyhedron has {t.n_edges}")
        by_half_edge = path_derivatives(paths).tocoo()
        edges = t.face_edges.ravel()[by_half_edge.col]
        A = sp.csc_array((by_half_edge.data, (by_half_edge.row, edges)), shape=(t.n_edges, t.n_edges))

        x = body.vertices / body.metric.unit
        creased = np.zeros(len(x), dtype=np.bool_)
        creased[t.edges[body.surface.flat_faces.edges]] = True
        inside = np.flatnonzero(flat & ~creased)
        planes, faces, broken = _planes(body, x, flat, inside)
        J = _matrix(t.edges, edge_rows(t, x, metric.lengths), len(x))
        slopes = deficit_derivative(metric)
        W = slopes[inside].T
        pins = _pins(x)
        M = sp.block_array([[J, W], [planes, None], [pins, None]], format="csc")
        return cls(
            np.flatnonzero(flat),
            inside,
            checked_lu(A, "COLAMD"),
            checked_lu(M, "COLAMD"),
            slopes[flat],
            planes,
            faces,
            broken,
            Projected.of(metric.space, x).isometries(),
        )

    @property
    def n_given(self) -> int:
        """Number of given lengths."""
        return int(self._paths.shape[0])

    def own_changes(self, changes: Floats) -> Floats:
        """Changes of the lengths of the polyhedron's edges, (E,), from those of the given ones, (E,)."""
        return np.asarray(self._paths.solve(changes))

    def jvp(self, changes: Floats) -> Floats:
        """Derivative of the vertices, (V, 3), along a change dl of the given lengths, (E,).

        Raises
        ------
        InvalidParameter
            A flat vertex does not remain flat, or its face breaks.
        """
        dl = self.own_changes(changes)
        rates, sizes = self._deficits @ dl, abs(self._deficits) @ np.abs(dl)
        bent = np.abs(rates) > 1e-7 * sizes  # smaller relative changes of the angle are rounding errors
        if bent.any():
            k = int(np.argmax(bent))
            raise InvalidParameter(
                f"the changes give vertex {self.flat[k]}, which is flat, a deficit at the rate "
                f"{rates[k]:.3g}: the polyhedron is differentiable only in the square root of such a "
                "change, and on one side only"
            )
        right = np.zeros(self._motion.shape[0])
        right[: len(dl)] = dl
        dx = self._motion.solve(right)[: self._planes.shape[1]]
        dx -= self._rigid @ (self._rigid.T @ dx)
        off = np.abs(self._faces @ dx)
        if (off > ROUNDING * np.abs(dx).max(initial=0.0)).any():
            raise self._one_sided(int(np.argmax(off)))
        return dx.reshape(-1, 3)

    def vjp(self, gradient: Floats) -> Floats:
        """Derivatives with respect to the given lengths, (E,), from those by the vertices, (V, 3).

        They are valid along changes that keep flat vertices flat.

        Raises
        ------
        InvalidParameter
            The gradient has a normal component at a vertex inside a face that may break.
        """
        g = gradient.ravel() - self._rigid @ (self._rigid.T @ gradient.ravel())
        for k, v in enumerate(self._broken):
            normal = self._planes[[int(np.searchsorted(self.inside, v))]].toarray()[0, 3 * v : 3 * v + 3]
            if abs(normal @ g[3 * v : 3 * v + 3]) > ROUNDING * np.linalg.norm(g):
                raise self._one_sided(k)
        right = np.zeros(self._motion.shape[0])
        right[: g.size] = g
        by_own = self._motion.solve(right, trans="T")[: self._deficits.shape[1]]
        return np.asarray(self._paths.solve(by_own, trans="T"))

    def _one_sided(self, k: int) -> InvalidParameter:
        return InvalidParameter(
            f"vertex {self._broken[k]} is inside a face with more than three corners, which may break: "
            "it has derivatives on one side only"
        )


def _planes(
    body: Polyhedron, x: Floats, flat: Mask, inside: Indices
) -> tuple[sp.csr_array, sp.csr_array, Indices]:
    """Rows (., 3V) of heights over three corners of faces: of vertices inside, and of other corners.

    Also returns the vertex inside for each of the other corners.
    """
    t = body.triangulation
    face_of = np.zeros(len(x), dtype=np.int64)
    face_of[t.faces.ravel()] = np.repeat(body.surface.flat_faces.of_triangles, 3)
    heights, others, broken = [], [], []
    for v in inside:
        outline = np.asarray(body.polygons[face_of[v]])
        corners = outline[~flat[outline]]
        a, b, c = three = _spread(x[corners])
        normal = np.cross(x[corners[b]] - x[corners[a]], x[corners[c]] - x[corners[a]])
        normal /= np.linalg.norm(normal)
        heights.append(_height(v, corners[three], x, normal))
        for corner in np.delete(corners, three):
            others.append(_height(corner, corners[three], x, normal))
            broken.append(v)
    empty = sp.csr_array((0, x.size))
    rows = [sp.csr_array(sp.vstack([empty, *each])) for each in (heights, others)]
    return rows[0], rows[1], np.array(broken, dtype=np.int64)


def _height(v: int, corners: Indices, x: Floats, normal: Floats) -> sp.csr_array:
    """Row (1, 3V) of the (zero) height of a vertex over the plane through three corners."""
    system = np.vstack([x[corners].T - x[v][:, None] + normal[:, None], np.ones(3)])
    shares = np.linalg.lstsq(system, np.append(normal, 1.0), rcond=None)[0]
    vertices, weights = np.append(v, corners), np.append(1.0, -shares)
    columns = (3 * vertices[:, None] + np.arange(3)).ravel()
    return sp.csr_array(
        ((weights[:, None] * normal).ravel(), (np.zeros(12, dtype=np.int64), columns)), shape=(1, x.size)
    )


def _spread(points: Floats) -> list[int]:
    """Indices of three points far from collinear."""
    a = int(np.argmax(np.linalg.norm(points - points.mean(axis=0), axis=1)))
    b = int(np.argmax(np.linalg.norm(points - points[a], axis=1)))
    along = (points[b] - points[a]) / np.linalg.norm(points[b] - points[a])
    c = int(np.argmax(np.linalg.norm(np.cross(points - points[a], along), axis=1)))
    return [a, b, c]


def _matrix(edges: Indices, rows: Floats, n: int) -> sp.csr_array:
    """Rigidity matrix J, (E, 3V)."""
    columns = (3 * edges[:, :, None] + np.arange(3)).ravel()
    entries = np.stack([rows, -rows], axis=1).ravel()
    return sp.csr_array((entries, columns, np.arange(0, columns.size + 1, 6)), shape=(len(edges), 3 * n))


def _pins(x: Floats) -> sp.csr_array:
    """Rows (6, 3V) that fix the first of three vertices, the second to a line, and the third to a plane."""
    a, b, c = _spread(x)
    along = x[b] - x[a]
    up = np.cross(along, x[c] - x[a])
    rows = np.zeros((6, 3, 3))
    rows[:3, 0] = np.eye(3)
    rows[3, 1], rows[4, 1], rows[5, 2] = up, np.cross(up, along), up
    rows /= np.linalg.norm(rows, axis=(1, 2))[:, None, None]
    columns = (3 * np.array([a, b, c])[:, None] + np.arange(3)).ravel()
    place = np.repeat(np.arange(6), 9), np.tile(columns, 6)
    return sp.csr_array((rows.ravel(), place), shape=(6, x.size))
