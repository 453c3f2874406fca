"""The paper's two open wishes: a bound on the deviation of equivalent embeddings, and parallel run times."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from isoembed import NotEmbedded, PolyhedralMetric, compare, embed, realizations
from isoembed.gallery import CassiniPeanut, Ergosphere, HarmonicSurface, Surface, triangulate
from isoembed.runs import Workers
from reproduction import plots
from reproduction.arrays import Floats
from reproduction.section import Section

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SURFACES: dict[str, Surface] = {
    "trefoil": HarmonicSurface(degree=3, order=3, amplitude=0.3),
    "saddle": HarmonicSurface(degree=2, order=2, amplitude=0.35),
    "ergosphere 0.1": Ergosphere(epsilon=0.1),
    "peanut": CassiniPeanut(),
}
DIFFERENT = 1e-6  # mean edge lengths: nearer surfaces are one


@dataclass(frozen=True)
class Pair:
    """The differences of two realizations of a metric, with proven errors.

    Attributes
    ----------
    surface : str
    vertices : int
    distance : float
        The largest of a vertex, in mean edge lengths.
    angle, angle_error : float
        The largest difference of a dihedral angle, in radians.
    mean_curvature, mean_curvature_error : float
        The difference of int H dA, over int H dA.
    proven : bool
        Whether these are proven to be two exact surfaces with the same lengths, and the errors are.
    """

    surface: str
    vertices: int
    distance: float
    angle: float
    angle_error: float
    mean_curvature: float
    mean_curvature_error: float
    proven: bool


def study(*, sizes: Sequence[int], seeds: Sequence[int | None], parallel: int, batch: int) -> Section:
    """Pairs of realizations, and the seconds of a batch by one and two processes.

    Parameters
    ----------
    sizes : sequence of int
        Vertices of each mesh.
    seeds : sequence of int or None
        Of irregular meshes; None for the regular one.
    parallel, batch : int
        Vertices of each ellipsoid of the batch, and how many.
    """
    pairs: list[Pair] = []
    missed = 0
    for n in sizes:
        for name, surface in SURFACES.items():
            for seed in seeds:
                metric = PolyhedralMetric.from_mesh(*triangulate(surface, n, irregular=seed))
                try:
                    pairs += of_metric(name, metric)
                except NotEmbedded:
                    missed += 1
    distance, mean, angle = np.abs([[p.distance, p.mean_curvature, p.angle] for p in pairs]).T
    power = float(np.polyfit(np.log(distance), np.log(mean), 1)[0])
    runs = run_times(parallel, batch)
    groups = [_group(pairs, name, n) for n in sizes for name in SURFACES]
    return Section.of(
        "equivalent",
        figures={"equivalent": picture(pairs)},
        numbers={
            "pairs": [vars(pair) for pair in pairs],
            "power": power,
            "missed": missed,
            "seconds": runs,
        },
        rows=[group for group in groups if group["pairs"]],
        count=len(pairs),
        proven=sum(pair.proven for pair in pairs),
        metrics=len(sizes) * len(SURFACES) * len(seeds),
        missed=missed,
        farthest=distance.max(),
        turned=angle.max(),
        ratio=(angle / distance).max(),
        deviation=mean.max(),
        constant=(mean / distance**3).max(),
        power=power,
        error=max((pair.mean_curvature_error for pair in pairs if pair.proven), default=np.inf),
        runs=runs,
        parallel=parallel,
        batch=batch,
    )


def of_metric(name: str, metric: PolyhedralMetric) -> list[Pair]:
    """The realization that the default method finds, paired with each of those that are found near it."""
    found = embed(metric)
    pairs = []
    for other in realizations(found, surfaces=1).surfaces:
        difference = compare(found, other)
        if difference.distance > DIFFERENT:
            scale = found.integrated_mean_curvature
            pairs.append(
                Pair(
                    name,
                    len(found.vertices),
                    difference.distance,
                    float(np.abs(difference.difference.dihedral_angles).max()),
                    float(np.max(difference.error.dihedral_angles)),
                    float(difference.difference.integrated_mean_curvature) / scale,
                    float(difference.error.integrated_mean_curvature) / scale,
                    difference.same is False,
                )
            )
    return pairs


def _group(pairs: Sequence[Pair], name: str, vertices: int) -> dict[str, Any]:
    """The largest differences of the pairs of one surface and size."""
    some = [pair for pair in pairs if (pair.surface, pair.vertices) == (name, vertices)]
    return {
        "surface": name,
        "vertices": vertices,
        "pairs": len(some),
        "proven": sum(pair.proven for pair in some),
        **{
            key: max((abs(getattr(pair, key)) for pair in some), default=0.0)
            for key in ("distance", "angle", "mean_curvature", "mean_curvature_error")
        },
    }


def run_times(vertices: int, count: int) -> dict[str, Any]:
    """Seconds of a batch of metrics by one process and by two, and whether they find the same."""
    surface = SURFACES["saddle"]
    metrics = [
        PolyhedralMetric.from_mesh(*triangulate(surface, vertices, irregular=seed)) for seed in range(count)
    ]
    seconds, found = {}, {}
    for jobs in (1, 2):
        with Workers(jobs) as workers:
            for future in [workers.submit(embedded, metrics[0]) for _ in range(jobs)]:
                future.result()  # started, and everything imported
            began = perf_counter()
            futures = [workers.submit(embedded, metric) for metric in metrics]
            found[jobs] = [future.result() for future in futures]
            seconds[jobs] = perf_counter() - began
    same = all(np.array_equal(a, b) for a, b in zip(found[1], found[2], strict=True))
    return {
        "one": seconds[1],
        "two": seconds[2],
        "ratio": seconds[1] / seconds[2],
        "same": "the same to the last bit" if same else "not the same",
    }


def embedded(metric: PolyhedralMetric) -> Floats:
    """The vertices of the embedding, or of the best attempt."""
    try:
        return embed(metric).vertices
    except NotEmbedded as error:
        return error.embedding.vertices


def picture(pairs: Sequence[Pair]) -> Figure:
    """Differences against the distance of the two surfaces."""
    figure = plots.blank(3.6)
    left, right = figure.subplots(1, 2)
    plots.dress(left, "distance in mean edge lengths", "radians", "largest difference of a dihedral angle")
    plots.dress(right, "distance in mean edge lengths", "relative", "difference of int H dA")
    for name, style in plots.styled(SURFACES):
        some = [pair for pair in pairs if pair.surface == name]
        style |= {"linestyle": "none", "markersize": 4, "label": name}
        d = [pair.distance for pair in some]
        left.loglog(d, [pair.angle for pair in some], **style)
        right.loglog(d, [abs(pair.mean_curvature) for pair in some], **style)
    least, most = (end(pair.distance for pair in pairs) for end in (min, max))
    level = max(abs(pair.mean_curvature) / pair.distance**3 for pair in pairs)
    right.loglog([least, most], [level * least**3, level * most**3], color=plots.INK, linewidth=0.7)
    plots.note(right, "$d^3$", (least, level * least**3), (4, 8))
    plots.legend_below(figure, left)
    return figure
