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
    """Derivatives of the vertices of an embedding with respect to its lengths, and error propagation.

    The first derivative factors J J^T, as does a step of Newton's method; the factors are reused for all
    others.

    Parameters
    ----------
    embedding : Embedding
        Closed surface of genus 0, or a `SheetEmbedding`, for which `variation`, `deviation_bound` and
        `smallest_singular_value` raise `InvalidMetric`.

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
        """Vertices in the unit of the normalized metric."""
        return frozen(self.embedding.vertices / self._metric.unit)

    @cached_property
    def _derivatives(self) -> Any:
        """Factors shared by all derivatives; raises InvalidMetric."""
        return self.embedding._length_derivatives()

    @property
    def _closed(self) -> LengthDerivatives:
        """J and its factors for a closed surface of genus 0; raises InvalidMetric for others."""
        self._metric.triangulation.check_sphere("second derivatives and bounds need", OF_A_NUMBER)
        return cast(LengthDerivatives, self._derivatives)

    def jvp(self, changes: ArrayLike) -> Floats:
        """Derivative of the vertices along changes of the lengths.

        Parameters
        ----------
        changes : array_like, shape (..., E)
            Changes of the lengths, in the order of the metric's edges.

        Returns
        -------
        ndarray, shape (..., V, 3)
            ``J^+ dl``, in the same unit, without translation and rotation.  (In hyperbolic and spherical
            space, with minimum norm of z among the motions w z.)  For a `SheetEmbedding`, the boundary data
            are fixed: with given heights there are no horizontal motions, and derivatives of a surface of
            least bending are accurate to about seven digits.

        Raises
        ------
        InvalidParameter
            The changes have another shape or are not finite.
        InvalidMetric
            The surface has a boundary without boundary conditions.
        SingularMatrix
            The surface is not infinitesimally rigid: a vertex is flat, such as those in the faces of a
            `ConvexPolyhedron`.
        OutOfMemory
            The factors exceed the available memory.
        """
        return self._derivatives.jvp(checked(changes, self._metric.lengths.shape, "changes"))

    def vjp(self, gradient: ArrayLike) -> Floats:
        """Derivatives with respect to the lengths of a function of the vertices, from its gradient.

        Parameters
        ----------
        gradient : array_like, shape (..., V, 3)
            Gradient with respect to the vertices.  For functions not invariant under rigid motions, the
            derivatives are for motions without translation and rotation.

        Returns
        -------
        ndarray, shape (..., E)
            ``(J^+)^T g``, the transpose of `jvp`, with the same factors.

        Raises
        ------
        InvalidParameter, InvalidMetric, SingularMatrix, OutOfMemory
            See `jvp`.
        """
        return self._derivatives.vjp(
            checked(gradient, (len(self.embedding.vertices), 3), "entries of the gradient")
        )

    def boundary_jvp(self, changes: ArrayLike) -> Floats:
        """Derivative of the vertices of a `SheetEmbedding` along changes of its boundary data.

        Parameters
        ----------
        changes : array_like, shape (..., B) or (..., B, 3)
            Changes of the heights (including a boundary in a plane) or positions of the boundary's vertices,
            in the order of `Triangulation.boundaries`.

        Returns
        -------
        ndarray, shape (..., V, 3)
            Derivative at constant lengths; with a given curve, in least squares of the lengths.

        Raises
        ------
        InvalidParameter
            There are no boundary data, or see `jvp`.
        InvalidMetric, SingularMatrix
            See `jvp`.
        """
        derivatives = self._at_boundary
        return derivatives.boundary_jvp(checked(changes, derivatives.shape, "changes"))

    def boundary_vjp(self, gradient: ArrayLike) -> Floats:
        """Derivatives with respect to the boundary data of a function of the vertices, from its gradient.

        Parameters
        ----------
        gradient : array_like, shape (..., V, 3)
            See `vjp`.

        Returns
        -------
        ndarray, shape (..., B) or (..., B, 3)
            Transpose of `boundary_jvp`.

        Raises
        ------
        InvalidParameter, InvalidMetric, SingularMatrix
            See `boundary_jvp`.
        """
        derivatives = self._at_boundary
        return derivatives.boundary_vjp(
            checked(gradient, (len(self.embedding.vertices), 3), "entries of the gradient")
        )

    @property
    def _at_boundary(self) -> Any:
        """Derivatives of a surface with given heights or positions; raises InvalidParameter for others."""
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

        For a `ConvexPolyhedron`, `jvp` differentiates with respect to the lengths of its own triangles, and
        this with respect to those of its `edge_paths`; for other embeddings they are the same.  The first
        call computes the factors for this and `given_vjp`.

        Parameters
        ----------
        changes : array_like, shape (..., n)
            Changes of the given lengths, in the order of `ConvexPolyhedron.edge_paths`: that of
            `PolyhedralMetric.edges`, or of the lower half-edges of a `GluedMetric`.

        Returns
        -------
        ndarray, shape (..., V, 3)
            Derivative in the same unit, without translation and rotation.

        Raises
        ------
        InvalidParameter
            The changes have another shape or are not finite; a flat vertex does not remain flat, or its face
            breaks, so that there is no derivative, or only a one-sided one; the polyhedron is not in R^3 or
            is flat, or its triangles have another number of edges.
        SingularMatrix
            The polyhedron is too thin.
        """
        if self._by_given is None:
            return self.jvp(changes)
        dl = checked(changes, (self._by_given.n_given,), "changes")
        rows = [self._by_given.jvp(row) for row in dl.reshape(-1, dl.shape[-1])]
        return np.array(rows).reshape(*dl.shape[:-1], *self.embedding.vertices.shape)

    def given_vjp(self, gradient: ArrayLike) -> Floats:
        """Derivatives with respect to the given lengths of a function of the vertices, from its gradient.

        Parameters
        ----------
        gradient : array_like, shape (..., V, 3)
            See `vjp`.

        Returns
        -------
        ndarray, shape (..., n)
            Transpose of `given_jvp`, along changes that keep flat vertices flat.

        Raises
        ------
        InvalidParameter, SingularMatrix
            See `given_jvp`.
        """
        if self._by_given is None:
            return self.vjp(gradient)
        g = checked(gradient, self.embedding.vertices.shape, "entries of the gradient")
        rows = [self._by_given.vjp(row) for row in g.reshape(-1, *g.shape[-2:])]
        return np.array(rows).reshape(*g.shape[:-2], self._by_given.n_given)

    def variation(self, changes: ArrayLike) -> Variation:
        """First and second derivatives of a surface in R^3 with lengths ``l + t dl``.

        Parameters
        ----------
        changes : array_like, shape (E,)
            Changes dl, in the order of the metric's edges.

        Raises
        ------
        InvalidParameter
            Space is curved, or see `jvp`.
        InvalidMetric, SingularMatrix, OutOfMemory
            See `jvp`.
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
        """First-order deviation of a surface in R^3 due to independent errors of its lengths.

        If few different lengths are rounded to a decimal place, with the corresponding standard deviation,
        equal lengths have a common error.  For a `SheetEmbedding`, boundary data are exact, and H is that of
        the fits, as its `mean_curvature`.

        Parameters
        ----------
        errors : float or array_like, shape (E,)
            Standard deviations of the lengths, in their unit: one for all, or one for each edge.

        Raises
        ------
        InvalidParameter
            Space is curved, an error is negative, or see `jvp`.
        InvalidMetric, SingularMatrix, OutOfMemory
            See `jvp`.
        """
        sigma = self._flat_errors(errors)
        shared = shared_errors(self._metric.lengths, sigma * self._metric.unit)
        found = Deviation.of(
            self._derivatives,
            self._metric.normalized,
            self._normalized,
            sigma,
            shared,
            self.embedding._smoothed_parts,
            self.embedding._curvature_rates,
        )
        return found.scaled(self._metric.unit)

    def integral_deviation(self, errors: ArrayLike) -> IntegralDeviation:
        """Deviations of area, volume and int H dA only, by a single solve, in every space.

        Parameters
        ----------
        errors : float or array_like, shape (E,)
            See `deviation`.

        Raises
        ------
        InvalidParameter
            The errors have another shape, are negative or not finite.
        InvalidMetric, OutOfMemory
            See `jvp`.
        """
        sigma = checked_errors(self._metric, errors)
        shared, sigma = shared_errors(self._metric.lengths, sigma), sigma / self._metric.unit
        metric, x = self._metric.normalized, self._normalized
        t, smoothed_parts = metric.triangulation, self.embedding._smoothed_parts
        if t.is_sphere:
            try:
                derivatives = self._closed
            except SingularMatrix:
                derivatives = None
            found = IntegralDeviation.of(metric, x, sigma, shared, smoothed_parts, derivatives)
        else:
            try:
                sheet, curvature = self._derivatives, self.embedding._curvature_rates
            except SingularMatrix:  # flat, for example
                sheet = curvature = None
            found = IntegralDeviation.of_sheet(sheet, metric, x, sigma, shared, smoothed_parts, curvature)
        return found.scaled(self._metric.unit)

    def deviation_bound(self, errors: ArrayLike) -> DeviationBound:
        """Proven bound on the deviation of a surface in R^3 due to errors of its lengths.

        For all lengths within these errors there is a surface that differs from this one by at most the
        bound.  The theorem is that of a `Certificate`.  With errors of 0, it bounds the distance of the exact
        surface.

        Parameters
        ----------
        errors : float or array_like, shape (E,)
            Bounds on the errors of the lengths, in their unit: one for all, or one for each edge.

        Raises
        ------
        InvalidParameter
            See `deviation`.
        InvalidMetric, OutOfMemory
            See `jvp`.
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
        """Smallest singular value of the rigidity matrix J, without rigid motions: 0 if the surface can flex.

        To first order, the vertices move by at most its inverse times a change of the lengths, both in the
        Euclidean norm.  It takes one factorization of J J^T, once per embedding.

        Raises
        ------
        InvalidMetric
            See `jvp`.
        """
        return self.embedding._smallest_singular_value

    def _flat_errors(self, errors: ArrayLike) -> Floats:
        """Validated length errors of a surface in R^3 in the normalized unit, (E,)."""
        if not self._metric.space.is_euclidean:
            raise InvalidParameter(f"deviations need surfaces in R^3, not in {self._metric.space!r}")
        return checked_errors(self._metric, errors) / self._metric.unit
