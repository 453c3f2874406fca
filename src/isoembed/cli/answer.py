"""What every command that embeds does with its answer: show it, write it, report it, and its exit status."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Mapping
from itertools import combinations
from pathlib import Path
from typing import Any

import isoembed
from isoembed.cli.live import live_view
from isoembed.cli.pictures import add_picture_options, check_pictures, film_for, picture_writers
from isoembed.cli.refusal import UsageError
from isoembed.cli.screen import print_error, print_out
from isoembed.cli.status import NOT_EMBEDDED, OK
from isoembed.cli.summary import summary
from isoembed.errors import NotEmbedded
from isoembed.io import (
    REPORT_ENDINGS,
    SURFACE_ENDINGS,
    check_output,
    report_writer,
    surface_writer,
    write_atomically,
)
from isoembed.io.files import Writer
from isoembed.progress.stages import Listener, Progress

OUTPUTS = ("output", "report", "picture", "html", "animate")


def add_output_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that say where the answer goes."""
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FILE",
        help=f"where to write the surface, by its ending: {' '.join(SURFACE_ENDINGS)}",
    )
    parser.add_argument("--report", type=Path, metavar="FILE.json", help="where to write the report")
    add_picture_options(parser)
    parser.add_argument(
        "--keep", action="store_true", help="write the best attempt even if it is not an answer"
    )
    parser.add_argument("--quiet", action="store_true", help="print nothing but errors")


def asked_for(options: argparse.Namespace) -> dict[str, Path]:
    """The files that are asked for, by the names of their options."""
    return {name: path for name in OUTPUTS if (path := getattr(options, name))}


def check_outputs(options: argparse.Namespace, **beside: Path | None) -> None:
    """Find out what cannot be written before anything is computed.

    Parameters
    ----------
    options : argparse.Namespace
    **beside : path or None
        Files that the command writes besides, by the names of their options.

    Raises
    ------
    FileError, Refusal
        Naming the file.
    """
    if options.output:
        check_output(options.output, SURFACE_ENDINGS)
    if options.report:
        check_output(options.report, REPORT_ENDINGS)
    check_pictures(options)
    asked = asked_for(options)
    if options.keep and not asked.keys() - {"report"}:
        raise UsageError("--keep needs an --output to write the best attempt to")
    everything = asked | {name: path for name, path in beside.items() if path}
    for (name, path), (other, same) in combinations(everything.items(), 2):
        if path.resolve() == same.resolve():
            raise UsageError(f"--{name} and --{other} are the same file {path}")


def answer(
    options: argparse.Namespace,
    solve: Callable[[Listener | None], isoembed.Embedding],
    *,
    describe: Callable[[isoembed.Embedding], str] = summary,
    beside: Mapping[Path, Writer] | None = None,
) -> int:
    """Solve under a live view, and write and say what is asked for.

    Parameters
    ----------
    options : argparse.Namespace
        With the options of `add_output_options`.
    solve : callable
        Takes the listener and embeds.
    describe : callable
        Says in a few lines what was found.
    beside : mapping of path to Writer, optional
        What is written whatever the answer.

    Returns
    -------
    int
        The exit status.
    """
    show = not options.quiet and sys.stderr is not None and sys.stderr.isatty()
    film = film_for(options)
    try:
        with live_view(show) as view:
            embedding = solve(_heard_by(view, film))
        failure = None
    except NotEmbedded as error:
        embedding, failure = error.embedding, str(error)

    shown = failure is None or options.keep
    writers = dict(beside or {})
    if options.output and shown:
        writers[options.output] = surface_writer(options.output, embedding)
    if options.report:
        writers[options.report] = report_writer(_report(embedding, failure))
    write_atomically(writers)
    if shown:  # when nothing can be lost any more
        write_atomically(picture_writers(options, embedding, film))
    if failure is not None:
        print_error(failure)
    if not options.quiet:
        if not options.output:
            print_out(describe(embedding))
        elif failure is None and not embedding.converged:
            print_out(f"{embedding.status}: {embedding.message}")
    return OK if failure is None else NOT_EMBEDDED


def _heard_by(*listeners: Listener | None) -> Listener | None:
    """One listener for those that there are."""
    there = [listener for listener in listeners if listener is not None]

    def tell(progress: Progress) -> None:
        for listener in there:
            listener(progress)

    return tell if there else None


def _report(embedding: isoembed.Embedding, failure: str | None) -> dict[str, Any]:
    return embedding.report if failure is None else {**embedding.report, "message": failure}
