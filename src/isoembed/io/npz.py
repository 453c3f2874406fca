"""NumPy archives (.npz)."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from isoembed.io.files import FileError, Tables
from isoembed.io.format import Format
from isoembed.io.input_file import InputFile


def read(file: InputFile) -> Tables:
    """Arrays of an archive by name."""
    return file.arrays[""]


def write(path: Path, tables: Tables) -> None:
    """Write named arrays."""
    with path.open("wb") as file:
        np.savez(file, **tables)


def with_prefix(tables: Mapping[str, Any], prefix: str) -> dict[str, Any]:
    """Arrays with a prefix of their names, by the rest of the names."""
    return {name.removeprefix(prefix): array for name, array in tables.items() if name.startswith(prefix)}


def scalar(tables: Tables, name: str, kind: str, otherwise: str) -> Any:
    """Scalar of a given dtype kind.

    Raises
    ------
    FileError
        There is none; the message begins with what the file is otherwise.
    """
    value = tables.get(name)
    if not isinstance(value, np.ndarray) or value.shape != () or value.dtype.kind != kind:
        raise FileError(f"{otherwise}: it has no {name!r}")
    return value.item()


FORMAT = Format(".npz", read, write, holds_metrics=True)
