"""Nets typed with few digits: glued sides become equal by the smallest change."""

import re

import numpy as np
import pytest

import isoembed
import zoo
from isoembed import InvalidMetric, InvalidParameter, MeshNote, glue
from isoembed.gluing.classics import CLASSICS, regular_faces
from johnson_solids import johnson
from solids import polygons, uniform

TRIANGLE = [[0, 0], [1, 0], [0.5, 0.866025]]
NAMES = ["abc", "adb", "bdc", "adc"]
PLATONIC = dict(CLASSICS["platonic"].make())


def solved(net):
    return isoembed.embed(net, method="alexandrov")


def rounded(unfolding, digits):
    return [np.round(sheet, digits) for sheet in unfolding.sheets]


@pytest.mark.filterwarnings("ignore::isoembed.MeshNote")
@pytest.mark.parametrize("digits", range(4, 10))
@pytest.mark.parametrize("name", PLATONIC)
def test_platonic_nets_with_few_decimals(name, digits):
    solid = solved(PLATONIC[name])
    unfolding = isoembed.unfold(solid)
    net = glue(rounded(unfolding, digits), unfolding.sides)
    again = solved(net)
    assert net.n_vertices == PLATONIC[name].n_vertices
    assert again.residual < 1e-12
    assert again.volume == pytest.approx(solid.volume, rel=10.0 ** (1 - digits))


@pytest.mark.filterwarnings("ignore::isoembed.MeshNote")
@pytest.mark.parametrize("number", [3, 12, 37, 84, 91])
def test_johnson_nets_with_six_decimals(number):
    points = johnson(number)
    solid = solved(regular_faces(polygons(points)))
    unfolding = isoembed.unfold(solid)
    again = solved(glue(rounded(unfolding, 6), unfolding.sides))
    assert again.volume == pytest.approx(solid.volume, rel=1e-5)


@pytest.mark.filterwarnings("ignore::isoembed.MeshNote")
@pytest.mark.parametrize("digits", [1, 2, 3])
def test_faces_are_the_polygons_of_a_net_with_few_decimals(digits):
    turns = 2 * np.pi * np.arange(5) / 5
    pentagon = np.round(15 / np.sin(np.pi / 5) * np.column_stack([np.cos(turns), np.sin(turns)]), digits)
    names = [[str(v) for v in polygon] for polygon in polygons(uniform("dodecahedron"))]
    solid = solved(glue([pentagon] * 12, corners=names, tolerance=3 * 10.0**-digits))
    assert solid.surface.flat_faces.sides.tolist() == [5] * 12


def test_the_change_is_said():
    with pytest.warns(MeshNote, match=r"differ by up to 3\.5e-07 .*, from the corners, with 6 digits"):
        net = glue([TRIANGLE] * 4, corners=NAMES)
    change = net.correction
    # Neither the digits nor the change are larger than the differences between the sides.
    assert 0 < change.rms < change.largest < change.difference < 4e-7
    assert f"corner {change.corner} of polygon {change.polygon}" in str(change)
    assert solved(net).volume == pytest.approx(2**0.5 / 12, abs=1e-6)


def test_the_change_is_the_smallest():
    # Rectangles of widths 1 and 1 + e, twice: by symmetry each corner moves by e / 4 along the width.
    e = 1e-3
    one, other = ([[0, 0], [w, 0], [w, 2], [0, 2]] for w in (1, 1 + e))
    with pytest.warns(MeshNote):
        net = glue([one, other], corners=["abcd", "abcd"], tolerance=2e-3)
    assert (net.correction.largest, net.correction.rms) == pytest.approx((e / 4, e / 4), rel=1e-9)
    assert net.correction.difference == pytest.approx(e)


@pytest.mark.filterwarnings("ignore::isoembed.MeshNote")
def test_flat_vertices_become_flat():
    # Six triangles around a vertex on each side of a hexagon, corners typed with five decimals.
    around = [[round(np.cos(a), 5), round(np.sin(a), 5)] for a in np.pi / 3 * np.arange(6) + 0.3]
    triangles = [[[0, 0], around[k], around[(k + 1) % 6]] for k in range(6)]
    turn = np.array([[np.cos(0.7), np.sin(0.7)], [-np.sin(0.7), np.cos(0.7)]])
    sheets = [np.round(np.array(t) @ turn, 5) for t in [*triangles, *triangles]]
    names = [[center, k, (k + 1) % 6] for center in ("top", "bottom") for k in range(6)]
    net = glue(sheets, corners=names)
    deficits = np.sort(np.abs(net.deficits))
    assert deficits[:2].max() < 1e-12
    assert deficits[2:] == pytest.approx(2 * np.pi / 3, abs=1e-4)


@pytest.mark.filterwarnings("ignore::isoembed.MeshNote")
def test_corners_meet_corners_along_runs():
    # The boundary, of steps 1 1 1 2 1, glued to itself backward: corners meet at 1, 3, 5, not at 2, 4.
    shape = np.array([[0, 0], [1, 0], [2, 0], [2, 1], [0, 1]])
    turn = np.array([[np.cos(0.4), np.sin(0.4)], [-np.sin(0.4), np.cos(0.4)]])
    front, back = np.round(shape @ turn, 6), np.round(shape @ turn @ turn, 6)
    net = glue([front, back], [((0, 0, 0), (1, 0, 0))])
    assert net.n_vertices == 6
    assert [len(outline) for outline in net.polygons] == [6, 6]


