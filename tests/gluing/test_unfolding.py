"""Solids unfolded: sheets without overlaps that, glued again, are the solid."""

import numpy as np
import pytest
from scipy.spatial.distance import pdist

import isoembed
import solids
import zoo
from exact import is_simple
from gluing_polygons import shoelace
from isoembed import Embedding, InvalidMetric, PolyhedralMetric
from isoembed.gallery import BentTube, triangulate
from isoembed.gluing import unfold
from isoembed.metric.curvature import deficits


def solid(vertices, faces):
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    return Embedding(metric, vertices, method="given", tolerance=1e-10)


def check_sheets(unfolding, surface):
    """The sheets are simple, exactly, and counterclockwise; together they have the area of the surface."""
    assert all(map(is_simple, unfolding.sheets))
    areas = [shoelace(sheet) for sheet in unfolding.sheets]
    assert min(areas) > 0
    assert sum(areas) == pytest.approx(surface.area, rel=1e-12)


def check_deficits(unfolding, surface):
    """The net glued from the sheets has the deficits of the surface at the vertices that are there."""
    given = np.zeros(surface.triangulation.n_vertices)
    given[np.concatenate(unfolding.corners)] = unfolding.net.deficits[np.concatenate(unfolding.net.corners)]
    assert given == pytest.approx(deficits(surface.metric), abs=1e-9)


def check_again(unfolding, surface):
    """Glued again and embedded, the sheets give the coordinates back, up to a motion."""
    net = unfolding.net
    again = isoembed.embed(net, method="alexandrov").vertices
    of = dict(zip(np.concatenate(unfolding.corners), np.concatenate(net.corners), strict=True))
    there = sorted(of)
    found, given = again[[of[v] for v in there]], surface.vertices[there]
    assert np.abs(pdist(found) - pdist(given)).max() < 1e-9 * pdist(given).max()
    u, _, v = np.linalg.svd((found - found.mean(axis=0)).T @ (given - given.mean(axis=0)))
    assert np.linalg.det(u @ v) > 0  # no mirror image


@pytest.mark.parametrize(
    ("name", "faces"), [("tetrahedron", 4), ("cube", 6), ("octahedron", 8), ("icosahedron", 20)]
)
def test_platonic_solids(name, faces):
    surface = solid(*getattr(zoo, name)())
    unfolding = unfold(surface)
    pairs = surface.triangulation.n_vertices - 1
    assert repr(unfolding) == f"Unfolding(1 sheet, {pairs} pairs of sides, {faces - 1} folds)"
    check_sheets(unfolding, surface)
    check_again(unfolding, surface)
    angle = {4: np.pi - np.arccos(1 / 3), 6: np.pi / 2, 8: np.arccos(1 / 3), 20: np.arccos(5**0.5 / 3)}[faces]
    assert unfolding.angles[0] == pytest.approx(np.full(faces - 1, angle), rel=1e-12)


@pytest.mark.parametrize("n", [8, 20, 60])
def test_random_hulls(n):
    surface = solid(*zoo.random_hull(n, n))
    unfolding = unfold(surface)
    assert len(unfolding.sheets) == 1
    check_sheets(unfolding, surface)
    check_again(unfolding, surface)


def test_flat_vertices_make_no_difference():
    surface = solid(*zoo.subdivided(*zoo.cube()))
    unfolding = unfold(surface)
    assert repr(unfolding) == "Unfolding(1 sheet, 7 pairs of sides, 5 folds)"
    check_sheets(unfolding, surface)
    check_again(unfolding, surface)


def test_a_polyhedron_found_from_a_net():
    square, rest = [[0, 0], [1, 0], [1, 1], [0, 1]], [[2, 0], [3, 0], [3, 1], [2, 1]]
    flat = isoembed.embed(
        isoembed.glue([square, rest], [((0, k), (1, 3 - k)) for k in range(4)]), method="alexandrov"
    )
    unfolding = unfold(flat)
    assert repr(unfolding) == "Unfolding(1 sheet, 3 pairs of sides, 1 fold)"
    assert unfolding.angles[0] == pytest.approx([np.pi])
    check_sheets(unfolding, flat)


@pytest.mark.parametrize("unit", [1e-150, 1e12])
def test_any_unit(unit):
    vertices, faces = zoo.random_hull(12, 1)
    small, given = unfold(solid(vertices * unit, faces)), unfold(solid(vertices, faces))
    assert small.sides == given.sides
    assert small.sheets[0] / unit == pytest.approx(given.sheets[0], rel=1e-9, abs=1e-12)
    assert small.net.deficits == pytest.approx(given.net.deficits, abs=1e-9)


@pytest.mark.parametrize("gap", [1e-6, 1e-9])
def test_vertices_next_to_each_other(gap):
    vertices, _ = zoo.random_hull(40, 3)
    vertices = vertices / np.linalg.norm(vertices, axis=1)[:, None]
    near = vertices[:8] + gap * np.random.default_rng(0).normal(size=(8, 3))
    surface = solid(*zoo.outward_hull(np.vstack([vertices, near / np.linalg.norm(near, axis=1)[:, None]])))
    unfolding = unfold(surface)
    assert len(unfolding.sheets) == 1
    check_again(unfolding, surface)


