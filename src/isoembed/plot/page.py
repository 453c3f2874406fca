"""Interactive page of a surface for the browser: colors, film and report in one HTML file."""

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from isoembed.arrays import Floats, Indices, Mask
from isoembed.embedding.embedding import Embedding
from isoembed.embedding.report import report
from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.io.files import Writer, write_atomically
from isoembed.io.format import Polygons
from isoembed.io.registry import check_output
from isoembed.methods import method_class
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.plot.browser.document import Document
from isoembed.plot.browser.packing import Packed
from isoembed.plot.browser.ramp import diverging, ramp
from isoembed.plot.browser.report import number, report_html, tables_html
from isoembed.plot.browser.thinning import thinned
from isoembed.plot.caption import faces_counted, has_own_lengths, of_integral
from isoembed.plot.coloring import (
    EMPTY,
    Quantity,
    concavity,
    face_means,
    intrinsic_curvature,
    mean_curvature,
    quantities,
    residual,
    sides,
)
from isoembed.plot.curved_space import BALL_RADIUS, Drawn
from isoembed.plot.endings import PAGE_ENDINGS
from isoembed.plot.film import ANSWER, Frame
from isoembed.plot.pieces import Pieces
from isoembed.plot.view import Pose, camera
from isoembed.space import Space
from isoembed.space.models import MODELS
from isoembed.strict_json import plain
from isoembed.surface.flat_faces import FlatFaces

MAX_FRAMES = 40  # in a page
LEAPT = (
    "This method reached the surface in one step, without intermediate surfaces; the method 'paper' has them."
)
ALONE = "This method has no intermediate surfaces."
PAUSE = 140  # milliseconds from one frame to the next
COLORS = 65  # interpolated by the browser
UNITS = {
    "mean curvature": "1 / length",
    "Gaussian curvature": "1 / length²",
    "residual": "",
    "concave edges": "",
    "conformal factor": "",
}
TITLES = {
    "hyperbolic": {"conformal": "Poincaré ball", "projective": "Klein ball", "ambient": "hyperboloid, x y z"},
    "spherical": {"conformal": "stereographic", "projective": "gnomonic", "ambient": "sphere, x y z"},
}
"""Names on the page of the models of a space."""
TEX = {"$": "", "k_1": "k₁", "k_2": "k₂", "  ": " "}


def page_writer(
    path: str | os.PathLike[str], embedding: Embedding, *, title: str = "", **contents: Any
) -> Writer:
    """Writer of the page of a surface; see `write_atomically` and `write_page`."""
    return _page(embedding, title or Path(path).stem, **contents).writer


def page_html(embedding: Embedding, *, title: str, **contents: Any) -> str:
    """HTML of the page of a surface; see `write_page`."""
    return _page(embedding, title, **contents).text


def write_page(
    path: str | os.PathLike[str],
    embedding: Embedding,
    *,
    frames: Sequence[Frame] = (),
    title: str = "",
    caption: str = "",
    beside: str = "",
    given: Mapping[str, Quantity] = EMPTY,
) -> None:
    """Write a self-contained page for the browser.

    The page shows the surface in WebGL, colored by any quantity of `isoembed.plot.quantities`; at most 40
    frames of a film; and the report, with its JSON for download.  The vertices are in single precision in
    units of the half diameter; positions and colors of frames before the last are 16-bit.

    Parameters
    ----------
    path : path
        Ending in ``.html``.
    embedding : Embedding
    frames : sequence of Frame
        `Film.frames`; the last one is the embedding itself.
    title : str
        Title of the page; by default the file name.
    caption : str
        Line below the surface; by default the numbers of vertices and faces, int H dA and the residual.
    beside : str
        HTML above the report.
    given : mapping of str to Quantity
        See `isoembed.plot.coloring.quantities`.

    Raises
    ------
    FileError
        The ending is unknown or the file cannot be written.
    """
    check_output(path, PAGE_ENDINGS)
    writer = page_writer(
        path, embedding, title=title, frames=frames, caption=caption, beside=beside, given=given
    )
    write_atomically({Path(path): writer})


