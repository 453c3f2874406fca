"""Problem shared by all strategies: metric, tolerance, convexification, and placement of a surface."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from isoembed.aim.convexification import Convexification
from isoembed.alexandrov.newton import Analyses
from isoembed.arrays import Floats
from isoembed.embedding.embedding import Embedding
from isoembed.linalg import Work
from isoembed.metric.glued import GluedMetric
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.progress.stages import StageRecorder
from isoembed.surface.measures import outward
from isoembed.surface.placement import standard_position

if TYPE_CHECKING:
    from isoembed.aim.regularized_energy import RegularizedEnergy
    from isoembed.surface.rigidity import LengthSystem


class Problem:
    """A metric to embed, quantities derived from it, and a tolerance.

    Parameters
    ----------
    metric : PolyhedralMetric
        Scaled to a mean edge length of about 1.
    tolerance : float
    name : str
        Name of the method, stored in the surfaces.
    work : Work
        Counter of factorizations.

    Attributes
    ----------
    numbers : ndarray of int, shape (V,)
        The vertices in the order of the `convexification`, in which neighbors are close in memory.
    """

    def __init__(self, metric: PolyhedralMetric, tolerance: float, name: str, work: Work) -> None:
        self.metric, self.tolerance, self.name, self.work = metric, tolerance, name, work
        tables = GluedMetric.of(metric).half_edges(directed=False)
        self.numbers = tables.order_in_memory()
        self.convexification = Convexification(GluedMetric.flipped(tables.in_order(self.numbers)))
        self._energy: tuple[Floats, RegularizedEnergy] | None = None

    # Derived quantities, computed once

    @cached_property
    def analyses(self) -> Analyses:
        """Symbolic factorization that all factorizations for the radii share."""
        return Analyses.of(self.convexification.original.half_edges(directed=False), self.work)

    def forget_analyses(self) -> None:
        """Free the memory of `analyses`, which the next strategies need for large bodies."""
        vars(self).pop("analyses", None)

    @cached_property
    def system(self) -> LengthSystem:
        """The length equations."""
        from isoembed.surface.rigidity import LengthSystem  # slow to import, not needed for convex bodies

        return LengthSystem(self.metric.triangulation, space=self.metric.space, work=self.work)

    def energy(self, start: Floats) -> RegularizedEnergy:
        """The regularized energy about a convex surface (V, 3)."""
        from isoembed.aim.regularized_energy import RegularizedEnergy

        if self._energy is None or self._energy[0] is not start:
            self._energy = start, RegularizedEnergy(self.metric, start, self.work)
        return self._energy[1]

    def annealed(self, vertices: Floats, recorder: StageRecorder) -> Embedding:
        """The surface to which Newton's method on the lengths converges from these vertices."""
        from isoembed.aim.anneal import DAMPED_STEPS, anneal

        found = anneal(self.system, vertices, self.metric.lengths, recorder, max_damped=DAMPED_STEPS)
        return self.surface(found.vertices)

    # Convexity

    @property
    def is_nearly_convex(self) -> bool:
        """Whether a generalized polytope may have this metric."""
        # Negative curvature over 4 pi.
        return self.convexification.negative_curvature < 0.03

    @property
    def is_convex(self) -> bool:
        """Whether no deficit is negative beyond rounding."""
        return self.convexification.is_convex

    # Placement

    def surface(self, vertices: Floats) -> Embedding:
        """The surface with these vertices, moved to its standard position."""
        return self.placed(standard_position(self.metric.faces, vertices, self.metric.space))

    def placed(self, vertices: Floats) -> Embedding:
        """The surface with these vertices, already in standard position."""
        return Embedding(self.metric, vertices, method=self.name, tolerance=self.tolerance)

    def in_original_order(self, vertices: Floats) -> Floats:
        """Vertices of the convexification in the given order, or their mirror image: `outward`."""
        return outward(self.metric.faces, vertices[np.argsort(self.numbers)])
