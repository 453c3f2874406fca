"""Quasi-local energies through a head-on merger: Bowen and York's slices of moving holes.

D. Pook-Kolb, B. Zhao, L. Andersson, B. Krishnan and S.-T. Yau, arXiv:2308.10906; B. Zhao, L. Andersson and
S.-T. Yau, arXiv:2406.10751.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import pi, sqrt
from typing import TYPE_CHECKING, Any

import numpy as np

from isoembed.relativity import embed_surface, find_horizon
from reproduction import plots
from reproduction.arrays import Floats
from reproduction.head_on import END, outside, rate
from reproduction.published import Published, rows
from reproduction.section import Section
from reproduction.two_punctures import DEGREES, TwoPunctures

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HALF = (0.5, 0.5)  # bare masses
SLOW, FAST = 0.2, 0.5  # momenta of each hole
NEAR = 0.5  # distance at which surfaces of constant expansion are followed
THEIRS = {  # by the program TwoPunctures, 40 x 40 x 4 points, to the places that more points do not change
    "slow": "1.010817865",  # mass at infinity, momenta 0.2, distance 1
    "puncture": "0.62843354",  # and of each hole at its other end
    "fast": "1.02137200",  # mass at infinity, momenta 0.5, distance 0.5
    "single": "1.499323",  # of one hole of bare mass and momentum 1; 80 points
}
FIRST = 0.7  # distance from which a common horizon is followed to its end
STOPS = 10  # distances on the way
SMALL = 0.02  # a momentum at which the mass is close to second order


def study(*, distances: Sequence[float], expansions: Sequence[float], momenta: Sequence[float]) -> Section:
    """Masses and energies of horizons as the holes approach, and near a common horizon.

    Parameters
    ----------
    distances : sequence of float
        Falling: where the horizon that no other one encloses is searched.
    expansions : sequence of float
        Falling: expansions times the areal radius of surfaces outside of the common horizon.
    momenta : sequence of float
        At which the distance is found where the common horizon appears.
    """
    numbers = _published()
    sequences = {P: [_energies(P, d) for d in distances] for P in (SLOW, FAST)}
    ends = [{"P": P, "end": appearance(P)} for P in (0.0, *momenta)]
    numbers.append(
        Published(
            "distance at which the common horizon appears, P = 0",
            f"{END}",
            ends[0]["end"],
            1e-8,
            END,
            "shooting",
        )
    )
    near = outside(head_on(FAST, NEAR), expansions)
    every = [one for found in sequences.values() for one in found]
    convergence = [_convergence(n) for n in (8, 12, 16, 20, 24, DEGREES)]
    return Section.of(
        "bowen-york",
        figures={"bowen-york": picture(sequences, near)},
        numbers={
            "published": [number.numbers for number in numbers],
            "sequences": every,
            "appearance": ends,
            "convergence": convergence,
            "constant_expansion": near,
        },
        rows=rows(numbers),
        known=numbers,
        every=every,
        ends=ends,
        moving=ends[1:],
        convergence=convergence,
        near=near,
        last=near[-1],
        below=near[-1]["limit"] - near[-1]["wang_yau"],
        rate=rate(near),
        penrose=max(one["mass"] * sqrt(one["number"]) / one["infinity"] for one in every),
        distance=NEAR,
        fast=FAST,
    )


def head_on(P: float, distance: float) -> TwoPunctures:
    """Two equal holes with momenta P toward each other."""
    return TwoPunctures.solved(HALF, (-P, P), distance)


def _published() -> list[Published]:
    """Masses beside those of the program TwoPunctures, and of one slow hole beside the closed form."""
    slow, fast = head_on(SLOW, 1.0), head_on(FAST, 0.5)
    single, finer = (TwoPunctures.solved((1.0, 0.0), (1.0, 0.0), 2.0, n) for n in (DEGREES, DEGREES + 8))
    quadrature, logarithms = "quadrature about the holes", "rounding; u has logarithms at infinity"
    more = f"{DEGREES + 8} degrees instead of {DEGREES}"
    ends = (
        one.puncture_masses[0] for one in (slow, TwoPunctures.solved(HALF, (-SLOW, SLOW), 1.0, DEGREES + 8))
    )
    masses = [
        Published(f"mass at infinity, {what}", THEIRS[key], one.mass, 1e-12, by_quadrature(one), quadrature)
        for what, key, one in (("P = 0.2, d = 1", "slow", slow), ("P = 0.5, d = 0.5", "fast", fast))
    ]
    masses += [
        Published(f"mass {what}", THEIRS[key], ours, error, second, more, reason)
        for what, key, (ours, second), error, reason in (
            ("of each hole at its other end, P = 0.2, d = 1", "puncture", ends, 1e-9, ""),
            ("at infinity, one hole, P = m", "single", (single.mass, finer.mass), 1e-11, logarithms),
        )
    ]
    at_infinity, at_horizon = np.array([_one_hole(P) for P in (SMALL, 2 * SMALL)]).T
    masses += [
        Published(
            f"(M{index} - m) m / P^2 of one hole, P -> 0", value, (4 * found[0] - found[1]) / 3, 1e-6,
            float(value), by,
        )
        for index, value, found, by in (
            ("", "0.625", at_infinity, "closed form, 5/8"),
            ("_irr", "0.125", at_horizon, "M^2 = M_irr^2 + P^2 and 5/8"),
        )
    ]  # fmt: skip
    return masses


def _one_hole(P: float) -> tuple[float, float]:
    """What a momentum adds to the mass at infinity and to that of the horizon, over its square; m = 1."""
    hole = TwoPunctures.solved((1.0, 0.0), (P, 0.0), 1.0)
    return hole.source / P**2, (find_horizon(hole).irreducible_mass - 1) / P**2


def by_quadrature(holes: TwoPunctures, nodes: int = 60) -> float:
    """The mass at infinity of equal holes, in spherical coordinates about one in its half of space."""
    x, weights = np.polynomial.legendre.leggauss(nodes)
    x, weights = 0.5 * (x + 1), 0.5 * weights
    b, total = 0.5 * holes.distance, 0.0
    for sign in (1, -1):  # directions away from the plane between the holes, and toward it
        for cosine, weight in zip(sign * x, weights, strict=True):
            end = 1.0 if sign > 0 else 1 / (1 - cosine)  # of r / (r + b): infinity, or the plane
            r = b * end * x / (1 - end * x)
            dr = b * end / (1 - end * x) ** 2
            at = np.column_stack([r * np.sqrt(1 - cosine**2), 0 * r, b + r * cosine])
            squared = (holes.conformal_curvature(at) ** 2).sum(axis=(1, 2))
            density = squared * holes.conformal_factor(at) ** -7 * r**2
            total += 2 * pi * weight * float(weights @ (density * dr))
    return sum(holes.masses) + 2 * total / (16 * pi)


def _energies(P: float, distance: float) -> dict[str, Any]:
    """Masses of the horizon that no other one encloses."""
    holes = head_on(P, distance)
    found = find_horizon(holes)
    energies = embed_surface(found.data()).energies
    assert energies.liu_yau is not None
    common = abs(found.surface.center[2]) < 0.1 * distance
    return {
        "P": P,
        "d": distance,
        "which": "common" if common else "one of two",
        "number": 1 if common else 2,
        "mass": found.irreducible_mass,
        "liu_yau": energies.liu_yau.value,
        "infinity": holes.mass,
        "error": energies.liu_yau.error,
        "stability": found.stability,
    }


def appearance(P: float) -> float:
    """The distance of the holes at which the common horizon appears, where its stability s vanishes.

    The distance is a smooth function of s with no linear term, ``d = D - a s^2 - b s^3 ...``.
    """
    found = find_horizon(head_on(P, FIRST))
    trace = [(FIRST, found.stability)]
    end = 1.05 * FIRST
    while len(trace) < STOPS:
        distance = 0.5 * (trace[-1][0] + end)
        found = find_horizon(head_on(P, distance), found.surface)
        trace.append((distance, found.stability))
        d, s = np.array(trace[-5:]).T
        end = float(np.linalg.solve(s[:, None] ** np.array([0, 2, 3, 4, 5])[: len(s)], d)[0])
    return end


def _convergence(degrees: int) -> dict[str, float]:
    """The mass at infinity and at the other end of a hole, and the former by the falloff of psi."""
    holes = TwoPunctures.solved(HALF, (-SLOW, SLOW), 1.0, degrees)
    return {
        "degrees": degrees,
        "mass": holes.mass,
        "falloff": holes.mass_by_falloff,
        "puncture": holes.puncture_masses[0],
    }


def picture(sequences: dict[float, list[dict[str, Any]]], near: Sequence[dict[str, float]]) -> Figure:
    """Masses against the distance of the holes, and energies outside of the common horizon."""
    figure = plots.blank(3.8)
    left, right = figure.subplots(1, 2)
    plots.dress(left, "distance d of the holes", "mass", "outermost horizons of equal holes")
    for (P, found), style in plots.styled(sequences.items()):
        for number in (2, 1):  # of horizons: the area jumps where they get a common one
            part = [one for one in found if one["number"] == number]
            d = [one["d"] for one in part]
            irreducible = [number * one["mass"] for one in part]
            half = [0.5 * number * one["liu_yau"] for one in part]
            left.plot(d, irreducible, **style, label=f"P = {P:g}, $M_{{irr}}$" if number == 1 else "")
            left.plot(
                d,
                half,
                **style,
                linestyle="--",
                fillstyle="none",
                label="half of Kijowski-Liu-Yau" if (P, number) == (SLOW, 1) else "",
            )
        left.plot(
            [one["d"] for one in found],
            [one["infinity"] for one in found],
            color=style["color"],
            linestyle=":",
            linewidth=0.8,
        )
    left.set_ylim(top=1.55)
    left.set_xscale("log")
    ticks = (0.4, 0.6, 1.0, 2.0, 4.0)
    left.set_xticks(ticks, [f"{x:g}" for x in ticks])
    left.set_xticks([], minor=True)
    plots.legend(left, loc="upper right")
    plots.dress(
        right,
        "expansion times the horizon's areal radius",
        "energy of the horizon, less that of the surface",
        f"constant expansion, d = {NEAR:g}, P = {FAST:g}",
    )
    c: Floats = np.array([one["c"] for one in near])
    for key, color, name in (
        ("liu_yau", plots.BLUE, "Kijowski-Liu-Yau"),
        ("wang_yau", plots.VERMILION, "least Wang-Yau"),
    ):
        below = [one["limit"] - one[key] for one in near]
        right.loglog(c, below, color=color, marker="o", label=name)
    right.loglog(c, 0.3 * below[-1] * np.sqrt(c / c[-1]), color=plots.INK, linewidth=0.7, label="$c^{1/2}$")
    plots.legend(right)
    return figure
