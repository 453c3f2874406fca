"""Checkpoints: states from which a computation can be resumed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from isoembed.linalg import Work
from isoembed.progress.fingerprint import Fingerprint

Arrays = Mapping[str, NDArray[Any]]


@dataclass(frozen=True, eq=False)
class Checkpoint:
    """State from which an interrupted computation can be resumed.

    Attributes
    ----------
    key : str
        Method's key of the running strategy; empty for a method with a single strategy.
    arrays : mapping of str to ndarray
        Arrays from which the strategy can be resumed; empty if it must restart.
    state : mapping of str to ndarray
        State at the start of the strategy.
    fingerprint : Fingerprint or None
        Identity of the computation.
    factorizations : int
        Number of sparse factorizations so far.
    """

    key: str
    arrays: Arrays
    state: Arrays = field(default_factory=dict)
    fingerprint: Fingerprint | None = None
    factorizations: int = 0


@dataclass
class Checkpoints:
    """Checkpoints of one computation: the one it resumes from, and the last one kept.

    Parameters
    ----------
    resumed : Checkpoint, optional
        Checkpoint to resume from.
    fingerprint : Fingerprint, optional
        Identity of the computation.

    Attributes
    ----------
    work : Work
        Work of the computation.
    last : Checkpoint or None
        Last checkpoint kept; initially the resumed one.
    """

    resumed: Checkpoint | None = None
    fingerprint: Fingerprint | None = None
    work: Work = field(default_factory=Work)
    last: Checkpoint | None = field(init=False)
    _key: str = field(init=False, default="")
    _state: Arrays = field(init=False, default_factory=dict)
    _resumed: bool = field(init=False, default=False)

    def __post_init__(self) -> None:
        self.last = self.resumed

    def begin(self, key: str, state: Mapping[str, ArrayLike]) -> None:
        """Begin a strategy: subsequent checkpoints have this key and state."""
        self._key, self._state = key, _arrays(state)

    def keep(self, **arrays: ArrayLike) -> None:
        """Replace the last checkpoint by one from which the running strategy can be resumed.

        Arrays are not copied, so they must not be modified afterward.  They must be valid in the unit of
        ``metric.normalized``, and for the given vertices in the given order.
        """
        self.last = Checkpoint(
            self._key, _arrays(arrays), self._state, self.fingerprint, self.work.factorizations
        )

    def resume(self, **belonging: ArrayLike) -> Arrays | None:
        """Arrays of the checkpoint to resume from, if the running strategy kept them; only once.

        The work counter is reset to that of the checkpoint: work repeated on the way here is not counted.

        Parameters
        ----------
        **belonging : ndarray
            Arrays that the checkpoint must contain; otherwise it was kept by another part of the strategy.
        """
        found = self.resumed
        if found is None or self._resumed or found.key != self._key or not found.arrays:
            return None
        for name, array in belonging.items():
            if name not in found.arrays or not np.array_equal(found.arrays[name], array):
                return None
        self._resumed, self.work.factorizations = True, found.factorizations
        return found.arrays


def _arrays(values: Mapping[str, ArrayLike]) -> dict[str, NDArray[Any]]:
    return {name: np.asarray(value) for name, value in values.items()}
