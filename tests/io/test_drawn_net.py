"""Nets from drawings: the solid comes back from the lines of the file, ours or anybody's."""

import math
import re
import time
from contextlib import nullcontext
from itertools import combinations

import numpy as np
import pytest
from scipy.spatial.distance import pdist

import isoembed
import solids
import zoo
from isoembed import Embedding, InvalidMetric, InvalidParameter, MeshNote, PolyhedralMetric
from isoembed.gallery import Ergosphere, triangulate
from isoembed.gluing import unfold
from isoembed.gluing.drawn_lines import Line
from isoembed.gluing.line_graph import LineGraph
from isoembed.io import FileError, dxf_lines, svg_lines
from isoembed.io.input_file import InputFile
from isoembed.io.net import read_net
from isoembed.io.svg_lines import read_svg_lines
from isoembed.io.svg_path import path_points

DIGIT = 1e-4  # mm, in files


def net_of(vertices, faces):
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    return unfold(Embedding(metric, vertices, method="given", tolerance=1e-10))


def uniform(name):
    vertices = solids.uniform(name)
    return vertices, solids.triangles(solids.polygons(vertices))


SOLIDS = {
    "cube": zoo.cube(),
    "icosahedron": zoo.icosahedron(),
    "truncated cube": uniform("truncated cube"),
    "snub cube": uniform("snub cube"),
    "hull": zoo.random_hull(25, 4),
    "with dents": triangulate(Ergosphere(), 40),
}


@pytest.mark.parametrize("ending", [".svg", ".dxf"])
@pytest.mark.parametrize("name", SOLIDS)
def test_the_solid_comes_back_from_the_file(tmp_path, name, ending):
    if ending == ".dxf":
        pytest.importorskip("ezdxf")
    vertices, faces = SOLIDS[name]
    path = tmp_path / f"net{ending}"
    scale = 40.0 / np.ptp(vertices)
    net_of(vertices, faces).save(path, scale=scale)
    solid = isoembed.embed(isoembed.glue(path))
    found, right = np.sort(pdist(solid.vertices)), np.sort(pdist(vertices * scale))
    assert len(found) == len(right)
    assert np.abs(found - right).max() < 10 * DIGIT  # errors of the digits of several faces in a row
    assert solid.volume > 0


@pytest.mark.parametrize("decimals", [3, 5])
def test_solids_with_rounded_coordinates_come_back_with_their_faces(tmp_path, decimals):
    vertices, faces = uniform("dodecahedron")
    net_of(vertices.round(decimals), faces).save(tmp_path / "net.svg", scale=20)
    solid = isoembed.embed(isoembed.glue(tmp_path / "net.svg"))
    assert solid.triangulation.n_vertices == 20
    apart = np.sort(pdist(solid.vertices)) - np.sort(pdist(vertices * 20))
    assert np.abs(apart).max() < 20 * 10.0**-decimals * 3


def square(x, y, size=10.0):
    return f'<rect x="{x}" y="{y}" width="{size}" height="{size}"/>'


def svg(body, head='width="200mm" height="100mm" viewBox="0 0 200 100"'):
    return f'<svg xmlns="http://www.w3.org/2000/svg" {head}>{body}</svg>'


def read(tmp_path, text, **how):
    (tmp_path / "net.svg").write_text(text)
    return read_net(tmp_path / "net.svg", **how)


CROSS = "".join(square(x, y) for x, y in ((0, 10), (10, 10), (20, 10), (30, 10), (10, 0), (10, 20)))
"""The squares of a cube, side by side, every line between them twice."""


def volume(net):
    return isoembed.embed(net).volume


NUMBERED = CROSS + "".join(
    f'<text x="{x}" y="{y}" font-size="2" text-anchor="middle">{text}</text>'
    for text, *places in (
        ("a", (9, 5.5), (5, 12.5)), ("b", (15, 2), (35, 12.5)), ("c", (21, 5.5), (25, 12.5)),
        ("d", (9, 25.5), (5, 19.5)), ("e", (15, 29.5), (35, 19.5)), ("f", (21, 25.5), (25, 19.5)),
        ("g", (1.5, 15.5), (38.5, 15.5)),
    )
    for x, y in places
)  # fmt: skip


