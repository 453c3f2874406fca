"""Reflection and rotation symmetries of simulation grids.

A run in bitant, quadrant or octant mode has points in a half, a quarter or an eighth of space; the rest is
its image under reflections in the planes x = 0, y = 0, z = 0, or under rotations about the z-axis.
"""

import itertools
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.relativity.spacetimes.cartesian_grid import ENTRY

PARAMETER = re.compile(r"^\s*(\w+)::(\w+)\s*=\s*\"?([^\"\n]*?)\"?\s*$", re.MULTILINE)
YES = ("yes", "y", "true", "t", "1")
PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
QUARTER_TURN = ((1, 0, 2), (-1, 1, 1))


@dataclass(frozen=True)
class AxisMap:
    """The map ``x'_a = sign_a x_source(a)`` of space onto itself: a reflection, or a turn by right angles.

    Attributes
    ----------
    source : tuple of int
        Which old axis each new one is.
    sign : tuple of int
        1 or -1, for each new axis.
    """

    source: tuple[int, int, int] = (0, 1, 2)
    sign: tuple[int, int, int] = (1, 1, 1)

    def entry(self, six: int) -> tuple[int, int]:
        """Index of the new entry among the six entries of the old matrix, and its sign."""
        a, b = PAIRS[six]
        return int(ENTRY[self.source[a], self.source[b]]), self.sign[a] * self.sign[b]

    def permuted(self, triple: Sequence[float] | Floats | Indices) -> Floats:
        """Three numbers, one for each old axis, in the order of the new ones."""
        return np.asarray(triple)[list(self.source)]

    def turned(self, array: Floats) -> Floats:
        """View of values on old points [i, j, k] in the order of the new points."""
        return array.transpose(self.source)[tuple(slice(None, None, sign) for sign in self.sign)]

    def after(self, first: "AxisMap") -> "AxisMap":
        """The map that does another one first."""
        source = [first.source[a] for a in self.source]
        sign = [s * first.sign[a] for s, a in zip(self.sign, self.source, strict=True)]
        return AxisMap((source[0], source[1], source[2]), (sign[0], sign[1], sign[2]))


IDENTITY = AxisMap()


def symmetry_in(parameters: str) -> tuple[AxisMap, ...]:
    """Symmetry of a run, from the parameters that Cactus writes into its files.

    Known are the thorns ReflectionSymmetry, RotatingSymmetry180 and RotatingSymmetry90, the reflections of
    CarpetX, and the domains bitant, quadrant and octant of CartGrid3D.

    Parameters
    ----------
    parameters : str
        A line ``Thorn::parameter = value`` for every parameter of an active thorn.

    Returns
    -------
    tuple of AxisMap
        All maps of the symmetry, the identity first; it alone if there is none.
    """
    given = {f"{m[1]}::{m[2]}".lower(): m[3].lower() for m in PARAMETER.finditer(parameters)}
    generators = [
        _reflection(axis)
        for axis, letter in enumerate("xyz")
        if given.get(f"reflectionsymmetry::reflection_{letter}") in YES
        or given.get(f"carpetx::reflection_{letter}") in YES
        or letter in _halved(given)
    ]
    quarter = AxisMap(*QUARTER_TURN)
    if any(name.startswith("rotatingsymmetry180::") for name in given):
        generators.append(quarter.after(quarter))
    if any(name.startswith("rotatingsymmetry90::") for name in given):
        generators.append(quarter)
    return _generated(generators)


def reflections(axes: Iterable[int]) -> tuple[AxisMap, ...]:
    """Symmetry of a run of which only the part on one side of some coordinate planes exists.

    Parameters
    ----------
    axes : iterable of int
        Those normal to the planes, 0 being x.

    Returns
    -------
    tuple of AxisMap
        As of `symmetry_in`.
    """
    return _generated([_reflection(axis) for axis in axes])


def _generated(generators: Sequence[AxisMap]) -> tuple[AxisMap, ...]:
    """All products of some maps, the identity first."""
    maps = [IDENTITY]
    while new := list(
        dict.fromkeys(b for a, g in itertools.product(maps, generators) if (b := g.after(a)) not in maps)
    ):
        maps += new
    return tuple(maps)


def _halved(given: dict[str, str]) -> str:
    """The axes of which CartGrid3D has one half."""
    match given.get("grid::domain", given.get("cartgrid3d::domain", "full")):
        case "octant":
            return "xyz"
        case "quadrant":
            return "xyz".replace(given.get("grid::quadrant_direction", "z"), "")
        case "bitant":
            plane = given.get("grid::bitant_plane", "xy")
            return "".join(letter for letter in "xyz" if letter not in plane)
        case _:
            return ""


def _reflection(axis: int) -> AxisMap:
    signs = [-1 if a == axis else 1 for a in range(3)]
    return AxisMap(sign=(signs[0], signs[1], signs[2]))
