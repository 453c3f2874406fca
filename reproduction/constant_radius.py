"""Surfaces of constant radius in Kerr spacetime: which embed, their energies, and those within the horizon.

J.-L. Liu and L.-F. Tam, arXiv:1601.04395; Phys. Rev. D 95 (2017) 084042; W. A. Miller, S. Ray, M.-T. Wang and
S.-T. Yau, arXiv:1708.07532; B. Zhao, S.-T. Yau and L. Andersson, arXiv:2407.00593.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import pi, sqrt
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.optimize import brentq

from isoembed import InvalidParameter, certify, embed
from isoembed.relativity import (
    KerrNewmanSphere,
    KerrSchild,
    StarSurface,
    embed_surface,
    smarr_limit,
    wang_yau,
)
from isoembed.smooth import triangulate_metric
from reproduction import plots
from reproduction.arrays import Floats
from reproduction.published import Published, rows
from reproduction.section import Section

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ERGOSPHERE = 2.0  # its largest radius, at the equator, in units of the mass
MEETING = sqrt(0.75)
MEETS = "0.86602540"  # sqrt(3)/2, which the paper writes so
THETA = np.linspace(0, pi / 2, 201)
NORTH = np.array([[0.0, 0.0, 1.0]])
WITHIN = ((0.0, 1.5), (0.3, 1.5), (0.3, 1.2), (0.6, 1.6), (0.6, 1.4))  # spins and radii below r_+


def study(*, spins: int, vertices: int, radii: Sequence[float]) -> Section:
    """Which surfaces r = const embed, what their energies are, and what is refused within the horizon.

    Parameters
    ----------
    spins : int
        From 0 to 1.
    vertices : int
        Of the polyhedra at r = 2 m.
    radii : sequence of float
        Rising, at which energies of the extreme hole are computed.
    """
    outside = [
        _outside(spin, r) for spin in np.linspace(0, 1, spins) for r in (ERGOSPHERE, 2.5, 3.0, 5.0, 10.0)
    ]
    least = min(outside, key=lambda one: one["curvature"])
    solids = [_solid(spin, vertices) for spin in (0.5, 1.0)]
    energies = [_energies(r) for r in radii]
    within = [_within(spin, r) for spin, r in WITHIN]
    numbers = [
        Published(
            "spin at which r_+, r_K and sqrt(3) a meet",
            MEETS,
            _meeting(),
            1e-10,
            smarr_limit(),
            "Smarr's limit, the end of surfaces of revolution",
        ),
        Published(
            "r_K / m, extreme hole",
            "",
            first_radius(1.0),
            1e-10,
            _cubic(1.0),
            "r (r^2 + a^2) = 6 m a^2",
        ),
        Published(
            "least K r^2 for r >= 2 m",
            "",
            least["curvature"],
            1e-10,
            ERGOSPHERE**2 * pole_curvature(least["spin"], least["r"]),
            "K at the poles, closed form",
        ),
    ]
    falling = all(a["brown_york"] > b["brown_york"] > 1 for a, b in pairwise(energies))
    return Section.of(
        "constant-radius",
        figures={"constant-radius": picture(energies)},
        numbers={
            "published": [number.numbers for number in numbers],
            "outside": outside,
            "polyhedra": solids,
            "energies": energies,
            "within": within,
        },
        rows=rows(numbers),
        meeting=numbers[0],
        embedded=sum(one["embeds"] for one in outside),
        outside=len(outside),
        least=least,
        vertices=vertices,
        solids=solids,
        energies=energies,
        order="falls" if falling else "does not fall",
        last=energies[-1],
        steepest=max(one["gradient"] for one in energies),
        softest=min(one["second"] for one in energies),
        apart=max(abs(one["wang_yau"] - one["brown_york"]) for one in energies),
        within=within,
        refused=sum(one["refused"] for one in within),
        tried=len(within),
        sentence=within[0]["sentence"],
        off=max(one["off"] for one in within),
    )


def _outside(spin: float, r: float) -> dict[str, Any]:
    """The least K r^2 of a surface outside of the ergosphere, and whether it embeds."""
    surface = KerrNewmanSphere(r, spin=spin)
    u = np.column_stack([np.sin(THETA), np.zeros_like(THETA), np.cos(THETA)])
    K = surface.gaussian_curvature(u)
    profile = surface.profile()
    return {
        "spin": float(spin),
        "r": r,
        "curvature": float(K.min()) * r * r,
        "embeds": profile.embeds and not profile.negative_curvature,
    }


def _solid(spin: float, vertices: int) -> dict[str, Any]:
    """The convex polyhedron of geodesic lengths on r = 2 m, with its proof."""
    metric = triangulate_metric(KerrNewmanSphere(ERGOSPHERE, spin=spin), vertices).metric
    found = embed(metric, method="alexandrov")
    return {"spin": spin, "residual": found.residual, "certified": certify(found).certified}


def pole_curvature(a: float, r: float) -> float:
    """K at the poles of r = const: r (r (r^2 + a^2) - 6 m a^2) / (r^2 + a^2)^3."""
    return r * (r * (r * r + a * a) - 6 * a * a) / (r * r + a * a) ** 3


def _horizon(a: float) -> float:
    return 1 + sqrt(1 - a * a)


def first_radius(a: float) -> float:
    """r_K: the radius of the surface whose K vanishes at the poles; from there on they embed."""
    return float(
        brentq(
            lambda r: float(KerrNewmanSphere(r, spin=a).gaussian_curvature(NORTH)[0]),
            _horizon(a),
            ERGOSPHERE,
            xtol=1e-14,
        )
    )


def _cubic(a: float) -> float:
    """The same by the closed form of the curvature."""
    return float(np.real(np.roots([1.0, 0.0, a * a, -6 * a * a])[-1]))


def _meeting() -> float:
    """The spin at which the horizon's K vanishes at the poles: r_K = r_+."""

    def curvature(a: float) -> float:
        return float(KerrNewmanSphere(_horizon(a), spin=a).gaussian_curvature(NORTH)[0])

    return float(brentq(curvature, 0.8, 0.9, xtol=1e-15))


