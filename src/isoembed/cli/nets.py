"""``isoembed nets``: classic nets and the solids that they fold to."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import cast

import isoembed
from isoembed.alexandrov.polyhedron import ConvexPolyhedron
from isoembed.cli.screen import print_error, print_out
from isoembed.cli.solid import Solid
from isoembed.cli.status import NOT_EMBEDDED, OK
from isoembed.errors import NotEmbedded
from isoembed.gluing.classics import CLASSICS
from isoembed.io import SURFACE_ENDINGS, check_output, surface_writer, write_atomically
from isoembed.io.files import Writer


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options of ``isoembed nets``."""
    parser.add_argument(
        "name",
        metavar="NAME",
        nargs="?",
        choices=CLASSICS,
        help=f"which to solve: {', '.join(CLASSICS)}; without it they are listed",
    )
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FILE",
        help="where to write the solids, by the ending "
        f"({' '.join(SURFACE_ENDINGS)}): -o solid.obj writes solid-1.obj, solid-2.obj, ...",
    )
    parser.add_argument("--quiet", action="store_true", help="print nothing but errors")


def run(options: argparse.Namespace) -> int:
    """List the nets or solve those of a name; return the exit status."""
    if options.name is None:
        width = max(map(len, CLASSICS))
        print_out("\n".join(f"{name:{width}}  {classic.purpose}" for name, classic in CLASSICS.items()))
        return OK
    nets = CLASSICS[options.name].make()
    paths = [
        options.output.with_name(f"{options.output.stem}-{k}{options.output.suffix}")
        for k in range(1, len(nets) + 1)
        if options.output
    ]
    for path in paths:
        check_output(path, SURFACE_ENDINGS)

    rows: list[tuple[str, ...]] = []
    kinds: list[Solid] = []
    failures: list[str] = []
    writers: dict[Path, Writer] = {}
    for k, (label, net) in enumerate(nets):
        try:
            polyhedron = cast(ConvexPolyhedron, isoembed.embed(net, method="alexandrov"))
        except NotEmbedded as error:
            failures.append(f"net {k + 1}, {label}: {error}")
            continue
        solid = Solid.of(polyhedron)
        kind = next((i for i, other in enumerate(kinds) if solid.is_congruent(other)), len(kinds))
        if kind == len(kinds):
            kinds.append(solid)
        counts = (str(count) for count in (solid.vertices, solid.edges, solid.faces))
        sizes = (f"{size:.9g}" for size in (polyhedron.area, polyhedron.volume))
        rows.append((str(k + 1), label, f"{kind + 1}: {solid.name}", *counts, *sizes))
        if options.output:
            writers[paths[k]] = surface_writer(paths[k], polyhedron)
    write_atomically(writers)
    if not options.quiet:
        print_out(_table(rows))
        print_out(f"\n{len(nets)} nets, {len(kinds)} solids")
    for failure in failures:
        print_error(failure)
    return NOT_EMBEDDED if failures else OK


def _table(rows: list[tuple[str, ...]]) -> str:
    """Columns under their headings: words to the left, numbers to the right."""
    table = [("", "net", "solid", "vertices", "edges", "faces", "area", "volume"), *rows]
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    return "\n".join(
        "  ".join(
            text.ljust(width) if 0 < k < 3 else text.rjust(width)
            for k, (text, width) in enumerate(zip(row, widths, strict=True))
        )
        for row in table
    )
