"""Regularized energy for fits, with conjugate gradients preconditioned by factors of earlier steps.

The matrix of a step, ``J^T J + mu R^T R``, fills more than the one with K in the place of R, but with its
factors conjugate gradients converge at once, and in some ten iterations on other surfaces nearby and with a
mu a little smaller or larger.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from isoembed.aim.regularized_energy import MAX_ITERATIONS, RegularizedEnergy
from isoembed.arrays import Floats
from isoembed.linalg import SingularMatrix, SymmetricFactor
from isoembed.linalg.krylov import conjugate_gradients
from isoembed.surface.projected import Projected

SOLVED = 1e-3  # relative residual of linear equations, for estimates
STEPPED = 1e-6  # of those for steps: with 1e-3, fits would change by 1e-6 with rounding
WORTH = 30  # iterations that cost as much as new factors
PATIENCE = 4  # iterations before it is judged whether WORTH of them will do
NEAR = 5.0  # ratio of mu to that of the factors, beyond which others are made at once


class SmoothingEnergy(RegularizedEnergy):
    """The energy ``|r|^2 + mu |R x|^2``, with factors that are kept as long as they serve.

    The parameters are those of `RegularizedEnergy`.
    """

    _factor: SymmetricFactor | None = None
    _weight = 0.0  # mu of the factors

    def solver(
        self, vertices: Floats, lengths: Floats, mu: float, w: float, tensions: Floats | float = 0.0
    ) -> Callable[[Floats], Floats]:
        """See `RegularizedEnergy.solver`; w is 0, and no edge has a tension."""
        return self._solver(vertices, lengths, mu, SOLVED)

    def solved(self, vertices: Floats, lengths: Floats, gradient: Floats, mu: float, w: float) -> Floats:
        """See `RegularizedEnergy.solved`."""
        return self._solver(vertices, lengths, mu, STEPPED)(gradient)

    def _solver(
        self, vertices: Floats, lengths: Floats, mu: float, tolerance: float
    ) -> Callable[[Floats], Floats]:
        surface = Projected.of(self.space, vertices)
        rows, fixed = self._rows(vertices, lengths), surface.without_isometries()
        a, b = self.triangulation.edges.T

        def product(z: Floats) -> Floats:
            stretch = np.einsum("ij,ij->i", rows, z[a] - z[b])
            pull = surface.motion(mu * self.roughness(surface.motion(z), 0.0))
            forces = self.triangulation.incidence @ (rows * stretch[:, None])
            return fixed((forces + pull).ravel()).reshape(-1, 3)

        def solve(gradient: Floats) -> Floats:
            forces = fixed(surface.motion(gradient).ravel()).reshape(-1, 3)
            if not self._weight / NEAR < mu < self._weight * NEAR:
                self._factor = None
            for most, patience in ((WORTH, PATIENCE), (MAX_ITERATIONS, None)):
                if self._factor is None:
                    self._factor, self._weight = self._newton_system.penalized(rows, mu, surface), mu
                    most, patience = MAX_ITERATIONS, None
                factor = self._factor

                def precondition(g: Floats, factor: SymmetricFactor = factor) -> Floats:
                    return fixed(factor.solve(g.ravel(), sweeps=0)).reshape(-1, 3)

                found = conjugate_gradients(product, precondition, forces, tolerance, most, patience=patience)
                if found.residual <= tolerance or patience is None:
                    break
                self._factor = None  # its memory is free for the next
            if not np.isfinite(found.x).all():
                raise SingularMatrix("conjugate gradients broke down")
            return surface.motion(found.x)

        return solve
