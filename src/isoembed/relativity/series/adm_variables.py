"""ADM variables (spatial metric, extrinsic curvature) from BSSN, CCZ4 or Z4c variables.

With chi = psi^-4 (or another power of psi) and conformal h_ij and A_ij,

    gamma_ij = psi^4 h_ij,    K_ij = psi^4 A_ij + K gamma_ij / 3,

where Z4c has K = Khat + 2 Theta [1]_, and CCZ4 evolves K itself [2]_.

References
----------
.. [1] D. Hilditch et al., "Compact binary evolutions with the Z4c formulation", Physical Review D 88 (2013),
   084057.
.. [2] T. Andrade et al., "GRChombo: An adaptable numerical relativity code for fundamental physics", Journal
   of Open Source Software 6 (2021), 3703.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from isoembed.arrays import Floats
from isoembed.io.files import FileError
from isoembed.relativity.spacetimes.slice_file import GAMMA, K

NUMBERED = ("11", "12", "13", "22", "23", "33")


class Variables(Protocol):
    """Variables of a code that determine the metric and the extrinsic curvature."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the variables."""
        ...

    def adm(self, values: Floats) -> Floats:
        """Twelve fields gxx ... gzz and kxx ... kzz from the values (n, ...) of the variables."""
        ...


@dataclass(frozen=True)
class AdmVariables:
    """Metric and K_ij as variables.

    Attributes
    ----------
    names : tuple of str
        Names of the components of the metric and of K_ij.
    """

    names: tuple[str, ...] = (*GAMMA, *K)

    def adm(self, values: Floats) -> Floats:
        """See `Variables`."""
        return values


@dataclass(frozen=True)
class ConformalVariables:
    """Power of the conformal factor, conformal metric, trace-free curvature and trace.

    Attributes
    ----------
    factor : str
        Name of chi.
    metric, curvature : tuple of str
        Names of h_ij and A_ij.
    trace : tuple of (str, float)
        Names and factors of the terms of the trace K.
    power : float
        Exponent with chi^power = psi^4.
    """

    factor: str
    metric: tuple[str, ...]
    curvature: tuple[str, ...]
    trace: tuple[tuple[str, float], ...]
    power: float = -1.0

    @property
    def names(self) -> tuple[str, ...]:
        """See `Variables`."""
        return (self.factor, *self.metric, *self.curvature, *(name for name, _ in self.trace))

    def adm(self, values: Floats) -> Floats:
        """See `Variables`; NaN where chi is not positive."""
        chi, h, a, parts = values[0], values[1:7], values[7:13], values[13:]
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            psi4 = np.where(chi > 0.0, chi, np.nan) ** self.power
            gamma = psi4 * h
            trace = sum(count * part for (_, count), part in zip(self.trace, parts, strict=True))
            return np.concatenate([gamma, psi4 * a + trace * gamma / 3.0])


GRCHOMBO = ConformalVariables(
    "chi", tuple(f"h{ij}" for ij in NUMBERED), tuple(f"A{ij}" for ij in NUMBERED), (("K", 1.0),)
)


def rank(there: Collection[str], sets: Sequence[Variables]) -> int:
    """Index of the first complete set of variables; the number of sets if none is complete."""
    complete = (k for k, variables in enumerate(sets) if {*variables.names} <= {*there})
    return next(complete, len(sets))


def variables_in(there: Collection[str], sets: Sequence[Variables], name: str) -> Variables:
    """First complete set of variables.

    Raises `FileError`: no set is complete; the message names those missing from the most complete one.
    """
    if (first := rank(there, sets)) < len(sets):
        return sets[first]
    best = max(sets, key=lambda variables: len({*variables.names} & {*there}))
    if not {*best.names} & {*there}:
        kinds = "; or ".join(", ".join(variables.names) for variables in sets)
        raise FileError(f"{name} has none of the variables that make a slice: {kinds}")
    missing = [each for each in best.names if each not in there]
    raise FileError(f"{name} has no {', '.join(missing)}: {', '.join(best.names)} are needed")
