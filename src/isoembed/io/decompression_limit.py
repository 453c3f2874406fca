"""Limit of the decompressed size of input files, against decompression bombs."""

from dataclasses import dataclass

from isoembed.io.files import FileError
from isoembed.thresholds import threshold


@dataclass(frozen=True)
class ExpansionThresholds:
    """Thresholds of compressed files."""

    spare: int = threshold(2**28, "bytes", "Size below which any expansion ratio is accepted.")
    ratio: int = threshold(
        100,
        "bytes a byte",
        "Largest expansion ratio above that size; coordinates and indices expand 2 to 10 times.",
    )


EXPANSION = ExpansionThresholds()


def largest_expansion(stored: int) -> int:
    """Largest permitted decompressed size of a given number of bytes."""
    return EXPANSION.spare + EXPANSION.ratio * stored


def check_expansion(name: str, size: int, stored: int) -> None:
    """Raise an error if data expand too far.

    Parameters
    ----------
    name : str
        Name of the data, for the message.
    size, stored : int
        Sizes in bytes, expanded and stored.

    Raises
    ------
    FileError
    """
    if size > (limit := largest_expansion(stored)):
        raise FileError(f"{name} expands from {stored} to more than {limit} bytes, too many for a surface")
