"""Intrinsic edge flips, compiled: Delaunay and weighted Delaunay triangulations of any gluing of triangles.

The triangles are tables over half-edges: half-edge ``h = 3 f + c`` leaves corner c of face f and is followed
by the next corner's.  ``corners[h]`` is the vertex that it leaves, ``twins[h]`` the half-edge that it is
glued to, ``lengths[h]`` its length, and ``directions[h]`` the angle at which it leaves its vertex,
counterclockwise from a direction that flips do not change and modulo the total angle there (a "signpost":
Sharp, Soliman and Crane, Navigating intrinsic triangulations, ACM TOG 38, 2019).  Nothing asks two triangles
to meet in one edge only: loops, repeated edges and triangles glued to themselves are triangles like any
others.  A flip changes the tables in place.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import reverse_cuthill_mckee

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

SLACK = 1e-12  # relative: an edge that is Delaunay to this is left alone
THINNEST = 1e-15  # height over longest side: thinner triangles are lost in rounding
ROUNDING = 4e-16  # of a difference of squared lengths, relative to their sum


@dataclass(frozen=True, eq=False)
class HalfEdges:
    """The tables of triangles that are being flipped; the arrays change, what they describe does not.

    Attributes
    ----------
    corners, twins : ndarray of int64, shape (3F,)
    lengths, directions : ndarray, shape (3F,)
    """

    corners: Indices
    twins: Indices
    lengths: Floats
    directions: Floats

    @classmethod
    def of(cls, faces: Indices, twins: Indices, face_lengths: Floats) -> HalfEdges:
        """Copy the triangles of a metric and give every half-edge its direction.

        Parameters
        ----------
        faces : ndarray of int, shape (F, 3)
        twins : ndarray of int, shape (3F,)
        face_lengths : ndarray, shape (F, 3)
            Length of each half-edge.
        """
        corners = np.array(faces, dtype=np.int64).ravel()
        tables = cls(corners, twins.copy(), np.array(face_lengths).ravel(), np.zeros(corners.size))
        set_directions(tables.corners, tables.twins, tables.lengths, tables.directions)
        return tables

    def copy(self) -> HalfEdges:
        """Copy all tables."""
        return HalfEdges(self.corners.copy(), self.twins.copy(), self.lengths.copy(), self.directions.copy())

    def order_in_memory(self) -> Indices:
        """An order of the vertices in which neighbors have near numbers, shape (V,)."""
        n = self.corners.size // 6 + 2
        ends = (self.corners, self.corners[self.twins])
        graph = coo_array((np.ones(self.corners.size), ends), shape=(n, n)).tocsr()
        return reverse_cuthill_mckee(graph, symmetric_mode=True).astype(np.int64)

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
        faces = np.argsort(corners.reshape(-1, 3).min(axis=1), kind="stable")
        place = np.empty_like(faces)
        place[faces] = np.arange(faces.size)
        halfedges = (3 * faces[:, None] + np.arange(3)).ravel()
        face, corner = np.divmod(self.twins[halfedges], 3)
        return HalfEdges(
            corners[halfedges],
            3 * place[face] + corner,
            self.lengths[halfedges],
            self.directions[halfedges],
        )

    @property
    def faces(self) -> Indices:
        """(F, 3): the vertex at each corner."""
        return self.corners.reshape(-1, 3)

    @property
    def face_lengths(self) -> Floats:
        """(F, 3): length of each half-edge."""
        return self.lengths.reshape(-1, 3)

    def non_delaunay(self, weights: Floats) -> Indices:
        """The lower half-edges of the edges that are not weighted Delaunay.

        Parameters
        ----------
        weights : ndarray, shape (V,)
            Squared radii, less any constant.
        """
        return non_delaunay_edges(self.corners, self.twins, self.lengths, weights)

    def make_delaunay(self, weights: Floats, non_delaunay: Indices | None = None) -> tuple[int, int]:
        """Flip to the weighted Delaunay triangulation; with equal weights, to the Delaunay triangulation.

        Parameters
        ----------
        weights : ndarray, shape (V,)
            Squared radii, less any constant.
        reflex : ndarray of int, optional
            What `non_delaunay` says, where it is known already.

        Returns
        -------
        int, int
            Flips made, and edges that are not Delaunay but cannot be flipped: a vertex is hidden, and the
            weights have no Delaunay triangulation that uses them all.
        """
        if non_delaunay is None:
            non_delaunay = self.non_delaunay(weights)
        flips, stuck = flip_to_delaunay(
            self.corners, self.twins, self.lengths, self.directions, weights, non_delaunay
        )
        return int(flips), int(stuck)

    def scramble(self, flips: int, rng: np.random.Generator, thinnest: float = 1e-3) -> int:
        """Flip random edges, of those whose flip leaves no triangle thinner than asked.

        Parameters
        ----------
        flips : int
            Edges to try.
        rng : numpy.random.Generator
        thinnest : float
            Least height of a new triangle over its longest side.

        Returns
        -------
        int
            Flips made.
        """
        tried = rng.integers(0, self.corners.size, flips)
        return int(flip_some(self.corners, self.twins, self.lengths, self.directions, tried, thinnest))


@njit(cache=True, inline="always")
def following(h: int) -> int:
    """The next half-edge of the face."""
    return h - 2 if h % 3 == 2 else h + 1


@njit(cache=True, inline="always")
def preceding(h: int) -> int:
    """The half-edge of the face before."""
    return h + 2 if h % 3 == 0 else h - 1


@njit(cache=True)
def twice_area(a: float, b: float, c: float) -> float:
    """Twice the area of a triangle from its sides, by Kahan's formula; 0 where they make none."""
    if a < b:
        a, b = b, a
    if a < c:
        a, c = c, a
    if b < c:
        b, c = c, b
    square = (a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c))
    return np.sqrt(square) / 2 if square > 0 else 0.0


