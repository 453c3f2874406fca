"""A page for the browser: one file with a surface to turn around, its colors, its film and its report."""

import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from isoembed._embed import configuration
from isoembed.arrays import Floats, Mask
from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.io.files import Writer, write_atomically
from isoembed.io.format import Polygons
from isoembed.io.registry import check_output
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.plot.browser.document import Document
from isoembed.plot.browser.packing import Packed
from isoembed.plot.browser.ramp import ramp
from isoembed.plot.browser.report import number, report_html
from isoembed.plot.browser.thinning import thinned
from isoembed.plot.film import ANSWER, FILM, Frame, shape
from isoembed.plot.quantity import (
    QUANTITY,
    Quantity,
    concavity,
    face_means,
    faces_counted,
    intrinsic_curvature,
    mean_curvature,
    quantities,
    residual,
)
from isoembed.plot.view import Pose, camera
from isoembed.strict_json import plain
from isoembed.surface.embedding import Embedding
from isoembed.surface.measures import edge_lengths

PAGE_ENDINGS = (".html",)
LEAPT = (
    "The method leaped to this surface: there is none on the way to it. With --method paper there are some."
)
ALONE = "This method has no surface before the answer."
PAUSE = 140  # milliseconds from one frame to the next
COLORS = 65  # the browser interpolates between them
UNITS = {
    "mean curvature": "1 / length",
    "Gaussian curvature": "1 / length²",
    "residual": "",
    "concave edges": "",
    "conformal factor": "",
}
TEX = {"$": "", r"\varepsilon_a": "ε", "A^*_a": "A*", "k_1": "k₁", "k_2": "k₂", "  ": " "}


def page_writer(
    path: str | os.PathLike[str], embedding: Embedding, *, title: str = "", **contents: Any
) -> Writer:
    """Return what writes the page of a surface; see `write_atomically` and `write_page`."""
    return _page(embedding, title or Path(path).stem, **contents).writer


def write_page(
    path: str | os.PathLike[str],
    embedding: Embedding,
    *,
    frames: Sequence[Frame] = (),
    title: str = "",
    caption: str = "",
) -> None:
    """Write a page for the browser: one file, which loads nothing from anywhere.

    It shows the surface in WebGL, with the colors of every quantity of `isoembed.plot.quantities`; the frames
    of a film, at most 40 of them; and the report, with the JSON to download.  The vertices are in single
    precision in units of the half diameter; of frames before the last, positions and colors are in 16 bit.

    Parameters
    ----------
    path : path
        Ending in ``.html``.
    embedding : Embedding
    frames : sequence of Frame
        `Film.frames`; the last one is the embedding itself.
    title : str
        By default the name of the file.
    caption : str
        A line below; by default the numbers of vertices and triangles, int H dA and the residual.

    Raises
    ------
    FileError
        The ending is not known or the file cannot be written.
    """
    check_output(path, PAGE_ENDINGS)
    write_atomically({Path(path): page_writer(path, embedding, frames=frames, title=title, caption=caption)})


def _page(embedding: Embedding, title: str, *, frames: Sequence[Frame] = (), caption: str = "") -> Document:
    data, arrays = _data(embedding, frames)
    report = embedding.report
    return Document(title, caption or _caption(embedding), report_html(report), report, data, arrays)


def _caption(embedding: Embedding) -> str:
    t, total = embedding.triangulation, embedding.integrated_mean_curvature
    words = [f"{t.n_vertices:,} vertices, {faces_counted(embedding)}", f"∫ H dA = {number(total)}"]
    if not _is_its_own(embedding):
        words.append(f"largest length error {number(plain(embedding.residual))} of the mean edge")
    return " · ".join(words)


def _is_its_own(embedding: Embedding) -> bool:
    """Whether nothing was computed and the lengths are those of the vertices: it has no residual to show."""
    return not embedding.stages and embedding.residual <= QUANTITY.exact


