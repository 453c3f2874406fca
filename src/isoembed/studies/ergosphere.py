"""The distorted ergosphere (paper, section 3.2): what its epsilon, which is not given, does."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq, minimize_scalar

from isoembed._embed import Method
from isoembed.aim.paper import Paper
from isoembed.gallery import Ergosphere, triangulate
from isoembed.gallery.kerr import ergosphere_radius, squares
from isoembed.metric.curvature import negative_deficits
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.studies import plots
from isoembed.studies.bodies import attempted
from isoembed.studies.mean_curvature import PAPERS
from isoembed.studies.section import Comparison, Illustration, Section, Table
from isoembed.surface.embedding import Embedding

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]

SPIN = 0.975  # over the mass, the paper's
THETA = np.linspace(0.0, pi / 2, 2001)
REAL = np.array([0.0, 1e-3, 0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 1.0, 1.5, 2.0, 3.0, 5.0, 10.0])
MAIN = 0.3  # epsilon
MORE = (20, 40)  # steps of the pull-back
TOLERANCE = 1e-6  # the paper's
SAME = 1e-2  # mean edge lengths from the discarded coordinates: the same surface to the eye
METHODS: dict[str, str | Method] = {"paper": Paper(), "default": "aim"}


@dataclass(frozen=True)
class Outcome:
    """What a method made of the lengths of one ergosphere.

    Attributes
    ----------
    converged : bool
        Within 1e-6.
    residual : float
    distance : float
        From the vertices that were thrown away, in mean edge lengths.
    """

    converged: bool
    residual: float
    distance: float


@dataclass(frozen=True)
class Case:
    """One epsilon.

    Attributes
    ----------
    epsilon : float
    pole : float
        Gaussian curvature at the poles, in units of M.
    least : float
        The least Gaussian curvature.
    percent : float
        Error of int H dA of the vertices that the lengths were taken from.
    negative : int
        Vertices with negative curvature.
    outcomes : dict of str to Outcome
        By method.
    """

    epsilon: float
    pole: float
    least: float
    percent: float
    negative: int
    outcomes: dict[str, Outcome]


def study(*, vertices: int, epsilons: Sequence[float]) -> Section:
    """Vary epsilon.

    Parameters
    ----------
    vertices : int
        Of each mesh.
    epsilons : sequence of float
        Rising, each from 1e-6 to 1e6.

    Returns
    -------
    Section
    """
    threshold, where = convex_from()
    under_root = least_under_root()
    cases = [_case(epsilon, vertices) for epsilon in epsilons]
    errors = [case.percent for case in cases]
    sizes = np.abs(errors)
    main = _exact(MAIN, vertices)
    more = {steps: _outcome(main, Paper(Tsteps=steps)) for steps in MORE}
    return Section(
        title="The ergosphere and its epsilon",
        text=(
            "The surface r = r_ergo(theta) + epsilon M of the paper depends on epsilon, which is not given, "
            f"and which no condition in the text fixes. With a = {SPIN} M the functions rho and f of the "
            "embedding are real for every epsilon tried, 0 included: under the root of f stands h_thth - "
            f"h_phph,th^2 / (4 h_phph) = sin^2(theta) q^2, and the least q^2 is {min(under_root):.2f} M^2 "
            f"(at epsilon = {REAL[int(np.argmin(under_root))]:g}).",
            f"K is not negative anywhere from epsilon = {threshold:.7f} on; there it vanishes at theta = "
            f"{np.degrees(where):.1f} degrees and its mirror image. Below, two bands have K < 0, as the "
            "paper says its surface does. The smaller epsilon, the sharper the poles: at 0 they are cones.",
            f"The table embeds meshes of {vertices:,} vertices to {TOLERANCE:.0e}, with the paper's method "
            "(10 steps, the corrected convexity routine, the start fitted to the sphere) and with the "
            "default one. Where K < 0 the lengths may have several realizations close to each other, so the "
            f"distance from the discarded vertices is measured, too. epsilon = {MAIN:g} is the main case of "
            "this report.",
        ),
        figures=(
            Illustration(
                "ergosphere-epsilon",
                "Left: Gaussian curvature from pole to equator, in units of the mass. Right: distance of the "
                "embedded vertices from the discarded ones; open: the lengths were missed.",
                picture(cases),
            ),
        ),
        comparisons=(
            Comparison(
                "epsilon of the ergosphere, Eq. (28)",
                "a small parameter, not given",
                f"K >= 0 everywhere iff epsilon >= {threshold:.4f}; {MAIN:g} is used here",
                "The paper's surface has regions of negative curvature, so its epsilon is below that. "
                "Nothing else in the text fixes it.",
            ),
            Comparison(
                "f(theta) is real on [0, pi], Eq. (34)",
                "stated for its epsilon",
                f"q^2 >= {min(under_root):.2f} M^2 > 0 for {len(REAL)} values of epsilon from 0 to "
                f"{REAL[-1]:g}",
            ),
            Comparison(
                "Error of int H dA of the ergosphere (section 3.2) against epsilon",
                "0.62 % for its epsilon and resolution",
                f"{min(errors):+.2f} % to {max(errors):+.2f} % at {vertices:,} vertices, epsilon from "
                f"{epsilons[0]:g} to {epsilons[-1]:g}",
                f"{'Some' if sizes.min() <= PAPERS <= sizes.max() else 'No'} epsilon of these accounts for "
                "it at this resolution; the paper's resolution is not given either.",
            ),
            Comparison(
                "AIM embeds surfaces with regions of K < 0 (abstract, section 3.2)",
                "one case, residuals within 1e-6",
                "; ".join(_successes(cases, name) for name in METHODS),
                "Where K < 0 the pull-back may lose the surface or lead to a nearby realization. More steps "
                f"at epsilon = {MAIN:g}: "
                + "; ".join(
                    f"{steps} steps {'reach' if outcome.converged else 'miss'} the lengths (residual "
                    f"{outcome.residual:.0e}), {outcome.distance:.0e} from the surface"
                    for steps, outcome in more.items()
                )
                + ".",
            ),
        ),
        tables=(
            Table(
                f"Ergospheres at {vertices:,} vertices. Distances from the discarded vertices, in mean edge "
                "lengths",
                (
                    "epsilon",
                    "K at the poles",
                    "least K",
                    "vertices with K < 0",
                    "error of int H dA",
                    *(f"{name}: {what}" for name in METHODS for what in ("residual", "distance")),
                ),
                tuple(_row(case) for case in cases),
            ),
        ),
        numbers={
            "convex_from": threshold,
            "theta": where,
            "least_q2": dict(zip(map(str, REAL), under_root, strict=True)),
            "vertices": vertices,
            "cases": [_numbers(case) for case in cases],
            "more_steps": {str(steps): vars(outcome) for steps, outcome in more.items()},
        },
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
    s = np.sin(THETA[1:]) ** 2
    return [
        float(squares(ergosphere_radius(float(epsilon), SPIN, 0.0, s), SPIN, 0.0, s).q2.min())
        for epsilon in REAL
    ]


def picture(cases: Sequence[Case]) -> Figure:
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
    epsilons = np.array([case.epsilon for case in cases])
    for name, color, marker in zip(METHODS, plots.SERIES, plots.MARKERS, strict=False):
        outcomes = [case.outcomes[name] for case in cases]
        reached = np.array([outcome.converged for outcome in outcomes])
        away = np.array([outcome.distance for outcome in outcomes])
        right.loglog(epsilons, away, color=color, linewidth=0.8)
        right.loglog(epsilons[reached], away[reached], marker, color=color, label=name)
        right.loglog(epsilons[~reached], away[~reached], marker, color=color, markerfacecolor=plots.PAPER)
    plots.legend(right)
    return figure


def _curvatures(epsilon: float, theta: Floats = THETA) -> Floats:
    """K M^2 at the angles."""
    u = np.column_stack([np.sin(theta), np.zeros_like(theta), np.cos(theta)])
    return Ergosphere(epsilon=epsilon, spin=SPIN).gaussian_curvature(u)


def _case(epsilon: float, vertices: int) -> Case:
    exact, K = _exact(epsilon, vertices), _curvatures(epsilon)
    integral = Ergosphere(epsilon=epsilon, spin=SPIN).integrated_mean_curvature
    return Case(
        epsilon,
        float(K[0]),
        float(K.min()),
        100 * (exact.integrated_mean_curvature / integral - 1),
        int(negative_deficits(exact.metric).sum()),
        {name: _outcome(exact, method) for name, method in METHODS.items()},
    )


def _exact(epsilon: float, vertices: int) -> Embedding:
    points, faces = triangulate(Ergosphere(epsilon=epsilon, spin=SPIN), vertices)
    return Embedding(PolyhedralMetric.from_mesh(points, faces), points, method="exact", tolerance=TOLERANCE)


def _outcome(exact: Embedding, method: str | Method) -> Outcome:
    found = attempted(exact.metric, method, TOLERANCE)
    return Outcome(found.converged, found.residual, found.distance(exact))


def _successes(cases: Sequence[Case], name: str) -> str:
    """How often a method reached the lengths, and the surface."""
    outcomes = [case.outcomes[name] for case in cases if case.least < 0]
    reached = sum(outcome.converged for outcome in outcomes)
    same = sum(outcome.converged and outcome.distance < SAME for outcome in outcomes)
    return (
        f"{name}: {reached} of {len(outcomes)} epsilons with K < 0 within {TOLERANCE:.0e}, {same} of them "
        f"less than {SAME:g} mean edge lengths from the surface"
    )


def _row(case: Case) -> tuple[str, ...]:
    return (
        f"{case.epsilon:g}",
        f"{case.pole:.3g}",
        f"{case.least:.3f}",
        str(case.negative),
        f"{case.percent:+.3f} %",
        *(
            text
            for outcome in case.outcomes.values()
            for text in (
                f"{outcome.residual:.0e}" + ("" if outcome.converged else ", missed"),
                f"{outcome.distance:.0e}",
            )
        ),
    )


def _numbers(case: Case) -> dict[str, Any]:
    return {
        "epsilon": case.epsilon,
        "K_pole": case.pole,
        "K_least": case.least,
        "negative_vertices": case.negative,
        "percent_error": case.percent,
        "outcomes": {name: vars(outcome) for name, outcome in case.outcomes.items()},
    }
