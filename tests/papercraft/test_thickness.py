"""Nets of thick sheets: bend allowance, setback, and faces that leave room for one another."""

import math
from dataclasses import replace

import numpy as np
import pytest

import zoo
from drawings import lines_of
from exact import is_simple
from isoembed import Embedding, InvalidParameter, PolyhedralMetric
from isoembed.gluing import unfold
from isoembed.papercraft import Material
from isoembed.papercraft.drawing import drawn
from isoembed.papercraft.thickness import shortening, thickened


def net_of(vertices, faces):
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    return unfold(Embedding(metric, vertices, method="given", tolerance=1e-10))


def test_bend_deduction_of_sheet_metal():
    # 2 mm, inside radius 3 mm, K = .42, 90 degrees: BA = pi/2 (3 + .84) = 6.0319, BD = 2 (3 + 2) - BA.
    metal = Material(thickness=2.0, radius=3.0, k_factor=0.42)
    assert 2 * shortening(math.pi / 2, metal, True) == pytest.approx(3.9681, abs=1e-4)
    assert 2 * shortening(-math.pi / 2, metal, True) == pytest.approx(6 - 6.0319, abs=1e-4)  # measured inside


def test_inside_and_outside_change_places_with_convex_and_concave():
    outside = Material(thickness=2.0, radius=1.0, k_factor=0.3)
    inside = replace(outside, surface="inside")
    for angle in (-2.0, -0.3, 0.4, 1.5):
        for is_fold in (True, False):
            assert shortening(angle, outside, is_fold) == shortening(-angle, inside, is_fold)


@pytest.mark.parametrize("angle", [0.2, 1.0, math.pi / 2, 2.5])
def test_faces_cut_apart_touch_along_their_inner_edges(angle):
    t = 3.0
    s = shortening(angle, Material(thickness=t), False)
    # In a plane across the edge at the origin: the first face below y = 0 for x < 0.
    inner_corner = np.array([-s, -t])
    normal = np.array([math.sin(angle), math.cos(angle)])  # of the second face
    assert inner_corner @ normal == pytest.approx(-t)  # on its inner surface
    along = np.array([math.cos(angle), -math.sin(angle)])
    assert inner_corner @ along == pytest.approx(s)  # at its inner edge


def test_a_thick_cube():
    side, material = 100.0, Material(thickness=5.0, joints="none")
    fold, cut = 5.0 - math.pi / 2 * 2.5 / 2, 5.0
    net = net_of(*zoo.cube())
    unit = np.ptp(net.vertices, axis=0).max()
    (outline,) = thickened(net, material, side / unit).sheets
    outline = outline * side / unit
    assert is_simple(outline)
    # Each side of a face is shorter at both ends, and the area follows.
    area = 0.0
    for face in net.faces[0]:
        n = len(net.sheets[0])
        cuts = [(b - a) % n == 1 for a, b in zip(face, np.roll(face, -1), strict=True)]
        a, b, c, d = (cut if is_cut else fold for is_cut in cuts)
        area += (side - b - d) * (side - a - c)
    x, y = outline.T
    found = (x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2
    assert area - 14 * 3 < found < area  # reliefs at corners have a radius of about 1.5


@pytest.mark.parametrize("surface", ["outside", "inside"])
@pytest.mark.parametrize("seed", range(3))
def test_thin_sheets_are_nearly_paper(surface, seed):
    net = net_of(*zoo.random_hull(20, seed))
    errors = []
    for t in (1e-3, 1e-4):
        thick = thickened(net, Material(thickness=t, surface=surface), 1.0)
        assert [len(some) for some in thick.folds] == [len(some) for some in net.folds]
        assert sorted(np.concatenate(thick.angles)) == pytest.approx(sorted(np.concatenate(net.angles)))
        assert len(thick.sides) == len(net.sides)
        lengths = [
            [
                np.hypot(*(some.sheets[p][(k + 1) % len(some.sheets[p])] - some.sheets[p][k]))
                for (p, k), _ in some.sides
            ]
            for some in (net, thick)
        ]
        errors.append(np.abs(np.subtract(*lengths)).max())
        assert all(is_simple(sheet) for sheet in thick.sheets)
    assert 0 < errors[1] < errors[0] / 9


def test_the_drawing_has_the_folds_of_the_thick_sheet():
    net = net_of(*zoo.cube())
    drawing = drawn(net, scale=40.0, material=Material(thickness=3.0, joints="none"))
    fold = 3.0 - math.pi / 2 * 1.5 / 2
    lines = np.array(lines_of(drawing, "mountain"))
    steps = (lines[:, 1] - lines[:, 0]) / np.hypot(*(lines[:, 1] - lines[:, 0]).T)[:, None]
    apart = [
        abs(float((other[0] - one[0]) @ [-step[1], step[0]]))
        for k, (one, step) in enumerate(zip(lines, steps, strict=True))
        for other, beside in zip(lines[:k], steps, strict=False)
        if abs(step @ beside) > 0.99
    ]
    # Faces with two folds across from each other, and rows of such.
    assert apart == pytest.approx([round(d / (40 - 2 * fold)) * (40 - 2 * fold) for d in apart])
    assert max(apart) > 30
    assert max(np.hypot(*(lines[:, 1] - lines[:, 0]).T)) < 40 - 2 * fold
    assert [fold.angle for fold in drawing.folds] == pytest.approx([math.pi / 2] * 5)


def test_faces_that_vanish_are_named():
    net = net_of(*zoo.cube())
    with pytest.raises(
        InvalidParameter, match=r"face \d is too small for this thickness: use a larger scale"
    ):
        drawn(net, scale=10.0, material=Material(thickness=6.0))
    with pytest.raises(InvalidParameter, match="a thickness requires the faces and vertices of the solid"):
        thickened(replace(net, faces=()), Material(thickness=1.0), 1.0)
