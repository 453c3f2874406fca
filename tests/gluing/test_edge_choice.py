"""The user's own cuts, and what a net is made for."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import coo_array
from scipy.sparse.csgraph import minimum_spanning_tree

import zoo
from exact import is_simple
from gluing_polygons import shoelace
from isoembed import Embedding, InvalidParameter, PolyhedralMetric
from isoembed.gluing import unfold
from isoembed.metric.curvature import deficits
from isoembed.papercraft.fitting import best_turn

OBJECTIVES = ["sheets", "length", "strips", "faces"]


def solid(vertices, faces):
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    return Embedding(metric, vertices, method="given", tolerance=1e-10)


def cube():
    """Vertices 0 to 3 around the bottom, 4 to 7 above them."""
    square = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
    vertices = np.vstack([np.column_stack([square, np.full(4, z)]) for z in (0.0, 1.0)])
    quads = [(3, 2, 1, 0), (4, 5, 6, 7), *((k, (k + 1) % 4, 4 + (k + 1) % 4, 4 + k) for k in range(4))]
    return solid(vertices, [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


def check(net, surface):
    assert all(map(is_simple, net.sheets))
    assert sum(map(shoelace, net.sheets)) == pytest.approx(surface.area, rel=1e-12)
    found = np.zeros(surface.triangulation.n_vertices)
    found[np.concatenate(net.corners)] = net.net.deficits[np.concatenate(net.net.corners)]
    assert found == pytest.approx(deficits(surface.metric), abs=1e-9)


def cut_edges(net):
    """The edges that are cut, by their vertices."""
    return {
        frozenset((int(net.corners[p][k]), int(net.corners[p][(k + 1) % len(net.corners[p])])))
        for pair in net.sides
        for p, k in pair
    }


def cut_length(net):
    return sum(
        float(np.hypot(*(net.sheets[p][(k + 1) % len(net.sheets[p])] - net.sheets[p][k])))
        for (p, k), _ in net.sides
    )


def joints(net):
    """How many faces each face is joined to."""
    found = []
    for faces in net.faces:
        sides = [set(zip(face.tolist(), np.roll(face, -1).tolist(), strict=True)) for face in faces]
        every = set().union(*sides)
        found += [sum((b, a) in every for a, b in own) for own in sides]
    return found


@pytest.mark.parametrize("objective", OBJECTIVES)
def test_nets_of_every_objective_are_the_solid(objective):
    for n in (8, 30):
        surface = solid(*zoo.random_hull(n, n))
        net = unfold(surface, objective=objective)
        check(net, surface)
        again = unfold(surface, objective=objective)
        assert all((a == b).all() for a, b in zip(net.sheets, again.sheets, strict=True))


def test_every_face_by_itself():
    net = unfold(cube(), objective="faces")
    assert len(net.sheets) == 6 and len(net.sides) == 12
    assert {len(sheet) for sheet in net.sheets} == {4}
    kept = unfold(cube(), objective="faces", keep=[(0, 1), (4, 5)])  # the wall over 0, 1 with bottom and top
    assert sorted(map(len, kept.faces)) == [1, 1, 1, 3]


@pytest.mark.parametrize("seed", range(6))
def test_cuts_are_no_shorter_than_a_minimum_spanning_tree(seed):
    """Cuts that leave one sheet are a tree through all vertices."""
    surface = solid(*zoo.random_hull(25, seed))
    edges = surface.triangulation.edges
    tree = minimum_spanning_tree(coo_array((surface.lengths, edges.T), shape=(25, 25))).sum()
    net = unfold(surface, objective="length")
    assert len(net.sheets) == 1
    assert tree * (1 - 1e-12) <= cut_length(net) <= 1.05 * tree
    assert cut_length(net) < cut_length(unfold(surface))


def test_strips_have_no_branches():
    for surface, most in ((cube(), 1), (solid(*zoo.icosahedron()), 1), (solid(*zoo.random_hull(40, 1)), 2)):
        net = unfold(surface, objective="strips")
        assert max(joints(net)) <= 2
        assert len(net.sheets) <= most  # one is a path through all faces
    assert max(joints(unfold(solid(*zoo.random_hull(40, 1))))) == 3


@given(st.integers(0, 10**6), st.sampled_from(OBJECTIVES), st.data())
@settings(max_examples=40, deadline=None)
def test_chosen_edges_are_cut_and_kept(seed, objective, data):
    surface = solid(*zoo.random_hull(12, seed % 50))
    edges = surface.triangulation.edges.tolist()
    some = data.draw(st.lists(st.sampled_from(edges), unique_by=tuple, max_size=8))
    cut, keep = some[2:], some[:2]  # two edges of a triangulation close no ring
    net = unfold(surface, cut=cut, keep=keep, objective=objective)
    check(net, surface)
    gone = cut_edges(net)
    assert all(frozenset(edge) in gone for edge in cut)
    assert not any(frozenset(edge) in gone for edge in keep)


def test_cuts_around_a_face_make_it_a_sheet():
    net = unfold(cube(), cut=[(0, 1), (1, 2), (2, 3), (3, 0)])
    assert sorted(map(len, net.faces)) == [1, 5]


@pytest.mark.parametrize("objective", ["sheets", "length", "strips"])
def test_sheets_within_a_rectangle(objective):
    surface = solid(*zoo.random_hull(20, 3))
    room = np.array([1.1, 1.7])
    net = unfold(surface, within=tuple(room), objective=objective)
    check(net, surface)
    assert all(best_turn(sheet, room, oblique=True)[1] >= 1 for sheet in net.sheets)
    assert 1 < len(net.sheets) < sum(map(len, net.faces))


def test_two_squares_that_fit_exactly():
    """Of a cube three pairs of squares, and no more than two on a rectangle of two."""
    net = unfold(cube(), within=(2.0, 1.0))
    assert [len(faces) for faces in net.faces] == [2, 2, 2]


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"cut": [(0, 6)]}, r"cut\[0\] \(0, 6\) is not an edge between two faces"),
        (
            {"cut": [(0, 1), (0, 2)]},
            r"cut\[1\] \(0, 2\) is not an edge between .* at an angle; those of vertex 0 lead to \d",
        ),
        ({"keep": [(0, 99)]}, r"keep\[0\] \(0, 99\) is not an edge"),
        ({"keep": [3]}, r"keep\[0\] is 3, not a pair of vertex numbers"),
        ({"keep": [(0, 1.5)]}, r"keep\[0\] is \(0, 1\.5\), not a pair of vertex numbers"),
        ({"cut": [(0, 1)], "keep": [(1, 2), (1, 0)]}, r"keep\[1\] \(1, 0\) is in cut, too"),
        (
            {"keep": [(0, 1), (0, 3), (5, 6), (0, 4), (6, 7)]},
            r"keep\[3\] \(0, 4\) joins all faces around vertex 0, which cannot lie flat",
        ),
        (
            {"keep": [(0, 4), (1, 5), (2, 6), (3, 7)]},
            r"keep\[3\] \(3, 7\) closes a ring of faces, which cannot lie flat",
        ),
        (
            {"keep": [(0, 1), (1, 2), (2, 3)], "objective": "strips"},
            r"the edge \(\d, \d\) cannot be kept: .* do not form a strip",
        ),
        ({"within": (1.0, 0.0)}, r"within is \(1\.0, 0\.0\), not the width and height of a rectangle"),
        ({"within": 2.0}, r"within is 2\.0, not the width and height of a rectangle"),
        (
            {"keep": [(0, 1)], "within": (1.5, 1.5)},
            r"the edge \(1, 0\) cannot be kept: .* do not fit in the rectangle",
        ),
        ({"objective": "pages"}, "objective is 'pages', not one of sheets, length, strips, faces"),
    ],
)
def test_refusals(options, sentence):
    with pytest.raises(InvalidParameter, match=sentence):
        unfold(cube(), **options)


def test_faces_that_overlap_cannot_be_kept_together():
    """Sixteen faces around the apex of a double cone that dents in and out: more than a full turn."""
    n = 12
    angles = 2 * np.pi * np.arange(n) / n
    rim = np.column_stack([np.cos(angles), np.sin(angles), np.where(np.arange(n) % 2, 1.2, -1.2)])
    vertices = np.vstack([rim, [[0.0, 0, 0.3], [0, 0, -0.3]]])
    faces = [t for k in range(n) for t in ((k, (k + 1) % n, n), ((k + 1) % n, k, n + 1))]
    surface = solid(vertices, faces)
    assert deficits(surface.metric)[n] < -1
    with pytest.raises(
        InvalidParameter, match=r"cannot be kept: faces that it and the previous edges join overlap"
    ):
        unfold(surface, keep=[(k, n) for k in range(1, n)])
    check(unfold(surface), surface)
