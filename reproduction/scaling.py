"""Time against the number of vertices, stage by stage, and the steps of the pull-back (paper, figure 8)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from isoembed import Embedding, Paper, embed
from isoembed.gallery import SURFACES
from isoembed.progress.stages import Log, Stage
from reproduction import plots
from reproduction.bodies import SAME, TOLERANCE, attempted, meshed
from reproduction.section import Section, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BODIES = ("ellipsoid", "drum")
RUNS = 3  # of which the fastest counts, stage by stage: whatever else the machine does only adds to the time
WARM = 100  # vertices of what is embedded once before anything is timed, to compile
MOST = 16  # steps that are tried
TOTAL, DEFAULT = "total", "method aim"
FLOWS: Mapping[Literal["RK45", "BDF"], float] = {"RK45": 0.1, "BDF": 1e-3}  # and the epsilon they reach
CUBIC = 3.0

Costs = dict[str, dict[str, float | None]]  # by kind of cost, then by stage
Exponents = Mapping[str, Mapping[str, float | None]]  # of N, by body, then by stage


def study(*, sizes: Sequence[int], flow_sizes: Sequence[int], step_sizes: Sequence[int]) -> Section:
    """Times of the paper's method and the default one, costs of the Ricci flow, and fewest steps.

    Parameters
    ----------
    sizes : sequence of int
        Vertices of the surfaces that are timed, rising; at least two.
    flow_sizes : sequence of int
        Of those on which the Ricci flow is integrated, rising; at least two.  Beyond some 400 an explicit
        integrator takes long.
    step_sizes : sequence of int
        Of those of which the steps are counted, rising.
    """
    for name in BODIES:
        _timed(name, WARM)
        _flowed(name, WARM)
    timed = {name: [_timed(name, n) for n in sizes] for name in BODIES}
    flowed = {name: [_flowed(name, n) for n in flow_sizes] for name in BODIES}
    steps = {name: [fewest_steps(name, n) for n in step_sizes] for name in BODIES}
    seconds = {name: _exponents(sizes, rows, "seconds") for name, rows in timed.items()}
    factorizations = {name: _exponents(sizes, rows, "factorizations") for name, rows in timed.items()}
    evaluations = {name: _exponents(flow_sizes, rows, "evaluations") for name, rows in flowed.items()}
    flow_seconds = {name: _exponents(flow_sizes, rows, "seconds") for name, rows in flowed.items()}
    stages = _stages(timed[BODIES[0]][0]["seconds"])
    steepest = {name: max(stages, key=lambda stage: seconds[name][stage] or 0.0) for name in BODIES}

    def each(exponents: Exponents, key: str, form: str = "N^{} ({})") -> str:
        """The exponents of a stage, by body."""
        return ", ".join(form.format(_digits(exponents[name][key]), name) for name in BODIES)

    def cells(key: str, *columns: Exponents) -> tuple[str, ...]:
        """The exponents of a stage, by body and column, as a row of a table."""
        return key, *(_digits(column[name].get(key)) for name in BODIES for column in columns)

    return Section.of(
        "scaling",
        figures={
            "scaling": _time_figure(sizes, timed),
            "flow-and-steps": _flow_figure(flow_sizes, flowed, step_sizes, steps),
        },
        tables=(
            Table(
                "Exponents of N: seconds, and number of factorizations",
                ("stage", *(f"{name}: {what}" for name in BODIES for what in ("seconds", "factorizations"))),
                tuple(cells(key, seconds, factorizations) for key in (*stages, TOTAL, DEFAULT)),
            ),
            Table(
                "The Ricci flow as a differential equation: exponents of N",
                ("integrator", *(f"{n}: {what}" for n in BODIES for what in ("right-hand sides", "seconds"))),
                tuple(cells(flow, evaluations, flow_seconds) for flow in FLOWS),
            ),
        ),
        numbers={
            "sizes": list(sizes),
            "timed": timed,
            "exponents": {"seconds": seconds, "factorizations": factorizations},
            "flow_sizes": list(flow_sizes),
            "flows": flowed,
            "flow_exponents": {"evaluations": evaluations, "seconds": flow_seconds},
            "step_sizes": list(step_sizes),
            "fewest_steps": steps,
        },
        tolerance=TOLERANCE,
        least=sizes[0],
        most=sizes[-1],
        total_factorizations=" and ".join(
            f"N^{_digits(factorizations[name][TOTAL])} ({name})" for name in BODIES
        ),
        rk45=FLOWS["RK45"],
        bdf=FLOWS["BDF"],
        total=each(seconds, TOTAL),
        default=each(seconds, DEFAULT, "N^{}"),
        uniformize=each(seconds, "uniformize"),
        steepest=", ".join(
            f"{stage} ({name}, N^{_digits(seconds[name][stage])})" for name, stage in steepest.items()
        ),
        rk45_seconds=each(flow_seconds, "RK45"),
        rk45_evaluations=each(evaluations, "RK45", "N^{}"),
        bdf_evaluations=each(evaluations, "BDF", "N^{}"),
        newton=each(factorizations, "uniformize", "N^{}"),
        fewest="; ".join(
            f"{name}: "
            + ", ".join(f"{n or f'> {MOST}'}" for n in steps[name])
            + f" (N^{_digits(_slope(step_sizes, steps[name]))})"
            for name in BODIES
        ),
        counted=", ".join(f"{n:,}" for n in step_sizes),
    )


def _timed(name: str, n: int) -> Costs:
    """Seconds and factorizations of the stages of the paper's method, and of both methods in total."""
    metric = meshed(SURFACES[name](), n).metric
    papers = [_stages_of(embed(metric, method="paper", tolerance=TOLERANCE)) for _ in range(RUNS)]
    defaults = [_stages_of(embed(metric)) for _ in range(RUNS)]
    found: Costs = {}
    for what in ("seconds", "factorizations"):
        costs = {
            stages[0].name: min(getattr(stage, what) for stage in stages)
            for stages in zip(*papers, strict=True)
        }
        least = min(sum(getattr(stage, what) for stage in stages) for stages in defaults)
        found[what] = {**costs, TOTAL: sum(costs.values()), DEFAULT: least}
    return found


