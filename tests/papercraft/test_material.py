"""Material of nets: kerf, allowances, stitches and perforated folds."""

import math

import numpy as np
import pytest
from scipy.spatial.distance import pdist

import isoembed
import zoo
from exact import is_simple
from gluing_polygons import shoelace
from isoembed import Embedding, InvalidParameter, PolyhedralMetric
from isoembed.gluing import unfold
from isoembed.gluing.line_graph import is_inside
from isoembed.papercraft import Material
from isoembed.papercraft.drawing import drawn
from isoembed.papercraft.perforation import pieces
from isoembed.papercraft.placing import laid_out


def net_of(vertices, faces):
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    return unfold(Embedding(metric, vertices, method="given", tolerance=1e-10))


@pytest.fixture(scope="module")
def cube():
    return net_of(*zoo.cube())


@pytest.mark.parametrize("length", [0.5, 3.0, 17.0, 40.0, 41.3])
def test_perforated_folds_begin_and_end_with_material(length):
    material = Material(bends="perforate", dash=3.0, gap=1.0)
    line = np.array([[1.0, 2.0], [1.0 + 0.6 * length, 2.0 + 0.8 * length]])
    dashes = pieces(line, material)
    along = (dashes - line[0]) @ [0.6, 0.8]
    gaps = np.diff(np.concatenate([[0], along.ravel(), [length]]))[::2]
    cuts = along[:, 1] - along[:, 0]
    assert np.ptp(gaps) == pytest.approx(0, abs=1e-9) and np.ptp(cuts) == pytest.approx(0, abs=1e-9)
    assert len(dashes) >= 3
    if length >= 13:
        assert cuts[0] == pytest.approx(3.0) and gaps[0] > 1.0 - 1e-9
        assert len(dashes) == math.floor((length - 1) / 4)
    beam = pieces(line, Material(bends="perforate", dash=3.0, gap=1.0, kerf=0.5))
    if length >= 13:
        assert np.hypot(*(beam[0, 1] - beam[0, 0])) == pytest.approx(2.5)


def test_kerf_is_outside_of_what_is_cut_out(cube):
    plain, kerf = (drawn(cube, scale=40.0, material=Material(joints="none", kerf=k)) for k in (0, 0.4))
    (before,), (after,) = plain.cuts, kerf.cuts
    assert len(before) == len(after) == 14
    assert np.abs(after - before).max() == pytest.approx(0.2)
    perimeter = 14 * 40.0
    turns = 4 * 0.2**2  # right angles: those to the left are four more than those to the right
    assert shoelace(after) == pytest.approx(shoelace(before) + 0.2 * perimeter + turns)


def test_a_router_is_wider_than_holes_that_are_not_there(cube):
    (cut,) = drawn(cube, scale=40.0, material=Material(joints="none", kerf=6.0)).cuts
    assert shoelace(cut) == pytest.approx(6 * 40**2 + 14 * 40 * 3 + 4 * 3**2)


def test_holes_are_smaller_by_the_kerf(cube):
    drawing = drawn(cube, scale=40.0, material=Material(joints="stitches", hole=1.2, kerf=0.2))
    assert {radius for _, _, radius in drawing.holes} == {0.5}


@pytest.mark.parametrize("allowance", [0.0, 1.0])
@pytest.mark.parametrize("seed", range(3))
def test_as_many_holes_on_both_sides(seed, allowance):
    net = net_of(*zoo.random_hull(10, seed))
    material = Material(joints="stitches", allowance=allowance, spacing=4.0)
    drawing = drawn(net, size=100.0, material=material)
    sides = laid_out(net, size=100.0).unfolding.sides  # in islands
    holes = np.array(drawing.holes)[:, :2]
    outlines = drawing.seams or drawing.cuts
    inset = 0.0 if allowance else 4.0
    assert sum(map(len, outlines)) == 2 * len(sides)
    lengths = {}
    for p, outline in enumerate(outlines):
        for k in range(len(outline)):
            start, end = outline[k], outline[(k + 1) % len(outline)]
            length = np.hypot(*(end - start))
            along = (end - start) / length
            x, y = (holes - start) @ along, (holes - start) @ [-along[1], along[0]]
            lengths[p, k] = sorted(x[(np.abs(y - inset) < 1e-6) & (x > 0) & (x < length)] / length)
    for one, other in sides:
        assert lengths[one] == pytest.approx([1 - x for x in reversed(lengths[other])])
    if not allowance:
        assert all(any(is_inside(hole, outline) for outline in outlines) for hole in holes)
        assert pdist(holes).min() > 1.9


