"""Newton's method for surfaces of constant expansion."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from isoembed.arrays import Floats
from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.relativity.horizons.discretization import Discretization, Equations, Iterate

ROUNDING = 1e-7  # residual over the radius below which stagnation counts as convergence: 2e-9 in degree 512
PATIENCE = 10
"""Steps in which the residual must decrease tenfold, as it does even with damped steps of 1/4."""


class NoConvergence(ArithmeticError):  # noqa: N818 - as the package's others
    """Newton's method did not converge; the message says where."""


FAILURES = (NoConvergence, InvalidMetric, InvalidParameter)
"""Exceptions of `solve`."""


@dataclass(frozen=True, eq=False)
class Solution:
    """Surface of constant expansion, up to the truncation of the harmonics.

    Attributes
    ----------
    discretization : Discretization
    iterate : Iterate
    expansion : float
    equations : Equations
        Equations linearized at a nearby surface.
    steps : int
    noise : float
        Root-mean-square displacement from the error of the slice, relative to the radius, for smooth errors.
    """

    discretization: Discretization
    iterate: Iterate
    expansion: float
    equations: Equations
    steps: int
    noise: float


def solve(
    discretization: Discretization, f: Floats, expansion: float | None, enough: float = 0.0
) -> Solution:
    """Find a surface of constant expansion near a given one.

    Raises `NoConvergence`: the residual does not decrease, or less than tenfold in ten steps; `InvalidMetric`
    or `InvalidParameter`: the initial surface leaves the domain of the slice.

    Parameters
    ----------
    discretization : Discretization
    f : ndarray, shape (size,)
        Coefficients of the initial surface.
    expansion : float, optional
        Prescribed expansion; by default it is an unknown, and the mean of f is fixed.
    enough : float
        Residual at which to stop, as a displacement relative to the radius.
    """
    free = expansion is None
    at = discretization.iterate(f)
    if expansion is None:
        expansion = float(discretization.transform.weights @ at.local.expansion / (4.0 * np.pi))
    equations, sizes = _linearized(discretization, at, free), list[float]()
    by_slice = equations.projected(discretization.expansion_errors(at))
    noise = float(np.linalg.norm(by_slice)) / at.radius
    enough = max(enough, 0.02 * noise, 1e-15)  # well below the error of the slice, or rounding
    while True:
        right, step = _residual(equations, at, expansion), len(sizes)
        size = float(np.linalg.norm(right)) / at.radius
        falls = not sizes or size <= 0.5 * sizes[-1]
        sizes.append(size)
        if size <= enough or (size <= ROUNDING and not falls):
            return Solution(discretization, at, expansion, equations, step, noise)
        if step >= PATIENCE and size > 0.1 * sizes[step - PATIENCE]:
            raise NoConvergence(f"the residual {size:.2g} falls too slowly")
        change = equations.solved(right)
        rate = float(change[0]) if free else 0.0
        if free:
            change[0] = 0.0
        try:
            part, at, left = _moved(discretization, at, change, expansion, rate, equations)
        except NoConvergence:
            if size <= ROUNDING:
                return Solution(discretization, at, expansion, equations, step, noise)
            raise
        expansion -= part * rate
        if left > 0.1 * size:  # otherwise the linearization is accurate enough to keep
            equations = _linearized(discretization, at, free)


def _linearized(discretization: Discretization, at: Iterate, free: bool) -> Equations:
    equations = discretization.equations(at)
    if equations.linear.tilt.min() <= 0.0:
        raise NoConvergence("the surface folds over")
    return replace(equations, free=free)


def _moved(
    discretization: Discretization,
    at: Iterate,
    change: Floats,
    expansion: float,
    rate: float,
    equations: Equations,
) -> tuple[float, Iterate, float]:
    """Damping factor of a step that reduces the residual, the new surface, and its relative residual."""
    radius = at.radius
    size = float(np.linalg.norm(_residual(equations, at, expansion))) / radius
    longest = float(np.abs(discretization.transform.values(change[:, None])).max())
    part = min(1.0, 0.3 * radius / longest) if longest > 0.0 else 1.0  # displacement of at most 0.3 radii
    why = f"Newton's method stalls at the residual {size:.2g}"
    while part >= 1.0 / 16.0:
        try:
            trial = discretization.iterate(at.f - part * change)
        except (InvalidMetric, InvalidParameter) as error:
            why = str(error)
        else:
            left = float(np.linalg.norm(_residual(equations, trial, expansion - part * rate))) / radius
            if left <= (1.0 - 0.2 * part) * size:  # a fifth of the decrease of a linear residual
                return part, trial, left
        part *= 0.5
    raise NoConvergence(why)


def _residual(equations: Equations, at: Iterate, expansion: float) -> Floats:
    """Projection (size,) of the excess of the expansion over the given one."""
    return equations.projected(at.local.expansion - expansion)
