"""Numbers of faces, on the net and on the drawing of the solid."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import solids
import zoo
from drawings import lines_of
from isoembed import Embedding, InvalidParameter, PolyhedralMetric
from isoembed.errors import MeshNote
from isoembed.gallery import BentTube, triangulate
from isoembed.gluing import unfold
from isoembed.papercraft.convex import overlaps
from isoembed.papercraft.drawing import drawn
from isoembed.papercraft.numbers import face_numbers
from isoembed.papercraft.views import SAMPLES, TOWARD, _visible, views

LOW, HIGH = np.array([10.0, 20.0]), np.array([200.0, 280.0])


def net_of(vertices, faces):
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    return unfold(Embedding(metric, vertices, method="given", tolerance=1e-10))


def seen(net):
    return views(net, net.vertices, LOW, HIGH)


def numbers_in(labels):
    return sorted(int(one.text[1:]) for one in labels if one.text.startswith("F"))


@pytest.mark.parametrize("name", ["cube", "dodecahedron", "truncated cube"])
def test_each_face_has_its_number_on_the_net_and_on_the_solid(name):
    vertices = solids.uniform(name)
    net = net_of(vertices, solids.triangles(solids.polygons(vertices)))
    plain, drawing = drawn(net), drawn(net, numbers=True)
    assert drawing.pages == plain.pages + 1
    count = sum(map(len, net.numbers))
    assert numbers_in(drawing.notes) == numbers_in(drawing.captions) == list(range(count))
    assert [cut.tolist() for cut in drawing.cuts] == [cut.tolist() for cut in plain.cuts]


def test_the_drawing_is_no_net():
    """On its page there are no ruler, no legend and no scale, as it is not to scale."""
    net = net_of(*zoo.icosahedron())
    plain, drawing = drawn(net), drawn(net, numbers=True)
    words = [one.text for one in drawing.captions if not one.text.startswith("F")]
    assert words == ["the solid, with the numbers of its faces; not to scale, not to be cut"]
    assert drawing.legend and all(ends[:, 1].min() > -plain.height for _, ends in drawing.legend)
    assert all(ends[:, 1].max() < -plain.height for ends in drawing.pictured)
    assert len(drawing.pictured) == len(seen(net)[0])  # the visible edges
    assert len(drawing.ruler) == len(plain.ruler)
    assert "page" not in drawing.notes[0].text  # of one page of the net


def test_faces_of_no_solid_have_no_numbers():
    with pytest.raises(
        InvalidParameter, match="numbers require the faces of a solid, which this net does not have"
    ):
        drawn(replace(net_of(*zoo.cube()), vertices=None), numbers=True)


def test_a_number_is_inside_its_face_and_meets_no_line_or_label():
    drawing = drawn(net_of(*zoo.icosahedron()), numbers=True)
    lines = np.array(
        [
            *lines_of(drawing, "mountain"),
            *np.stack([drawing.cuts[0], np.roll(drawing.cuts[0], -1, axis=0)], axis=1),
        ]
    )
    inside = [one for one in drawing.notes if one.text.startswith("F") and one.y > -drawing.height]
    boxes = np.array([one.box for one in (*drawing.labels, *inside)])
    for k, one in enumerate(inside, len(drawing.labels)):
        assert not overlaps(one.box, lines)
        assert not overlaps(one.box, np.delete(boxes, k, axis=0))


def test_a_number_in_a_face_that_is_not_convex():
    """In a horseshoe the mean of the corners is outside."""
    horseshoe = np.array([[0.0, 0], [60, 0], [60, 60], [50, 60], [50, 10], [10, 10], [10, 60], [0, 60]])
    (one,) = face_numbers([horseshoe], [7])
    assert one.text == "F7"
    assert not (10 <= one.x <= 50 and one.y >= 10)
    assert not overlaps(one.box, np.stack([horseshoe, np.roll(horseshoe, -1, axis=0)], axis=1))


def test_edges_of_a_cube_from_both_sides():
    """From either side nine of the twelve edges are seen, those in front whole."""
    lines, labels = seen(net_of(*zoo.cube()))
    assert len(lines) == 18
    assert numbers_in(labels) == list(range(6))
    points = np.concatenate(lines)
    assert (points >= LOW - 1e-9).all() and (points <= HIGH + 1e-9).all()


def test_an_edge_is_hidden_where_a_triangle_is_before_it():
    """A triangle at the height 1 over the middle of two edges, one below it and one above."""
    triangle = np.array([[[-1.0, -1, 1], [1, -1, 1], [0, 2, 1]]])
    below, above = (np.array([[-3.0, 0, z], [3, 0, z]]) for z in (0.0, 2.0))
    (whole,) = _visible(above[None], triangle, 1e-9)
    assert whole == pytest.approx(above[:, :2])
    left, right = _visible(below[None], triangle, 1e-9)
    width = 2 / 3  # of the triangle there, on each side of the middle
    assert left == pytest.approx(np.array([[-3, 0], [-width, 0]]), abs=6 / SAMPLES)
    assert right == pytest.approx(np.array([[width, 0], [3, 0]]), abs=6 / SAMPLES)


def test_no_face_is_seen_from_its_edge():
    """An octahedron two of whose faces are along one of the lines of sight."""
    turn, _ = Rotation.align_vectors([np.cross(TOWARD, [0.0, 0.0, 1.0])], [np.ones(3)])
    vertices = turn.apply(solids.uniform("octahedron"))
    _, labels = seen(net_of(vertices, solids.triangles(solids.polygons(vertices))))
    assert numbers_in(labels) == list(range(8))
    assert min(one.size for one in labels) > 2


def test_numbers_that_nobody_can_read_are_counted_and_left_out():
    net = net_of(*zoo.random_hull(40, 2))
    with pytest.warns(MeshNote, match=r"faces without a number, of 76: (\d+) on the net, where they are too"):
        drawing = drawn(net, scale=12.0, numbers=True)
    sizes = [one.size for one in drawing.notes if one.text.startswith("F")]
    assert 0 < len(sizes) < 76 and min(sizes) >= 1


def test_most_faces_of_a_dented_surface_are_seen_from_one_side_or_the_other():
    net = net_of(*triangulate(BentTube(), 60))
    _, labels = seen(net)
    found = numbers_in(labels)
    assert len(set(found)) == len(found) > 0.8 * sum(map(len, net.numbers))
