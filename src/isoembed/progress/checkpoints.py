"""Checkpoints: states of a computation, from which another run goes on."""

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
    """State of an interrupted computation, from which it can go on.

    Attributes
    ----------
    key : str
        The strategy that was running, as its method calls it; empty in a method of one strategy.
    arrays : mapping of str to ndarray
        What that strategy needs to go on; nothing if it is to begin anew.
    state : mapping of str to ndarray
        What was known when the strategy began.
    fingerprint : Fingerprint or None
        What was being computed.
    factorizations : int
        Sparse factorizations of the computation until then.
    """

    key: str
    arrays: Arrays
    state: Arrays = field(default_factory=dict)
    fingerprint: Fingerprint | None = None
    factorizations: int = 0


@dataclass
class Checkpoints:
    """Checkpoints of one computation: the one that it goes on from, and the last one that it has kept.

    Parameters
    ----------
    resumed : Checkpoint, optional
        To go on from.
    fingerprint : Fingerprint, optional
        What is being computed.

    Attributes
    ----------
    work : Work
        Of the computation.
    last : Checkpoint or None
        The one kept last; until then the resumed one.
    """

    resumed: Checkpoint | None = None
    fingerprint: Fingerprint | None = None
    work: Work = field(default_factory=Work)
    last: Checkpoint | None = field(init=False)
    _key: str = field(init=False, default="")
    _state: Arrays = field(init=False, default_factory=dict)
    _taken: bool = field(init=False, default=False)

    def __post_init__(self) -> None:
        self.last = self.resumed

    def begin(self, key: str, state: Mapping[str, ArrayLike]) -> None:
        """Begin a strategy: what is kept from now on is its own, and comes with this state."""
        self._key, self._state = key, _arrays(state)

    def keep(self, **arrays: ArrayLike) -> None:
        """Replace the last checkpoint by what the running strategy could go on from.

        It costs nothing: arrays are not copied, so they must not change any more.  What is kept has to hold
        in the unit of ``metric.normalized``, and for the given vertices in the given order.
        """
        self.last = Checkpoint(
            self._key, _arrays(arrays), self._state, self.fingerprint, self.work.factorizations
        )

    def resume(self, **belonging: ArrayLike) -> Arrays | None:
        """Arrays of the checkpoint to go on from, if the running strategy kept them; once.

        The work is then that of the checkpoint: what was done again to come here does not count.

        Parameters
        ----------
        **belonging : ndarray
            Arrays that the checkpoint must hold: otherwise it was kept by another part of the strategy.
        """
        found = self.resumed
        if found is None or self._taken or found.key != self._key or not found.arrays:
            return None
        for name, array in belonging.items():
            if name not in found.arrays or not np.array_equal(found.arrays[name], array):
                return None
        self._taken, self.work.factorizations = True, found.factorizations
        return found.arrays


def _arrays(values: Mapping[str, ArrayLike]) -> dict[str, NDArray[Any]]:
    return {name: np.asarray(value) for name, value in values.items()}