def test_a_drawing_with_numbers(tmp_path):
    net = read(tmp_path, svg(NUMBERED))
    assert (net.n_vertices, volume(net)) == (8, pytest.approx(1000))


@pytest.mark.parametrize(
    ("head", "transform", "size"),
    [
        ('width="400mm" height="200mm" viewBox="0 0 200 100"', "", 20.0),
        ('width="20cm" height="10cm" viewBox="0 0 200 100"', 'transform="rotate(30) translate(3,4)"', 10.0),
        ("", "", 10 * 25.4 / 96),
        ('width="2in" viewBox="0 0 96 96"', 'transform="matrix(2 0 0 2 5 5)"', 2 * 10 * 25.4 / 48),
        ('width="96" height="96" viewBox="0 0 96 96"', 'transform="scale(-1, 1)"', 10 * 25.4 / 96),
    ],
)
def test_units_and_transformations(tmp_path, head, transform, size):
    # Turned and turned over the net of a cube is one as well.
    says = any(unit in head for unit in ("mm", "cm", "in"))
    said = nullcontext() if says else pytest.warns(MeshNote, match="has no unit: a pixel is taken as 1/96 in")
    with said:
        net = read(tmp_path, svg(f"<g {transform}>{NUMBERED}</g>", head))
    assert volume(net) == pytest.approx(size**3, rel=1e-6)


def test_a_cross_without_numbers_folds_to_several_solids(tmp_path):
    with pytest.raises(
        InvalidParameter, match=r"has no mate that is certain: \d+ ways to glue it make a conv"
    ):
        read(tmp_path, svg(CROSS))


def test_numbers_that_are_not_at_two_sides(tmp_path):
    """One is mistyped: its sides are left to lengths and the search, which is said."""
    mistyped = NUMBERED.replace(">a<", ">b<", 1)
    with pytest.warns(MeshNote, match="not at two sides glue none: b at 3 sides, a at 1 side"):
        net = read(tmp_path, svg(mistyped))
    assert volume(net) == pytest.approx(1000)


PRISM = [
    [0, 0],
    [40, 0],
    [45, -39.686270],
    [90, 0],
    [150, 0],
    [150, 70],
    [90, 70],
    [45, 109.686270],
    [40, 70],
    [0, 70],
]
"""The net of a prism over a triangle with the sides 40, 50 and 60; its folds are between these corners."""
FOLDS = [[1, 8], [3, 6], [1, 3], [8, 6]]


def prism(digits):
    points = [[f"{20 + x:.{digits}f}", f"{50 + y:.{digits}f}"] for x, y in PRISM]
    lines = "".join('<path d="M{} {}L{} {}"/>'.format(*points[a], *points[b]) for a, b in FOLDS)
    return svg(f'<polygon points="{" ".join(map(",".join, points))}"/>{lines}')


@pytest.mark.parametrize(("digits", "how"), [(6, {}), (2, {}), (1, {}), (0, {"tolerance": 1.0})])
def test_sides_of_a_coarse_drawing_are_told_apart_by_the_search(tmp_path, digits, how):
    """Four sides of 40 differ by no more than the digits; only one of the ways to glue them is convex."""
    said = "as given" if how else "by the digits of the drawing"
    noted = pytest.warns(MeshNote, match=rf"{said}\): the sheets are corrected, corner \d of polygon \d most")
    with nullcontext() if digits == 6 else noted:
        net = read(tmp_path, prism(digits), **how)
    area = 0.25 * math.sqrt(150 * 70 * 50 * 30)  # Heron's formula
    exact = 70 * area
    assert net.n_vertices == 6
    assert volume(net) == pytest.approx(exact, rel=2 * 10.0**-digits / 40)


