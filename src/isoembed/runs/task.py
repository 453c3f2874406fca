"""Tasks, and the keys of their stored results."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from typing import Any, Protocol

from isoembed.runs.result import Result
from isoembed.version import __version__

DIGITS = 16  # of a key, hexadecimal: two of a million results meet once in 10 million runs


class Task(Protocol):
    """One computation of many; it can be pickled, and holds paths rather than what is in files."""

    @property
    def label(self) -> str:
        """Name of the task: unique in the run and valid as a file name."""
        ...

    @property
    def facts(self) -> Mapping[str, Any]:
        """Entries of the report of a result without an answer, besides status and message."""
        ...

    def digest(self) -> str:
        """A digest of the content of its input and of its options: all that decides what it computes.

        Raises
        ------
        FileError, InvalidParameter
            The input cannot be read, or has no digest.
        """
        ...

    def compute(self, before: Result | None) -> Result:
        """Compute the result.

        Parameters
        ----------
        before : Result, optional
            Of the last task before it in its chunk that has an answer: something to start from.

        Returns
        -------
        Result
            With a status and a message where what the user gave has no answer.
        """
        ...


def key_of(text: str) -> str:
    """Key of a result: a digest of what decides it, and of the version of isoembed."""
    return hashlib.sha256(f"{__version__} {text}".encode()).hexdigest()[:DIGITS]
