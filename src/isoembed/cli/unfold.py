"""``isoembed unfold``: unfolding of a solid to a paper net."""

import argparse
from pathlib import Path

from isoembed.cli.material import FIELDS, add_material_options, material_of
from isoembed.cli.options import add_merge_option, add_output_option, add_quiet_option
from isoembed.cli.outputs import check_answer, written
from isoembed.cli.screen import UsageError, print_aside, print_error
from isoembed.cli.status import OK
from isoembed.gluing import unfold
from isoembed.io import MESH_ENDINGS, METRIC_ENDINGS, read_surface, write_atomically
from isoembed.io.files import ending
from isoembed.io.net import NET_ENDINGS, net_writer
from isoembed.papercraft.placing import PAPERS
from isoembed.papercraft.sheets import SHEET_ENDINGS, sheets_writer

MANY_FOLDS = 300  # some hours of folding
EXAMPLES = (
    "isoembed unfold surface.ply -o net.svg",
    "isoembed unfold surface.ply -o net.pdf --paper letter",
    "isoembed unfold surface.ply -o net.dxf --kerf 0.15 --bends perforate",
)


USUAL = ("file", "output", "paper", "scale", "joints", "allowance", "kerf", "bends", "merge", "quiet")
"""The options that ``--help`` lists."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options of ``isoembed unfold``."""
    parser.add_argument(
        "file",
        type=Path,
        metavar="FILE",
        help=f"a surface with vertices ({' '.join((*METRIC_ENDINGS, *MESH_ENDINGS))}), as 'isoembed embed' "
        "writes it",
    )
    add_output_option(
        parser,
        f"{' '.join(SHEET_ENDINGS)}: the net on pages, with tabs and with a number on both sides that are "
        f"glued; {' '.join(NET_ENDINGS)}: the net for 'isoembed glue'",
        required=True,
    )
    parser.add_argument("--paper", choices=PAPERS, help=f"{', '.join(PAPERS)} (default A4)")
    parser.add_argument(
        "--scale",
        type=float,
        metavar="MM",
        help="millimeters a unit of the solid (default: the largest with which each sheet fits on a page)",
    )
    add_material_options(parser)
    add_merge_option(parser)
    add_quiet_option(parser)


def run(options: argparse.Namespace) -> int:
    """Unfold the surface; return the exit status."""
    output = options.output
    check_answer(output, (*SHEET_ENDINGS, *NET_ENDINGS), options.file)
    drawing = {name: value for name in ("paper", "scale") if (value := getattr(options, name)) is not None}
    told = [name for name in ("paper", "scale", *FIELDS) if getattr(options, name) is not None]
    if told and ending(output) in NET_ENDINGS:
        raise UsageError(f"--{told[0]} is for nets on pages ({' '.join(SHEET_ENDINGS)})")
    if (material := material_of(options)) is not None:
        drawing["material"] = material
    unfolding = unfold(read_surface(options.file, merge=options.merge))
    folds = sum(map(len, unfolding.folds))
    if folds > MANY_FOLDS and not options.quiet:
        print_error(
            f"{folds:,} folds: simplify the mesh first, to as many faces as you are ready to fold", "note"
        )
    if ending(output) in NET_ENDINGS:
        writer = net_writer(output, unfolding)
    else:
        writer = sheets_writer(output, unfolding, **drawing)
    write_atomically({output: writer})
    print_aside(f"{unfolding}\n{written(options, output)}")
    return OK
