"""Nets on paper: what is cut, folded and glued is all there, and nothing overlaps."""

import dataclasses
import re
import xml.etree.ElementTree as ElementTree
from collections import Counter

import numpy as np
import pytest
from scipy.spatial import ConvexHull

import isoembed
import solids
import zoo
from drawings import lines_of
from exact import is_simple
from gluing_polygons import shoelace
from isoembed import Embedding, InvalidParameter, PolyhedralMetric
from isoembed.gallery import Ergosphere, triangulate
from isoembed.gluing import unfold
from isoembed.gluing.unfolding import Unfolding
from isoembed.io import FileError
from isoembed.papercraft import write_sheets
from isoembed.papercraft.convex import overlaps
from isoembed.papercraft.drawing import drawn
from isoembed.papercraft.labels import Label
from isoembed.papercraft.paper import FOOT, FORMATS, MARGIN, Paper
from isoembed.papercraft.placing import GAP, laid_out
from isoembed.papercraft.tabs import tabs


def net_of(vertices, faces):
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    return unfold(Embedding(metric, vertices, method="given", tolerance=1e-10))


def squares():
    """Six sheets of different sizes, which need several pages."""
    sheets = [np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]]) * size for size in (1.0, 0.9, 0.8, 0.8, 0.5, 0.5)]
    nothing = [np.empty((0, 2, 2))] * 6
    sides = tuple(((p, k), (p + 1, k)) for p in (0, 2, 4) for k in range(4))
    return Unfolding(tuple(sheets), (np.arange(4),) * 6, sides, tuple(nothing), (np.empty(0),) * 6)


def test_a_cube_on_a4():
    drawing = drawn(net_of(*zoo.cube()))
    assert (drawing.width, drawing.height, drawing.pages) == (210, 297, 1)
    assert Counter(one.text for one in drawing.labels) == Counter({str(k): 2 for k in range(1, 8)})
    assert {one.size for one in drawing.labels} == {4.2}
    assert len(lines_of(drawing, "mountain")) == 5 + 7  # of the solid, and one for each tab
    assert not lines_of(drawing, "valley")
    (cut,) = drawing.cuts
    assert len(cut) == 14 + 2 * 7
    assert is_simple(cut) and cut[:, 0].min() > 0 and cut[:, 0].max() < 210
    side = float(drawing.notes[0].text.split("; ")[1].split()[0])
    assert np.hypot(*np.diff(lines_of(drawing, "mountain")[0], axis=0)[0]) == pytest.approx(side, rel=1e-3)


@pytest.mark.parametrize("seed", range(3))
def test_tabs_and_labels_overlap_nothing(seed):
    net = net_of(*zoo.random_hull(20 + 10 * seed, seed))
    drawing = drawn(net)
    (cut,) = drawing.cuts
    assert is_simple(cut)  # with the tabs
    assert shoelace(cut) > 1.02 * shoelace(net.sheets[0]) * drawing_scale(drawing) ** 2
    outline = np.stack([cut, np.roll(cut, -1, axis=0)], axis=1)
    boxes = np.array([one.box for one in drawing.labels if one.size > 0.5])
    assert len(boxes) == len(drawing.labels)
    for k, box in enumerate(boxes):
        assert not overlaps(box, outline)
        assert not overlaps(box, np.delete(boxes, k, axis=0))
    assert Counter(Counter(one.text for one in drawing.labels).values()) == {2: len(net.sides)}
    assert all(-90 <= one.angle < 90 for one in drawing.labels)


def drawing_scale(drawing):
    return float(re.search(r"([\d.e+-]+) mm a unit", drawing.notes[0].text)[1])


def test_labels_stand_at_their_sides():
    net = net_of(*zoo.icosahedron())
    outline = laid_out(net).places[0].put(net.sheets[0])
    by_text = {}
    for one in drawn(net).labels:
        by_text.setdefault(one.text, []).append((one.x, one.y))
    for number, pair in enumerate(net.sides, 1):
        middles = np.array([(outline[k] + outline[(k + 1) % len(outline)]) / 2 for _, k in pair])
        found = np.array(by_text[str(number)])
        apart = np.linalg.norm(middles[:, None] - found, axis=2)
        assert apart.min(axis=0).max() < 4 and apart.min(axis=1).max() < 4


