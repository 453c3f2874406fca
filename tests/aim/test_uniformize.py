"""Uniformization: constant curvature by Newton's method and by the flow, agreement, failures."""

import numpy as np
import pytest

import smooth_bodies
import zoo
from isoembed.aim import uniformize
from isoembed.aim.uniformize import newton_uniformization, ricci_flow
from isoembed.metric.conformal import rescaled
from isoembed.metric.curvature import area, deficits, dual_areas
from isoembed.metric.polyhedral import PolyhedralMetric


def normalized(vertices, faces):
    return PolyhedralMetric.from_mesh(vertices, faces).normalized


def curvature_over_mean(metric):
    return deficits(metric) / dual_areas(metric) * area(metric) / (4 * np.pi)


@pytest.mark.parametrize("mesh", [smooth_bodies.ellipsoid(), smooth_bodies.drum(), zoo.random_hull(40, 2)])
def test_newtons_method_makes_the_curvature_constant_and_keeps_the_area(mesh):
    metric = normalized(*mesh)
    assert np.abs(curvature_over_mean(metric) - 1).max() > 0.5
    uniform = newton_uniformization(metric, smooth_bodies.recorder(), epsilon=1e-10)
    assert uniform.converged
    k = curvature_over_mean(uniform.metric)
    # What is left is a multiple of the Moebius modes, which no sphere-like metric can do without.
    assert uniform.deviation == pytest.approx(np.sqrt(np.mean((k - 1) ** 2)), rel=1e-6)
    assert uniform.deviation < 0.03
    assert area(uniform.metric) == pytest.approx(area(metric), rel=1e-13)
    assert uniform.kbar == pytest.approx(4 * np.pi / area(metric), rel=1e-13)
    assert uniform.radius == pytest.approx(np.sqrt(area(metric) / (4 * np.pi)), rel=1e-13)
    assert uniform.metric.lengths == pytest.approx(rescaled(metric, uniform.u).lengths, rel=1e-14)
    assert (uniform.history == np.vstack([0 * uniform.u, uniform.u])).all()


def test_what_newtons_method_leaves_shrinks_with_the_triangles():
    left = [
        newton_uniformization(
            normalized(*smooth_bodies.ellipsoid(n)), smooth_bodies.recorder(), epsilon=1e-10
        ).deviation
        for n in (100, 200, 400)
    ]
    assert left[0] > left[1] > left[2]
    assert left[2] < 5e-5


def test_newtons_method_converges_quadratically():
    recorder = smooth_bodies.recorder()
    newton_uniformization(normalized(*smooth_bodies.ellipsoid()), recorder, epsilon=1e-10)
    # 3 steps and 5 factorizations of the layout, then 2 or 3 of its own.
    assert recorder.iterations <= 6
    assert recorder.factorizations <= 9


def test_the_flow_and_newtons_method_end_at_the_same_curvature():
    metric = normalized(*smooth_bodies.ellipsoid())
    newton = newton_uniformization(metric, smooth_bodies.recorder(), epsilon=1e-10)
    flow = ricci_flow(metric, smooth_bodies.recorder(), integrator="BDF", epsilon=1e-3, t_f=100.0)
    assert flow.converged
    assert flow.deviation == pytest.approx(1e-3, rel=1e-9)  # the flow stops as it gets there
    k = curvature_over_mean(flow.metric)
    assert np.sqrt(np.mean((k - 1) ** 2)) == pytest.approx(flow.deviation)
    # The flow keeps the area up to the triangles' size.
    assert flow.kbar == pytest.approx(newton.kbar, rel=1e-2)
    assert (flow.history[0] == 0).all()
    assert (flow.history[-1] == flow.u).all()
    assert flow.metric.lengths == pytest.approx(rescaled(metric, flow.u).lengths, rel=1e-14)
    # They differ by a Moebius map: u(flow) - u(newton) is a combination of 1 and three more modes.
    steps = [np.sqrt(np.mean((curvature_over_mean(rescaled(metric, u)) - 1) ** 2)) for u in flow.history]
    assert (np.diff(steps) < 1e-3).all()  # it only ever becomes more uniform


@pytest.mark.parametrize("integrator", ["BDF", "Radau", "LSODA", "RK45"])
def test_every_integrator_lowers_the_curvature_along_the_flow(integrator):
    metric = normalized(*zoo.icosphere(1))
    stretched = PolyhedralMetric.from_mesh(zoo.icosphere(1)[0] * [1.3, 1, 1], metric.faces).normalized
    recorder = smooth_bodies.recorder()
    flow = ricci_flow(stretched, recorder, integrator=integrator, epsilon=0.05, t_f=100.0)
    reference = ricci_flow(stretched, smooth_bodies.recorder(), integrator="BDF", epsilon=0.05, t_f=100.0)
    assert flow.converged
    assert flow.deviation == pytest.approx(0.05, rel=1e-6)
    assert flow.u == pytest.approx(reference.u, abs=2e-3)
    assert recorder.iterations > 5


def test_the_flow_starts_along_minus_the_curvature_excess():
    metric = normalized(*smooth_bodies.ellipsoid())
    kbar = 4 * np.pi / area(metric)
    short = 1e-6
    flow = ricci_flow(metric, smooth_bodies.recorder(), integrator="RK45", epsilon=1e-3, t_f=short)
    velocity = flow.u / (short / kbar)
    excess = deficits(metric) / dual_areas(metric) - kbar
    assert velocity == pytest.approx(-excess, abs=1e-3 * np.abs(excess).max())


def test_a_flow_that_is_too_short_has_not_converged():
    metric = normalized(*smooth_bodies.ellipsoid())
    flow = ricci_flow(metric, smooth_bodies.recorder(), integrator="BDF", epsilon=1e-3, t_f=0.1)
    assert not flow.converged
    assert 1e-3 < flow.deviation < np.sqrt(np.mean((curvature_over_mean(metric) - 1) ** 2))


def test_a_uniform_metric_stays():
    metric = normalized(*zoo.icosahedron())
    flow = ricci_flow(metric, smooth_bodies.recorder(), integrator="BDF", epsilon=1e-6, t_f=1.0)
    newton = newton_uniformization(metric, smooth_bodies.recorder(), epsilon=1e-6)
    for uniform in (flow, newton):
        assert uniform.converged
        assert uniform.u == pytest.approx(0, abs=1e-10)
        assert uniform.deviation < 1e-10


def test_newtons_method_says_when_it_stops_short(monkeypatch):
    metric = normalized(*smooth_bodies.ellipsoid())
    assert not newton_uniformization(metric, smooth_bodies.recorder(), epsilon=1e-30).converged
    monkeypatch.setattr(uniformize, "MAX_STEPS", 1)
    assert not newton_uniformization(metric, smooth_bodies.recorder(), epsilon=1e-10).converged


def test_a_metric_of_negative_dual_areas_does_not_become_uniform_and_says_so():
    vertices, faces = zoo.random_hull(30, 0)
    metric = normalized(vertices * [1, 1, 20], faces)
    uniform = newton_uniformization(metric, smooth_bodies.recorder(), epsilon=1e-6)
    assert not uniform.converged
    assert np.isfinite(uniform.u).all()
