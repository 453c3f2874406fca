"""Pairs of realizations of one metric, and batches by several processes."""

import pytest

from isoembed import PolyhedralMetric
from isoembed.gallery import triangulate
from reproduction import equivalent
from sections import check_section


@pytest.mark.slow
def test_pairs_are_proven_to_be_two_and_their_integrals_differ_little():
    metric = PolyhedralMetric.from_mesh(*triangulate(equivalent.SURFACES["saddle"], 100, irregular=2))
    pairs = equivalent.of_metric("saddle", metric)
    assert len(pairs) > 1
    for pair in pairs:
        assert pair.proven
        assert 0 < pair.angle_error < 1e-9 < pair.angle < 6 * pair.distance
        assert pair.mean_curvature_error < abs(pair.mean_curvature) < 0.05 * pair.distance**3


@pytest.mark.slow
def test_the_section(monkeypatch):
    monkeypatch.setattr(equivalent, "SURFACES", {"saddle": equivalent.SURFACES["saddle"]})
    section = equivalent.study(sizes=(100,), seeds=(2,), parallel=60, batch=3)
    check_section(section)
    assert section.numbers["seconds"]["same"] == "the same to the last bit"
    assert all(pair["proven"] for pair in section.numbers["pairs"])
