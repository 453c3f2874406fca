"""The page in a real browser: what is drawn, and what its controls do.  Needs Playwright and a Chromium."""

import re

import numpy as np
import pytest

import zoo

pytest.importorskip("playwright.sync_api", reason="pages are tried out in a browser by playwright")
pytest.importorskip("matplotlib.image", reason="screenshots are read by matplotlib")

from browser_tab import CHROMIUM, Tab, chromium
from isoembed import Embedding, PolyhedralMetric, embed, glue
from isoembed.embedding.polyhedron import Polyhedron
from isoembed.gluing.classics import LATIN_CROSS
from isoembed.plot import Frame
from isoembed.plot.coloring import intrinsic_curvature
from isoembed.plot.notebook import notebook_html
from isoembed.plot.page import write_page
from regular_in_space import regular_solid

if CHROMIUM is None:
    pytest.skip("pages are tried out in Chromium, which is not installed", allow_module_level=True)

EVIL = "</script><script>throw Error('out')</script> <!-- & \u2028 \""


@pytest.fixture(scope="module")
def browser():
    with chromium() as started:
        yield started


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    """A sphere that becomes a dented ellipsoid, with a message that wants to break out."""
    path = tmp_path_factory.mktemp("page") / "dented.html"
    vertices, faces = zoo.icosphere(2)
    target = vertices * [2.0, 1.2, 0.8]
    target[::7] *= 0.8
    target -= target.mean(axis=0)
    metric = PolyhedralMetric.from_mesh(target, faces)
    surface = Embedding(metric, target, method="exact", tolerance=1e-10, message=EVIL)
    frames = [
        Frame("start" if t == 1 else "pull back", t, 1e-9, t * vertices + (1 - t) * target)
        for t in np.linspace(1.0, 0.0, 5)
    ]
    write_page(path, surface, frames=frames, title=EVIL)
    return path


@pytest.fixture(scope="module")
def desktop(browser, file):
    window = Tab(browser, file, viewport={"width": 900, "height": 720})
    yield window
    window.context.close()


@pytest.fixture
def tab(desktop, tmp_path):
    yield desktop.open()
    desktop.page.screenshot(path=tmp_path / "screen.png")
    assert desktop.requests == [desktop.file.as_uri()]
    assert desktop.complaints == []


def differing(one, other):
    """The share of the pixels that differ."""
    return (np.abs(one - other).max(axis=2) > 0.02).mean()


