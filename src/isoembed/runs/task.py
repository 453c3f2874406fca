"""Tasks, and the keys of their stored results."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from typing import Any, Protocol

from isoembed.runs.result import Result
from isoembed.version import __version__


class Task(Protocol):
    """One computation of many; must be picklable, and holds paths rather than file contents."""

    @property
    def label(self) -> str:
        """Label of the task, unique in the run and valid as a file name."""
        ...

    @property
    def facts(self) -> Mapping[str, Any]:
        """Report entries of a result without an answer, besides status and message."""
        ...

    def digest(self) -> str:
        """Digest of everything that affects the result: contents of the input, and options.

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
            Result of the last previous task in the chunk with an answer, as a starting point.

        Returns
        -------
        Result
            Result, with status and message if the user's input has no answer.
        """
        ...


def key_of(text: str) -> str:
    """Key of a result: digest of everything that affects it, including the version of isoembed."""
    # Two of a million results have the same 16 hexadecimal digits once in 10 million runs.
    return hashlib.sha256(f"{__version__} {text}".encode()).hexdigest()[:16]
