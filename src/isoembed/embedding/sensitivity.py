"""`isoembed.Sensitivity`: derivatives of a surface with respect to its lengths; propagation of errors."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike

from isoembed.arrays import Floats
from isoembed.embedding.embedding import Embedding, checked_embedding
from isoembed.errors import InvalidParameter
from isoembed.linalg import SingularMatrix
from isoembed.mesh.triangulation import frozen
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.metric.precision import shared_errors
from isoembed.proof.deviation_bound import DeviationBound
from isoembed.proof.length_equations import NotProven
from isoembed.surface.checked import checked, checked_errors
from isoembed.surface.derivatives import LengthDerivatives, Variation, volume_gradient
from isoembed.surface.deviation import Deviation, IntegralDeviation

OF_A_NUMBER = (
    "a number with the derivatives g by the vertices, (V, 3), has the standard deviation "
    "np.linalg.norm(Sensitivity(surface).vjp(g) * errors)"
)


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """Derivatives of the vertices of an embedding by its lengths, and the effect of errors of these.

    The first derivative that is asked for factors J J^T, as a step of Newton's method does; the factors are
    kept for all of them.

    Parameters
    ----------
    embedding : Embedding
        Closed, of genus 0, or a `SheetEmbedding`: `variation`, `deviation_bound` and
        `smallest_singular_value` of that raise `InvalidMetric`.

    Raises
    ------
    InvalidParameter
        The argument is not an embedding.
    """

    embedding: Embedding

    def __post_init__(self) -> None:
        checked_embedding(self.embedding)

    @property
    def _metric(self) -> PolyhedralMetric:
        return self.embedding.metric

    @cached_property
    def _normalized(self) -> Floats:
        """The vertices in the unit of the normalized metric."""
        return frozen(self.embedding.vertices / self._metric.unit)

    @cached_property
    def _derivatives(self) -> Any:
        """The factors that all derivatives need; raises InvalidMetric."""
        return self.embedding._length_derivatives()

    @property
    def _closed(self) -> LengthDerivatives:
        """J and its factors, of a closed surface of genus 0; raises InvalidMetric of others."""
        self._metric.triangulation.check_sphere("second derivatives and bounds need", OF_A_NUMBER)
        return cast(LengthDerivatives, self._derivatives)

    def jvp(self, changes: ArrayLike) -> Floats:
        """Derivative of the vertices along changes of the lengths.

        Parameters
        ----------
        changes : array_like, shape (..., E)
            Of the lengths, in the order of the metric's edges.

        Returns
        -------
        ndarray, shape (..., V, 3)
            ``J^+ dl``, in the same unit, without translation and rotation.  (In hyperbolic and spherical
            space, of least norm among the motions w z by z.)  For a `SheetEmbedding`, the boundary data stay
            fixed: with given heights there are no horizontal motions, and a surface of least bending is
            followed to seven digits or so.

        Raises
        ------
        InvalidParameter
            The changes have another shape or are not finite.
        InvalidMetric
            The surface has a boundary, and nothing that holds it there.
        SingularMatrix
            The surface is not infinitesimally rigid: a vertex is flat, as they are in the faces of a
            `ConvexPolyhedron`.
        OutOfMemory
            The factors need more memory than is free.
        """
        return self._derivatives.jvp(checked(changes, self._metric.lengths.shape, "changes"))

    def vjp(self, gradient: ArrayLike) -> Floats:
        """Derivatives by the lengths of a function of the vertices, from its derivatives by these.

        Parameters
        ----------
        gradient : array_like, shape (..., V, 3)
            Of a function that rigid motions do not change; of others, what motions without translation and
            rotation change.

        Returns
        -------
        ndarray, shape (..., E)
            ``(J^+)^T g``, the transpose of `jvp`, by the same factors.

        Raises
        ------
        InvalidParameter, InvalidMetric, SingularMatrix, OutOfMemory
            As `jvp`.
        """
        return self._derivatives.vjp(
            checked(gradient, (len(self.embedding.vertices), 3), "entries of the gradient")
        )

    def boundary_jvp(self, changes: ArrayLike) -> Floats:
        """Derivative of the vertices of a `SheetEmbedding` along changes of its boundary data.

        Parameters
        ----------
        changes : array_like, shape (..., B) or (..., B, 3)
            Of the heights, also of a boundary in a plane, or of the positions of the boundary's vertices, in
            the order of `Triangulation.boundaries`.

        Returns
        -------
        ndarray, shape (..., V, 3)
            While the lengths stay; with a given curve, in least squares of these.

        Raises
        ------
        InvalidParameter
            Nothing is given at the boundary, or as `jvp`.
        InvalidMetric, SingularMatrix
            As `jvp`.
        """
        derivatives = self._at_boundary
        return derivatives.boundary_jvp(checked(changes, derivatives.shape, "changes"))

    def boundary_vjp(self, gradient: ArrayLike) -> Floats:
        """Derivatives by what is given at the boundary of a function of the vertices.

        Parameters
        ----------
        gradient : array_like, shape (..., V, 3)
            As that of `vjp`.

        Returns
        -------
        ndarray, shape (..., B) or (..., B, 3)
            The transpose of `boundary_jvp`.

        Raises
        ------
        InvalidParameter, InvalidMetric, SingularMatrix
            As `boundary_jvp`.
        """
        derivatives = self._at_boundary
        return derivatives.boundary_vjp(
            checked(gradient, (len(self.embedding.vertices), 3), "entries of the gradient")
        )

    @property
    def _at_boundary(self) -> Any:
        """Derivatives of a surface with given heights or positions; raises InvalidParameter of others."""
        if not np.prod(getattr(self._derivatives, "shape", (0,))):
            raise InvalidParameter(
                "derivatives with respect to boundary data require heights or positions on the boundary"
            )
        return self._derivatives

    @cached_property
    def _by_given(self) -> Any:
        return self.embedding._given_derivatives()

    def given_jvp(self, changes: ArrayLike) -> Floats:
        """Derivative of the vertices along changes of the given lengths.

        Of a `ConvexPolyhedron`, `jvp` is by the lengths of its own triangles, and this by those of its
        `edge_paths`; of other embeddings they are the same.  The first call factors what both this and
        `given_vjp` need.

        Parameters
        ----------
        changes : array_like, shape (..., n)
            Of the given lengths, in the order of `ConvexPolyhedron.edge_paths`: that of
            `PolyhedralMetric.edges`, or of the lower half-edges of a `GluedMetric`.

        Returns
        -------
        ndarray, shape (..., V, 3)
            In the same unit, without translation and rotation.

        Raises
        ------
        InvalidParameter
            The changes have another shape or are not finite; a flat vertex does not remain flat, or its face
            breaks, so that there is no derivative or one on one side only; the polyhedron is not in R^3 or
            is flat, or its triangles have another number of edges.
        SingularMatrix
            It is too thin.
        """
        if self._by_given is None:
            return self.jvp(changes)
        dl = checked(changes, (self._by_given.n_given,), "changes")
        rows = [self._by_given.jvp(row) for row in dl.reshape(-1, dl.shape[-1])]
        return np.array(rows).reshape(*dl.shape[:-1], *self.embedding.vertices.shape)

    def given_vjp(self, gradient: ArrayLike) -> Floats:
        """Derivatives by the given lengths of a function of the vertices, from its derivatives by these.

        Parameters
        ----------
        gradient : array_like, shape (..., V, 3)
            As that of `vjp`.

        Returns
        -------
        ndarray, shape (..., n)
            The transpose of `given_jvp`, along changes that keep flat vertices flat.

        Raises
        ------
        InvalidParameter, SingularMatrix
            As `given_jvp`.
        """
        if self._by_given is None:
            return self.vjp(gradient)
        g = checked(gradient, self.embedding.vertices.shape, "entries of the gradient")
        rows = [self._by_given.vjp(row) for row in g.reshape(-1, *g.shape[-2:])]
        return np.array(rows).reshape(*g.shape[:-2], self._by_given.n_given)

    def variation(self, changes: ArrayLike) -> Variation:
        """First and second derivatives of a surface in R^3 when its lengths are ``l + t dl``.

        Parameters
        ----------
        changes : array_like, shape (E,)
            dl, in the order of the metric's edges.

        Raises
        ------
        InvalidParameter
            As `jvp`, and in space that is curved.
        InvalidMetric, SingularMatrix, OutOfMemory
            As `jvp`.
        """
        metric = self._metric
        if not metric.space.is_euclidean:
            raise InvalidParameter(f"second derivatives need surfaces in R^3, not in {metric.space!r}")
        unit, lengths = metric.unit, metric.normalized.lengths
        dl = checked(changes, lengths.shape, "changes") / unit
        if dl.ndim > 1:
            raise InvalidParameter(f"the changes have the shape {dl.shape}, not {lengths.shape}")
        t, vertices = metric.triangulation, self._normalized
        return Variation.of(self._closed, t, vertices, lengths, dl).scaled(unit)

    def deviation(self, errors: ArrayLike) -> Deviation:
        """Deviation of a surface in R^3 by independent errors of its lengths, to first order.

        Where few different lengths are rounded to a decimal place, whose standard deviation is the errors',
        equal ones have the same error.  Of a `SheetEmbedding`, what is given at the boundary has no error,
        and H is that of the dihedral angles.

        Parameters
        ----------
        errors : float or array_like, shape (E,)
            Standard deviations of the lengths, in their unit: one for all, or one for each edge.

        Raises
        ------
        InvalidParameter
            As `jvp`, in space that is curved, and if an error is negative.
        InvalidMetric, SingularMatrix, OutOfMemory
            As `jvp`.
        """
        sigma = self._flat_errors(errors)
        shared = shared_errors(self._metric.lengths, sigma * self._metric.unit)
        found = Deviation.of(
            self._derivatives,
            self._metric.normalized,
            self._normalized,
            sigma,
            shared,
            self.embedding._missed,
        )
        return found.scaled(self._metric.unit)

    def integral_deviation(self, errors: ArrayLike) -> IntegralDeviation:
        """Area, volume and int H dA of `deviation` alone, by one solve, and in every space.

        Parameters
        ----------
        errors : float or array_like, shape (E,)
            As of `deviation`.

        Raises
        ------
        InvalidParameter
            The errors have another shape, are not finite or negative.
        InvalidMetric, OutOfMemory
            As `jvp`.
        """
        sigma = checked_errors(self._metric, errors)
        shared, sigma = shared_errors(self._metric.lengths, sigma), sigma / self._metric.unit
        metric, x = self._metric.normalized, self._normalized
        t, missed = metric.triangulation, self.embedding._missed
        if t.is_sphere:
            try:
                derivatives = self._closed
            except SingularMatrix:
                derivatives = None
            found = IntegralDeviation.of(metric, x, sigma, shared, missed, derivatives)
        else:
            found = IntegralDeviation.of_sheet(self._derivatives, t, x, sigma, shared, missed)
        return found.scaled(self._metric.unit)

    def deviation_bound(self, errors: ArrayLike) -> DeviationBound:
        """Proven bound on the deviation of a surface in R^3 by errors of its lengths.

        Whatever the lengths are, within these errors of the metric's, there is a surface with them that
        differs from this one by no more.  The theorem is that of a `Certificate`.  With errors of 0 it is how
        far the exact surface may be.

        Parameters
        ----------
        errors : float or array_like, shape (E,)
            The largest of each length, in their unit: one for all, or one for each edge.

        Raises
        ------
        InvalidParameter
            As `deviation`.
        InvalidMetric, OutOfMemory
            As `jvp`.
        """
        bounds = self._flat_errors(errors)
        metric, x = self._metric.normalized, self._normalized
        try:
            volume_rates = self._closed.vjp(volume_gradient(metric.triangulation, x))
            found = DeviationBound.of(metric, x, bounds, volume_rates)
        except (SingularMatrix, NotProven) as obstacle:
            return DeviationBound.unproven(metric.triangulation, str(obstacle))
        return found.scaled(self._metric.unit)

    @property
    def smallest_singular_value(self) -> float:
        """Smallest singular value of the rigidity matrix J, rigid motions apart: 0 if the surface can flex.

        To first order, the vertices need not move by more than its inverse times a change of the lengths,
        both in the Euclidean norm.  It takes one factorization of J J^T, once for each embedding.

        Raises
        ------
        InvalidMetric
            As `jvp`.
        """
        return self.embedding._smallest_singular_value

    def _flat_errors(self, errors: ArrayLike) -> Floats:
        """Errors of the lengths of a surface in R^3 in the normalized unit, (E,), checked."""
        if not self._metric.space.is_euclidean:
            raise InvalidParameter(f"deviations need surfaces in R^3, not in {self._metric.space!r}")
        return checked_errors(self._metric, errors) / self._metric.unit
