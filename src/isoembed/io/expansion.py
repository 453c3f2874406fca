"""Decompression limits, against archives that expand without bound."""

from dataclasses import dataclass

from isoembed.io.files import FileError
from isoembed.thresholds import threshold


@dataclass(frozen=True)
class ExpansionThresholds:
    """Thresholds of compressed files."""

    spare: int = threshold(2**28, "bytes", "Size up to which any expansion is taken.")
    ratio: int = threshold(
        100, "bytes a byte", "Largest expansion beyond; coordinates and indices expand 2 to 10 times."
    )


EXPANSION = ExpansionThresholds()


def largest_expansion(stored: int) -> int:
    """Largest number of bytes that a number of compressed ones may hold."""
    return EXPANSION.spare + EXPANSION.ratio * stored


def check_expansion(what: str, size: int, stored: int) -> None:
    """Refuse what would expand too far.

    Parameters
    ----------
    what : str
    size, stored : int
        Its bytes, expanded and in the file.

    Raises
    ------
    FileError
    """
    if size > (most := largest_expansion(stored)):
        raise FileError(f"{what} expands from {stored} to more than {most} bytes, as no surface does")
