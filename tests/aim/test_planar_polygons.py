"""Polygons of a mesh as information on which of its realizations is meant."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from isoembed import Embedding, InvalidMetric, PolyhedralMetric, certify, embed
from isoembed.aim.polygon_planarity import PolygonPlanarity, has_planar_polygons
from isoembed.io import read_metric, write_metric

# Coordinates of the corners of polygons, of cubes of side 3.
NOTCHED_EDGE = """
000 030 330 300, 000 300 303 203 202 102 103 003, 030 033 333 330, 000 003 033 030, 300 330 333 303,
003 103 113 213 203 303 333 033, 102 202 212 112, 102 112 113 103, 202 203 213 212, 112 212 213 113
"""
NOTCHED_CORNER = """
000 030 330 300, 000 300 303 003, 000 003 033 030, 003 303 323 123 133 033, 300 330 332 322 323 303,
030 033 133 132 332 330, 122 132 133 123, 122 123 323 322, 122 322 332 132
"""
THREE_NOTCHES = """
000 030 330 300, 000 300 303 103 101 001, 001 101 111 011, 011 111 113 013, 101 103 113 111,
030 033 133 132 332 330, 122 132 133 123, 122 123 323 322, 122 322 332 132, 000 001 011 013 033 030,
103 303 323 123 133 033 013 113, 300 330 332 322 323 303
"""


def solid(text):
    """Vertices and faces of a solid whose polygons are given by points."""
    numbers = {}
    faces = [
        [numbers.setdefault(point, len(numbers)) for point in polygon.split()] for polygon in text.split(",")
    ]
    return np.array([[*map(float, point)] for point in numbers]), faces


@pytest.mark.parametrize(
    ("text", "volume"), [(NOTCHED_EDGE, 26), (NOTCHED_CORNER, 25), (THREE_NOTCHES, 25 - 2)]
)
def test_notched_cubes_are_found_with_planar_polygons(text, volume):
    vertices, faces = solid(text)
    found = embed(PolyhedralMetric.from_mesh(vertices, faces))
    assert found.converged and has_planar_polygons(found)
    assert found.volume == pytest.approx(volume, rel=1e-10)


@pytest.mark.parametrize("text", [NOTCHED_EDGE, NOTCHED_CORNER])
def test_polygons_of_rounded_coordinates_are_planar_within_the_digits(text):
    vertices, faces = solid(text)
    turned = Rotation.from_rotvec([0.3, 0.5, 0.7]).apply(vertices * [1, 1.1, 1.23])
    metric = PolyhedralMetric.from_mesh(np.round(turned, 6), faces)
    found = embed(metric)
    assert found.converged and has_planar_polygons(found)
    given = Embedding(metric, turned, method="given", tolerance=1e-5)
    assert found.distance(given) < 1e-5


def test_short_diagonals_of_large_polygons_are_as_planar_as_these():
    """A prism over an hourglass, off by less than the planarity of a mesh: no rounding explains that."""
    outline = np.array([[-1, -1], [1, -1], [0.01, 0], [1, 1], [-1, 1], [-0.01, 0]])
    vertices = np.vstack([np.column_stack([outline, np.full(6, z)]) for z in (-1.0, 1.0)])
    faces = [
        [5, 4, 3, 2, 1, 0],
        [6, 7, 8, 9, 10, 11],
        *([i, (i + 1) % 6, (i + 1) % 6 + 6, i + 6] for i in range(6)),
    ]
    bent = vertices + 3e-6 * np.random.default_rng(0).uniform(-1, 1, vertices.shape)
    metric = PolyhedralMetric.from_mesh(bent, faces)
    assert metric.precision is None and len(metric.diagonals) == 12
    assert PolygonPlanarity.of(metric).holds(bent)
    bent[0] += [0, 0, 1e-3]
    assert not PolygonPlanarity.of(metric).holds(bent)


def test_the_distance_from_planarity_is_that_of_the_diagonals():
    h = 0.1
    square = [[0, 0, h], [1, 0, 0], [1, 1, h], [0, 1, 0]]  # its diagonals are h apart
    apex = [0.5, 0.5, -1]
    faces = [[0, 1, 2, 3], *([b, a, 4] for a, b in ((0, 1), (1, 2), (2, 3), (3, 0)))]
    flat = np.array([*square, apex])
    flat[:, 2] = [0, 0, 0, 0, -1]
    metric = PolyhedralMetric.from_mesh(flat, faces)
    planarity = PolygonPlanarity.of(metric)
    np.testing.assert_allclose(planarity.offsets(flat), 0, atol=1e-15)
    offsets = planarity.offsets(np.array([*square, apex]))
    np.testing.assert_allclose(np.abs(offsets), [[0, 0, h]], atol=1e-15)
    with pytest.warns(match="not planar"):
        assert PolyhedralMetric.from_mesh([*square, apex], faces).diagonals.size == 0


def test_diagonals_stay_with_the_metric(tmp_path):
    vertices, faces = solid(NOTCHED_EDGE)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    assert len(metric.diagonals) == sum(len(face) - 3 for face in faces)
    for changed in (metric.scaled(2.0), metric.normalized, metric.with_length_errors(1e-3)):
        np.testing.assert_array_equal(changed.diagonals, metric.diagonals)
    assert metric.with_lengths(metric.lengths).diagonals.size == 0
    lines = ["v 9 9 9", *("v {} {} {}".format(*v) for v in vertices)]  # a vertex in no face is left out
    lines += ["f " + " ".join(str(v + 2) for v in face) for face in faces]
    (tmp_path / "solid.obj").write_text("\n".join(lines))
    with pytest.warns(match="in no face"):
        read = read_metric(tmp_path / "solid.obj")
    np.testing.assert_array_equal(read.edges[read.diagonals], metric.edges[metric.diagonals])


@pytest.mark.parametrize("ending", ["npz", "json"])
def test_diagonals_stay_with_a_metric_in_a_file(ending, tmp_path):
    metric = PolyhedralMetric.from_mesh(*solid(NOTCHED_EDGE))
    write_metric(tmp_path / f"metric.{ending}", metric)
    read = read_metric(tmp_path / f"metric.{ending}")
    np.testing.assert_array_equal(read.diagonals, metric.diagonals)
    assert embed(read).volume == pytest.approx(26, rel=1e-10)
    with pytest.raises(InvalidMetric, match=r"diagonal 1 \[0, 12\] is not an edge"):
        metric.with_diagonals(np.array([metric.edges[metric.diagonals[0]], [0, 12]]))
    with pytest.raises(InvalidMetric, match=r"the diagonals have the shape \(3,\), not \(D, 2\)"):
        metric.with_diagonals(np.arange(3))


def test_fits_that_equal_the_exact_surface_do_not_replace_it():
    """Which of the two was smoother, and returned, was a matter of rounding."""
    vertices, faces = solid(
        "000 030 330 300, 000 300 303 003, 000 003 033 030, 333 303 300 330, 333 330 030 033, 333 033 003 303"
    )
    for turn in Rotation.random(10, random_state=0):
        found = embed(PolyhedralMetric.from_mesh(np.round(turn.apply(vertices), 6), faces))
        assert found.length_errors is None
        assert certify(found).certified
