"""State of a search: remaining budget and nearest surface so far."""

import numpy as np

from isoembed.aim.regularized_energy import RegularizedEnergy
from isoembed.arrays import Floats
from isoembed.linalg.work import Budget
from isoembed.progress.stages import StageRecorder
from isoembed.surface.rigidity import LengthSystem


class SearchState:
    """Base class of searches: budget, recorder and nearest surface so far.

    Parameters
    ----------
    energy : RegularizedEnergy
        Energy of a metric in Euclidean space.
    system : LengthSystem
    vertices : ndarray, shape (V, 3)
        Start of the search.
    lengths : ndarray, shape (E,)
    recorder : StageRecorder
        Recorder of the work.
    budget : Budget

    Attributes
    ----------
    nearest : ndarray, shape (V, 3)
        The surface kept with the smallest residual.
    residual : float
        Its largest residual, in mean edge lengths.
    """

    def __init__(
        self,
        energy: RegularizedEnergy,
        system: LengthSystem,
        vertices: Floats,
        lengths: Floats,
        recorder: StageRecorder,
        budget: Budget,
    ) -> None:
        self.energy, self.system, self.lengths = energy, system, lengths
        self.recorder, self.budget = recorder, budget
        self.nearest, self.residual = vertices, self.largest_residual(vertices)

    @property
    def exhausted(self) -> bool:
        """Whether the budget is exhausted."""
        return self.budget.exhausted

    def largest_residual(self, x: Floats) -> float:
        """Largest error of the lengths, in mean edge lengths."""
        return float(np.abs(self.energy.residuals(x, self.lengths)).max()) / self.energy.unit

    def keep(self, x: Floats) -> float:
        """Keep a surface if its largest residual is the smallest so far; return the residual."""
        residual = self.largest_residual(x)
        if residual < self.residual:
            self.nearest, self.residual = x, residual
        return residual

    def show(self, x: Floats) -> None:
        """Report a surface and the progress of the search to the listener."""
        fraction = 1.0 if self.budget.exhausted else self.budget.spent / self.budget.limit
        self.recorder.show(vertices=x, residual=self.largest_residual(x), done=fraction)
