"""Spherical harmonic fit of vertices at given directions: misfit, validation, and better directions.

Tangential distances have a small weight; the fit is judged by distances along the normals.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import cho_solve, cholesky, solve_triangular
from scipy.linalg.lapack import dtrcon
from scipy.sparse.linalg import LinearOperator, lsmr

from isoembed.arrays import Floats, Indices
from isoembed.meshing.sphere import solid_angles
from isoembed.meshing.sphere_layout import orientations
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.scattered_fit import DEVIATIONS, deviating
from isoembed.smooth.transforms import resized
from isoembed.smooth.two_metric import angle_frame

SIDEWAYS = 0.1  # weight of tangential distances


@dataclass(frozen=True)
class VertexFit:
    """Harmonic fit to the vertices of a mesh.

    Attributes
    ----------
    x, u : ndarray, shape (V, 3)
        Vertices and their directions.
    angles : ndarray, shape (V,)
        Solid angles of the directions.
    used : ndarray, shape (V,)
        1 for the vertices used in the fit, 0 for the others.
    harmonics : Harmonics
    coefficients : ndarray, shape (size, 3)
    """

    x: Floats
    u: Floats
    angles: Floats
    used: Floats
    harmonics: Harmonics
    coefficients: Floats

    @cached_property
    def table(self) -> Floats:
        """Harmonics (V, size) at the directions."""
        return self.harmonics.values(self.u)

    @cached_property
    def _tangents(self) -> tuple[Floats, Floats]:
        """Two tangent vectors of the sphere (V, 2, 3), and their images (V, 2, 3)."""
        e = np.stack(angle_frame(self.u), axis=1)
        first = self.harmonics.derivatives(self.u, self.coefficients)[1]
        return e, e @ first.transpose(0, 2, 1)

    @cached_property
    def normals(self) -> Floats:
        """Unit normals (V, 3) of the surface."""
        n = np.cross(self._tangents[1][:, 0], self._tangents[1][:, 1])
        length = np.linalg.norm(n, axis=1, keepdims=True)
        return n / np.where(length > 0.0, length, 1.0)

    @cached_property
    def residuals(self) -> Floats:
        """Vectors (V, 3) from the surface to the vertices."""
        return self.x - self.table @ self.coefficients

    @cached_property
    def distances(self) -> Floats:
        """Distances (V,) of the vertices along the normals."""
        return np.einsum("ni,ni->n", self.residuals, self.normals)

    @cached_property
    def misfit(self) -> float:
        """Root mean square of the distances."""
        return float(np.sqrt(np.average(self.distances**2, weights=self.weights)))

    @property
    def weights(self) -> Floats:
        """Weights of the vertices (V,)."""
        return self.angles * self.used

    @property
    def validation(self) -> float:
        """Generalized cross-validation score."""
        return (self.misfit / (1.0 - self._freedom / len(self.x))) ** 2

    @property
    def chance(self) -> float:
        """Largest ratio of scores attributed to chance."""
        return 1.0 + float(np.sqrt(8.0 / len(self.x)))

    @property
    def _freedom(self) -> int:
        """Degrees of freedom of normal distances, as of harmonics of about two degrees more."""
        return deviating(self.harmonics).size

    @property
    def is_possible(self) -> bool:
        """Whether the vertices determine all coefficients and the table fits into memory."""
        count = len(self.x)
        # The table of harmonics at vertices must fit into memory.
        if self._freedom > 0.6 * count or self.harmonics.size * count > 100_000_000:
            return False
        return self.is_determined

    def raised(self, degree: int) -> VertexFit:
        """Fit in harmonics of another degree."""
        harmonics = Harmonics(degree, degree)
        coefficients = resized(self.coefficients, self.harmonics, harmonics)
        return replace(self, harmonics=harmonics, coefficients=coefficients)

    def moved(self, change: Floats) -> VertexFit:
        """Fit with a change (size, 3) of the coefficients."""
        return replace(self, coefficients=self.coefficients + change)

    def nearer(self) -> VertexFit:
        """Fit after a Gauss-Newton step that reduces the normal distances."""
        return self.moved(self._weighted_least_squares(self.residuals))

    def corrected(self, faces: Indices) -> VertexFit:
        """Fit of the same surface with the vertices at their nearest points on it."""
        e, images = self._tangents
        q = images @ images.transpose(0, 2, 1)
        pulled = np.einsum("nai,ni->na", images, self.residuals)
        step = np.einsum("na,nai->ni", np.linalg.solve(q, pulled[:, :, None])[:, :, 0], e)
        length = np.linalg.norm(step, axis=1)
        farthest = 0.5 * np.sqrt(4.0 * np.pi / len(self.x))  # half the mean spacing
        step *= (farthest / np.maximum(length, farthest))[:, None]
        u = _moved(self.u, step, faces)
        return replace(self, u=u, angles=solid_angles(u, faces))

    def deviations(self) -> Floats:
        """Random samples of the error, as coefficients (N, size of ``deviating(harmonics)``, 3)."""
        random = np.random.default_rng(0)
        more = deviating(self.harmonics)
        signs = random.choice((-1.0, 1.0), (DEVIATIONS, len(self.x), 1))
        signed = signs * self.distances[:, None] * self.normals
        drawn = np.array([resized(self.least_squares(v), self.harmonics, more) for v in signed])
        higher = more.labels[0] > self.harmonics.degree
        following = self.raised(more.degree)
        size = self.misfit * np.sqrt(4.0 * np.pi / np.count_nonzero(higher))
        if following.is_determined:
            size = float(np.sqrt(np.mean(following.least_squares(self.residuals)[higher] ** 2)))
        drawn[:, higher] = size * random.normal(size=drawn[:, higher].shape)
        return drawn

    @cached_property
    def _root(self) -> Floats:
        return np.sqrt(self.weights)[:, None]

    @cached_property
    def _triangle(self) -> Floats:
        """Cholesky factor R (size, size) of the normal matrix ``R^T R`` of the weighted table."""
        rows = self._root * self.table
        return np.asarray(cholesky(rows.T @ rows))

    @property
    def is_determined(self) -> bool:
        """Whether the vertices determine all coefficients."""
        try:
            R = self._triangle
        except np.linalg.LinAlgError:
            return False
        return float(dtrcon(R)[0]) >= 1e-4  # reciprocal condition

    def least_squares(self, vectors: Floats) -> Floats:
        """Coefficients (size, 3) of the least-squares fit to vectors (V, 3)."""
        pulled = self.table.T @ (self.weights[:, None] * vectors)
        return np.asarray(cho_solve((self._triangle, False), pulled))

    def _weighted_least_squares(self, vectors: Floats) -> Floats:
        """Iterative least squares with a small weight of tangential parts, preconditioned by R."""
        R, n = self._triangle, self.normals

        def weighted(v: Floats) -> Floats:
            along = np.einsum("ni,ni->n", v, n)[:, None] * n
            return self._root * (SIDEWAYS * v + (1.0 - SIDEWAYS) * along)

        def forward(c: Floats) -> Floats:
            return weighted(self.table @ solve_triangular(R, c.reshape(-1, 3))).ravel()

        def backward(v: Floats) -> Floats:
            return solve_triangular(R, self.table.T @ weighted(v.reshape(-1, 3)), trans="T").ravel()

        shape = (self.x.size, 3 * self.harmonics.size)
        operator = LinearOperator(shape, matvec=forward, rmatvec=backward, dtype=np.float64)
        tolerance, max_iterations = 1e-4, 200  # later steps add digits
        right = weighted(vectors).ravel()
        found = lsmr(operator, right, atol=tolerance, btol=tolerance, maxiter=max_iterations)
        return np.asarray(solve_triangular(R, found[0].reshape(-1, 3)))


def _moved(u: Floats, step: Floats, faces: Indices) -> Floats:
    """Unit vectors moved by a step (V, 3), reduced around triangles that would be inverted."""
    share = np.ones((len(u), 1))
    for _ in range(30):  # halve the steps around inverted triangles
        v = u + share * step
        v /= np.linalg.norm(v, axis=1, keepdims=True)
        over = orientations(faces, v) <= 0.0
        if not over.any():
            return v
        share[np.unique(faces[over])] *= 0.5
    return u
