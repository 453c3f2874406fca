"""Surfaces of Kerr-Newman and Kerr-(anti-)de Sitter spacetimes by name, in one of three slices."""

from typing import Literal

from isoembed.errors import InvalidParameter
from isoembed.relativity.spacetimes.kerr import KerrNewmanErgosphere, KerrNewmanHorizon, KerrNewmanSphere
from isoembed.relativity.spacetimes.kerr_de_sitter import KerrDeSitterSphere
from isoembed.relativity.spacetimes.kerr_slices import KerrSchild
from isoembed.relativity.spacetimes.schwarzschild import PainleveGullstrand
from isoembed.relativity.spacetimes.star_surface import StarSurface
from isoembed.relativity.spacetimes.surface_data import SurfaceData

Slice = Literal["boyer-lindquist", "kerr-schild", "painleve-gullstrand"]

SURFACES = "horizon, r=R and ergosphere=EPSILON"


def kerr_surface(
    surface: str,
    *,
    mass: float = 1.0,
    spin: float = 0.0,
    charge: float = 0.0,
    cosmological_constant: float = 0.0,
    slice: Slice = "boyer-lindquist",
) -> SurfaceData:
    """Surface of a Kerr-Newman black hole in a slice of its spacetime.

    Parameters
    ----------
    surface : str
        ``"horizon"``; ``"r=3"``, a constant Boyer-Lindquist radius; or ``"ergosphere=0.5"``, the surface
        r = r_ergo + epsilon M of the paper.
    mass, spin, charge : float
        Lengths; the spin is a = J/M.
    cosmological_constant : float
        Cosmological constant in 1/length^2, negative for Kerr-anti-de Sitter.  Available only for r=R and the
        horizon, in the slice boyer-lindquist and without charge.
    slice : {"boyer-lindquist", "kerr-schild", "painleve-gullstrand"}
        Slice for k and p.  Charge and ergosphere require the first, and the last requires zero spin.

    Raises
    ------
    InvalidParameter
        There is no such surface.

    Examples
    --------
    >>> kerr_surface("r=6", slice="painleve-gullstrand").name
    'r=6 of mass 1 and spin 0 in the slice painleve-gullstrand'
    """
    kind, _, text = surface.partition("=")
    if kind not in ("horizon", "r", "ergosphere") or (kind == "horizon") != (surface == "horizon"):
        raise InvalidParameter(f"surface {surface} is not one of {SURFACES}")
    try:
        number = 0.0 if kind == "horizon" else float(text)
    except ValueError:
        example = {"r": "r=3", "ergosphere": "ergosphere=0.1"}[kind]
        why = f"{text!r} is not a number; give one" if text else "give a number"
        raise InvalidParameter(f"surface {surface}: {why}, for instance {example}") from None
    if cosmological_constant:
        if charge or kind == "ergosphere" or slice != "boyer-lindquist":
            parameter = (
                "charge" if charge else f"surface {kind}" if kind == "ergosphere" else f"slice {slice}"
            )
            raise InvalidParameter(f"{parameter} cannot be combined with a cosmological constant")
        if kind == "horizon":
            return KerrDeSitterSphere.horizon(mass, spin, cosmological_constant).data()
        return KerrDeSitterSphere(number, mass, spin, cosmological_constant).data()
    if slice == "boyer-lindquist":
        if kind == "horizon":
            return KerrNewmanHorizon(mass, spin, charge).data()
        if kind == "r":
            return KerrNewmanSphere(number, mass, spin, charge).data()
        return KerrNewmanErgosphere(number, mass, spin, charge).data()
    if charge:
        raise InvalidParameter("charge needs the slice boyer-lindquist")
    if kind == "ergosphere":
        raise InvalidParameter("surface ergosphere needs the slice boyer-lindquist")
    geometry: KerrSchild | PainleveGullstrand
    if slice == "kerr-schild":
        geometry = KerrSchild(mass, (0.0, 0.0, spin))
        horizon = geometry.horizon  # raises if the spin exceeds the mass
        shape = StarSurface.from_radius(geometry.spheroid(horizon if kind == "horizon" else number))
    elif slice == "painleve-gullstrand":
        if spin:
            raise InvalidParameter(f"the slice {slice} requires zero spin, not {spin:g}")
        geometry = PainleveGullstrand(mass)
        shape = StarSurface.sphere((0.0, 0.0, 0.0), 2.0 * mass if kind == "horizon" else number)
    else:
        raise InvalidParameter(
            f"slice {slice} is not one of boyer-lindquist, kerr-schild and painleve-gullstrand"
        )
    name = f"{surface} of mass {mass:.9g} and spin {spin:.9g} in the slice {slice}"
    return shape.data(geometry, marginal=kind == "horizon", name=name)
