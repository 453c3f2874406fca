"""The distorted ergosphere (paper, section 3.2): what its epsilon, which is not given, does."""

# ruff: noqa: N806 (R, Sigma, Delta, P as the paper and the field write them)
from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import pi
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from isoembed import Paper
from isoembed.gallery import Ergosphere
from isoembed.metric.curvature import negative_deficits
from reproduction import plots
from reproduction.arrays import Floats
from reproduction.bodies import TOLERANCE, Body, attempted, meshed
from reproduction.mean_curvature import PAPERS
from reproduction.section import Section

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Record = Mapping[str, Any]

SPIN = 0.975  # over the mass, the paper's
THETA = np.linspace(0.0, pi / 2, 2001)
REAL = np.array([0.0, 1e-3, 0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 1.0, 1.5, 2.0, 3.0, 5.0, 10.0])
MAIN = 0.3  # epsilon
SAME = 1e-2  # mean edge lengths: nearer ergospheres are the same to the eye
MORE = (20, 40)  # steps of the pull-back
METHODS: dict[str, str | Paper] = {"paper": Paper(), "default": "aim"}


def study(*, vertices: int, epsilons: Sequence[float]) -> Section:
    """Ergospheres of several epsilons.

    Parameters
    ----------
    vertices : int
        Of each mesh.
    epsilons : sequence of float
        Rising, each from 1e-6 to 1e6.
    """
    threshold, where = convex_from()
    under_root = least_under_root()
    cases = [_case(epsilon, vertices) for epsilon in epsilons]
    errors = [case["percent_error"] for case in cases]
    sizes = np.abs(errors)
    more = {steps: _outcome(_body(MAIN, vertices), Paper(Tsteps=steps)) for steps in MORE}
    return Section.of(
        "ergosphere",
        figures={"ergosphere-epsilon": picture(cases)},
        numbers={
            "convex_from": threshold,
            "theta": where,
            "least_q2": dict(zip(map(str, REAL), under_root, strict=True)),
            "vertices": vertices,
            "cases": cases,
            "more_steps": more,
        },
        rows=[{**case, **{name: _residual(one) for name, one in case["outcomes"].items()}} for case in cases],
        spin=SPIN,
        least_q2=min(under_root),
        least_at=REAL[int(np.argmin(under_root))],
        threshold=threshold,
        degrees=np.degrees(where),
        vertices=vertices,
        tolerance=TOLERANCE,
        main=MAIN,
        tried=len(REAL),
        largest_tried=REAL[-1],
        least_error=min(errors),
        largest_error=max(errors),
        first=epsilons[0],
        last=epsilons[-1],
        some="Some" if sizes.min() <= PAPERS <= sizes.max() else "No",
        successes="; ".join(_successes(cases, name) for name in METHODS),
        further="; ".join(
            f"{steps} steps {'reach' if one['converged'] else 'miss'} the lengths (residual "
            f"{one['residual']:.0e}), {one['distance']:.0e} from the surface"
            for steps, one in more.items()
        ),
    )


def convex_from() -> tuple[float, float]:
    """The epsilon from which on K >= 0 everywhere, and the theta in [0, pi/2] at which K vanishes there."""

    def lowest(epsilon: float) -> tuple[float, float]:
        """The least K M^2 and its theta."""
        k = int(_curvatures(epsilon).argmin())
        found = minimize_scalar(
            lambda theta: float(_curvatures(epsilon, np.array([theta]))[0]),
            bounds=(THETA[max(k - 1, 0)], THETA[min(k + 1, len(THETA) - 1)]),
            method="bounded",
            options={"xatol": 1e-12},
        )
        return float(found.fun), float(found.x)

    epsilon = float(brentq(lambda epsilon: lowest(epsilon)[0], 1.0, 1.5, xtol=1e-12))
    return epsilon, lowest(epsilon)[1]


def least_under_root() -> list[float]:
    """The least q^2 = (h_thth - h_phph,th^2 / (4 h_phph)) / sin^2(theta), in M^2, for each `REAL` epsilon."""
    return [float(_under_root(float(epsilon), np.sin(THETA[1:]) ** 2).min()) for epsilon in REAL]


