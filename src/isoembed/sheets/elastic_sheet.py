"""Elastic sheets: Newton minimization of edge stretching energy plus quadratic bending energy."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array

from isoembed.arrays import Floats
from isoembed.linalg import SingularMatrix, SymmetricFactor
from isoembed.nonlinear.acceptance import LineSearch
from isoembed.nonlinear.descent import Curve, descend
from isoembed.nonlinear.newton import Point
from isoembed.nonlinear.stopping import short_step
from isoembed.progress.stages import StageRecorder
from isoembed.sheets.length_constraints import LengthConstraints
from isoembed.surface.rigidity import edge_rows
from isoembed.surface.vertex_system import HeldVertices, VertexSystem


class ElasticSheet:
    """Energy ``sum r^2 / 2 + epsilon tr(x^T Q x)`` of surfaces, with length residuals r.

    Parameters
    ----------
    lengths : LengthConstraints
    form : csr_array, shape (V, V)
        Positive semidefinite matrix Q.
    clamped : HeldVertices
        Triangle that removes the rigid motions, or fixed vertices.
    recorder : StageRecorder
    """

    def __init__(
        self, lengths: LengthConstraints, form: csr_array, clamped: HeldVertices, recorder: StageRecorder
    ) -> None:
        self.lengths, self.form, self.clamped, self.recorder = lengths, form, clamped, recorder
        self._system = VertexSystem(lengths.triangulation, form, recorder.work)

    def value(self, vertices: Floats, epsilon: float) -> float:
        """Energy of a surface."""
        return self._value(Point(vertices, self.lengths.residuals(vertices)), epsilon)

    def _value(self, p: Point, epsilon: float) -> float:
        return float(p.residual @ p.residual) / 2 + epsilon * float(np.sum(p.x * (self.form @ p.x)))

    def relaxed(self, start: Floats, epsilon: float, max_iterations: int, shortest: float = 1e-6) -> Floats:
        """Minimum near a starting surface, by Newton steps down to the length `shortest`, in mean edges."""
        unit = self.lengths.metric.mean_length

        def value(p: Point) -> float:
            return self._value(p, epsilon)

        def step(p: Point) -> Curve[Point]:
            self.recorder.show(residual=float(np.abs(p.residual).max()) / unit)
            self.recorder.iterations += 1
            factor, gradient = self._factor(p, epsilon), self._gradient(p, epsilon)
            d = factor.solve(gradient.ravel(), sweeps=1).reshape(-1, 3)

            def moved(by: Floats) -> Point:
                x = p.x - by
                return Point(x, self.lengths.residuals(x), float(np.abs(by).max()))

            def at(fraction: float) -> Point:
                # Isometric motions are curved: chord steps with the same factors restore the lengths.
                trial = moved(fraction * d)
                for _ in range(3):
                    left = self._gradient(trial, epsilon) - (1 - fraction) * gradient
                    back = factor.solve(left.ravel(), sweeps=0).reshape(-1, 3)
                    nearer = moved(p.x - trial.x + back)
                    if not value(nearer) < value(trial):
                        break
                    trial = nearer
                return trial

            return at

        return descend(
            Point(start, self.lengths.residuals(start)),
            step,
            LineSearch(decrease=0.0, shortest=1e-4),
            value=value,
            converged=short_step(shortest * unit),
            max_iterations=max_iterations,
        ).point.x

    def _gradient(self, p: Point, epsilon: float) -> Floats:
        return self.lengths.forces(p.x, p.residual) + 2 * epsilon * (self.form @ p.x)

    def _factor(self, p: Point, epsilon: float) -> SymmetricFactor:
        """Factors of the Hessian; without the stress of compressed edges if it is not positive definite."""
        t, targets = self.lengths.triangulation, self.lengths.lengths
        rows = edge_rows(t, p.x, targets)
        try:
            return self._system.penalized(
                rows, 2 * epsilon, tensions=p.residual / targets, clamped=self.clamped
            )
        except SingularMatrix:
            stretched = np.maximum(p.residual, 0.0) / targets
            return self._system.penalized(rows, 2 * epsilon, tensions=stretched, clamped=self.clamped)
