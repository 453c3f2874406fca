"""Options that select a slice of spacetime: closed forms and grid files."""

import argparse
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from isoembed.cli.console import UsageError
from isoembed.cli.options import converted, given
from isoembed.errors import InvalidParameter
from isoembed.io.files import input_ending
from isoembed.relativity.series.slice_files import read_slice
from isoembed.relativity.spacetimes.kerr_slices import BoyerLindquist, KerrSchild, horizon_radius
from isoembed.relativity.spacetimes.schwarzschild import (
    BoostedSchwarzschild,
    BrillLindquist,
    IsotropicSchwarzschild,
    PainleveGullstrand,
    Superposed,
)
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry
from isoembed.relativity.spacetimes.transformed import Translated
from isoembed.typed_numbers import number

OF_SLICE = ("mass", "spin", "center", "velocity", "masses", "positions", "velocities")
DEFAULTS = {"mass": 1.0, "spin": (0.0, 0.0, 0.0)}


@dataclass(frozen=True)
class ClosedForm:
    """A slice in closed form, and its options.

    Attributes
    ----------
    make : callable
        Takes the given options as keyword arguments.
    takes, needs : tuple of str
        Permitted and required options.
    """

    make: Callable[..., ThreeGeometry]
    takes: tuple[str, ...] = ()
    needs: tuple[str, ...] = ()


def _kerr_schild(mass: float, spin: Sequence[float]) -> ThreeGeometry:
    geometry = KerrSchild(mass, spin)
    horizon_radius(mass, spin)  # rejects a spin beyond the mass
    return geometry


def _superposed(masses: Sequence[float], positions: list[Any], velocities: list[Any]) -> ThreeGeometry:
    if not len(masses) == len(positions) == len(velocities):
        raise UsageError(
            f"{len(masses)} masses at {len(positions)} positions with {len(velocities)} velocities: there "
            "must be one of each for every hole"
        )
    holes = []
    for k, hole in enumerate(zip(masses, velocities, positions, strict=True)):
        try:
            holes.append(BoostedSchwarzschild(*hole))
        except InvalidParameter as error:
            raise InvalidParameter(f"hole {k}: {error}") from None
    return Superposed(holes)


CLOSED_FORMS = {
    "brill-lindquist": ClosedForm(BrillLindquist, needs=("masses", "positions")),
    "kerr-schild": ClosedForm(_kerr_schild, takes=("mass", "spin", "center")),
    "boyer-lindquist": ClosedForm(BoyerLindquist, takes=("mass", "spin", "center")),
    "isotropic": ClosedForm(IsotropicSchwarzschild, takes=("mass", "center")),
    "painleve-gullstrand": ClosedForm(PainleveGullstrand, takes=("mass", "center")),
    "boosted": ClosedForm(BoostedSchwarzschild, takes=("mass", "center"), needs=("velocity",)),
    "superposed": ClosedForm(_superposed, needs=("masses", "positions", "velocities")),
}


def add_slice_options(parser: argparse.ArgumentParser, purpose: str, *, mass_and_spin: bool = True) -> None:
    """Add the option for a slice, and those of closed forms.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    purpose : str
        Purpose of the slice.
    mass_and_spin : bool
        Whether to add mass and spin, too, which spacetimes have in common with slices.
    """
    parser.add_argument(
        "--geometry",
        metavar="GEOMETRY",
        help=f"{purpose}: a file (.h5 .hdf5 .npz) with gxx ... gzz, and kxx ... kzz, on a Cartesian grid; "
        f"a file of GRChombo or AthenaK, or a plot file of AMReX; or one of {', '.join(CLOSED_FORMS)}",
    )
    if mass_and_spin:
        parser.add_argument(
            "--mass", type=float, metavar="M", help="mass of the closed-form geometry (default 1)"
        )
        parser.add_argument(
            "--spin",
            type=_number,
            nargs="+",
            metavar="A",
            help="a = J/M of kerr-schild or boyer-lindquist, a length: one number, along z, or a vector "
            "AX AY AZ (default 0)",
        )
    coordinates = ("X", "Y", "Z")
    parser.add_argument(
        "--center", type=float, nargs=3, metavar=coordinates, help="center of the single hole (default 0 0 0)"
    )
    parser.add_argument(
        "--velocity",
        type=float,
        nargs=3,
        metavar=("VX", "VY", "VZ"),
        help="velocity of a boosted hole, in units of the speed of light",
    )
    parser.add_argument(
        "--masses",
        type=_number,
        nargs="+",
        metavar="M",
        help="masses of brill-lindquist or superposed holes, one per hole",
    )
    parser.add_argument(
        "--positions",
        type=_number,
        nargs="+",
        metavar="X Y Z",
        help="positions of these holes, three numbers each",
    )
    parser.add_argument(
        "--velocities",
        type=_number,
        nargs="+",
        metavar="VX VY VZ",
        help="velocities of superposed holes, three numbers each",
    )


def slice_named(name: str, options: argparse.Namespace) -> ThreeGeometry:
    """Slice by name, a closed form or a file, with parameters from the options.

    Raises
    ------
    UsageError, InvalidParameter, FileError
        The slice does not exist, or an option is incompatible with it.
    """
    form, values = CLOSED_FORMS.get(name), _values_of(options)
    if form is None:
        if not input_ending(name) and not Path(name).exists():
            raise UsageError(f"the geometry {name}: there are {', '.join(CLOSED_FORMS)}, or a file")
        for option in values:
            raise UsageError(f"--{option} does not go with the geometry {name}, a file")
        return read_slice(name)
    names = (*form.needs, *form.takes)
    for option in values:
        if option not in names:
            raise UsageError(f"--{option} does not go with the geometry {name}, which takes {_listed(names)}")
    for option in form.needs:
        if option not in values:
            raise UsageError(f"the geometry {name} needs --{option}")
    center = values.pop("center", None)
    geometry = form.make(**{key: DEFAULTS[key] for key in form.takes if key in DEFAULTS} | values)
    return geometry if center is None else Translated(geometry, center)


def slice_label(name: str, options: argparse.Namespace) -> str:
    """Description of a slice for reports: its name and the given options."""
    values = given(options, OF_SLICE)
    words = (f"{option} {' '.join(f'{x:.9g}' for x in np.ravel(value))}" for option, value in values.items())
    return ", ".join([name, *words])


def slice_stem(name: str) -> str:
    """Part of a file name that denotes the slice."""
    return Path(name).name.removesuffix(".gz").removesuffix(input_ending(name))


def _values_of(options: argparse.Namespace) -> dict[str, Any]:
    """Parameters of a slice by option name; several vectors as a list."""
    values = given(options, OF_SLICE)
    for name in values.keys() & {"positions", "velocities"}:
        values[name] = _triples(name, values[name])
    if (spin := values.get("spin")) is not None:
        if len(spin) not in (1, 3):
            raise UsageError(f"--spin takes one number, along z, or three, not {len(spin)}")
        values["spin"] = [0.0, 0.0, *spin][-3:]
    return values


def _triples(name: str, flat: list[float]) -> list[list[float]]:
    if len(flat) % 3:
        raise UsageError(f"--{name} takes three numbers for each hole, not {len(flat)} in all")
    return [flat[k : k + 3] for k in range(0, len(flat), 3)]


def _number(text: str) -> float:
    return converted(text, number, "a number (files come before the options)")


def _listed(options: Sequence[str]) -> str:
    *others, last = (f"--{option}" for option in options)
    return f"{', '.join(others)} and {last}" if others else last