def _data(embedding: Embedding, frames: Sequence[Frame]) -> tuple[dict[str, Any], Packed]:
    """What the script shows: a JSON object, and the arrays that it points to."""
    t, packed = embedding.triangulation, Packed()
    earlier = list(frames[:-1])
    own = not earlier and _is_its_own(embedding)
    shown = [q for q in quantities(embedding) if not (own and q.name == "residual")]
    size = t.n_vertices * (6 + 2 * len(shown)) + t.n_edges / 8
    limit = int(min(FILM.frames, 1 + FILM.size // size))
    chosen = thinned([frame.stage for frame in earlier] + [ANSWER], limit)
    pose = Pose.of(embedding.vertices)
    faceted, seams = embedding.polygons is not embedding.faces, embedding.seams.ends
    order = np.argsort(t.edge_halfedges[:, 0])  # the script finds the edges in that of the faces

    def entry(
        surface: Embedding, add: Callable[[Floats], dict[str, Any]], of: Sequence[Quantity]
    ) -> dict[str, Any]:
        return {
            "told": [],
            "mesh": 0,
            "concave": packed.add(_bits(surface.concave_edges[order])),
            "positions": add(pose.put(surface.vertices).ravel()),
            "values": {q.name: shades(q, add, surface.polygons) for q in of},
        }

    entries: list[dict[str, Any]] = []
    for frame in (earlier[k] for k in chosen[:-1]):
        surface = frame.surface(embedding)
        told = {"stage": frame.stage, "t": frame.t, "residual": frame.residual}
        entries.append(told | entry(surface, packed.add_short, _on_the_way(surface)))
    told = {"stage": ANSWER, "t": frames[-1].t if frames else None, "residual": embedding.residual}
    entries.append(told | entry(embedding, packed.add_floats, shown))
    for k, made in enumerate(entries):
        begins = k == 0 or made["stage"] != entries[k - 1]["stage"]
        made["pause"] = 3 * PAUSE if begins else PAUSE
    mesh = {
        "faces": packed.add(t.faces.ravel()),
        "polygons": packed.add(embedding.face_polygons) if faceted else None,
        "outlines": packed.add(_bits(embedding.polygon_edges[order])) if faceted else None,
        "solid": t.n_faces,
    }
    return {
        "meshes": [mesh],
        "first": len(entries) - 1,
        "seams": packed.add_floats(pose.put(seams).ravel()) if len(seams) else None,
        "pose": {"center": pose.center.tolist(), "axes": pose.axes.tolist(), "size": pose.size},
        "alone": _why_alone(embedding.method) if len(frames) == 1 else "",
        "camera": camera().ravel().tolist(),
        "ramp": ramp(COLORS),
        "quantities": [
            {
                "name": q.name,
                "label": _plain(q.label),
                "unit": UNITS.get(q.name, ""),
                "scale": q.scale,
                "at": q.at,
            }
            for q in shown
        ],
        "frames": entries,
    }, packed


def _why_alone(method: str) -> str:
    """Why there is no surface before the answer."""
    try:
        found = configuration(method)
    except InvalidParameter:  # it was passed as it is
        return ALONE
    return LEAPT if found.keeps_triangles and not found.shows_path else ALONE


def _on_the_way(surface: Embedding) -> list[Quantity]:
    """What changes from frame to frame: Gaussian curvature is that of the frame's own lengths."""
    metric, unit = surface.metric, surface.metric.unit
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):  # a frame may be folded flat
        found = [mean_curvature(surface), residual(surface), concavity(surface)]
        lengths = unit * edge_lengths(metric.edges, surface.vertices / unit)
        try:
            own = PolyhedralMetric.on(metric.triangulation, lengths)
        except InvalidMetric:  # a triangle without area has no curvature at its corners
            return found
        return [*found, intrinsic_curvature(shape(own, surface.vertices, surface.message))]


def shades(quantity: Quantity, add: Callable[[Floats], dict[str, Any]], polygons: Polygons) -> dict[str, Any]:
    """Values, of a logarithmic scale their logarithms, and where the colors begin and end."""
    values, bounds = quantity.values, np.array(quantity.bounds)
    if quantity.scale == "log":
        values, bounds = np.log10(values), np.log10(bounds)
    low, high = bounds.tolist()
    shades = {**add(values), "bounds": [low, high if low < high else low + 1.0]}
    if quantity.at == "faces":
        shades["faces"] = add(values)
    elif not isinstance(polygons, np.ndarray):
        shades["faces"] = add(face_means(values, polygons))
    return shades


def _bits(mask: Mask) -> NDArray[np.uint8]:
    return np.packbits(mask, bitorder="little")


def _plain(label: str) -> str:
    """A label without TeX."""
    for tex, text in TEX.items():
        label = label.replace(tex, text)
    return label
