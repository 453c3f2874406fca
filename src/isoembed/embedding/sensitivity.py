"""Sensitivity of a surface to its lengths: derivatives, and what errors of the lengths do.

What computes them is imported when they are asked for.
"""

from __future__ import annotations

from abc import abstractmethod
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter
from isoembed.linalg import SingularMatrix
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.metric.precision import shared_errors
from isoembed.surface.checked import checked, checked_errors

if TYPE_CHECKING:
    from isoembed.proof.deviation_bound import DeviationBound
    from isoembed.surface.derivatives import LengthDerivatives, Variation
    from isoembed.surface.deviation import Deviation, IntegralDeviation


class Sensitivity:
    """How the vertices of an `Embedding` follow its lengths, and how far errors of these may take them."""

    metric: PolyhedralMetric
    vertices: Floats

    @property
    @abstractmethod
    def _normalized(self) -> Floats:
        """The vertices in the unit of the normalized metric."""

    @cached_property
    def _derivatives(self) -> LengthDerivatives:
        """J and its factors where the vertices are, kept for all derivatives; raises InvalidMetric."""
        from isoembed.surface.derivatives import LengthDerivatives

        self.metric.triangulation.check_sphere()  # elsewhere J is not square, rigid motions apart
        normalized = self.metric.normalized
        return LengthDerivatives.of(
            self.metric.triangulation, self._normalized, normalized.lengths, normalized.space
        )

    def jvp(self, changes: ArrayLike) -> Floats:
        """How the vertices move, to first order, when the lengths change.

        The first call factors J J^T, as a step of Newton's method does, and keeps the factors.

        Parameters
        ----------
        changes : array_like, shape (..., E)
            Of the lengths, in the order of the metric's edges.

        Returns
        -------
        ndarray, shape (..., V, 3)
            ``J^+ dl``, in the same unit, without translation and rotation.  (In hyperbolic and spherical
            space, of least norm among the motions w z by z.)

        Raises
        ------
        InvalidParameter
            The changes have another shape or are not finite.
        InvalidMetric
            The surface has a boundary or handles: its lengths are not as many as its motions.
        SingularMatrix
            The surface is not infinitesimally rigid: a vertex is flat, as they are in the faces of a
            `ConvexPolyhedron`.
        OutOfMemory
            The factors need more memory than is free.
        """
        return self._derivatives.jvp(checked(changes, self.metric.lengths.shape, "changes"))

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
        return self._derivatives.vjp(checked(gradient, (len(self.vertices), 3), "gradient"))

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
        from isoembed.surface.derivatives import Variation

        metric = self.metric
        if not metric.space.is_euclidean:
            raise InvalidParameter(
                f"second derivatives are those of surfaces in R^3, not in {metric.space!r}"
            )
        unit, lengths = metric.unit, metric.normalized.lengths
        dl = checked(changes, lengths.shape, "changes") / unit
        if dl.ndim > 1:
            raise InvalidParameter(f"the changes have the shape {dl.shape}, not {lengths.shape}")
        t, vertices = metric.triangulation, self._normalized
        return Variation.of(self._derivatives, t, vertices, lengths, dl).scaled(unit)

    def deviation(self, errors: ArrayLike) -> Deviation:
        """How far a surface in R^3 may be off because its lengths have independent errors, to first order.

        Where few different lengths are rounded to a decimal place, whose standard deviation is the errors',
        equal ones have the same error.

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
        from isoembed.surface.deviation import Deviation

        sigma = self._flat_errors(errors)
        shared = shared_errors(self.metric.lengths, sigma * self.metric.unit)
        found = Deviation.of(self._derivatives, self.metric.normalized, self._normalized, sigma, shared)
        return found.scaled(self.metric.unit)

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
        from isoembed.surface.derivatives import volume_gradient
        from isoembed.surface.deviation import IntegralDeviation

        sigma = checked_errors(self.metric, errors)
        shared, sigma = shared_errors(self.metric.lengths, sigma), sigma / self.metric.unit
        metric, x = self.metric.normalized, self._normalized
        try:
            volume_rates = self._derivatives.vjp(volume_gradient(metric.triangulation, x, metric.space))
        except SingularMatrix:
            volume_rates = np.full(len(sigma), np.inf)
        return IntegralDeviation.of(metric, x, sigma, shared, volume_rates).scaled(self.metric.unit)

    def deviation_bound(self, errors: ArrayLike) -> DeviationBound:
        """How far a surface in R^3 may be off because lengths are: not an estimate, but proven.

        Whatever the lengths are, within these errors of the metric's, there is a surface with them that
        differs from this one by no more.  The theorem is that of a `certificate`.  With errors of 0 it is how
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
        from isoembed.proof.deviation_bound import DeviationBound
        from isoembed.proof.length_equations import NotProven
        from isoembed.surface.derivatives import volume_gradient

        bounds = self._flat_errors(errors)
        metric, x = self.metric.normalized, self._normalized
        try:
            volume_rates = self._derivatives.vjp(volume_gradient(metric.triangulation, x))
            found = DeviationBound.of(metric, x, bounds, volume_rates)
        except (SingularMatrix, NotProven) as obstacle:
            return DeviationBound.unproven(metric.triangulation, str(obstacle))
        return found.scaled(self.metric.unit)

    def _flat_errors(self, errors: ArrayLike) -> Floats:
        """Errors of the lengths of a surface in R^3 in the normalized unit, (E,), checked."""
        if not self.metric.space.is_euclidean:
            raise InvalidParameter(f"deviations are those of surfaces in R^3, not in {self.metric.space!r}")
        return checked_errors(self.metric, errors) / self.metric.unit