def _energies(r: float) -> dict[str, float]:
    """Energies of a surface around the extreme hole."""
    data = KerrNewmanSphere(r, spin=1.0).data()
    surface = embed_surface(data)
    least = wang_yau(data, "optimal", embedding=surface.embedding)
    energy = surface.energies.brown_york
    assert energy is not None and least.gradient is not None and least.least_second_derivative is not None
    return {
        "r": r,
        "brown_york": energy.value,
        "wang_yau": least.energy.value,
        "gradient": float(least.gradient),
        "second": float(least.least_second_derivative),
    }


def squared_norm(a: float, r: float, cosine: Floats) -> Floats:
    """|H|^2 of r = const from the spacetime, Delta / Sigma (d ln sqrt(q) / dr)^2: negative within r_+."""
    Delta, s = r * r - 2 * r + a * a, 1 - cosine**2
    Sigma, A = r * r + a * a * (1 - s), r * r + a * a
    rate = (2 * r * A - (r - 1) * a * a * s) / (A * A - Delta * a * a * s)
    return np.asarray(Delta / Sigma * rate**2)


def _within(spin: float, r: float) -> dict[str, Any]:
    """What is said of a surface of timelike mean curvature in a Kerr-Schild slice."""
    slice_ = KerrSchild(1.0, (0.0, 0.0, spin))
    sphere = StarSurface.from_radius(slice_.spheroid(r))
    data = sphere.data(slice_)
    u = np.column_stack([np.sin(THETA), np.zeros_like(THETA), np.cos(THETA)])
    assert data.mean_curvature is not None and data.momentum is not None
    k, p = data.mean_curvature(u), data.momentum(u)
    # Directions in Kerr-Schild coordinates are not Boyer and Lindquist's: z = r cos(theta).
    ours, exact = (k - p) * (k + p), squared_norm(spin, r, sphere.points(u)[:, 2] / r)
    surface = embed_surface(data)
    hawking, brown_york = surface.energies.hawking, surface.energies.brown_york
    assert hawking is not None and brown_york is not None
    try:
        wang_yau(data, embedding=surface.embedding)
    except InvalidParameter as error:
        sentence = str(error)
    else:
        sentence = ""
    return {
        "spin": spin,
        "r": r,
        "least": float(ours.min()),
        "greatest": float(ours.max()),
        "off": float(np.abs(ours - exact).max()),
        "hawking": hawking.value,
        "brown_york": brown_york.value,
        "refused": surface.energies.liu_yau is None and bool(sentence),
        "sentence": sentence,
    }


def picture(energies: Sequence[dict[str, float]]) -> Figure:
    """The three curves in the plane of spin and radius, and the energy against the radius."""
    figure = plots.blank(3.8)
    left, right = figure.subplots(1, 2)
    plots.dress(left, "spin a / m", "r / m", "where surfaces r = const embed")
    a = np.linspace(0, 1, 201)
    horizon = 1 + np.sqrt(1 - a * a)
    curved = np.array([_cubic(float(x)) for x in a])
    left.plot(a, horizon, color=plots.INK, label="$r_+$, horizon")
    left.plot(a, curved, color=plots.BLUE, label="$r_K$, K = 0 at the poles")
    left.plot(a, sqrt(3) * a, color=plots.VERMILION, linestyle="--", label=r"$\sqrt{3}\,a$")
    left.axhline(ERGOSPHERE, color=plots.FAINT, linewidth=0.8, label="ergosphere, equator")
    left.fill_between(a, np.maximum(horizon, curved), 2.5, color=plots.PALE)
    left.plot([MEETING], [sqrt(3) * MEETING], color=plots.INK, marker="o", markersize=4)
    left.set_ylim(0, 2.5)
    plots.legend(left, loc="lower right")
    plots.dress(right, "r / m", "E / m", "extreme hole")
    r = [one["r"] for one in energies]
    right.semilogx(
        r, [one["brown_york"] for one in energies], color=plots.BLUE, marker="o", label="Brown-York"
    )
    right.semilogx(
        r,
        [one["wang_yau"] for one in energies],
        color=plots.VERMILION,
        marker="+",
        linestyle="none",
        markersize=9,
        label="least Wang-Yau",
    )
    right.axhline(1.0, color=plots.INK, linewidth=0.8)
    right.set_xticks(r, [f"{x:g}" for x in r])
    right.minorticks_off()
    plots.legend(right)
    return figure
