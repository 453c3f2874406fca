"""Options of the material of a net."""

import argparse
from dataclasses import fields
from typing import get_args

from isoembed.papercraft.material import Bends, Joints, Material

FIELDS = tuple(field.name for field in fields(Material))
"""The options by their names in Python."""


def add_material_options(parser: argparse.ArgumentParser) -> None:
    """Add an option for each field of `Material`."""
    parser.add_argument(
        "--joints",
        choices=get_args(Joints),
        help="how sides are joined: tabs to glue (default), holes for stitches, none",
    )
    parser.add_argument(
        "--bends", choices=get_args(Bends), help="folds as whole lines (default) or dashes to cut"
    )
    for name, said in (
        ("allowance", "seam allowance: how far outside of the net the cut runs, without tabs"),
        ("kerf", "width of the beam or blade: outlines are offset outward by half of it"),
        ("spacing", "of the holes for stitches (default 4)"),
        ("hole", "diameter of the holes for stitches (default 1)"),
        ("dash", "what is cut of a fold in dashes (default 3)"),
        ("gap", "what is left between two dashes, at least (default 1)"),
    ):
        parser.add_argument(f"--{name}", type=float, metavar="MM", help=said)


def material_of(options: argparse.Namespace) -> Material | None:
    """The material that the options say; None if they say nothing."""
    given = {name: value for name in FIELDS if (value := getattr(options, name)) is not None}
    return Material(**given) if given else None
