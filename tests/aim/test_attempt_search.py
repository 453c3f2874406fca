"""Realizations near an attempt that misses its lengths by little."""

import numpy as np
import pytest

import isoembed
import smooth_bodies
from isoembed import Aim, NotEmbedded, PolyhedralMetric
from isoembed.aim import realization_search
from isoembed.aim.attempt_search import realization_near
from isoembed.aim.realization_leads import Leads
from isoembed.gallery import Ellipsoid, triangulate
from isoembed.progress.stages import Log
from isoembed.surface.alignment import distance
from isoembed.surface.rigidity import LengthSystem


def test_the_first_realization_is_enough():
    metric, vertices, missed = smooth_bodies.attempt_with_noise()
    with Log().stage("realizations") as recorder:
        found = realization_near(metric, LengthSystem(metric.triangulation), missed, recorder, 500)
    assert distance(found, vertices) < 1e-9
    assert 0 < recorder.factorizations < 100


def test_no_lead_is_sought_once_all_is_spent(monkeypatch):
    metric, _, missed = smooth_bodies.attempt_with_noise()
    # Flat, so that nothing is near.
    sought, system, flat = [], LengthSystem(metric.triangulation), missed * [1.0, 1.0, 0.3]
    monkeypatch.setattr(realization_search, "leads", lambda *_: sought.append(None) or Leads([], 0))
    for most in (1, 500):
        with Log().stage("realizations") as recorder:
            assert realization_near(metric, system, flat, recorder, most) is None
        assert len(sought) == (0 if most == 1 else 4)


def test_large_surfaces_are_not_searched_about():
    vertices, faces = triangulate(Ellipsoid((3, 2, 1)), 1001)
    metric = PolyhedralMetric.from_mesh(vertices, faces).normalized
    with Log().stage("realizations") as recorder:
        system = LengthSystem(metric.triangulation)
        assert realization_near(metric, system, vertices, recorder, 500) is None
    assert recorder.factorizations == 0


@pytest.mark.slow
def test_a_bumpy_body_that_only_a_longer_search_finds():
    x, faces = triangulate(Ellipsoid((1, 1, 1)), 400, irregular=3)
    rng = np.random.default_rng(10)
    bumps = sum(np.cos(x @ (3 * rng.normal(size=3)) + rng.uniform(0, 6.3)) for _ in range(6))
    vertices = x * (1 + rng.uniform(0.03, 0.08) * bumps)[:, None]
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    with pytest.raises(NotEmbedded, match="--effort 10"):
        isoembed.embed(metric)
    found = isoembed.embed(metric, method=Aim(effort=10))
    assert found.residual < 1e-11
    assert min(distance(each.vertices, vertices) for each in (found, *found.others)) < 1e-9
    assert "realizations" in [stage.name for stage in found.stages]