def test_valleys_of_a_surface_that_is_not_convex():
    net = net_of(*triangulate(Ergosphere(), 80))
    drawing = drawn(net)
    assert len(lines_of(drawing, "valley")) == sum(int((angles < 0).sum()) for angles in net.angles) > 0
    assert [kind for kind, _ in drawing.legend] == ["cut", "mountain", "valley"]
    assert "fold toward you" in [one.text for one in drawing.notes]


def test_faces_that_rounding_bent_are_not_folded():
    vertices = solids.uniform("dodecahedron")
    net = net_of(vertices.round(5), solids.triangles(solids.polygons(vertices)))
    assert sum(map(len, net.folds)) == 11  # rounding explains the bends of diagonals
    drawing = drawn(net)
    assert len(lines_of(drawing, "mountain")) == 11 + len(net.sides) == 11 + 19
    assert not lines_of(drawing, "valley")
    long = (1 + 5**0.5) / 2 * drawing_scale(drawing)
    assert max(np.hypot(*(b - a)) for a, b in lines_of(drawing, "mountain")) < 0.9 * long


def test_numbers_that_are_others_upside_down_are_underlined():
    underlined = [n for n in range(1, 120) if Label(str(n), 0, 0, 0, 1).underline is not None]
    assert underlined == [6, 9, 60, 66, 68, 69, 86, 89, 90, 96, 98, 99]


# Pages


def is_mark(lengths):
    return np.abs(lengths - 6) < 1e-9


@pytest.mark.parametrize("paper", ["A5", "A4", "tabloid", "100x120", "roll:90"])
def test_marks_in_the_corners_of_each_page_meet_nothing(paper):
    drawing = drawn(net_of(*zoo.icosahedron()), paper=paper)
    lines = np.array(drawing.ruler)
    marks = lines[is_mark(np.hypot(*np.moveaxis(np.diff(lines, axis=1), 2, 0)).ravel())]
    assert len(marks) == 8 * drawing.pages
    corners = {
        (x, y - k * drawing.height)
        for k in range(drawing.pages)
        for x in (5.0, drawing.width - 5)
        for y in (-5.0, 5 - drawing.height)
    }
    assert {tuple(start) for start, _ in marks.tolist()} == corners
    boxes = [one.box for one in (*drawing.labels, *drawing.notes)]
    others = [np.stack([cut, np.roll(cut, -1, axis=0)], axis=1) for cut in drawing.cuts]
    for mark in marks:
        assert not overlaps(mark, np.array(boxes)) and not any(overlaps(mark, some) for some in others)
    written = np.concatenate([one.box for one in drawing.notes])
    assert written[:, 0].min() > 0 and written[:, 0].max() < drawing.width


@pytest.mark.parametrize("paper", ["A4", "A3", "letter"])
def test_each_page_has_a_ruler_and_a_legend_apart_from_the_sheets(paper):
    drawing = drawn(squares(), paper=paper)
    lines = np.array(drawing.ruler)
    lengths = np.hypot(*np.moveaxis(np.diff(lines, axis=1), 2, 0)).ravel()
    assert (lengths == 50).sum() == drawing.pages > 1
    lines = lines[~is_mark(lengths)]
    assert [kind for kind, _ in drawing.legend] == ["cut", "mountain"] * drawing.pages
    samples = np.concatenate([lines, [line for _, line in drawing.legend]])
    corners = np.concatenate([*drawing.cuts, *(one.box for one in drawing.labels)])
    written = np.concatenate([one.box for one in drawing.notes])
    assert written[:, 0].min() > 0 and written[:, 0].max() < drawing.width
    for page in range(drawing.pages):
        bottom = -(page + 1) * drawing.height
        on_page = [
            points[(points[:, 1] > bottom) & (points[:, 1] < bottom + drawing.height)]
            for points in (np.concatenate([samples.reshape(-1, 2), written]), corners)
        ]
        foot, sheets = (points[:, 1] - bottom for points in on_page)
        assert foot.min() > 0 and foot.max() < sheets.min()


