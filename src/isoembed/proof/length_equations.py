"""Length equations as polynomials of degree 2 or 4, with bounds on their second derivatives.

In conformal coordinates of a space of curvature k, with ``m = 1 + k |p|^2 / 4``, the chord of two points has
the square ``|p - q|^2 / (m_p m_q)``.  So

    F_ab(p) = (|p_a - p_b|^2 - c_ab^2 m_a m_b) / (2 n_ab) = 0

says that the distance is the l whose chord is c; n is any number, here near ``sn(l) m_a m_b``, so that F is
the error of the length to first order.  In Euclidean space c = n = l and m = 1.

*Near* a vertex are points within `room` of it in these coordinates.  What bounds say of near points is
computed in floats whose rounding their guards exceed many times; of sin and sinh it is assumed that they are
right to ten digits.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array

from isoembed.arrays import Floats, Indices, Mask
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.proof.enclosed_residuals import Chords, enclosed_residuals, squared_chords
from isoembed.proof.rounding import GUARD, U
from isoembed.space import Space
from isoembed.space.models import to_model

LONGEST = 10.0  # radii of curvature: for longer edges the series of chords is long
NEARBY = 2e-5  # size of the neighborhood with known derivatives, in least m or 2 - m and radii of curvature


class NotProven(ArithmeticError):  # noqa: N818 - says what happened
    """A proof does not go through; the message, part of a sentence, says why."""


@dataclass(frozen=True, eq=False)
class LengthEquations:
    """The equations of a metric's lengths, about given vertices.

    Attributes
    ----------
    space : Space
    edges : ndarray of int, shape (E, 2)
    lengths : ndarray, shape (E,)
        Near 1.
    vertices : ndarray, shape (V, 3)
        As on hyperboloid or sphere.
    points : ndarray, shape (V, 3)
        Floats near their conformal coordinates: what the equations are about.
    densities : ndarray, shape (V,)
        m of the points.
    divisors : ndarray, shape (E,)
        n.
    """

    space: Space
    edges: Indices
    lengths: Floats
    vertices: Floats
    points: Floats
    densities: Floats
    divisors: Floats

    @classmethod
    def of(cls, metric: PolyhedralMetric, vertices: Floats) -> LengthEquations:
        """Equations of the lengths of a normalized metric.

        Raises
        ------
        NotProven
            An edge is longer than some radii of curvature, or a vertex too far out for floats.
        """
        space, edges, lengths = metric.space, metric.edges, metric.lengths
        if space.is_euclidean:
            return cls(space, edges, lengths, vertices, vertices, np.ones(len(vertices)), lengths)
        if not lengths.max() <= LONGEST * space.radius:
            e = int(np.argmax(lengths))
            raise NotProven(f"edge {e} {edges[e].tolist()} is longer than {LONGEST:g} radii of curvature")
        points, (a, b) = to_model(space, vertices, "conformal"), edges.T
        m = 1 + space.curvature / 4 * np.einsum("ij,ij->i", points, points)
        found = cls(space, edges, lengths, vertices, points, m, space.sn(lengths) * m[a] * m[b])
        low, high = found._near_densities
        known = (low > 0) & (high < 2)
        if not known.all():
            raise NotProven(f"vertex {int(np.argmin(known))} is too far from the center for floats")
        return found

    @cached_property
    def room(self) -> float:
        """Largest distance of points that count as near."""
        if self.space.is_euclidean:
            return np.inf
        m = self.densities
        return NEARBY * float(min(1.0, m.min(), 2 - m.max())) * self.space.radius

    @cached_property
    def _near_densities(self) -> tuple[Floats, Floats]:
        """Bounds on the m of near points, each (V,)."""
        if self.space.is_euclidean:
            return self.densities, self.densities
        quarter = abs(self.space.curvature) / 4
        size = np.linalg.norm(self.points, axis=1)
        change = GUARD * quarter * (2 * size + self.room) * self.room + 16 * U * (1 + quarter * size * size)
        return self.densities - change, self.densities + change

    @cached_property
    def _near_heights(self) -> tuple[Floats, Floats]:
        """Bounds on the w = (2 - m) / m of near points, each (V,)."""
        low, high = self._near_densities
        return (2 - high) / high / GUARD, GUARD * (2 - low) / low

    @cached_property
    def _chords(self) -> Chords:
        return squared_chords(self.lengths, self.space.curvature)

    @property
    def _squares(self) -> Floats:
        """The squares of the chords, rounded."""
        return self._chords.squares[0]

    def residuals(self, corrections: Floats) -> tuple[Floats, Floats]:
        """F at the exact sums of points and corrections, (V, 3), as `enclosed_residuals`."""
        chords = None if self.space.is_euclidean else self._chords
        return enclosed_residuals(self.edges, self.points, corrections, self.lengths, chords, self.divisors)

    def missed(self, residuals: Floats) -> Floats:
        """Upper bounds on errors of the lengths at the vertices, (E,), from those on |F| at the points."""
        a, b = self.edges.T
        if self.space.is_euclidean:
            straight = np.linalg.norm(self.points[a] - self.points[b], axis=1)
            return 2 * GUARD * residuals * (self.lengths / (straight + self.lengths))
        m, goals = self.densities, np.sqrt(self._squares)
        chords = self.space.chords(self.vertices[a], self.vertices[b])
        steepest = np.maximum(chords, goals) if self.space.curvature > 0 else np.minimum(chords, goals)
        squares = 1 - self.space.curvature * steepest**2 / 4  # of the cosine, by which arcs grow faster
        cosines = np.sqrt(np.where(squares > 1e-6, squares, 0.0))  # of nearly half a circle, nothing is known
        with np.errstate(divide="ignore"):
            shares = GUARD**2 * self.divisors / (m[a] * m[b] * (chords + goals) * cosines)
        return 2 * residuals * shares + self._off[a] + self._off[b]

    def changes_by(self, errors: Floats) -> Floats:
        """Bounds on the change of F by errors of the lengths no larger than these, shape (E,)."""
        if self.space.is_euclidean:
            return errors * (1 + errors / (2 * self.lengths))
        sn, cs = self.space.sn(self.lengths), self.space.cs(self.lengths)
        if self.space.curvature > 0:
            growth = 1 + errors / sn
        else:
            growth = self.space.cs(errors) + self.space.sn(errors) * cs / sn
        return GUARD**2 * errors * growth

    def matrix(self) -> csr_array:
        """J = F' at the points, its columns over the `weights`, shape (E, 3 V); its entries rounded."""
        a, b = self.edges.T
        first = (self.points[a] - self.points[b]) / self.divisors[:, None]
        second = -first
        if not self.space.is_euclidean:
            m, weights = self.densities, self.space.curvature / 4 * self._squares / self.divisors
            first = first - (weights * m[b])[:, None] * self.points[a]
            second = second - (weights * m[a])[:, None] * self.points[b]
        s = self.weights
        first, second = first / s[a][:, None], second / s[b][:, None]
        columns = (3 * self.edges[:, :, None] + np.arange(3)).ravel()
        pointers = np.arange(0, columns.size + 1, 6)
        entries = np.stack([first, second], axis=1).ravel()
        return csr_array((entries, columns, pointers), shape=(len(self.edges), self.points.size))

    @property
    def matrix_error(self) -> float:
        """Bound on the effect of rounding on the singular values of J, beyond two roundings of each entry.

        J is that of vertices with `weights`.
        """
        if self.space.is_euclidean:
            return 0.0
        (a, b), size = self.edges.T, np.linalg.norm(self.points, axis=1)
        quarter = abs(self.space.curvature) / 4
        terms = (
            quarter * self._squares * (size[a] + size[b]) * (1 + quarter * np.maximum(size[a], size[b]) ** 2)
        )
        straight = np.linalg.norm(self.points[a] - self.points[b], axis=1)
        error = np.linalg.norm((40 * terms + 8 * straight) / self.divisors)
        return float(GUARD * U * error / self.weights.min())

    @cached_property
    def weights(self) -> Floats:
        """Weights s of the vertices, shape (V,).

        At near points no second derivative of F_ab in directions d exceeds ``2 c_ab (|d_a|^2 + |d_b|^2)``,
        and ``s_a^2`` is the sum of the ``c_ab^2`` at a, rounded up.
        """
        c = 1 / self.divisors
        if not self.space.is_euclidean:
            (a, b), size = self.edges.T, np.linalg.norm(self.points, axis=1) + self.room
            quarter = abs(self.space.curvature) / 4
            P, m = (
                np.maximum(size[a], size[b]),
                np.maximum(1.0, np.maximum(*self._near_densities[1][self.edges.T])),
            )
            c = c + GUARD * self._squares / self.divisors * (quarter * m + 2 * (quarter * P) ** 2) / 2
        return GUARD * np.sqrt(np.bincount(self.edges.ravel(), np.repeat(c * c, 2)))

    @cached_property
    def straight(self) -> tuple[Floats, float, float]:
        """Projective coordinates, (V, 3), how far they are off, and how much they change with the points."""
        if self.space.is_euclidean:
            return self.points, 0.0, 1.0
        high = self._near_densities[1]
        straight = self.points / (2 - self.densities)[:, None]
        sizes = np.linalg.norm(straight, axis=1) * (1 + np.abs(self.densities)) / (2 - high)
        # Along the radius it is m / (2 - m)^2, across it 1 / (2 - m).
        stretch = GUARD * float((high / (2 - high) ** 2).max()) if self.space.curvature > 0 else 1.0
        return straight, 32 * U * float(sizes.max()), stretch

    def distance(self, step: Floats, radius: float) -> float:
        """Upper bound on the distance of a vertex from where it is moved to.

        Parameters
        ----------
        step : ndarray, shape (V,)
            How far each point is moved, in conformal coordinates.
        radius : float
            How much farther.
        """
        if self.space.is_euclidean:
            return GUARD * float((GUARD * step + radius).max())
        return GUARD * float(((GUARD * step + radius) / self._near_densities[0] + self._off).max())

    def least_distance(self, move: float) -> float:
        """Lower bound on how far, in the space, a move of this size takes a vertex that stays near."""
        if self.space.curvature <= 0:
            return move  # m is at most 1
        return move / (GUARD * float(self._near_densities[1].max()))

    @cached_property
    def _off(self) -> Floats:
        """Upper bounds on the distances of the points from the vertices, (V,)."""
        if self.space.is_euclidean:
            return np.zeros(len(self.points))
        rounded = self.points / self.densities[:, None]
        # m is off by five roundings of 1 + |k| |p|^2 / 4, and the quotient by one.
        sizes = 1 + abs(self.space.curvature) / 4 * np.einsum("ij,ij->i", self.points, self.points)
        off = np.linalg.norm(rounded - self.vertices, axis=1)
        off += 8 * U * np.linalg.norm(rounded, axis=1) * sizes / self.densities
        return GUARD * (2 * off / self._near_heights[0] if self.space.curvature > 0 else off)

    @property
    def _distortion(self) -> float:
        """Bound on the ratio of the sines of small angles to those in projective coordinates, at near points.

        A translation takes a point at the height w to the origin, and stretches projective coordinates by w^2
        along the radius and w across; normals of planes by the inverse.
        """
        low, high = self._near_heights
        return GUARD * float(max(high.max(), (1 / low).max())) ** 2

    def dihedral_shares(self) -> Floats:
        """The least that sines of dihedral angles are over those in projective coordinates, shape (E,).

        Normals of planes are stretched by 1 / w^2 along the radius and 1 / w across: areas that two of them
        span by 1 / w^3 or more where w > 1, their lengths by 1 / w or less.  Both ends of an edge see the
        same angle.
        """
        if self.space.is_euclidean:
            return np.ones(len(self.edges))
        low, high = self._near_heights
        shares = np.minimum(1 / high, np.minimum(low, 1.0) ** 2)
        return np.maximum(*shares[self.edges.T]) / GUARD

    def detours(self, flat: Mask, slopes: Floats, reach: float, farther: Floats) -> Floats:
        """Upper bounds on what longer ways on roofs add to F, shape (E,), at near points.

        Parameters
        ----------
        flat : ndarray of bool, shape (E,)
        slopes : ndarray, shape (E,)
            The tangents of the tilts of roofs, in projective coordinates.
        reach : float
            How far points are from the given ones, in projective coordinates.
        farther : ndarray, shape (E,)
            By how much the distances of their ends exceed the lengths, at most.

        Raises
        ------
        NotProven
            A roof may be too steep.
        """
        a, b = self.edges.T
        if self.space.is_euclidean:
            chords = np.linalg.norm(self.points[a] - self.points[b], axis=1) + 2 * reach
            return np.where(flat, (chords * slopes) ** 2 / (2 * self.lengths), 0.0)
        space, k = self.space, min(self.space.curvature, 0.0)
        sines = np.where(flat, 2 * GUARD * slopes * self._distortion, 0.0)
        most = self.lengths + farther
        half = GUARD * space.sn(most / 2) / space.cs(most / 2)
        room = 1 + k * (half * (1 + sines**2)) ** 2
        if not (~flat | (sines < 0.5) & (room > 0) & (half > 0)).all():
            e = int(np.argmax(np.where(flat, sines, 0.0)))
            raise NotProven(f"the faces beside edge {e} {self.edges[e].tolist()} may be bent too much")
        more = GUARD * 2 * half * sines**2 / np.where(flat, room, 1.0)
        longest = most + more
        sn = longest if space.curvature > 0 else space.sn(longest)
        m = self._near_densities[1]
        return np.where(flat, GUARD * m[a] * m[b] * sn * more / self.divisors, 0.0)
