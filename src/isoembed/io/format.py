"""What a file format is: an ending, a reader and a writer."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from isoembed.io.files import Tables
from isoembed.io.input_file import InputFile


@dataclass(frozen=True)
class Format:
    """A file format of surfaces.

    Attributes
    ----------
    ending : str
        Of the names of its files, in lower case, with its dot.
    read : callable
        Takes an `InputFile` and returns its arrays by their names: ``vertices`` (V, 3) and ``faces`` (F, 3),
        or ``faces``, ``edges`` (E, 2) and ``lengths`` (E,).
    write : callable
        Takes a path and such arrays, to which those of data at the vertices (V,) may be added.
    holds_metrics : bool
        It has a place for arrays of any name, so for metrics without vertices.
    """

    ending: str
    read: Callable[[InputFile], Tables]
    write: Callable[[Path, Tables], None]
    holds_metrics: bool = False