@pytest.mark.parametrize("paper", ["A4", "A3", "letter"])
def test_sheets_are_on_pages_and_apart(paper):
    net = squares()
    layout = laid_out(net, paper)
    pages = layout.pages
    width, height = FORMATS[paper]
    assert layout.scale == pytest.approx(min(width, height) - 2 * MARGIN)
    boxes = []
    for place, sheet in zip(layout.places, net.sheets, strict=True):
        there = place.put(sheet)
        low, high = there.min(axis=0), there.max(axis=0)
        page = int(-high[1] // height)
        assert page < pages and -low[1] <= (page + 1) * height - MARGIN + 1e-9
        assert -high[1] >= page * height + MARGIN - 1e-9
        assert low[0] >= MARGIN - 1e-9 and high[0] <= width - MARGIN + 1e-9
        boxes.append((low, high))
    for k, (low, high) in enumerate(boxes):
        for other_low, other_high in boxes[:k]:
            assert (np.maximum(low, other_low) - np.minimum(high, other_high)).max() >= GAP - 1e-9
    assert pages == drawn(net, paper=paper).pages > 1


def test_a_sheet_is_turned_to_fit():
    angle = 0.3
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    sheet = np.array([[0.0, 0], [1, 0], [1, 1.5], [0, 1.5]]) @ turn
    scale = laid_out(Unfolding((sheet,), (np.arange(4),), (), (), ())).scale
    assert scale == pytest.approx((297 - FOOT - 2 * MARGIN) / 1.5)


@pytest.mark.parametrize("unit", [1e-300, 1e300])
def test_any_unit_fits_as_well(unit):
    points, faces = zoo.cube()
    usual, other = drawn(net_of(points, faces)), drawn(net_of(points * unit, faces))
    for cut, again in zip(usual.cuts, other.cuts, strict=True):
        assert again == pytest.approx(cut, abs=1e-9)


def test_a_scale_is_kept():
    net = net_of(*zoo.cube())
    drawing = drawn(net, scale=30.0)
    assert drawing_scale(drawing) == 30
    lengths = [float(np.hypot(*(b - a))) for a, b in lines_of(drawing, "mountain")]
    assert lengths == pytest.approx([30.0] * len(lengths))


@pytest.mark.parametrize(("typed", "name"), [("a4", "A4"), ("Letter", "letter"), ("210X297", "210x297")])
def test_names_of_papers_in_any_case(typed, name):
    assert dataclasses.replace(Paper.of(typed), name="") == dataclasses.replace(Paper.of(name), name="")


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (
            {"paper": "A9"},
            "paper is 'A9', not one of A0, A1, .*, tabloid, nor WIDTHxHEIGHT or roll:WIDTH in mm",
        ),
        ({"paper": "roll:70"}, "paper is 'roll:70': less than 80 mm has no room for margins and ruler"),
        ({"size": 0.0}, "size is 0, not a positive finite number of mm"),
        ({"size": ("z", -3.0)}, "size in z is -3, not a positive finite number of mm"),
        ({"size": ("z", None)}, r"size is \('z', None\), not a number or such as \('z', 200\)"),
        ({"size": ("w", 3.0)}, r"size is \('w', 3.0\), not a number or such as \('z', 200\)"),
        ({"size": 10.0, "scale": 2.0}, "give either a scale, here 2 mm, or a size, here 10 mm, not both"),
        ({"scale": "big"}, "scale is 'big', not a positive finite number of mm"),
        ({"material": "leather"}, "material is 'leather', not an isoembed.papercraft.Material"),
        ({"scale": -1.0}, "scale is -1, not a positive finite number of mm"),
        ({"scale": float("nan")}, "scale is nan, not a positive finite number of mm"),
        (
            {"scale": 400.0},
            "scale is 400 mm, but face 0 fits on A4 up to scale=182; paper='A1' is large enough",
        ),
        (
            {"size": 400.0, "paper": "A3"},
            "size is 400 mm, but face 0 fits on A3 up to size=269; paper='A1' is large enough",
        ),
    ],
)
def test_refusals(options, sentence):
    with pytest.raises(InvalidParameter, match=sentence):
        drawn(net_of(*zoo.cube()), **options)


# Files


