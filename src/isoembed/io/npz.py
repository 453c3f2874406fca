"""NumPy archives (.npz)."""

from pathlib import Path

import numpy as np

from isoembed.io.files import Tables
from isoembed.io.format import Format
from isoembed.io.input_file import InputFile


def read(file: InputFile) -> Tables:
    """Arrays of an archive by name."""
    return file.arrays[""]


def write(path: Path, tables: Tables) -> None:
    """Write named arrays."""
    with path.open("wb") as file:
        np.savez(file, **tables)


FORMAT = Format(".npz", read, write, holds_metrics=True)
