"""The three steps of AIM in one picture (paper, figure 1): two metrics as flat nets, two surfaces."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order, shortest_path

from isoembed import Paper, PolyhedralMetric, Triangulation, embed
from isoembed.gallery import Ellipsoid
from isoembed.metric.curvature import area, corner_angles, gaussian_curvature
from isoembed.plot import Film, Panel, color_scale, draw_panel
from isoembed.progress.stages import Log
from reproduction import plots
from reproduction.arrays import Floats
from reproduction.bodies import meshed
from reproduction.section import Section

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable
    from matplotlib.figure import Figure


COLORED = (0.1, 10.0)  # K over its average: from 0.11 to 8.8 on the smooth ellipsoid


def study(*, vertices: int) -> Section:
    """What goes into each step and what comes out of it.

    Parameters
    ----------
    vertices : int
        Of the ellipsoid; more than about 200 cannot be told apart in the nets.
    """
    given = meshed(Ellipsoid(), vertices).metric
    method = Paper()
    with Log().stage("uniformize") as recorder:
        uniform = method.uniformize(given.normalized, recorder).metric
    film = Film()
    surface = embed(given, method=method, progress=film)
    on_sphere = [frame.vertices for frame in film.frames(surface) if frame.t == 1][-1]
    curvatures = [_over_average(given), _over_average(uniform)]
    spread = [(float(k.min()), float(k.max())) for k in curvatures]
    radii = np.linalg.norm(on_sphere - on_sphere.mean(axis=0), axis=1)
    roundness = float(np.ptp(radii) / radii.mean())
    nets = [_net(metric) for metric in (given, uniform)]
    shapes = [on_sphere, surface.vertices]
    return Section.of(
        "three-steps",
        figures={"three-steps": _picture(given.triangulation, nets, shapes, curvatures)},
        numbers={
            "vertices": vertices,
            "curvature_before": spread[0],
            "curvature_after": spread[1],
            "roundness": roundness,
            "residual": surface.residual,
        },
        vertices=vertices,
        spread=spread,
        off=max(abs(k - 1) for k in spread[1]),
        roundness=roundness,
    )


def _over_average(metric: PolyhedralMetric) -> Floats:
    """Gaussian curvature over ``kbar = 4 pi / A`` at the vertices, (V,)."""
    return gaussian_curvature(metric) * area(metric) / (4 * np.pi)


def _net(metric: PolyhedralMetric) -> Floats:
    """Corners (F, 3, 2) of the triangles, unfolded along a breadth-first tree from a middle one.

    The longest extent of the net lies across.
    """
    t = metric.triangulation
    beside = csr_array((np.ones(3 * t.n_faces), (np.arange(3 * t.n_faces) // 3, t.twins // 3)))
    middle = int(shortest_path(beside, unweighted=True).max(axis=1).argmin())
    order, before = breadth_first_order(beside, middle)
    angles, lengths = corner_angles(metric), metric.face_lengths
    at = np.empty((t.n_faces, 3), dtype=np.complex128)  # the plane as complex numbers
    for f in order:
        c = 0
        if f == middle:
            at[f, :2] = 0.0, lengths[f, 0]
        else:
            c = int(np.flatnonzero(t.twins[3 * f : 3 * f + 3] // 3 == before[f])[0])
            g, d = divmod(t.twins[3 * f + c], 3)
            at[f, c], at[f, (c + 1) % 3] = at[g, (d + 1) % 3], at[g, d]
        side = (at[f, (c + 1) % 3] - at[f, c]) / lengths[f, c]
        at[f, (c + 2) % 3] = at[f, c] + side * lengths[f, (c + 2) % 3] * np.exp(1j * angles[f, c])
    points = np.column_stack([at.real.ravel(), at.imag.ravel()])
    points -= points.mean(axis=0)
    axes = np.linalg.eigh(points.T @ points)[1][:, ::-1]
    axes[:, 1] *= np.sign(np.linalg.det(axes))  # turned, not mirrored
    return (points @ axes).reshape(-1, 3, 2)


def _picture(
    triangulation: Triangulation, nets: list[Floats], shapes: list[Floats], curvatures: list[Floats]
) -> Figure:
    figure = plots.blank(6.4)
    figure.set_layout_engine("none")  # every axes has its place
    scale = color_scale(*COLORED, "log")
    curvatures = [np.clip(k, *COLORED) for k in curvatures]
    spots = {  # left, bottom, width, height
        "before": (0.01, 0.51, 0.40, 0.44),
        "after": (0.59, 0.51, 0.40, 0.44),
        "surface": (0.01, 0.05, 0.40, 0.37),
        "sphere": (0.63, 0.05, 0.32, 0.37),
    }
    axes = {name: figure.add_axes(spot) for name, spot in spots.items()}
    titles = {"before": r"$\rho_0$", "after": r"$\rho_{t_f}$", "sphere": "$P_{t_f}$", "surface": "$P_0$"}
    for name, net, k in zip(("before", "after"), nets, curvatures, strict=True):
        _draw_net(axes[name], net, k[triangulation.faces], scale)
        axes[name].set_title(titles[name], color=plots.INK, fontsize=13)
    for name, vertices, k in zip(("sphere", "surface"), shapes, curvatures[::-1], strict=True):
        left, _, width, _ = spots[name]
        figure.text(left + width / 2, 0.01, titles[name], ha="center", color=plots.INK, fontsize=13)
        draw_panel(axes[name], Panel(vertices, triangulation.faces, k), scale)
        axes[name].autoscale_view()
    for start, end, words, spot in (
        ((0.42, 0.74), (0.58, 0.74), "Ricci flow\n2.1", (0.5, 0.79)),
        ((0.79, 0.50), (0.79, 0.43), "uniform surface\nembedding, 2.2", (0.89, 0.465)),
        ((0.60, 0.22), (0.43, 0.22), "guided adiabatic\npull-back, 2.3", (0.515, 0.27)),
    ):
        axes["before"].annotate(
            "",
            end,
            start,
            xycoords="figure fraction",
            textcoords="figure fraction",
            arrowprops={"arrowstyle": "-|>", "color": plots.INK, "linewidth": 1.4, "mutation_scale": 16},
            annotation_clip=False,
        )
        figure.text(*spot, words, ha="center", va="center", color=plots.INK, fontsize=plots.TEXT)
    bar_axes = figure.add_axes((0.08, 0.455, 0.26, 0.016))
    bar = figure.colorbar(scale, cax=bar_axes, orientation="horizontal")
    bar.outline.set_visible(False)
    bar_axes.set_xticks([0.1, 0.3, 1, 3, 10], ["0.1", "0.3", "1", "3", "10"])
    bar_axes.set_xticks([], minor=True)
    bar_axes.tick_params(colors=plots.INK, labelsize=plots.SMALL, length=3, width=0.6)
    bar_axes.set_title(r"Gaussian curvature  $K / \bar{k}$", color=plots.INK, fontsize=plots.SMALL)
    return figure


def _draw_net(axes: Axes, net: Floats, values: Floats, scale: ScalarMappable) -> None:
    from matplotlib.collections import PolyCollection

    colors = scale.to_rgba(values.mean(axis=1))
    axes.add_collection(PolyCollection(list(net), facecolors=colors, edgecolors="white", linewidths=0.4))
    axes.autoscale_view()
    plots.bare(axes)
