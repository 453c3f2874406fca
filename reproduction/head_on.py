"""Quasi-local energies through a head-on merger: Brill and Lindquist's slices.

D. Pook-Kolb, B. Zhao, L. Andersson, B. Krishnan and S.-T. Yau, arXiv:2308.10906; B. Zhao, L. Andersson and
S.-T. Yau, arXiv:2406.10751.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import pi, sqrt
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from isoembed.relativity import (
    BrillLindquist,
    FoundHorizon,
    StarSurface,
    ThreeGeometry,
    constant_expansion,
    embed_surface,
    find_horizon,
    inner_horizon,
    wang_yau,
)
from isoembed.smooth import AxisymmetricEmbedding
from reproduction import plots
from reproduction.arrays import Floats
from reproduction.published import Published, rows
from reproduction.section import Section

if TYPE_CHECKING:
    from matplotlib.figure import Figure

END = 0.76619743  # distance of equal holes at which the common horizon appears, by shooting
FLAT_WAIST = "0.62783144"  # likewise, at which K = 0 at its waist
TUTORIAL = "49.8984892225"  # area for masses (0.2, 0.8) at 0.65, of MOTSFinder's public tutorial
SHOT = {  # (masses, distance, which): M_irr and the Kijowski-Liu-Yau energy, by shooting
    ((0.5, 0.5), 0.5, "common"): ("0.998248418", "2.01920982"),
    ((0.5, 0.5), 0.7, "common"): ("0.992722898", "2.08522669"),
    ((0.5, 0.5), 0.765, "common"): ("0.988481603", "2.18409858"),
    ((0.2, 0.8), 0.5, "common"): ("0.999007214", "2.01382715"),
    ((0.5, 0.5), 0.5, "individual"): ("0.749986858", "1.50015707"),
    ((0.5, 0.5), 1.0, "individual"): ("0.624999260", "1.25000897"),
    ((0.5, 0.5), 0.5, "inner"): ("1.081780729", "2.80388428"),
}
NEAR = 0.5  # distance at which surfaces of constant expansion are followed


def study(
    *, separate: Sequence[float], common: Sequence[float], inner: bool, expansions: Sequence[float]
) -> Section:
    """Energies of the horizons against the distance of the holes, and near a common horizon.

    Parameters
    ----------
    separate : sequence of float
        Distances at which the individual horizons are found.
    common : sequence of float
        Likewise the common one.
    inner : bool
        Whether the inner horizon is found, which takes longest.
    expansions : sequence of float
        Falling: expansions times the areal radius of surfaces outside of the common horizon.
    """
    apart = [_energies((0.5, 0.5), d, "individual") for d in separate]
    merged = [_energies((0.5, 0.5), d, "common") for d in common]
    shot = {key: _energies(*key) for key in SHOT if inner or key[2] != "inner"}
    tutorial, again = _tutorial()
    numbers = [
        Published(
            "area of the common horizon, masses 0.2 and 0.8, d = 0.65",
            TUTORIAL,
            tutorial,
            1e-10,
            again,
            "holes on a tilted axis off the origin",
        ),
        *(number for key, found in shot.items() for number in _against_shooting(key, found)),
        Published(
            "distance at which K = 0 at the waist",
            FLAT_WAIST,
            flat_waist(),
            1e-9,
            flat_waist_by_shooting(),
            "shooting, here",
            "the last two digits of the known number are wrong: both computations here say so",
        ),
    ]
    near = outside(pair((0.5, 0.5), NEAR), expansions)
    limit = near[-1]["limit"]
    return Section.of(
        "head-on",
        figures={"head-on": picture(apart, merged, near)},
        numbers={
            "published": [number.numbers for number in numbers],
            "separate": apart,
            "common": merged,
            "constant_expansion": near,
        },
        rows=rows(numbers),
        tutorial=numbers[0],
        agreeing=sum(number.agrees for number in numbers[1:-1]),
        known=len(numbers) - 2,
        waist=numbers[-1],
        separate=apart,
        common=merged,
        near=near,
        limit=limit,
        missing=limit - near[-1]["wang_yau"],
        last=near[-1],
        rate=rate(near),
        distance=NEAR,
        first=merged[0],
        closest=merged[-1],
        end=END,
        far=apart[0],
        punctures=max(abs(one["mass"] / one["puncture"] - 1) for one in apart if one["d"] >= 1),
    )


def pair(masses: tuple[float, float], distance: float) -> BrillLindquist:
    """Two holes on the z-axis."""
    return BrillLindquist(masses, ((0, 0, distance / 2), (0, 0, -distance / 2)))


def horizon(masses: tuple[float, float], distance: float, which: str) -> FoundHorizon:
    """The common horizon, the upper hole's own one, or the inner one that belongs to the common one."""
    slice_ = pair(masses, distance)
    if which == "individual":
        return find_horizon(slice_, StarSurface.sphere((0, 0, distance / 2), masses[0] / 2))
    outer = find_horizon(slice_)
    return inner_horizon(outer) if which == "inner" else outer


