"""The local search: patches that stand on the wrong side are turned over, and coarse stars are found."""

import numpy as np
import pytest

import isoembed
import smooth_bodies
import zoo
from isoembed.aim.adaptive import Aim
from isoembed.aim.local_search import local_search, misses_locally
from isoembed.aim.regularized_energy import RegularizedEnergy
from isoembed.errors import InvalidParameter, NotEmbedded
from isoembed.gallery import HarmonicSurface, triangulate
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.surface.measures import edge_lengths
from isoembed.surface.rigidity import LengthSystem


@pytest.fixture(scope="module")
def saddle():
    vertices, faces = triangulate(HarmonicSurface(2, 2, 0.3), 300)
    metric = PolyhedralMetric.from_mesh(vertices, faces).normalized
    return metric, vertices * (metric.mean_length / edge_lengths(metric.edges, vertices).mean())


def system(metric, recorder):
    return LengthSystem(metric.triangulation, work=recorder.work)


def disk(metric, center, rings):
    inside = np.array([center])
    for _ in range(rings):
        inside = np.unique(np.concatenate([inside, metric.triangulation.adjacency[inside].indices]))
    return inside


def reflected(metric, vertices, inside):
    """The disk reflected in the plane of its rim."""
    rim = vertices[np.setdiff1d(metric.triangulation.adjacency[inside].indices, inside)]
    normal = np.linalg.svd(rim - rim.mean(axis=0))[2][-1]
    moved = vertices.copy()
    moved[inside] -= 2 * np.outer((vertices[inside] - rim.mean(axis=0)) @ normal, normal)
    return moved


@pytest.mark.parametrize(("center", "rings"), [(0, 1), (150, 2)])
def test_a_patch_on_the_wrong_side_is_turned_back(saddle, center, rings):
    (metric, true), recorder = saddle, smooth_bodies.recorder()
    wrong = reflected(metric, true, disk(metric, center, rings))
    energy = RegularizedEnergy(metric, true, recorder.work)
    found = local_search(energy, system(metric, recorder), wrong, metric.lengths, recorder, 200.0).end
    assert np.abs(energy.residuals(wrong, metric.lengths)).max() > 1e-3
    assert np.abs(energy.residuals(found, metric.lengths)).max() < 1e-6 * metric.mean_length
    assert recorder.factorizations < 200


def test_what_misses_least_is_kept_though_the_search_goes_on(saddle):
    (metric, true), recorder = saddle, smooth_bodies.recorder()
    errors = np.random.default_rng(0).standard_normal(len(metric.lengths))
    lengths = metric.lengths * (1 + 0.003 * errors)
    energy = RegularizedEnergy(metric, true, recorder.work)
    found = local_search(energy, system(metric, recorder), true, lengths, recorder, 60.0)

    def missed(x):
        return np.abs(energy.residuals(x, lengths)).max()

    assert missed(found.nearest) < min(missed(found.end), missed(true))


def test_what_it_may_cost(saddle):
    (metric, true), recorder = saddle, smooth_bodies.recorder()
    wrong = reflected(metric, true, disk(metric, 150, 3))
    energy = RegularizedEnergy(metric, true, recorder.work)
    local_search(energy, system(metric, recorder), wrong, metric.lengths, recorder, 0.0)
    assert 0 < recorder.factorizations <= 10  # a step of either relaxation, and no disk


def star(seed, n, amount):
    """Lengths of a star-shaped body, each vertex at a random distance."""
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(n, 3))
    vertices, faces = zoo.outward_hull(points / np.linalg.norm(points, axis=1)[:, None])
    return PolyhedralMetric.from_mesh(vertices * np.exp(amount * rng.normal(size=(n, 1))), faces)


def test_a_coarse_star_that_the_pull_back_does_not_find():
    metric = star(0, 40, 0.1)
    with pytest.raises(NotEmbedded) as caught:
        isoembed.embed(metric, method=Aim(effort=0))
    assert caught.value.embedding.residual > 1e-4
    assert "local search" not in [stage.name for stage in caught.value.embedding.stages]
    found = isoembed.embed(metric)
    assert np.abs(edge_lengths(metric.edges, found.vertices) - metric.lengths).max() < 1e-12
    again = isoembed.embed(metric)
    assert (again.vertices == found.vertices).all()


def test_an_interruption_does_not_change_what_the_search_may_cost():
    metric, checkpoints = star(0, 40, 0.1), {}
    found = isoembed.embed(
        metric, progress=lambda snapshot: checkpoints.setdefault(id(snapshot.checkpoint), snapshot.checkpoint)
    )
    kept = [checkpoint for checkpoint in checkpoints.values() if checkpoint is not None]
    assert {"newton on lengths", "guided path", "local search"} <= {checkpoint.key for checkpoint in kept}
    for checkpoint in kept[1 :: max(1, len(kept) // 2)]:
        again = isoembed.embed(metric, resume=checkpoint)
        assert (again.vertices == found.vertices).all()


def noisy_saddle():
    """Lengths without a smooth surface."""
    metric = PolyhedralMetric.from_mesh(*triangulate(HarmonicSurface(2, 2, 0.3), 100))
    errors = np.random.default_rng(0).standard_normal(metric.triangulation.n_edges)
    return metric.with_lengths(metric.lengths * (1 + 0.03 * errors))


@pytest.mark.parametrize("effort", [0.0, 1.0])
def test_a_failure_costs_as_much_as_the_effort_says(effort):
    with pytest.raises(NotEmbedded) as caught:
        isoembed.embed(noisy_saddle(), method=Aim(effort=effort))
    stages = caught.value.embedding.stages
    after = sum(stage.factorizations for stage in stages if stage.name in {"local search", "best fit"})
    first = sum(stage.factorizations for stage in stages) - after
    assert after <= (1 + effort) * first


@pytest.mark.parametrize("effort", [-1.0, np.inf, np.nan])
def test_no_effort(effort):
    with pytest.raises(InvalidParameter, match="not a finite number of at least 0"):
        Aim(effort=effort)


def test_noise_is_missed_everywhere_and_a_patch_where_it_is():
    vertices, faces = zoo.icosphere(4)  # 7,680 edges, of which the disks of a sweep have fewer than half
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    energy = RegularizedEnergy(metric, vertices)
    pushed = vertices.copy()
    pushed[100] *= 0.9
    assert misses_locally(energy, pushed, metric.lengths)
    noise = 1e-3 * np.random.default_rng(0).uniform(-1, 1, len(metric.lengths))
    assert not misses_locally(energy, vertices, metric.lengths + noise)
