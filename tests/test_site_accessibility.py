"""Accessibility of the documentation site, where it is built.  Needs Playwright, a Chromium and axe-core."""

import pytest

from places import ROOT

pytest.importorskip("playwright.sync_api", reason="pages are tried out in a browser by playwright")
pytest.importorskip("matplotlib.image", reason="screenshots are read by matplotlib")

from accessibility import AXE, violations
from browser_tab import CHROMIUM, Tab, chromium

SITE = ROOT / "site"

if CHROMIUM is None:
    pytest.skip("pages are tried out in Chromium, which is not installed", allow_module_level=True)
if not AXE.exists():
    pytest.skip("axe-core is not installed: npm install in page-lint", allow_module_level=True)
if not SITE.exists():
    pytest.skip("the site is not built: make docs", allow_module_level=True)

PAGES = sorted(page for page in SITE.glob("**/*.html") if "_static" not in page.parts)


@pytest.fixture(scope="module")
def browser():
    with chromium() as started:
        yield started


WIDTHS = {1280: 900, 390: 844}  # of a desktop and of a phone, with their heights


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(SITE)))
def test_nothing_on_the_site_breaks_a_rule(browser, page, width):
    tab = Tab(browser, page, viewport={"width": width, "height": WIDTHS[width]}).open()
    tab.page.evaluate("window.MathJax?.startup?.promise.then(() => null)")  # formulas as text, too
    for colors in ("light", "dark"):
        tab.page.emulate_media(color_scheme=colors)
        assert violations(tab.page) == []
    assert tab.page.evaluate("document.documentElement.scrollWidth") <= width  # wide tables and code scroll
    tab.context.close()
