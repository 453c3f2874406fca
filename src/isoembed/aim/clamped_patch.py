"""Clamped patch: vertices that move while the rest of the surface is fixed, their energy and its minima.

The energy is that of `isoembed.aim.regularized_energy`.  Patches are small: their matrices are dense.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import LinAlgError, cho_factor, cho_solve
from scipy.sparse import csr_array

from isoembed.aim.accuracy import SOFTER, STIFFER
from isoembed.aim.regularized_energy import RegularizedEnergy
from isoembed.arrays import Floats, Indices


@dataclass(frozen=True, eq=False)
class ClampedPatch:
    """The energy as a function of a few vertices, the others being held.

    Attributes
    ----------
    spend : callable
        Told of each factorization, by its share of the surface's vertices.
    vertices : ndarray of int, shape (n,)
        Those that move.
    edges, lengths : ndarray, shape (m, 2), (m,)
        Edges that change, and the lengths that they are to have.
    place : ndarray of int, shape (m, 2)
        The ends of edges among the vertices; n where they are held.
    rows : sparse, shape (k, V)
        The rows of R that change.
    columns : ndarray, shape (k, n)
        Their columns.
    stiffness : ndarray, shape (n, n)
        ``mu R^T R``.
    mu : float
    """

    spend: Callable[[float], None]
    vertices: Indices
    edges: Indices
    lengths: Floats
    place: Indices
    rows: csr_array
    columns: Floats
    stiffness: Floats
    mu: float

    @classmethod
    def of(
        cls,
        energy: RegularizedEnergy,
        lengths: Floats,
        vertices: Indices,
        mu: float,
        spend: Callable[[float], None],
    ) -> ClampedPatch:
        """That of these vertices."""
        triangulation, R = energy.triangulation, energy.fit_residuals
        n = len(vertices)
        changing = np.unique(triangulation.incidence[vertices].indices)
        edges = triangulation.edges[changing]
        place = np.full(triangulation.n_vertices, n)
        place[vertices] = np.arange(n)
        rows = R[np.unique(energy.fit_residuals_transposed[vertices].indices)]
        columns = rows[:, vertices].toarray()
        stiffness = mu * (columns.T @ columns)
        return cls(spend, vertices, edges, lengths[changing], place[edges], rows, columns, stiffness, mu)

    def value(self, x: Floats) -> float:
        """The part of the energy that changes."""
        r, rough, _ = self._terms(x)
        return float(r @ r + self.mu * np.sum(rough**2))

    def offset(self, x: Floats, disk: Indices) -> Floats:
        """What is to be added to vertices of the patch for R x to be least, shape (k, 3)."""
        of = np.searchsorted(self.vertices, disk)
        columns = self.columns[:, of]
        return -np.linalg.lstsq(columns, self.rows @ x, rcond=None)[0]

    def relaxed(
        self,
        x: Floats,
        steps: int = 12,
        settled: float = 0.002,  # relative decrease of the energy
    ) -> tuple[Floats, float]:
        """The local minimum near x, and its part of the energy, by Levenberg-Marquardt."""
        n, damping = len(self.vertices), 1e-3  # Levenberg-Marquardt
        r, rough, directions = self._terms(x)
        value = float(r @ r + self.mu * np.sum(rough**2))
        held = np.kron(self.stiffness, np.eye(3))
        for _ in range(steps):
            gradient = self.mu * (self.columns.T @ rough)
            blocks = np.zeros((n + 1, n + 1, 3, 3))
            pull = np.zeros((n + 1, 3))
            products = np.einsum("ei,ej->eij", directions, directions)
            for sign, end in ((1.0, 0), (-1.0, 1)):
                np.add.at(pull, self.place[:, end], sign * directions * r[:, None])
                np.add.at(blocks, (self.place[:, end], self.place[:, end]), products)
            blocks[self.place[:, 0], self.place[:, 1]] -= products
            blocks[self.place[:, 1], self.place[:, 0]] -= products
            matrix = blocks[:n, :n].transpose(0, 2, 1, 3).reshape(3 * n, 3 * n) + held
            gradient = (gradient + pull[:n]).ravel()
            for _ in range(6):
                self.spend(n / len(x))
                matrix_damped = matrix.copy()
                matrix_damped[np.diag_indices(3 * n)] += damping
                try:
                    factor = cho_factor(matrix_damped, overwrite_a=True, check_finite=False)
                except LinAlgError:
                    damping *= STIFFER
                    continue
                trial = x.copy()
                trial[self.vertices] -= cho_solve(factor, gradient, check_finite=False).reshape(-1, 3)
                r_trial, rough_trial, directions_trial = self._terms(trial)
                reached = float(r_trial @ r_trial + self.mu * np.sum(rough_trial**2))
                if reached < value:
                    break
                damping *= STIFFER
            else:
                return x, value
            enough = value - reached < settled * value
            x, r, rough, directions, value = trial, r_trial, rough_trial, directions_trial, reached
            damping *= SOFTER
            if enough:
                break
        return x, value

    def _terms(self, x: Floats) -> tuple[Floats, Floats, Floats]:
        """Errors of the lengths, R x, and the nonzeros of J."""
        d = x[self.edges[:, 0]] - x[self.edges[:, 1]]
        lengths = self.lengths
        r = (np.einsum("ei,ei->e", d, d) - lengths**2) / (2 * lengths)
        return r, self.rows @ x, d / lengths[:, None]
