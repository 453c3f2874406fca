"""The descent to a minimum of the regularized energy."""

import numpy as np

import smooth_bodies
from isoembed.aim.energy_descent import minimize_energy
from isoembed.aim.regularized_energy import RegularizedEnergy
from isoembed.gallery import HarmonicSurface, triangulate
from isoembed.metric.polyhedral import PolyhedralMetric

MU = 1e-7


def test_it_ends_at_a_minimum_where_gauss_newton_steps_do_not():
    vertices, faces = triangulate(HarmonicSurface(2, 2, 0.3), 150)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    errors = np.random.default_rng(0).standard_normal(metric.triangulation.n_edges)
    lengths = metric.lengths * (1 + 1e-2 * errors)  # no surface has these: r stays, and with it S
    recorder = smooth_bodies.recorder()
    energy = RegularizedEnergy(metric, vertices, recorder.work)
    mu = MU * energy.unit**2

    def slope(x):
        r = energy.residuals(x, lengths)
        return np.linalg.norm(energy.forces(x, lengths, r) + mu * energy.roughness(x, 0.0))

    found = x = vertices
    for _ in range(4):  # each ends where a step gains little
        found = minimize_energy(energy, found, lengths, mu, recorder, lambda _: False)
    assert recorder.factorizations > 4
    for _ in range(recorder.factorizations):
        x = energy.relaxed(x, lengths, mu, 0.0, smooth_bodies.recorder())
    assert slope(found) < 1e-9 * min(slope(vertices), slope(x))
    assert energy.value(found, lengths, mu) <= energy.value(x, lengths, mu)


def test_it_stops_when_told():
    vertices, faces = triangulate(HarmonicSurface(2, 2, 0.3), 150)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    recorder = smooth_bodies.recorder()
    energy = RegularizedEnergy(metric, vertices, recorder.work)
    found = minimize_energy(
        energy, vertices, metric.lengths, 1.0, recorder, lambda _: recorder.factorizations == 2
    )
    assert recorder.factorizations == 2
    assert energy.value(found, metric.lengths, 1.0) < energy.value(vertices, metric.lengths, 1.0)
