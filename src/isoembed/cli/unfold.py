"""``isoembed unfold``: unfolding of a solid to a paper net."""

import argparse
import re
from pathlib import Path
from typing import get_args

import numpy as np

from isoembed.cli.console import OK, UsageError, print_aside, print_error
from isoembed.cli.material import add_material_options, given_fields, material_of, on_paper
from isoembed.cli.options import READABLE, add_merge_option, add_output_option
from isoembed.cli.outputs import check_answer, written
from isoembed.gluing import unfold
from isoembed.gluing.sheet_search import Objective
from isoembed.io import read_surface, write_atomically
from isoembed.io.files import ending
from isoembed.io.net import NET_ENDINGS, net_writer
from isoembed.papercraft import SHEET_ENDINGS, fewest_pages
from isoembed.papercraft.drawing import drawn
from isoembed.papercraft.paper import FORMATS, Paper
from isoembed.papercraft.saving import drawing_writer
from isoembed.reprs import counted
from isoembed.typed_numbers import millimeters, number

DRAWING = ("paper", "scale", "size", "numbers")
EXAMPLES = (
    "isoembed unfold surface.stl -o net.pdf --size 400 --paper A3 --numbers",
    "isoembed unfold surface.ply -o net.dxf --kerf 0.15 --bends perforate",
)


USUAL = (
    *("output", "paper", "scale", "solid_size", "numbers", "objective", "joints", "kerf"),
    *("thickness", "merge"),
)
"""Options listed by ``--help``."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options of ``isoembed unfold``."""
    parser.add_argument(
        "file",
        type=Path,
        metavar="FILE",
        help=f"a surface with vertices ({READABLE}), as 'isoembed embed' writes it",
    )
    add_output_option(
        parser,
        f"{' '.join(SHEET_ENDINGS)}: the net on pages, with tabs and a number on both sides of each "
        f"glued pair, and in .html with a film of its folding; {' '.join(NET_ENDINGS)}: the net for "
        "'isoembed glue'",
        required=True,
    )
    parser.add_argument(
        "--paper",
        metavar="NAME|WIDTHxHEIGHT|roll:WIDTH",
        help=f"{', '.join(FORMATS)}, a size in mm or such as 8.5x11in, or a roll, used as long as needed "
        "(default A4)",
    )
    parser.add_argument(
        "--scale",
        type=_scale,
        metavar="MM",
        help="millimeters per unit of the solid, such as 0.25 or 1:4 (default: the largest scale at which "
        "each sheet fits on a page); larger sheets are cut into several",
    )
    parser.add_argument(
        "--size",
        dest="solid_size",
        type=_size,
        metavar="MM|z=MM",
        help="instead of --scale: the largest extent of the solid in x, y or z, in millimeters; z=200 or "
        "z=20cm sets the extent in z",
    )
    parser.add_argument(
        "--numbers",
        action="store_true",
        default=None,
        help="number the faces, also on a picture of the solid",
    )
    parser.add_argument(
        "--objective",
        choices=(*get_args(Objective), "pages"),
        help="few sheets (default), short cuts, strips without branches, every face by itself, or few pages",
    )
    for name, purpose in (("cut", "edges to cut"), ("keep", "edges not to cut")):
        parser.add_argument(
            f"--{name}",
            dest=f"{name}_edges",
            type=_edge,
            nargs="+",
            default=[],
            metavar="A-B",
            help=f"{purpose}, given by their vertex numbers in the file, from 0",
        )
    add_material_options(parser)
    add_merge_option(parser)


def run(options: argparse.Namespace) -> int:
    """Unfold the surface; return the exit status."""
    output = options.output
    check_answer(output, (*SHEET_ENDINGS, *NET_ENDINGS), options.file)
    values = {name: getattr(options, "solid_size" if name == "size" else name) for name in DRAWING}
    drawing = {name: value for name, value in values.items() if value is not None}
    drawing_options = [
        *drawing,
        *given_fields(options),
        *(["objective pages"] if options.objective == "pages" else []),
    ]
    if drawing_options and ending(output) in NET_ENDINGS:
        raise UsageError(
            f"--{drawing_options[0].replace('_', '-')} is for nets on pages ({' '.join(SHEET_ENDINGS)})"
        )
    if (material := material_of(options)) is not None:
        drawing["material"] = material
    surface = read_surface(options.file, merge=options.merge)
    extents = np.ptp(surface.vertices, axis=0)
    chosen = {"cut": options.cut_edges, "keep": options.keep_edges}
    if options.objective == "pages":
        sized = {name: value for name, value in drawing.items() if name in ("paper", "scale", "size")}
        unfolding = fewest_pages(surface, **sized, **chosen)
    else:
        unfolding = unfold(surface, **chosen, objective=options.objective or "sheets")
    folds = sum(map(len, unfolding.folds))
    if folds > 300 and not options.quiet:  # takes hours to fold
        print_error(
            f"{folds:,} folds: simplify the mesh first, to the number of faces that you want to fold", "note"
        )
    boundaries = surface.triangulation.boundaries
    rims = f"{len(boundaries)} boundar{'y' if len(boundaries) == 1 else 'ies'}"
    is_open = f"; open: {rims} of {sum(map(len, boundaries))} edges" if boundaries else ""
    if ending(output) in NET_ENDINGS:
        writer = net_writer(output, unfolding)
        text = f"{unfolding}{is_open}"
    else:
        pages = drawn(unfolding, **drawing)
        writer = drawing_writer(output, unfolding, pages)
        text = str(pages.net)
        if len(pages.net.sheets) > len(unfolding.sheets):
            uncut, _, _ = str(unfolding).partition(",")
            text = (
                f"{uncut} cut into {len(pages.net.sheets)} islands that fit on pages,{text.partition(',')[2]}"
            )
        sizes = " x ".join(f"{float(f'{size:.3g}'):g}" for size in pages.scale * extents)
        text += f"{is_open}; solid {sizes} mm, {pages.scale:.4g} mm a unit"
        if pages.scale * extents.max() < 5.0 and not options.quiet:  # mm, too small to fold
            print_error(f"the solid is {sizes} mm large: is the scale right?", "note")
        paper, net_pages = Paper.of(options.paper or "A4"), pages.pages - bool(options.numbers)
        if paper.is_roll:
            text += f"; {pages.height:.0f} mm of a roll of {paper.width:g} mm"
        else:
            text += f"; {counted(net_pages, 'page')} of {paper.name}"
        if options.numbers:
            text += " and a drawing of the solid"
    write_atomically({output: writer})
    print_aside(f"{text}\n{written(options, output)}")
    return OK


def _edge(text: str) -> tuple[int, int]:
    found = re.fullmatch(r"(\d+)-(\d+)", text)
    if found is None:
        raise argparse.ArgumentTypeError(f"{text!r} is not a pair of vertex numbers such as 3-17")
    return int(found[1]), int(found[2])


def _size(text: str) -> float | tuple[str, float]:
    axis, _, length = text.rpartition("=")
    if axis not in ("", "x", "y", "z"):
        raise argparse.ArgumentTypeError(f"{text!r} is not an extent in x, y or z such as z=200")
    return (axis, on_paper(length)) if axis else on_paper(length)


def _scale(text: str) -> float:
    found = re.fullmatch(r"([\d.,]+)\s*[:/]\s*([\d.,]+)", text)
    try:
        return number(found[1]) / number(found[2]) if found else millimeters(text)
    except (ValueError, ZeroDivisionError):
        raise argparse.ArgumentTypeError(f"{text!r} is not a scale such as 0.25 or 1:4") from None
