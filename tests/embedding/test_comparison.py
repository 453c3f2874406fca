"""Comparisons of two surfaces with the same lengths, against closed forms and against each other."""

import numpy as np
import pytest

import isoembed
import zoo
from isoembed.errors import InvalidParameter
from isoembed.gallery import CassiniPeanut, Ellipsoid, triangulate
from isoembed.surface.alignment import best_rotation
from noisy import ARRAYS, SCALARS, surface
from two_realizations import cap_outside_and_inside

H = 0.5


@pytest.fixture(scope="module")
def pair():
    """Two realizations of the same lengths: with the cap outside and inside."""
    return cap_outside_and_inside(H)


def rotated(x, seed):
    rng = np.random.default_rng(seed)
    q = best_rotation(rng.standard_normal((3, 3)), rng.standard_normal((3, 3)))
    return x @ q + rng.standard_normal(3)


def test_cap_outside_and_inside(pair):
    found = isoembed.compare(pair[0], pair[1])
    x = pair[0].vertices
    base = np.linalg.norm(np.cross(x[1] - x[0], x[2] - x[0])) / 2
    assert (found.certified, found.same) == (True, False)
    assert abs(found.difference.volume + 2 * base * H / 3) <= found.error.volume < 1e-11
    assert (found.difference.area, found.error.area) == (0, 0)
    assert np.allclose(found.difference.vertices, 2 * H * np.array([0.2, 0.2, 0.2, 0.2, 0.8]), atol=1e-12)
    # The edges of the face under the cap turn by twice the angle of its sides with that face.
    inradius = np.linalg.norm(x[0] - x[1]) / np.sqrt(12)
    tilt = np.arctan2(H, inradius)
    sides = np.sort(np.abs(found.difference.dihedral_angles))
    assert np.allclose(sides[:3], 0, atol=1e-14)
    assert np.isclose(sides[3:], 2 * tilt, atol=1e-13).sum() == 3
    assert found.reason.startswith("proven to be two exact surfaces with these lengths, ")
    assert found.reason.endswith("; the first is the smoother")
    assert found.distance > found.isolation > 1e9 * found.distance_error


def test_the_other_way_round(pair):
    one, other = isoembed.compare(pair[0], pair[1]), isoembed.compare(pair[1], pair[0])
    for name in ("dihedral_angles", "mean_curvature", "volume", "integrated_mean_curvature"):
        assert np.allclose(getattr(one.difference, name), -getattr(other.difference, name), rtol=1e-12)
    assert np.isclose(one.distance, other.distance, rtol=1e-12)
    assert one.fine_roughness == other.fine_roughness[::-1]
    assert one.distance == pair[0].distance(pair[1])


def test_a_moved_one_is_the_same():
    found = surface(CassiniPeanut(), 100)
    moved = isoembed.Embedding(found.metric, rotated(found.vertices, 3), method="given", tolerance=1e-10)
    same = isoembed.compare(found, moved)
    assert (same.certified, same.same) == (True, True)
    assert same.reason == "proven to be the same exact surface"
    for name in (*ARRAYS, *SCALARS):
        assert np.all(np.abs(getattr(same.difference, name)) <= getattr(same.error, name)), name
        assert np.max(getattr(same.error, name)) < 1e-10


def test_two_approximations_of_one_surface_differ_by_less_than_the_errors():
    found = surface(Ellipsoid((3.0, 2.0, 1.0)), 60)
    rng = np.random.default_rng(1)
    shake = 1e-9 * found.metric.mean_length
    blurred = [
        isoembed.Embedding(
            found.metric,
            rotated(found.vertices + shake * rng.uniform(-1, 1, found.vertices.shape), k),
            method="given",
            tolerance=1e-8,
        )
        for k in range(2)
    ]
    rough = isoembed.compare(blurred[0], blurred[1])
    assert rough.certified and rough.same is True
    for name in (*ARRAYS, *SCALARS):
        assert np.all(np.abs(getattr(rough.difference, name)) <= getattr(rough.error, name)), name
    assert 0.01 * rough.distance_error < rough.distance < rough.distance_error


@pytest.mark.parametrize("unit", (1e-90, 1e40))
def test_unit(pair, unit):
    one, other = (
        isoembed.Embedding(p.metric.scaled(unit), unit * p.vertices, method="given", tolerance=1e-10)
        for p in pair
    )
    found, scaled = isoembed.compare(pair[0], pair[1]), isoembed.compare(one, other)
    powers = {"vertices": 1, "normals": 0, "dihedral_angles": 0, "mean_curvature": -1}
    for name, power in (powers | {"volume": 3, "integrated_mean_curvature": 1}).items():
        expected = getattr(found.difference, name)
        assert np.allclose(getattr(scaled.difference, name) / unit**power, expected, atol=1e-12), name
    assert np.isclose(scaled.distance, found.distance) and scaled.same is False


def test_what_is_not_proven(pair):
    first = pair[0]
    other = isoembed.Embedding(first.metric, 1.1 * first.vertices, method="given", tolerance=1e-10)
    found = isoembed.compare(first, other)
    assert (found.certified, found.same, found.isolation) == (False, None, None)
    assert "because the second is not certified, because the lengths miss the tolerance" in found.reason
    assert np.isclose(found.difference.volume, (1.1**3 - 1) * first.volume)
    assert np.isinf(found.error.volume) and np.isinf(found.distance_error)
    lengths = first.metric.lengths.copy()
    lengths[4] *= 1 + 1e-12
    longer = isoembed.Embedding(
        first.metric.with_lengths(lengths), first.vertices, method="given", tolerance=1e-10
    )
    found = isoembed.compare(first, longer)
    assert not found.certified and f"edge 4 {first.metric.edges[4].tolist()} has the length" in found.reason


def test_what_is_refused(pair):
    x, faces = zoo.icosahedron()
    other = isoembed.Embedding(
        isoembed.PolyhedralMetric.from_mesh(x, faces), x, method="given", tolerance=1e-10
    )
    with pytest.raises(
        InvalidParameter, match=r"an array, not an embedding: embedding\.distance\(vertices\)"
    ):
        isoembed.compare(pair[0], pair[0].vertices)
    with pytest.raises(InvalidParameter, match="the same triangles"):
        isoembed.compare(pair[0], other)
    x, faces = triangulate(Ellipsoid((3.0, 2.0, 1.0)), 60)
    curved = isoembed.PolyhedralMetric.from_mesh(x / 9, faces, curvature=-1)
    bent = isoembed.Embedding(curved, x / 9, method="given", tolerance=1e-10)
    with pytest.raises(InvalidParameter, match="comparisons need surfaces in R"):
        isoembed.compare(bent, bent)
