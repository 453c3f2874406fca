"""The page: text, figures and its form."""

from html.parser import HTMLParser

from reproduction.report import HEAVY, Made, page, rendered, text
from sections import a_section, squares

VOID = {"meta", "img", "col", "br"}


class Page(HTMLParser):
    """Checks that tags nest, and collects what would be loaded and what is linked."""

    def __init__(self, html):
        super().__init__()
        self.open, self.loaded, self.links, self.ids, self.words = [], [], [], [], []
        self.feed(html)
        self.close()
        assert not self.open

    def handle_starttag(self, tag, attributes):
        given = dict(attributes)
        self.ids += [given["id"]] if "id" in given else []
        self.links += [given["href"]] if tag == "a" else []
        self.loaded += [given[key] for key in ("src", "href", "data") if key in given and tag != "a"]
        assert tag not in ("script", "link", "iframe", "object")
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.words.append(data)


def test_plain_text_becomes_html():
    assert text("a < b & c") == "a &lt; b &amp; c"
    assert text("(as N^-1.02)") == "(as N<sup>\N{MINUS SIGN}1.02</sup>)"
    assert text("0 <= K") == "0 \N{LESS-THAN OR EQUAL TO} K"
    assert text("2e-07, 1e-6, 0e+00, 6.7e-01, 4e+00").replace("\N{NO-BREAK SPACE}", " ") == (
        "2 \N{MULTIPLICATION SIGN} 10<sup>\N{MINUS SIGN}7</sup>, 10<sup>\N{MINUS SIGN}6</sup>, 0, 0.67, 4"
    )
    assert text("int H dA, -0.5, 3-4, v - 2 v_diff").replace("\N{NO-BREAK SPACE}", " ") == (
        "\N{INTEGRAL} H dA, \N{MINUS SIGN}0.5, 3-4, v - 2 v<sub>diff</sub>"
    )
    assert (
        text("K / kbar at rho_0, embedding_tree")
        == "K / k\N{COMBINING MACRON} at rho<sub>0</sub>, embedding_tree"
    )


def test_the_page_is_one_well_formed_file():
    section = a_section()
    images = {each.name: rendered(each.figure) for each in section.figures}
    html = page([Made("sizes", {}, section, images, 1.25)], "tiny")
    parsed = Page(html)
    assert parsed.loaded
    assert all(address.startswith("data:image/") for address in parsed.loaded)
    assert set(parsed.links) == {"#summary", "#sizes"}
    assert {"summary", "sizes"} <= set(parsed.ids)
    assert "<script" not in html
    assert "".join(parsed.words).count("<script>alert('&')") == 4
    assert html.count("<br>") == 1
    assert "http" not in html
    assert "url(" not in html
    assert "@import" not in html


def test_figures_are_drawn_the_same_twice():
    assert rendered(squares(3)) == rendered(squares(3))
    assert rendered(squares(3)).ending == ".svg"
    heavy = rendered(squares(HEAVY))
    assert heavy.ending == ".png"
    assert heavy.data.startswith(b"\x89PNG")


def test_several_figures_are_a_film_that_does_not_begin_by_itself():
    from io import BytesIO

    from PIL import Image

    film = rendered([squares(n) for n in (1, 2, 3)])
    assert film.ending == ".gif" and film == rendered([squares(n) for n in (1, 2, 3)])
    with Image.open(BytesIO(film.data)) as images:
        assert images.n_frames == 3
    section = a_section()
    html = page([Made("sizes", {}, section, {"squares": film}, 1.25)], "tiny")
    assert '<details><summary>Film</summary><img src="data:image/gif;base64,' in html
    assert Page(html).loaded
