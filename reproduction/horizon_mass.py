"""The Kijowski-Liu-Yau mass of Kerr horizons beyond Smarr's limit, in hyperbolic space.

M. Dunajski and P. Tod, arXiv:2107.12400; G. W. Gibbons, C. A. R. Herdeiro and C. Rebelo, arXiv:0906.2768.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import pi, sqrt
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from isoembed import InvalidMetric, Space, embed
from isoembed.relativity import KerrNewmanHorizon, smarr_limit
from isoembed.smooth import AxisymmetricEmbedding, embed_smooth, triangulate_metric
from isoembed.space.models import to_model
from isoembed.surface.smooth_integrals import SmoothIntegrals
from reproduction import plots
from reproduction.arrays import Floats
from reproduction.published import Published, rows
from reproduction.section import Section

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LIMIT = sqrt(0.75)  # of the spin over the mass, without charge
PRINTED = {0.0: "2", LIMIT: "1.76569", 1.0: "2.01966"}  # by Dunajski and Tod
GREATEST_AT = "0.99907"  # likewise
CHARGES = (0.0, 0.3, 0.6, 0.8, 0.9)
DRAWN = (0.5, LIMIT, 0.95, 1.0)  # spins of the meridians


@dataclass(frozen=True)
class Horizon:
    """A Kerr-Newman horizon of mass 1 in the least curved space that has it as a surface of revolution.

    Attributes
    ----------
    spin, charge : float
    """

    spin: float
    charge: float = 0.0

    @cached_property
    def surface(self) -> KerrNewmanHorizon:
        """The horizon of the package."""
        return KerrNewmanHorizon(spin=self.spin, charge=self.charge)

    @cached_property
    def space(self) -> Space:
        """Euclidean space up to Smarr's limit, hyperbolic space beyond."""
        k = self.surface.profile().greatest_curvature
        return Space(k if k < -1e-10 else 0.0)

    @cached_property
    def profile(self) -> AxisymmetricEmbedding:
        """The surface of revolution in that space."""
        return self.surface.profile(self.space)

    @property
    def mass(self) -> float:
        """Integral of 2 H dA / 8 pi: on a horizon the mean curvature vector has no length."""
        return self.profile.integrated_mean_curvature / (4 * pi)

    @property
    def pole_curvature(self) -> float:
        """K at the poles, in closed form: (r_+^2 - 3 a^2) / (r_+^2 + a^2)^2."""
        a2 = self.spin**2
        r2 = (1 + sqrt(max(0.0, 1 - a2 - self.charge**2))) ** 2
        return (r2 - 3 * a2) / (r2 + a2) ** 2

    def by_harmonics(self) -> float:
        """The mass by the spectral embedding, which knows of no symmetry."""
        return embed_smooth(self.surface, space=self.space).integrated_mean_curvature / (4 * pi)

    def by_lengths(self, vertices: int) -> tuple[float, float]:
        """The mass of the polyhedron with geodesic lengths: as it is, and corrected for bulges."""
        mesh = triangulate_metric(self.surface, vertices, space=self.space)
        found = embed(mesh.metric)
        behind = SmoothIntegrals(
            found.surface.triangulation, found.vertices, "geodesic", self.space
        ).integrated_mean_curvature
        return found.integrated_mean_curvature / (4 * pi), behind.value / (4 * pi)


def study(*, spins: Sequence[float], charged: int, vertices: int) -> Section:
    """The mass against the spin, where it is greatest, and which charged horizons need how much curvature.

    Parameters
    ----------
    spins : sequence of float
        Of the horizons that are embedded from their edge lengths.
    charged : int
        Spins and charges on each side of the grid on which every Kerr-Newman horizon is embedded.
    vertices : int
        Of each polyhedron.
    """
    peak, (place, height) = greatest(), greatest_by_quadrature()
    numbers = [
        *(_printed(spin) for spin in PRINTED),
        Published(
            "spin of the greatest mass",
            GREATEST_AT,
            peak.spin,
            1e-7,
            place,
            "quadrature of the closed form",
        ),
        Published("greatest mass", "", peak.mass, 1e-10, height, "quadrature of the closed form"),
        Published(
            "least curvature of space, spin 1",
            "",
            Horizon(1.0).surface.profile().greatest_curvature,
            1e-10,
            Horizon(1.0).pole_curvature,
            "K at the poles, closed form",
        ),
    ]
    curve = mass_curve()
    polyhedra = [{"spin": spin, **_polyhedron(spin, vertices)} for spin in spins]
    grid = embedded_grid(charged)
    cone = static_pair(1.0)
    return Section.of(
        "horizon-mass",
        figures={"horizon-mass": picture(curve, polyhedra, peak)},
        numbers={
            "published": [number.numbers for number in numbers],
            "curve": curve.tolist(),
            "polyhedra": polyhedra,
            "charged": grid,
            "static_pair": cone,
        },
        rows=rows(numbers),
        polyhedra=polyhedra,
        charges=[_charged(charge) for charge in CHARGES],
        at_limit=numbers[1],
        extreme=numbers[2],
        place=numbers[3],
        peak=peak,
        turns=turns(curve),
        vertices=vertices,
        grid=grid,
        cone=cone,
        off=max(abs(one["corrected"] - one["mass"]) for one in polyhedra),
    )


