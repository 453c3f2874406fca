"""Horizons at their places: centers, sides, and an orientation that does not jump."""

import numpy as np
import pytest

from isoembed.plot.series.placing import PlacedHorizons
from series_results import embedded, missing

AXES = (1.0, 1.2, 1.5)


def rotation(seed):
    turned, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    return turned * np.linalg.det(turned)


def test_without_coordinates_each_surface_is_turned_onto_the_one_before():
    """Also where the meshes differ, and over one that is missing."""
    results = [
        embedded("ah1", k, k, half_axes=AXES, turned=rotation(k), level=1 + k % 2) for k in (0, 1, 3, 4)
    ]
    placed = PlacedHorizons.of([*results[::-1], missing("ah1", 2, 2.0, "failed", "killed")])
    first = placed.horizons["ah1.t0"]
    assert np.allclose(first.vertices - first.center, results[0].arrays["vertices"])
    for label, other in (("ah1.t3", "ah1.t1"), ("ah1.t4", "ah1.t0")):
        vertices = placed.horizons[label].vertices
        assert np.allclose(vertices, placed.horizons[other].vertices, atol=1e-12)
    assert set(placed.horizons) == {result.label for result in results}


def test_the_axis_of_the_spin_is_turned_with_the_surface():
    turned = rotation(5)
    pair = [embedded("ah1", 0, 0, half_axes=AXES), embedded("ah1", 1, 1, half_axes=AXES, turned=turned)]
    second = PlacedHorizons.of(pair).horizons["ah1.t1"]
    assert np.allclose(second.axis, np.array([0.6, 0.0, 0.8]) @ turned)


def test_with_coordinates_a_surface_stays_as_it_lies_in_its_slice():
    results = [
        embedded("ah1", k, k, half_axes=AXES, turned=rotation(k), center=(0.0, 0.0, 0.0)) for k in range(3)
    ]
    placed = PlacedHorizons.of(results)
    for result in results:
        assert np.array_equal(placed.horizons[result.label].vertices, result.arrays["vertices"])


def test_centers_are_as_far_apart_as_the_surfaces_are_larger_than_in_coordinates():
    results = [embedded("ah1", 0, 0, center=(1, 0, 0)), embedded("ah2", 0, 0, center=(0, -2, 0))]
    placed = PlacedHorizons.of(results)
    ratio = np.sqrt(12.5 / (4 * np.pi)) / 0.5  # area and mean radius in coordinates
    assert placed.stretch == pytest.approx(ratio)
    centers = np.array([horizon.center for horizon in placed.horizons.values()])
    assert np.allclose(centers, ratio * np.array([[1, 0, 0], [0, -2, 0]]))


def test_series_without_centers_stand_side_by_side():
    placed = PlacedHorizons.of([embedded(name, 0, 0) for name in ("ah1", "ah2", "ah3")])
    one, two, three = (horizon.vertices[:, 0] for horizon in placed.horizons.values())
    assert one.max() < two.min()
    assert two.max() < three.min()


def test_a_common_horizon_holds_the_others():
    here, there = embedded("ah1", 0, 0, center=(0.4, 0, 0)), embedded("ah2", 0, 0, center=(0, 2.5, 0))
    common = embedded("ah3", 0, 0, center=(0, 0, 0), half_axes=(3, 3, 3))
    one, two, three = PlacedHorizons.of([here, there, common]).horizons.values()
    assert three.holds(one)
    assert not three.holds(two)
    assert not one.holds(three)


def test_only_the_fields_that_are_asked_for_are_kept():
    result = embedded("ah1", 0, 0, center=(0, 0, 0))
    placed = PlacedHorizons.of([result], ["mean_curvature"])
    assert set(placed.horizons["ah1.t0"].fields) == {"mean_curvature", "slice_coordinates"}
