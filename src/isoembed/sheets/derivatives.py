"""Derivatives of surfaces with boundary or handles with respect to edge lengths and boundary data.

The equations that define the surface are differentiated.  With the residuals r of `LengthConstraints` and
J = r', they are

- for heights h of the boundary, Z x = h: the minimum-norm solution of ``J dx = dl`` and ``Z dx = dh``;
- for least bending, ``2 Q x + J^T y = 0`` and r = 0 with tensions y: with the Laplacian T of the
  triangulation with weights y / l, ``(2 Q + T) dx + J^T dy = J^T (y / l dl) - d(2 Q) x`` and ``J dx = dl``;
- for a curve, or handles, ``J^T r = 0`` inside: with T for weights r / l, ``s + J dx = rho dl`` and
  ``J^T s - T dx = -J^T (r / l dl)``, where ``rho = (|x_a - x_b|^2 + l^2) / (2 l^2)``.  For r = 0 this is the
  Gauss-Newton step.

All of these matrices are symmetric, so that one factorization serves forward and adjoint derivatives.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import block_array, csr_array, diags_array, eye_array, kron

from isoembed.arrays import Floats
from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.linalg import Factor, factor_general
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.sheets.bending import BendingEnergy
from isoembed.sheets.bending_derivative import bending_force_derivative
from isoembed.sheets.length_constraints import LengthConstraints
from isoembed.sheets.surface import BALANCED, SheetEmbedding


@dataclass(frozen=True, eq=False)
class SheetDerivatives:
    """Factored linear system for the derivatives of a surface.

    Attributes
    ----------
    factor : Factor
        Factors of the symmetric matrix K, (n, n).
    place : csr_array, shape (3 V, n)
        Selection of the vertices from the unknowns.
    by_lengths : csr_array, shape (n, E)
        Right-hand sides for changes of the lengths.
    by_boundary : csr_array, shape (n, D)
        Right-hand sides for changes of the D boundary data, if any.
    boundary_rows : csr_array, shape (3 V, D)
        Derivatives of prescribed vertices with respect to the boundary data.
    shape : tuple of int
        Shape of the boundary data: (B,), (B, 3) or (0,).
    """

    factor: Factor
    place: csr_array
    by_lengths: csr_array
    by_boundary: csr_array
    boundary_rows: csr_array
    shape: tuple[int, ...]

    @classmethod
    def of(cls, sheet: SheetEmbedding) -> SheetDerivatives:
        """Differentiate the equations of a surface.

        Raises
        ------
        InvalidMetric
            The boundary condition of the surface is unknown.
        InvalidParameter
            The bending energy is not at a minimum.
        SingularMatrix
            The equations do not determine the surface to first order.
        """
        metric, unit, t = sheet.metric.normalized, sheet.metric.unit, sheet.triangulation
        x, lengths = sheet.vertices / unit, LengthConstraints(metric)
        if sheet.heights is not None:
            return cls._with_heights(lengths, x)
        if sheet.condition == "curve":
            return cls.of_least_squares(lengths, x)
        if t.n_edges > 3 * t.n_vertices - 6 and t.is_closed:
            return cls.of_least_squares(lengths, x)
        if sheet.tensions is None or sheet.imbalance is None:
            raise InvalidMetric(
                "the surface has an unknown boundary condition: derivatives require a surface "
                "returned by embed(metric, boundary=...)"
            )
        if not sheet.imbalance <= BALANCED:
            raise InvalidParameter(
                f"the bending forces are balanced only to {sheet.imbalance:.0e}: derivatives require a "
                "minimum"
            )
        return cls._least_bending(metric, lengths, x, unit * sheet.tensions)

    @classmethod
    def _with_heights(cls, lengths: LengthConstraints, x: Floats) -> SheetDerivatives:
        t = lengths.triangulation
        loop = np.concatenate(t.boundaries)
        count, n = len(loop), x.size
        J = lengths.jacobian(x)
        Z = csr_array((np.ones(count), (np.arange(count), 3 * loop + 2)), shape=(count, n))
        K = block_array([[eye_array(n), J.T, Z.T], [J, None, None], [Z, None, None]])
        size = K.shape[0]
        return cls(
            factor_general(K),
            eye_array(n, size, format="csr"),
            eye_array(size, t.n_edges, k=-n, format="csr"),
            eye_array(size, count, k=-n - t.n_edges, format="csr"),
            csr_array((n, count)),
            (count,),
        )

    @classmethod
    def of_least_squares(cls, lengths: LengthConstraints, x: Floats) -> SheetDerivatives:
        """Derivatives of a least-squares surface, closed or with given boundary, at normalized vertices."""
        t, n = lengths.triangulation, x.size
        loop = np.concatenate([np.zeros(0, dtype=np.int64), *t.boundaries])
        inner, fixed = np.flatnonzero(~t.boundary_edges), (3 * loop[:, None] + np.arange(3)).ravel()
        free = np.flatnonzero(np.repeat(~t.boundary_vertices, 3))
        r, l = lengths.residuals(x)[inner], lengths.lengths[inner]
        J = csr_array(lengths.jacobian(x)[inner])
        stress = np.zeros(t.n_edges)
        stress[inner] = r / l
        T = csr_array(kron(_laplacian(lengths, stress), eye_array(3), format="csr"))
        rigid = csr_array(_rigid_motions(x) if t.is_closed else np.zeros((0, n)))[:, free]
        inside, beside = J[:, free], J[:, fixed]
        K = block_array(
            [
                [eye_array(len(inner)), inside, None],
                [inside.T, -T[free][:, free], rigid.T],
                [None, rigid, csr_array((rigid.shape[0], rigid.shape[0]))],
            ]
        )
        size, first = K.shape[0], len(inner)
        chosen = eye_array(t.n_edges, format="csr")[inner]
        rho = 1 + r / l
        by_lengths = block_array(
            [
                [diags_array(rho) @ chosen],
                [-inside.T @ diags_array(r / l) @ chosen],
                [csr_array((rigid.shape[0], t.n_edges))],
            ],
            format="csr",
        )
        by_boundary = block_array(
            [[-beside], [T[free][:, fixed]], [csr_array((rigid.shape[0], len(fixed)))]], format="csr"
        )
        return cls(
            factor_general(K),
            csr_array((np.ones(len(free)), (free, first + np.arange(len(free)))), shape=(n, size)),
            by_lengths,
            by_boundary,
            csr_array((np.ones(len(fixed)), (fixed, np.arange(len(fixed)))), shape=(n, len(fixed))),
            (len(loop), 3) if len(loop) else (0,),
        )

    @classmethod
    def _least_bending(
        cls, metric: PolyhedralMetric, lengths: LengthConstraints, x: Floats, tensions: Floats
    ) -> SheetDerivatives:
        n, count = x.size, len(tensions)
        factor, scale = bending_factor(BendingEnergy(metric), lengths, x, tensions)
        pulled = lengths.jacobian(x).T @ diags_array(tensions / metric.lengths)
        forces = (pulled - bending_force_derivative(metric, x)) / scale
        by_lengths = block_array([[forces], [eye_array(count)], [csr_array((6, count))]], format="csr")
        size = by_lengths.shape[0]
        place, none = eye_array(n, size, format="csr"), csr_array((size, 0))
        return cls(factor, place, by_lengths, none, csr_array((n, 0)), (0,))

    def jvp(self, changes: Floats) -> Floats:
        """Derivative of the vertices, (..., V, 3), along changes of the lengths, (..., E)."""
        return self._forward(
            self.by_lengths, None, changes.reshape(-1, changes.shape[-1]), changes.shape[:-1]
        )

    def vjp(self, gradient: Floats) -> Floats:
        """Transpose of `jvp`: (..., E) from (..., V, 3)."""
        return self._backward(self.by_lengths, None, gradient, self.by_lengths.shape[1:])

    def boundary_jvp(self, changes: Floats) -> Floats:
        """Derivative of the vertices, (..., V, 3), along changes of the boundary data, (..., *shape)."""
        leading = changes.shape[: changes.ndim - len(self.shape)]
        return self._forward(
            self.by_boundary, self.boundary_rows, changes.reshape(-1, int(np.prod(self.shape))), leading
        )

    def boundary_vjp(self, gradient: Floats) -> Floats:
        """Transpose of `boundary_jvp`: (..., *shape) from (..., V, 3)."""
        return self._backward(self.by_boundary, self.boundary_rows, gradient, self.shape)

    def newton_step(self, residuals: Floats) -> Floats:
        """Newton step d, (V, 3), to subtract from x, for least squares of the inner residuals."""
        right = np.zeros(self.place.shape[1])
        right[: len(residuals)] = residuals
        return np.asarray((self.place @ self.factor.solve(right)).reshape(-1, 3))

    def _forward(
        self, right: csr_array, boundary_rows: csr_array | None, rows: Floats, leading: tuple[int, ...]
    ) -> Floats:
        dx = self.place @ self.factor.solve(right @ rows.T)
        if boundary_rows is not None:
            dx = dx + boundary_rows @ rows.T
        return np.asarray(dx.T.reshape(*leading, -1, 3))

    def _backward(
        self, right: csr_array, boundary_rows: csr_array | None, gradient: Floats, shape: tuple[int, ...]
    ) -> Floats:
        rows = gradient.reshape(-1, self.place.shape[0])
        found = right.T @ self.factor.solve(self.place.T @ rows.T)
        if boundary_rows is not None:
            found = found + boundary_rows.T @ rows.T
        return np.asarray(found.T.reshape(*gradient.shape[:-2], *shape))


def bending_factor(
    energy: BendingEnergy, lengths: LengthConstraints, x: Floats, tensions: Floats
) -> tuple[Factor, float]:
    """Factors of the linearized equations of least bending: scaled forces, lengths and rigid motions.

    The unknowns are motions of the vertices, scaled changes of the tensions, and six that are zero.
    """
    J, form = lengths.jacobian(x), 2 * energy.form
    scale = max(float(form.diagonal().mean()), 1.0)
    B = kron((form + _laplacian(lengths, tensions / lengths.lengths)) / scale, eye_array(3))
    rigid = csr_array(_rigid_motions(x))
    return factor_general(block_array([[B, J.T, rigid.T], [J, None, None], [rigid, None, None]])), scale


def _laplacian(lengths: LengthConstraints, weights: Floats) -> csr_array:
    """Laplacian of the triangulation with these edge weights, (V, V)."""
    incidence = lengths.triangulation.incidence
    return csr_array(incidence @ diags_array(weights) @ incidence.T)


def _rigid_motions(x: Floats) -> Floats:
    """Orthonormal infinitesimal rigid motions, as rows, (6, 3 V)."""
    away = x - x.mean(axis=0)
    fields = [np.broadcast_to(axis, x.shape) for axis in np.eye(3)]
    fields += [np.cross(axis, away) for axis in np.eye(3)]
    return np.asarray(np.linalg.qr(np.stack([field.ravel() for field in fields], axis=1))[0].T)
