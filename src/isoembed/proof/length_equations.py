"""Length equations as polynomials of degree 2 or 4, with bounds on their second derivatives.

In conformal coordinates of a space of curvature k, with ``m = 1 + k |p|^2 / 4``, the chord of two points has
the square ``|p - q|^2 / (m_p m_q)``.  So

    F_ab(p) = (|p_a - p_b|^2 - c_ab^2 m_a m_b) / (2 n_ab) = 0

states that the distance is the l with chord c; n is arbitrary, here approximately ``sn(l) m_a m_b``, so that
F is the error of the length to first order.  In Euclidean space c = n = l and m = 1.

Points *near* a vertex are within `room` of it in these coordinates.  Bounds for near points are computed in
floats with guard factors that far exceed the rounding errors; sin and sinh are assumed to be accurate to ten
digits.
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

LONGEST = 10.0  # radii of curvature: the chord series of longer edges is long


class NotProven(ArithmeticError):  # noqa: N818 - the outcome
    """A proof fails; the message, part of a sentence, gives the reason."""


@dataclass(frozen=True, eq=False)
class LengthEquations:
    """Length equations of a metric near given vertices.

    Attributes
    ----------
    space : Space
    edges : ndarray of int, shape (E, 2)
    lengths : ndarray, shape (E,)
        Lengths of order 1.
    vertices : ndarray, shape (V, 3)
        Coordinates on the hyperboloid or sphere.
    points : ndarray, shape (V, 3)
        Rounded conformal coordinates of the vertices, the unknowns of the equations.
    densities : ndarray, shape (V,)
        Values of m at the points.
    divisors : ndarray, shape (E,)
        Values of n.
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
            An edge is longer than ten radii of curvature, or a vertex too far from the origin for floats.
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
        valid = (low > 0) & (high < 2)
        if not valid.all():
            raise NotProven(f"vertex {int(np.argmin(valid))} is too far from the center for floats")
        return found

    @cached_property
    def room(self) -> float:
        """Largest distance of points that count as near."""
        if self.space.is_euclidean:
            return np.inf
        m = self.densities
        return 2e-5 * float(min(1.0, m.min(), 2 - m.max())) * self.space.radius

    @cached_property
    def _near_densities(self) -> tuple[Floats, Floats]:
        """Bounds on m at near points, each (V,)."""
        if self.space.is_euclidean:
            return self.densities, self.densities
        quarter = abs(self.space.curvature) / 4
        size = np.linalg.norm(self.points, axis=1)
        change = GUARD * quarter * (2 * size + self.room) * self.room + 16 * U * (1 + quarter * size * size)
        return self.densities - change, self.densities + change

    @cached_property
    def _near_heights(self) -> tuple[Floats, Floats]:
        """Bounds on w = (2 - m) / m at near points, each (V,)."""
        low, high = self._near_densities
        return (2 - high) / high / GUARD, GUARD * (2 - low) / low

    @cached_property
    def _chords(self) -> Chords:
        return squared_chords(self.lengths, self.space.curvature)

    @property
    def _squares(self) -> Floats:
        """Squared chords, rounded."""
        return self._chords.squares[0]

    def residuals(self, corrections: Floats) -> tuple[Floats, Floats]:
        """F at the exact sums of points and corrections, (V, 3), as `enclosed_residuals`."""
        chords = None if self.space.is_euclidean else self._chords
        return enclosed_residuals(self.edges, self.points, corrections, self.lengths, chords, self.divisors)

    def length_differences(self, residuals: Floats) -> Floats:
        """Upper bounds on the length errors at the vertices, (E,), from bounds on |F| at the points."""
        a, b = self.edges.T
        if self.space.is_euclidean:
            straight = np.linalg.norm(self.points[a] - self.points[b], axis=1)
            return 2 * GUARD * residuals * (self.lengths / (straight + self.lengths))
        m, goals = self.densities, np.sqrt(self._squares)
        chords = self.space.chords(self.vertices[a], self.vertices[b])
        steepest = np.maximum(chords, goals) if self.space.curvature > 0 else np.minimum(chords, goals)
        squares = 1 - self.space.curvature * steepest**2 / 4  # squared cosines: d(chord) / d(arc)
        cosines = np.sqrt(np.where(squares > 1e-6, squares, 0.0))  # no bound near half a circle
        with np.errstate(divide="ignore"):
            shares = GUARD**2 * self.divisors / (m[a] * m[b] * (chords + goals) * cosines)
        return 2 * residuals * shares + self._off[a] + self._off[b]

    def changes_by(self, errors: Floats) -> Floats:
        """Bounds on the change of F due to length errors up to these, shape (E,)."""
        if self.space.is_euclidean:
            return errors * (1 + errors / (2 * self.lengths))
        sn, cs = self.space.sn(self.lengths), self.space.cs(self.lengths)
        if self.space.curvature > 0:
            growth = 1 + errors / sn
        else:
            growth = self.space.cs(errors) + self.space.sn(errors) * cs / sn
        return GUARD**2 * errors * growth

    def matrix(self) -> csr_array:
        """J = F' at the points, with columns divided by the `weights` and rounded entries, shape (E, 3 V)."""
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

        J is the weighted matrix of `matrix`.
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

        At near points, second derivatives of F_ab in directions d are at most ``2 c_ab (|d_a|^2 + |d_b|^2)``,
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
        """Projective coordinates, (V, 3), a bound on their errors, and a Lipschitz constant of the map."""
        if self.space.is_euclidean:
            return self.points, 0.0, 1.0
        high = self._near_densities[1]
        straight = self.points / (2 - self.densities)[:, None]
        sizes = np.linalg.norm(straight, axis=1) * (1 + np.abs(self.densities)) / (2 - high)
        # The stretch is m / (2 - m)^2 along the radius and 1 / (2 - m) across.
        stretch = GUARD * float((high / (2 - high) ** 2).max()) if self.space.curvature > 0 else 1.0
        return straight, 32 * U * float(sizes.max()), stretch

    def distance(self, step: Floats, radius: float) -> float:
        """Upper bound on the displacement of a vertex.

        Parameters
        ----------
        step : ndarray, shape (V,)
            Displacement of each point in conformal coordinates.
        radius : float
            Bound on a further displacement.
        """
        if self.space.is_euclidean:
            return GUARD * float((GUARD * step + radius).max())
        return GUARD * float(((GUARD * step + radius) / self._near_densities[0] + self._off).max())

    def smallest_distance(self, move: float) -> float:
        """Lower bound on the distance in space for a coordinate displacement of a vertex that stays near."""
        if self.space.curvature <= 0:
            return move  # m is at most 1
        return move / (GUARD * float(self._near_densities[1].max()))

    @cached_property
    def _off(self) -> Floats:
        """Upper bounds on the distances of the points from the vertices, (V,)."""
        if self.space.is_euclidean:
            return np.zeros(len(self.points))
        rounded = self.points / self.densities[:, None]
        # five roundings of 1 + |k| |p|^2 / 4 in m, and one of the quotient
        sizes = 1 + abs(self.space.curvature) / 4 * np.einsum("ij,ij->i", self.points, self.points)
        off = np.linalg.norm(rounded - self.vertices, axis=1)
        off += 8 * U * np.linalg.norm(rounded, axis=1) * sizes / self.densities
        return GUARD * (2 * off / self._near_heights[0] if self.space.curvature > 0 else off)

    @property
    def _distortion(self) -> float:
        """Bound on the ratio of the sines of small angles to those in projective coordinates, at near points.

        The translation of a point at the height w to the origin stretches projective coordinates by w^2 along
        the radius and by w across; normals of planes by the inverse.
        """
        low, high = self._near_heights
        return GUARD * float(max(high.max(), (1 / low).max())) ** 2

    def dihedral_shares(self) -> Floats:
        """Lower bounds on ratios of sines of dihedral angles to those in projective coordinates, shape (E,).

        Normals of planes are stretched by 1 / w^2 along the radius and 1 / w across: for w > 1, areas spanned
        by two of them by at least 1 / w^3, their lengths by at most 1 / w.  The angle is the same at both
        ends of an edge.
        """
        if self.space.is_euclidean:
            return np.ones(len(self.edges))
        low, high = self._near_heights
        shares = np.minimum(1 / high, np.minimum(low, 1.0) ** 2)
        return np.maximum(*shares[self.edges.T]) / GUARD

    def detours(self, flat: Mask, slopes: Floats, reach: float, farther: Floats) -> Floats:
        """Upper bounds on the contribution of detours over roofs to F, shape (E,), at near points.

        Parameters
        ----------
        flat : ndarray of bool, shape (E,)
        slopes : ndarray, shape (E,)
            Tangents of the tilts of roofs, in projective coordinates.
        reach : float
            Bound on the distance of points from the given ones, in projective coordinates.
        farther : ndarray, shape (E,)
            Bounds on the excess of the distances of the edges' ends over the lengths.

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
        upper = self.lengths + farther
        half = GUARD * space.sn(upper / 2) / space.cs(upper / 2)
        room = 1 + k * (half * (1 + sines**2)) ** 2
        if not (~flat | (sines < 0.5) & (room > 0) & (half > 0)).all():
            e = int(np.argmax(np.where(flat, sines, 0.0)))
            raise NotProven(f"the faces beside edge {e} {self.edges[e].tolist()} may be bent too much")
        more = GUARD * 2 * half * sines**2 / np.where(flat, room, 1.0)
        longest = upper + more
        sn = longest if space.curvature > 0 else space.sn(longest)
        m = self._near_densities[1]
        return np.where(flat, GUARD * m[a] * m[b] * sn * more / self.divisors, 0.0)