def _energies(masses: tuple[float, float], distance: float, which: str) -> dict[str, Any]:
    """Masses of a horizon, in units of the sum of the bare ones."""
    found = horizon(masses, distance, which)
    energies = embed_surface(found.data()).energies
    assert energies.liu_yau is not None
    return {
        "d": distance,
        "which": which,
        "mass": energies.irreducible_mass.value,
        "liu_yau": energies.liu_yau.value,
        "errors": (energies.irreducible_mass.error, energies.liu_yau.error),
        "puncture": masses[0] * (1 + masses[1] / (2 * distance)),
        "stability": found.stability,
    }


def _against_shooting(key: tuple[tuple[float, float], float, str], found: dict[str, Any]) -> list[Published]:
    """The two masses of a horizon beside those by shooting."""
    (m, _), d, which = key
    name = f"{which} horizon, masses {m:g} and {1 - m:g}, d = {d:g}"
    return [
        Published(f"{what}, {name}", known, found[value], max(error, 1e-10), float(known), "shooting")
        for what, known, value, error in zip(
            ("M_irr", "Kijowski-Liu-Yau"), SHOT[key], ("mass", "liu_yau"), found["errors"], strict=True
        )
    ]


def _tutorial() -> tuple[float, float]:
    """The area of the horizon of MOTSFinder's tutorial, and of the same holes elsewhere."""
    axis, middle = np.array([0.36, 0.48, 0.8]), np.array([0.3, -0.2, 0.1])
    places = tuple(tuple(float(x) for x in middle + s * 0.325 * axis) for s in (1, -1))
    return (
        find_horizon(pair((0.2, 0.8), 0.65)).area,
        find_horizon(BrillLindquist((0.2, 0.8), places)).area,
    )


def flat_waist() -> float:
    """The distance of equal holes at which K = 0 at the waist of the common horizon."""

    def curvature(distance: float) -> float:
        metric = horizon((0.5, 0.5), distance, "common").data().metric
        return float(AxisymmetricEmbedding.of(metric).gaussian_curvature([pi / 2])[0])

    return float(brentq(curvature, 0.626, 0.63, xtol=1e-10))


def flat_waist_by_shooting() -> float:
    """The same by the ordinary differential equation of a minimal meridian, from the pole to the equator."""
    return float(brentq(lambda distance: _shot(distance)[1], 0.626, 0.63, xtol=1e-11))


def _shot(distance: float) -> tuple[float, float]:
    """The height of the pole of the common horizon of two equal holes, and K at its waist.

    In psi^4 (dr^2 + dz^2 + r^2 dphi^2), with t the angle of the meridian, t' + sin(t) / r = -4 d ln psi / dn.
    On a minimal surface K = -Ric(n, n) - k^2 (Gauss), k = (1 / r + 2 d ln psi / dr) / psi^2 at the waist.
    """
    h, first = distance / 2, 3e-4  # the length of meridian that the series at the pole stands for

    def psi(r: float, z: float) -> Floats:
        """Conformal factor and its derivatives in r and z."""
        above, below = np.hypot(r, z - h), np.hypot(r, z + h)
        return np.array(
            [
                1 + 0.25 / above + 0.25 / below,
                -0.25 * r * (above**-3 + below**-3),
                -0.25 * ((z - h) * above**-3 + (z + h) * below**-3),
            ]
        )

    def along(_: float, y: Floats) -> list[float]:
        r, z, t = y
        p, p_r, p_z = psi(r, z)
        turning = -np.sin(t) / r - 4 * (np.sin(t) * p_r + np.cos(t) * p_z) / p
        return [np.cos(t), -np.sin(t), turning]

    def plane(_: float, y: Floats) -> float:
        return float(y[1])

    plane.terminal = True  # type: ignore[attr-defined]

    def arrival(top: float) -> Floats:
        p, _, p_z = psi(0.0, top)
        bend = -2 * p_z / p
        start = [first, top - bend * first**2 / 2, bend * first]
        options = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-14}
        found = solve_ivp(along, (first, 5.0), start, events=plane, **options)
        return np.asarray(found.y_events[0][0])

    top = float(brentq(lambda z: arrival(z)[2] - pi / 2, 0.6, 0.63, xtol=1e-14))
    r = arrival(top)[0]
    p, p_r, _ = psi(r, 0.0)
    far = np.hypot(r, h)
    p_rr = -0.5 * (far**-3 - 3 * r * r * far**-5)
    ricci = (-2 * p_rr / p + 4 * (p_r / p) ** 2) / p**4
    return top, float(-ricci - ((1 / r + 2 * p_r / p) / p**2) ** 2)


