"""Embedding as a differentiable function of lengths and boundary data: values, derivative and adjoint."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from isoembed.arrays import Floats
from isoembed.embedding.embedding import Embedding
from isoembed.errors import InvalidParameter
from isoembed.method import solve
from isoembed.methods import as_method
from isoembed.nonlinear.acceptance import contraction
from isoembed.nonlinear.stopping import below
from isoembed.sheets.derivatives import SheetDerivatives
from isoembed.sheets.nearby import nearby_sheet
from isoembed.sheets.surface import SheetEmbedding
from isoembed.surface.alignment import aligned
from isoembed.surface.checked import checked
from isoembed.surface.derivatives import LengthDerivatives
from isoembed.surface.length_newton import length_newton
from isoembed.surface.rigidity import LengthSystem


@dataclass(frozen=True, eq=False)
class Linearized:
    """Surface with given lengths, and its derivatives.

    Attributes
    ----------
    vertices : ndarray, shape (V, 3)
    derivatives : LengthDerivatives or SheetDerivatives
    gauge : ndarray, shape (3 V, k)
        Constraints: motions dx with ``gauge^T dx = 0`` keep the vertices aligned with the reference.
    rigid : ndarray, shape (3 V, k)
        The k = 6 rigid motions, with ``gauge^T rigid = 1``; 3 horizontal ones for a surface with given
        boundary heights, none for one with a given curve.
    """

    vertices: Floats
    derivatives: LengthDerivatives | SheetDerivatives
    gauge: Floats
    rigid: Floats

    def jvp(self, changes: Floats) -> Floats:
        """Derivative of the vertices, (V, 3), along a change dl of the lengths, (E,)."""
        return self._aligned(self.derivatives.jvp(changes))

    def vjp(self, gradient: Floats) -> Floats:
        """Derivatives with respect to the lengths, (E,), from those by the vertices, (V, 3)."""
        return self.derivatives.vjp(self._unaligned(gradient))

    def boundary_jvp(self, changes: Floats) -> Floats:
        """Derivative of the vertices, (V, 3), along a change of the boundary data; zeros without any."""
        if not isinstance(self.derivatives, SheetDerivatives):
            return np.zeros_like(self.vertices)
        return self._aligned(self.derivatives.boundary_jvp(changes))

    def boundary_vjp(self, gradient: Floats) -> Floats:
        """Derivatives with respect to the boundary data, in its shape, from those by the vertices, (V, 3)."""
        if not isinstance(self.derivatives, SheetDerivatives):
            return np.zeros(0)
        return self.derivatives.boundary_vjp(self._unaligned(gradient))

    def _aligned(self, motion: Floats) -> Floats:
        dx = motion.ravel()
        return (dx - self.rigid @ (self.gauge.T @ dx)).reshape(-1, 3)

    def _unaligned(self, gradient: Floats) -> Floats:
        g = gradient.ravel()
        return (g - self.gauge @ (self.rigid.T @ g)).reshape(-1, 3)


@dataclass(frozen=True, eq=False)
class Realization:
    """Surface near a given one with other lengths, aligned with it.

    The triangles are unchanged.  The vertices are differentiable functions of the lengths.
    With boundary they also depend on the boundary data, of the same kind as those of the given surface.
    Alignment is then horizontal only if heights are given, and omitted if a curve is; with a curve,
    and with handles, lengths are fitted in least squares.

    Parameters
    ----------
    surface : Embedding
        Surface in R^3: closed and of genus 0, or a `SheetEmbedding`.

    Attributes
    ----------
    boundary : ndarray, shape (B,), (B, 3) or (0,)
        Boundary data of the surface: heights, positions, or none.

    Raises
    ------
    InvalidParameter
        The surface is not in R^3, or did not converge.
    """

    surface: Embedding

    def __post_init__(self) -> None:
        if not self.surface.space.is_euclidean:
            raise InvalidParameter(f"the surface is in {self.surface.space!r}, not in R^3")
        if not self.surface.converged:
            raise InvalidParameter(f"cannot start from this surface: {self.surface.message}")

    @cached_property
    def boundary(self) -> Floats:
        """Boundary data: heights or positions; empty if there are none."""
        surface = self.surface
        if not isinstance(surface, SheetEmbedding):
            return np.zeros(0)
        if surface.heights is not None:
            return surface.heights
        if surface.condition == "curve":
            return surface.vertices[np.concatenate(surface.triangulation.boundaries)]
        return np.zeros(0)

    def __call__(self, lengths: ArrayLike, boundary: ArrayLike | None = None) -> Floats:
        """Vertices, (V, 3), for lengths (E,) in the order of the metric's edges.

        Parameters
        ----------
        lengths : array_like, shape (E,)
        boundary : array_like, in the shape of `boundary`, optional
            Heights or positions of the boundary's vertices; by default those of the surface.

        Raises
        ------
        InvalidMetric
            The lengths do not define a metric.
        NotEmbedded
            No surface with these lengths was found.
        InvalidParameter
            The lengths or boundary data have another shape.
        """
        if isinstance(self.surface, SheetEmbedding):
            return self._sheet(self.surface, lengths, boundary).vertices
        self._given(boundary)
        given, t = self.surface, self.surface.triangulation
        metric = given.metric.with_lengths(checked(lengths, (t.n_edges,), "lengths"))
        unit = metric.unit
        goal = metric.lengths / unit
        # For nearby lengths a few steps suffice; otherwise they are embedded from scratch.
        found = length_newton(
            LengthSystem(t),
            given.vertices / unit,
            goal,
            contraction(0.5),
            converged=below(1e-13 * goal.mean()),  # rounding
            max_iterations=20,
        )
        near = found.value <= 1e-10 * goal.mean()
        vertices = unit * found.point.x if near else solve(metric, as_method("aim")).vertices
        return aligned(vertices, given.vertices)

    def _given(self, boundary: ArrayLike | None) -> Floats:
        return (
            self.boundary
            if boundary is None
            else checked(boundary, self.boundary.shape, "data at the boundary")
        )

    def _sheet(
        self, surface: SheetEmbedding, lengths: ArrayLike, boundary: ArrayLike | None
    ) -> SheetEmbedding:
        count = len(surface.metric.lengths)
        metric = surface.metric.with_lengths(checked(lengths, (count,), "lengths"))
        values = self._given(boundary)
        found = nearby_sheet(surface, metric, values if values.size else None)
        y = surface.vertices - surface.vertices.mean(axis=0)
        if surface.heights is not None:
            upright = np.array([0.0, 0.0, 1.0])
            x = found.vertices - found.vertices.mean(axis=0)
            middle = (1 - upright) * surface.vertices.mean(axis=0) + upright * found.vertices.mean(axis=0)
            return replace(found, vertices=_turned_level(x, y) + middle)
        if values.size:
            return found
        return replace(found, vertices=aligned(found.vertices, surface.vertices))

    def linearized(self, lengths: ArrayLike, boundary: ArrayLike | None = None) -> Linearized:
        """Surface with these lengths and boundary data, and its derivatives with respect to them.

        Raises
        ------
        InvalidMetric, NotEmbedded
            See `__call__`.
        SingularMatrix
            The surface is not infinitesimally rigid.
        """
        unit, motions = self.surface.metric.unit, np.arange(6)
        derivatives: LengthDerivatives | SheetDerivatives
        if isinstance(self.surface, SheetEmbedding):
            sheet = self._sheet(self.surface, lengths, boundary)
            x, derivatives = sheet.vertices, SheetDerivatives.of(sheet)
            if self.boundary.size:
                motions = np.array([0, 1, 5] if self.boundary.ndim == 1 else [], dtype=np.int64)
        else:
            x = self(lengths, boundary)
            goal = np.asarray(lengths, dtype=np.float64) / unit
            derivatives = LengthDerivatives.of(self.surface.triangulation, x / unit, goal)
        # Alignment: the same centroid, and sum y x dx = 0 about it, with the reference y.
        y = (self.surface.vertices - self.surface.vertices.mean(axis=0)) / unit
        constraints, rigid = (_rigid_fields(p)[:, motions] for p in (y, (x - x.mean(axis=0)) / unit))
        return Linearized(x, derivatives, constraints, rigid @ np.linalg.inv(constraints.T @ rigid))


def _turned_level(x: Floats, y: Floats) -> Floats:
    """Points (V, 3) rotated about the vertical axis for the best alignment with others."""
    angle = np.arctan2(np.sum(x[:, 0] * y[:, 1] - x[:, 1] * y[:, 0]), np.sum(x[:, :2] * y[:, :2]))
    c, s = np.cos(angle), np.sin(angle)
    return x @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


def _rigid_fields(x: Floats) -> Floats:
    """Translations and rotations of points (V, 3) about the origin, as columns (3 V, 6)."""
    translations = [np.broadcast_to(axis, x.shape) for axis in np.eye(3)]
    rotations = [np.cross(axis, x) for axis in np.eye(3)]
    return np.stack([field.ravel() for field in translations + rotations], axis=1)
