"""The best fit to noisy lengths: near the surface they came from, with the noise that was put in."""

from functools import cache, partial

import numpy as np
import pytest

import isoembed
import smooth_bodies
import zoo
from isoembed.aim import best_fit as module
from isoembed.aim.adaptive import Aim
from isoembed.aim.best_fit import best_fit
from isoembed.aim.regularized_energy import RegularizedEnergy
from isoembed.embedding.fitted import FittedSurface
from isoembed.errors import InvalidParameter, NotEmbedded
from isoembed.gallery import Bean, CassiniPeanut, HarmonicSurface, Sphere, triangulate
from isoembed.linalg.work import Budget, Work
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.surface.measures import edge_lengths
from isoembed.surface.rigidity import edge_rows


def noisy(vertices, faces, noise, seed=0):
    """Lengths with errors of this relative size, and the sphere of directions in the same unit."""
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    factors = 1 + noise * np.random.default_rng(seed).normal(size=len(metric.lengths))
    metric = metric.with_lengths(metric.lengths * factors)
    radii = np.linalg.norm(vertices, axis=1)[:, None]
    return metric.normalized, vertices / radii * radii.mean() / metric.unit, vertices / metric.unit


def fitted(metric, start, recorder):
    return best_fit(metric, RegularizedEnergy(metric, start, recorder.work), start, recorder, np.inf)


BODIES = {
    "ellipsoid": partial(smooth_bodies.ellipsoid, 400),
    "peanut": cache(partial(triangulate, CassiniPeanut(), 400)),
    "irregular saddle": cache(partial(triangulate, HarmonicSurface(2, 2, 0.2), 500, irregular=1)),
}


@pytest.mark.parametrize(
    ("body", "noise"),
    [
        ("ellipsoid", 3e-3),
        ("peanut", 1e-3),
        ("irregular saddle", 1e-2),
        pytest.param("ellipsoid", 1e-3, marks=pytest.mark.slow),
        pytest.param("peanut", 1e-2, marks=pytest.mark.slow),
        pytest.param("irregular saddle", 1e-3, marks=pytest.mark.slow),
    ],
)
def test_it_is_as_near_as_the_noise_and_tells_it(body, noise):
    metric, sphere, truth = noisy(*BODIES[body](), noise)
    recorder = smooth_bodies.recorder()
    fit = fitted(metric, sphere, recorder)
    assert fit.scatter == pytest.approx(noise, rel=0.3)  # less where edges are short enough: below
    assert smooth_bodies.misfit(fit.vertices, truth) < 6 * noise  # the farthest vertex, over the size
    assert recorder.factorizations <= 30


@pytest.mark.slow
@pytest.mark.parametrize("body", BODIES.values(), ids=BODIES)
def test_the_weight_is_nearly_that_of_one_who_knows_the_lengths(body):
    metric, sphere, truth = noisy(*body(), 2e-3)
    exact, x = edge_lengths(metric.edges, truth), sphere
    fits, risks = (
        module.Fits(
            metric, RegularizedEnergy(metric, sphere), smooth_bodies.recorder(), Budget(Work(), np.inf)
        ),
        {},
    )
    for weight in (100.0, 10.0, 1.0, 0.1, 0.01, 0.001, 1e-4, 1e-5):
        x = fits.fit(x, weight).vertices
        risks[weight] = np.sum((edge_lengths(metric.edges, x) - exact) ** 2)
    weight = fitted(metric, sphere, smooth_bodies.recorder()).weight
    assert risks[weight] < 1.5 * min(risks.values())
    assert max(risks.values()) > 3 * min(risks.values())


def test_no_other_weight_is_tried_when_no_more_may_be_spent():
    metric, start, _ = noisy(*BODIES["peanut"](), 1e-4)
    recorder = smooth_bodies.recorder()
    energy = RegularizedEnergy(metric, start, recorder.work)
    assert best_fit(metric, energy, start, recorder, 1.0).weight == module.WEIGHT
    assert recorder.factorizations <= module.MAX_STEPS + 1
    most = 25
    assert best_fit(metric, energy, start, recorder, most).weight < module.WEIGHT
    assert recorder.factorizations <= most + module.MAX_STEPS + 1


@pytest.mark.parametrize(("body", "noise"), [("ellipsoid", 3e-3), ("peanut", 1e-3)])
def test_no_system_is_factored_twice(body, noise, monkeypatch):
    factored, solver = [], RegularizedEnergy.solver

    def counted(energy, x, lengths, mu, damping, *more, **options):
        factored.append((x.tobytes(), mu, damping))
        return solver(energy, x, lengths, mu, damping, *more, **options)

    monkeypatch.setattr(RegularizedEnergy, "solver", counted)
    metric, sphere, _ = noisy(*BODIES[body](), noise)
    fitted(metric, sphere, smooth_bodies.recorder())
    assert len(factored) == len(set(factored)) > 1


def test_degrees_of_freedom_are_a_trace(monkeypatch):
    monkeypatch.setattr(module, "PROBES", 200)
    metric, _, x = noisy(*zoo.icosphere(1), 1e-3)
    energy, mu = RegularizedEnergy(metric, x), 5.0
    fits = module.Fits(metric, energy, smooth_bodies.recorder(), Budget(Work(), np.inf))
    n = x.size
    rows = edge_rows(metric.triangulation, x, metric.lengths)
    a, b = metric.edges.T
    J = np.zeros((len(a), len(x), 3))
    J[np.arange(len(a)), a], J[np.arange(len(a)), b] = rows, -rows
    J = J.reshape(len(a), n)
    penalty = np.column_stack([fits._energy.roughness(e.reshape(-1, 3), 0.0).ravel() for e in np.eye(n)])
    H = J @ np.linalg.solve(J.T @ J + mu * penalty + 1e-9 * np.eye(n), J.T)
    trace, of_square = fits._traces(x, mu)
    assert trace == pytest.approx(len(a) - np.trace(H), rel=0.03)
    assert of_square == pytest.approx(np.trace((np.eye(len(a)) - H) @ (np.eye(len(a)) - H)), rel=0.03)
    assert 20 < np.trace(H) < len(a) - 20


