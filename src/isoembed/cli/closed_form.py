"""A surface of a closed-form spacetime from the options of ``isoembed energy``."""

from __future__ import annotations

import argparse

from isoembed.cli.refusal import UsageError
from isoembed.relativity.spacetimes.kerr import KerrNewmanErgosphere, KerrNewmanHorizon, KerrNewmanSphere
from isoembed.relativity.spacetimes.kerr_schild import KerrSchild
from isoembed.relativity.spacetimes.painleve_gullstrand import PainleveGullstrand
from isoembed.relativity.spacetimes.star_surface import StarSurface
from isoembed.relativity.spacetimes.surface_data import SurfaceData

SLICES = ("boyer-lindquist", "kerr-schild", "painleve-gullstrand")
SURFACES = "horizon, r=R and ergosphere=EPSILON"
OF_SPACETIME = ("mass", "spin", "charge", "surface", "slice")  # options that need a --spacetime
Z_AXIS = (0.0, 0.0, 1.0)


def add_spacetime_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that name a surface of a closed-form spacetime."""
    parser.add_argument("--spacetime", choices=("kerr", "schwarzschild"), help="a closed-form spacetime")
    parser.add_argument("--mass", type=float, metavar="M", help="its mass (default 1)")
    parser.add_argument("--spin", type=float, metavar="A", help="its spin a = J/M, a length (default 0)")
    parser.add_argument("--charge", type=float, metavar="Q", help="its charge, a length (default 0)")
    parser.add_argument(
        "--surface",
        metavar="SURFACE",
        help="horizon; r=R, of constant Boyer-Lindquist radius; ergosphere=EPSILON, r = r_ergo + EPSILON M",
    )
    parser.add_argument(
        "--slice",
        choices=SLICES,
        help=f"the slice of spacetime that the surface lies in, for k and p (default {SLICES[0]})",
    )


def refuse_given(options: argparse.Namespace, names: tuple[str, ...], why: str) -> None:
    """Refuse options that make no sense beside others.

    Raises
    ------
    Refusal
        Naming the first that is given.
    """
    for name in names:
        if getattr(options, name) is not None:
            given = f"the input {options.input}" if name == "input" else f"--{name.replace('_', '-')}"
            raise UsageError(f"{given} {why}")


def closed_form(options: argparse.Namespace) -> SurfaceData:
    """The surface that the options name.

    Raises
    ------
    Refusal, InvalidParameter
        There is none.
    """
    if options.surface is None:
        raise UsageError(f"which --surface? There are {SURFACES}")
    mass, spin, charge = (
        default if given is None else given
        for given, default in ((options.mass, 1.0), (options.spin, 0.0), (options.charge, 0.0))
    )
    if options.spacetime == "schwarzschild" and (spin or charge):
        raise UsageError("a Schwarzschild black hole has neither spin nor charge: take --spacetime kerr")
    kind, _, text = options.surface.partition("=")
    if kind not in ("horizon", "r", "ergosphere") or (kind == "horizon") != (options.surface == "horizon"):
        raise UsageError(f"--surface {options.surface}: there are {SURFACES}")
    try:
        number = 0.0 if kind == "horizon" else float(text)
    except ValueError:
        raise UsageError(f"--surface {options.surface}: {text!r} is not a number") from None
    if options.slice in (None, "boyer-lindquist"):
        if kind == "horizon":
            return KerrNewmanHorizon(mass, spin, charge).data()
        if kind == "r":
            return KerrNewmanSphere(number, mass, spin, charge).data()
        return KerrNewmanErgosphere(number, mass, spin, charge).data()
    if charge:
        raise UsageError(f"--charge needs the slice {SLICES[0]}")
    if kind == "ergosphere":
        raise UsageError(f"--surface ergosphere needs the slice {SLICES[0]}")
    geometry: KerrSchild | PainleveGullstrand
    if options.slice == "kerr-schild":
        geometry = KerrSchild(mass, (0.0, 0.0, spin))
        horizon = geometry.horizon  # refuses a spin beyond the mass
        surface = StarSurface.from_radius(geometry.spheroid(horizon if kind == "horizon" else number))
    elif spin:
        raise UsageError(f"the slice {options.slice} is that of a hole without spin, not {spin:g}")
    else:
        geometry = PainleveGullstrand(mass)
        surface = StarSurface.sphere((0.0, 0.0, 0.0), 2.0 * mass if kind == "horizon" else number)
    return surface.data(
        geometry,
        Z_AXIS,
        marginal=kind == "horizon",
        name=f"{options.surface} of mass {mass:.9g} and spin {spin:.9g} in the slice {options.slice}",
    )
