"""The page for the browser, without a browser: what is in the file."""

import base64
import json
import os
import re
from html.parser import HTMLParser

import numpy as np
import pytest

import isoembed
import zoo
from isoembed import Embedding, PolyhedralMetric, embed, glue
from isoembed.gluing.classics import LATIN_CROSS
from isoembed.io import FileError
from isoembed.plot import Film, Frame, quantities
from isoembed.plot.browser.packing import Packed
from isoembed.plot.browser.ramp import ramp
from isoembed.plot.browser.report import number
from isoembed.plot.browser.thinning import thinned
from isoembed.plot.page import MAX_FRAMES, write_page
from lost_edges import octahedron_with_a_lost_edge
from regular_in_space import regular_solid
from strict_json import strict


class Elements(HTMLParser):
    """The tags of a page, and the text of its elements with an id."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.texts, self._open = [], {}, None
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.tags.append((tag, dict(attributes)))
        self._open = dict(attributes).get("id")

    def handle_data(self, data):
        if self._open:
            self.texts[self._open] = self.texts.get(self._open, "") + data

    def handle_endtag(self, tag):
        self._open = None


def unpacked(text, entry):
    """The numbers that `Packed` holds, as the script reads them."""
    kind = np.dtype(f"<{entry['type']}")
    stored = np.frombuffer(base64.b64decode(text), kind, entry["count"], entry["at"])
    if "step" not in entry:
        return stored
    values = entry["low"] + entry["step"] * stored.astype(float)
    return np.where(stored == 65535, np.nan, values) if kind == np.uint16 else values


def marked(data, arrays, bits):
    """The edges that have their bit, as the script reads them: in the order of the triangles, each once."""
    corners = unpacked(arrays, data["meshes"][0]["faces"]).reshape(-1, 3)
    halves = np.column_stack([corners.ravel(), np.roll(corners, -1, axis=1).ravel()]).astype(int)
    ends = halves[halves[:, 0] < halves[:, 1]]
    there = np.unpackbits(unpacked(arrays, bits), bitorder="little")[: len(ends)].astype(bool)
    return {tuple(pair) for pair in ends[there].tolist()}


def deformed(vertices, faces, factors, **options):
    """An ellipsoid, and frames from the sphere to it."""
    metric = PolyhedralMetric.from_mesh(vertices * factors, faces)
    shares = np.linspace(1.0, 0.0, options.pop("count", 5))
    frames = [
        Frame("start" if k < 2 else "pull back", t, 1e-9, vertices * (t + (1 - t) * factors))
        for k, t in enumerate(shares)
    ]
    return Embedding(metric, vertices * factors, method="exact", tolerance=1e-10, **options), frames


def read(path):
    text = path.read_text(encoding="utf-8")
    page = Elements(text)
    return text, page, json.loads(page.texts["data"]), page.texts["arrays"]


@pytest.fixture(scope="module")
def ellipsoid():
    return deformed(*zoo.icosphere(2), np.array([3.0, 2.0, 1.0]))


@pytest.fixture(scope="module")
def page(ellipsoid, tmp_path_factory):
    path = tmp_path_factory.mktemp("page") / "ellipsoid.html"
    surface, frames = ellipsoid
    write_page(path, surface, frames=frames)
    return read(path)


def test_it_loads_nothing(page):
    text, elements, _, _ = page
    for tag, attributes in elements.tags:
        assert "src" not in attributes
        assert tag not in ("iframe", "object", "embed", "img")
        assert attributes.get("href", "data:").startswith("data:")
        assert not any(
            name.startswith("on") or name == "style" for name in attributes
        )  # the policy forbids both
    assert "http" not in re.sub(r'http-equiv="Content-Security-Policy"', "", text)
    assert "url(" not in text and "@import" not in text
    policy = next(a["content"] for t, a in elements.tags if a.get("http-equiv") == "Content-Security-Policy")
    assert policy.startswith("default-src 'none'; img-src data:;")


def test_nothing_is_left_of_the_template(page):
    assert "{{" not in page[0]


def test_the_vertices_are_there(page, ellipsoid):
    _, _, data, arrays = page
    surface, frames = ellipsoid
    pose = data["pose"]
    assert len(data["frames"]) == len(frames)
    for entry, frame, precision in zip(data["frames"], frames, [2**-16] * 4 + [2**-23], strict=True):
        placed = unpacked(arrays, entry["positions"]).reshape(-1, 3)
        vertices = placed @ np.transpose(pose["axes"]) * pose["size"] + pose["center"]
        np.testing.assert_allclose(vertices, frame.vertices, atol=1.7 * precision * np.ptp(frame.vertices))
        assert (entry["stage"] == frame.stage) == (frame is not frames[-1])
        assert entry["t"] == frame.t
    (mesh,) = data["meshes"]
    np.testing.assert_array_equal(unpacked(arrays, mesh["faces"]).reshape(-1, 3), surface.faces)
    assert mesh["solid"] == len(surface.faces)
    np.testing.assert_allclose(np.linalg.norm(placed, axis=1).max(), 1.0)


def test_quantities_of_both_signs_have_their_own_colors(page):
    own = {quantity["name"]: quantity["ramp"] for quantity in page[2]["quantities"]}
    assert {name for name, colors in own.items() if colors} == {"conformal factor"}  # H, K > 0
    low, high = page[2]["frames"][-1]["values"]["conformal factor"]["bounds"]
    zero = round(len(own["conformal factor"]) * -low / (high - low))
    amounts = [[int(color[k : k + 2], 16) for k in (1, 3, 5)] for color in own["conformal factor"]]
    assert amounts[0][2] > amounts[0][0] and amounts[-1][0] > amounts[-1][2]  # blue, orange
    assert min(amounts[zero]) > 190


def test_the_colors_are_those_of_the_quantities(page, ellipsoid):
    _, _, data, arrays = page
    surface, frames = ellipsoid
    answer = data["frames"][-1]["values"]
    for quantity in quantities(surface):
        values = unpacked(arrays, answer[quantity.name])
        expected = np.log10(quantity.values) if quantity.scale == "log" else quantity.values
        np.testing.assert_allclose(values, expected, rtol=1e-6, atol=1e-6)
        low, high = answer[quantity.name]["bounds"]
        assert low < high
    # The first frame is the unit sphere: H = K = 1 up to the triangles.
    sphere = data["frames"][0]["values"]
    for name in ("mean curvature", "Gaussian curvature"):
        np.testing.assert_allclose(np.median(unpacked(arrays, sphere[name])), 1.0, rtol=0.03)
    # Its lengths are wrong by as much as the axes are.
    edges = surface.metric.edges
    lengths = [np.linalg.norm(np.subtract(*x.vertices[edges.T]), axis=1) for x in (frames[0], frames[-1])]
    worst = np.max(np.abs(lengths[0] - lengths[1])) / np.mean(lengths[1])
    assert 10 ** unpacked(arrays, sphere["residual"]).max() == pytest.approx(worst)


def test_concave_edges_are_marked(tmp_path):
    # A deep dent in an icosahedron: all five edges at its bottom, and the answer without it none.
    vertices, faces = zoo.icosahedron()
    dented = vertices.copy()
    dented[0] *= -0.2
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    surface = Embedding(metric, vertices, method="exact", tolerance=1e-10)
    frames = [Frame("dented", 1.0, None, dented), Frame("answer", 0.0, 0.0, vertices)]
    write_page(tmp_path / "a.html", surface, frames=frames)
    _, _, data, arrays = read(tmp_path / "a.html")
    first, last = (marked(data, arrays, frame["concave"]) for frame in data["frames"])
    assert first == {(a, b) for a, b in metric.edges.tolist() if 0 in (a, b)}
    assert not last
    share = unpacked(arrays, data["frames"][0]["values"]["concave edges"])
    assert share[0] == 1
    assert np.count_nonzero(share) == 6


def test_boundaries_are_in_the_page(page, tmp_path):
    metric = PolyhedralMetric([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]], [1.0] * 8)
    write_page(tmp_path / "a.html", embed(metric, boundary="plane"))
    _, _, data, arrays = read(tmp_path / "a.html")
    ends = unpacked(arrays, data["meshes"][0]["boundary"]).reshape(-1, 2)
    assert ends.tolist() == [[0, 1], [0, 3], [1, 2], [2, 3]]
    assert page[2]["meshes"][0]["boundary"] is None


def test_a_message_cannot_break_out(ellipsoid, tmp_path):
    surface, frames = ellipsoid
    evil = "</script><script>alert(1)</script> & <!-- {{json}}"
    frames = [Frame(evil, 1.0, None, frames[0].vertices), *frames[1:]]
    marked = surface._with_message(evil)
    write_page(tmp_path / "a.html", marked, frames=frames, title=evil, caption=evil)
    _, elements, data, _ = read(tmp_path / "a.html")
    assert [tag for tag, _ in elements.tags].count("script") == 3
    assert data["frames"][0]["stage"] == evil
    link = next(attributes["href"] for _, attributes in elements.tags if attributes.get("id") == "json")
    report = json.loads(base64.b64decode(link.partition(",")[2]))
    assert report == json.loads(json.dumps(isoembed.report(marked)))


def test_what_has_no_value_is_missing(tmp_path):
    # At the ends of a needle the circumcentric dual area is negative.
    points = np.array([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.05]])
    metric = PolyhedralMetric.from_mesh(points, zoo.TETRAHEDRON)
    write_page(tmp_path / "a.html", Embedding(metric, points, method="exact", tolerance=1e-10))
    _, _, data, arrays = read(tmp_path / "a.html")
    values = unpacked(arrays, data["frames"][0]["values"]["Gaussian curvature"])
    assert np.isnan(values).any()
    assert np.isfinite(values).any()


def test_a_frame_whose_lengths_no_surface_has(ellipsoid, tmp_path):
    surface, frames = ellipsoid
    lost = Frame("lost", 0.5, np.inf, frames[0].vertices)
    write_page(tmp_path / "a.html", surface, frames=[lost, frames[-1]])
    assert [entry["residual"] for entry in read(tmp_path / "a.html")[2]["frames"]] == [None, surface.residual]


def test_a_frame_without_area(ellipsoid, tmp_path):
    surface, frames = ellipsoid
    flat = frames[0].vertices * [1.0, 0.0, 0.0]
    write_page(tmp_path / "a.html", surface, frames=[Frame("folded", 1.0, None, flat), frames[-1]])
    _, _, data, _ = read(tmp_path / "a.html")
    assert "Gaussian curvature" not in data["frames"][0]["values"]


def test_a_name_that_is_no_text(ellipsoid, tmp_path):
    write_page(tmp_path / "a.html", ellipsoid[0], title=os.fsdecode(b"\xff.ply"))
    assert "<h1>?.ply</h1>" in (tmp_path / "a.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("radius", [1e-154, 1e-150, 1e12])
def test_any_size(radius, tmp_path):
    surface, frames = deformed(*zoo.icosphere(1), radius * np.array([1.0, 1.0, 0.5]))
    write_page(tmp_path / "a.html", surface, frames=frames[-1:])
    _, _, data, arrays = read(tmp_path / "a.html")
    curvature = unpacked(arrays, data["frames"][0]["values"]["mean curvature"])
    np.testing.assert_allclose(curvature, surface.mean_curvature, rtol=1e-6)


def test_residuals_within_rounding_are_left_out(tmp_path):
    surface, _ = deformed(*zoo.icosphere(1), np.ones(3))
    write_page(tmp_path / "a.html", surface)
    text, _, data, _ = read(tmp_path / "a.html")
    assert "residual" not in [q["name"] for q in data["quantities"]]
    assert "largest length error" not in text


@pytest.mark.parametrize(
    ("method", "said"), [("aim", "'paper' has them"), ("alexandrov", "no intermediate surfaces")]
)
def test_an_answer_without_a_way_to_it(method, said, tmp_path):
    film = Film()
    surface = embed(PolyhedralMetric.from_mesh(*zoo.icosphere(1)), method=method, progress=film)
    write_page(tmp_path / "a.html", surface, frames=film.frames(surface))
    _, _, data, _ = read(tmp_path / "a.html")
    assert said in data["alone"]
    assert len(data["frames"]) == 1
    assert "residual" in [q["name"] for q in data["quantities"]]  # something was computed
    write_page(tmp_path / "b.html", surface)  # without a film there is nothing to explain
    assert read(tmp_path / "b.html")[2]["alone"] == ""


def test_a_convex_polyhedron(tmp_path):
    vertices, faces = zoo.cube()
    write_page(tmp_path / "a.html", embed(PolyhedralMetric.from_mesh(vertices, faces), method="alexandrov"))
    text, _, data, _ = read(tmp_path / "a.html")
    assert data["quantities"]
    assert "<caption>Polyhedron</caption>" in text
    assert "<caption>Certificate</caption>" in text


def test_a_polyhedron_with_an_edge_that_is_not_found(tmp_path):
    lost = octahedron_with_a_lost_edge()
    write_page(tmp_path / "a.html", lost, frames=[Frame("answer", None, None, lost.vertices)])
    text, elements, data, _ = read(tmp_path / "a.html")
    assert data["frames"][-1]["residual"] is None
    assert 'scope="row">along the given edges</th><td>\N{EN DASH}</td>' in text
    link = next(attributes["href"] for _, attributes in elements.tags if attributes.get("id") == "json")
    assert strict(base64.b64decode(link.partition(",")[2]))["residual"]["max"] is None


def test_another_ending_is_refused(ellipsoid, tmp_path):
    with pytest.raises(FileError, match=r"not one of \.html"):
        write_page(tmp_path / "a.htm", ellipsoid[0])


def test_films_are_thinned(tmp_path):
    surface, frames = deformed(*zoo.icosphere(0), np.array([2.0, 1.0, 1.0]), count=101)
    write_page(tmp_path / "a.html", surface, frames=frames)
    entries = read(tmp_path / "a.html")[2]["frames"]
    assert len(entries) == MAX_FRAMES
    kept = [round(100 * (1 - entry["t"])) for entry in entries]
    assert {0, 1, 2, 100} <= set(kept)  # the first and last frame of each stage
    assert max(np.diff(kept)) <= 4


@pytest.mark.parametrize("limit", range(1, 14))
def test_stages_keep_their_ends(limit):
    stages = ["a"] * 7 + ["b"] * 1 + ["c"] * 30 + ["answer"]
    kept = thinned(stages, limit)
    assert len(kept) == limit
    assert kept == sorted(set(kept))
    assert kept[-1] == 38
    if limit >= 6:
        assert {0, 6, 7, 8, 37, 38} <= set(kept)


def test_all_frames_stay_if_they_may():
    assert thinned(["a", "b", "c"], 3) == [0, 1, 2]


def test_sixteen_bits():
    packed, values = Packed(), np.array([-1.0, np.nan, 3.0, 0.7])
    packed.add(np.array([1, 2, 3], dtype=np.uint8))
    some, same, none = (packed.add_short(v) for v in (values, np.full(2, 5.0), np.full(2, np.nan)))
    np.testing.assert_allclose(unpacked(packed.text, some), values, atol=4.0 / 65534 / 2)
    np.testing.assert_array_equal(unpacked(packed.text, same), 5.0)
    assert np.isnan(unpacked(packed.text, none)).all()


def test_the_ramp_rises_evenly_in_lightness():
    colors = np.array([[int(c[k : k + 2], 16) for k in (1, 3, 5)] for c in ramp(65)]) / 255
    linear = np.where(colors <= 0.04045, colors / 12.92, ((colors + 0.055) / 1.055) ** 2.4)
    luminance = linear @ [0.2126, 0.7152, 0.0722]
    lightness = 116 * np.cbrt(luminance) - 16  # of CIE 1976
    steps = np.diff(lightness)
    assert steps.min() > 0.3 * steps.mean() > 0
    assert np.ptp(lightness) > 55


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, "\u2013"),
        (1234, "1,234"),
        (0.0, "0"),
        (26.376123, "26.3761"),
        (-0.5, "\u22120.5"),
        (3.14e-15, "3.14\u00a0\u00d7\u00a010⁻¹⁵"),
        (1e300, "1\u00a0\u00d7\u00a010³⁰⁰"),
    ],
)
def test_numbers(value, text):
    assert number(value) == text


def test_the_faces_and_seams_of_a_polyhedron(tmp_path):
    pairs = [(0, 3), (1, 2), (4, 7), (5, 6), (8, 9), (10, 13), (11, 12)]
    solid = embed(glue([LATIN_CROSS], [((0, i), (0, k)) for i, k in pairs]), method="alexandrov")
    write_page(tmp_path / "a.html", solid)
    text, _, data, arrays = read(tmp_path / "a.html")
    assert "8 vertices, 8 faces" in text
    (mesh,) = data["meshes"]
    np.testing.assert_array_equal(unpacked(arrays, mesh["polygons"]), solid.surface.flat_faces.of_triangles)
    outlines = solid.metric.edges[solid.surface.flat_faces.edges].tolist()
    assert marked(data, arrays, mesh["outlines"]) == {tuple(pair) for pair in outlines}
    pose, ends = data["pose"], unpacked(arrays, data["seams"]).reshape(-1, 3)
    placed = ends @ np.transpose(pose["axes"]) * pose["size"] + pose["center"]
    np.testing.assert_allclose(placed, solid.surface.seams.ends.reshape(-1, 3), atol=1e-6)
    values = data["frames"][-1]["values"]
    means = [solid.mean_curvature[polygon].mean() for polygon in solid.polygons]
    np.testing.assert_allclose(unpacked(arrays, values["mean curvature"]["faces"]), means, rtol=1e-6)
    np.testing.assert_allclose(
        unpacked(arrays, values["sides"]["faces"]), solid.surface.flat_faces.sides, rtol=1e-6
    )
    assert [q["at"] for q in data["quantities"] if q["name"] == "sides"] == ["faces"]


def test_other_surfaces_have_neither(page):
    _, _, data, _ = page
    (mesh,) = data["meshes"]
    assert mesh["polygons"] is mesh["outlines"] is data["seams"] is None
    assert all("faces" not in shades for shades in data["frames"][-1]["values"].values())


def test_points_of_space_are_there(tmp_path):
    """The script is told points about the origin, from which it makes each model."""
    solid = regular_solid("octahedron", -4.0, 1.7)
    metric = PolyhedralMetric.from_mesh(solid.points, solid.faces, curvature=-4.0)
    surface = Embedding(metric, solid.points, method="exact", tolerance=1e-10)
    write_page(tmp_path / "solid.html", surface)
    text, _, data, arrays = read(tmp_path / "solid.html")
    pose, space, (mesh,) = data["pose"], data["space"], data["meshes"]
    assert pose["center"] == [0, 0, 0]
    assert space["curvature"] == pytest.approx(-4.0 * pose["size"] ** 2)
    assert [model["model"] for model in space["models"]] == ["conformal", "projective", "ambient"]
    (frame,) = data["frames"]
    placed = unpacked(arrays, frame["positions"]).reshape(-1, 3) @ np.transpose(pose["axes"]) * pose["size"]
    np.testing.assert_allclose(placed[:6], solid.points, atol=1e-6)
    assert mesh["cuts"] > 0 and mesh["solid"] == 8 * 4 ** mesh["cuts"]
    own = unpacked(arrays, mesh["own"])
    np.testing.assert_array_equal(own[:6], np.arange(6))
    assert len(own) == len(placed) == len(unpacked(arrays, frame["values"]["mean curvature"]))
    assert len(unpacked(arrays, mesh["polygons"])) == mesh["solid"]
    edges = {tuple(sorted(pair)) for pair in marked(data, arrays, mesh["outlines"])}
    assert len(edges) == 12 * 2 ** mesh["cuts"]
    assert "hyperbolic space of curvature \N{MINUS SIGN}4" in text


def test_pages_of_r3_have_no_models(page):
    _, _, data, _ = page
    assert data["space"] is None
    assert data["meshes"][0]["own"] is None
