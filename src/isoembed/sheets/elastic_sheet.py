"""Elastic sheets: stretching energy of the edges and a quadratic form for the bending, minimized together."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array

from isoembed.arrays import Floats
from isoembed.linalg import SingularMatrix
from isoembed.nonlinear.acceptance import LineSearch
from isoembed.nonlinear.newton import Point, newton
from isoembed.nonlinear.stopping import short_step
from isoembed.progress.stages import StageRecorder
from isoembed.sheets.length_constraints import LengthConstraints
from isoembed.surface.rigidity import HeldVertices, VertexSystem, edge_rows


class ElasticSheet:
    """The energy ``sum r^2 / 2 + epsilon tr(x^T Q x)`` of surfaces, r the residuals of the lengths.

    Parameters
    ----------
    lengths : LengthConstraints
    form : csr_array, shape (V, V)
        Q, positive semidefinite.
    held : HeldVertices
        A triangle that holds the rigid motions, or vertices that do not move.
    recorder : StageRecorder
    """

    def __init__(
        self, lengths: LengthConstraints, form: csr_array, held: HeldVertices, recorder: StageRecorder
    ) -> None:
        self.lengths, self.form, self.held, self.recorder = lengths, form, held, recorder
        self._system = VertexSystem(lengths.triangulation, form)

    def value(self, vertices: Floats, epsilon: float) -> float:
        """The energy."""
        return self._value(Point(vertices, self.lengths.residuals(vertices)), epsilon)

    def _value(self, p: Point, epsilon: float) -> float:
        return float(p.residual @ p.residual) / 2 + epsilon * float(np.sum(p.x * (self.form @ p.x)))

    def relaxed(self, start: Floats, epsilon: float, max_iterations: int, shortest: float) -> Floats:
        """The minimum near a start, by Newton steps, the last one no longer than this."""
        t, given = self.lengths.triangulation, self.lengths.lengths
        unit = self.lengths.metric.mean_length

        def solve(x: Floats, r: Floats) -> Floats:
            self.recorder.show(residual=float(np.abs(r).max()) / unit)
            rows = edge_rows(t, x, given)
            gradient = t.incidence @ (rows * r[:, None]) + 2 * epsilon * (self.form @ x)
            self.recorder.factorizations += 1
            self.recorder.iterations += 1
            weight = 2 * epsilon
            try:
                factor = self._system.penalized(rows, weight, tensions=r / given, held=self.held)
            except SingularMatrix:  # compressed edges buckle: without their stress the matrix is definite
                self.recorder.factorizations += 1
                stretched = np.maximum(r, 0.0) / given
                factor = self._system.penalized(rows, weight, tensions=stretched, held=self.held)
            return factor.solve(gradient.ravel(), sweeps=1).reshape(-1, 3)

        return newton(
            start,
            self.lengths.residuals,
            solve,
            LineSearch(decrease=0.0, shortest=1e-4),
            norm=lambda p: self._value(p, epsilon),
            converged=short_step(shortest * unit),
            max_iterations=max_iterations,
        ).point.x
