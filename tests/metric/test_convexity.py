"""What is refused as not convex, and what of it may be noise."""

import numpy as np
import pytest

from curved import body
from isoembed.errors import InvalidMetric
from isoembed.metric.convexity import (
    ROUNDINGS,
    check_convex,
    deficit_rounding,
    deficit_spread,
    noise_level,
    repair_level,
)
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.metric.variation import deficit_derivative


def refusal(deficits):
    with pytest.raises(InvalidMetric) as refused:
        check_convex(np.array(deficits), 1e-12)
    return str(refused.value)


def test_the_refusal_names_the_worst_vertex():
    corners = [1.5] * 8
    assert refusal([*corners, -1.04e-7, 2.31e-7, -3e-9]) == (
        "vertex 8 has total angle 6.283185411 > 2 pi (deficit -1.04e-07), and 1 other vertex has more than "
        "2 pi: the metric is not convex, and no convex polyhedron has it"
    )


@pytest.mark.parametrize(
    ("deficits", "level"),
    [
        ([2.0, 1.0, 3e-6, -1e-6], 3e-6),
        ([2.0, 1.0, 3e-6, 1e-6], 0.0),  # none is negative: nothing shows noise
        ([2.0, 1.0, 3e-5, -1e-6], 1e-6),  # a positive one of thirty times the size is no noise
        ([2.0, 1.0, 3e-6, -1e-3], 1e-3),  # not below a negative one
        ([0.05, 0.04, 0.01, 0.02, -0.003], 0.003),  # no gap: a smooth body
        ([0.05, 0.04, 0.01, 0.02, 0.003], 0.0),
        ([2.0, 1.0, 0.0, 1e-15], 0.0),
    ],
)
def test_noise_ends_at_a_gap(deficits, level):
    assert noise_level(np.array(deficits)) == level


def test_the_repair_of_small_deficits():
    deficits = np.array([2.0, 3.0, 4.0, 3e-8, -1e-8, 1e-13])
    assert repair_level(deficits, 1e-12) == 3e-8
    assert repair_level(deficits, 1e-7) is None
    assert repair_level(np.array([2.0, 1.0, 0.5]), 1e-12) is None
    assert repair_level(np.array([2.0, 1.0, -0.5]), 1e-12) is None  # that is no noise


@pytest.mark.parametrize("k", [0.0, -1.0, 0.7])
def test_errors_of_lengths_move_deficits(k):
    x, faces, _ = body(30, 0, k or -1e-9, 2.4)
    metric = PolyhedralMetric.from_mesh(x, faces, curvature=k)
    tables = metric.faces, metric.face_lengths
    D = deficit_derivative(metric).toarray()
    spread = deficit_spread(*tables, metric.triangulation.twins, k)
    assert spread == pytest.approx(np.sqrt((D**2).sum(axis=1)) * metric.mean_length, rel=1e-10)
    upper = metric.faces[x[metric.faces].mean(axis=1)[:, 2] > 0.2 * x[:, 2].max()]
    cap = PolyhedralMetric.from_mesh(
        x[np.unique(upper)], np.unique(upper, return_inverse=True)[1].reshape(-1, 3), curvature=k
    )
    open_spread = deficit_spread(cap.faces, cap.face_lengths, cap.triangulation.sides_across, k)
    changes = deficit_derivative(cap).toarray()
    assert not cap.triangulation.is_closed
    assert open_spread == pytest.approx(np.sqrt((changes**2).sum(axis=1)) * cap.mean_length, rel=1e-10)
    most = np.abs(D) @ metric.lengths * ROUNDINGS * np.finfo(np.float64).eps
    assert (deficit_rounding(metric) > 0.2 * most).all()
