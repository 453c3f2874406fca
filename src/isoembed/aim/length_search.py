"""A search for a surface with given lengths: what it has spent, and what has missed them least."""

import numpy as np

from isoembed.aim.regularized_energy import RegularizedEnergy
from isoembed.arrays import Floats
from isoembed.progress.stages import StageRecorder
from isoembed.surface.rigidity import LengthSystem


class LengthSearch:
    """What searches share.

    Parameters
    ----------
    energy : RegularizedEnergy
        Of a metric in Euclidean space.
    system : LengthSystem
        Of its triangulation.
    vertices : ndarray, shape (V, 3)
        Where it begins.
    lengths : ndarray, shape (E,)
    recorder : StageRecorder
        Counts factorizations.
    most : float
        Factorizations after which nothing more is tried.

    Attributes
    ----------
    cost : float
        What counts as shares of factorizations, added up.
    nearest : ndarray, shape (V, 3)
        What has missed the lengths least of all that was kept.
    missed : float
        Its largest error, in mean edge lengths.
    """

    def __init__(
        self,
        energy: RegularizedEnergy,
        system: LengthSystem,
        vertices: Floats,
        lengths: Floats,
        recorder: StageRecorder,
        most: float,
    ) -> None:
        self.energy, self.system, self.lengths, self.recorder = energy, system, lengths, recorder
        self.most, self.cost, self._begun = most, 0.0, recorder.factorizations
        self.nearest, self.missed = vertices, self.largest_residual(vertices)

    def spend(self, cost: float) -> None:
        """Add what counts as a share of a factorization."""
        self.cost += cost

    @property
    def spent(self) -> float:
        """Factorizations, and what else counts as shares of one."""
        return self.recorder.factorizations - self._begun + self.cost

    @property
    def exhausted(self) -> bool:
        """Whether as much is spent as may be."""
        return self.spent >= self.most

    def largest_residual(self, x: Floats) -> float:
        """Largest error of the lengths, in mean edge lengths."""
        return float(np.abs(self.energy.residuals(x, self.lengths)).max()) / self.energy.unit

    def keep(self, x: Floats) -> float:
        """Keep a surface if it misses less than all before; returns its largest residual."""
        missed = self.largest_residual(x)
        if missed < self.missed:
            self.nearest, self.missed = x, missed
        return missed

    def show(self, x: Floats) -> None:
        """Tell a listener of a surface, and of the share of the search that is done."""
        done = 1.0 if self.exhausted else self.spent / self.most
        self.recorder.show(vertices=x, residual=self.largest_residual(x), done=done)
