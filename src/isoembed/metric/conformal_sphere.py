"""Discrete conformal map of a polyhedral metric to the unit sphere.

Two metrics on one triangulation are discretely conformally equivalent if their lengths differ by a factor
``e^{(u_a + u_b) / 2}`` an edge; on the sphere and in the hyperbolic plane it is the chords ``2 sn(l / 2)``
that differ by it, and these count here instead of the lengths.  One vertex is removed and the rest flattened
into the plane, which is a convex problem in u; stereographic projection back is again an equivalence; a
Moebius map centers the result.  The chords of the layout are then the lengths of an equivalent metric that is
embedded, exactly.

References
----------
Springborn, Schroeder and Pinkall, Conformal equivalence of triangle meshes, ACM TOG 27 (2008).
Bobenko, Pinkall and Springborn, Discrete conformal maps and ideal hyperbolic polyhedra,
Geom. Topol. 19 (2015).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np
from scipy.sparse import eye_array

from isoembed.arrays import Floats, Indices, Points
from isoembed.linalg import SingularMatrix, Work, analyze, dissect
from isoembed.mesh.triangulation import Triangulation
from isoembed.metric.curvature import face_areas
from isoembed.metric.delaunay import ideal_delaunay
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.metric.triangles import Triangles
from isoembed.progress.stages import StageRecorder


@dataclass(frozen=True)
class ConformalSphere:
    """A layout on the unit sphere.

    Attributes
    ----------
    points : ndarray, shape (V, 3)
        On the unit sphere, centered: the mean over the metric's area vanishes.
    exact : bool
        Whether it is discretely conformal.  Where it is not (triangles that had to be flipped could not),
        Tutte's embedding stands in.
    """

    points: Floats
    exact: bool


def conformal_sphere(metric: PolyhedralMetric, recorder: StageRecorder) -> ConformalSphere:
    """Lay the metric out on the unit sphere.

    Parameters
    ----------
    metric : PolyhedralMetric
        Best on Delaunay triangles: see `isoembed.metric.delaunay.delaunay`.
    recorder : StageRecorder
        Counts the Newton steps and their factorizations.

    Returns
    -------
    ConformalSphere

    Raises
    ------
    InvalidMetric
        The surface has a boundary or handles.
    """
    metric.triangulation.check_sphere()
    triangulation, lengths = metric.triangulation, _chords(metric.normalized)
    # The star of the pole is never flipped; where that keeps triangles broken, another pole may do.
    # vertices that are taken to infinity, in turn
    for pole in np.argsort(-triangulation.degrees, kind="stable")[:5]:
        plane = _Plane(triangulation, lengths, int(pole), recorder.work)
        plane, u, exact = _flattened(plane, plane.start(), recorder)
        if exact:
            break
    weights = _vertex_weights(metric)
    if exact:
        x = _centered(_projected(plane.lay_out(u), plane.pole), weights)
        a, b = metric.edges.T
        # A metric so long and thin that neighbors meet on the sphere within rounding has no layout either.
        if (np.linalg.norm(x[a] - x[b], axis=1) > 1e-12).all():  # neighbors do not coincide
            return ConformalSphere(x, True)
    return ConformalSphere(_centered(_projected(plane.tutte(), plane.pole), weights), False)


def _projected(z: Points, pole: int) -> Floats:
    """Points of the plane on the unit sphere, the pole at infinity: stereographic projection."""
    others = np.delete(z, pole)
    z = z - np.median(others.real) - 1j * np.median(others.imag)
    z /= np.median(np.abs(np.delete(z, pole)))
    square = np.abs(z) ** 2
    x = np.column_stack([2 * z.real, 2 * z.imag, square - 1]) / (1 + square)[:, None]
    x[pole] = [0, 0, 1]
    return x


def conformal_factors(metric: PolyhedralMetric, sphere: ConformalSphere) -> Floats:
    """The u_a of ``|x_a - x_b| = l_ab e^{(u_a + u_b) / 2}``, shape (V,), averaged over the corners at a.

    On the sphere and in the hyperbolic plane l_ab is the chord.

    Parameters
    ----------
    metric : PolyhedralMetric
        With lengths of order 1.
    sphere : ConformalSphere
    """
    a, b = metric.edges.T
    x = sphere.points
    ratio = np.log(np.linalg.norm(x[a] - x[b], axis=1) / _chords(metric))[metric.triangulation.face_edges]
    corner = ratio + np.roll(ratio, 1, axis=1) - np.roll(ratio, -1, axis=1)
    return np.bincount(metric.faces.ravel(), corner.ravel()) / metric.triangulation.degrees


def _chords(metric: PolyhedralMetric) -> Floats:
    return metric.space.chord(metric.lengths)


class _Plane:
    """The metric without its pole, to be flattened: unknowns u at the vertices off the pole's star."""

    def __init__(
        self,
        triangulation: Triangulation,
        lengths: Floats,
        pole: int,
        work: Work,
        flipped: bool = False,
    ) -> None:
        self.triangulation, self.lengths, self.pole = triangulation, lengths, pole
        self.work, self.flipped = work, flipped
        n = triangulation.n_vertices
        away = (triangulation.faces != pole).all(axis=1)
        self.faces, self.face_edges = triangulation.faces[away], triangulation.face_edges[away]
        spokes = np.flatnonzero((triangulation.edges == pole).any(axis=1))
        rim = triangulation.edges[spokes].sum(axis=1) - pole
        self.ring = _ring(triangulation, pole)
        # With this u all spokes have one length: the pole goes to infinity.
        self.rim_u = np.zeros(n)
        self.rim_u[rim] = -2 * np.log(self.lengths[spokes])
        self.inner = np.setdiff1d(np.arange(n), np.append(rim, pole))
        if len(self.inner) == 0:
            return
        position = np.full(n, -1)
        position[self.inner] = np.arange(len(self.inner))
        graph = triangulation.adjacency[self.inner][:, self.inner] + eye_array(len(self.inner))
        order = position[dissect(triangulation.adjacency).vertex_order()]
        self._solver = analyze(graph.tocsc(), order[order >= 0], work=self.work)
        pattern = self._solver.pattern
        row, column = pattern.indices, np.repeat(np.arange(len(self.inner)), np.diff(pattern.indptr))
        self._diagonal = row == column
        self._row = self.inner[row]
        self._edge = triangulation.edge_indices(np.column_stack([self._row, self.inner[column]]))

    def measure(self, u: Floats) -> tuple[Floats, Floats, Floats, bool]:
        """Angle sums (V,), weights (E,) of half the Laplacian, lengths (E,), and whether triangles break.

        A triangle whose inequality is broken has the angles pi, 0, 0, which keeps the problem convex.
        """
        a, b = self.triangulation.edges.T
        lengths = self.lengths * np.exp((u[a] + u[b]) / 2)
        l = lengths[self.face_edges]
        l = l / l.max(axis=1, keepdims=True)
        sides = np.sort(l, axis=1)
        broken = sides[:, 2] - sides[:, 1] >= sides[:, 0]
        triangles = Triangles.of(np.where(broken[:, None], 1.0, l))
        straight = np.where(np.roll(l, -1, axis=1) == 1.0, np.pi, 0.0)
        angles = np.where(broken[:, None], straight, triangles.angles)
        cotangents = np.where(broken[:, None], 0.0, triangles.cotangents)
        n, m = self.triangulation.n_vertices, self.triangulation.n_edges
        sums = cast(Floats, np.bincount(self.faces.ravel(), angles.ravel(), minlength=n))
        across = np.roll(self.face_edges, -1, axis=1)
        weights = cast(Floats, np.bincount(across.ravel(), cotangents.ravel() / 2, minlength=m))
        return sums, weights, lengths, bool(broken.any())

    def solve(self, weights: Floats, right: Floats, boundary: Floats) -> Floats:
        """Solve ``L y = right`` for y (V, k), L with these weights, y given on the ring."""
        edges = self.triangulation.edges
        n = self.triangulation.n_vertices
        a, b = edges.T
        diagonal = np.bincount(edges.ravel(), np.repeat(weights, 2), minlength=n)
        values = np.where(self._diagonal, diagonal[self._row], -weights[self._edge])
        factor = self._solver.factor(values)
        fixed = np.zeros_like(boundary)
        fixed[self.ring] = boundary[self.ring]
        pull = np.zeros_like(boundary)
        for k in range(boundary.shape[1]):
            pull[:, k] = np.bincount(a, weights * fixed[b, k], minlength=n)
            pull[:, k] += np.bincount(b, weights * fixed[a, k], minlength=n)
        y = fixed
        y[self.inner] = factor.solve(right[self.inner] + pull[self.inner])
        return y

    def start(self) -> Floats:
        """The u of the smooth problem, one Poisson equation, unless it breaks triangles; else 0."""
        if len(self.inner) == 0:
            return self.rim_u
        sums, weights, _, _ = self.measure(np.zeros(self.triangulation.n_vertices))
        try:
            u = self.solve(weights, (sums - 2 * np.pi)[:, None], self.rim_u[:, None])[:, 0]
        except SingularMatrix:  # needles
            return self.rim_u
        # larger factors: the metric has no place on the sphere
        return u if np.abs(u).max() < 40.0 and not self.measure(u)[3] else self.rim_u

    def whole(self, u: Floats) -> tuple[_Plane, tuple[Floats, Floats, Floats, bool]]:
        """Copy of the conformal class on triangles that u does not break, and its measures.

        Where it does, triangles that are Delaunay at u take their place, by Ptolemy's flips.  From then on
        they are kept Delaunay: only then does the layout not depend on which edges were flipped.
        """
        measures = self.measure(u)
        if not measures[3] and not self.flipped:
            return self, measures
        a, b = self.triangulation.edges.T
        scaled = self.lengths * np.exp((u[a] + u[b]) / 2)
        triangulation, scaled = ideal_delaunay(self.triangulation, scaled, self.pole)
        if triangulation is self.triangulation:
            return self, measures
        a, b = triangulation.edges.T
        lengths = scaled * np.exp(-(u[a] + u[b]) / 2)
        plane = _Plane(triangulation, lengths, self.pole, self.work, flipped=True)
        return plane, plane.measure(u)

    def lay_out(self, u: Floats) -> Points:
        """Place the ring by its lengths and angles, the rest by harmonic functions, as coordinates are."""
        sums, weights, lengths, _ = self.measure(u)
        sides = self.triangulation.edge_indices(np.column_stack([self.ring, np.roll(self.ring, -1)]))
        direction = np.cumsum(np.pi - sums[self.ring])
        steps = lengths[sides] * np.exp(1j * direction)
        return self._extended(np.concatenate([[0], np.cumsum(steps)[:-1]]), weights)

    def tutte(self) -> Points:
        """Place every vertex at the mean of its neighbors within a regular polygon: valid for any lengths."""
        corners = np.exp(2j * np.pi * np.arange(len(self.ring)) / len(self.ring))
        return self._extended(corners, np.ones(self.triangulation.n_edges))

    def _extended(self, corners: Points, weights: Floats) -> Points:
        z = np.zeros((self.triangulation.n_vertices, 2))
        z[self.ring] = np.column_stack([corners.real, corners.imag])
        if len(self.inner):
            z = self.solve(weights, np.zeros_like(z), z)
        return z[:, 0] + 1j * z[:, 1]


