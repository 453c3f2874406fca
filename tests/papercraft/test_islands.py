"""Nets larger than a page: islands that fit, are the same solid, and are as few as can be."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import isoembed
import solids
import zoo
from exact import is_simple
from gluing_polygons import shoelace
from isoembed import Embedding, PolyhedralMetric
from isoembed.gluing import Unfolding, unfold
from isoembed.metric.curvature import deficits
from isoembed.papercraft import Material, fewest_pages
from isoembed.papercraft.drawing import drawn
from isoembed.papercraft.fitting import best_turn
from isoembed.papercraft.islands import partition
from isoembed.papercraft.paper import FOOT, FORMATS, MARGIN, Paper
from isoembed.papercraft.placing import GAP, laid_out

A4 = np.array([182.0, 259.0])  # what is inside the margins


def solid(vertices, faces):
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    return Embedding(metric, vertices, method="given", tolerance=1e-10)


def with_edges(vertices, faces, edge):
    """The solid with edges of this length."""
    surface = solid(vertices, faces)
    return solid(vertices * (edge / surface.lengths.min()), faces)


def check_layout(layout, paper, surface):
    """All is on the pages, apart, exactly simple, and glued again it is the surface."""
    net = layout.unfolding
    assert all(map(is_simple, net.sheets))
    assert sum(map(shoelace, net.sheets)) == pytest.approx(surface.area, rel=1e-12)
    boxes = []
    for place, sheet in zip(layout.places, net.sheets, strict=True):
        there = place.put(sheet)
        assert np.hypot(*np.ptp(there, axis=0)) > 0
        low, high = there.min(axis=0), there.max(axis=0)
        page = int(-high[1] // layout.height)
        assert low[0] >= MARGIN - 1e-6 and high[0] <= layout.width - MARGIN + 1e-6
        assert -high[1] - page * layout.height >= MARGIN - 1e-6
        assert (page + 1) * layout.height + low[1] >= MARGIN + FOOT - 1e-6
        assert page < layout.pages
        boxes.append((low, high))
    for one, other in combinations(boxes, 2):
        assert np.maximum(one[0] - other[1], other[0] - one[1]).max() >= GAP - 1e-6
    sides = [side for pair in net.sides for side in pair]
    assert sorted(sides) == [(p, k) for p, sheet in enumerate(net.sheets) for k in range(len(sheet))]
    numbers = np.concatenate(net.numbers)
    assert sorted(numbers) == list(range(len(numbers)))
    found = np.zeros(surface.triangulation.n_vertices)
    found[np.concatenate(net.corners)] = net.net.deficits[np.concatenate(net.net.corners)]
    assert found == pytest.approx(deficits(surface.metric), abs=1e-9)
    for sheet, corners in zip(net.sheets, net.corners, strict=True):
        steps = np.linalg.norm(np.roll(sheet, -1, axis=0) - sheet, axis=1)
        ends = surface.vertices[corners]
        assert steps == pytest.approx(np.linalg.norm(np.roll(ends, -1, axis=0) - ends, axis=1), rel=1e-12)


def test_a_cube_of_150_mm_on_a4_is_six_squares():
    surface = with_edges(*zoo.cube(), 150.0)  # two squares in a row are 300 mm long
    layout = laid_out(unfold(surface), scale=1.0)
    check_layout(layout, "A4", surface)
    assert len(layout.unfolding.sheets) == layout.pages == 6
    assert len(layout.unfolding.sides) == 12
    assert not any(map(len, layout.unfolding.folds))
    again = isoembed.embed(layout.unfolding.net, method="alexandrov")
    assert again.volume == pytest.approx(150.0**3, rel=1e-12)


@pytest.mark.parametrize(("edge", "islands"), [(200.0, 20), (150.0, 10), (45.0, 1)])
def test_islands_of_an_icosahedron(edge, islands):
    """Two triangles of 200 mm are 300 mm long and 173 mm wide; of 150 mm two fit, three are 300 mm long."""
    surface = with_edges(*zoo.icosahedron(), edge)
    layout = laid_out(unfold(surface), scale=1.0)
    check_layout(layout, "A4", surface)
    assert len(layout.unfolding.sheets) == islands
    assert sum(map(len, layout.unfolding.folds)) == 20 - islands


def brute_force(sheet, faces, room):
    """The fewest islands and the shortest cuts, of all ways to cut."""
    owner = {
        side: f
        for f, face in enumerate(faces)
        for side in zip(face.tolist(), np.roll(face, -1).tolist(), strict=True)
    }
    joints = [
        (owner[a, b], owner[b, a], np.hypot(*(sheet[a] - sheet[b])))
        for a, b in owner
        if a < b and (b, a) in owner
    ]
    known = {}

    def fits(some):
        if some not in known:
            points = np.concatenate([sheet[faces[f]] for f in some])
            known[some] = best_turn(points, room, oblique=True)[1] >= 1 - 1e-9
        return known[some]

    for count in range(len(faces)):
        lengths = []
        for cut in combinations(range(len(joints)), count):
            group = list(range(len(faces)))
            for k, (f, g, _) in enumerate(joints):
                if k not in cut:
                    group = [group[g] if one == group[f] else one for one in group]
            if all(fits(tuple(f for f, one in enumerate(group) if one == each)) for each in set(group)):
                lengths.append(sum(joints[k][2] for k in cut))
        if lengths:
            return count + 1, min(lengths)
    raise AssertionError


@pytest.mark.parametrize("part", [0.5, 0.95])
@pytest.mark.parametrize("seed", range(4))
def test_islands_against_all_ways_to_cut(seed, part):
    net = unfold(solid(*zoo.random_hull(7, seed)))
    sheet, faces = net.sheets[0], net.faces[0]
    scale = part * min(best_turn(sheet[face], A4, oblique=True)[1] for face in faces)
    cuts = partition(sheet, faces, A4 / scale)
    islands, length = brute_force(sheet, faces, A4 / scale)
    assert len(cuts) + 1 == islands
    assert sum(np.hypot(*(sheet[a] - sheet[b])) for a, b in cuts) == pytest.approx(length)


@given(
    st.integers(6, 30), st.integers(0, 10**6), st.sampled_from(["A5", "A4", "letter", "300x120", "roll:200"])
)
@settings(max_examples=30, deadline=None)
def test_random_hulls_on_any_paper(n, seed, paper):
    surface = solid(*zoo.random_hull(n, seed))
    net = unfold(surface)
    page = Paper.of(paper)
    scale = 0.8 * min(
        best_turn(sheet[face], page.room)[1]
        for sheet, some in zip(net.sheets, net.faces, strict=True)
        for face in some
    )
    layout = laid_out(net, paper, scale=scale)
    assert {layout.width, layout.height} == {page.width, page.height} or page.is_roll
    check_layout(layout, paper, surface)


def test_the_scale_that_a_refusal_names_fits():
    net = unfold(solid(*zoo.random_hull(12, 5)))
    with pytest.raises(isoembed.InvalidParameter, match=r"face \d+ fits on A5 up to scale=") as caught:
        laid_out(net, "A5", scale=1000.0)
    found = float(str(caught.value).split("up to scale=")[1].split(";")[0])
    laid_out(net, "A5", scale=found)
    with pytest.raises(isoembed.InvalidParameter):
        laid_out(net, "A5", scale=found * 1.001)
    paper = next((name for name in FORMATS if f"paper='{name}'" in str(caught.value)), None)
    if paper is not None:
        laid_out(net, paper, scale=1000.0)


def test_a_paper_named_by_a_refusal_is_the_smallest():
    net = unfold(with_edges(*zoo.cube(), 400.0))
    with pytest.raises(isoembed.InvalidParameter, match=r"; paper='A1' is large enough$"):
        laid_out(net, scale=1.0)
    laid_out(net, "A1", scale=1.0)
    with pytest.raises(
        isoembed.InvalidParameter, match="no format is large enough: give a page size, paper="
    ):
        laid_out(net, scale=4.0)


@pytest.mark.parametrize(
    ("paper", "named"), [("A4", "A3"), ("letter", "tabloid"), ("210x297", "tabloid"), ("a4", "A3")]
)
def test_a_refusal_names_a_paper_of_the_same_series(paper, named):
    net = unfold(with_edges(*zoo.cube(), 200.0))
    with pytest.raises(isoembed.InvalidParameter, match=rf"; paper='{named}' is large enough$"):
        laid_out(net, paper, scale=1.0)


def test_a_size_is_that_of_a_known_solid():
    net = replace(unfold(solid(*zoo.cube())), vertices=None)
    with pytest.raises(
        isoembed.InvalidParameter, match="a size requires the solid, which this net does not have"
    ):
        laid_out(net, size=100.0)


def test_a_size_is_the_longest_extent():
    net = unfold(solid(zoo.cube()[0] * [1.0, 2.0, 3.0], zoo.cube()[1]))
    assert laid_out(net, size=120.0).scale == pytest.approx(120 / np.ptp(net.vertices[:, 2]))


def test_a_page_is_turned_where_that_takes_fewer_islands():
    surface = solid(
        zoo.cube()[0] * (np.array([260.0, 20, 20]) / np.ptp(zoo.cube()[0], axis=0)), zoo.cube()[1]
    )
    layout = laid_out(unfold(surface), scale=1.0)  # 260 mm long: more than the 259 of an upright page
    check_layout(layout, "A4", surface)
    assert (layout.width, layout.height) == (297.0, 210.0)


def test_a_figure_fits_obliquely():
    """A rod as long as 0.9 of a diagonal, of no width nearly."""
    rod = np.array([[0.0, 0], [1, 0], [1, 1e-3], [0, 1e-3]])
    upright, oblique = (best_turn(rod, A4, oblique=way)[1] for way in (False, True))
    assert upright == pytest.approx(259)
    assert 0.99 * np.hypot(*A4) < oblique < np.hypot(*A4)


@pytest.mark.parametrize("seed", range(5))
def test_the_best_turn_against_many_angles(seed):
    points = np.random.default_rng(seed).normal(size=(12, 2)) * [1.0, 0.4]
    angles = np.linspace(0, np.pi, 20001)
    turns = np.array([[np.cos(angles), -np.sin(angles)], [np.sin(angles), np.cos(angles)]]).transpose(2, 0, 1)
    sampled = (A4 / np.ptp(points @ turns, axis=1)).min(axis=1).max()
    turn, found = best_turn(points, A4, oblique=True)
    assert sampled <= found * (1 + 1e-12) and found <= sampled * (1 + 1e-3)
    assert (A4 / np.ptp(points @ turn, axis=0)).min() == pytest.approx(found)


def test_a_roll_is_as_long_as_needed():
    surface = with_edges(*zoo.cube(), 150.0)
    layout = laid_out(unfold(surface), "roll:500", scale=1.0)
    check_layout(layout, "roll:500", surface)
    assert (layout.width, layout.pages, len(layout.unfolding.sheets)) == (500.0, 1, 1)
    assert layout.height == np.ceil(600 + FOOT + 2 * MARGIN)  # four squares in a row


def test_both_sides_of_a_cut_have_the_same_number():
    drawing = drawn(unfold(with_edges(*zoo.cube(), 150.0)), scale=1.0)
    assert sorted(int(one.text) for one in drawing.labels) == sorted([*range(1, 13)] * 2)
    assert len(drawing.cuts) == 6


def test_folds_that_are_kept_are_not_cut():
    """Bottom, a wall and the top of a box, 250 mm long together, whatever else is cut off."""
    vertices, faces = zoo.cube()
    vertices = vertices * (80 / np.ptp(vertices[:, 0]))
    surface = solid(vertices, faces)
    wall = unfold(surface, objective="faces").corners[0].tolist()
    keep = [(wall[0], wall[1]), (wall[2], wall[3])]
    layout = laid_out(unfold(surface, keep=keep), scale=1.0)
    check_layout(layout, "A4", surface)
    assert len(layout.unfolding.sheets) > 1
    for edge in keep:
        assert any(
            set(edge) == set(corners[fold].tolist())
            for corners, folds in zip(layout.unfolding.corners, layout.unfolding.fold_corners, strict=True)
            for fold in folds
        )
    with pytest.raises(
        isoembed.InvalidParameter, match=r"face \d with the faces kept attached to it fits on A4 up"
    ):
        laid_out(unfold(surface, keep=keep), scale=1.5)


def test_fewest_pages():
    surface = solid(*zoo.random_hull(30, 1))
    net = fewest_pages(surface, scale=150.0)
    layout = laid_out(net, scale=150.0)
    check_layout(layout, "A4", surface)
    others = [
        laid_out(unfold(surface, objective=name), scale=150.0) for name in ("sheets", "length", "strips")
    ]
    assert layout.pages < min(other.pages for other in others)
    with pytest.raises(isoembed.InvalidParameter, match="give a scale or a size"):
        fewest_pages(surface)


def test_allowances_of_needles_are_apart():
    needle = np.array([[0.0, 0.0], [40.0, 0.0], [41.0, 0.5]])
    drawing = drawn(
        Unfolding((needle,) * 24, (np.arange(3),) * 24, (), (np.empty((0, 2, 2)),) * 24, (np.empty(0),) * 24),
        scale=1.0,
        material=Material(joints="none", allowance=6.0),
    )
    for one, other in combinations(drawing.cuts, 2):
        gaps = np.maximum(one.min(axis=0) - other.max(axis=0), other.min(axis=0) - one.max(axis=0))
        assert gaps.max() > 0
    assert min(cut[:, 0].min() for cut in drawing.cuts) > 5


def test_faces_of_sheets_are_those_of_the_solid():
    vertices = solids.uniform("truncated cube")
    polygons = solids.polygons(vertices)
    net = unfold(solid(vertices, solids.triangles(polygons)))
    found = [
        frozenset(corners[face].tolist())
        for corners, faces in zip(net.corners, net.faces, strict=True)
        for face in faces
    ]
    assert sorted(map(sorted, found)) == sorted(sorted(map(int, some)) for some in polygons)
