"""Options that select a closed-form surface of a spacetime."""

import argparse
from typing import get_args

from isoembed.cli.console import UsageError
from isoembed.cli.options import given
from isoembed.errors import InvalidParameter
from isoembed.relativity.spacetimes.kerr_surface import SURFACES, Slice, kerr_surface
from isoembed.relativity.spacetimes.surface_data import SurfaceData

OF_SPACETIME = (
    "mass",
    "spin",
    "charge",
    "cosmological_constant",
    "surface",
    "slice",
)  # options that require --spacetime


def add_spacetime_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that select a surface of a closed-form spacetime."""
    parser.add_argument(
        "--spacetime",
        type=_spacetime,
        choices=("kerr", "schwarzschild"),
        help="a closed-form spacetime, charged with --charge",
    )
    parser.add_argument("--mass", type=float, metavar="M", help="mass (default 1)")
    parser.add_argument(
        "--spin", type=float, nargs="+", metavar="A", help="spin a = J/M, a length (default 0)"
    )
    parser.add_argument("--charge", type=float, metavar="Q", help="charge, a length (default 0)")
    parser.add_argument(
        "--cosmological-constant",
        type=float,
        metavar="LAMBDA",
        help="cosmological constant of the spacetime, in 1/length^2; negative for anti-de Sitter (default 0)",
    )
    parser.add_argument(
        "--surface",
        metavar="SURFACE",
        help="horizon; r=R, of constant Boyer-Lindquist radius; ergosphere=EPSILON, r = r_ergo + EPSILON M",
    )
    slices = get_args(Slice)
    parser.add_argument(
        "--slice",
        choices=slices,
        help=f"slice of spacetime that contains the surface, for k and p (default {slices[0]})",
    )


def _spacetime(name: str) -> str:
    if name.lower() in ("kerr-newman", "reissner-nordstrom"):
        raise argparse.ArgumentTypeError(f"{name} is kerr with a --charge")
    return name


def closed_form(options: argparse.Namespace) -> SurfaceData:
    """Surface selected by the options.

    Raises
    ------
    UsageError, InvalidParameter
        No such surface exists.
    """
    if options.surface is None:
        raise UsageError(f"which --surface? There are {SURFACES}")
    values = given(options, OF_SPACETIME)
    if "spin" in values:
        if len(values["spin"]) > 1:
            raise UsageError("--spin takes one number with a --spacetime, whose holes spin about z")
        (values["spin"],) = values["spin"]
    if options.spacetime == "schwarzschild" and (values.get("spin") or options.charge):
        raise UsageError("a Schwarzschild black hole has neither spin nor charge: take --spacetime kerr")
    try:
        return kerr_surface(**values)
    except InvalidParameter as error:  # a parameter's name at the beginning is that of an option
        first, _, rest = str(error).partition(" ")
        if first in OF_SPACETIME:
            raise UsageError(f"--{first.replace('_', '-')} {rest}") from None
        raise
