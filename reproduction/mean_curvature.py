"""Convergence of the integral of H (paper, figure 7): of the polyhedra, and of the surfaces behind them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from isoembed import Paper, PolyhedralMetric
from isoembed.gallery import Drum, Ellipsoid, Ergosphere, Surface
from isoembed.metric.curvature import corner_angles
from isoembed.surface.smooth_integrals import SmoothIntegrals
from reproduction import plots
from reproduction.arrays import Floats, Indices
from reproduction.bodies import embedding_of, meshed
from reproduction.section import Section

if TYPE_CHECKING:
    from matplotlib.figure import Figure


TOLERANCE = 1e-10  # mean edge lengths: the residual must not show in the error of int H dA
PAPERS = 0.62  # percent, of the ergosphere
RESOLVED = 4  # sizes, the largest, to which the order of the corrected integral is fitted


@dataclass(frozen=True)
class Convergence:
    """Errors of int H dA of one surface against the number of vertices, in percent.

    Attributes
    ----------
    name : str
    n : ndarray of int, shape (S,)
    embedded : ndarray, shape (S,)
        Of 1/2 sum l theta of the embeddings.
    exact : ndarray, shape (S,)
        The same on the vertices that the lengths were taken from.
    cotangent : ndarray, shape (S,)
        Of the norms of the cotangent Laplacian of the embedded vertices.
    corrected : ndarray, shape (S,)
        Of the integral over the surface that the polyhedron stands for.
    angles : (float, float)
        The least and the largest angle of all triangles, in degrees.
    """

    name: str
    n: Indices
    embedded: Floats
    exact: Floats
    cotangent: Floats
    corrected: Floats
    angles: tuple[float, float]

    def order(self, errors: Floats) -> float:
        """Exponent of N, fitted to the sizes of the errors at the largest numbers of vertices."""
        return float(np.polyfit(np.log(self.n[-len(errors) :]), np.log(np.abs(errors)), 1)[0])

    def vertices_for(self, errors: Floats, percent: float) -> int:
        """The number of vertices at which the fitted line has this error, to two digits."""
        slope, level = np.polyfit(np.log(self.n), np.log(np.abs(errors)), 1)
        return int(float(f"{np.exp((np.log(percent) - level) / slope):.2g}"))

    @property
    def rows(self) -> list[dict[str, Any]]:
        """One record for each size."""
        columns = {key: value for key, value in vars(self).items() if isinstance(value, np.ndarray)}
        return [
            {"name": self.name, **dict(zip(columns, row, strict=True))}
            for row in zip(*columns.values(), strict=True)
        ]

    @property
    def numbers(self) -> dict[str, Any]:
        """All of it, with the orders."""
        return {
            "vertices": self.n.tolist(),
            "percent_embedded": self.embedded.tolist(),
            "percent_exact": self.exact.tolist(),
            "percent_cotangent": self.cotangent.tolist(),
            "percent_corrected": self.corrected.tolist(),
            "order_embedded": self.order(self.embedded),
            "order_corrected": self.order(self.corrected[-RESOLVED:]),
            "angles": self.angles,
        }


def study(*, sizes: Sequence[int]) -> Section:
    """Errors of int H dA at several numbers of vertices, and their order.

    Parameters
    ----------
    sizes : sequence of int
        Numbers of vertices, rising; the last one is also compared with the paper.
    """
    _, drum, kerr = made = [
        convergence(Ellipsoid(), sizes, Paper()),
        convergence(Drum(), sizes, Paper()),
        convergence(Ergosphere(), sizes, "aim"),
    ]
    numbers = {one.name: one.numbers for one in made}
    orders = [{"name": name, **found} for name, found in numbers.items()]
    apart = max(float(np.abs(one.embedded - one.exact).max()) for one in made)
    ratios, formulas = drum.embedded / kerr.embedded, kerr.cotangent / kerr.embedded
    low, high = min(one.angles[0] for one in made), max(one.angles[1] for one in made)
    return Section.of(
        "mean-curvature",
        figures={"mean-curvature": picture(made)},
        numbers=numbers,
        rows=[row for one in made for row in one.rows],
        apart=apart,
        orders=orders,
        resolved=RESOLVED,
        drum_error=drum.embedded[-1],
        kerr_error=kerr.embedded[-1],
        most=kerr.n[-1],
        least_ratio=ratios.min(),
        largest_ratio=ratios.max(),
        kerr_order=kerr.order(kerr.embedded),
        low=low,
        high=high,
        for_dihedral=kerr.vertices_for(kerr.embedded, PAPERS),
        for_cotangent=kerr.vertices_for(kerr.cotangent, PAPERS),
        least_factor=formulas.min(),
        largest_factor=formulas.max(),
    )


def convergence(surface: Surface, sizes: Sequence[int], method: str | Paper) -> Convergence:
    """Errors of int H dA of a surface that is embedded from its lengths at several sizes.

    Parameters
    ----------
    surface : Surface
    sizes : sequence of int
        Numbers of vertices.
    method : str or Paper
    """
    errors, angles = [], []
    for n in sizes:
        body = meshed(surface, n)
        found = embedding_of(body, method, TOLERANCE)
        behind = SmoothIntegrals(body.metric.triangulation, found.vertices, "chord")
        values = (
            found.integrated_mean_curvature,
            body.exact.integrated_mean_curvature,
            cotangent_integral(body.metric, found.vertices),
            behind.integrated_mean_curvature.value,
        )
        errors.append([body.percent_error(value) for value in values])
        angles.append(np.degrees(corner_angles(body.metric)))
    extremes = min(float(a.min()) for a in angles), max(float(a.max()) for a in angles)
    embedded, exact, cotangent, corrected = np.array(errors).T
    return Convergence(surface.name, np.array(sizes), embedded, exact, cotangent, corrected, extremes)


def cotangent_integral(metric: PolyhedralMetric, vertices: Floats) -> float:
    """Sum of the lengths of H n A over the vertices, by the cotangent Laplacian of the coordinates.

    Pinkall & Polthier, Exp. Math. 2 (1993); Meyer et al., Visualization and Mathematics III (2003).
    """
    faces = metric.faces
    cotangents = 1 / np.tan(corner_angles(metric))
    normals = np.zeros_like(vertices)
    for c in range(3):
        a, b = faces[:, (c + 1) % 3], faces[:, (c + 2) % 3]
        force = cotangents[:, [c]] / 4 * (vertices[a] - vertices[b])
        np.add.at(normals, a, force)
        np.add.at(normals, b, -force)
    return float(np.linalg.norm(normals, axis=1).sum())


def picture(made: Sequence[Convergence]) -> Figure:
    """The errors in percent against N, in logarithmic scales."""
    figure = plots.blank(4.6)
    axes = figure.add_subplot()
    plots.dress(axes, "vertices N", "error of int H dA in percent")
    for one, style in plots.styled(made):
        axes.loglog(one.n, np.abs(one.embedded), label=one.name, **style)
        style |= {"markerfacecolor": plots.PAPER, "linestyle": "--", "label": f"{one.name}, corrected"}
        axes.loglog(one.n, np.abs(one.corrected), **style)
    n = made[0].n
    for power, errors, factor in (
        (-1.0, [one.embedded for one in made], 1.7),
        (-2.0, [one.corrected for one in made], 0.4),
    ):
        level = factor * np.exp(np.mean([np.log(np.abs(e) * n**-power).mean() for e in errors]))
        axes.loglog(n, level * n**power, color=plots.INK, linewidth=0.7)
        plots.note(axes, f"$N^{{{power:.0f}}}$", (n[-1], level * n[-1] ** power), (4, 0), va="center")
    axes.set_xticks(n, [f"{size:,}" for size in n])
    axes.minorticks_off()
    plots.legend(axes, loc="upper left", bbox_to_anchor=(1.06, 1.0))
    return figure
