"""What is said of lengths without a surface: the right place, and advice that works."""

import re

import numpy as np
import pytest

import isoembed
import smooth_bodies
import zoo
from isoembed.aim.best_fit import best_fit
from isoembed.aim.diagnosis import diagnosis
from isoembed.aim.regularized_energy import RegularizedEnergy
from isoembed.alexandrov.method import repair_that_succeeds
from isoembed.embedding.fitted import FittedSurface
from isoembed.errors import NotEmbedded
from isoembed.gallery import CassiniPeanut, triangulate
from isoembed.metric.curvature import deficits, negative_deficits
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.progress.stages import Log


def of_body(vertices, faces):
    return PolyhedralMetric.from_mesh(vertices, faces), vertices


def diagnosed(metric, start):
    """The diagnosis where the best fit itself is the nearest attempt."""
    unit, start = metric.normalized, start / metric.unit
    fit = best_fit(unit, RegularizedEnergy(unit, start), start, smooth_bodies.recorder(), np.inf)
    surface = FittedSurface(
        metric,
        metric.unit * fit.vertices,
        noise=fit.noise,
        weight=fit.weight,
        method="aim",
        tolerance=1e-10,
    )
    return diagnosis(surface, surface, 1.0), surface


def test_noise_on_a_convex_body():
    metric, x = of_body(*smooth_bodies.ellipsoid(400))
    rng = np.random.default_rng(0)
    metric = metric.with_lengths(metric.lengths * (1 + 2e-3 * rng.normal(size=len(metric.lengths))))
    text, surface = diagnosed(metric, x)
    e = int(np.argmax(surface.residuals))
    assert f"the nearest misses edge {e} {metric.edges[e].tolist()} by {surface.residual:.1e}" in text
    v = int(np.argmin(deficits(metric)))
    near = metric.edges[(metric.edges == v).any(axis=1)]
    around = np.mean([deficits(metric)[w] for w in near[near != v]])
    assert f"the lowest is {deficits(metric)[v]:.2g} radians at vertex {v}" in text
    assert f"whose neighbors have {around:.2g} on average" in text
    count = int(negative_deficits(metric).sum())
    assert count > 1
    assert f"{count} of 400 deficits are negative" in text
    assert f"up to errors of about {surface.noise:.0e} of the mean edge length" in text
    assert surface.noise == pytest.approx(2e-3, rel=0.35)
    assert "method=Aim(best_fit=True)" in text
    repair = float(re.search(r"method=Alexandrov\(repair=(\S+)\) finds a polyhedron", text)[1])
    assert isoembed.embed(metric, method=isoembed.Alexandrov(repair=repair)).converged


def test_a_wrong_length_is_found():
    metric, x = of_body(*smooth_bodies.ellipsoid(400))
    lengths = metric.lengths.copy()
    lengths[100] *= 1.3
    text, _ = diagnosed(metric.with_lengths(lengths), x)
    v = int(re.search(r"miss them most at the edges of vertex (\d+)", text)[1])
    assert v in metric.edges[100]


@pytest.mark.parametrize(("factor", "change"), [(1.1, "0.02"), (1.3, "0.07"), (1.5, "")])
def test_a_repair_that_changes_lengths_by_much_is_not_advised(factor, change):
    metric, _ = of_body(*smooth_bodies.ellipsoid(400))
    lengths = metric.lengths.copy()
    lengths[100] *= factor
    metric = metric.with_lengths(lengths)
    repair = 1.01 * -deficits(metric).min()
    solid = isoembed.embed(metric, method=isoembed.Alexandrov(repair=repair))
    said = repair_that_succeeds(metric, repair, 1e-10, Log())
    assert bool(said) == bool(change) == (solid.repair.largest_change < 0.1)
    assert f"relative length changes of at most {change}" in said or not change


def test_lengths_of_no_surface():
    metric, x = of_body(*smooth_bodies.ellipsoid(200))
    text, surface = diagnosed(metric.with_lengths(np.ones(len(metric.lengths))), x)
    said = f"No smooth surface was found near them: the best fit misses them by {surface.residual_rms:.0%}"
    assert said in text
    assert "check that each length belongs to its edge" in text
    assert "alexandrov" not in text


def test_negative_curvature_over_a_region_is_told_from_noise():
    metric, x = of_body(*triangulate(CassiniPeanut(), 400))
    a, b = metric.edges.T
    # Narrower at the waist than meridians of this length allow.
    lengths = metric.lengths * (1 - 0.02 * np.exp(-8 * (x[a] + x[b])[:, 2] ** 2))
    text, _ = diagnosed(metric.with_lengths(lengths), x)
    assert ", in 1 connected region;" in text
    assert "Negative curvature over whole regions is unlikely to be noise" in text
    assert "alexandrov" not in text


def test_a_convex_metric_has_another_way():
    metric, x = of_body(*zoo.icosphere(2))
    assert not negative_deficits(metric).any()
    text, _ = diagnosed(metric, x)
    assert 'No deficit is negative: method="alexandrov" finds the convex polyhedron' in text
    assert "effort" not in text


def test_a_failure_carries_it():
    metric, _ = of_body(*smooth_bodies.ellipsoid(100))
    rng = np.random.default_rng(0)
    metric = metric.with_lengths(metric.lengths * (1 + 0.02 * rng.normal(size=len(metric.lengths))))
    with pytest.raises(NotEmbedded) as caught:
        isoembed.embed(metric)
    attempt = caught.value.embedding
    assert str(caught.value) == attempt.message
    assert attempt.status == "not converged"
    assert not isinstance(attempt, FittedSurface)
    e = int(np.argmax(attempt.residuals))
    assert attempt.message.startswith("no surface with these lengths was found: the nearest misses edge")
    assert f"edge {e} {metric.edges[e].tolist()} by {attempt.residual:.1e}" in attempt.message
    assert ". ." not in attempt.message
    assert attempt.message.endswith("a longer search may find it: method=Aim(effort=20)")
    assert "best fit" in [stage.name for stage in attempt.stages]