def test_a_surface_is_drawn(tab):
    shape, pixels = tab.shape(), tab.pixels()[:, 70:-70]
    assert 0.1 < shape.mean() < 0.8
    assert shape[shape.shape[0] // 2, shape.shape[1] // 2]
    colors = np.unique((6 * pixels[shape]).astype(int), axis=0)
    assert len(colors) > 20


def test_the_camera_is_that_of_the_pictures(tab):
    # The longest axis lies across: half of it is the half diameter.
    rows, columns = np.nonzero(tab.shape())
    assert np.ptp(columns) > 1.4 * np.ptp(rows)


def test_another_quantity_has_other_colors(tab):
    seen = [tab.pixels()]
    for name in ("Gaussian curvature", "concave edges", "conformal factor"):
        tab.page.select_option("#color", name)
        seen.append(tab.pixels())
        assert differing(seen[-2], seen[-1]) > 0.02
        assert name.split()[0] in tab.text("#label")
        assert tab.page.locator("#ticks span").count() >= 2


def test_concave_edges_are_dark_lines(tab):
    before = tab.pixels()
    tab.page.check("#creases")
    after = tab.pixels()
    darker = (after.max(axis=2) < 0.2) & (before.max(axis=2) > 0.2)
    assert darker.sum() > 50


def test_the_mesh_and_smooth_shading(tab):
    everything = tab.pixels()
    tab.page.uncheck("#mesh")
    plain = tab.pixels()
    assert plain.mean() > everything.mean()  # the lines were dark
    tab.page.check("#smooth")
    assert differing(plain, tab.pixels()) > 0.005


def test_the_slider_shows_the_way(tab):
    def slide(k):
        tab.page.locator("#frame").fill(str(k))
        return tab.shape()

    answer = tab.shape()
    words = tab.text("#moment")
    assert words.startswith("answer · frame 5 of 5 · t = 0")
    sphere = slide(0)
    rows, columns = np.nonzero(sphere)
    assert np.ptp(columns) == pytest.approx(np.ptp(rows), rel=0.05)  # a sphere
    height, width = sphere.shape
    assert abs(columns.mean() - width / 2) < 3
    assert abs(rows.mean() - height / 2) < 3
    first = tab.text("#moment")
    assert first.startswith("start · frame 1 of 5 · t = 1")
    assert "0 concave edges" in first
    middle = slide(2)
    assert "pull back · frame 3 of 5 · t = 0.5" in tab.text("#moment")
    assert (middle != answer).mean() > 0.01
    np.testing.assert_array_equal(slide(4), answer)
    assert tab.text("#moment") == words


def test_the_film_plays_to_its_end(tab):
    # The page itself notes what it shows: a slow machine may miss frames from outside.
    tab.page.evaluate(
        """() => {
            window.noted = [];
            const note = () => noted.push(document.getElementById("frame").value);
            new MutationObserver(note).observe(document.getElementById("moment"), { childList: true });
            new MutationObserver(() => noted.push(document.getElementById("play").getAttribute("aria-label")))
                .observe(document.getElementById("play"), { attributes: true });
        }"""
    )
    tab.page.click("#play")
    tab.page.locator("#play[aria-label=Play]").wait_for()
    assert tab.page.evaluate("noted") == ["0", "Pause", "1", "2", "3", "4", "Play"]
    assert "frame 5 of 5" in tab.text("#moment")


def test_turning_zooming_and_going_back(tab):
    box = tab.page.locator("#canvas").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    first = tab.pixels()

    def drag():
        tab.page.mouse.move(x, y)
        tab.page.mouse.down()
        tab.page.mouse.move(x + 80, y + 60, steps=3)
        tab.page.mouse.up()
        tab.page.mouse.move(2, 2)

    def keys():
        tab.page.focus("#canvas")
        for key in ("ArrowLeft", "ArrowUp", "ArrowLeft"):
            tab.page.keyboard.press(key)

    def wheel():
        tab.page.mouse.move(x, y)
        tab.page.mouse.wheel(0, 400)
        tab.page.mouse.move(2, 2)

    seen = [first]
    for change in (drag, keys, wheel, lambda: tab.page.click("#closer")):
        change()
        seen.append(tab.pixels())
        assert differing(seen[-2], seen[-1]) > 0.02
    tab.page.click("#reset")
    tab.page.mouse.move(2, 2)
    assert differing(first, tab.pixels()) < 1e-3


def test_turning_follows_the_hand(tab):
    # What is under the pointer at the front moves with it.
    box = tab.page.locator("#canvas").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    tab.page.mouse.move(x, y)
    before = tab.text("#tip b")
    tab.page.mouse.down()
    tab.page.mouse.move(x + 24, y + 10, steps=4)
    tab.page.mouse.up()
    mark = tab.page.locator("#mark").bounding_box()
    tab.page.mouse.move(x + 24, y + 10)
    assert tab.text("#tip b") == before
    assert abs(mark["x"] + mark["width"] / 2 - (x + 24)) < 40


def test_the_vertex_under_the_pointer_is_named(tab):
    box = tab.page.locator("#canvas").bounding_box()
    tab.page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    assert tab.page.locator("#mark").is_visible()
    words = tab.text("#tip")
    assert words.startswith("vertex ")
    assert "mean curvature" in words
    tab.page.mouse.move(box["x"] + 3, box["y"] + 3)
    assert not tab.page.locator("#mark").is_visible()


@pytest.mark.parametrize("size", [1.0, 1e-150])
def test_what_has_no_value_is_gray(browser, size, tmp_path):
    # Where a triangle is obtuse, the circumcentric dual area of its sharp corners may be negative.
    points = size * np.array([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.3, 0.0], [0.0, 0.0, 0.6]])
    metric = PolyhedralMetric.from_mesh(points, zoo.TETRAHEDRON)
    surface = Embedding(metric, points, method="exact", tolerance=1e-10)
    frames = [Frame("same", None, None, points), Frame("answer", 0.0, 0.0, points)]
    write_page(tmp_path / "needle.html", surface, frames=frames)
    tab = Tab(browser, tmp_path / "needle.html", viewport={"width": 500, "height": 600}).open()
    tab.page.select_option("#color", "Gaussian curvature")
    tab.page.uncheck("#mesh")
    missing = int(np.isnan(intrinsic_curvature(surface).values).sum())
    assert 0 < missing < 4
    for frame in (1, 0):
        tab.page.locator("#frame").fill(str(frame))
        assert f"gray: no value at {missing} vert" in tab.text("#span")
        colors = tab.pixels()[:, 70:-70][tab.shape()]
        assert (np.ptp(colors, axis=1) < 0.05).mean() > 0.1
    assert tab.complaints == []
    tab.context.close()


