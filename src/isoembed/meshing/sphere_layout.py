"""Low-distortion parametrization of triangulations over the unit sphere.

A conformal layout preserves angles, but maps long arms of a surface to tiny regions of the sphere, where
functions on the surface have high frequencies.  Starting from it, the symmetric Dirichlet energy is
minimized, the mean of ``s1^2 + s2^2 + s1^-2 + s2^-2`` over the surface, where s1 and s2 are the singular
values of the map of a triangle: it is infinite for degenerate triangles, so that no triangle is inverted.

References
----------
J. Smith and S. Schaefer, Bijective parameterization with free boundaries, ACM TOG 34 (2015).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.sparse import coo_array, csc_array, diags_array

from isoembed.arrays import Floats, Indices
from isoembed.linalg import SingularMatrix, SymmetricFactor, analyze, dissect
from isoembed.mesh.triangulation import Triangulation
from isoembed.metric.conformal_sphere import ConformalSphere, conformal_factors, conformal_sphere
from isoembed.metric.delaunay import delaunay
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.metric.triangles import Triangles
from isoembed.progress.stages import Log, StageRecorder


def sphere_layout(metric: PolyhedralMetric) -> Floats:
    """Unit vectors (V, 3) of the vertices with little distortion and outward triangles.

    Parameters
    ----------
    metric : PolyhedralMetric

    Returns
    -------
    ndarray, shape (V, 3)
        Layout in which all triangles of the Delaunay triangulation are oriented outward, if that has a
        discretely conformal layout without further flips; otherwise the conformal layout.
    """
    fine = delaunay(metric)
    u = conformal_sphere(fine, StageRecorder("layout", Log())).points
    if np.median(orientations(fine.faces, u)) < 0.0:
        u = -u
    return least_distorted(fine, u)


def least_distorted(metric: PolyhedralMetric, u: Floats) -> Floats:
    """Unit vectors (V, 3) that minimize the symmetric Dirichlet energy of the triangles.

    Parameters
    ----------
    metric : PolyhedralMetric
    u : ndarray, shape (V, 3)
        Initial unit vectors.  If some triangle is not oriented outward, they are returned unchanged.

    Notes
    -----
    By continuation, the metric changes conformally from nearly that of the sphere to the given one: crowded
    regions of the sphere expand gradually.
    """
    if not are_outward(metric.faces, u):
        return u
    factors = conformal_factors(metric.normalized, ConformalSphere(u, True))
    stages = max(1, int(np.ceil(np.ptp(factors))))  # the log factor changes by at most 1 at a time
    i, j = metric.edges.T
    exponents = 0.5 * (factors[i] + factors[j])
    for part in np.arange(stages - 1, -1, -1) / stages:
        lengths = metric.normalized.lengths * np.exp(part * exponents)
        triangles = Triangles.of(lengths[metric.triangulation.face_edges])
        if triangles.excess.min() > 0.0:
            u = _minimized(_Distortion(metric.triangulation, triangles), u)
    return u


def _minimized(energy: _Distortion, u: Floats) -> Floats:
    """Unit vectors (V, 3) of a local minimum of the energy near u (V, 3).

    L-BFGS, preconditioned by the Laplacian of the surface with the energy's weights.
    """
    value, slope, weights = energy.at(u)
    memory = _Memory()
    for step in range(200):  # steps at most
        if step % 10 == 0 or step < 10:  # a new preconditioner
            try:
                factor = energy.preconditioner(weights)
            except SingularMatrix:
                return u
        search = _tangent(memory.direction(slope, factor), u)
        decrease = float(np.sum(search * slope))
        if decrease <= 0.0:
            memory, search = _Memory(), slope
            decrease = float(np.sum(slope * slope))
        length = 1.0
        while True:
            v = u - length * search
            v /= np.linalg.norm(v, axis=1, keepdims=True)
            new, new_slope, weights = energy.at(v)
            if new <= value - 1e-4 * length * decrease:  # Armijo's condition
                break
            length /= 2.0
            if length < 1e-10:  # no descent
                return u
        memory.add(v - u, new_slope - slope)
        settled = value - new <= 1e-5 * value  # negligible decrease
        u, value, slope = v, new, new_slope
        if settled:
            break
    return u


class _Distortion:
    """Symmetric Dirichlet energy of maps from triangles to the unit sphere, scaled to equal total area."""

    def __init__(self, triangulation: Triangulation, triangles: Triangles) -> None:
        self.triangulation, self.faces = triangulation, triangulation.faces
        # The side opposite to corner faces[f, c] is that from c + 1 to c + 2.
        self.cotangents = triangles.cotangents
        self.areas = triangles.areas * (4.0 * np.pi / triangles.areas.sum())

    def at(self, u: Floats) -> tuple[float, Floats, Floats]:
        """Energy, its gradient (V, 3) along the sphere, and the triangles' weights (F,) in it.

        The energy is infinite if a triangle is not oriented outward.
        """
        if not are_outward(self.faces, u):
            return np.inf, np.zeros_like(u), np.zeros(len(self.faces))
        corners = u[self.faces]
        sides = np.roll(corners, -2, axis=1) - np.roll(corners, -1, axis=1)
        normals = np.cross(sides[:, 0], sides[:, 1])
        areas = 0.5 * np.linalg.norm(normals, axis=1)
        dirichlet = 0.5 * np.einsum("fc,fci,fci->f", self.cotangents, sides, sides)
        inverse = (self.areas / areas) ** 2
        weights = 1.0 + inverse
        pulls = (weights[:, None] * self.cotangents)[:, :, None] * sides
        # The derivative of an area is half of the unit normal times the opposite side.
        pushes = np.cross(normals[:, None], sides) * (-0.5 * dirichlet * inverse / areas**2)[:, None, None]
        forces = np.roll(pulls, 2, axis=1) - np.roll(pulls, 1, axis=1) + pushes
        slope = np.zeros_like(u)
        np.add.at(slope, self.faces, forces)
        return float(dirichlet @ weights), _tangent(slope, u), weights

    def preconditioner(self, weights: Floats) -> SymmetricFactor:
        """Factorized Laplacian of the surface with these weights of the triangles."""
        # edge weights are kept positive
        across = np.maximum(np.roll(self.cotangents, 1, axis=1), 0.05) * weights[:, None]
        i, j = self.faces, np.roll(self.faces, -1, axis=1)
        n = self.triangulation.n_vertices
        half = coo_array((across.ravel(), (i.ravel(), j.ravel())), shape=(n, n)).tocsr()
        edges = half + half.T
        diagonal = edges.sum(axis=1) + 1e-3 * weights.mean()  # makes the matrix definite
        matrix = csc_array(diags_array(diagonal) - edges)
        matrix.sort_indices()
        return self._solver.factor(2.0 * matrix.data)

    @cached_property
    def _solver(self):  # type: ignore[no-untyped-def]
        graph = self.triangulation.adjacency + diags_array(np.ones(self.triangulation.n_vertices))
        return analyze(csc_array(graph), dissect(self.triangulation.adjacency).vertex_order())


@dataclass
class _Memory:
    """Last steps and gradient changes of L-BFGS."""

    pairs: list[tuple[Floats, Floats]] = field(default_factory=list)

    def add(self, step: Floats, change: Floats) -> None:
        if np.sum(step * change) > 0.0:
            self.pairs = [*self.pairs, (step, change)][-8:]  # pairs of L-BFGS

    def direction(self, slope: Floats, factor: SymmetricFactor) -> Floats:
        """Search direction by the two-loop recursion of L-BFGS."""
        q, shares = slope.copy(), []
        for step, change in reversed(self.pairs):
            share = np.sum(step * q) / np.sum(step * change)
            shares.append(share)
            q -= share * change
        z = factor.solve(q)
        for (step, change), share in zip(self.pairs, reversed(shares), strict=True):
            z += step * (share - np.sum(change * z) / np.sum(step * change))
        return z


def are_outward(faces: Indices, u: Floats) -> bool:
    """Whether all triangles (F, 3) between unit vectors (V, 3) are oriented outward."""
    return bool((orientations(faces, u) > 0.0).all())


def orientations(faces: Indices, u: Floats) -> Floats:
    """Six times the volumes (F,) of the tetrahedra from the center: positive for outward triangles."""
    a, b, c = u[faces].transpose(1, 0, 2)
    return np.asarray(np.einsum("fi,fi->f", a, np.cross(b, c)))


def _tangent(vectors: Floats, u: Floats) -> Floats:
    """Tangential components of vectors (n, 3) on the unit sphere at u (n, 3)."""
    return vectors - np.einsum("ni,ni->n", vectors, u)[:, None] * u
