"""Browser page of a simulation, with time on a slider."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter
from isoembed.io.files import write_atomically
from isoembed.io.registry import check_output
from isoembed.plot.browser.document import Document
from isoembed.plot.browser.packing import Packed
from isoembed.plot.browser.ramp import ramp
from isoembed.plot.coloring import SMALLEST_RESIDUAL, Quantity
from isoembed.plot.endings import PAGE_ENDINGS
from isoembed.plot.page import COLORS, own_ramp
from isoembed.plot.series.labels import facts_of
from isoembed.plot.series.page_report import run_caption, run_report_html
from isoembed.plot.series.placing import PlacedHorizon, PlacedHorizons
from isoembed.plot.series.scenes import Scene, evenly, joined, scenes
from isoembed.plot.view import Pose, camera
from isoembed.runs.result import Result

FIELDS = {
    "mean_curvature": ("mean curvature", "mean curvature H = (k₁ + k₂)/2", "1 / length", "linear"),
    "gaussian_curvature": ("Gaussian curvature", "Gaussian curvature K", "1 / length²", "linear"),
    "angular_momentum_density": ("angular momentum", "density of the angular momentum", "", "linear"),
    "residual": ("residual", "relative error of lengths", "", "log"),
}
"""Vertex data shown on a page if all horizons have them: name, label, unit and scale."""


MAX_FRAMES = 200  # times on the slider; more are thinned evenly


def write_series_page(path: str | os.PathLike[str], results: Iterable[Result], *, title: str = "") -> None:
    """Write a self-contained browser page of the embedded horizons of a run.

    Horizons are placed as in `write_series_film`, with time on a slider; a table beside them lists all
    horizons, including those not embedded, and can be downloaded as JSON.  Positions and colors are 16-bit;
    more than 200 times are thinned evenly.

    Parameters
    ----------
    path : path
        Ending in ``.html``.
    results : iterable of Result
        Results in any order; equal results yield identical files.
    title : str
        Title of the page; by default the file name.

    Raises
    ------
    FileError
        The ending is unknown or the file cannot be written.
    InvalidParameter
        No horizon is embedded.
    """
    check_output(path, PAGE_ENDINGS)
    document = _document(PlacedHorizons.of(results, FIELDS), title or Path(path).stem)
    write_atomically({Path(path): document.writer})


def _document(placed: PlacedHorizons, title: str) -> Document:
    everything = scenes(placed)
    if not everything:
        raise InvalidParameter("no horizon of the run is embedded: there is nothing to show")
    names = [name for name in FIELDS if all(name in one.fields for one in placed.horizons.values())]
    shown = evenly(everything, _max_scenes(everything, len(names)))
    packed, pose = Packed(), _pose(shown)
    bounds = {name: _bounds(name, shown) for name in names}
    meshes = dict[bytes, int]()
    entries, frames = list[dict[str, Any]](), list[dict[str, Any]]()
    pause = round(1000 * min(0.4, 12.0 / len(shown)))  # milliseconds; limits playing time to 12 seconds
    for scene in shown:
        shells = scene.shells
        horizons = [one for one in scene.shown if one not in shells] + list(shells)
        vertices, faces = joined(horizons)
        solid = sum(len(one.faces) for one in horizons if one not in shells)
        mesh = meshes.setdefault(faces.tobytes() + bytes([len(shells)]), len(meshes))
        if mesh == len(entries):
            entries.append(
                {"faces": packed.add(faces.ravel()), "polygons": None, "outlines": None, "solid": solid}
            )
        frames.append(
            {
                **{"stage": scene.moment, "t": None, "residual": None, "remarks": _report_lines(scene)},
                **{"pause": pause, "mesh": mesh, "concave": None},
                "positions": packed.add_short(pose.put(vertices).ravel()),
                "values": {FIELDS[name][0]: _shades(name, horizons, bounds[name], packed) for name in names},
            }
        )
    data = {
        **{"meshes": entries, "first": 0, "seams": None, "alone": ""},
        "pose": {"center": pose.center.tolist(), "axes": pose.axes.tolist(), "size": pose.size},
        "camera": camera().ravel().tolist(),
        "ramp": ramp(COLORS),
        "quantities": [
            {
                **dict(zip(("name", "label", "unit", "scale"), FIELDS[name], strict=True)),
                **{"at": "vertices", "ramp": own_ramp(FIELDS[name][3], *bounds[name])},
            }
            for name in names
        ],
        "frames": frames,
    }
    rows = [
        {"series": row.series, "label": row.label, "status": row.status, "reason": row.reason, **row.numbers}
        for row in placed.table.rows
    ]
    caption = run_caption(placed, everything[0], everything[-1])
    return Document(title, caption, run_report_html(placed), rows, data, packed)


def _max_scenes(shown: Sequence[Scene], fields: int) -> int:
    """Largest number of scenes on a page."""
    sizes = [
        len(one.vertices) * (6 + 2 * fields) + one.faces.size * (2 if len(one.vertices) < 2**14 else 4)
        for scene in shown
        for one in scene.shown
    ]
    # Limit of 12 MB for all frames, before base64 encoding.
    return max(1, int(min(MAX_FRAMES, 12_000_000 * len(shown) // sum(sizes))))


def _pose(shown: Sequence[Scene]) -> Pose:
    """Pose that contains all horizons in their positions."""
    horizons = [one for scene in shown for one in scene.shown]
    low = np.min([one.vertices.min(axis=0) for one in horizons], axis=0)
    high = np.max([one.vertices.max(axis=0) for one in horizons], axis=0)
    center = 0.5 * (low + high)
    size = max(float(np.linalg.norm(one.vertices - center, axis=1).max()) for one in horizons)
    return Pose(center, np.eye(3), size)


def _report_lines(scene: Scene) -> list[str]:
    """Text about the horizons of a scene."""
    rows = [one.row for one in scene.shown] + list(scene.missing)
    return [f"{row.series}: {facts_of(row, ', ')}" for row in sorted(rows, key=lambda row: row.place)]


def _values(field: str, horizons: Sequence[PlacedHorizon]) -> Floats:
    """Vertex data of horizons, one after the other; those on a logarithmic scale are not below a bound."""
    values: Floats = np.concatenate([one.fields[field] for one in horizons] or [np.empty(0)])
    return np.maximum(values, SMALLEST_RESIDUAL) if _is_log(field) else values


def _is_log(field: str) -> bool:
    return FIELDS[field][3] == "log"


def _bounds(field: str, shown: Sequence[Scene]) -> list[float]:
    """Color limits common to all scenes, or their logarithms on a logarithmic scale."""
    values = _values(field, [one for scene in shown for one in scene.shown])
    if _is_log(field):
        return np.log10(Quantity("", "", values, "log").bounds).tolist()
    return list(Quantity("", "", values).bounds)


def _shades(
    field: str, horizons: Sequence[PlacedHorizon], bounds: list[float], packed: Packed
) -> dict[str, Any]:
    """Packed values of a scene, with the limits of the colors."""
    values = _values(field, horizons)
    return {**packed.add_short(np.log10(values) if _is_log(field) else values), "bounds": bounds}