def test_lengths_that_are_too_coarse(tmp_path):
    """In whole millimeters two of four equal sides seem to be the only ones of their length."""
    with pytest.raises(InvalidMetric, match="not a sphere; sides without a number were glued by their leng"):
        read(tmp_path, prism(0))
    with pytest.raises(InvalidParameter, match=r"more digits: lengths that differ by less than 0\.4 mm"):
        read(tmp_path, svg("".join(square(x, 0) for x in range(0, 80, 20))), tolerance=0.4)


def test_a_cross_with_the_angles_of_its_folds(tmp_path):
    ends = (10, 10, 10, 20), (20, 10, 20, 20), (30, 10, 30, 20), (10, 10, 20, 10), (10, 20, 20, 20)
    folds = "".join(f'<line x1="{a}" y1="{b}" x2="{c}" y2="{d}" data-angle="90"/>' for a, b, c, d in ends)
    outline = "M10 0h10v10h20v10h-20v10h-10v-10h-10v-10h10z"
    net = read(tmp_path, svg(f'<g id="fold">{folds}</g><g id="cut"><path d="{outline}"/></g>'))
    assert volume(net) == pytest.approx(1000)


def test_lengths_that_two_sides_have(tmp_path):
    # A tetrahedron with three pairs of sides of different lengths, in one triangle.
    corners = np.array([[0, 0], [80, 0], [30.0, 70]])
    middles = (corners + np.roll(corners, -1, axis=0)) / 2
    (a, b, c), (d, e, f) = corners.tolist(), middles.tolist()
    lines = "".join(
        f'<polygon points="{" ".join(f"{x},{y}" for x, y in some)}"/>'
        for some in ((a, d, f), (d, b, e), (f, e, c), (d, e, f))
    )
    net = read(tmp_path, svg(lines))
    assert net.n_vertices == 4
    assert isoembed.embed(net).area == pytest.approx(80 * 70 / 2)


def test_colors_that_two_sides_have(tmp_path):
    lines = '<polygon points="0,0 20,0 20,20" stroke="none"/>'  # hidden below the colors
    sides = [(0, 0, 10, 0), (10, 0, 20, 0), (20, 0, 15, 8.660254), (15, 8.660254, 10, 17.320508),
             (10, 17.320508, 5, 8.660254), (5, 8.660254, 0, 0)]  # fmt: skip
    lines = "".join(
        f'<line x1="{a}" y1="{b}" x2="{c}" y2="{d}" style="stroke:{color}"/>'
        for (a, b, c, d), color in zip(sides, ("red", "red", "blue", "blue", "green", "green"), strict=True)
    )
    net = read(tmp_path, svg(lines))
    assert volume(net) == pytest.approx(10**3 * math.sqrt(2) / 12, rel=1e-5)


@pytest.mark.parametrize(
    ("body", "sentence"),
    [
        ("", "has no lines"),
        ('<path d="M0 0L10 0"/>', "has no closed outlines"),
        ('<path d="M0 0L10 10L10 0L0 10z"/>', r"lines from \[.*\] to \[.*\] and from \[.*\] to \[.*\] cross"),
        (square(0, 0, 50) + square(10, 10), "an outline lies inside another"),
        ('<path d="M0 0L10"/>', "the command L of a path lacks numbers"),
        ('<path d="0 0"/>', "does not begin with M"),
        ('<path d="M0 0 # 1"/>', "a path has '# 1'"),
        ('<g transform="turn(3)"/>', r"has the invalid transformation 'turn\(3\)'"),
        ('<rect width="5 apples"/>', "width of rect is '5 apples', not a length"),
        ('<path d="M0 0L1 1" data-angle="right"/>', "data-angle is 'right', not a number"),
        ('<circle r="5"/><g id="fold"><line x1="0" y1="5" x2="0" y2="0"/></g>', "ends inside a sheet"),
    ],
)
def test_refusals(tmp_path, body, sentence):
    with pytest.raises((FileError, InvalidMetric), match=sentence):
        read(tmp_path, svg(body))


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("<svg", "is not a readable SVG file"),
        ("<html/>", "is not an SVG file: it holds 'html'"),
        ('<!DOCTYPE s [<!ENTITY a "b">]><svg/>', "defines entities"),
        ("<svg>" + "<g>" * 60 + "</g>" * 60 + "</svg>", "nested more than 50 deep"),
        ('<svg><g id="a"><use href="#a"/></g></svg>', "nested more than 50 deep"),
    ],
)
def test_files_that_are_refused(tmp_path, text, sentence):
    with pytest.raises(FileError, match=sentence):
        read(tmp_path, text)