def _stages_of(surface: Embedding) -> list[Stage]:
    """The stages without the compilation that some run may have had to do."""
    return [stage for stage in surface.stages if stage.name != "compilation"]


def _flowed(name: str, n: int) -> Costs:
    """Right-hand sides and seconds of the Ricci flow; None where it does not get there."""
    metric = meshed(SURFACES[name](), n).metric.normalized
    found: Costs = {"evaluations": {}, "seconds": {}}
    for flow, epsilon in FLOWS.items():
        method, log = Paper(flow=flow, epsilon=epsilon), Log()
        for _ in range(RUNS):
            with log.stage("uniformize") as recorder:
                arrived = method.uniformize(metric, recorder).converged
        found["evaluations"][flow] = log.stages[0].iterations if arrived else None
        found["seconds"][flow] = min(run.seconds for run in log.stages) if arrived else None
    return found


def fewest_steps(name: str, n: int) -> int | None:
    """Least Tsteps with which the paper's method finds the given surface without its convexity routine.

    It is None if `MOST` are not enough.

    Parameters
    ----------
    name : str
        Of a surface in `isoembed.gallery.SURFACES`.
    n : int
        Number of vertices.
    """
    body = meshed(SURFACES[name](), n)
    for steps in range(1, MOST + 1):
        surface = attempted(body.metric, Paper(Tsteps=steps, convexity="none"), TOLERANCE)
        if surface.converged and surface.distance(body.exact) < SAME:
            return steps
    return None


def _stages(costs: Mapping[str, Any]) -> list[str]:
    return [key for key in costs if key not in (TOTAL, DEFAULT)]


def _exponents(sizes: Sequence[int], rows: Sequence[Mapping[str, Any]], what: str) -> dict[str, float | None]:
    """Slopes of log(cost) over log(N); None for what costs nothing or did not end."""
    return {key: _slope(sizes, [row[what].get(key) for row in rows]) for key in rows[0][what]}


def _slope(sizes: Sequence[int], costs: Sequence[float | None]) -> float | None:
    """Slope of log(cost) over log(N); None if a cost is nothing or not known."""
    if not all(costs):
        return None
    return float(np.polyfit(np.log(sizes), np.log(np.array(costs, dtype=float)), 1)[0])


def _digits(slope: float | None) -> str:
    return "-" if slope is None else f"{round(slope, 2) + 0.0:.2f}"  # no minus before zero


def _time_figure(sizes: Sequence[int], timed: Mapping[str, Any]) -> Figure:
    figure = plots.blank(4.6)
    n = np.array(sizes, dtype=float)
    for axes, (name, rows) in zip(figure.subplots(1, 2, sharey=True), timed.items(), strict=True):
        plots.dress(axes, "vertices N", "seconds" if name == BODIES[0] else "", name)
        styles = [
            *plots.styled(_stages(rows[0]["seconds"])),
            (TOTAL, {"color": plots.INK, "marker": "*"}),
            (DEFAULT, {"color": plots.FAINT, "marker": "x"}),
        ]
        for key, style in styles:
            seconds = [row["seconds"][key] for row in rows]
            axes.loglog(n, seconds, markersize=5, linewidth=1.3, label=key, **style)
        top = rows[-1]["seconds"][TOTAL]
        axes.loglog(n, top * (n / n[-1]) ** CUBIC, ":", color=plots.FAINT, linewidth=1.2)
        plots.mark_sizes(axes, sizes)
    plots.legend_below(figure, axes)
    return figure


def _flow_figure(
    flow_sizes: Sequence[int],
    flowed: Mapping[str, Sequence[Mapping[str, Any]]],
    step_sizes: Sequence[int],
    steps: Mapping[str, Sequence[int | None]],
) -> Figure:
    figure = plots.blank(3.3)
    left, right = figure.subplots(1, 2)
    plots.dress(left, "vertices N", "right-hand sides", "Ricci flow")
    for (name, rows), line in zip(flowed.items(), ("-", "--"), strict=True):
        for flow, style in plots.styled(FLOWS):
            counts = [row["evaluations"][flow] or np.nan for row in rows]
            left.loglog(flow_sizes, counts, line, markersize=5, label=f"{flow}, {name}", **style)
    plots.mark_sizes(left, flow_sizes)
    plots.legend(left)
    plots.dress(right, "vertices N", "fewest steps", "adiabatic pull-back")
    for (name, fewest), style in plots.styled(steps.items()):
        right.semilogx(step_sizes, [count or np.nan for count in fewest], markersize=5, label=name, **style)
    plots.mark_sizes(right, step_sizes)
    right.set_ylim(bottom=0)
    right.yaxis.get_major_locator().set_params(integer=True)
    plots.legend(right)
    return figure
