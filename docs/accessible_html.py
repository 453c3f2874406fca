"""Sphinx extension: what the theme leaves out of the pages for keyboards and screen readers."""

import re
from pathlib import Path

from sphinx.application import Sphinx

MENDED = (
    (re.compile(r'<p class="caption" role="heading">'), '<p class="caption" role="heading" aria-level="2">'),
    (re.compile(r'<aside class="sidebar-drawer">'), '<aside class="sidebar-drawer" aria-label="All pages">'),
    (re.compile(r'<aside class="toc-drawer">'), '<aside class="toc-drawer" aria-label="On this page">'),
    (re.compile(r"<pre>"), '<pre tabindex="0">'),  # long lines are scrolled
    (re.compile(r'(<div class="(?:math|table)-wrapper[^>]*)>'), r'\1 tabindex="0">'),  # and tables, formulas
    (re.compile(r'(<div class="citation"[^>]*) role="doc-biblioentry">'), r"\1>"),  # it is in no list of such
    (re.compile(r'<div role="list" class="citation-list">'), '<div class="citation-list">'),  # of no items
    (re.compile(r'<div id="search-results"></div>'), '<h1>Search</h1>\n<div id="search-results"></div>'),
    (re.compile(r"<th[^>]*>(?:<p></p>)?</th>"), "<td></td>"),  # tables whose columns need no names
)
"""What stands in pages, and what is better."""


def mended(page: str) -> str:
    """The HTML of a page with what was left out."""
    for pattern, better in MENDED:
        page = pattern.sub(better, page)
    return page


def mend(app: Sphinx, exception: Exception | None) -> None:
    """Mend all pages once they are written."""
    if exception is None and app.builder.format == "html":
        for path in Path(app.outdir).glob("**/*.html"):
            path.write_text(mended(path.read_text(encoding="utf-8")), encoding="utf-8")


def setup(app: Sphinx) -> dict[str, bool]:
    """Called by Sphinx."""
    app.connect("build-finished", mend)
    return {"parallel_read_safe": True}
