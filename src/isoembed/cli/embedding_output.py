"""Output of commands that embed: surface files, report, closing lines, exit status."""

import argparse
import shlex
import sys
from collections.abc import Callable, Collection, Mapping
from contextlib import nullcontext
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any

import isoembed
from isoembed.cli.console import (
    NOT_EMBEDDED,
    OK,
    UsageError,
    is_terminal,
    print_aside,
    print_error,
    print_json,
    print_out,
)
from isoembed.cli.options import add_json_option, add_output_option
from isoembed.cli.outputs import Outputs, print_written, written
from isoembed.cli.pictures import PICTURES, add_picture_options, check_pictures, film, picture_writers
from isoembed.cli.summary import INTEGRALS, bending, measure, summary
from isoembed.cli.waiting import suspended
from isoembed.errors import NotEmbedded
from isoembed.io import REPORT_ENDINGS, SURFACE_ENDINGS, report_writer, surface_writer
from isoembed.io.files import Writer, ending
from isoembed.progress import bar
from isoembed.progress.stages import Listener, Progress
from isoembed.sheets.surface import SheetEmbedding

CERTIFIED = 10_000  # vertices: above, a certificate takes as long as the embedding


def add_output_options(parser: argparse.ArgumentParser) -> None:
    """Add the output options."""
    add_output_option(parser, f"surface file, in the format of its extension: {' '.join(SURFACE_ENDINGS)}")
    parser.add_argument("--report", type=Path, metavar="FILE.json", help="report file")
    add_picture_options(parser)
    parser.add_argument("--keep", action="store_true", help="write the best attempt even if it fails")
    add_json_option(parser, "print the report, as one JSON object, instead of text")
    parser.add_argument("--verbose", action="store_true", help="also print measures and stages")


def requested_outputs(options: argparse.Namespace, **beside: Collection[str]) -> Outputs:
    """Output files of `add_output_options`, checked before the computation.

    Parameters
    ----------
    options : argparse.Namespace
    **beside : collection of str
        Endings of additional output files, by option name.

    Raises
    ------
    FileError, UsageError
        A file cannot be written; the message names it.
    """
    for name, endings in PICTURES.items():
        if options.output and ending(options.output) in endings:
            net = ", and paper nets are written by 'isoembed unfold'" * (
                ending(options.output) in (".svg", ".pdf")
            )
            path = shlex.quote(str(options.output))
            raise UsageError(f"--output is for surfaces{net}: did you mean --{name} {path}?")
    outputs = Outputs.of(options, output=SURFACE_ENDINGS, report=REPORT_ENDINGS, **PICTURES, **beside)
    check_pictures(options)
    if options.keep and not outputs.keys() - {"report", *beside}:
        raise UsageError("--keep needs an --output for the best attempt")
    outputs.keep_apart()
    return outputs


def answer(
    options: argparse.Namespace,
    outputs: Outputs,
    solve: Callable[[Listener | None], isoembed.Embedding],
    *,
    describe: Callable[..., str] = summary,
    reported: Mapping[str, Any] = MappingProxyType({}),
    **beside: Callable[[Path], Writer],
) -> int:
    """Embed with a live view, write the requested files and print a summary.

    Parameters
    ----------
    options : argparse.Namespace
    outputs : Outputs
        Output files, from `requested_outputs`.
    solve : callable
        Takes a listener and embeds.
    describe : callable
        Describes the result: takes the surface, its report, whether to list its ``stages``, and whether it
        ``failed``.
    reported : mapping
        Report entries besides those of the surface.
    **beside : callable
        Writers of files that are written in any case, by option name.

    Returns
    -------
    int
        Exit status.
    """
    recorder = film(options)
    embedding, failure = solved(options, solve, recorder)
    if failure is None or options.keep:
        beside["output"] = lambda path: surface_writer(path, embedding)
        beside |= picture_writers(options, embedding, recorder)

    @cache
    def whole() -> Mapping[str, Any]:  # expensive: only on request
        from isoembed.embedding.report import report

        return {**report(embedding), **(failure.report if failure is not None else {}), **reported}

    try:
        outputs.write(report=lambda _: report_writer(whole()), **beside)
    finally:
        if failure is not None:
            print_error(str(failure))
        if options.json:
            print_json(whole())
        elif not options.quiet:  # a summary and a certificate are expensive
            say = print_out if failure is None and not outputs else print_aside
            if options.verbose or not options.output:
                say(describe(embedding, whole(), stages=options.verbose, failed=failure is not None))
            _end(options, embedding, outputs, whole, failed=failure is not None)
    return OK if failure is None else NOT_EMBEDDED


def _end(
    options: argparse.Namespace,
    embedding: isoembed.Embedding,
    outputs: Outputs,
    report: Callable[[], Mapping[str, Any]],
    *,
    failed: bool,
) -> None:
    """Print the result and the written files, usually in four lines."""
    if failed and not options.keep:
        outputs = Outputs((name, path) for name, path in outputs.items() if name in ("report", "metric"))
    files = tuple(outputs.values())
    if failed:
        keep = "; --keep writes the best attempt" if options.output and not options.keep else ""
        print_aside(f"{embedding.status}: {written(options, *files)}{keep}")
        return
    if options.output:
        found = f"{embedding.status}: {embedding.message}"
        integrals = ""
        if embedding.length_errors is not None:
            stated = {name: shown for name, shown in INTEGRALS.items() if report()[name] is not None}
            integrals = ", ".join(f"{shown} {measure(report(), name)}" for name, shown in stated.items())
        energy = bending(embedding._reported["sheet"]) if isinstance(embedding, SheetEmbedding) else ""
        proof = _proof(embedding, report if options.report else None)
        lines = found, energy, proof, integrals
        print_aside("\n".join(line for line in lines if line))
    print_written(options, *files)


def _proof(embedding: isoembed.Embedding, report: Callable[[], Mapping[str, Any]] | None) -> str:
    """Certificate of a surface with exact lengths: from the report, or computed if inexpensive."""
    if not embedding.converged or embedding.metric.length_errors is not None:
        return ""
    if report is not None:
        return str(report()["certificate"]["reason"])
    if embedding.triangulation.n_vertices > CERTIFIED:
        return f"certificate not computed for more than {CERTIFIED:,} vertices: use 'isoembed certify'"
    from isoembed.embedding.certify import certify

    return certify(embedding).reason


def solved(
    options: argparse.Namespace,
    solve: Callable[[Listener | None], isoembed.Embedding],
    seen: Listener | None = None,
) -> tuple[isoembed.Embedding, NotEmbedded | None]:
    """Embed with a live view; return the surface, or the best attempt and the failure."""
    try:
        watched = not options.quiet and is_terminal(sys.stderr)
        with suspended(options), bar() if watched else nullcontext() as view:
            return solve(listener_of(view, seen)), None
    except NotEmbedded as error:
        return error.embedding, error


def listener_of(*listeners: Listener | None) -> Listener | None:
    """Combined listener; None if there is none."""
    there = [listener for listener in listeners if listener is not None]

    def tell(progress: Progress) -> None:
        for listener in there:
            listener(progress)

    return tell if there else None