LONG = 200_000


@pytest.mark.parametrize(
    "said",
    [
        f'style="{"a" * LONG}"',
        f'data-angle="{"1" * LONG}x"',
        f'transform="{"a" * LONG}"',
        f'transform="{"a(" * LONG}"',
    ],
)
def test_long_attributes_take_no_longer_for_each_letter(tmp_path, said):
    begin = time.process_time()
    with pytest.raises((FileError, InvalidParameter)):
        read(tmp_path, svg(f'<path d="M0 0L1 0L1 1z" {said}/>'))
    assert time.process_time() - begin < 5  # a minute and more where it is the square


def test_slanted_lines_between_whole_numbers(tmp_path):
    # (10, 10) . (10, 10) over the square of the rounded length is less than 1.
    marks = {"a": ((5, 2), (2, 5)), "b": ((8, 5), (5, 9))}
    numbers = "".join(
        f'<text x="{x}" y="{y}" font-size="1" text-anchor="middle">{text}</text>'
        for text, places in marks.items()
        for x, y in places
    )
    net = read(tmp_path, svg(square(0, 0) + '<path id="fold" d="M0 0L10 10"/>' + numbers))
    solid = isoembed.embed(net)
    assert (solid.triangulation.n_vertices, solid.area) == (3, pytest.approx(100))


def test_a_few_lines_that_are_used_many_times(tmp_path, monkeypatch):
    groups = "".join(f'<g id="a{k}">' + f'<use href="#a{k + 1}"/>' * 10 + "</g>" for k in range(20))
    monkeypatch.setattr(svg_lines, "MOST_READ", 1000)
    with pytest.raises(FileError, match="draws more than 1000 elements: no net needs as many"):
        read(tmp_path, svg(f'<defs>{groups}</defs><use href="#a0"/>'))


def test_crossings_are_those_of_all_pairs():
    rng = np.random.default_rng(0)
    found = 0
    for _ in range(200):
        ends = rng.integers(0, 8, (4, 2, 2)).astype(float)
        pieces = [Line(some, "cut") for some in ends if (some[0] != some[1]).any()]
        crosses = any(
            np.prod([np.linalg.det([b - a, p - a]) for p in other]) < -1e-9
            and np.prod([np.linalg.det([other[1] - other[0], p - other[0]]) for p in (a, b)]) < -1e-9
            for (a, b), other in combinations([one.points for one in pieces], 2)
        )
        # Where three lines meet in a corner of one, they are cut there first.
        try:
            LineGraph.of(pieces, 0.0)
        except InvalidMetric as error:
            assert crosses == ("cross" in str(error))
            found += 1
        else:
            assert not crosses
    assert 20 < found < 180


def test_sides_of_different_lengths_with_one_number_are_named(tmp_path):
    longer = NUMBERED.replace(square(30, 10), '<path d="M30 10h10.5v10h-10.5z"/>')
    with pytest.raises(InvalidMetric, match=r"number [be] are 1\d(\.5)? and 1\d(\.5)? mm long, from"):
        read(tmp_path, svg(longer))


def test_the_tolerance_that_is_advised_is_that_of_all_numbers(tmp_path):
    longer = NUMBERED.replace(square(30, 10), '<path d="M30 10h10.5v10h-10.5z"/>')
    drawing = svg(longer.replace(square(10, 20), '<path d="M10 20h10v9.3h-10z"/>'))
    with pytest.raises(InvalidMetric, match=r"give a tolerance of [.\d]+, or correct them") as refusal:
        read(tmp_path, drawing)
    tolerance = float(re.search(r"tolerance of ([.\d]+)", str(refusal.value))[1])
    with pytest.warns(MeshNote, match="the sheets are corrected"):
        assert 900 < volume(read(tmp_path, drawing, tolerance=tolerance)) < 1050