def outside(holes: ThreeGeometry, expansions: Sequence[float]) -> list[dict[str, float]]:
    """Energies of surfaces of constant expansion outside of a common horizon, from far to near."""
    outer = find_horizon(holes)
    energy = embed_surface(outer.data()).energies.liu_yau
    assert energy is not None
    radius, records = sqrt(outer.area / (4 * pi)), []
    guess = outer.surface
    for c in sorted(expansions):
        found = constant_expansion(holes, c / radius, guess)
        guess = found.surface
        data = found.data()
        surface = embed_surface(data)
        least = wang_yau(data, "optimal", embedding=surface.embedding)
        given = surface.energies.liu_yau
        assert given is not None
        records.append(
            {
                "c": c,
                "radius": sqrt(found.area / (4 * pi)),
                "liu_yau": given.value,
                "wang_yau": least.energy.value,
                "second": float(least.least_second_derivative or 0.0),
                "limit": energy.value,
            }
        )
    return records[::-1]


def rate(near: Sequence[dict[str, float]]) -> float:
    """The power of the expansion with which the energy tends to that of the horizon."""
    a, b = near[-2:]
    return float(
        np.log((a["limit"] - a["wang_yau"]) / (b["limit"] - b["wang_yau"])) / np.log(a["c"] / b["c"])
    )


def picture(
    apart: Sequence[dict[str, Any]], merged: Sequence[dict[str, Any]], near: Sequence[dict[str, float]]
) -> Figure:
    """Masses against the distance of the holes, and energies outside of the common horizon."""
    figure = plots.blank(3.8)
    left, right = figure.subplots(1, 2)
    plots.dress(left, "distance d of the holes", "mass", "horizons of equal holes")
    for records, factor, name in ((apart, 2, "both holes"), (merged, 1, "common horizon")):
        d = [one["d"] for one in records]
        color = plots.BLUE if factor == 2 else plots.VERMILION
        left.plot(
            d,
            [factor * one["mass"] for one in records],
            color=color,
            marker="o",
            label=f"{name}, $M_{{irr}}$",
        )
        left.plot(
            d,
            [factor * one["liu_yau"] / 2 for one in records],
            color=color,
            marker="+",
            linestyle="--",
            label="half of Kijowski-Liu-Yau",
        )
    left.axvline(END, color=plots.STONE, linewidth=0.8)
    left.set_xscale("log")
    ticks = (0.4, 0.6, 1.0, 2.0, 4.0)
    left.set_xticks(ticks, [f"{x:g}" for x in ticks])
    left.set_xticks([], minor=True)
    plots.legend(left, loc="upper right")
    plots.dress(
        right, "expansion times the horizon's areal radius", "energy", f"constant expansion, d = {NEAR:g}"
    )
    c = [one["c"] for one in near]
    right.semilogx(
        c, [one["liu_yau"] for one in near], color=plots.BLUE, marker="o", label="Kijowski-Liu-Yau"
    )
    right.semilogx(
        c,
        [one["wang_yau"] for one in near],
        color=plots.VERMILION,
        marker="+",
        markersize=9,
        linestyle="none",
        label="least Wang-Yau",
    )
    right.axhline(near[0]["limit"], color=plots.INK, linewidth=0.8)
    plots.note(right, "horizon", (c[0], near[0]["limit"]), (-42, 4))
    plots.legend(right)
    return figure