def _page(
    embedding: Embedding,
    title: str,
    *,
    frames: Sequence[Frame] = (),
    caption: str = "",
    beside: str = "",
    tables: Mapping[str, Mapping[str, Any]] | None = None,
    given: Mapping[str, Quantity] = EMPTY,
) -> Document:
    """Page of a surface; `tables`, by caption, replace those of the report."""
    data, arrays = _data(embedding, frames, given)
    if tables is None:
        found = report(embedding)
        report_markup = report_html(found)
    else:
        found, report_markup = dict(tables), tables_html(tables)
    return Document(title, caption or _caption(embedding), beside + report_markup, found, data, arrays)


def _caption(embedding: Embedding) -> str:
    t, total = embedding.triangulation, embedding.integrated_mean_curvature
    words = [
        f"{t.n_vertices:,} vertices, {faces_counted(embedding)}",
        f"∫ H dA{of_integral(embedding)} = {number(total)}",
    ]
    if not has_own_lengths(embedding):
        words.append(f"largest length error {number(plain(embedding.residual))} of the mean edge")
    if not embedding.space.is_euclidean:
        space = embedding.space
        words.append(f"{space.name} space of curvature {number(space.curvature)}")
    return " · ".join(words)


def _data(
    embedding: Embedding, frames: Sequence[Frame], given: Mapping[str, Quantity]
) -> tuple[dict[str, Any], Packed]:
    """Data for the script: a JSON object, and the arrays that it refers to."""
    packed, drawn = Packed(), Drawn.of(embedding)
    pieces = drawn.pieces
    earlier = list(frames[:-1])
    own = not earlier and has_own_lengths(embedding)
    shown = [q for q in quantities(embedding, given) if not (own and q.name == "residual")]
    size = pieces.n_vertices * (6 + 2 * len(shown)) + len(pieces.faces) * 3 / 16
    # All frames but the last have at most 6 MB, before base64 encoding.
    limit = int(min(MAX_FRAMES, 1 + 6_000_000 // size))
    chosen = thinned([frame.stage for frame in earlier] + [ANSWER], limit)
    pose, seams = _pose(drawn, [earlier[k] for k in chosen[:-1]]), drawn.seams_in_space().ends
    edges = pieces.edges_of_faces()  # the script finds them in this order

    def entry(
        surface: Embedding, add: Callable[[Floats], dict[str, Any]], of: Sequence[Quantity]
    ) -> dict[str, Any]:
        return {
            "remarks": [],
            "mesh": 0,
            "concave": packed.add(_bits(edges, surface.surface.concave_edges)),
            "positions": add(pose.put(drawn.points(surface.vertices)).ravel()),
            "values": {q.name: shades(drawn.spread(q), add, surface.polygons) for q in of},
        }

    entries: list[dict[str, Any]] = []
    for frame in (earlier[k] for k in chosen[:-1]):
        surface = frame.surface(embedding)
        facts = {"stage": frame.stage, "t": frame.t, "residual": frame.residual}
        entries.append(facts | entry(surface, packed.add_short, _on_the_way(surface)))
    facts = {"stage": ANSWER, "t": frames[-1].t if frames else None, "residual": embedding.residual}
    entries.append(facts | entry(embedding, packed.add_floats, shown))
    for k, entry_ in enumerate(entries):
        begins = k == 0 or entry_["stage"] != entries[k - 1]["stage"]
        entry_["pause"] = 3 * PAUSE if begins else PAUSE
    return {
        "meshes": [_mesh(embedding, pieces, edges, packed)],
        "first": len(entries) - 1,
        "seams": packed.add_floats(pose.put(seams).ravel()) if len(seams) else None,
        "space": _space(drawn.space, pose.size),
        "pose": {"center": pose.center.tolist(), "axes": pose.axes.tolist(), "size": pose.size},
        "alone": _why_alone(embedding.method) if len(frames) == 1 else "",
        "camera": camera().ravel().tolist(),
        "ramp": ramp(COLORS),
        "quantities": [_named(q) for q in shown],
        "frames": entries,
    }, packed


def _bits(edges: Indices, mask: Mask) -> NDArray[np.uint8]:
    """Packed mask (E,) at the edges of the faces' sides; -1 denotes the inside of a face."""
    return np.packbits((edges >= 0) & mask[edges], bitorder="little")


def _mesh(embedding: Embedding, pieces: Pieces, edges: Indices, packed: Packed) -> dict[str, Any]:
    """Drawn triangles and the faces that contain them."""
    faces, t = embedding.surface.flat_faces, embedding.triangulation
    faceted = pieces.cuts > 0 or isinstance(faces, FlatFaces)
    return {
        "faces": packed.add(pieces.faces.ravel()),
        "polygons": packed.add(np.repeat(faces.of_triangles, pieces.per_face)) if faceted else None,
        "outlines": packed.add(_bits(edges, faces.edges)) if faceted else None,
        "boundary": None if t.is_closed else packed.add(t.edges[t.boundary_edges].ravel()),
        "solid": len(pieces.faces),
        "cuts": pieces.cuts,
        "own": packed.add(pieces.nearest()) if pieces.cuts else None,
    }


def _named(quantity: Quantity) -> dict[str, Any]:
    """Names of a quantity for the script, and its color ramp if it has its own."""
    return {
        "name": quantity.name,
        "label": _plain(quantity.label),
        "unit": UNITS.get(quantity.name, ""),
        "scale": quantity.scale,
        "at": quantity.at,
        "ramp": own_ramp(quantity.scale, *quantity.bounds),
    }


def own_ramp(scale: str, low: float, high: float) -> list[str] | None:
    """Diverging colors for values of both signs; None for the default ramp."""
    return diverging(COLORS, low, high) if scale == "linear" and low < 0 < high else None


def _pose(drawn: Drawn, frames: Sequence[Frame]) -> Pose:
    """Pose of points of space; in curved space the origin, the center of the models, stays fixed.

    If a frame is much larger than the final surface, as a net is, the picture is scaled to the frame.
    """
    vertices = drawn.surface.vertices
    pose = drawn.pose(vertices)
    if drawn.space.is_euclidean:
        reach = max((np.linalg.norm(pose.put(one.vertices), axis=1).max() for one in frames), default=1.0)
        # Surfaces up to a quarter larger than the final one fit into the picture.
        return pose if reach < 1.25 else replace(pose, size=pose.size * float(reach))
    return Pose(np.zeros(3), pose.axes, float(np.linalg.norm(drawn.points(vertices), axis=1).max()))


def _space(space: Space, unit: float) -> dict[str, Any] | None:
    """Curvature in the given unit of length, and the models offered on the page; None for R^3."""
    if space.is_euclidean:
        return None
    models = [{"model": model, "name": TITLES[space.name][model]} for model in MODELS]
    return {"curvature": space.curvature * unit * unit, "farthest": BALL_RADIUS, "models": models}


def _why_alone(method: str) -> str:
    """Explanation for the lack of intermediate surfaces."""
    try:
        found = method_class(method)
    except InvalidParameter:  # the method is not registered
        return ALONE
    return LEAPT if found.keeps_triangles and not found.shows_path else ALONE


def _on_the_way(surface: Embedding) -> list[Quantity]:
    """Quantities of a frame; its Gaussian curvature is that of its own lengths."""
    metric, unit = surface.metric, surface.metric.unit
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):  # a frame may be folded flat
        found = [mean_curvature(surface), residual(surface), concavity(surface)]
        found += [] if (counted := sides(surface)) is None else [counted]
        a, b = metric.edges.T
        points = surface.vertices / unit
        lengths = unit * metric.normalized.space.distances(points[a], points[b])
        try:
            own = PolyhedralMetric.on(metric.triangulation, lengths, metric.space)
        except InvalidMetric:  # degenerate triangles have no angles
            return found
        return [*found, intrinsic_curvature(Embedding(own, surface.vertices, method="", tolerance=1.0))]


def shades(quantity: Quantity, add: Callable[[Floats], dict[str, Any]], polygons: Polygons) -> dict[str, Any]:
    """Values, or their logarithms on a logarithmic scale, and the limits of the colors."""
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


def _plain(label: str) -> str:
    """Label without TeX."""
    for tex, text in TEX.items():
        label = label.replace(tex, text)
    return label