def test_exact_numbers_are_no_rounded_ones():
    with pytest.raises(InvalidMetric, match=r"more than the tolerance .* of the length, by default"):
        glue([[[0, 0], [2000, 0], [2000, 1.1]], [[0, 0], [2000, 0], [2000, 1.2]]], corners=["abc", "abc"])


@pytest.mark.parametrize(
    ("top", "tolerance", "sentence"),
    [
        (0.8661, None, "from the corners, with"),
        (
            0.866025,
            1e-8,
            "(as given); correct them, or allow it: tolerance=3.5e-07 moves",
        ),
    ],
)
def test_what_differs_by_more_is_refused(top, tolerance, sentence):
    triangles = [TRIANGLE, TRIANGLE, TRIANGLE, [[0, 0], [1, 0], [0.5, top]]]
    with pytest.raises(InvalidMetric, match=re.escape(sentence)):
        glue(triangles, corners=NAMES, tolerance=tolerance)


@pytest.mark.filterwarnings("ignore::isoembed.MeshNote")
def test_the_advised_tolerance_glues():
    triangles = [TRIANGLE, TRIANGLE, TRIANGLE, [[0, 0], [1, 0], [0.5, 0.8661]]]
    with pytest.raises(InvalidMetric) as refusal:
        glue(triangles, corners=NAMES)
    advised = float(re.search(r"tolerance=([\d.e+-]+)", str(refusal.value))[1])
    assert solved(glue(triangles, corners=NAMES, tolerance=advised)).residual < 1e-12


@pytest.mark.filterwarnings("ignore::isoembed.MeshNote")
@pytest.mark.parametrize("noise", [1e-5, 1e-2])
def test_the_advised_tolerance_is_that_of_all_sides(noise):
    corners, squares = zoo.cube()
    cube = isoembed.PolyhedralMetric.from_mesh(corners, squares)
    net = isoembed.unfold(isoembed.Embedding(cube, corners, method="exact", tolerance=1e-10))
    rng = np.random.default_rng(3)
    sheets = [sheet + noise * rng.normal(size=sheet.shape) for sheet in net.sheets]
    with pytest.raises(InvalidMetric) as refusal:
        glue(sheets, net.sides)
    advised = float(re.search(r"tolerance=([\d.e+-]+)", str(refusal.value))[1])
    assert solved(glue(sheets, net.sides, tolerance=advised)).volume == pytest.approx(1, rel=10 * noise)


def test_no_tolerance_is_advised_that_does_not_help():
    # A side of 1.9 glued to one of .003 leaves no triangle on the one or the other side.
    wide, thin = [[0, 0], [1.9, 0], [0.95, 0.312]], [[0, 0], [3e-3, 0], [1.5e-3, 1]]
    with pytest.raises(InvalidMetric, match=r"correct them$"):
        glue([wide, thin], corners=["abc", "abc"])


@pytest.mark.parametrize("tolerance", [-1.0, np.nan, np.inf, "a", True])
def test_a_tolerance_is_a_length(tolerance):
    with pytest.raises(InvalidParameter, match="not a non-negative length"):
        glue([TRIANGLE] * 4, corners=NAMES, tolerance=tolerance)


def test_curved_polygons_are_not_corrected():
    with pytest.raises(InvalidParameter, match="a tolerance requires polygons in the plane"):
        glue([TRIANGLE] * 4, corners=NAMES, tolerance=0.1, curvature=-1.0)


def pyramid(rise):
    """A low pyramid over a square: the deficit at its apex is small."""
    edge = np.sqrt(0.5 + rise**2)
    side = [[0, 0], [1, 0], [0.5, np.sqrt(edge**2 - 0.25)]]
    return [side] * 4 + [[[0, 0], [1, 0], [1, 1], [0, 1]]], ["abe", "bce", "cde", "dae", "abcd"]


def test_a_large_tolerance_does_not_flatten_a_small_deficit():
    sheets, names = pyramid(0.01)  # lengths agree: there is nothing to correct, whatever is allowed
    exact, allowed = (glue(sheets, corners=names, tolerance=t) for t in (None, 0.1))
    assert allowed.correction is None
    assert allowed.deficits == pytest.approx(exact.deficits, abs=1e-12)
    assert 0 < exact.deficits[exact.corners[0][2]] < 1e-3


def test_what_a_large_tolerance_flattens_is_said():
    sheets, names = pyramid(0.01)
    sheets = [np.array(sheet) for sheet in sheets]
    sheets[4] = sheets[4] * [1.0, 1.01]  # two sides are off by a hundredth, which hides the apex
    with pytest.warns(MeshNote, match=r"1 vertices are flattened, with deficits of up to 0\.0008"):
        net = glue(sheets, corners=names, tolerance=0.02)
    assert net.correction.flattened == 1
    apex = net.corners[0][2]
    exact = glue(pyramid(0.01)[0], corners=names)
    assert net.correction.largest_deficit == pytest.approx(exact.deficits[apex], rel=1e-6)
    assert abs(net.deficits[apex]) < 1e-12
