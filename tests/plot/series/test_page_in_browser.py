"""The page of a run in a real browser: what is drawn at which time.  Needs Playwright and a Chromium."""

import numpy as np
import pytest

pytest.importorskip("playwright.sync_api", reason="pages are tried out in a browser by playwright")
pytest.importorskip("matplotlib.image", reason="screenshots are read by matplotlib")

from browser_tab import CHROMIUM, Tab, chromium
from isoembed.plot.series.page import write_series_page
from series_results import embedded, missing

if CHROMIUM is None:
    pytest.skip("pages are tried out in Chromium, which is not installed", allow_module_level=True)


MOVE = (
    "(k) => { const f = document.getElementById('frame'); f.value = k; f.dispatchEvent(new Event('input')); }"
)


@pytest.fixture(scope="module")
def tab(tmp_path_factory):
    """Two horizons, then the one around them with them, then nothing, then it alone."""
    path = tmp_path_factory.mktemp("page") / "merger.html"
    pair = [
        embedded(name, k, k, center=(x, 0, 0), level=2 + k)
        for name, x in (("ah1", 1.5), ("ah2", -1.5))
        for k in (0, 1)
    ]
    common = [embedded("ah3", k, k, center=(0, 0, 0), half_axes=(5, 3, 3), level=3) for k in (1, 3)]
    write_series_page(path, [*pair, *common, missing("ah3", 2, 2, "not embedded", "K < 0")])
    with chromium() as browser:
        window = Tab(browser, path, viewport={"width": 900, "height": 720})
        yield window.open()
        assert window.requests == [path.as_uri()]
        assert window.complaints == []


def at(tab, frame):
    """Move the slider, and see where the horizons are."""
    tab.page.evaluate(MOVE, frame)
    return tab.shape()


def test_every_time_shows_its_own_horizons(tab):
    assert tab.text("#moment").startswith("t = 0.0 ")  # a run begins at its first time
    apart, together, none, alone = (at(tab, k) for k in range(4))
    middle = apart.shape[0] // 2, apart.shape[1] // 2
    assert apart.any()
    assert not apart[middle]  # between two horizons is nothing
    assert alone[middle]
    assert not none.any()
    assert alone.sum() > 1.5 * apart.sum()
    assert together.sum() > apart.sum()


def test_horizons_are_seen_through_the_one_around_them(tab):
    at(tab, 3)
    alone = tab.pixels()
    at(tab, 1)
    through = tab.pixels()
    apart = at(tab, 0)
    inside = np.zeros(through.shape[:2], dtype=bool)
    inside[:, 70:-70] = apart
    assert np.abs(alone - through)[inside].mean() > 0.05


def test_what_is_lost_is_told(tab):
    at(tab, 2)
    assert "ah3: not embedded" in tab.text("#moment")
    assert tab.page.locator("#folds").is_hidden()


def test_time_runs(tab):
    at(tab, 0)
    tab.page.locator("#play").click()
    tab.page.get_by_text("t = 3.0", exact=True).wait_for(timeout=20_000)