def _flattened(plane: _Plane, u: Floats, recorder: StageRecorder) -> tuple[_Plane, Floats, bool]:
    """Newton on the convex energy whose gradient is ``2 pi - (angle sum)``: flat where it vanishes.

    Returns the plane, whose triangles may have been flipped on the way, u, and whether the surface is flat
    with all triangles whole.
    """
    inner, zero = plane.inner, np.zeros((len(u), 1))
    plane, (sums, weights, _, broken) = plane.whole(u)
    for _ in range(50):  # Newton steps
        g = np.zeros(len(u))
        g[inner] = 2 * np.pi - sums[inner]
        recorder.show(residual=float(np.abs(g).max()))
        if np.abs(g).max() < 1e-10:  # the deficits are rounding
            return plane, u, not broken
        if broken:  # straight triangles have no second derivative: keep the matrix definite
            weights = weights + 1e-3  # of straight triangles, whose cotangents vanish
        try:
            step = plane.solve(weights, -g[:, None], zero)[:, 0]
        except SingularMatrix:  # needles
            return plane, u, False
        recorder.iterations += 1
        # a Newton step changes no factor by more than e^2
        slope, s = step @ g, min(1.0, 2.0 / np.abs(step).max())
        while True:  # a convex function has decreased where its slope has not turned around
            trial, (sums, weights, _, broken) = plane.whole(u + s * step)
            if step[inner] @ (2 * np.pi - sums[inner]) <= 0.9 * abs(slope):
                break
            s /= 2
            if s < 1e-6:
                return plane, u, False
        plane, u = trial, u + s * step
    return plane, u, False


