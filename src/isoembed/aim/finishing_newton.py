"""Damped Newton's method for a surface whose edge lengths are nearly right, patch by patch.

A descent (`isoembed.aim.energy_descent`) that nearly reaches the lengths ends where J is singular: the
errors r are a stress in equilibrium, ``J^T r = 0``, and no small motion reduces them.  A larger one may,
along the few softest motions v_1 ... v_k, with the corresponding stresses w_1 ... w_k.  For each
``s = sum_i s_i v_i`` the stiff motions respond, to second order, by ``d = -1/2 J^+ Q(s, s)``, with the w
excluded from J^+.  The remaining errors,

    ``w_m . (r + J s + 1/2 Q(s, s) + Q(s, d))``,

are k cubic equations (`isoembed.aim.length_expansion`).  Without the response of the stiff motions, their
roots on rough bodies led back to the start.  The roots are computed from random starts, and Newton's method
continues from them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.sparse.linalg import ArpackError, LinearOperator, eigsh

from isoembed.aim.acceptance import REALIZED
from isoembed.aim.anneal import anneal
from isoembed.aim.length_expansion import LengthExpansion
from isoembed.arrays import Floats
from isoembed.linalg import SingularMatrix
from isoembed.nonlinear.acceptance import Damping
from isoembed.nonlinear.descent import Curve, descend
from isoembed.nonlinear.stopping import settled
from isoembed.progress.stages import StageRecorder
from isoembed.surface.rigidity import LengthSystem, LinearizedLengths, edge_rows
from isoembed.surface.vertex_system import VertexSystem

MOTIONS = (2, 3, 4, 5, 6, 8)  # numbers of softest motions, in turn


def finish(
    system: LengthSystem,
    vertices: Floats,
    lengths: Floats,
    recorder: StageRecorder,
    is_done: Callable[[Floats], bool],
) -> Floats:
    """A realization near a surface that nearly has the lengths; the surface itself if none is found.

    Parameters
    ----------
    system : LengthSystem
        In Euclidean space.
    vertices : ndarray, shape (V, 3)
    lengths : ndarray, shape (E,)
    recorder : StageRecorder
    is_done : callable
        Whether the budget is exhausted, as a function of a surface.
    """
    exact = REALIZED * float(lengths.mean())
    if is_done(vertices):
        return vertices
    try:
        soft = _SoftMotions.of(system, vertices, lengths, MOTIONS[-1])
    except (SingularMatrix, ArpackError):  # no convergence of the Lanczos iteration
        return vertices
    for count in MOTIONS:
        for start in soft.equations(count).roots():
            if is_done(vertices):
                return vertices
            found = anneal(
                system,
                start,
                lengths,
                recorder,
                residual_tolerance=exact,
                max_iterations=4,  # enough to see whether a root leads to a realization
            )
            if found.converged:
                return found.vertices
    return vertices


@dataclass(frozen=True, eq=False)
class _SoftMotions:
    """The softest motions of a surface.

    Attributes
    ----------
    expansion : LengthExpansion
    linear : LinearizedLengths
        Damped linearization.
    motions : ndarray, shape (k, V, 3)
        v, normalized.
    stresses : ndarray, shape (k, E)
        w, normalized.
    """

    expansion: LengthExpansion
    linear: LinearizedLengths
    motions: Floats
    stresses: Floats

    @classmethod
    def of(cls, system: LengthSystem, vertices: Floats, lengths: Floats, max_count: int) -> _SoftMotions:
        """Softest motions, at most `count`; raises SingularMatrix.

        If J is singular, motions do not follow from stresses; both are computed as eigenvectors.
        """
        triangulation, m = system.triangulation, len(lengths)
        # Slight damping, since J J^T is singular.
        linear = system.linearized(vertices, lengths, 1e-11)
        factor = VertexSystem(triangulation, work=system.work).penalized(
            edge_rows(triangulation, vertices, lengths), 0.0
        )
        count = min(max_count, m - 1)
        moved = vertices - vertices.mean(axis=0)
        turns = [np.cross(axis, moved).ravel() for axis in np.eye(3)]
        shifts = [np.tile(axis, len(vertices)) for axis in np.eye(3)]
        rigid = np.linalg.qr(np.array([*turns, *shifts]).T)[0]

        def inverse(d: Floats) -> Floats:
            d = factor.solve(d - rigid @ (rigid.T @ d), sweeps=0)
            return d - rigid @ (rigid.T @ d)

        motions = _softest(inverse, vertices.size, count).reshape(count, -1, 3)
        stresses = np.empty((count, m))
        stresses[:, linear.order] = _softest(linear.solve, m, count)
        return cls(LengthExpansion(system, vertices, lengths), linear, motions, stresses)

    def equations(self, count: int) -> _SoftEquations:
        """Cubic equations for the `count` softest motions."""
        expansion, motions, stresses = self.expansion, self.motions[:count], self.stresses[:count]
        k = len(motions)
        bends = np.array([expansion.bends(each, motions) for each in motions])
        left = (bends - bends @ stresses.T @ stresses).reshape(k**2, -1)
        tensions = self.linear.solve(np.ascontiguousarray(left[:, self.linear.order].T)).T
        followed = -np.array([self.linear.J.forces(np.ascontiguousarray(each)) for each in tensions])
        cubic = np.array([expansion.bends(each, followed) @ stresses.T for each in motions])
        return _SoftEquations(
            expansion.vertices,
            motions,
            followed.reshape(k, k, -1, 3),
            stresses @ expansion.residuals,
            stresses @ expansion.rates(motions).T,
            np.einsum("ije,me->mij", bends, stresses),
            np.moveaxis(cubic.reshape((k,) * 4), 3, 0) / 2,
        )


def _softest(inverse: Callable[[Floats], Floats], n: int, count: int) -> Floats:
    """Eigenvectors, (k, n), of an inverse for its largest eigenvalues, in descending order."""
    _, vectors = eigsh(
        LinearOperator((n, n), matvec=inverse, dtype=np.float64),
        k=count,
        which="LA",
        v0=np.random.default_rng(0).standard_normal(n),
        ncv=min(n, 2 * count + 20),
        tol=1e-4,  # enough for the softest motions
    )
    return np.asarray(vectors.T[::-1])


@dataclass(frozen=True, eq=False)
class _SoftEquations:
    """The cubic equations for k motions of a surface.

    Attributes
    ----------
    vertices : ndarray, shape (V, 3)
    motions : ndarray, shape (k, V, 3)
    followed : ndarray, shape (k, k, V, 3)
        Response of the stiff motions, twice d.
    constant : ndarray, shape (k,)
    slope : ndarray, shape (k, k)
    Q : ndarray, shape (k, k, k)
        Coefficients of the quadratic terms, doubled.
    C : ndarray, shape (k, k, k, k)
        Coefficients of the cubic terms, symmetric in the last two indices.
    """

    vertices: Floats
    motions: Floats
    followed: Floats
    constant: Floats
    slope: Floats
    Q: Floats
    C: Floats

    def roots(self) -> list[Floats]:
        """Surfaces, (V, 3), at the roots or minima found, the best first."""
        k, rng = len(self.constant), np.random.default_rng(0)
        bent = np.abs(np.einsum("mii->im", self.Q)).max(axis=1)
        with np.errstate(divide="ignore"):
            size = np.sqrt(np.abs(self.constant).max() / bent)
        if not np.isfinite(size).all():
            return []
        found_roots: list[tuple[float, Floats]] = []
        for _ in range(60):  # random starts of the cubic equations
            # At this size, quadratic terms are comparable to the errors.
            value, s = self._least(rng.standard_normal(k) * size * rng.choice((0.5, 1.0, 2.0, 4.0)))
            close = 1e-3 * np.abs(s).max()  # relative distance of equal roots
            if all(np.abs(s - other).max() > close for _, other in found_roots):
                found_roots.append((value, s))
        found_roots.sort(key=lambda pair: pair[0])
        return [
            self.vertices
            + np.tensordot(s, self.motions, axes=1)
            + np.einsum("i,j,ijvc->vc", s, s, self.followed) / 2
            for _, s in found_roots[:6]  # the best roots
        ]

    def _evaluated(self, s: Floats) -> tuple[Floats, Floats]:
        """The equations, (k,), and their derivatives, (k, k)."""
        bent, curved = self.Q @ s, np.einsum("mlij,i,j->ml", self.C, s, s)
        turned = np.einsum("mlij,l,i->mj", self.C, s, s)
        values = self.constant + self.slope @ s + bent @ s / 2 + curved @ s
        return values, self.slope + bent + curved + 2 * turned

    def _least(self, s: Floats) -> tuple[float, Floats]:
        """The minimum of the sum of squares that Levenberg-Marquardt steps reach, and its location."""

        def at(s: Floats) -> tuple[Floats, ...]:
            return s, *self._evaluated(s)

        def step(point: tuple[Floats, ...]) -> Curve[tuple[Floats, ...]]:
            s, f, J = point
            gram, gradient, identity = J.T @ J, J.T @ f, np.eye(len(s))
            return lambda damping: at(s - np.linalg.solve(gram * (1 + damping * identity), gradient))

        found = descend(
            at(s),
            step,
            Damping(1e-3, largest=1e8),
            value=lambda point: float(point[1] @ point[1]),
            converged=settled(1e-8),  # rounding
            max_iterations=60,
            max_trials=60,
        )
        return found.value, found.point[0]
