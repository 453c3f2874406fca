"""The studies of figures 6, 7 and 9, and the report that all studies go into."""

import inspect
import json
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest

from isoembed.aim.paper import Paper
from isoembed.errors import NotEmbedded
from isoembed.gallery import Drum, Ellipsoid, Ergosphere, triangulate
from isoembed.io.files import FileError
from isoembed.metric.curvature import negative_deficits
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.studies import ergosphere, mean_curvature, plots, triptychs
from isoembed.studies.bodies import STUDY
from isoembed.studies.report import HEAVY, Made, page, rendered, text
from isoembed.studies.reproduce import STUDIES, Study, reproduce
from isoembed.studies.section import Comparison, Illustration, Section, Table
from isoembed.surface.embedding import Embedding
from zoo import icosphere

VOID = {"meta", "img", "col", "br"}
UNSAFE = "<script>alert('&')</script> \"quoted\""


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


def squares(n):
    from matplotlib.collections import PolyCollection

    figure = plots.blank(1.0)
    corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    figure.add_subplot().add_collection(PolyCollection([corners + k for k in range(n)]))
    return figure


def a_section(**changes):
    parts = {
        "title": "Sizes & shapes",
        "text": (UNSAFE, "of order N^-1.02, int H dA to 2e-07"),
        "figures": (Illustration("squares", UNSAFE, squares(3)),),
        "comparisons": (Comparison(UNSAFE, "0.62 %", "-0.04 % (here; there); N^2", ""),),
        "tables": (Table("a table", ("N", "error"), (("100", "1e-6"), ("200", UNSAFE))),),
        "numbers": {"n": np.int64(3), "list": np.array([1.0, np.nan]), "none": float("inf")},
    }
    return Section(**(parts | changes))


def studies(make=a_section, **sizes):
    return (Study("sizes", make, {}, sizes),)


@pytest.mark.parametrize(
    ("surface", "method"), [(Ellipsoid(), Paper()), (Drum(), "aim")], ids=("ellipsoid", "drum")
)
def test_a_triptych_is_smooth_in_the_middle_and_crumpled_on_the_right(surface, method):
    one = triptychs.triptych(surface, 300, method)
    exact, smooth, crumpled = one.panels.values()
    assert smooth.converged
    assert smooth.distance(exact) < 1e-4
    assert not smooth.rough_edges.any()
    metric, x = exact.metric, crumpled.vertices
    lengths = np.linalg.norm(x[metric.edges[:, 0]] - x[metric.edges[:, 1]], axis=1)
    assert np.abs(lengths - metric.lengths).max() < 1e-6 * metric.mean_length
    assert crumpled.rough_edges.mean() >= STUDY.crumpled
    assert (crumpled.inverted_vertices | crumpled.partially_inverted_vertices).any()
    assert crumpled.distance(exact) > 0.1
    assert one.attempts[-1].succeeded
    assert not any(attempt.succeeded for attempt in one.attempts[:-1])


def test_a_push_leaves_what_is_near_negative_curvature(monkeypatch):
    monkeypatch.setattr(triptychs, "STUDY", replace(STUDY, kick_iterations=0))  # do not anneal
    points, faces = triangulate(Ergosphere(), 400)
    metric = PolyhedralMetric.from_mesh(points, faces)
    smooth = Embedding(metric, points, method="exact", tolerance=1)
    pushed = np.linalg.norm(triptychs.kicked(smooth, 0.3).vertices - points, axis=1) / metric.mean_length
    held = negative_deficits(metric)
    near = held | (metric.triangulation.adjacency @ held > 0)  # sqrt(400) / 10 is 2 edges
    near = near | (metric.triangulation.adjacency @ near > 0)
    assert pushed[near].max() < 1e-12
    assert np.sqrt(np.mean(pushed[~near] ** 2)) == pytest.approx(0.3, rel=0.15)


def test_the_integral_of_h_converges_like_one_over_n():
    found = mean_curvature.convergence(Drum(), (150, 300, 600), Paper())
    assert found.order(found.embedded) == pytest.approx(-1, abs=0.1)
    assert np.allclose(found.embedded, found.exact, atol=1e-6)
    assert (np.abs(found.corrected) < 0.1 * np.abs(found.embedded)).all()
    assert np.all(found.embedded < 0)  # inscribed
    n = found.vertices_for(found.embedded, abs(found.embedded[1]))
    assert n == pytest.approx(300, rel=0.1)


