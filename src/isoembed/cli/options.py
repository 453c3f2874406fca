"""Options that several commands share."""

import argparse
from pathlib import Path

from isoembed.cli.screen import UsageError

DEFAULT, FEWEST = 1000, 12  # vertices


def add_output_option(
    parser: argparse.ArgumentParser, purpose: str, *, metavar: str = "FILE", required: bool = False
) -> None:
    """Add the option that says where the answer goes."""
    parser.add_argument("-o", "--output", type=Path, metavar=metavar, required=required, help=purpose)


def add_json_option(
    parser: argparse.ArgumentParser, purpose: str = "print one JSON object instead of text"
) -> None:
    """Add the option that asks for JSON."""
    parser.add_argument("--json", action="store_true", help=purpose)


def add_quiet_option(parser: argparse.ArgumentParser) -> None:
    """Add the option that silences the command."""
    parser.add_argument("--quiet", action="store_true", help="print nothing but errors")


def add_vertices_option(parser: argparse.ArgumentParser) -> None:
    """Add the option that says how fine the mesh of a smooth surface is."""
    parser.add_argument(
        "--vertices",
        type=int,
        metavar="N",
        help=f"of the mesh that finds a smooth surface, and of the one that is written (default {DEFAULT})",
    )


def vertices(options: argparse.Namespace) -> int:
    """How many vertices the mesh of a smooth surface has.

    Raises
    ------
    UsageError
        They are too few.
    """
    if options.vertices is not None and options.vertices < FEWEST:
        raise UsageError(f"--vertices must be at least {FEWEST}, not {options.vertices}")
    return DEFAULT if options.vertices is None else int(options.vertices)
