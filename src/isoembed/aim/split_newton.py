"""Newton's method on many lengths, with steps split into smooth and rough components.

Newton's method converges only if rough errors are small compared with the heights of vertices above their
neighbors.  The smooth errors of an interpolated coarse surface P z are larger than its rough ones.  Smooth
motions are therefore free, and rough ones penalized:

    ``|r|^2 + mu |x - P z|^2``

is minimized over x and z, with decreasing mu.  A step takes one factorization of ``J J^T + mu I``, which
gives the optimal x for every z; the remaining equations for z are solved by conjugate gradients.

Soft rough motions, along lines of vanishing curvature, are determined by quintics:

    ``|r|^2 + mu |R R x|^2``,

with the differences R from quintics fitted to neighbors.  The linear equations are solved by conjugate
gradients with a two-level preconditioner: ``J^T J + mu I`` for rough motions, with the same factors, and
``(J P)^T J P`` for smooth ones.
"""

from __future__ import annotations

from isoembed.arrays import Floats
from isoembed.linalg import SymmetricFactor
from isoembed.linalg.krylov import conjugate_gradients
from isoembed.progress.stages import StageRecorder
from isoembed.surface.interpolation import CellRows
from isoembed.surface.rigidity import LengthSystem, LinearizedLengths, length_residuals
from isoembed.surface.smoothness import QuinticResiduals

SOLVED = 5e-2  # largest relative residual of linear equations
SOFT_SOLVED = 1e-2  # with quintics; after larger ones a few vertices may stay on a wrong side
SOFT_SOLVED_MANY = 1e-3  # for more vertices than:
MANY = 60_000
MAX_ITERATIONS = 30  # conjugate gradient iterations for smooth motions


class SplitNewton:
    """Newton steps split at one level.

    Parameters
    ----------
    system : LengthSystem
    lengths : ndarray, shape (E,)
    P : CellRows, (V, C)
        Interpolation of smooth motions from those of C vertices.
    coarse : SymmetricFactor
        Factorization of ``(J P)^T J P``, or of an approximation, as a preconditioner.
    """

    def __init__(self, system: LengthSystem, lengths: Floats, P: CellRows, coarse: SymmetricFactor) -> None:
        self._system, self._lengths, self.P, self._coarse = system, lengths, P, coarse
        self._mass = len(P.rows) / len(P.starts)  # vertices a cell

    def step(self, x: Floats, z: Floats, mu: float, recorder: StageRecorder) -> tuple[Floats, Floats]:
        """The next x and z by a Gauss-Newton step on ``|r|^2 + mu |x - P z|^2``."""
        linear, r = self._linearized(x, mu, recorder)
        J, P = linear.J, self.P
        r = r - J.rates(x - P @ z)

        def product(v: Floats) -> Floats:
            return P.transposed(J.forces(linear.solve(J.rates(P @ v))))

        def precondition(v: Floats) -> Floats:
            return v / self._mass + mu * self._smooth(v)

        b = P.transposed(J.forces(linear.solve(r)))
        dz = conjugate_gradients(product, precondition, b, SOLVED, MAX_ITERATIONS).x
        rough = J.forces(linear.solve(r - J.rates(P @ dz)))
        z = z - dz
        return P @ z - rough, z

    def smooth_step(
        self, x: Floats, quintics: QuinticResiduals, mu: float, recorder: StageRecorder
    ) -> Floats:
        """The next x by a Gauss-Newton step on ``|r|^2 + mu |R R x|^2``."""
        damping = 0.1 * mu  # share of mu for rough motions in the preconditioner
        linear, r = self._linearized(x, damping, recorder)
        J, P = linear.J, self.P

        def product(d: Floats) -> Floats:
            return J.forces(J.rates(d)) + mu * quintics.pull(d)

        def precondition(d: Floats) -> Floats:
            return (d - J.forces(linear.solve(J.rates(d)))) / damping + P @ self._smooth(P.transposed(d))

        gradient = J.forces(r) + mu * quintics.pull(x)
        solved = SOFT_SOLVED if len(x) < MANY else SOFT_SOLVED_MANY
        found = conjugate_gradients(product, precondition, gradient, solved, 70)
        return x - found.x

    def _smooth(self, forces: Floats) -> Floats:
        """Solve for smooth motions (C, 3) by the coarse factor."""
        return self._coarse.solve(forces.ravel(), sweeps=0).reshape(-1, 3)

    def _linearized(
        self, x: Floats, damping: float, recorder: StageRecorder
    ) -> tuple[LinearizedLengths, Floats]:
        """J and the factors at x, and the residuals in their order."""
        recorder.iterations += 1
        # Single precision is accurate enough.
        linear = self._system.linearized(x, self._lengths, damping, single=damping >= 5e-7)
        return linear, length_residuals(self._system.triangulation, x, self._lengths)[linear.order]