def test_the_cotangent_integral_of_a_sphere():
    errors = []
    for level in (2, 3):
        vertices, faces = icosphere(level)
        found = mean_curvature.cotangent_integral(PolyhedralMetric.from_mesh(vertices, faces), vertices)
        errors.append(1 - found / (4 * np.pi))
    assert 0 < errors[1] < errors[0] < 0.03
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.05)


def test_from_which_epsilon_on_the_ergosphere_is_convex():
    epsilon, theta = ergosphere.convex_from()
    assert epsilon == pytest.approx(1.2977301304924984, abs=1e-8)  # a second computation, in long doubles
    u = [[np.sin(theta), 0, np.cos(theta)]]
    assert Ergosphere(epsilon=epsilon).gaussian_curvature(u)[0] == pytest.approx(0, abs=1e-9)
    assert Ergosphere(epsilon=epsilon - 0.01).gaussian_curvature(u)[0] < 0
    assert min(ergosphere.least_under_root()) > 3


def test_an_ergosphere_with_negative_curvature_embeds(monkeypatch):
    monkeypatch.setattr(ergosphere, "MORE", ())
    section = ergosphere.study(vertices=150, epsilons=(0.3, 1.5))
    first, last = section.numbers["cases"]
    assert first["K_least"] < 0 < last["K_least"]
    for case in (first, last):
        assert case["outcomes"]["default"]["residual"] < 1e-6
        assert abs(case["percent_error"]) < 3


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


def test_a_plan_leaves_a_report_figures_and_numbers(tmp_path):
    told = []
    folder = tmp_path / "a" / "b"
    (folder / "figures").mkdir(parents=True)
    (folder / "figures" / "squares.png").write_text("of an earlier run")
    outcome = reproduce(studies(title="sized"), folder, told.append, quick=True)
    assert outcome.report == folder / "report.html"
    assert outcome.failures == ()
    written = sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())
    assert written == ["figures/squares.svg", "numbers.json", "report.html"]
    numbers = json.loads((folder / "numbers.json").read_text())
    assert numbers["plan"] == "quick"
    found = numbers["sections"]["sizes"]
    assert found["numbers"] == {"n": 3, "list": [1.0, None], "none": None}
    assert found["comparisons"][0]["paper"] == "0.62 %"
    assert str(tmp_path) not in (folder / "report.html").read_text() + json.dumps(numbers)
    assert told[0] == "1/1 sizes ..."
    assert told[1].startswith("1/1 sizes: ")


def test_a_section_that_fails_is_replaced_by_the_reason(tmp_path):
    def fails():
        raise NotEmbedded("it did not embed", None)

    outcome = reproduce(studies(fails), tmp_path, lambda line: None)
    assert outcome.failures == ("sizes: it did not embed",)
    assert "could not be made: it did not embed" in outcome.report.read_text()


def test_a_folder_that_is_a_file_is_refused_before_anything_is_made(tmp_path):
    (tmp_path / "taken").write_text("")

    def never():
        raise AssertionError("made too early")

    for folder in (tmp_path / "taken", tmp_path / "taken" / "below"):
        with pytest.raises(FileError, match=r"^cannot (write|make the folder) .*taken"):
            reproduce(studies(never), folder, lambda line: None)


@pytest.mark.parametrize("name", ["report.html", "numbers.json"])
def test_a_folder_in_the_place_of_a_file_is_refused_before_anything_is_made(tmp_path, name):
    (tmp_path / name).mkdir()

    def never():
        raise AssertionError("made too early")

    with pytest.raises(FileError, match=rf"^cannot write .*{name}: it is a folder$"):
        reproduce(studies(never), tmp_path, lambda line: None)


def test_sizes_fit_their_studies():
    assert len({study.name for study in STUDIES}) == len(STUDIES) == 10
    for study in STUDIES:
        for sizes in (study.full, study.quick):
            inspect.signature(study.make).bind(**sizes)
