"""Clamped patch: energy minimization over the vertices of a patch, with the rest of the surface fixed.

The energy is that of `isoembed.aim.regularized_energy`.  Patches are small: their matrices are dense.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array

from isoembed.aim.patch_edges import PatchEdges
from isoembed.aim.regularized_energy import RegularizedEnergy
from isoembed.arrays import Floats, Indices
from isoembed.nonlinear.acceptance import Damping
from isoembed.nonlinear.descent import Curve, descend
from isoembed.nonlinear.newton import damped_step
from isoembed.nonlinear.stopping import settled


@dataclass(frozen=True, eq=False)
class ClampedPatch:
    """The energy as a function of a few vertices, with all others fixed.

    Attributes
    ----------
    spend : callable
        Called for each factorization, with the patch's share of all vertices.
    vertices : ndarray of int, shape (n,)
        The free vertices.
    ends : ndarray, shape (m, 2)
        End vertices of the edges that change.
    edges : PatchEdges
        The edges that change.
    rows : sparse, shape (k, V)
        The rows of R that change.
    columns : ndarray, shape (k, n)
        Their columns for the free vertices.
    stiffness : ndarray, shape (n, n)
        ``mu R^T R``.
    mu : float
    """

    spend: Callable[[float], None]
    vertices: Indices
    ends: Indices
    edges: PatchEdges
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
        """Clamp all vertices except these."""
        triangulation, R = energy.triangulation, energy.fit_residuals
        n = len(vertices)
        changing = np.unique(triangulation.incidence[vertices].indices)
        ends = triangulation.edges[changing]
        place = np.full(triangulation.n_vertices, n)
        place[vertices] = np.arange(n)
        rows = R[np.unique(energy.fit_residuals_transposed[vertices].indices)]
        columns = rows[:, vertices].toarray()
        stiffness = mu * (columns.T @ columns)
        edges = PatchEdges(place[ends], lengths[changing], n)
        return cls(spend, vertices, ends, edges, rows, columns, stiffness, mu)

    def value(self, x: Floats) -> float:
        """The variable part of the energy."""
        return self._value(self._terms(x))

    def offset(self, x: Floats, disk: Indices) -> Floats:
        """Displacements of vertices of the patch that minimize |R x|, shape (k, 3)."""
        of = np.searchsorted(self.vertices, disk)
        columns = self.columns[:, of]
        return -np.linalg.lstsq(columns, self.rows @ x, rcond=None)[0]

    def relaxed(
        self,
        x: Floats,
        steps: int = 12,
        share: float = 0.002,  # relative decrease of the energy
    ) -> tuple[Floats, float]:
        """Local minimum near x and its variable part of the energy, by the Levenberg-Marquardt method."""
        n, stiffness = len(self.vertices), np.kron(self.stiffness, np.eye(3))

        def step(at: _Terms) -> Curve[_Terms]:
            matrix = self.edges.hessian(at.directions) + stiffness
            pull = self.edges.forces(at.directions, at.residuals)
            gradient = (self.mu * (self.columns.T @ at.rough) + pull).ravel()

            def damped(damping: float) -> _Terms:
                self.spend(n / len(x))
                trial = at.x.copy()
                trial[self.vertices] -= damped_step(matrix, gradient, damping).reshape(-1, 3)
                return self._terms(trial)

            return damped

        found = descend(
            self._terms(x),
            step,
            Damping(1e-3, tries=6),
            value=self._value,
            converged=settled(share),
            max_iterations=steps,
        )
        return found.point.x, found.value

    def _terms(self, x: Floats) -> _Terms:
        errors, directions = self.edges.errors(x[self.ends[:, 0]] - x[self.ends[:, 1]])
        return _Terms(x, errors, self.rows @ x, directions)

    def _value(self, at: _Terms) -> float:
        return float(at.residuals @ at.residuals + self.mu * np.sum(at.rough**2))


class _Terms(NamedTuple):
    """A surface, the errors of its lengths, R x, and the nonzeros of J."""

    x: Floats
    residuals: Floats
    rough: Floats
    directions: Floats
