"""Convergence of the integral of H (paper, figure 7): of the polyhedra, and of the surfaces behind them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from isoembed._embed import Method, embed
from isoembed.aim.paper import Paper
from isoembed.gallery import Drum, Ellipsoid, Ergosphere, triangulate
from isoembed.gallery.surface import Surface
from isoembed.metric.curvature import corner_angles
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.studies import plots
from isoembed.studies.section import Comparison, Illustration, Section, Table
from isoembed.surface.embedding import Embedding
from isoembed.surface.smooth_integrals import SmoothIntegrals

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]

TOLERANCE = 1e-10  # far below the errors of the corrected integrals
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
    n: NDArray[np.int64]
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


def study(*, sizes: Sequence[int]) -> Section:
    """Measure the error of int H dA at several numbers of vertices and fit its order.

    Parameters
    ----------
    sizes : sequence of int
        Numbers of vertices, rising; the last one is also compared with the paper.

    Returns
    -------
    Section
    """
    made = [
        convergence(Ellipsoid(), sizes, Paper()),
        convergence(Drum(), sizes, Paper()),
        convergence(Ergosphere(), sizes, "aim"),
    ]
    orders = {one.name: one.order(one.embedded) for one in made}
    fourth = {one.name: one.order(one.corrected[-RESOLVED:]) for one in made}
    apart = max(float(np.abs(one.embedded - one.exact).max()) for one in made)
    _, drum, kerr = made
    ratios, formulas = drum.embedded / kerr.embedded, kerr.cotangent / kerr.embedded
    angles = min(one.angles[0] for one in made), max(one.angles[1] for one in made)
    return Section(
        title="Convergence of the integrated mean curvature",
        text=(
            "The error of int H dA = 1/2 sum l theta against the number of vertices, from lengths alone; H = "
            "(k1 + k2) / 2. It is the error of a polyhedron inscribed in the surface: the vertices that the "
            f"lengths were taken from have the same one, to {apart:.0e} percentage points.",
            "First order in N is second order in the edge length, since N is inversely proportional to its "
            "square. What a polyhedron lacks is known from the curvatures along its edges; with it added, "
            "the integral over the smooth surface has an error of fourth order in the edge length, second in "
            "N (isoembed.surface.smooth_integrals). The ergosphere, which the paper leaves out here, is like "
            "the others where the mesh resolves its tips.",
        ),
        figures=(
            Illustration(
                "mean-curvature",
                "Error of int H dA in percent. Filled: of the embedded polyhedra. Open: with what they lack "
                "added. Thin lines: N^-1 and N^-2.",
                picture(made),
            ),
        ),
        comparisons=(
            Comparison(
                "Order of convergence of int H dA (figure 7)",
                "first order",
                "; ".join(f"{name}: N^{order:.2f}" for name, order in orders.items()),
                "They agree if the order is counted in N, which the paper calls the resolution; in the edge "
                "length it is the second. The exact coordinates have the same error.",
            ),
            Comparison(
                "The same with the inscribed polyhedron's defect added",
                "not in the paper",
                "; ".join(f"{name}: N^{order:.2f}" for name, order in fourth.items()),
                "The second order in N, which is the fourth in the edge length, is what it tends to once the "
                f"meshes resolve where the surface is most curved. Fitted to the {RESOLVED} largest ones.",
            ),
            Comparison(
                "The drum's error is comparable to the ergosphere's at the same resolution (section 3.2)",
                "comparable, no number",
                f"{drum.embedded[-1]:+.3g} % and {kerr.embedded[-1]:+.3g} % at {kerr.n[-1]:,} vertices; "
                f"{ratios.min():.2f} to {ratios.max():.2f} times as large at all sizes",
            ),
            Comparison(
                "Convergence for the ergosphere (section 3.2)",
                "not analyzed, expected to be similar",
                f"N^{orders[kerr.name]:.2f}",
                "The paper lacked triangulations of consistent quality; here all angles of all meshes are "
                f"between {angles[0]:.0f} and {angles[1]:.0f} degrees.",
            ),
            Comparison(
                "Vertices at which the ergosphere's error is 0.62 % (section 3.2)",
                "resolution not stated",
                f"about {kerr.vertices_for(kerr.embedded, PAPERS):,} with 1/2 sum l theta; about "
                f"{kerr.vertices_for(kerr.cotangent, PAPERS):,} with the cotangent formula",
                "The paper does not print its formula for H, but cites it. The cotangent formula has "
                f"{formulas.min():.1f} to {formulas.max():.1f} times the error of the other one on the same "
                "vertices.",
            ),
        ),
        tables=(
            Table(
                "Error of int H dA in percent",
                ("surface", "N", "embedded", "exact coordinates", "cotangent formula", "corrected"),
                tuple(
                    (
                        one.name,
                        f"{one.n[k]:,}",
                        f"{one.embedded[k]:+.4f}",
                        f"{one.exact[k]:+.4f}",
                        f"{one.cotangent[k]:+.4f}",
                        f"{one.corrected[k]:+.1e}",
                    )
                    for one in made
                    for k in range(len(one.n))
                ),
            ),
        ),
        numbers={
            one.name: {
                "vertices": one.n.tolist(),
                "percent_embedded": one.embedded.tolist(),
                "percent_exact": one.exact.tolist(),
                "percent_cotangent": one.cotangent.tolist(),
                "percent_corrected": one.corrected.tolist(),
                "order_embedded": orders[one.name],
                "order_corrected": fourth[one.name],
                "angles": one.angles,
            }
            for one in made
        },
    )


def convergence(surface: Surface, sizes: Sequence[int], method: str | Method) -> Convergence:
    """Embed a surface's lengths at several sizes and compare int H dA with the exact one.

    Parameters
    ----------
    surface : Surface
    sizes : sequence of int
        Numbers of vertices.
    method : str or Method

    Returns
    -------
    Convergence
    """
    errors, angles = [], []
    for n in sizes:
        points, faces = triangulate(surface, n)
        metric = PolyhedralMetric.from_mesh(points, faces)
        embedding = embed(metric, method=method, tolerance=TOLERANCE)
        original = Embedding(metric, points, method="exact", tolerance=TOLERANCE)
        behind = SmoothIntegrals(metric.triangulation, embedding.vertices, "chord")
        found = (
            embedding.integrated_mean_curvature,
            original.integrated_mean_curvature,
            cotangent_integral(metric, embedding.vertices),
            behind.integrated_mean_curvature.value,
        )
        errors.append([100 * (value / surface.integrated_mean_curvature - 1) for value in found])
        corners = np.degrees(corner_angles(metric))
        angles.append((corners.min(), corners.max()))
    embedded, exact, cotangent, corrected = np.array(errors).T
    low, high = np.array(angles).T
    return Convergence(
        surface.name,
        np.array(sizes),
        embedded,
        exact,
        cotangent,
        corrected,
        (float(low.min()), float(high.max())),
    )


def cotangent_integral(metric: PolyhedralMetric, vertices: Floats) -> float:
    """Sum of the lengths of H n A over the vertices, by the cotangent Laplacian of the coordinates.

    Pinkall & Polthier, Exp. Math. 2 (1993); Meyer et al., Visualization and Mathematics III (2003).

    Parameters
    ----------
    metric : PolyhedralMetric
    vertices : ndarray, shape (V, 3)
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
    for one, color, marker in zip(made, plots.SERIES, plots.MARKERS, strict=False):
        axes.loglog(one.n, np.abs(one.embedded), color=color, marker=marker, label=one.name)
        axes.loglog(
            one.n,
            np.abs(one.corrected),
            color=color,
            marker=marker,
            markerfacecolor=plots.PAPER,
            linestyle="--",
            label=f"{one.name}, corrected",
        )
    n = made[0].n
    for power, errors, factor in (
        (-1, [one.embedded for one in made], 1.7),
        (-2, [m.corrected for m in made], 0.4),
    ):
        level = factor * np.exp(np.mean([np.log(np.abs(e) * n ** -float(power)).mean() for e in errors]))
        axes.loglog(n, level * n ** float(power), color=plots.INK, linewidth=0.7)
        axes.annotate(
            f"$N^{{{power}}}$",
            (n[-1], level * n[-1] ** float(power)),
            xytext=(4, 0),
            textcoords="offset points",
            color=plots.INK,
            va="center",
        )
    axes.set_xticks(n, [f"{size:,}" for size in n])
    axes.minorticks_off()
    plots.legend(axes, loc="upper left", bbox_to_anchor=(1.06, 1.0))
    return figure
