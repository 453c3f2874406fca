"""What a notebook shows of a surface."""

import sys
from html.parser import HTMLParser

import pytest

import isoembed
import zoo
from isoembed.plot import write_page

pytest.importorskip("matplotlib")


class Elements(HTMLParser):
    """The elements of a piece of HTML."""

    def __init__(self, text):
        super().__init__()
        self.found = []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.found.append((tag, dict(attributes)))


@pytest.fixture(scope="module")
def ball():
    return isoembed.embed(isoembed.PolyhedralMetric.from_mesh(*zoo.icosphere(1)))


@pytest.fixture
def large(ball, monkeypatch):
    """The ball in a notebook whose pages are of fewer vertices."""
    monkeypatch.setattr("isoembed.plot.notebook.PAGE_VERTICES", 41)
    return ball


def test_a_surface_is_a_page_in_a_frame(ball, tmp_path):
    ((tag, attributes),) = Elements(ball._repr_html_()).found
    assert tag == "iframe" and attributes["sandbox"].split() == ["allow-scripts", "allow-downloads"]
    assert attributes["title"] == repr(ball)
    write_page(tmp_path / "Surface.html", ball)
    assert attributes["srcdoc"] == (tmp_path / "Surface.html").read_text(encoding="utf-8")
    assert len(ball._repr_html_()) < 100_000


def test_a_large_surface_is_a_picture(large):
    ((tag, attributes),) = Elements(large._repr_html_()).found
    assert tag == "img" and attributes["src"].startswith("data:image/png;base64,iVBOR")
    assert attributes["alt"] == repr(large)


def test_a_large_surface_without_matplotlib_is_text(large, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    assert large._repr_html_() is None


def test_a_figure_shows_itself_without_pyplot(ball, tmp_path):
    drawn = ball.plot(color="residual", caption="a ball")
    assert drawn._repr_png_().startswith(b"\x89PNG")
    assert "a ball" in [text.get_text() for text in drawn.texts]
    assert drawn.axes[-1].get_ylabel().startswith("largest length error")
    with pytest.raises(isoembed.InvalidParameter, match="no quantity 'taste' to show"):
        ball.plot(color="taste")
    assert not sys.modules.get("matplotlib.pyplot") or not sys.modules["matplotlib.pyplot"].get_fignums()
