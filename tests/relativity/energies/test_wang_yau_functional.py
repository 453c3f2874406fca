"""The Wang-Yau functional: its derivatives, and paths to its embeddings."""

import numpy as np
import pytest

from isoembed.relativity import KerrNewmanSphere, TimeFunction, wang_yau
from isoembed.relativity.energies.second_variation import SecondVariation
from isoembed.relativity.energies.time_function import TimeRaisedMetric
from isoembed.relativity.energies.wang_yau_functional import EmbeddedTime, Functional
from isoembed.smooth import Harmonics, embed_smooth
from isoembed.smooth.transforms import resized
from spacelike import minkowski, static


def test_second_variation_of_spheres():
    data, embedding = static()
    X, tau, r, f = Harmonics(8, 8), Harmonics(4, 4), 4.0, np.sqrt(0.5)
    functional = Functional.of(data, embedding, TimeFunction.zero(), X, tau)
    start = resized(embedding.coefficients, embedding.harmonics, X)
    hessian = SecondVariation.of(functional).at(np.zeros(24), start)
    l = tau.labels[0][1:]
    expected = l * (l + 1) * (1.0 - 2.0 * f + l * (l + 1) / (2.0 * f)) / (8.0 * np.pi * r)
    np.testing.assert_allclose(hessian, np.diag(expected), atol=1e-12 * expected.max())
    table = [0.5 * (0.05 * r) ** 2 * expected[l == degree][0] for degree in (1, 2, 3, 4)]
    np.testing.assert_allclose(table, [0.00039789, 0.00456985, 0.01926826, 0.05462167], atol=5e-9)
    found = wang_yau(data, "optimal", embedding=embedding)
    assert found.least_second_derivative == pytest.approx(expected.min(), rel=1e-10)
    assert found.energy.value == pytest.approx(4.0 * (1.0 - f), rel=1e-13)
    assert not found.notes


def test_derivatives_are_those_of_differences():
    _, data, embedding = minkowski()
    X, tau = Harmonics(12, 12), Harmonics(3, 3)
    functional = Functional.of(data, embedding, TimeFunction.zero(), X, tau)
    rng = np.random.default_rng(2)
    t, v, h = 0.05 * rng.normal(size=tau.size - 1), rng.normal(size=tau.size - 1), 1e-4
    here = functional.embedded(t, resized(embedding.coefficients, embedding.harmonics, X))
    ahead, behind = (functional.embedded(t + s * h * v, here.X) for s in (1, -1))
    assert (ahead.energy - behind.energy) / (2 * h) == pytest.approx(here.gradient @ v, rel=1e-5)
    change = (ahead.gradient - behind.gradient) / (2 * h)
    hessian = SecondVariation.of(functional).at(t, here.X)
    expected = hessian @ v
    np.testing.assert_allclose(change, expected, atol=1e-6 * np.abs(expected).max())
    np.testing.assert_array_equal(hessian, hessian.T)


@pytest.mark.slow
def test_the_energy_does_not_depend_on_where_the_path_begins():
    data = KerrNewmanSphere(3.0, 1.0, 0.8).data()
    tau = TimeFunction.of(lambda u: 1.5 * u[:, 2] + 0.4 * u[:, 0] * u[:, 2], 2)
    one = wang_yau(data, tau)
    raised = embed_smooth(TimeRaisedMetric(data.metric, tau))
    functional = Functional.of(data, raised, tau, raised.harmonics, tau.harmonics)
    other = EmbeddedTime(functional, tau.coefficients[1:], raised.coefficients).energy
    assert other == pytest.approx(one.energy.value, rel=1e-9)