def test_lengths_without_errors_are_met():
    metric, sphere, truth = noisy(*BODIES["peanut"](), 0.0)
    fit = fitted(metric, sphere, smooth_bodies.recorder())
    assert fit.noise < 1e-5
    assert smooth_bodies.misfit(fit.vertices, truth) < 1e-5


def test_the_unit_does_not_matter():
    metric, sphere, _ = noisy(*BODIES["ellipsoid"](), 1e-2)
    scale = 1.9 / metric.mean_length
    plain = fitted(metric, sphere, smooth_bodies.recorder())
    scaled = fitted(metric.scaled(scale), scale * sphere, smooth_bodies.recorder())
    assert scaled.weight == plain.weight
    assert scaled.noise == pytest.approx(plain.noise, rel=1e-3)
    assert smooth_bodies.misfit(scaled.vertices, scale * plain.vertices) < 1e-3


@pytest.mark.slow
@pytest.mark.parametrize("body", [Sphere(), Bean()])
def test_the_noise_is_estimated_to_five_percent(body):
    vertices, faces = triangulate(body, 1200, irregular=1)
    exact = PolyhedralMetric.from_mesh(vertices, faces)
    errors = 0.01 * exact.mean_length * np.random.default_rng(3).normal(size=len(exact.lengths))
    surface = isoembed.embed(exact.with_lengths(exact.lengths + errors), method=Aim(best_fit=True))
    assert surface.noise == pytest.approx(0.01, rel=0.05)


# As an answer


def embedded(noise, **parameters):
    vertices, faces = smooth_bodies.ellipsoid(200)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    factors = 1 + noise * np.random.default_rng(0).normal(size=len(metric.lengths))
    metric = metric.with_lengths(metric.lengths * factors)
    return isoembed.embed(metric, method=Aim(best_fit=True), **parameters)


def test_the_numbering_does_not_matter():
    vertices, faces = smooth_bodies.ellipsoid(200)
    moved, others, new = zoo.relabeled(vertices, faces, 2)
    fits = []
    for x, f, at in ((vertices, faces, np.arange(len(new))), (moved, others, new)):
        metric = PolyhedralMetric.from_mesh(x, f)
        ends = np.sort(np.argsort(at)[metric.edges], axis=1)  # noise by the edge, whatever it is called
        noise = np.sin(1e4 * (ends[:, 0] + len(new) * ends[:, 1]))
        metric = metric.with_lengths(metric.lengths * (1 + 0.02 * noise))
        fits.append(best_fit(metric, RegularizedEnergy(metric, x), x, smooth_bodies.recorder(), np.inf))
    assert fits[0].weight == fits[1].weight
    assert fits[0].noise == pytest.approx(fits[1].noise, rel=1e-6)


def test_where_there_is_no_surface_the_best_fit_is_the_answer_and_says_so():
    surface = embedded(0.02)
    assert isinstance(surface, FittedSurface)
    assert (surface.status, surface.converged) == ("best fit", False)
    assert "best fit" in [stage.name for stage in surface.stages]
    assert surface.residual > surface.residual_rms > 1e-3
    report = isoembed.report(surface)
    assert report["status"] == "best fit"
    assert report["residual"]["max"] == surface.residual
    assert report["best_fit"] == {
        "noise": surface.noise,
        "residual_rms": surface.residual_rms,
        "weight": surface.weight,
    }
    assert surface.noise == pytest.approx(0.02, rel=0.1)
    worst = int(np.argmax(surface.residuals))
    assert surface.message.startswith("a least-squares surface that misses the lengths")
    assert f"edge {worst} {surface.metric.edges[worst].tolist()}" in surface.message
    assert smooth_bodies.misfit(surface.vertices, smooth_bodies.ellipsoid(200)[0]) < 6 * 0.02


def test_where_there_is_a_surface_it_is_the_answer():
    surface = embedded(1e-5)
    assert surface.status == "converged"
    assert not isinstance(surface, FittedSurface)
    assert "best_fit" not in isoembed.report(surface)


def test_a_tolerance_below_rounding_is_no_matter_for_a_fit():
    with pytest.raises(NotEmbedded) as caught:
        embedded(0.0, tolerance=1e-18)
    assert caught.value.embedding.residual < 1e-12


def test_a_fit_that_loses_the_shape_is_none():
    # Of the two triangles at the long side, both are nearly flat: no tetrahedron, and nothing smooth near it.
    faces = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]
    metric = PolyhedralMetric(faces, [1.0, 1.0, 1.0, 1.0, 1.0, 1.9])
    with pytest.raises(NotEmbedded, match="No smooth surface was found near them: check") as caught:
        isoembed.embed(metric, method=Aim(best_fit=True))
    assert caught.value.embedding.status == "not converged"


def test_what_is_not_a_yes_or_no_is_refused():
    with pytest.raises(InvalidParameter, match="best_fit is 'no', not True or False"):
        Aim(best_fit="no")
