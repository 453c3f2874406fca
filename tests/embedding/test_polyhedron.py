"""The true faces of solids whose coordinates or lengths are rounded."""

import numpy as np
import pytest

import solids
from isoembed import Alexandrov, PolyhedralMetric, embed, unfold
from isoembed.io.surface import read_surface
from isoembed.struts import strut_table
from johnson_solids import johnson


def rounded_cube(n: int, seed: int) -> PolyhedralMetric:
    """A turned cube, n x n squares of two triangles a side, with vertices in single precision."""
    steps = [np.array([x, y]) for x in range(n) for y in range(n)]
    corners = np.array([[[0, 0], [1, 0], [1, 1]], [[0, 0], [1, 1], [0, 1]]])
    flat = np.concatenate([corners + step for step in steps])
    sides = []
    for axis in range(3):
        for level, order in ((0, [0, 2, 1]), (n, [0, 1, 2])):
            points = np.full((*flat.shape[:2], 3), level)
            points[..., (axis + 1) % 3], points[..., (axis + 2) % 3] = flat[..., 0], flat[..., 1]
            sides.append(points[:, order])
    points, faces = np.unique(np.concatenate(sides).reshape(-1, 3), axis=0, return_inverse=True)
    turn, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    turn *= np.linalg.det(turn)
    return PolyhedralMetric.from_mesh((points @ turn / n + 1).astype(np.float32), faces.reshape(-1, 3))


@pytest.mark.parametrize(("n", "seed"), [(4, 5), (9, 3), (9, 7)])
def test_the_faces_of_a_rounded_cube_cover_it(n, seed):
    cube = embed(rounded_cube(n, seed), method=Alexandrov(repair=1e-4))
    area = 0.0
    for polygon in cube.polygons:
        points = cube.vertices[polygon]
        area += np.linalg.norm(np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)) / 2
    assert area == pytest.approx(cube.area, rel=1e-6)
    assert len(cube.polygons) <= 12  # what was rounded may fold the sides along a diagonal
    assert not cube.surface.concave_edges.any()
    unfolding = unfold(cube)
    assert len(unfolding.sheets) == 1
    assert len(unfolding.sides) <= 30


def rounded_lengths(points, decimals: int) -> PolyhedralMetric:
    """Edges and diagonals of a solid with a mean length of 40, with these decimals."""
    exact = PolyhedralMetric.from_mesh(points, solids.triangles(solids.polygons(points)))
    lengths = np.round(exact.lengths * 40 / exact.mean_length, decimals)
    return PolyhedralMetric(exact.faces, lengths, exact.edges, length_errors=10.0**-decimals / 12**0.5)


@pytest.mark.parametrize("decimals", [1, 4])
@pytest.mark.parametrize(
    "points",
    [solids.uniform("cube"), solids.uniform("truncated dodecahedron"), solids.catalan("icosidodecahedron")]
    + [johnson(k) for k in (9, 54, 57, 74)],
)
def test_faces_are_flat_within_the_digits_of_the_lengths(points, decimals, tmp_path):
    sides = sorted(map(len, solids.polygons(points)))
    found = embed(rounded_lengths(points, decimals), method="alexandrov")
    assert sorted(found.surface.flat_faces.sides.tolist()) == sides
    assert found.surface.vertex_error < 10 * 10.0**-decimals
    found.save(tmp_path / "solid.obj")
    lines = (tmp_path / "solid.obj").read_text().splitlines()
    assert sorted(len(line.split()) - 1 for line in lines if line.startswith("f ")) == sides
    assert len(strut_table(read_surface(tmp_path / "solid.obj")).lengths) == sum(sides) / 2


def test_common_errors_of_equal_lengths_bend_by_no_more_than_the_digits():
    """They add up along a zone of rhombi: bends had up to ten deviations of independent errors."""
    points, rng = solids.catalan("icosidodecahedron"), np.random.default_rng(0)
    polygons = sorted(
        solids.polygons(points), key=lambda polygon: points[polygon].sum(axis=0).round(9).tolist()
    )
    for _ in range(10):
        rhombi = []
        for polygon in polygons:
            a, b, c, d = np.roll(polygon, rng.integers(2) - np.argmin(points[polygon].round(9)[:, 0]))
            rhombi += [[a, b, c], [a, c, d]]
        exact = PolyhedralMetric.from_mesh(points, rhombi)
        lengths = np.round(exact.lengths * 40 / exact.mean_length, 4)
        metric = PolyhedralMetric(exact.faces, lengths, exact.edges, length_errors=1e-4 / 12**0.5)
        assert embed(metric, method="alexandrov").surface.flat_faces.sides.tolist() == [4] * 30


def test_exact_lengths_bend_by_any_angle():
    metric = rounded_lengths(solids.uniform("cube"), 2).with_length_errors(0)
    found = embed(metric, method="alexandrov")
    assert len(found.polygons) == 12 and found.surface.vertex_error == 0


def test_files_of_fits_know_the_errors_of_the_lengths(tmp_path):
    found = embed(rounded_lengths(solids.uniform("dodecahedron"), 2))
    assert found.metric.precision is not None
    found.save(tmp_path / "fit.obj")
    again = read_surface(tmp_path / "fit.obj")
    assert len(strut_table(again).lengths) == 30
    assert sum(map(len, unfold(again).folds)) == 11
