"""The guided adiabatic pull-back: what guides it, and along which path (paper, section 2.3, figure 5)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from isoembed import Embedding, InvalidMetric, Paper, PolyhedralMetric
from isoembed.aim.anneal import Annealed
from isoembed.aim.uniformize import Uniformization
from isoembed.gallery import SURFACES
from isoembed.metric.curvature import deficits, gaussian_curvature
from isoembed.progress.stages import Log, Progress
from isoembed.surface.alignment import aligned
from isoembed.surface.measures import edge_lengths
from isoembed.surface.rigidity import LengthSystem, length_residuals
from reproduction import plots
from reproduction.arrays import Floats
from reproduction.bodies import SAME, TOLERANCE, attempted, meshed
from reproduction.section import Section, listed

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Record = Mapping[str, Any]

ROUTINES: dict[Literal["corrected", "printed", "none"], str] = {
    "corrected": "corrected",
    "printed": "as printed",
    "none": "no routine",
}
PATHS: tuple[tuple[Literal["linear", "exponential", "flow"], float], ...] = (
    ("linear", 0.1),
    ("exponential", 0.1),
    ("exponential", 0.3),
    ("flow", 0.1),
)
"""With alpha."""
COMPARED = 10  # steps of every path
TRIED = (1, 2, 3, 4, 5, 6, 8, COMPARED, 12)  # Tsteps


@dataclass(frozen=True)
class _Start:
    """The uniform surface, smooth, and the Ricci flow that led to its metric."""

    metric: PolyhedralMetric
    uniform: Uniformization
    system: LengthSystem
    vertices: Floats
    given: Floats


@dataclass(frozen=True)
class _Way:
    """One pull-back."""

    arrived: bool  # whether its end is the surface that the lengths are from
    iterations: int  # of Newton's method
    guesses: list[tuple[float, float]]  # residuals of the guess and of the surface before, in the new lengths


def study(*, cases: Sequence[tuple[str, int, int]], path_vertices: int) -> Section:
    """Crumpled vertices on the way down to t = 0, and a comparison of the paths.

    Parameters
    ----------
    cases : sequence of (str, int, int)
        Surface (a name of `isoembed.gallery.SURFACES`), vertices and Tsteps.
    path_vertices : int
        Of the ellipsoid and the drum on which the paths are compared.
    """
    followed = [_followed(*case) for case in cases]
    paths = {name: _compared(_start(name, path_vertices)) for name in ("ellipsoid", "drum")}
    starts, annealed, ends = (
        {key: sum(case["routines"][key]["crumpled"][place] for case in followed) for key in ROUTINES}
        for place in (0, 1, -1)
    )
    bodies = [{"name": name, **found, **found["extrapolation"]} for name, found in paths.items()]
    off = " and ".join(
        f"{case['routines']['corrected']['off']:.1g} mean edges ({case['surface']}, N = {case['vertices']:,})"
        for case in followed
    )
    by_path = list(zip(*(body["paths"] for body in bodies), strict=True))
    apart = max(
        abs(row["iterations"] - linear["iterations"])
        for linear, *others in (body["paths"] for body in bodies)
        for row in others
        if row["name"].startswith("exponential")
    )
    return Section.of(
        "guided-pull-back",
        figures={"guided-pull-back": _followed_figure(followed), "paths": _guess_figure(bodies)},
        numbers={"pull_backs": followed, "paths": paths},
        tried=", ".join(map(str, TRIED)),
        rows=[
            {"surface": body["name"], "leading": ", ".join(map(str, row["arrived"])) or "none", **row}
            for body in bodies
            for row in body["paths"]
        ],
        starts=starts,
        ends=ends,
        off=off,
        compared=COMPARED,
        path_vertices=path_vertices,
        counts="; ".join(f"{word} {starts[k]}, {annealed[k]}, {ends[k]}" for k, word in ROUTINES.items()),
        costs="; ".join(map(_sentence, by_path)),
        apart=apart,
        longest="; ".join(
            f"{rows[0]['name']}: " + ", ".join(f"{row['longest']:.2f}" for row in rows) for rows in by_path
        ),
        rates=listed("{name}: deficits {rates[deficits]:.2f}, K {rates[curvature]:.1f}", bodies),
        factors=", ".join(f"{body['factor']:.0f} ({body['name']})" for body in bodies),
        savings=", ".join(f"{body['iterations']} instead of {body['without']}" for body in bodies),
    )


def _sentence(rows: Sequence[Record]) -> str:
    """Fewest steps and iterations of one path, on one surface after another."""
    fewest = ", ".join(str(row["arrived"][0]) if row["arrived"] else f"> {TRIED[-1]}" for row in rows)
    iterations = ", ".join(str(row["iterations"]) for row in rows)
    return f"{rows[0]['name']}: {fewest} steps, {iterations} iterations"


def _followed(name: str, n: int, steps: int) -> dict[str, Any]:
    """Crumpled vertices and concave edges at every step, for each routine."""
    body = meshed(SURFACES[name](), n)
    found: dict[str, Any] = {
        "surface": name,
        "vertices": n,
        "steps": steps,
        "concave_given": int(body.exact.surface.concave_edges.sum()),
        "routines": {},
    }
    for routine in ROUTINES:
        seen: list[Progress] = []
        method = Paper(sphere=False, convexity=routine, Tsteps=steps)
        surface = attempted(body.metric, method, TOLERANCE, seen.append)
        shown = [(p, p.vertices) for p in seen if p.vertices is not None and p.inverted is not None]
        found["routines"][routine] = {
            "t": [p.t for p, _ in shown],
            "crumpled": [(p.inverted or 0) + (p.partially_inverted or 0) for p, _ in shown],
            "concave": [_concave(body.metric, x) for _, x in shown],
            "residual": surface.residual,
            "off": surface.distance(body.exact),
        }
    return found


def _concave(metric: PolyhedralMetric, vertices: Floats) -> int:
    """Number of concave edges of a surface of any lengths, in the unit of ``metric.normalized``."""
    lengths = edge_lengths(metric.edges, vertices)
    surface = Embedding(metric.with_lengths(lengths), vertices, method="shown", tolerance=TOLERANCE)
    return int(surface.surface.concave_edges.sum())


def _start(name: str, n: int) -> _Start:
    """The uniform surface of the Ricci flow, spherical fit included."""
    body = meshed(SURFACES[name](), n)
    metric = body.metric.normalized
    method, system = Paper(flow="BDF"), LengthSystem(metric.triangulation)
    with Log().stage("start") as recorder:
        uniform = method.uniformize(metric, recorder)
        tree = method.embed_on_sphere(uniform, recorder)
        vertices = method.anneal_on_sphere(uniform, tree.vertices, recorder)
        annealed = method.anneal(system, vertices, uniform.metric.lengths, TOLERANCE, recorder)
    return _Start(metric, uniform, system, annealed.vertices, body.vertices / body.metric.unit)


def _pulled(start: _Start, method: Paper, extrapolate: bool = True) -> _Way:
    """Pull back without the convexity routine."""
    triangulation = start.metric.triangulation
    guesses: list[tuple[float, float]] = []
    reached = [Annealed(start.vertices, 0.0, True)]

    def relax(guess: Floats, t: float) -> Annealed:
        before = reached[-1].vertices
        try:
            lengths = method.on_path(start.metric, start.uniform, t).lengths
        except InvalidMetric:  # between two metrics, but none itself
            return Annealed(guess, np.inf, False)
        first, last = (np.abs(length_residuals(triangulation, x, lengths)).max() for x in (guess, before))
        guesses.append((float(first), float(last)))
        found = method.anneal(start.system, guess if extrapolate else before, lengths, TOLERANCE, recorder)
        reached.append(found)
        return found

    with Log().stage("pull back") as recorder:
        *_, (_, end) = method.pull_back(start.vertices, relax)
    away = np.linalg.norm(aligned(end.vertices, start.given) - start.given, axis=1)
    off = away.max() / start.metric.mean_length
    return _Way(off < SAME, recorder.iterations, guesses)


def _compared(start: _Start) -> dict[str, Any]:
    """All paths, and what extrapolation is worth on the linear one."""
    ways = {
        (path, alpha): {
            steps: _pulled(start, Paper(flow="BDF", path=path, alpha=alpha, Tsteps=steps)) for steps in TRIED
        }
        for path, alpha in PATHS
    }
    linear = ways[PATHS[0]][COMPARED]
    later = np.array(linear.guesses[3:])  # j > 3
    return {
        "paths": [
            {
                "name": f"{path}, alpha = {alpha}" if path == "exponential" else path,
                "arrived": [steps for steps, way in found.items() if way.arrived],
                "iterations": found[COMPARED].iterations,
                "longest": max(before for _, before in found[COMPARED].guesses),
            }
            for (path, alpha), found in ways.items()
        ],
        "rates": {
            "deficits": _unevenness(start, deficits),
            "curvature": _unevenness(start, gaussian_curvature),
        },
        "extrapolation": {
            "guesses": linear.guesses,
            "factor": float(np.median(later[:, 1] / later[:, 0])),
            "iterations": linear.iterations,
            "without": _pulled(start, Paper(Tsteps=COMPARED), extrapolate=False).iterations,
        },
    }


def _unevenness(start: _Start, quantity: Callable[[PolyhedralMetric], Floats]) -> float:
    """The largest over the smallest change of a quantity, as a vector, in a step of the linear path."""
    times = 1 - np.arange(COMPARED + 1) / COMPARED
    values = np.array([quantity(Paper().on_path(start.metric, start.uniform, t)) for t in times])
    changes = np.linalg.norm(np.diff(values, axis=0), axis=1)
    return float(changes.max() / changes.min())


def _followed_figure(followed: Sequence[Record]) -> Figure:
    figure = plots.blank(5.0)
    rows = figure.subplots(2, len(followed), squeeze=False, sharex=True)
    for k, case in enumerate(followed):
        above, below = rows[:, k]
        title = f"{case['surface']}, N = {case['vertices']:,}, {case['steps']} steps"
        plots.dress(above, "", "crumpled vertices" if k == 0 else "", title)
        plots.dress(below, "$t / t_f$", "concave edges" if k == 0 else "")
        for (routine, word), style in plots.styled(ROUTINES.items()):
            way = case["routines"][routine]
            style |= {"linewidth": 1.3, "markersize": 4.0}
            if routine == "printed":  # under the next curve where it is the same
                style |= {"markersize": 8.0, "fillstyle": "none"}
            above.plot(way["t"], way["crumpled"], label=word, **style)
            below.plot(way["t"], way["concave"], **style)
        diamond = {"color": plots.INK, "markersize": 8, "fillstyle": "none", "clip_on": False}
        below.plot(0, case["concave_given"], "D", **diamond)
        above.set_ylim(bottom=-0.5)
        above.set_xlim(1.03, -0.03)
    plots.legend(rows[0, 0])
    return figure


def _guess_figure(bodies: Sequence[Record]) -> Figure:
    figure = plots.blank(3.2)
    for axes, body in zip(figure.subplots(1, len(bodies), sharey=True), bodies, strict=True):
        guess, before = np.array(body["guesses"]).T
        j = np.arange(1, len(guess) + 1)
        plots.dress(axes, "step j", "residual of the guess" if body is bodies[0] else "", body["name"])
        axes.semilogy(j, before, "s-", color=plots.VERMILION, label="the surface before", markersize=5)
        axes.semilogy(j, guess, "o-", color=plots.BLUE, label="extrapolated from j = 4 on", markersize=5)
    plots.legend(axes)
    return figure
