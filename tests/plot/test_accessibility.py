"""Contrast, names and keyboard of a page in the browser.  Needs Playwright, a Chromium and axe-core."""

import re

import numpy as np
import pytest

import zoo

pytest.importorskip("playwright.sync_api", reason="pages are tried out in a browser by playwright")
pytest.importorskip("matplotlib.image", reason="screenshots are read by matplotlib")

from accessibility import AXE, violations
from browser_tab import CHROMIUM, Tab, chromium
from isoembed import Embedding, PolyhedralMetric, embed, glue
from isoembed.gluing.classics import LATIN_CROSS
from isoembed.plot import Frame
from isoembed.plot.notebook import notebook_html
from isoembed.plot.page import write_page

if CHROMIUM is None:
    pytest.skip("pages are tried out in Chromium, which is not installed", allow_module_level=True)
if not AXE.exists():
    pytest.skip("axe-core is not installed: npm install in page-lint", allow_module_level=True)

SIZES = {"desktop": {"width": 1280, "height": 800}, "phone": {"width": 390, "height": 844}}


@pytest.fixture(scope="module")
def browser():
    with chromium() as started:
        yield started


@pytest.fixture(scope="module")
def film(tmp_path_factory):
    """A sphere that becomes a dented ellipsoid."""
    path = tmp_path_factory.mktemp("page") / "dented.html"
    vertices, faces = zoo.icosphere(2)
    target = vertices * [2.0, 1.2, 0.8]
    target[::7] *= 0.8
    metric = PolyhedralMetric.from_mesh(target, faces)
    surface = Embedding(metric, target, method="exact", tolerance=1e-10)
    frames = [Frame("pull back", t, 1e-9, t * vertices + (1 - t) * target) for t in np.linspace(1.0, 0.0, 5)]
    write_page(path, surface, frames=frames, title="A dented ellipsoid")
    return path


@pytest.fixture(scope="module")
def solid(tmp_path_factory):
    """A polyhedron from paper, with seams."""
    path = tmp_path_factory.mktemp("page") / "solid.html"
    pairs = [(0, 3), (1, 2), (4, 7), (5, 6), (8, 9), (10, 13), (11, 12)]
    write_page(path, embed(glue([LATIN_CROSS], [((0, i), (0, k)) for i, k in pairs]), method="alexandrov"))
    return path


@pytest.mark.parametrize("colors", ["light", "dark"])
@pytest.mark.parametrize("size", SIZES)
def test_nothing_on_a_page_breaks_a_rule(browser, film, size, colors):
    tab = Tab(browser, film, viewport=SIZES[size], color_scheme=colors).open()
    tab.page.emulate_media(color_scheme=colors)
    assert violations(tab.page) == []
    tab.page.locator("#canvas").click(position={"x": SIZES[size]["width"] / 4, "y": 200})
    tab.page.select_option("#color", "residual")
    assert violations(tab.page) == []
    tab.context.close()


def test_nothing_breaks_a_rule_where_there_are_seams(browser, solid):
    tab = Tab(browser, solid, viewport=SIZES["desktop"]).open()
    assert violations(tab.page) == []
    tab.context.close()


def test_nothing_breaks_a_rule_without_webgl(browser, film):
    tab = Tab(browser, film, viewport=SIZES["desktop"])
    tab.page.add_init_script("HTMLCanvasElement.prototype.getContext = () => null;")
    tab.open()
    assert violations(tab.page) == []
    tab.context.close()


def test_a_frame_in_a_notebook_is_drawn_and_breaks_no_rule(browser, tmp_path):
    surface = embed(PolyhedralMetric.from_mesh(*zoo.icosphere(1)))
    cell = tmp_path / "cell.html"
    cell.write_text(
        '<!doctype html><html lang="en"><title>Notebook</title>'
        f"<main><h1>Notebook</h1>{notebook_html(surface)}</main></html>",
        encoding="utf-8",
    )
    tab = Tab(browser, cell, viewport=SIZES["desktop"]).open()
    frame = tab.page.frame_locator("iframe")
    frame.locator("#controls").wait_for()
    assert "42 vertices" in frame.locator("header").inner_text()
    assert violations(tab.page) == []
    assert [url for url in tab.requests if url.startswith("http")] == []
    assert tab.complaints == []
    tab.context.close()


def test_a_broken_rule_is_found(browser, film):
    tab = Tab(browser, film, viewport=SIZES["desktop"]).open()
    tab.page.evaluate("document.querySelector('#theme').removeAttribute('aria-label')")
    tab.page.evaluate("document.querySelector('#theme').removeAttribute('title')")
    tab.page.evaluate("document.querySelector('#theme').textContent = ''")
    assert any(line.startswith("button-name") for line in violations(tab.page))
    tab.context.close()


def test_everything_is_reached_with_the_keyboard_and_seen_to_be(browser, film):
    tab = Tab(browser, film, viewport=SIZES["desktop"]).open()
    page, reached = tab.page, []
    seen = """() => {
        const e = document.activeElement, s = getComputedStyle(e);
        const outlined = s.outlineStyle !== "none" && parseFloat(s.outlineWidth) > 0;
        return [e.id, outlined || s.boxShadow !== "none"];
    }"""
    for _ in range(30):
        page.keyboard.press("Tab")
        name, is_seen = page.evaluate(seen)
        if not name:
            break
        reached.append(name)
        assert is_seen, f"the focus on {name} is not seen"
    assert reached == [
        *("theme", "canvas", "closer", "farther", "reset", "color", "mesh", "creases", "smooth"),
        *("play", "frame", "report", "json"),
    ]


def test_the_surface_is_used_with_the_keyboard(browser, film):
    tab = Tab(browser, film, viewport=SIZES["desktop"]).open()
    page = tab.page
    page.locator("#canvas").focus()
    first = tab.pixels()
    page.keyboard.press("ArrowLeft")
    assert np.abs(tab.pixels() - first).max() > 0.1
    page.keyboard.press("0")
    page.keyboard.press("Enter")
    assert re.fullmatch(r"vertex \d+\s+mean curvature .*", tab.text("#tip"))
    page.locator("#frame").focus()
    page.keyboard.press("Home")
    assert page.locator("#frame").get_attribute("aria-valuetext").startswith("pull back, frame 1 of 5")
    page.locator("#mesh").focus()
    page.keyboard.press("Space")
    assert not page.locator("#mesh").is_checked()
    page.locator("#theme").focus()
    page.keyboard.press("Enter")
    assert re.fullmatch("light|dark", page.evaluate("document.documentElement.dataset.theme"))
    tab.context.close()
