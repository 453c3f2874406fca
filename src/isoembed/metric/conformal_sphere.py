"""Discrete conformal map of a polyhedral metric to the unit sphere.

Two metrics on one triangulation are discretely conformally equivalent if their lengths differ by a factor
``e^{(u_a + u_b) / 2}`` per edge; on the sphere and in the hyperbolic plane this holds for the chords
``2 sn(l / 2)``, which replace the lengths here.  One vertex is removed and the rest flattened into the plane,
a convex problem in u; stereographic projection back is also a conformal equivalence; a Moebius transformation
centers the result.  The chords of the layout are then the lengths of an equivalent metric with an exact
embedding.

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
    """Layout on the unit sphere.

    Attributes
    ----------
    points : ndarray, shape (V, 3)
        Points on the unit sphere, centered: their area-weighted mean vanishes.
    exact : bool
        Whether the layout is discretely conformal.  If not (required flips were impossible), it is Tutte's
        embedding.
    """

    points: Floats
    exact: bool


def conformal_sphere(metric: PolyhedralMetric, recorder: StageRecorder) -> ConformalSphere:
    """Lay the metric out on the unit sphere.

    Parameters
    ----------
    metric : PolyhedralMetric
        Preferably on a Delaunay triangulation: see `isoembed.metric.delaunay.delaunay`.
    recorder : StageRecorder
        Counter of Newton steps and factorizations.

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
    # The star of the pole is never flipped; if that leaves triangles broken, other poles are tried.
    for pole in np.argsort(-triangulation.degrees, kind="stable")[:5]:
        plane = _Plane(triangulation, lengths, int(pole), recorder.work)
        plane, u, exact = _flattened(plane, plane.start(), recorder)
        if exact:
            break
    weights = _vertex_weights(metric)
    if exact:
        x = _centered(_projected(plane.lay_out(u), plane.pole), weights)
        a, b = metric.edges.T
        # Metrics so long and thin that neighbors coincide on the sphere within rounding have no layout.
        if (np.linalg.norm(x[a] - x[b], axis=1) > 1e-12).all():  # neighbors are distinct
            return ConformalSphere(x, True)
    return ConformalSphere(_centered(_projected(plane.tutte(), plane.pole), weights), False)


def _projected(z: Points, pole: int) -> Floats:
    """Stereographic projection of points from the plane to the unit sphere, with the pole at infinity."""
    others = np.delete(z, pole)
    z = z - np.median(others.real) - 1j * np.median(others.imag)
    z /= np.median(np.abs(np.delete(z, pole)))
    square = np.abs(z) ** 2
    x = np.column_stack([2 * z.real, 2 * z.imag, square - 1]) / (1 + square)[:, None]
    x[pole] = [0, 0, 1]
    return x