def test_an_answer_without_a_way_to_it(browser, tmp_path):
    surface = embed(PolyhedralMetric.from_mesh(*zoo.icosphere(1)))
    write_page(tmp_path / "alone.html", surface, frames=[Frame("answer", 0.0, 0.0, surface.vertices)])
    tab = Tab(browser, tmp_path / "alone.html").open()
    assert "in one step" in tab.text("#alone")
    assert not tab.page.locator("#film").is_visible()
    tab.context.close()


def test_light_and_dark(tab):
    light = tab.pixels()[5, 5].mean()
    tab.page.emulate_media(color_scheme="dark")
    dark = tab.pixels()[5, 5].mean()
    assert light > 0.8
    assert dark < 0.2
    tab.page.click("#theme")
    assert tab.pixels()[5, 5].mean() == pytest.approx(light)


def test_the_report_is_beside_it(tab):
    assert tab.text(".message") == EVIL.replace("\u2028", " ") or EVIL[:40] in tab.text(".message")
    assert "area" in tab.text("aside")
    with tab.page.expect_download() as download:
        tab.page.click("#json")
    assert download.value.suggested_filename == "report.json"
    tab.requests = [url for url in tab.requests if not url.startswith("data:")]  # which the link holds


def test_on_a_phone(browser, file, tmp_path):
    phone = {"width": 390, "height": 844}
    tab = Tab(browser, file, viewport=phone, device_scale_factor=2, has_touch=True).open()
    tab.page.screenshot(path=tmp_path / "phone.png")
    assert tab.page.evaluate("document.documentElement.scrollWidth") <= 390
    tops = [tab.page.locator(part).bounding_box()["y"] for part in ("#view", "#controls", "aside")]
    assert tops == sorted(tops)
    assert tab.shape().mean() > 0.1
    first = tab.pixels()
    tab.page.touchscreen.tap(195, 300)
    assert tab.page.locator("#tip").is_visible()
    tab.page.locator("#closer").tap()
    assert differing(first, tab.pixels()) > 0.02
    assert tab.complaints == []
    tab.context.close()


@pytest.mark.parametrize("width", [660, 820, 1000])
def test_in_the_cell_of_a_notebook(browser, tmp_path, width):
    """The report is beside the surface, and the page needs no scroll bars but that of the report."""
    solid = embed(PolyhedralMetric.from_mesh(*zoo.icosphere(2)))
    cell = tmp_path / "cell.html"
    cell.write_text(notebook_html(solid), encoding="utf-8")
    tab = Tab(browser, cell, viewport={"width": width + 16, "height": 600}).open()
    page = tab.page.frame_locator("iframe")
    aside = page.locator("aside")
    assert aside.bounding_box()["y"] == page.locator("#surface").bounding_box()["y"]
    assert page.locator("html").evaluate("html => html.scrollHeight - innerHeight") <= 0
    assert aside.evaluate("box => box.scrollWidth - box.clientWidth") <= 0
    assert page.locator("#view").bounding_box()["height"] >= 200
    tab.context.close()


