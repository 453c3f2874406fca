"""Result of a task: a report, with arrays where it succeeded."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from isoembed.io import npz
from isoembed.io.files import FileError, Writer
from isoembed.io.input_file import InputFile
from isoembed.strict_json import plain, strict_json

TEXTS = ("label", "status", "report")
ARRAY = "array/"  # before the names of the arrays, which are the task's own
REFUSED, FAILED = "refused", "failed"


@dataclass(frozen=True, eq=False)
class Result:
    """Result of a task, for a file and for the task after it.

    Attributes
    ----------
    label : str
        Of the task.
    status : str
        "refused" where the input is wrong, "failed" where the computation could not be done (memory, a worker
        that was killed); others are the task's own, such as "embedded" and "not embedded".
    report : dict
        Plain numbers and texts, for JSON; has a "message" where there is no answer.
    arrays : mapping of str to ndarray
        Numbers by their names; none where there is no answer.
    """

    label: str
    status: str
    report: dict[str, Any]
    arrays: Mapping[str, NDArray[Any]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "report", plain(self.report))  # as it is read again

    @classmethod
    def without_answer(cls, label: str, status: str, message: str, **facts: Any) -> Result:
        """The result of a task that has no answer, with the reason."""
        return cls(label, status, {"status": status, "message": message, **facts})

    @property
    def answered(self) -> bool:
        """Whether there is an answer."""
        return bool(self.arrays)

    @property
    def message(self) -> str:
        """The reason where there is no answer."""
        return str(self.report.get("message", ""))

    @property
    def writer(self) -> Writer:
        """Writer of an archive with all of it; see `isoembed.io.write_atomically`."""
        tables: dict[str, Any] = {ARRAY + name: array for name, array in self.arrays.items()}
        tables |= {"label": self.label, "status": self.status, "report": strict_json(self.report)}
        return lambda temporary: npz.write(temporary, tables)

    @classmethod
    def read(cls, path: Path) -> Result:
        """The result in a file.

        Raises
        ------
        FileError
            The file cannot be read or holds no result.
        """
        with InputFile(path) as file:
            tables = npz.read(file)
        for name in TEXTS:
            value = tables.get(name)
            if not isinstance(value, np.ndarray) or value.shape != () or value.dtype.kind != "U":
                raise FileError(f"{path} is not a result: it has no {name!r}")
        label, status, text = (tables[name].item() for name in TEXTS)
        try:
            report = json.loads(text)
        except ValueError as error:
            raise FileError(f"{path} is not a result: its report is not JSON: {error}") from None
        arrays = {name.removeprefix(ARRAY): table for name, table in tables.items() if name.startswith(ARRAY)}
        return cls(label, status, report, arrays)
