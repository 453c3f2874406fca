"""Rigidity matrix J of a surface: entries, factorization, Newton steps on lengths, singular values.

A row of J per edge holds ``(x_a - x_b)^T / l_ab`` at a and its negative at b; the edge's residual is
``(|x_a - x_b|^2 - l_ab^2) / (2 l_ab)``.
The minimum-norm step, ``d = J^T (J J^T + mu I)^-1 r``, needs no fixed triangle: J J^T is an edges x edges
matrix that is positive definite whenever the surface is infinitesimally rigid.  At a vertex with hundreds of
edges it is dense, unlike J itself with a triangle fixed.  In hyperbolic and spherical space J is that of the
projective coordinates, and acts on the z of `projected`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
from scipy.sparse import csc_array

from isoembed.arrays import Floats, Indices
from isoembed.linalg import SingularMatrix, Solver, SymmetricFactor, Work, analyze, dissect
from isoembed.linalg.dissection import Dissection
from isoembed.linalg.superlu import checked_lu
from isoembed.mesh.triangulation import Triangulation
from isoembed.space import EUCLIDEAN, Space
from isoembed.surface.projected import Projected
from isoembed.surface.rigidity_matrix import MEAN_DIAGONAL, RigidityMatrix, coupled_edges
from isoembed.surface.vertex_system import VertexSystem


def length_residuals(
    triangulation: Triangulation, vertices: Floats, lengths: Floats, space: Space = EUCLIDEAN
) -> Floats:
    """``(|x_a - x_b|^2 - l_ab^2) / (2 l_ab)``, shape (E,): to first order, the error of each length.

    In hyperbolic and spherical space the squares are those of chords, and sn(l) replaces l.
    """
    a, b = triangulation.edges.T
    if not space.is_euclidean:
        with np.errstate(invalid="ignore"):  # NaN outside the hemisphere of the origin
            chords, goals = space.chords(vertices[a], vertices[b]), space.chord(lengths)
        return (chords - goals) * (chords + goals) / (2 * space.sn(lengths))
    d = vertices[a] - vertices[b]
    norm = np.sqrt(np.einsum("ij,ij->i", d, d))
    return (norm - lengths) * (norm + lengths) / (2 * lengths)


def edge_rows(
    triangulation: Triangulation, vertices: Floats, lengths: Floats, space: Space = EUCLIDEAN
) -> Floats:
    """Nonzeros of J, ``(x_a - x_b) / l_ab``, shape (E, 3).

    In hyperbolic and spherical space they act on the z of `projected`, with x' = w z.
    """
    a, b = triangulation.edges.T
    surface = Projected.of(space, vertices)
    divisors = surface.divisors(triangulation.edges, lengths)
    return (surface.positions[a] - surface.positions[b]) / divisors[:, None]


@dataclass(frozen=True, eq=False)
class LinearizedLengths:
    """J at one surface, and a factorization of ``J J^T + damping I``, with the edges in elimination order.

    In hyperbolic and spherical space it acts on the z of `projected`.

    Attributes
    ----------
    J : RigidityMatrix
    factor : SymmetricFactor
    order : ndarray of int, shape (E,)
        Edges in elimination order.
    """

    J: RigidityMatrix
    factor: SymmetricFactor
    order: Indices

    def solve(self, r: Floats) -> Floats:
        """Solve ``(J J^T + damping I) y = r``, (E,), without iterative refinement."""
        return self.factor.solve(r, sweeps=0)


class LengthSystem:
    """J J^T of one triangulation, with a single symbolic analysis for all positions of the vertices.

    Parameters
    ----------
    triangulation : Triangulation
    space : Space, optional
        Ambient space.
    work : Work, optional
        Counter of factorizations.
    """

    def __init__(
        self, triangulation: Triangulation, *, space: Space = EUCLIDEAN, work: Work | None = None
    ) -> None:
        self.triangulation, self.space = triangulation, space
        self.work = Work() if work is None else work
        # The edges are stored in elimination order: neighbors are then close in memory.
        by_number = np.arange(triangulation.n_edges)
        self._order = by_number if self._by_vertices else self._dissection.edge_order(triangulation.edges)
        self._ends = triangulation.edges[self._order].astype(np.int32)

    def step(self, vertices: Floats, lengths: Floats, residuals: Floats, mu: float = 0.0) -> Floats:
        """Step ``d = J^T (J J^T + mu I)^-1 r``, (V, 3), to be subtracted from the vertices.

        The residuals r, (E,), are the `length_residuals`; mu is Levenberg-Marquardt damping, relative to the
        mean diagonal of J J^T: 0 gives the Newton step.  In hyperbolic and spherical space the step is that
        of the points x, and ``d / w`` has minimum norm; the vertices should be centered at the origin.

        Raises
        ------
        SingularMatrix
            The surface is not infinitesimally rigid and mu is 0.
        OutOfMemory
            The factors exceed the available memory.
        """
        r, surface = residuals[self._order], Projected.of(self.space, vertices)
        J = self._matrix(surface, lengths)
        damping = mu * self._mean_diagonal(J)
        if self._by_vertices:
            return surface.motion(self._step_by_vertices(surface, J, r, damping))
        linear = LinearizedLengths(J, self._factor(J, damping), self._order)
        d = J.forces(linear.solve(r))
        if mu == 0:
            # Refinement through J: refining the solution of J J^T alone would not reduce this residual.
            d = d + J.forces(linear.solve(r - J.rates(d)))
        return surface.motion(d)

    def linearized(
        self, vertices: Floats, lengths: Floats, damping: float = 0.0, *, single: bool = False
    ) -> LinearizedLengths:
        """J at the vertices, and the factors of ``J J^T + damping I``, optionally in `single` precision.

        Raises
        ------
        SingularMatrix
            The matrix is singular.
        OutOfMemory
            The factors exceed the available memory.
        """
        J = self._matrix(Projected.of(self.space, vertices), lengths)
        return LinearizedLengths(J, self._factor(J, damping, single=single), self._order)

    def smallest_singular_values(
        self, vertices: Floats, lengths: Floats, count: int
    ) -> tuple[Floats, Floats, Floats]:
        """Smallest singular values of J, apart from the six of the rigid motions, and their vectors.

        The values are accurate to about three digits: square roots of the smallest eigenvalues of J J^T, by
        Lanczos iteration with its inverse, which takes one factorization and some 20 solves.  In hyperbolic
        and spherical space they are those of the J that acts on velocities, whose norms are speeds, and are
        thus invariant under isometries.

        Returns
        -------
        sigma : ndarray, shape (count,)
            Singular values, ascending.
        motions : ndarray, shape (count, V, 3)
            Motions of the vertices that change the lengths least, of unit norm as velocities.
        changes : ndarray, shape (count, E)
            Unit vectors: the lengths change by ``sigma changes``, to first order.

        Raises
        ------
        SingularMatrix
            J J^T is singular to working precision.
        """
        from scipy.sparse.linalg import LinearOperator, eigsh  # slow to import

        surface = Projected.of(self.space, vertices)
        J = self._matrix(surface, lengths)
        factor = self._factor(J)
        n = len(lengths)
        inverse = LinearOperator((n, n), matvec=self._inverse(surface, J, factor), dtype=np.float64)
        # Lanczos vectors between restarts
        start, subspace = np.random.default_rng(0).standard_normal(n), min(n, 8 + count)
        # an estimate suffices
        _, vectors = eigsh(inverse, k=count, which="LA", v0=start, ncv=subspace, tol=1e-3)
        changes = np.empty((count, n))
        changes[:, self._order] = vectors.T[::-1] / np.linalg.norm(vectors.T[::-1], axis=1, keepdims=True)
        # Rayleigh quotient through J: rounding in J J^T would hide values below 1e-8.
        velocities = np.array([surface.from_velocities(J.forces(change[self._order])) for change in changes])
        sigma = np.linalg.norm(velocities, axis=(1, 2))
        motions = np.array([surface.motion(surface.from_velocities(v)) for v in velocities])
        return sigma, motions / sigma[:, None, None], changes

    def _inverse(
        self, surface: Projected, J: RigidityMatrix, factor: SymmetricFactor
    ) -> Callable[[Floats], Floats]:
        """Product with the inverse of J J^T, where J acts on velocities."""
        solve = partial(factor.solve, sweeps=0)
        if self.space.is_euclidean:
            return solve
        isometries = surface.isometries()

        def product(r: Floats) -> Floats:
            v = surface.velocities(J.forces(solve(r))).ravel()
            v -= isometries @ (isometries.T @ v)
            return solve(J.rates(surface.velocities(v.reshape(-1, 3))))

        return product

    def _matrix(self, surface: Projected, lengths: Floats) -> RigidityMatrix:
        divisors = surface.divisors(self._ends, lengths[self._order])
        return RigidityMatrix.of(self._ends, surface.positions, divisors)

    def _mean_diagonal(self, J: RigidityMatrix) -> float:
        return MEAN_DIAGONAL if self.space.is_euclidean else 2 * float(np.mean(np.sum(J.rows**2, axis=1)))

    def _factor(self, J: RigidityMatrix, damping: float = 0.0, *, single: bool = False) -> SymmetricFactor:
        pattern = self._solver.pattern
        return self._solver.factor(J.gram(pattern.indptr, pattern.indices, damping), single=single)

    @cached_property
    def _dissection(self) -> Dissection:
        return dissect(self.triangulation.adjacency)

    @cached_property
    def _by_vertices(self) -> bool:
        """Whether J^T J has fewer entries than J J^T."""
        t = self.triangulation
        degrees = np.bincount(t.edges.ravel()).astype(np.int64)
        return bool(9 * (t.n_vertices + 2 * t.n_edges) < int((degrees**2).sum()) - t.n_edges)

    @cached_property
    def _vertex_system(self) -> VertexSystem:
        return VertexSystem(self.triangulation, work=self.work)

    def _step_by_vertices(self, surface: Projected, J: RigidityMatrix, r: Floats, damping: float) -> Floats:
        """Newton step by factorizing J^T J or, without damping, J with a triangle fixed.

        J is then square, and its factors lose half as many digits as those of J^T J.
        """
        rows = np.empty_like(J.rows)
        rows[self._order] = J.rows
        if damping > 0:
            damped = self._vertex_system.damped(rows, damping)
            return damped.solve(J.forces(r).ravel(), sweeps=0).reshape(-1, 3)
        self.work.factorizations += 1
        lu = checked_lu(_square(J, surface.positions), "COLAMD")
        if not np.abs(lu.U.diagonal()).min() > 1e-14:  # the rows have entries up to 1
            raise SingularMatrix("J is singular to working precision")
        d = lu.solve(np.concatenate([r, np.zeros(6)]))
        basis = surface.rigid_motions()
        return (d - basis @ (basis.T @ d)).reshape(-1, 3)

    @cached_property
    def _solver(self) -> Solver:
        indptr, indices = coupled_edges(self._ends, self.triangulation.n_vertices)
        n = len(self._ends)
        pattern = csc_array((np.ones(indices.size, dtype=np.int8), indices, indptr), shape=(n, n))
        return analyze(pattern, np.arange(n), work=self.work)


def _square(J: RigidityMatrix, positions: Floats) -> csc_array:
    """J with six more rows that fix a triangle of distant vertices, (3 V, 3 V)."""
    away = positions - positions.mean(axis=0)
    a = int(np.linalg.norm(away, axis=1).argmax())
    away = positions - positions[a]
    b = int(np.linalg.norm(away, axis=1).argmax())
    c = int(np.linalg.norm(np.cross(away, away[b]), axis=1).argmax())
    normal = np.cross(away[b], away[c])
    across = np.cross(normal, away[b])
    normal, across = normal / np.linalg.norm(normal), across / np.linalg.norm(across)
    count = len(J.ends)
    edge = np.repeat(np.arange(count), 3)
    columns = 3 * J.ends[:, :, None].astype(np.int64) + np.arange(3)
    fixed = np.repeat(count + np.arange(6), 3)
    held_columns = (3 * np.array([a, a, a, b, b, c])[:, None] + np.arange(3)).ravel()
    values = [J.rows.ravel(), -J.rows.ravel(), np.eye(3).ravel(), across, normal, normal]
    rows = np.concatenate([edge, edge, fixed])
    places = np.concatenate([columns[:, 0].ravel(), columns[:, 1].ravel(), held_columns])
    return csc_array((np.concatenate(values), (rows, places)), shape=(3 * J.vertices, 3 * J.vertices))