def test_without_webgl(browser, file):
    tab = Tab(browser, file)
    tab.page.add_init_script("HTMLCanvasElement.prototype.getContext = () => null;")
    tab.open()
    assert "WebGL 2" in tab.text("#sorry")
    assert not tab.page.locator("#controls").is_visible()
    assert "area" in tab.text("aside")
    assert tab.complaints == []
    tab.context.close()


def test_without_javascript(browser, file):
    context = browser.new_context(java_script_enabled=False)
    page = context.new_page()
    page.goto(file.as_uri())
    assert "this browser runs none" in page.locator("#view").inner_text()
    assert "area" in page.locator("aside").inner_text()
    context.close()


def test_a_polyhedron_has_edges_seams_and_faces_of_one_color(browser, tmp_path):
    pairs = [(0, 3), (1, 2), (4, 7), (5, 6), (8, 9), (10, 13), (11, 12)]
    solid = embed(glue([LATIN_CROSS], [((0, i), (0, k)) for i, k in pairs]), method="alexandrov")
    write_page(tmp_path / "solid.html", solid)
    window = Tab(browser, tmp_path / "solid.html", viewport={"width": 900, "height": 720}).open()
    assert window.text("#kind") == "Edges" and window.page.locator("#paper").is_visible()
    whole = window.pixels()
    reddish = (whole[:, :, 0] > 0.6) & (whole[:, :, 0] > 1.5 * whole[:, :, 1])
    assert reddish.sum() > 100
    window.page.uncheck("#seams")
    window.page.uncheck("#mesh")
    plain = window.pixels()
    assert differing(whole, plain) > 0.001
    assert not ((plain[:, :, 0] > 0.6) & (plain[:, :, 0] > 1.5 * plain[:, :, 1])).any()
    window.page.check("#smooth")
    assert differing(plain, window.pixels()) > 0.02
    window.page.select_option("#color", "sides")
    box = window.page.locator("#canvas").bounding_box()
    window.page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    window.restore_delaunay()
    assert re.fullmatch(r"face \d\s+sides 3", window.text("#tip"))
    assert window.page.locator("#mark").is_hidden()
    assert window.complaints == []
    window.context.close()


def test_the_models_of_hyperbolic_space(browser, tmp_path):
    """Edges are bent but in Klein's ball; the sphere at infinity is a circle around both."""
    solid = regular_solid("cube", -1.0, 1.2)
    metric = PolyhedralMetric.from_mesh(solid.points, solid.faces, curvature=-1.0)
    cube = Polyhedron(metric, solid.points, method="exact", tolerance=1e-10)
    write_page(tmp_path / "cube.html", cube)
    window = Tab(browser, tmp_path / "cube.html", viewport={"width": 900, "height": 720}).open()
    names = window.page.locator("#model option").all_inner_texts()
    assert names == ["Poincaré ball", "Klein ball", "hyperboloid, x y z"]
    shapes = []
    for name in names:
        window.page.select_option("#model", name)
        shapes.append(window.shape())
        assert window.page.locator("#infinity").is_visible() == ("ball" in name)
    poincare, klein, _ = (shape.sum() for shape in shapes)
    assert klein > 1.5 * poincare
    size = window.page.locator("#canvas").bounding_box()
    window.page.select_option("#model", "Klein ball")
    window.restore_delaunay()
    around = window.page.locator("#infinity").bounding_box()
    assert around["width"] == pytest.approx(around["height"]) and around["width"] < min(
        size["width"], size["height"]
    )
    window.page.click("#closer")
    window.restore_delaunay()
    assert window.page.locator("#infinity").bounding_box()["width"] > 1.2 * around["width"]
    window.page.click("#reset")
    window.page.mouse.move(size["x"] + size["width"] / 2, size["y"] + size["height"] / 2)
    window.restore_delaunay()
    assert re.fullmatch(r"face [0-5]\s+sides 4", window.text("#tip"))
    assert "all are" in window.text("#span") and "hyperbolic" in window.text("aside")
    assert window.complaints == []
    window.context.close()


def test_models_are_those_of_curved_spaces(tab):
    assert tab.page.locator("#models").is_hidden() and tab.page.locator("#infinity").is_hidden()