def tetrahedron(x, texts):
    """A triangle with the folds of a tetrahedron, one end of which is at x instead of 35."""
    places = ((47, 36), (24, 80), (34, 98), (85, 98), (71, 36), (95, 80))
    numbers = "".join(
        f'<text x="{u}" y="{v}" font-size="4">{text}</text>'
        for (u, v), text in zip(places, texts, strict=False)
    )
    return svg(f"""<polygon points="10,100 110,100 60,13.397460" fill="none" stroke="red"/>
        <path d="M60 100 L{x} 56.698730 L85 56.698730 Z" fill="none" stroke="blue"/>{numbers}""")


def test_a_fold_that_ends_beside_the_outline(tmp_path):
    """It is named with a tolerance that helps: 2.2 times the gap, 0.3 sin 60 degrees."""
    remedy = r"; a line ends at \[35.3, -56.6987\], 0.26 mm from another: tolerance=(\S+) joins them$"
    with pytest.raises(InvalidParameter, match=remedy), pytest.warns(MeshNote, match="1 at 1 side"):
        read(tmp_path, tetrahedron(35.3, "112233"))
    with pytest.warns(MeshNote, match="the sheets are corrected"):
        net = read(tmp_path, tetrahedron(35.3, "112233"), tolerance=0.58)
    assert volume(net) == pytest.approx(50**3 / 72**0.5, rel=0.02)


def test_sides_with_wrong_numbers(tmp_path):
    """The corners where more than a full turn meets are named by their places."""
    net = read(tmp_path, tetrahedron(35, "122313"))
    places = r"540 degrees, meets at \[35, -56.6987\], \[60, -100\], \[85, -56.6987\] \(vertex"
    with pytest.raises(InvalidMetric, match=places):
        isoembed.embed(net)


def test_sides_without_a_number_are_said(tmp_path):
    with pytest.warns(MeshNote, match="2 sides that no number pairs are glued by their lengths"):
        net = read(tmp_path, tetrahedron(35, "1122"))
    assert volume(net) == pytest.approx(50**3 / 72**0.5, rel=1e-5)


# Paths


@pytest.mark.parametrize(
    ("d", "points"),
    [
        ("M1 2L3 4", [[1, 2], [3, 4]]),
        ("m1,2 3,4 5-6", [[1, 2], [4, 6], [9, 0]]),
        ("M1 2H5V7h-1v-.5", [[1, 2], [5, 2], [5, 7], [4, 7], [4, 6.5]]),
        ("M0 0.5.5.25", [[0, 0.5], [0.5, 0.25]]),
        ("M1e1-2E-1L0,0", [[10, -0.2], [0, 0]]),
    ],
)
def test_straight_paths(d, points):
    ((found, closed),) = path_points(d)[0]
    assert found.tolist() == points and not closed


def test_parts_of_a_path():
    parts = path_points("M0 0L1 0L1 1zl5 5M9 9L8 8")[0]
    assert [closed for _, closed in parts] == [True, False, False]
    assert parts[1][0].tolist() == [[0, 0], [5, 5]]


@pytest.mark.parametrize("flags", ["0 1", "0 0", "1 1", "1 0"])
def test_arcs_lie_on_their_ellipse(flags):
    ((points, _),) = path_points(f"M3 1A5 2 30 {flags} 1 4")[0]
    c, s = math.cos(math.radians(30)), math.sin(math.radians(30))
    turned = points @ np.array([[c, -s], [s, c]]) / [5, 2]  # on a circle of radius 1
    x, y = turned.T
    rows = np.column_stack([2 * x, 2 * y, np.ones(len(x))])
    (u, v, _), *_ = np.linalg.lstsq(rows, x**2 + y**2, rcond=None)
    assert np.hypot(x - u, y - v) == pytest.approx(np.ones(len(x)), abs=1e-9)
    angle = np.unwrap(np.arctan2(y - v, x - u))
    assert (abs(angle[-1] - angle[0]) > math.pi) == (flags[0] == "1")
    assert (angle[-1] > angle[0]) == (flags[-1] == "1")
    assert points[[0, -1]] == pytest.approx(np.array([[3, 1], [1, 4]]))


