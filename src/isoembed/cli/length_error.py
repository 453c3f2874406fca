"""The option ``--length-error``: standard deviations of the lengths."""

import argparse
from pathlib import Path

import numpy as np

from isoembed.arrays import Floats
from isoembed.cli.console import UsageError
from isoembed.cli.numbers import read_numbers
from isoembed.io.files import ending
from isoembed.typed_numbers import number


def add_length_error_option(
    parser: argparse.ArgumentParser, purpose: str = "", *, required: bool = False
) -> None:
    """Add the option."""
    parser.add_argument(
        "--length-error",
        required=required,
        metavar="E",
        help="standard deviation of the independent length errors, in the unit of the lengths: a number, "
        f"or a .npy file with one number per edge, in the order of the file{purpose}",
    )


def length_errors(options: argparse.Namespace) -> Floats | None:
    """One error for all lengths, or one per edge; None if the option is not given.

    Raises
    ------
    UsageError
        The value is neither a number nor a file of numbers.
    FileError
    """
    text = options.length_error
    if text is None:
        return None
    if ending(text) == ".npy":
        return read_numbers(Path(text))
    try:
        return np.array(number(text))
    except ValueError:
        raise UsageError(f"--length-error {text} is neither a number nor a .npy file") from None


def not_rigid(path: Path | str) -> UsageError:
    """Error for a surface whose deviation is undefined."""
    return UsageError(
        f"{path} is not infinitesimally rigid, for example at a flat vertex: to first order, its "
        "response to length errors is unbounded"
    )
