"""Result of a task: a report and, if successful, arrays."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from isoembed.io import npz
from isoembed.io.files import FileError, Writer
from isoembed.io.input_file import InputFile
from isoembed.strict_json import plain, strict_json

TEXTS = ("label", "status", "report")
ARRAY = "array/"  # prefix of the array names, which the task chooses
REFUSED, FAILED = "refused", "failed"


@dataclass(frozen=True, eq=False)
class Result:
    """Result of a task, for storage and as a starting point of the next task.

    Attributes
    ----------
    label : str
        Label of the task.
    status : str
        "refused" if the input is invalid, "failed" if the computation could not be completed (out of memory,
        killed worker); other values are the task's own, such as "embedded" and "not embedded".
    report : dict
        Plain numbers and strings, for JSON; has a "message" if there is no answer.
    arrays : mapping of str to ndarray
        Arrays by name; empty if there is no answer.
    """

    label: str
    status: str
    report: dict[str, Any]
    arrays: Mapping[str, NDArray[Any]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "report", plain(self.report))  # equal to the report read from a file

    @classmethod
    def without_answer(cls, label: str, status: str, message: str, **facts: Any) -> Result:
        """Result of a task without an answer, with the reason."""
        return cls(label, status, {"status": status, "message": message, **facts})

    @property
    def answered(self) -> bool:
        """Whether there is an answer."""
        return bool(self.arrays)

    @property
    def message(self) -> str:
        """Reason why there is no answer."""
        return str(self.report.get("message", ""))

    @property
    def writer(self) -> Writer:
        """Writer of the result as an archive; see `isoembed.io.write_atomically`."""
        tables: dict[str, Any] = {ARRAY + name: array for name, array in self.arrays.items()}
        tables |= {"label": self.label, "status": self.status, "report": strict_json(self.report)}
        return lambda temporary: npz.write(temporary, tables)

    @classmethod
    def read(cls, path: Path) -> Result:
        """Read a result from a file.

        Raises
        ------
        FileError
            The file cannot be read or contains no result.
        """
        with InputFile(path) as file:
            tables = npz.read(file)
        label, status, text = (npz.scalar(tables, name, "U", f"{path} is not a result") for name in TEXTS)
        try:
            report = json.loads(text)
        except ValueError as error:
            raise FileError(f"{path} is not a result: its report is not JSON: {error}") from None
        return cls(label, status, report, npz.with_prefix(tables, ARRAY))