@njit(cache=True)
def angle_between(a: float, b: float, across: float) -> float:
    """The angle between sides a and b of a triangle, by Kahan's formula."""
    s = across
    if a < b:
        a, b = b, a
    mu = s - (a - b) if b >= s else b - (a - s)
    return 2 * np.arctan2(
        np.sqrt(max(((a - b) + s) * mu, 0.0)), np.sqrt((a + (b + s)) * max((a - s) + b, 0.0))
    )


@njit(cache=True)
def apex(l: float, second: float, third: float) -> tuple[float, float]:
    """Where the third corner lies if side l runs from (0, 0) to (l, 0); second follows l, third closes."""
    return (l + (third - second) * (third + second) / l) / 2, twice_area(l, second, third) / l


@njit(cache=True)
def set_directions(corners: Indices, twins: Indices, lengths: Floats, directions: Floats) -> None:
    """Measure the directions from the lowest half-edge at each vertex."""
    seen = np.zeros(corners.size, dtype=np.bool_)
    for start in range(corners.size):
        h = start
        angle = 0.0
        while not seen[h]:
            seen[h] = True
            directions[h] = angle
            into = preceding(h)
            angle += angle_between(lengths[h], lengths[into], lengths[following(h)])
            h = twins[into]


@njit(cache=True)
def flip(
    h: int, corners: Indices, twins: Indices, lengths: Floats, directions: Floats, thinnest: float
) -> bool:
    """Flip the edge of a half-edge, if the two triangles are a strictly convex quadrilateral.

    Of the faces ijk and jim of half-edge i -> j and its twin remain kim, with the other diagonal in the place
    that ``following(h)`` had, and mjk, with it in the place of ``following(twin)``.

    Returns
    -------
    bool
        False, and nothing is changed, if both sides are one face, or a new triangle would be as thin as
        stated: no higher than that fraction of its longest side.
    """
    t = twins[h]
    if h // 3 == t // 3:
        return False
    jk, ki, im, mj = following(h), preceding(h), following(t), preceding(t)
    l = lengths[h]
    x, y = apex(l, lengths[jk], lengths[ki])
    u, v = apex(l, lengths[mj], lengths[im])
    diagonal = np.hypot(x - u, y + v)
    # Twice the areas of the new triangles.
    at_i = x * v + u * y
    at_j = (l - x) * v + (l - u) * y
    longest_i = max(diagonal, max(lengths[ki], lengths[im]))
    longest_j = max(diagonal, max(lengths[mj], lengths[jk]))
    if not (at_i > thinnest * longest_i**2 and at_j > thinnest * longest_j**2):
        return False
    i, j, k, m = corners[h], corners[t], corners[ki], corners[mj]

    # jk moves to the place of t, im to the place of h; their twins may be among the four sides.
    length_jk, length_im = lengths[jk], lengths[im]
    twin_jk, twin_im = twins[jk], twins[im]
    direction_jk, direction_im = directions[jk], directions[im]
    if twin_jk == im:
        twin_jk, twin_im = h, t
    lengths[t], lengths[h] = length_jk, length_im
    corners[t], corners[h] = j, i
    directions[t], directions[h] = direction_jk, direction_im
    twins[t], twins[h] = twin_jk, twin_im
    twins[twin_jk], twins[twin_im] = t, h

    corners[jk], corners[im] = m, k
    lengths[jk] = lengths[im] = diagonal
    twins[jk], twins[im] = im, jk
    directions[jk] = directions[mj] + angle_between(lengths[mj], diagonal, length_jk)
    directions[im] = directions[ki] + angle_between(lengths[ki], diagonal, length_im)
    return True


