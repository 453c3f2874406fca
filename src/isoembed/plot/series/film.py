"""Film of a run: its embedded horizons at their centers, from inspiral to ringdown."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter
from isoembed.io.files import write_atomically
from isoembed.io.registry import check_output
from isoembed.plot.animation import Pixels, check_animation, pixels_writer
from isoembed.plot.coloring import Quantity, face_means
from isoembed.plot.endings import ANIMATION_ENDINGS
from isoembed.plot.picture import INK, PAPER, color_bar, color_scale, draw
from isoembed.plot.placed import TIP, draw_arrow, draw_length, draw_triad
from isoembed.plot.series.labels import CURVATURE, colors_of, escaped, facts_of
from isoembed.plot.series.placing import PlacedHorizon, PlacedHorizons
from isoembed.plot.series.scenes import Scene, evenly, joined, scenes
from isoembed.plot.view import Pose, View, camera
from isoembed.runs.result import Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable
    from matplotlib.figure import Figure

SHOWN = "mean_curvature"
SIZE = (7.2, 6.0)  # inches: even numbers of pixels
PLACE = (0.0, 0.13, 0.86, 0.81)  # axes in the picture: left, bottom, width, height
WIDE = PLACE[2] * SIZE[0] / (PLACE[3] * SIZE[1])
LINES = 3  # per column of the text below


def write_series_film(path: str | os.PathLike[str], results: Iterable[Result]) -> None:
    """Write a film of the embedded horizons of a run as ``.gif`` or ``.mp4``.

    Each horizon has the position of its center and its orientation in the slice (`PlacedHorizons`); a common
    horizon is translucent while it contains others.  Colors show the mean curvature on a fixed scale.  The
    view follows the horizons, at a fixed scale unless they approach each other strongly, and a scale bar
    indicates length.  The text below gives time, masses, spins and lost horizons.

    Parameters
    ----------
    path : path
    results : iterable of Result
        Results in any order; equal results yield identical files.

    Raises
    ------
    FileError
        The ending is unknown, the file cannot be written, or matplotlib, or for MP4 imageio-ffmpeg, is not
        installed.
    InvalidParameter
        No horizon is embedded.
    """
    check_output(path, ANIMATION_ENDINGS)
    check_animation(path)
    placed = PlacedHorizons.of(results, [SHOWN])
    shown = evenly(scenes(placed), 240)  # limit of images
    if not shown:
        raise InvalidParameter("no horizon of the run is embedded: there is nothing to show in a film")
    each = min(0.4, 16.0 / len(shown))  # seconds per image; limits the film to 16 seconds
    seconds = [each] * (len(shown) - 1) + [2.0]
    write_atomically({Path(path): pixels_writer(path, _drawn(placed, shown), seconds)})


def _drawn(placed: PlacedHorizons, shown: Sequence[Scene]) -> Iterator[Pixels]:
    """Rendered images as pixels, (height, width, 3), in order."""
    from isoembed.plot.windowless import WindowlessFigure

    values = np.concatenate([horizon.fields[SHOWN] for scene in shown for horizon in scene.shown])
    scale, colors = color_scale(*Quantity("", "", values).bounds), colors_of(placed.table.series)
    for scene, pose in zip(shown, _poses(shown), strict=True):
        picture = WindowlessFigure(*SIZE, facecolor=PAPER, dpi=100)
        axes = picture.add_axes(PLACE)
        _draw_scene(axes, scene, pose, scale, colors)
        axes.set_aspect("equal")
        axes.axis("off")
        tall = 1.15  # size of the picture relative to its contents
        axes.set_xlim(-WIDE * tall, WIDE * tall)
        axes.set_ylim(-tall, tall)
        draw_triad(axes, tall * np.array([-0.85 * WIDE, -0.78]))
        draw_length(axes, pose.size, tall * np.array([0.97 * WIDE, -0.9]))
        bar = picture.add_axes((0.87, 0.24, 0.02, 0.6))
        color_bar(picture, bar, scale, values)
        bar.set_ylabel(CURVATURE, color=INK, labelpad=6, fontsize=10)
        picture.text(0.43, 0.965, scene.moment, ha="center", va="center", fontsize=14, color=INK)
        _write_below(picture, scene, colors, placed.note)
        yield picture.pixels()


def _poses(shown: Sequence[Scene]) -> list[Pose]:
    """Centers and sizes of the views, smoothed in time, with everything inside the picture."""
    calm = round(0.5 * 0.12 * len(shown))  # half width of the smoothing window, 12 % of the film
    boxes = _filled([_box(scene) for scene in shown])
    low, high = boxes[:, :3], boxes[:, 3:]
    lower, higher = -_around(-low, calm).max(axis=-1), _around(high, calm).max(axis=-1)
    centers = _around(0.5 * (lower + higher), calm).mean(axis=-1)
    reaches = (np.maximum(high - centers, centers - low) / (WIDE, 1.0, np.inf)).max(axis=1)
    sizes = _around(_around(reaches, calm).max(axis=-1), calm).mean(axis=-1)
    if reaches.max() <= 3.0 * reaches.min():  # a fixed scale keeps sizes comparable
        sizes[:] = reaches.max()
    return [
        Pose(camera().T @ center, np.eye(3), float(size)) for center, size in zip(centers, sizes, strict=True)
    ]


def _box(scene: Scene) -> Floats | None:
    """Smallest and largest coordinates right, up and toward the viewer, including the spin axes."""
    if not scene.shown:
        return None
    centers = np.array([horizon.center for horizon in scene.shown]) @ camera().T
    reaches = [horizon.radius * (1.0 if horizon.axis is None else TIP) for horizon in scene.shown]
    around = np.array(reaches)[:, None]  # independent of orientation, for a steady picture
    return np.concatenate([(centers - around).min(axis=0), (centers + around).max(axis=0)])


def _filled(boxes: Sequence[Floats | None]) -> Floats:
    """Boxes with missing ones replaced by their predecessors; the first must exist."""
    found = list[Floats]()
    for box in boxes:
        found.append(found[-1] if box is None else box)
    return np.array(found)


def _around(values: Floats, calm: int) -> Floats:
    """Windows with `calm` values before and after each value, along a last axis."""
    padded = np.pad(values, [(calm, calm)] + [(0, 0)] * (values.ndim - 1), "edge")
    return np.lib.stride_tricks.sliding_window_view(padded, 2 * calm + 1, axis=0)


def _draw_scene(axes: Axes, scene: Scene, pose: Pose, scale: ScalarMappable, colors: dict[str, str]) -> None:
    """Draw the horizons, enclosing ones on top of the enclosed, with spins and names."""
    shells = scene.shells
    _draw_surfaces(axes, [one for one in scene.shown if one not in shells], pose, scale, 1.0)
    for shell in shells:
        # Translucent, as it contains others.
        _draw_surfaces(axes, [shell], pose, scale, 0.35)
    for horizon in scene.shown:
        points = pose.put(np.vstack([horizon.vertices, horizon.center]))
        if horizon.axis is not None:
            draw_arrow(axes, horizon.axis, points[:-1], points[-1])
        right, up = (points @ camera()[:2].T).T
        name = escaped(horizon.row.series)
        axes.text(
            right[-1],
            up[:-1].max() + 0.03,
            name,
            ha="center",
            va="bottom",
            fontsize=11,
            fontweight="bold",
            color=colors[horizon.row.series],
            zorder=4,
        )


def _draw_surfaces(
    axes: Axes, horizons: Sequence[PlacedHorizon], pose: Pose, scale: ScalarMappable, opacity: float
) -> None:
    """Draw disjoint horizons, the farthest face first."""
    if not horizons:
        return
    vertices, faces = joined(horizons)
    values = np.concatenate([horizon.fields[SHOWN] for horizon in horizons])
    draw(axes, View.of(vertices, faces, pose), face_means(values, faces), scale, opacity=opacity)


def _write_below(picture: Figure, scene: Scene, colors: dict[str, str], note: str) -> None:
    """Write the properties of the horizons, one line per series, and the outcome of lost ones."""
    rows = [horizon.row for horizon in scene.shown] + list(scene.missing)
    lines = {row.series: facts_of(row, "    ") for row in rows}
    for k, name in enumerate(colors):
        if name in lines:
            words = f"{escaped(name)}    {lines[name]}"
            at = 0.04 + 0.5 * (k // LINES), 0.105 - 0.034 * (k % LINES)
            picture.text(*at, words, ha="left", va="center", fontsize=10, color=colors[name])
    picture.text(0.98, 0.02, note, ha="right", va="center", fontsize=8, color=INK)