def test_the_same_every_time():
    surface = solid(*zoo.random_hull(30, 2))
    one, other = unfold(surface), unfold(surface)
    assert all((a == b).all() for a, b in zip(one.sheets, other.sheets, strict=True))


def test_a_surface_that_is_not_convex():
    surface = solid(*triangulate(BentTube(), 150))
    unfolding = unfold(surface)
    assert min(map(np.min, unfolding.angles)) < 0
    check_sheets(unfolding, surface)
    check_deficits(unfolding, surface)


def crumpled():
    vertices, faces = zoo.icosphere(1)
    return solid(vertices * np.exp(np.random.default_rng(0).normal(size=(len(vertices), 1))), faces)


def test_where_no_direction_helps_sides_are_exchanged(monkeypatch):
    surface = crumpled()
    with monkeypatch.context() as without:
        without.setattr("isoembed.gluing.sheet_search.EXCHANGES", 0)
        before = unfold(surface)
    check_sheets(before, surface)
    check_deficits(before, surface)
    after = unfold(surface)
    check_sheets(after, surface)
    check_deficits(after, surface)
    assert len(before.sheets) > len(after.sheets) == 1


def spiked(flat, spike):
    """A unit cube with these triangles on top, over its corners 0 to 3, and with a spike."""
    points = [[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1], [0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    points += [[0.5, 0.4, 1.5], [0.7, 0.3, 1], [0.5, 0.6, 1], [0.3, 0.3, 1]]
    walls = [(k, 4 + k, 4 + (k + 1) % 4) for k in range(4)]
    walls += [(k, 4 + (k + 1) % 4, (k + 1) % 4) for k in range(4)]
    faces = np.array([*walls, (4, 7, 6), (4, 6, 5), *flat, *spike])
    return solid(np.array(points, dtype=float)[: faces.max() + 1], faces)


HOLE = [(0, 1, 9), (0, 9, 11), (1, 2, 9), (2, 10, 9), (2, 3, 10), (3, 0, 11), (3, 11, 10)]
PINCH = [(0, 1, 9), (1, 2, 9), (2, 10, 9), (2, 3, 10), (3, 0, 10)]


@pytest.mark.parametrize(("flat", "base"), [(HOLE, 11), (PINCH, 0)])
def test_faces_with_a_hole_and_with_a_pinch_are_cut(flat, base):
    surface = spiked(flat, [(base, 9, 8), (9, 10, 8), (10, base, 8)])
    unfolding = unfold(surface)
    check_sheets(unfolding, surface)
    check_deficits(unfolding, surface)
    assert sum(map(len, unfolding.folds)) <= 9 + 6 - 1  # no fold where it is flat
    assert np.abs(np.concatenate(unfolding.angles)).min() > 0.1


def prism(n):
    angles = 2 * np.pi * np.arange(n) / n
    base = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(n)])
    return np.vstack([base, base + np.array([0, 0, 1])])


@pytest.mark.parametrize("decimals", [3, 4, 5, 6])
@pytest.mark.parametrize("name", ["cube", "dodecahedron", 3, 5, 6, 30])
def test_faces_of_rounded_solids_stay_whole(name, decimals, tmp_path):
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    vertices = (prism(name) if isinstance(name, int) else solids.uniform(name)) @ turn
    polygons = solids.polygons(vertices)
    unfolding = unfold(solid(vertices.round(decimals), solids.triangles(polygons)))
    assert len(unfolding.sheets) == 1
    assert len(unfolding.folds[0]) == len(polygons) - 1
    assert unfolding.net.n_vertices == len(vertices)
    unfolding.save(tmp_path / "net.json")
    assert isoembed.glue(tmp_path / "net.json").folded is not None


def test_a_sliver_along_an_edge():
    vertices, faces = zoo.tetrahedron()
    a, b, c = faces[0]
    up = np.cross(*(vertices[[b, c]] - vertices[a]))
    middle = (vertices[a] + vertices[b]) / 2 + 2.4e-8 * up * (8**0.5 / np.linalg.norm(up))
    beside = np.vstack([faces[1:], [[a, b, 4], [4, b, c], [a, 4, c]]])
    surface = solid(np.vstack([vertices, middle]), beside)
    unfolding = unfold(surface)
    assert set(np.concatenate(unfolding.corners).tolist()) == set(range(5))
    check_sheets(unfolding, surface)
    assert unfolding.net.n_vertices == 5


def test_a_face_without_area_is_refused():
    vertices, faces = zoo.tetrahedron()
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    flat = Embedding(metric, vertices * [1, 0, 0], method="given", tolerance=1e-10)
    with pytest.raises(InvalidMetric, match=r"face 0 \[\d, \d, \d\] is too thin to define a plane"):
        unfold(flat)


@pytest.mark.parametrize("thin", [1e-16, 3e-17, 1e-40])
def test_sides_that_rounding_hides_are_refused(thin):
    points, faces = zoo.cube()
    with pytest.raises(InvalidMetric, match=r"vertex . is too near to another to be distinguished"):
        unfold(solid(points * [1.0, thin, thin], faces))


def test_walls_as_low_as_rounding_belong_to_the_faces_beside_them():
    points, faces = zoo.cube()
    unfolding = unfold(solid(points * [1.0, 1.0, 3e-17], faces))
    assert sorted(map(len, unfolding.sheets)) == [6]
    assert sum(map(shoelace, unfolding.sheets)) == pytest.approx(2)
