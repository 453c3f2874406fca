"""Newton's method on many lengths, its steps split into smooth motions and rough ones.

Newton's method converges only from where rough errors are small beside the heights of vertices above their
neighbors.  Of a surface that was found for chosen vertices, P z, the smooth errors are the larger ones.  So
these are left free, and the others held, as long as the lengths do not need them:

    ``|r|^2 + mu |x - P z|^2``

of both x and z, mu falling.  A step takes one factorization of ``J J^T + mu I``, which gives the best x for
every z; the equations that are left for z are solved by conjugate gradients.

What soft rough motions remain, along lines where curvature vanishes, quintics decide:

    ``|r|^2 + mu |R R x|^2``,

R the differences from quintics fitted to neighbors.  Its steps are made by conjugate gradients,
preconditioned on two levels: ``J^T J + mu I`` for the rough motions, which the same factors solve, and
``(J P)^T J P`` for the smooth ones.
"""

from __future__ import annotations

from dataclasses import dataclass

from isoembed.arrays import Floats
from isoembed.linalg import SymmetricFactor
from isoembed.linalg.krylov import conjugate_gradients
from isoembed.progress.stages import StageRecorder
from isoembed.surface.interpolation import CellRows
from isoembed.surface.rigidity import LengthSystem, LinearizedLengths, length_residuals
from isoembed.surface.smoothness import QuinticResiduals
from isoembed.thresholds import threshold


@dataclass(frozen=True)
class SplitNewtonThresholds:
    """Thresholds of Newton's method with smooth and rough motions."""

    solved: float = threshold(5e-2, "relative", "Residual of linear equations at most.")
    most: int = threshold(30, "count", "Iterations for smooth motions at most.")
    many: int = threshold(60_000, "vertices", "Of so many, soft motions hide in such a residual.")
    quintic_solved: float = threshold(1e-3, "relative", "The same where quintics hold so many.")
    quintic_most: int = threshold(70, "count", "Iterations with quintics at most.")
    held: float = threshold(0.1, "mu", "What holds rough motions in the preconditioner of the latter.")
    single: float = threshold(5e-7, "relative", "Damping from which single precision solves well enough.")


SPLIT_NEWTON = SplitNewtonThresholds()


class SplitNewton:
    """Steps that are split at one level.

    Parameters
    ----------
    system : LengthSystem
    lengths : ndarray, shape (E,)
    P : CellRows, (V, C)
        Interpolates smooth motions from those of C vertices.
    coarse : SymmetricFactor
        Of ``(J P)^T J P``, or what is near it: it preconditions.
    """

    def __init__(self, system: LengthSystem, lengths: Floats, P: CellRows, coarse: SymmetricFactor) -> None:
        self._system, self._lengths, self.P, self._coarse = system, lengths, P, coarse
        self._mass = len(P.rows) / len(P.starts)  # vertices a cell

    def step(self, x: Floats, z: Floats, mu: float, recorder: StageRecorder) -> tuple[Floats, Floats]:
        """A Gauss-Newton step on ``|r|^2 + mu |x - P z|^2``: the next x and z."""
        linear, r = self._linearized(x, mu, recorder)
        J, P = linear.J, self.P
        r = r - J.rates(x - P @ z)

        def product(v: Floats) -> Floats:
            return P.transposed(J.forces(linear.solve(J.rates(P @ v))))

        def precondition(v: Floats) -> Floats:
            return v / self._mass + mu * self._smooth(v)

        b = P.transposed(J.forces(linear.solve(r)))
        dz = conjugate_gradients(product, precondition, b, SPLIT_NEWTON.solved, SPLIT_NEWTON.most).x
        rough = J.forces(linear.solve(r - J.rates(P @ dz)))
        z = z - dz
        return P @ z - rough, z

    def smooth_step(
        self, x: Floats, quintics: QuinticResiduals, mu: float, recorder: StageRecorder
    ) -> Floats:
        """A Gauss-Newton step on ``|r|^2 + mu |R R x|^2``: the next x."""
        held = SPLIT_NEWTON.held * mu
        linear, r = self._linearized(x, held, recorder)
        J, P = linear.J, self.P

        def product(d: Floats) -> Floats:
            return J.forces(J.rates(d)) + mu * quintics.pull(d)

        def precondition(d: Floats) -> Floats:
            return (d - J.forces(linear.solve(J.rates(d)))) / held + P @ self._smooth(P.transposed(d))

        gradient = J.forces(r) + mu * quintics.pull(x)
        solved = SPLIT_NEWTON.quintic_solved if len(x) >= SPLIT_NEWTON.many else SPLIT_NEWTON.solved
        found = conjugate_gradients(product, precondition, gradient, solved, SPLIT_NEWTON.quintic_most)
        return x - found.x

    def _smooth(self, forces: Floats) -> Floats:
        """Solve for smooth motions (C, 3) by the coarse factor."""
        return self._coarse.solve(forces.ravel(), sweeps=0).reshape(-1, 3)

    def _linearized(
        self, x: Floats, damping: float, recorder: StageRecorder
    ) -> tuple[LinearizedLengths, Floats]:
        """J and the factors at x, and the residuals in their order."""
        recorder.iterations += 1
        recorder.factorizations += 1
        linear = self._system.linearized(x, self._lengths, damping, single=damping >= SPLIT_NEWTON.single)
        return linear, length_residuals(self._system.triangulation, x, self._lengths)[linear.order]
