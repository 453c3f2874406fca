"""Regularized energy on a coarse level: few degrees of freedom, interpolated, measured on fine edges.

For many vertices, the path from the convex surface to the given lengths is followed for a few of them.
These have no metric of their own: the errors r are those of *given* edges, with end points interpolated by
quintics.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array

from isoembed.aim.regularized_energy import MAX_ITERATIONS, RegularizedEnergy
from isoembed.arrays import Floats
from isoembed.linalg import SymmetricFactor, Work
from isoembed.linalg.krylov import Approximation, conjugate_gradients
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.progress.stages import StageRecorder
from isoembed.surface.interpolated_rigidity import InterpolatedRigidity
from isoembed.surface.interpolation import Stencils
from isoembed.surface.local_fit import edge_lengths_about
from isoembed.surface.measures import edge_lengths

SOLVED = 1e-2  # relative residual of a step's linear equations


class InterpolatedEnergy(RegularizedEnergy):
    """The energy of the chosen vertices' positions, (C, 3).

    The errors are those of the strains times the coarse edge length around, three for each chosen vertex, so
    that mu has the same meaning as on a triangulation of these vertices.

    Parameters
    ----------
    metric : PolyhedralMetric
        Given.
    stencils : Stencils
    convex : ndarray, shape (V, 3)
        The surface on which the vertices were chosen; gives R and K.
    positions : ndarray, shape (V, 3)
        In whose tangent planes is interpolated at first.
    work : Work, optional
        Counts the factorizations.

    Attributes
    ----------
    edges : InterpolatedRigidity
        Those measured.
    lengths : ndarray, shape (M,)
        Given for them.
    P : CellRows, (V, C)
        Interpolates all vertices.
    factor : SymmetricFactor or None
        Of the matrix of a step, the last one that was factored.
    """

    def __init__(
        self,
        metric: PolyhedralMetric,
        stencils: Stencils,
        convex: Floats,
        positions: Floats,
        work: Work | None = None,
    ) -> None:
        fine = metric.triangulation
        self.edges = InterpolatedRigidity(fine, stencils, work)
        self.lengths = metric.lengths[self.edges.edges]
        chosen = convex[stencils.cells.vertices]
        coarse = PolyhedralMetric.from_mesh(chosen, stencils.triangulation.faces)
        stretch = edge_lengths_about(fine, edge_lengths(fine.edges, convex)) / edge_lengths_about(
            fine, metric.lengths
        )
        units = edge_lengths_about(coarse.triangulation, coarse.lengths) / stretch[stencils.cells.vertices]
        self._set_penalties(coarse, chosen, units, float(units.mean()))
        self._RR = csr_array(self._RT @ self._R)
        share = 3 * len(chosen) / len(self.lengths)
        self._weights = np.sqrt(share) * units[self.edges.of_edge] / self.lengths
        self.factor: SymmetricFactor | None = None
        self._factored: Floats | None = None  # where
        self.in_charts_of(positions)

    def in_charts_of(self, positions: Floats) -> None:
        """Interpolate in the tangent planes of a surface (V, 3) that is nearer to the one sought."""
        self.P, self._differences = self.edges.interpolated(positions)

    def residuals(self, vertices: Floats, lengths: Floats) -> Floats:
        """The errors r of the lengths of the edges that are measured."""
        d = self._differences @ vertices
        norm = np.sqrt(np.einsum("ij,ij->i", d, d))
        return self._weights * (norm - lengths) * (norm + lengths) / (2 * lengths)

    def _rows(self, vertices: Floats, lengths: Floats) -> Floats:
        return (self._weights / lengths)[:, None] * (self._differences @ vertices)

    def forces(self, vertices: Floats, lengths: Floats, tensions: Floats) -> Floats:
        """``J^T y`` of the edges that are measured."""
        return self._differences.transposed(self._rows(vertices, lengths) * tensions[:, None])

    def step(
        self,
        vertices: Floats,
        lengths: Floats,
        mu: float,
        w: float,
        recorder: StageRecorder,
        stiffness: float = 1.0,
    ) -> tuple[Floats, bool]:
        """Newton step, repeated with new factors if reused ones lead uphill."""
        before = self.factor
        trial, downhill = super().step(vertices, lengths, mu, w, recorder, stiffness)
        if downhill or before is None or self.factor is not before or self._factored is vertices:
            return trial, downhill
        self.factor = None
        return super().step(vertices, lengths, mu, w, recorder, stiffness)

    def solved(self, vertices: Floats, lengths: Floats, gradient: Floats, mu: float, w: float) -> Floats:
        """Solve for a step by conjugate gradients, with reused factors as long as they are good enough."""
        rows = self._rows(vertices, lengths)

        def product(d: Floats) -> Floats:
            stretch = np.einsum("ij,ij->i", rows, self._differences @ d)
            return self._differences.transposed(rows * stretch[:, None]) + mu * self.roughness(d, w)

        def attempt(
            factor: SymmetricFactor, tolerance: float, limit: int, patience: int | None = None
        ) -> Approximation:
            def precondition(forces: Floats) -> Floats:
                return factor.solve(forces.ravel(), sweeps=0).reshape(-1, 3)

            return conjugate_gradients(product, precondition, gradient, tolerance, limit, patience=patience)

        if self.factor is not None:
            worth = int(1.1e-4 * len(vertices) ** 1.5)  # iterations worth a new factorization
            limit = min(worth, MAX_ITERATIONS)
            # Three iterations before extrapolating their number.
            found = attempt(self.factor, SOLVED, limit, 3)
            if found.residual <= SOLVED:
                return found.x
        self.factor = None  # free its memory for the next
        penalty = csr_array(mu * (self._RR + w * self._KK))
        self.factor, self._factored = self.edges.factor(self._differences, rows, penalty), vertices
        return attempt(self.factor, 1e-4, MAX_ITERATIONS).x  # cheap with its own factors