@njit(cache=True)
def tilt(h: int, corners: Indices, lengths: Floats, weights: Floats) -> tuple[float, float]:
    """Signed distance of the power center of h's triangle from h, positive inside, and its rounding error.

    It is d = ((|ik|^2 + q_i - q_k) / 2 - p x) / y with p = (l^2 + q_i - q_j) / (2 l).
    """
    after, before = following(h), preceding(h)
    l, second, third = lengths[h], lengths[after], lengths[before]
    x, y = apex(l, second, third)
    a, b, c = weights[corners[h]], weights[corners[after]], weights[corners[before]]
    p = (l + (a - b) / l) / 2
    if y <= 0:
        return -np.inf, 0.0
    size = abs(a) + abs(b) + abs(c) + l * l + third * third
    return ((third * third + a - c) / 2 - p * x) / y, ROUNDING * size / y


@njit(cache=True)
def tilts(corners: Indices, lengths: Floats, weights: Floats) -> tuple[Floats, Floats]:
    """The tilts of all half-edges and their rounding errors, shape (3F,)."""
    values, errors = np.empty(corners.size), np.empty(corners.size)
    for f in range(0, corners.size, 3):
        i, j, k = weights[corners[f]], weights[corners[f + 1]], weights[corners[f + 2]]
        a, b, c = lengths[f], lengths[f + 1], lengths[f + 2]  # ij, jk, ki
        area = twice_area(a, b, c)
        if area <= 0:
            values[f : f + 3] = -np.inf
            errors[f : f + 3] = 0.0
            continue
        at_i = (a * a + (c - b) * (c + b)) / 2  # products of the two sides at a corner
        at_j = (b * b + (a - c) * (a + c)) / 2
        at_k = (c * c + (b - a) * (b + a)) / 2
        values[f] = (a * (c * c + i - k) - (a * a + i - j) * at_i / a) / (2 * area)
        values[f + 1] = (b * (a * a + j - i) - (b * b + j - k) * at_j / b) / (2 * area)
        values[f + 2] = (c * (b * b + k - j) - (c * c + k - i) * at_k / c) / (2 * area)
        size = (abs(i) + abs(j) + abs(k) + a * a + b * b + c * c) * ROUNDING / area
        errors[f], errors[f + 1], errors[f + 2] = a * size, b * size, c * size
    return values, errors


@njit(cache=True)
def non_delaunay_edges(corners: Indices, twins: Indices, lengths: Floats, weights: Floats) -> Indices:
    """See `HalfEdges.non_delaunay`."""
    d, error = tilts(corners, lengths, weights)
    found = np.empty(corners.size // 2, dtype=np.int64)
    count = 0
    for h in range(corners.size):
        t = twins[h]
        if h < t and d[h] + d[t] < -(SLACK * (abs(d[h]) + abs(d[t])) + error[h] + error[t]):
            found[count] = h
            count += 1
    return found[:count].copy()


@njit(cache=True)
def is_delaunay(h: int, corners: Indices, twins: Indices, lengths: Floats, weights: Floats) -> bool:
    """Whether the dihedral angle at the edge of h is convex: the centers lie in order, d + d' >= 0."""
    here, error = tilt(h, corners, lengths, weights)
    there, other_error = tilt(twins[h], corners, lengths, weights)
    return here + there >= -(SLACK * (abs(here) + abs(there)) + error + other_error)


@njit(cache=True)
def flip_to_delaunay(
    corners: Indices,
    twins: Indices,
    lengths: Floats,
    directions: Floats,
    weights: Floats,
    non_delaunay: Indices,
) -> tuple[int, int]:
    """Flip edges until all that can be flipped are Delaunay; see `HalfEdges.make_delaunay`."""
    n = corners.size
    waiting = np.zeros(n, dtype=np.bool_)
    stack = np.empty(n, dtype=np.int64)
    top = non_delaunay.size
    stack[:top] = non_delaunay
    waiting[non_delaunay] = True
    flips = blocked = 0
    limit = 100 * n + 1000  # far beyond what terminates; rounding alone could go round in circles
    while top > 0 and flips < limit:
        top -= 1
        h = stack[top]
        waiting[h] = False
        if is_delaunay(h, corners, twins, lengths, weights):
            continue
        t = twins[h]
        if not flip(h, corners, twins, lengths, directions, THINNEST):
            blocked += 1
            continue
        flips += 1
        for side in (h, preceding(h), t, preceding(t)):
            name = min(side, twins[side])
            if not waiting[name]:
                stack[top] = name
                top += 1
                waiting[name] = True
    if blocked == 0:
        return flips, top
    # Some that were blocked may have come free by other flips.
    return flips, top + non_delaunay_edges(corners, twins, lengths, weights).size


@njit(cache=True)
def flip_some(
    corners: Indices, twins: Indices, lengths: Floats, directions: Floats, tried: Indices, thinnest: float
) -> int:
    """Flip the edges of these half-edges where that leaves no thin triangle; return how many were."""
    flips = 0
    for h in tried:
        if flip(h, corners, twins, lengths, directions, thinnest):
            flips += 1
    return flips