def test_svg_holds_every_line(tmp_path):
    net = net_of(*zoo.random_hull(12, 3))
    write_sheets(tmp_path / "net.svg", net)
    drawing = drawn(net)
    root = ElementTree.parse(tmp_path / "net.svg").getroot()
    name = "{http://www.w3.org/2000/svg}"
    assert (root.get("width"), root.get("height"), root.get("viewBox")) == ("210mm", "297mm", "0 0 210 297")
    groups = {group.get("id"): group for group in root.findall(f"{name}g")}
    numbers = [float(x) for x in re.findall(r"-?\d+\.\d+", groups["cut"][0].get("d"))]
    assert np.reshape(numbers, (-1, 2)) * [1, -1] == pytest.approx(drawing.cuts[0], abs=1e-4)
    assert len(groups["mountain"]) == len(lines_of(drawing, "mountain"))
    layers = ["glue", "engrave", "valley", "mountain", "cut"]
    assert [*groups] == layers
    inkscape = "{http://www.inkscape.org/namespaces/inkscape}"
    assert [group.get(f"{inkscape}label") for group in groups.values()] == layers
    assert {group.get(f"{inkscape}groupmode") for group in groups.values()} == {"layer"}
    texts = [text.text for text in groups["engrave"].iter(f"{name}text")]
    assert texts == [one.text for one in (*drawing.labels, *drawing.notes)]


def test_pdf_has_a_page_each(tmp_path):
    net = squares()
    write_sheets(tmp_path / "net.pdf", net)
    data = (tmp_path / "net.pdf").read_bytes()
    assert data.startswith(b"%PDF")
    assert len(re.findall(rb"/Type /Page\b", data)) == drawn(net).pages
    assert b"/MediaBox [ 0 0 595.27" in data
    again = tmp_path / "again.pdf"
    write_sheets(again, net)
    assert again.read_bytes() == data


def test_other_endings_are_refused(tmp_path):
    with pytest.raises(FileError, match=r"not one of \.svg \.pdf \.dxf"):
        write_sheets(tmp_path / "net.png", net_of(*zoo.cube()))


@pytest.mark.parametrize("name", ["SHEET_ENDINGS", "sheets_writer", "write_sheets"])
def test_old_names_say_where_they_went(name):
    with pytest.warns(DeprecationWarning, match=rf"papercraft\.{name} now; .* version 0\.5") as caught:
        assert getattr(isoembed.plot, name) is getattr(isoembed.papercraft, name)
    assert caught[0].filename == __file__


# Pieces


@pytest.mark.parametrize("seed", range(50))
def test_overlaps_against_hulls(seed):
    """Two convex polygons are apart if a line separates all of their corners: by linear programming."""
    from scipy.optimize import linprog

    rng = np.random.default_rng(seed)
    pieces = []
    for n in (4, int(rng.choice([2, 4]))):
        points = rng.normal(size=(n, 2)) + rng.uniform(-2, 2, 2)
        pieces.append(points if n == 2 else points[ConvexHull(points).vertices])
    one, other = pieces
    rows = np.vstack(
        [np.column_stack([one, np.ones(len(one))]), -np.column_stack([other, np.ones(len(other))])]
    )
    separated = linprog(np.zeros(3), A_ub=rows, b_ub=-np.ones(len(rows)), bounds=[(None, None)] * 3).success
    assert overlaps(one, other[None]) == (not separated)


def test_a_tab_does_not_reach_across_a_slit_into_the_sheet():
    slit = [[50.01, 60], [50.01, 20], [50, 19], [49.99, 20], [49.99, 60]]
    outline = np.array([[0, 0], [100, 0], [100, 60], *slit, [0, 60]], dtype=float)
    assert list(tabs([outline], [((0, 3), (0, 8))])) == [(0, 8)]
    assert not tabs([outline], [((0, 3), (0, 6))])


def test_a_tab_does_not_meet_a_corner_that_is_near_its_own():
    """A slit ends a fifth of a millimeter beside the corner at which the tab begins."""
    outline = np.array(
        [
            [56.47, 9.06],
            [47.306, 46.528],
            [54.953, 53.718],
            [47.424, 46.405],
            [58.104, 53.124],
            [65, 60],
            [0, 60],
            [0, 0],
        ]
    )
    (((_, k), top),) = tabs([outline], [((0, 0), (0, 6))]).items()
    assert is_simple(np.insert(outline, k + 1, top, axis=0))