def conformal_factors(metric: PolyhedralMetric, sphere: ConformalSphere) -> Floats:
    """Factors u_a of ``|x_a - x_b| = l_ab e^{(u_a + u_b) / 2}``, shape (V,), averaged over the corners at a.

    On the sphere and in the hyperbolic plane l_ab is the chord.

    Parameters
    ----------
    metric : PolyhedralMetric
        Metric with lengths of order 1.
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
    """Metric without its pole, to be flattened: unknowns u at the vertices outside the pole's star."""

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
        # With this u all spokes have the same length: the pole goes to infinity.
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
        """Angle sums (V,), cotangent weights (E,), lengths (E,), and whether triangles are broken.

        A triangle that violates the triangle inequality has the angles pi, 0, 0: the problem stays convex.
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
        """Solve ``L y = right`` for y (V, k), with the weighted Laplacian L and y given on the ring."""
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
        """Initial u from the linearized (Poisson) equation, or 0 if it breaks triangles."""
        if len(self.inner) == 0:
            return self.rim_u
        sums, weights, _, _ = self.measure(np.zeros(self.triangulation.n_vertices))
        try:
            u = self.solve(weights, (sums - 2 * np.pi)[:, None], self.rim_u[:, None])[:, 0]
        except SingularMatrix:  # needles
            return self.rim_u
        # larger factors do not fit on the sphere
        return u if np.abs(u).max() < 40.0 and not self.measure(u)[3] else self.rim_u

    def whole(self, u: Floats) -> tuple[_Plane, tuple[Floats, Floats, Floats, bool]]:
        """Conformal class on triangles that are not broken at u, and its measures.

        Broken triangles are replaced by Delaunay triangles at u, by Ptolemaic flips.  From then on they are
        kept Delaunay: otherwise the layout would depend on the choice of flipped edges.
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
        """Lay out the ring by its lengths and angles, and the other vertices by harmonic extension."""
        sums, weights, lengths, _ = self.measure(u)
        sides = self.triangulation.edge_indices(np.column_stack([self.ring, np.roll(self.ring, -1)]))
        direction = np.cumsum(np.pi - sums[self.ring])
        steps = lengths[sides] * np.exp(1j * direction)
        return self._extended(np.concatenate([[0], np.cumsum(steps)[:-1]]), weights)

    def tutte(self) -> Points:
        """Tutte embedding in a regular polygon, vertices at means of their neighbors, for any lengths."""
        corners = np.exp(2j * np.pi * np.arange(len(self.ring)) / len(self.ring))
        return self._extended(corners, np.ones(self.triangulation.n_edges))

    def _extended(self, corners: Points, weights: Floats) -> Points:
        z = np.zeros((self.triangulation.n_vertices, 2))
        z[self.ring] = np.column_stack([corners.real, corners.imag])
        if len(self.inner):
            z = self.solve(weights, np.zeros_like(z), z)
        return z[:, 0] + 1j * z[:, 1]


def _flattened(plane: _Plane, u: Floats, recorder: StageRecorder) -> tuple[_Plane, Floats, bool]:
    """Minimize the convex energy with gradient ``2 pi - (angle sum)`` by Newton's method.

    Returns the plane, possibly with flipped triangles, u, and whether the surface is flat without broken
    triangles.
    """
    inner, zero = plane.inner, np.zeros((len(u), 1))
    plane, (sums, weights, _, broken) = plane.whole(u)
    for _ in range(50):  # Newton steps
        g = np.zeros(len(u))
        g[inner] = 2 * np.pi - sums[inner]
        recorder.show(residual=float(np.abs(g).max()))
        if np.abs(g).max() < 1e-10:  # deficits within rounding
            return plane, u, not broken
        if broken:  # degenerate triangles have no second derivative: keep the matrix definite
            weights = weights + 1e-3  # degenerate triangles have zero cotangents
        try:
            step = plane.solve(weights, -g[:, None], zero)[:, 0]
        except SingularMatrix:  # needles
            return plane, u, False
        recorder.iterations += 1
        # a Newton step changes each factor by at most e^2
        slope, s = step @ g, min(1.0, 2.0 / np.abs(step).max())
        while True:  # a convex function decreases as long as its slope is negative
            trial, (sums, weights, _, broken) = plane.whole(u + s * step)
            if step[inner] @ (2 * np.pi - sums[inner]) <= 0.9 * abs(slope):
                break
            s /= 2
            if s < 1e-6:
                return plane, u, False
        plane, u = trial, u + s * step
    return plane, u, False


def _ring(triangulation: Triangulation, pole: int) -> Indices:
    """Neighbors of the pole, counterclockwise as seen from the rest of the surface."""
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
    """Center points on the sphere by a Moebius transformation, so that their weighted mean vanishes.

    Newton's method on boosts: the center minimizes a convex function on hyperbolic space (Springborn, A
    unique representation of polyhedral types, 2005).
    """
    for _ in range(100):
        mean = weights @ x
        if np.linalg.norm(mean) < 1e-12:  # the points are centered
            break
        rapidity = -np.linalg.solve(np.eye(3) - (weights[:, None] * x).T @ x, mean)
        size = float(np.linalg.norm(rapidity))
        beta = rapidity / size * np.tanh(min(size, 1.0))
        gamma = 1 / np.sqrt(1 - beta @ beta)
        along = x @ beta
        x = x / gamma + (1 + gamma / (gamma + 1) * along)[:, None] * beta
        x /= np.linalg.norm(x, axis=1, keepdims=True)
    return x
