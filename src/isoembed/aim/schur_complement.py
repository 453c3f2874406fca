"""Schur complement of a patch: its energy, with all other vertices eliminated to first order.

Near a minimum of ``|r|^2 + mu |R x|^2`` (`isoembed.aim.regularized_energy`) the energy is quadratic for small
motions.  If the vertices of a patch change sides, only the edges among them leave that regime.  These edges
are therefore kept nonlinear, all other terms are expanded to second order, and the vertices outside are
eliminated by minimizing the energy.  The result is a function of the patch alone, with a dense matrix, the
Schur complement.  It is computed from a block of the inverse of Newton's matrix, whose factors are shared by
all patches of the surface.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import count

import numpy as np
from scipy.linalg import LinAlgError, cho_factor, cho_solve

from isoembed.aim.patch_edges import PatchEdges
from isoembed.aim.regularized_energy import RegularizedEnergy
from isoembed.arrays import Floats, Indices
from isoembed.linalg import SingularMatrix, SymmetricFactor
from isoembed.nonlinear.acceptance import Damping
from isoembed.nonlinear.descent import Curve, descend
from isoembed.nonlinear.newton import damped_step
from isoembed.surface.rigidity import edge_rows
from isoembed.surface.vertex_system import HeldTriangle

COLUMNS = 96  # simultaneous right-hand sides for the inverse
EARLY = 4  # steps before unsuccessful trials are abandoned
SETTLED = 1e-3  # decrease of the last step, relative to the change of the energy


class Condensation:
    """The energy about a minimum, its second derivatives factored.

    Parameters
    ----------
    energy : RegularizedEnergy
        Energy of a metric in Euclidean space.
    vertices : ndarray, shape (V, 3)
        A minimum, or nearly.
    lengths : ndarray, shape (E,)
    mu : float
    spend : callable
        Called with the cost of each solve, in factorizations.

    Raises
    ------
    SingularMatrix
        The matrix is not definite to working precision, even without edges in compression.
    """

    def __init__(
        self,
        energy: RegularizedEnergy,
        vertices: Floats,
        lengths: Floats,
        mu: float,
        spend: Callable[[float], None],
    ) -> None:
        self.energy, self.vertices, self.lengths, self.mu, self.spend = energy, vertices, lengths, mu, spend
        self.value = energy.value(vertices, lengths, mu)
        self.residuals = energy.residuals(vertices, lengths)
        self.tensions = self.residuals / lengths
        self.rows = edge_rows(energy.triangulation, vertices, lengths)
        self.clamped = HeldTriangle.of(vertices, energy.quiet_triangle(vertices, lengths))
        try:
            self._factor = self._factored()
        except SingularMatrix:
            self.tensions = np.maximum(self.tensions, 0.0)
            self._factor = self._factored()

    def _factored(self) -> SymmetricFactor:
        return self.energy.newton_factor(self.vertices, self.lengths, self.mu, self.tensions, self.clamped)

    def solve(self, forces: Floats) -> Floats:
        """Motions, (V, 3, k), caused by forces, (V, 3, k)."""
        flat = forces.reshape(-1, forces.shape[-1])
        self.spend(0.015 * flat.shape[1])  # factorizations that a column costs
        return self._factor.solve(flat, sweeps=0).reshape(forces.shape)

    def patch(self, vertices: Indices) -> CondensedPatch:
        """Energy of a patch, vertices ascending, with all others eliminated; raises SingularMatrix."""
        n, of = len(self.vertices), (3 * vertices[:, None] + np.arange(3)).ravel()
        block = np.empty((of.size, of.size))  # of the inverse
        for first in range(0, of.size, COLUMNS):
            chosen = of[first : first + COLUMNS]
            forces = np.zeros((3 * n, chosen.size))
            forces[chosen, np.arange(chosen.size)] = 1.0
            moved = self.solve(forces.reshape(n, 3, -1)).reshape(3 * n, -1)
            block[:, first : first + chosen.size] = moved[of]
        try:
            factor = cho_factor((block + block.T) / 2, lower=True)
        except LinAlgError:
            raise SingularMatrix("the inverse of Newton's matrix is not definite") from None
        place = np.full(n, -1)
        place[vertices] = np.arange(len(vertices))
        ends = place[self.energy.triangulation.edges]
        inside = np.flatnonzero((ends >= 0).all(axis=1))
        edges = PatchEdges(ends[inside], self.lengths[inside], len(vertices))
        return CondensedPatch(self, vertices, inside, edges, cho_solve(factor, np.eye(of.size)))


@dataclass(frozen=True, eq=False)
class CondensedPatch:
    """The energy as a function of how some vertices move, all others following.

    Attributes
    ----------
    surface : Condensation
    vertices : ndarray of int, shape (n,)
    inside : ndarray of int, shape (m,)
        The edges among them.
    edges : PatchEdges
        These edges.
    stiffness : ndarray, shape (3n, 3n)
        Half the second derivatives for small motions: the Schur complement.
    """

    surface: Condensation
    vertices: Indices
    inside: Indices
    edges: PatchEdges
    stiffness: Floats

    @cached_property
    def _outside(self) -> tuple[Floats, Floats]:
        """Contributions from other than the edges inside: the matrix, and the forces at rest, (n, 3)."""
        surface, inside = self.surface, self.inside
        rows = surface.rows[inside]
        matrix = self.stiffness - self.edges.hessian(rows, surface.tensions[inside])
        for corner, block in zip(*surface.clamped, strict=True):  # vertices that move far are not clamped
            for place in np.flatnonzero(self.vertices == corner):
                own = slice(3 * place, 3 * place + 3)
                matrix[own, own] -= block
        return matrix, -self.edges.forces(rows, surface.residuals[inside])

    def _errors(self, motion: Floats) -> tuple[Floats, Floats]:
        """The errors r of the edges inside, and their rows of J."""
        x = self.surface.vertices[self.vertices] + motion
        a, b = self.edges.ends.T
        return self.edges.errors(x[a] - x[b])

    def change(self, motion: Floats) -> float:
        """Change of the energy with a motion, (n, 3), of the vertices."""
        matrix, forces = self._outside
        r, before, d = self._errors(motion)[0], self.surface.residuals[self.inside], motion.ravel()
        return float((r - before) @ (r + before) + d @ (matrix @ d) + 2 * np.sum(forces * motion))

    def relaxed(self, motion: Floats) -> tuple[Floats, float]:
        """The local minimum near a motion, (n, 3), and by how much the energy has grown there."""
        matrix, forces = self._outside
        share = len(self.vertices) / len(self.surface.vertices)
        lowest, steps = self.surface.value, count(-EARLY)  # of those that may lead nowhere

        def step(d: Floats) -> Curve[Floats]:
            r, rows = self._errors(d)
            gradient = self.edges.forces(rows, r).ravel() + forces.ravel() + matrix @ d.ravel()
            hessian = matrix + self.edges.hessian(rows, r / self.edges.lengths)

            def damped(damping: float) -> Floats:
                # Factorizations that a step costs whose matrix is that of all vertices.
                self.surface.spend(0.15 * share)
                return d - damped_step(hessian, gradient, damping).reshape(-1, 3)

            return damped

        def leads_nowhere(_: Floats, value: float, before: float) -> bool:
            # Growth of the energy after the first steps, and its factor with each further one.
            k = next(steps) - 1
            return k >= 0 and value > 3e3 * 0.25**k * lowest

        found = descend(
            motion,
            step,
            Damping(1e-6, stiffer=4.0, softer=0.125, largest=10.0),  # stiffness of an edge
            value=self.change,
            converged=lambda _, value, before: before - value < SETTLED * (abs(value) + lowest * SETTLED),
            stalled=leads_nowhere,
            max_iterations=15,
        )
        return found.point, found.value

    def followed(self, motion: Floats) -> Floats:
        """Motion of all vertices, (V, 3), that follows a motion of these, (n, 3)."""
        surface = self.surface
        forces = np.zeros_like(surface.vertices)
        forces[self.vertices] = (self.stiffness @ motion.ravel()).reshape(-1, 3)
        moved = surface.solve(forces[:, :, None])[:, :, 0]
        moved[self.vertices] = motion
        return moved
