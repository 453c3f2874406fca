"""Convergence of the integral of H (paper, figure 7): of the polyhedra, and of the surfaces behind them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from isoembed.aim.paper import Paper
from isoembed.arrays import Floats
from isoembed.gallery import Drum, Ellipsoid, Ergosphere, Surface
from isoembed.metric.curvature import corner_angles
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.studies import plots
from isoembed.studies.bodies import STUDY, embedding_of, meshed
from isoembed.studies.section import Comparison, Illustration, Section, Table, listed
from isoembed.surface.smooth_integrals import SmoothIntegrals

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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
                listed("{name}: N^{order_embedded:.2f}", orders),
                "They agree if the order is counted in N, which the paper calls the resolution; in the edge "
                "length it is the second. The exact coordinates have the same error.",
            ),
            Comparison(
                "The same with the inscribed polyhedron's defect added",
                "not in the paper",
                listed("{name}: N^{order_corrected:.2f}", orders),
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
                f"N^{kerr.order(kerr.embedded):.2f}",
                "The paper lacked triangulations of consistent quality; here all angles of all meshes are "
                f"between {low:.0f} and {high:.0f} degrees.",
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
            Table.of(
                "Error of int H dA in percent",
                {
                    "surface": "{name}",
                    "N": "{n:,}",
                    "embedded": "{embedded:+.4f}",
                    "exact coordinates": "{exact:+.4f}",
                    "cotangent formula": "{cotangent:+.4f}",
                    "corrected": "{corrected:+.1e}",
                },
                [row for one in made for row in one.rows],
            ),
        ),
        numbers=numbers,
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
        found = embedding_of(body, method, STUDY.fine_tolerance)
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