def greatest() -> Horizon:
    """The horizon without charge whose mass beyond Smarr's limit is greatest."""
    found = minimize_scalar(
        lambda spin: -Horizon(float(spin)).mass, bounds=(0.99, 1.0), method="bounded", options={"xatol": 1e-9}
    )
    return Horizon(float(found.x))


def greatest_by_quadrature() -> tuple[float, float]:
    """The spin of the greatest mass, and that mass, by `mass_by_quadrature`."""
    found = minimize_scalar(
        lambda spin: -mass_by_quadrature(float(spin)),
        bounds=(0.99, 1.0),
        method="bounded",
        options={"xatol": 1e-10},
    )
    return float(found.x), -float(found.fun)


def mass_by_quadrature(a: float) -> float:
    """The mass beyond Smarr's limit from the closed form of the principal curvatures.

    On the horizon dA = A sin(theta) dtheta dphi, A = r_+^2 + a^2, and with x = cos(theta) and the curvature
    -kappa = K(x = 1) of space, k_phi = sqrt(G) / A, k_theta = (K + kappa) / k_phi, Sigma = r_+^2 + a^2 x^2,

        K = A (r_+^2 - 3 a^2 x^2) / Sigma^3,
        G = [A^4 - a^2 (Sigma + A)(Sigma^2 + A^2)] / Sigma^3 + kappa A^2.
    """
    r2 = (1 + sqrt(1 - a * a)) ** 2
    A = r2 + a * a
    kappa = (3 * a * a - r2) / A**2
    nodes, weights = np.polynomial.legendre.leggauss(200)
    theta = pi / 4 * (1 + nodes)  # to the equator: sqrt(G) vanishes like sin(theta) at the pole
    x = np.cos(theta)
    Sigma = r2 + a * a * x * x
    K = A * (r2 - 3 * a * a * x * x) / Sigma**3
    G = (A**4 - a * a * (Sigma + A) * (Sigma**2 + A**2)) / Sigma**3 + kappa * A**2
    k = np.sqrt(G) / A + (K + kappa) * A / np.sqrt(G)
    return float(pi / 4 * weights @ (k * A * np.sin(theta))) / 2


def _printed(spin: float) -> Published:
    horizon = Horizon(spin)
    name = {0.0: "0", LIMIT: "sqrt(3)/2"}.get(spin, f"{spin:g}")
    return Published(
        f"mass, spin {name}", PRINTED[spin], horizon.mass, 1e-10, horizon.by_harmonics(), "harmonics"
    )


def mass_curve() -> Floats:
    """Spins and masses, (n, 2), dense where the mass turns."""
    slow, fast = np.linspace(0, LIMIT, 20), np.linspace(LIMIT, 0.99, 20)
    spins = np.concatenate([slow, fast[1:], 1 - np.geomspace(0.01, 1e-5, 30)[1:], [1.0]])
    return np.array([(spin, Horizon(float(spin)).mass) for spin in spins])


def turns(curve: Floats) -> list[float]:
    """The spins at which the mass changes from falling to rising or back."""
    rising = np.diff(curve[:, 1]) > 0
    return [float(curve[i + 1, 0]) for i in np.flatnonzero(rising[1:] != rising[:-1])]


def _polyhedron(spin: float, vertices: int) -> dict[str, float]:
    horizon = Horizon(spin)
    plain, corrected = horizon.by_lengths(vertices)
    return {
        "curvature": horizon.space.curvature,
        "mass": horizon.mass,
        "polyhedron": plain,
        "corrected": corrected,
    }


def _charged(charge: float) -> dict[str, float]:
    """Smarr's limit at a charge, by the package and in closed form, and the horizon of the largest spin."""
    most = sqrt(1 - charge**2)
    extreme = Horizon(most, charge)
    crossing = sqrt(1 - charge**2) if extreme.pole_curvature >= 0 else _smarr(charge)
    return {
        "charge": charge,
        "limit": smarr_limit(1.0, charge),
        "closed": crossing,
        "spin": most,
        "curvature": extreme.space.curvature,
        "pole": extreme.pole_curvature,
        "mass": extreme.mass,
    }