def _under_root(epsilon: float, s: Floats) -> Floats:
    """q^2 = (h_thth - rho_th^2) / s at s = sin^2(theta), with rho^2 = h_phph = P s, all in units of M."""
    a2 = SPIN**2
    W = np.sqrt((1.0 - a2) + a2 * s)
    R, R_s = 1.0 + W + epsilon, a2 / (2.0 * W)  # Eq. (rtheta); derivatives are in s
    Delta = a2 * s + epsilon * (2.0 * W + epsilon)
    Sigma = R**2 + a2 * (1.0 - s)  # Eq. (sigma)
    w = 2.0 * R / Sigma
    w_s = (2.0 * R_s - w * (2.0 * R * R_s - a2)) / Sigma
    P = R**2 + a2 + a2 * s * w  # Eq. (gpp)
    P_s = 2.0 * R * R_s + a2 * (w + s * w_s)
    # The 0/0 of the poles is divided out: Sigma - P = -a^2 s (1 + w) and R_th^2 = 4 s (1 - s) R_s^2.
    slope = 4.0 * (Sigma * R_s**2 / Delta) - 2.0 * P_s - s * (P_s**2 / P)
    return np.asarray(P - a2 * (1.0 + w) + (1.0 - s) * slope)


def picture(cases: Sequence[Record]) -> Figure:
    """Curvature along the meridian, and how far the methods end from the surface."""
    figure = plots.blank(3.8)
    left, right = figure.subplots(1, 2)
    plots.dress(left, "theta in degrees", "$K\\,M^2$", "Gaussian curvature")
    for epsilon, color in zip((0.1, 0.3, 1.0, 1.5), plots.SERIES, strict=False):
        left.plot(np.degrees(THETA), _curvatures(epsilon), color=color, label=f"epsilon = {epsilon:g}")
    left.axhline(0.0, color=plots.INK, linewidth=0.8)
    left.set_ylim(-0.4, 0.6)
    plots.legend(left)
    plots.dress(right, "epsilon", "distance in mean edge lengths", "from the surface")
    epsilons = np.array([case["epsilon"] for case in cases])
    for name, style in plots.styled(METHODS):
        reached = np.array([case["outcomes"][name]["converged"] for case in cases])
        away = np.array([case["outcomes"][name]["distance"] for case in cases])
        right.loglog(epsilons, away, color=style["color"], linewidth=0.8)
        right.loglog(epsilons[reached], away[reached], label=name, linestyle="none", **style)
        style |= {"markerfacecolor": plots.PAPER, "linestyle": "none"}
        right.loglog(epsilons[~reached], away[~reached], **style)
    plots.legend(right)
    return figure


def _curvatures(epsilon: float, theta: Floats = THETA) -> Floats:
    """K M^2 at the angles."""
    u = np.column_stack([np.sin(theta), np.zeros_like(theta), np.cos(theta)])
    return Ergosphere(epsilon=epsilon, spin=SPIN).gaussian_curvature(u)


def _body(epsilon: float, vertices: int) -> Body:
    return meshed(Ergosphere(epsilon=epsilon, spin=SPIN), vertices)


def _case(epsilon: float, vertices: int) -> dict[str, Any]:
    """Curvatures in units of M, the error of int H dA of the exact vertices, and what each method made."""
    body, K = _body(epsilon, vertices), _curvatures(epsilon)
    return {
        "epsilon": epsilon,
        "K_pole": float(K[0]),
        "K_least": float(K.min()),
        "negative_vertices": int(negative_deficits(body.metric).sum()),
        "percent_error": body.percent_error(body.exact.integrated_mean_curvature),
        "outcomes": {name: _outcome(body, method) for name, method in METHODS.items()},
    }


def _outcome(body: Body, method: str | Paper) -> dict[str, Any]:
    found = attempted(body.metric, method, TOLERANCE)
    return {
        "converged": found.converged,
        "residual": found.residual,
        "distance": found.distance(body.exact),
    }


def _residual(outcome: Record) -> str:
    return f"{outcome['residual']:.0e}" + ("" if outcome["converged"] else ", missed")


def _successes(cases: Sequence[Record], name: str) -> str:
    """How often a method reached the lengths, and the surface."""
    outcomes = [case["outcomes"][name] for case in cases if case["K_least"] < 0]
    reached = [outcome for outcome in outcomes if outcome["converged"]]
    same = sum(outcome["distance"] < SAME for outcome in reached)
    return (
        f"{name}: {len(reached)} of {len(outcomes)} epsilons with K < 0 within {TOLERANCE:.0e}, {same} "
        f"of them less than {SAME:g} mean edge lengths from the surface"
    )