def test_flags_may_stand_together():
    assert (
        path_points("M3 1A5 2 30 011 4")[0][0][0].tolist()
        == path_points("M3 1A5 2 30 0 1 1 4")[0][0][0].tolist()
    )


def test_curves_are_near_their_chords():
    ((points, _),) = path_points("M0 0C0 55.228 44.772 100 100 100S200 55.228 200 0")[0]
    middles = (points[1:] + points[:-1]) / 2
    radius = np.hypot(*(middles - [100, 0]).T)  # a half circle, as nearly as cubics are
    assert np.abs(radius - 100).max() < 0.04
    ((quadratic, _),) = path_points("M0 0Q1 2 2 0T4 0")[0]
    x = quadratic[:, 0]
    assert quadratic[:, 1] == pytest.approx(np.where(x <= 2, x * (2 - x), -(x - 2) * (4 - x)))


def test_layers_of_inkscape_are_known_by_their_labels(tmp_path):
    ns = 'xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape"'
    (tmp_path / "a.svg").write_text(
        f'<svg {ns} width="1mm"><g id="layer1" inkscape:label="Engrave"><path d="M0 0L1 1"/></g>'
        '<g id="layer2" inkscape:label="Cut" style="display:none"><path d="M0 0L1 1"/></g></svg>'
    )
    with InputFile(tmp_path / "a.svg") as file:
        lines = read_svg_lines(file)
    assert [line.purpose for line in lines.lines] == ["read"]


# DXF of others


@pytest.fixture
def dxf():
    return pytest.importorskip("ezdxf")


def cross_of_lines(space, unit=1.0, layer="0"):
    """The net of a cube of side 1, every line by itself, with numbers."""
    for x, y in ((0, 1), (1, 1), (2, 1), (3, 1), (1, 0), (1, 2)):
        corners = [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)]
        for (a, b), (c, d) in zip(corners, corners[1:] + corners[:1], strict=True):
            space.add_line((a * unit, b * unit), (c * unit, d * unit), dxfattribs={"layer": layer})
    places = {
        "a": ((0.9, 0.5), (0.5, 1.1)), "b": ((1.5, 0.1), (3.5, 1.1)), "c": ((2.1, 0.5), (2.5, 1.1)),
        "d": ((0.9, 2.5), (0.5, 1.9)), "e": ((1.5, 2.9), (3.5, 1.9)), "f": ((2.1, 2.5), (2.5, 1.9)),
        "g": ((0.1, 1.5), (3.9, 1.5)),
    }  # fmt: skip
    return [(text, unit * x, unit * y) for text, some in places.items() for x, y in some]


@pytest.mark.parametrize(("code", "millimeters"), [(0, 1.0), (1, 25.4), (4, 1.0), (5, 10.0), (6, 1000.0)])
@pytest.mark.parametrize("version", ["R12", "R2000", "R2018"])
def test_units_of_dxf(tmp_path, dxf, version, code, millimeters):
    if version == "R12" and code:
        pytest.skip("has no units")
    document = dxf.new(version)
    document.units = code
    space = document.modelspace()
    for text, x, y in cross_of_lines(space, 20.0):
        space.add_text(text, height=1.0).set_placement(
            (x, y), align=dxf.enums.TextEntityAlignment.MIDDLE_CENTER
        )
    document.saveas(tmp_path / "net.dxf")
    said = nullcontext() if code else pytest.warns(MeshNote, match="net.dxf has no unit: millimeters are ta")
    with said:
        net = read_net(tmp_path / "net.dxf")
    assert volume(net) == pytest.approx((20 * millimeters) ** 3, rel=1e-6)


