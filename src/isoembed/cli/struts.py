"""``isoembed struts``: the strut table of a dome or a frame."""

import argparse
import math
import re
from pathlib import Path

from isoembed.cli.console import OK, print_aside, print_error, print_json, print_out
from isoembed.cli.options import (
    READABLE,
    add_json_option,
    add_merge_option,
    add_output_option,
    converted,
)
from isoembed.cli.outputs import Outputs, print_written, written
from isoembed.io import read_surface
from isoembed.plot.endings import PICTURE_ENDINGS
from isoembed.struts import STRUT_ENDINGS, strut_table
from isoembed.struts.saving import struts_writer
from isoembed.typed_numbers import UNIT, number

EXAMPLES = (
    "isoembed struts dome.obj -o struts.csv --picture struts.png",
    "isoembed struts dome.obj --hub-radius 20 --stock 6000",
)


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options of ``isoembed struts``."""
    parser.add_argument(
        "file",
        type=Path,
        metavar="FILE",
        help=f"a surface with vertices ({READABLE}), closed or with a boundary",
    )
    parser.add_argument(
        "--tolerance",
        type=_length,
        metavar="LENGTH",
        help="largest length difference within a type, in the unit of the file (default: a millionth of "
        "the mean length, or the rounding error of the coordinates)",
    )
    parser.add_argument(
        "--hub-radius",
        type=_length,
        default=0.0,
        metavar="LENGTH",
        help="radius of the hubs, by which struts are shortened at each end",
    )
    parser.add_argument(
        "--stock",
        type=_length,
        metavar="LENGTH",
        help="length of the stock bars; adds a cut list",
    )
    add_merge_option(parser)
    add_output_option(
        parser,
        f"file for the table: {' '.join(STRUT_ENDINGS)} (default: print the types); 'isoembed embed' "
        "reads a .csv",
    )
    parser.add_argument(
        "--picture",
        type=Path,
        metavar="FILE",
        help=f"a picture with struts colored by type: {' '.join(PICTURE_ENDINGS)}",
    )
    add_json_option(parser, "print the table as one JSON object instead of text")


def run(options: argparse.Namespace) -> int:
    """Tabulate the struts; return the exit status."""
    outputs = Outputs.of(options, output=STRUT_ENDINGS, picture=PICTURE_ENDINGS)
    outputs.keep_apart(options.file)
    if options.picture:
        from isoembed.plot.picture import check_drawable

        check_drawable()
    surface = read_surface(options.file, merge=options.merge)
    table = strut_table(
        surface, tolerance=options.tolerance, hub_radius=options.hub_radius, stock=options.stock
    )
    # Types for most struts, and too many to build: a larger tolerance is recommended.
    if len(table.struts) > 20 and 2 * len(table.struts) > len(table.edges) and not options.quiet:
        print_error(
            f"{len(table.struts)} types of {len(table.edges)} struts: --tolerance LENGTH groups "
            "lengths that differ by at most LENGTH",
            "note",
        )
    writers = {"output": lambda path: struts_writer(path, table)}
    if options.picture:
        from isoembed.plot.struts import struts_picture_writer

        writers["picture"] = lambda path: struts_picture_writer(path, surface, table)
    files = outputs.write(**writers)
    if options.json:
        print_json(table.report)
    elif options.output:
        print_aside(f"{table.summary}\n{written(options, *files)}")
    else:
        print_out(str(table))
        print_written(options, *files)
    return OK


def _length(text: str) -> float:
    unit = ": lengths are in the unit of the file" if re.fullmatch(rf"[\d.,]+\s*{UNIT}", text) else ""
    value = converted(text, number, f"a number{unit}")
    if not 0 <= value < math.inf:
        raise argparse.ArgumentTypeError(f"{text} is not a non-negative length")
    return value