def _smarr(charge: float) -> float:
    """The spin at which r_+ = sqrt(3) a."""
    most = sqrt(1 - charge**2)
    return float(brentq(lambda a: 1 + sqrt(max(0.0, most**2 - a * a)) - sqrt(3) * a, 0.0, most, xtol=1e-15))


def embedded_grid(n: int) -> dict[str, Any]:
    """How many horizons of n spins and n charges, up to extreme ones, are surfaces of revolution in H^3."""
    made, euclidean, largest = 0, 0, 0.0
    for angle in np.linspace(0, pi / 2, n):  # of (spin, charge)
        for size in np.linspace(1 / n, 1, n):
            horizon = Horizon(float(size * np.sin(angle)), float(size * np.cos(angle)))
            made += horizon.profile.embeds
            euclidean += horizon.space.is_euclidean
            largest = max(largest, -horizon.space.curvature)
    return {"horizons": n * n, "embedded": made, "euclidean": euclidean, "most_curved": largest}


def static_pair(gap: float) -> dict[str, Any]:
    """One horizon of two equal static holes that a strut holds apart: a metric with a cone at a pole.

    Bach and Weyl's solution, rods of length 2 at a distance `gap` on the axis of Weyl's coordinates: on the
    rod from z1 to z2, with the other from z3 to z4,

        q_pp = 4 (z2 - z)(z - z1)(z4 - z) / (z3 - z),    q_zz q_pp = 1 / kappa^2,

    kappa being the surface gravity, for which the outer pole z1 is smooth.

    Returns
    -------
    dict
        The refusal of the package, the ratio q_tt sin^2 / q_pp that it names, and the same in closed form.
    """
    z1, z2, z3, z4 = -1.0, 1.0, 1.0 + gap, 3.0 + gap
    outer = 4 * (z2 - z1) * (z4 - z1) / (z3 - z1)  # slope of q_pp in z
    inner = 4 * (z2 - z1) * (z4 - z2) / (z3 - z2)
    kappa = 2 / outer

    def stretch(theta: Floats) -> Floats:
        z = -np.cos(theta)
        return np.asarray((z4 - z) / (z3 - z))

    try:
        AxisymmetricEmbedding.from_components(
            lambda theta: 1 / (4 * kappa**2 * stretch(theta)),
            lambda theta: 4 * np.sin(theta) ** 2 * stretch(theta),
        )
    except InvalidMetric as error:
        refusal = str(error)
    else:
        refusal = ""
    return {"gap": gap, "refusal": refusal, "ratio": (outer / inner) ** 2, "angle": inner / outer}


def picture(curve: Floats, polyhedra: Sequence[dict[str, float]], peak: Horizon) -> Figure:
    """The mass against the spin, and meridians in Poincare's ball."""
    figure = plots.blank(3.9)
    left, right = figure.subplots(1, 2)
    plots.dress(left, "spin $j = J / m^2$", "mass / m", "Kijowski-Liu-Yau mass of the horizon")
    left.plot(curve[:, 0], curve[:, 1], color=plots.BLUE, label="surface of revolution")
    spins = [one["spin"] for one in polyhedra]
    left.plot(
        spins,
        [one["corrected"] for one in polyhedra],
        color=plots.VERMILION,
        marker="o",
        markersize=4,
        linestyle="none",
        label="polyhedra, from lengths",
    )
    left.axvline(LIMIT, color=plots.STONE, linewidth=0.8)
    plots.note(left, "R$^3$ ends", (LIMIT, 2.0), (-50, 0))
    plots.legend(left, loc="lower left")
    _inset(left.inset_axes((0.12, 0.28, 0.4, 0.27)), curve, peak)
    plots.dress(right, "distance from the axis / m", "along the axis / m", "meridians, Poincare's ball")
    for spin, color in zip(DRAWN, plots.SERIES, strict=False):
        rho, z = meridian(Horizon(spin))
        right.plot(rho, z, color=color, label=f"j = {spin:.3g}")
    right.set_aspect("equal")
    plots.legend(right, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    return figure


def _inset(axes: Axes, curve: Floats, peak: Horizon) -> None:
    near = curve[curve[:, 0] >= 0.997]
    axes.plot(near[:, 0], near[:, 1], color=plots.BLUE)
    axes.plot([peak.spin], [peak.mass], color=plots.INK, marker="+")
    axes.tick_params(labelsize=7, colors=plots.INK)
    axes.set_xticks([0.997, 1.0])
    axes.set_yticks([2.02, 2.022])


def meridian(horizon: Horizon) -> tuple[Floats, Floats]:
    """Distance from the axis and height (n,) of a horizon's meridian, conformal coordinates."""
    theta = np.linspace(0, pi, 200)
    u = np.column_stack([np.sin(theta), np.zeros_like(theta), np.cos(theta)])
    points = to_model(horizon.space, horizon.profile.points(u), "conformal")
    return points[:, 0], points[:, 2]
