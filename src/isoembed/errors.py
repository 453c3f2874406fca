"""Exceptions and warnings, including notes on meshes that are accepted after a change."""

from __future__ import annotations

import sys
import warnings
from types import FrameType
from typing import TYPE_CHECKING, Any

from isoembed.evidence import Evidence

if TYPE_CHECKING:
    from isoembed.progress.checkpoints import Checkpoint
    from isoembed.progress.stages import Stage


SEARCHED = Evidence("searched", "the search that the message describes")


class InvalidMetric(ValueError):  # noqa: N818 - the contract's name
    """The input is not a valid polyhedral metric.

    The message is one sentence that names the first offending vertex, edge or face by its index and value.
    """


class MeshNote(UserWarning):
    """A property of a mesh, or a change of it, that the user should know; a sentence."""


def warn_of_mesh(note: str) -> None:
    """Issue a `MeshNote` at the line outside of the package from which this was called."""
    frame: FrameType | None = sys._getframe()
    level = 1
    while frame is not None and frame.f_globals.get("__name__", "").partition(".")[0] == __package__:
        frame = frame.f_back
        level += 1
    warnings.warn(note, MeshNote, stacklevel=level)


class InvalidParameter(ValueError):  # noqa: N818 - as the others
    """A method's parameter has a value that it cannot have; the message names it."""


class NotEmbedded(RuntimeError):  # noqa: N818 - the contract's name
    """No embedding within the tolerance was found.

    Parameters
    ----------
    message : str
        The diagnosis: how far from the lengths it ended, and where the method lost the surface.
    embedding : Embedding or SmoothEmbedding
        The best attempt: of a polyhedral metric an `Embedding`, of a smooth metric a `SmoothEmbedding`; its
        ``residual`` says how far from the metric it is.
    evidence : Evidence
        The extent of the search, or the proof that there is no embedding.

    Attributes
    ----------
    embedding : Embedding
        As given.
    evidence : Evidence
        As given.
    """

    def __init__(self, message: str, embedding: Any, evidence: Evidence = SEARCHED) -> None:
        super().__init__(message, embedding, evidence)  # all, for pickle
        self.embedding = embedding
        self.evidence = evidence

    def __str__(self) -> str:
        return str(self.args[0])

    @property
    def report(self) -> dict[str, str]:
        """The message, and the evidence for it, as entries of a report."""
        return {"message": str(self), **self.evidence.report}


class NoMinimum(RuntimeError):  # noqa: N818 - as the others
    """The search for a least energy ended where the energy still falls; the message says how fast."""


class NoHorizon(RuntimeError):  # noqa: N818 - as the others
    """No horizon, or no surface of the expansion asked for, was found; a sentence says why.

    Parameters
    ----------
    message : str
    least : float, optional
        The least ``c R / 2`` of the surfaces of constant expansion c and areal radius R in the search,
        which is 1 for spheres in flat space and 0 on a horizon.
    evidence : Evidence
        The extent of the search, or the proof that there is no horizon.
    least_error : float, optional
        The error of `least`, where it is a minimum above zero.
    barriers : tuple of two Surface, optional
        Surfaces of positive and of negative expansion, the second one inside the first one: a horizon exists
        between them, and was not resolved.

    Attributes
    ----------
    least, evidence, least_error, barriers
        As given.
    """

    def __init__(
        self,
        message: str,
        least: float | None = None,
        evidence: Evidence = SEARCHED,
        least_error: float | None = None,
        barriers: tuple[Any, Any] | None = None,
    ) -> None:
        super().__init__(message, least, evidence, least_error, barriers)  # all, for pickle
        self.least = least
        self.evidence = evidence
        self.least_error = least_error
        self.barriers = barriers

    def __str__(self) -> str:
        return str(self.args[0])

    @property
    def report(self) -> dict[str, Any]:
        """The message, the least that was met, and the evidence, as entries of a report."""
        least = {"least_expansion": self.least, "least_expansion_error": self.least_error}
        return {"message": str(self), **least, **self.evidence.report}


class Interrupted(KeyboardInterrupt):
    """The computation was interrupted, by Ctrl-C for one.

    Parameters
    ----------
    checkpoint : Checkpoint or None
        The state to continue from: the ``resume`` of `isoembed.embed`.  None if nothing was kept yet; the
        method ``"paper"`` keeps nothing.
    stages : tuple of Stage
        The stages so far; the last one is incomplete.

    Attributes
    ----------
    checkpoint, stages
        As given.
    """

    def __init__(self, checkpoint: Checkpoint | None, stages: tuple[Stage, ...]) -> None:
        super().__init__(checkpoint, stages)  # both, for pickle
        self.checkpoint = checkpoint
        self.stages = stages

    def __str__(self) -> str:
        return f"interrupted in the stage {self.stages[-1].name!r}" if self.stages else "interrupted"
