"""Text tables of numbers with ``#`` comments."""

from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.io.files import FileError
from isoembed.io.input_file import InputFile


@dataclass(frozen=True)
class TextTable:
    """A table of numbers from a text file.

    Attributes
    ----------
    comments : tuple of str
        Comment lines, without the ``#``.
    numbers : ndarray, shape (n_rows, n_columns)
    lines : ndarray of int, shape (n_rows,)
        Line number of each row, from 1.
    """

    comments: tuple[str, ...]
    numbers: Floats
    lines: Indices


def words_of(line: str) -> list[str]:
    """The words of a row, between blanks, commas or semicolons; beside semicolons, commas are decimal."""
    if ";" in line:
        return line.replace(",", ".").replace(";", " ").split()
    return line.replace(",", " ").split()


def read_text_table(file: InputFile, *, named: bool = False) -> TextTable:
    """Read a table of numbers separated as in `words_of`; blank lines are skipped.

    Parameters
    ----------
    file : InputFile
    named : bool
        Whether the first line that is not a comment may contain column names.

    Raises
    ------
    FileError
        There are no rows, a word is not a number, or the rows have different numbers of columns; the message
        names the line.
    """
    lines = list(enumerate(map(str.strip, file.text.splitlines()), 1))
    rows = [(number, words_of(line)) for number, line in lines if line and not line.startswith("#")]
    if named and rows and rows[0][1][0].isidentifier():
        del rows[0]
    if not rows:
        raise FileError(f"{file} holds no numbers")
    columns = len(rows[0][1])
    values = []
    for number, words in rows:
        if len(words) != columns:
            raise FileError(f"{file}, line {number}: there are {len(words)} columns, not {columns}")
        try:
            values.append([float(word) for word in words])
        except ValueError as error:
            raise FileError(f"{file}, line {number}: {error}") from None
    comments = tuple(line[1:].strip() for _, line in lines if line.startswith("#"))
    return TextTable(comments, np.array(values), np.array([number for number, _ in rows], dtype=np.int64))
