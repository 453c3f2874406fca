"""Newton's method on many lengths, with steps split into smooth and rough components.

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

from isoembed.arrays import Floats
from isoembed.linalg import SymmetricFactor
from isoembed.linalg.krylov import conjugate_gradients
from isoembed.progress.stages import StageRecorder
from isoembed.surface.interpolation import CellRows
from isoembed.surface.rigidity import LengthSystem, LinearizedLengths, length_residuals
from isoembed.surface.smoothness import QuinticResiduals

SOLVED = 5e-2  # largest residual of linear equations, relative
MAX_ITERATIONS = 30  # for smooth motions
MANY = 60_000  # vertices: soft motions of more hide in such a residual


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
        dz = conjugate_gradients(product, precondition, b, SOLVED, MAX_ITERATIONS).x
        rough = J.forces(linear.solve(r - J.rates(P @ dz)))
        z = z - dz
        return P @ z - rough, z

    def smooth_step(
        self, x: Floats, quintics: QuinticResiduals, mu: float, recorder: StageRecorder
    ) -> Floats:
        """A Gauss-Newton step on ``|r|^2 + mu |R R x|^2``: the next x."""
        held = 0.1 * mu  # share of mu that holds rough motions in the preconditioner
        linear, r = self._linearized(x, held, recorder)
        J, P = linear.J, self.P

        def product(d: Floats) -> Floats:
            return J.forces(J.rates(d)) + mu * quintics.pull(d)

        def precondition(d: Floats) -> Floats:
            return (d - J.forces(linear.solve(J.rates(d)))) / held + P @ self._smooth(P.transposed(d))

        gradient = J.forces(r) + mu * quintics.pull(x)
        solved = 1e-3 if len(x) >= MANY else SOLVED
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
        # Single precision solves well enough.
        linear = self._system.linearized(x, self._lengths, damping, single=damping >= 5e-7)
        return linear, length_residuals(self._system.triangulation, x, self._lengths)[linear.order]
