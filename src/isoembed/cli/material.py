"""Options of the material of a net."""

import argparse
from dataclasses import fields
from typing import Any, get_args

from isoembed.cli.options import converted
from isoembed.papercraft.material import Bends, Joints, Material, Surface
from isoembed.typed_numbers import millimeters

FIELDS = tuple(field.name for field in fields(Material))
DESTINATIONS = {"surface": "sheet_surface"}  # `surface` is the destination of other options


def add_material_options(parser: argparse.ArgumentParser) -> None:
    """Add an option for each field of `Material`."""
    parser.add_argument(
        "--joints",
        choices=get_args(Joints),
        help="joints of the sides: tabs to glue (default), holes for stitches, or none",
    )
    parser.add_argument(
        "--bends", choices=get_args(Bends), help="folds as whole lines (default) or dashes to cut"
    )
    parser.add_argument(
        "--surface",
        dest="sheet_surface",
        choices=get_args(Surface),
        help="with --thickness: surface of the sheet that coincides with the faces of the solid (default "
        "outside)",
    )
    parser.add_argument(
        "--k-factor",
        type=float,
        metavar="K",
        help="with --thickness: position of the neutral axis of a bend, from 0 (inside) to 1 (default 0.5)",
    )
    for name, text in (
        (
            "thickness",
            "thickness of board, foam or metal: adds clearance between faces and bend allowance at folds",
        ),
        ("radius", "with --thickness: inside radius of a bend (default 0)"),
        ("allowance", "seam allowance, the distance of the cut outside the net, without tabs"),
        ("kerf", "width of the beam or blade; outlines are offset outward by half of it"),
        ("spacing", "spacing of the holes for stitches (default 4)"),
        ("hole", "diameter of the holes for stitches (default 1)"),
        ("dash", "length of the cuts of a perforated fold (default 3)"),
        ("gap", "minimum distance between the cuts of a perforated fold (default 1)"),
    ):
        parser.add_argument(f"--{name}", type=on_paper, metavar="MM", help=text)


def on_paper(text: str) -> float:
    """Argument type of lengths on paper: millimeters, or a number with another unit.

    Raises
    ------
    ArgumentTypeError
        The text is not a length.
    """
    return converted(text, millimeters, "a length such as 15, 15mm, 1.5cm or 0.6in")


def material_of(options: argparse.Namespace) -> Material | None:
    """Material given by the options; None if they are not given."""
    given = given_fields(options)
    return Material(**given) if given else None


def given_fields(options: argparse.Namespace) -> dict[str, Any]:
    """Fields given by the options, by name."""
    values = {name: getattr(options, DESTINATIONS.get(name, name)) for name in FIELDS}
    return {name: value for name, value in values.items() if value is not None}
