"""The half-edge structure of a triangulated surface without coordinates, which flips change in place.

Half-edge ``h = 3 f + c`` leaves corner c of face f and is followed by the next corner's.  Nothing asks two
triangles to meet in one edge only: loops, repeated edges and triangles glued to themselves are triangles like
any others.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.intrinsic.chart import toward
from isoembed.intrinsic.trigonometry import from_frame, norm
from isoembed.kernel import kernel
from isoembed.space.trigonometry import angle_between, apex, cs


class HalfEdges(NamedTuple):
    """Triangles as tables over their half-edges; compiled functions take it whole.

    Attributes
    ----------
    corners : ndarray of int64, shape (3F,)
        The vertex that each half-edge leaves.
    twins : ndarray of int64, shape (3F,)
        The half-edge that it is glued to.
    lengths : ndarray, shape (3F,)
    directions : ndarray, shape (3F,)
        The angle at which it leaves its vertex, counterclockwise from a direction that flips do not change
        and modulo the total angle there (a "signpost": Sharp, Soliman and Crane, Navigating intrinsic
        triangulations, ACM TOG 38, 2019).  Empty where nobody asks for them.
    curvature : float
        That of the triangles; lengths are measured along their sides.
    """

    corners: Indices
    twins: Indices
    lengths: Floats
    directions: Floats
    curvature: float = 0.0

    @classmethod
    def of(cls, faces: Indices, twins: Indices, face_lengths: Floats, curvature: float = 0.0) -> HalfEdges:
        """Copy the triangles of a metric and give every half-edge its direction.

        Parameters
        ----------
        faces : ndarray of int, shape (F, 3)
        twins : ndarray of int, shape (3F,)
        face_lengths : ndarray, shape (F, 3)
            Length of each half-edge.
        curvature : float
            That of the triangles.
        """
        mesh = cls.without_directions(faces, twins, face_lengths, curvature)
        mesh = mesh._replace(directions=np.zeros(mesh.corners.size))
        set_directions(mesh)
        return mesh

    @classmethod
    def without_directions(
        cls, faces: Indices, twins: Indices, face_lengths: Floats, curvature: float = 0.0
    ) -> HalfEdges:
        """Copy the triangles of a metric for those who ask for no directions."""
        corners = np.array(faces, dtype=np.int64).ravel()
        lengths = np.array(face_lengths).ravel()
        return cls(corners, np.array(twins), lengths, np.empty(0), float(curvature))

    def copy(self) -> HalfEdges:
        """Copy of all tables."""
        return HalfEdges(
            self.corners.copy(),
            self.twins.copy(),
            self.lengths.copy(),
            self.directions.copy(),
            self.curvature,
        )

    def order_in_memory(self) -> Indices:
        """Order of the vertices in which neighbors have near numbers, shape (V,)."""
        return _breadth_first(self.corners, self.twins)

    def in_order(self, order: Indices) -> HalfEdges:
        """Copy with other numbers for vertices and faces, so that what is near is near in memory.

        Parameters
        ----------
        order : ndarray of int, shape (V,)
            The vertex that gets each number; the faces follow their lowest one.
        """
        number = np.empty_like(order)
        number[order] = np.arange(order.size)
        corners = number[self.corners]
        return self._replace(corners=corners).of_faces(_by_lowest_corner(corners))

    def of_faces(self, faces: Indices) -> HalfEdges:
        """Copy of some faces, in this order, which are glued to no others."""
        place = np.empty(self.corners.size // 3, dtype=np.int64)
        place[faces] = np.arange(faces.size)
        h = (3 * faces[:, None] + np.arange(3)).ravel()
        face, corner = np.divmod(self.twins[h], 3)
        return self._replace(
            corners=self.corners[h],
            twins=3 * place[face] + corner,
            lengths=self.lengths[h],
            directions=self.directions[h] if len(self.directions) else self.directions,
        )

    @property
    def faces(self) -> Indices:
        """Vertex at each corner, shape (F, 3)."""
        return self.corners.reshape(-1, 3)

    @property
    def face_lengths(self) -> Floats:
        """Length of each half-edge, shape (F, 3)."""
        return self.lengths.reshape(-1, 3)

    @property
    def ends(self) -> tuple[Indices, Indices]:
        """The vertex where each half-edge begins and that where it ends."""
        return self.corners, self.corners[self.twins]

    @property
    def edges(self) -> Indices:
        """The lower half-edge of each edge, ascending, shape (E,)."""
        return np.flatnonzero(np.arange(self.twins.size) < self.twins)


@kernel(inline="always")
def following(h: int) -> int:
    """The next half-edge of the face."""
    return h - 2 if h % 3 == 2 else h + 1


@kernel(inline="always")
def preceding(h: int) -> int:
    """The half-edge of the face before."""
    return h + 2 if h % 3 == 0 else h - 1


@kernel
def glue(g: int, h: int, twins: Indices) -> None:
    """Make two half-edges twins."""
    twins[g], twins[h] = h, g


@kernel
def leaving_halfedges(corners: Indices, n: int) -> Indices:
    """A half-edge that leaves each of n vertices, shape (n,); -1 where there is none."""
    leaving = np.full(n, -1, dtype=np.int64)
    for h in range(corners.size):
        leaving[corners[h]] = h
    return leaving


@kernel
def _breadth_first(corners: Indices, twins: Indices) -> Indices:
    """The vertices in order of their distance from the first, counted in edges, shape (V,)."""
    n = corners.size // 6 + 2
    leaving = leaving_halfedges(corners, n)
    order = np.empty(n, dtype=np.int64)
    met = np.zeros(n, dtype=np.bool_)
    order[0], met[0] = 0, True
    count = 1
    for k in range(n):
        start = h = leaving[order[k]]
        while True:
            v = corners[twins[h]]
            if not met[v]:
                met[v] = True
                order[count] = v
                count += 1
            h = twins[preceding(h)]
            if h == start:
                break
    return order


@kernel
def _by_lowest_corner(corners: Indices) -> Indices:
    """The faces, ordered by their lowest vertices and then by their numbers, shape (F,)."""
    count = corners.size // 3
    place = np.zeros(count // 2 + 3, dtype=np.int64)
    for f in range(count):
        place[min(corners[3 * f], min(corners[3 * f + 1], corners[3 * f + 2])) + 1] += 1
    for v in range(1, place.size):
        place[v] += place[v - 1]
    order = np.empty(count, dtype=np.int64)
    for f in range(count):
        lowest = min(corners[3 * f], min(corners[3 * f + 1], corners[3 * f + 2]))
        order[place[lowest]] = f
        place[lowest] += 1
    return order


@kernel
def degree(h: int, twins: Indices, most: int) -> int:
    """Number of edges at the vertex that a half-edge leaves, counted no farther than one beyond most."""
    e = h
    for k in range(most + 1):
        e = twins[preceding(e)]
        if e == h:
            return k + 1
    return most + 1


@kernel
def edges_between(h: int, v: int, corners: Indices, twins: Indices) -> int:
    """Number of edges from the vertex that a half-edge leaves to v."""
    found = 0
    e = h
    while True:
        if corners[twins[e]] == v:
            found += 1
        e = twins[preceding(e)]
        if e == h:
            return found


@kernel
def corner_angle(h: int, mesh: HalfEdges) -> float:
    """Angle of a face at the corner that a half-edge leaves."""
    lengths = mesh.lengths
    return angle_between(lengths[h], lengths[preceding(h)], lengths[following(h)], mesh.curvature)


@kernel
def total_angle(h: int, mesh: HalfEdges) -> float:
    """Sum of the angles at the vertex that a half-edge leaves."""
    start = h
    total = 0.0
    while True:
        total += corner_angle(h, mesh)
        h = mesh.twins[preceding(h)]
        if h == start:
            return total


@kernel
def set_directions(mesh: HalfEdges) -> None:
    """Measure the directions from the lowest half-edge at each vertex."""
    seen = np.zeros(mesh.corners.size, dtype=np.bool_)
    for start in range(mesh.corners.size):
        h = start
        angle = 0.0
        while not seen[h]:
            seen[h] = True
            mesh.directions[h] = angle
            angle += corner_angle(h, mesh)
            h = mesh.twins[preceding(h)]


@kernel
def third_corner(h: int, p: complex, q: complex, mesh: HalfEdges) -> complex:
    """Third corner of a triangle laid out in a `chart`, to the left of half-edge h from p to q."""
    l, third, k = mesh.lengths[h], mesh.lengths[preceding(h)], mesh.curvature
    x, y = apex(l, mesh.lengths[following(h)], third, k)
    if k == 0:
        return from_frame(p, q - p, x / l, y / l)
    side, half = toward(p, q, k), cs(third / 2, k)
    scale = norm(side) * half * half
    return toward(-p, from_frame(0j, side, x / scale, y / scale), k)