def test_blocks_and_paragraphs_of_dxf(tmp_path, dxf):
    document = dxf.new("R2010", units=4)
    block = document.blocks.new("NET")
    for text, x, y in cross_of_lines(block, 2.0, layer="Outline"):
        block.add_mtext(text, dxfattribs={"char_height": 0.2, "insert": (x, y), "attachment_point": 5})
    how = {"xscale": 5, "yscale": 5, "rotation": 30}
    document.modelspace().add_blockref("NET", (100, 50), dxfattribs=how)
    document.saveas(tmp_path / "net.dxf")
    assert volume(read_net(tmp_path / "net.dxf", tolerance=1e-6)) == pytest.approx(1000, rel=1e-6)


def test_rows_and_columns_of_a_block(tmp_path, dxf):
    document = dxf.new("R2010", units=4)
    document.blocks.new("A").add_line((0, 0), (1, 0))
    grid = {"row_count": 2, "column_count": 3, "row_spacing": 5, "column_spacing": 7}
    document.modelspace().add_blockref("A", (0, 0), dxfattribs=grid)
    document.saveas(tmp_path / "net.dxf")
    with InputFile(tmp_path / "net.dxf") as file:
        begins = [line.points[0].tolist() for line in dxf_lines.read_dxf_lines(file).lines]
    assert sorted(begins) == [[x, y] for x in (0, 7, 14) for y in (0, 5)]


def test_blocks_that_are_inserted_many_times(tmp_path, dxf, monkeypatch):
    document = dxf.new("R2010")
    document.blocks.new("B0").add_line((0, 0), (1, 0))
    for k in range(1, 9):
        block = document.blocks.new(f"B{k}")
        for x in range(10):
            block.add_blockref(f"B{k - 1}", (x, 0))
    document.modelspace().add_blockref("B8", (0, 0))
    document.saveas(tmp_path / "net.dxf")
    monkeypatch.setattr(dxf_lines, "MOST_READ", 50)
    with pytest.raises(FileError, match="draws more than 50 entities: no net needs as many"):
        read_net(tmp_path / "net.dxf")


@pytest.mark.parametrize(
    "draw",
    [
        lambda space: space.add_blockref("missing", (0, 0)),
        lambda space: space.add_lwpolyline([(0, 0, 1e30), (1, 0, 0)], format="xyb"),
        lambda space: space.add_spline([(0, 0)] * 4),
    ],
)
def test_entities_of_dxf_that_are_damaged(tmp_path, dxf, draw):
    document = dxf.new("R2010")
    draw(document.modelspace())
    document.saveas(tmp_path / "net.dxf")
    with pytest.raises(FileError, match=r"net.dxf is not a readable DXF file"):
        read_net(tmp_path / "net.dxf")


def test_curves_of_dxf_are_sampled(tmp_path, dxf):
    document = dxf.new("R2010", units=4)
    space = document.modelspace()
    space.add_circle((0, 0), 10)
    space.add_line((-20, 0), (20, 0))
    space.add_arc((0, 0), 20, 0, 180)
    space.add_lwpolyline([(-20, 0, 1.0), (20, 0, 0.0)], format="xyb")  # a half circle
    document.saveas(tmp_path / "net.dxf")
    with InputFile(tmp_path / "net.dxf") as file:
        circle, line, arc, bulge = dxf_lines.read_dxf_lines(file).lines
    assert circle.is_circle and circle.is_closed
    assert line.points.tolist() == [[-20, 0], [20, 0]]
    for curve, radius in ((circle, 10), (arc, 20), (bulge, 20)):
        middles = (curve.points[1:] + curve.points[:-1]) / 2
        assert np.hypot(*middles.T) == pytest.approx(np.full(len(middles), radius), rel=2e-3)
    assert arc.points[:, 1].min() > -1e-9 and bulge.points[:, 1].min() < -19


@pytest.mark.parametrize(
    ("text", "sentence"), [("", "is not a readable DXF file"), ("0\nSECTION\n", "is not")]
)
def test_dxf_that_is_refused(tmp_path, dxf, text, sentence):
    (tmp_path / "net.dxf").write_text(text)
    with pytest.raises(FileError, match=sentence):
        read_net(tmp_path / "net.dxf")
