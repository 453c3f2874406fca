"""Minimization of the regularized energy for fits: steps without rotations, by factors of earlier steps.

The matrix of a step, ``J^T J + mu R^T R``, has more fill than the one with K in place of R, but with its
factors conjugate gradients converge immediately, and in about ten iterations for nearby surfaces and slightly
different mu.

Rotations change neither lengths nor roughness, but R takes an infinitesimal rotation to the rotated ``R x``,
so that solutions of these equations contain rotations, which stretch the surface to second order.  Without
them the quadratic model of a step is nearly exact, and few steps lead to the minimum.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array

from isoembed.aim.regularized_energy import MAX_ITERATIONS, RegularizedEnergy
from isoembed.arrays import Floats
from isoembed.linalg import SingularMatrix, SymmetricFactor, Work
from isoembed.linalg.krylov import conjugate_gradients
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.nonlinear.acceptance import LineSearch
from isoembed.nonlinear.descent import Curve, descend
from isoembed.nonlinear.stopping import settled
from isoembed.progress.stages import StageRecorder
from isoembed.surface.projected import Projected
from isoembed.surface.vertex_system import VertexSystem

SOLVED = 1e-3  # relative residual of linear equations, for estimates
STEPPED = 1e-6  # for steps; with 1e-3, fits would change by 1e-6 with rounding
WORTH = 0.6  # iterations worth a new factorization, over the square root of the number of vertices
PATIENCE = 4  # iterations before extrapolating their number
NEAR = 0.035  # largest ratio of mu to that of reused factors, over the same root
FORETOLD = 1e-4  # relative deviation of the energy from its quadratic model at the last step
DOWNHILL = LineSearch(0.0, 1 / 128)  # fractions of 1 / mu, which shortens soft motions most
DAMPING = 1e-5  # where R leaves soft modes, such as paraboloids that vanish on a circle
DAMPED = DOWNHILL.shortest / 1024  # of half that damping to 1000 times as much


class Point(NamedTuple):
    """A surface, and its energy predicted by the quadratic model of a full step that led there."""

    x: Floats
    foretold: float = np.inf


class KeptFactors:
    """Factors of one surface and mu, reused for nearby surfaces and similar mu.

    Parameters
    ----------
    system : VertexSystem
        System of the matrices.
    """

    def __init__(self, system: VertexSystem) -> None:
        self._system = system
        self._factor: SymmetricFactor | None = None
        self._mu = 0.0

    def serve(self, mu: float, ratio: float) -> bool:
        """Whether there are factors for this mu, up to a ratio; others are freed."""
        if not self._mu / ratio <= mu <= self._mu * ratio:
            self.forget()
        return self._factor is not None

    def forget(self) -> None:
        """Free the factors."""
        self._factor = None

    def renew(self, rows: Floats, mu: float, surface: Projected) -> None:
        """Factor the matrix of a surface, J given by its `edge_rows`.

        Lagrange multipliers exclude isometries from solutions.
        """
        self.forget()
        self._factor, self._mu = self._system.penalized(rows, mu, surface), mu
        isometries = surface.rigid_motions()
        self._moved = self._factor.solve(isometries, sweeps=0)
        self._held = np.linalg.inv(isometries.T @ self._moved)

    def solve(self, forces: Floats) -> Floats:
        """Solve for z, (3 V,), without isometries of the factored surface."""
        assert self._factor is not None
        z = self._factor.solve(forces, sweeps=0)
        return z - self._moved @ (self._held @ (self._moved.T @ forces))


class SmoothingEnergy(RegularizedEnergy):
    """The energy ``|r|^2 + mu |R x|^2``, with reuse of factors.

    Parameters as for `RegularizedEnergy`, and the matrix R, by default that of fits to all neighbors.
    Energies with other weights share analysis and factors.
    """

    def __init__(
        self,
        metric: PolyhedralMetric,
        vertices: Floats,
        work: Work | None = None,
        residuals: csr_array | None = None,
    ) -> None:
        super().__init__(metric, vertices, work)
        self._shortest = DOWNHILL.shortest
        if residuals is not None:
            self._regularize_by(residuals)
            self._shortest = DAMPED
        self._kept = KeptFactors(self._newton_system)

    def solver(
        self, vertices: Floats, lengths: Floats, mu: float, w: float, tensions: Floats | float = 0.0
    ) -> Callable[[Floats], Floats]:
        """See `RegularizedEnergy.solver`; w is 0, and no edge has a tension."""
        return self._solver(vertices, lengths, mu, SOLVED, 0.0)

    def solved(self, vertices: Floats, lengths: Floats, gradient: Floats, mu: float, w: float) -> Floats:
        """See `RegularizedEnergy.solved`."""
        return self._solver(vertices, lengths, mu, STEPPED, 0.0)(gradient)

    def _shortened(
        self, vertices: Floats, lengths: Floats, gradient: Floats, mu: float, share: float
    ) -> Floats:
        """A step that is shortened by dividing mu by a share, or by damping if that has not sufficed."""
        if share >= DOWNHILL.shortest:
            return self._solver(vertices, lengths, mu / share, STEPPED, 0.0)(gradient)
        return self._solver(vertices, lengths, mu, STEPPED, DAMPING * DOWNHILL.shortest / share)(gradient)

    def _solver(
        self, vertices: Floats, lengths: Floats, mu: float, tolerance: float, damping: float
    ) -> Callable[[Floats], Floats]:
        surface = Projected.of(self.space, vertices)
        rows, fixed = self._rows(vertices, lengths), surface.without_isometries()
        a, b = self.triangulation.edges.T

        def product(z: Floats) -> Floats:
            stretch = np.einsum("ij,ij->i", rows, z[a] - z[b])
            pull = surface.motion(mu * self.roughness(surface.motion(z), 0.0))
            forces = self.triangulation.incidence @ (rows * stretch[:, None]) + damping * z
            return fixed((forces + pull).ravel()).reshape(-1, 3)

        def solve(gradient: Floats) -> Floats:
            forces, kept = fixed(surface.motion(gradient).ravel()).reshape(-1, 3), self._kept

            def precondition(g: Floats) -> Floats:
                return fixed(kept.solve(g.ravel())).reshape(-1, 3)

            root = float(np.sqrt(len(vertices)))
            if kept.serve(mu, max(NEAR * root, 1.0)):
                worth = int(WORTH * root)
                found = conjugate_gradients(
                    product, precondition, forces, tolerance, worth, patience=PATIENCE
                )
                if found.residual <= tolerance:
                    return surface.motion(found.x)
            kept.renew(rows, mu, surface)
            found = conjugate_gradients(product, precondition, forces, tolerance, MAX_ITERATIONS)
            if not np.isfinite(found.x).all():
                raise SingularMatrix("conjugate gradients broke down")
            return surface.motion(found.x)

        return solve

    def minimized(
        self,
        vertices: Floats,
        lengths: Floats,
        mu: float,
        share: float,
        max_iterations: int,
        recorder: StageRecorder,
        exhausted: Callable[[], bool] = lambda: False,
    ) -> Floats:
        """The local minimum, up to a step that gains less than a share, or as much as its model predicts."""

        def value(p: Point) -> float:
            return self.value(p.x, lengths, mu)

        def step(p: Point) -> Curve[Point]:
            r = self.residuals(p.x, lengths)
            gradient = self.forces(p.x, lengths, r) + mu * self.roughness(p.x, 0.0)
            recorder.iterations += 1
            recorder.show(residual=float(np.abs(r).max()))
            before = value(p)

            def at(fraction: float) -> Point:
                d = self._shortened(p.x, lengths, gradient, mu, fraction)
                whole = fraction == 1.0
                return Point(p.x - d, before - float(np.vdot(gradient, d)) if whole else np.inf)

            return at

        def converged(p: Point, reached: float, before: float) -> bool:
            return settled(share)(p, reached, before) or abs(reached - p.foretold) < FORETOLD * reached

        return descend(
            Point(vertices),
            step,
            replace(DOWNHILL, shortest=self._shortest),
            value=value,
            converged=converged,
            max_iterations=max_iterations,
            exhausted=lambda _: exhausted(),
        ).point.x