def test_allowances(cube):
    drawing = drawn(cube, scale=30.0, material=Material(joints="none", allowance=10.0))
    (seam,), (cut,) = drawing.seams, drawing.cuts
    assert shoelace(seam) == pytest.approx(6 * 30**2)
    assert is_simple(cut)
    assert shoelace(cut) == pytest.approx(6 * 30**2 + 14 * 30 * 10 + 4 * 10**2)  # right angles stay
    assert cut[:, 0].min() >= 7 and cut[:, 0].max() <= 203  # on the page, with a margin


def test_allowances_of_several_sheets_are_apart():
    vertices, faces = zoo.cube()
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    net = unfold(Embedding(metric, vertices, method="given", tolerance=1e-10), objective="faces")
    drawing = drawn(net, scale=30.0, material=Material(joints="none", allowance=15.0))
    boxes = [(cut.min(axis=0), cut.max(axis=0)) for cut in drawing.cuts]
    assert len(boxes) == 6
    for k, (low, high) in enumerate(boxes):
        for other_low, other_high in boxes[:k]:
            assert (np.maximum(low, other_low) - np.minimum(high, other_high)).max() > 0


@pytest.mark.parametrize("ending", [".svg", ".dxf"])
@pytest.mark.parametrize(
    "material",
    [
        Material(bends="perforate", kerf=0.15),
        Material(joints="none", kerf=0.3),
        Material(joints="stitches", kerf=0.15),
        Material(joints="stitches", allowance=6.0, kerf=0.15, bends="perforate"),
    ],
)
def test_the_solid_comes_back(tmp_path, material, ending):
    if ending == ".dxf":
        pytest.importorskip("ezdxf")
    vertices, faces = zoo.random_hull(12, 3)
    scale = 60 / np.ptp(vertices)
    net_of(vertices, faces).save(tmp_path / f"net{ending}", scale=scale, material=material)
    solid = isoembed.embed(isoembed.glue(tmp_path / f"net{ending}"))
    assert np.sort(pdist(solid.vertices)) == pytest.approx(np.sort(pdist(vertices * scale)), abs=2e-3)


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"joints": "glue"}, "joints is 'glue', not one of tabs, stitches, none"),
        ({"bends": "cut"}, "bends is 'cut', not one of score, perforate"),
        ({"surface": "middle"}, "surface is 'middle', not one of outside, inside"),
        ({"kerf": -0.1}, "kerf is -0.1, not a number of at least 0"),
        ({"spacing": 0}, "spacing is 0, not a number above 0"),
        ({"thickness": math.nan}, "thickness is nan, not a number of at least 0"),
        ({"thickness": "3"}, "thickness is '3', not a number of at least 0"),
        ({"k_factor": 1.5}, "k_factor is 1.5, not from 0 to 1"),
        ({"allowance": 5.0}, "an allowance of 5 mm is for joints='stitches' or joints='none'"),
        ({"kerf": 1.0, "joints": "stitches"}, "kerf is 1 mm, as wide as a hole of 1 mm"),
        ({"kerf": 4.0, "bends": "perforate"}, "kerf is 4 mm, as wide as a dash of 3 mm"),
    ],
)
def test_refusals(given, sentence):
    with pytest.raises(InvalidParameter, match=sentence):
        Material(**given)


def test_an_allowance_that_closes_a_notch_is_refused():
    with pytest.raises(InvalidParameter, match=r"closes the notch of sheet 0|vanishes"):
        drawn(net_of(*zoo.random_hull(30, 1)), material=Material(joints="none", allowance=8.0))