def _ring(triangulation: Triangulation, pole: int) -> Indices:
    """The neighbors of the pole, in order, counterclockwise as seen from the rest of the surface."""
    f, c = np.nonzero(triangulation.faces == pole)
    faces = triangulation.faces
    before = dict(zip(faces[f, (c + 2) % 3].tolist(), faces[f, (c + 1) % 3].tolist(), strict=True))
    ring = [int(faces[f[0], (c[0] + 1) % 3])]
    while len(ring) < len(before):
        ring.append(before[ring[-1]])
    return np.array(ring)


def _vertex_weights(metric: PolyhedralMetric) -> Floats:
    share = np.repeat(face_areas(metric.normalized), 3)
    weights = np.bincount(metric.faces.ravel(), share)
    return weights / weights.sum()


def _centered(x: Floats, weights: Floats) -> Floats:
    """Move points on the sphere by a Moebius map until their weighted mean vanishes.

    Newton's method on boosts: the center is the minimum of a convex function on hyperbolic space
    (Springborn, A unique representation of polyhedral types, 2005).
    """
    for _ in range(100):
        mean = weights @ x
        if np.linalg.norm(mean) < 1e-12:  # the mean is at the center
            break
        rapidity = -np.linalg.solve(np.eye(3) - (weights[:, None] * x).T @ x, mean)
        size = float(np.linalg.norm(rapidity))
        beta = rapidity / size * np.tanh(min(size, 1.0))
        gamma = 1 / np.sqrt(1 - beta @ beta)
        along = x @ beta
        x = x / gamma + (1 + gamma / (gamma + 1) * along)[:, None] * beta
        x /= np.linalg.norm(x, axis=1, keepdims=True)
    return x
