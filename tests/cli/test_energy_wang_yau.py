"""``isoembed energy --wang-yau``."""

from functools import partial

import numpy as np
import pytest

import isoembed
from isoembed.relativity import StarSurface
from isoembed.smooth import GridMetric
from isoembed.smooth.two_metric import angle_frame


@pytest.fixture
def run(call):
    """Call ``isoembed energy`` in an empty folder."""
    return partial(call, "energy")


def test_the_wang_yau_energy_is_the_least(report, tmp_path):
    """Of a round sphere of Schwarzschild's in a slice that falls: that of the slice at rest, tau = 0."""
    slice_ = ["--spacetime", "schwarzschild", "--surface", "r=4", "--slice", "painleve-gullstrand"]
    found = report(*slice_, "--wang-yau", "--vertices", 60, "-o", "a.npz")
    exact = 4.0 * (1.0 - np.sqrt(0.5))
    assert abs(found["wang_yau"] - exact) <= found["errors"]["wang_yau"] <= 1e-9
    assert found["minimum"]["least_second_derivative"] > 0.0 and found["minimum"]["admissible"] > 0.0
    assert found["minimum"]["evidence"] == "searched" and "local minimum" in found["minimum"]["basis"]
    written = np.load("a.npz")
    np.testing.assert_allclose(np.linalg.norm(written["vertices"], axis=1), 4.0, rtol=1e-9)
    np.testing.assert_allclose(written["tau"], 0.0, atol=1e-9)


def test_of_a_horizon_the_wang_yau_energy_is_the_limit(report):
    """Int k0 dA / 8 pi, as the energy of Kijowski, Liu and Yau."""
    horizon = ["--spacetime", "kerr", "--spin", 0.5, "--surface", "horizon"]
    found = report(*horizon, "--wang-yau", "--vertices", 60)
    assert abs(found["wang_yau"] - 1.9337681253680011) <= found["errors"]["wang_yau"] <= 1e-10
    assert "arXiv:2406.10751" in found["minimum"]["notes"][0]
    assert "evidence" not in found["minimum"]  # a theorem says which tau is the best


def test_where_there_is_no_wang_yau_energy_the_reason_is_said(report):
    found = report("isotropic", "--sphere", 0, 0, 0, 0.4, "--wang-yau", "--vertices", 60)
    assert found["wang_yau"] is None and found["errors"]["wang_yau"] is None
    assert "needs a spacelike, outward mean curvature vector" in found["notes"][-1]
    assert found["hawking"] is not None


def test_the_wang_yau_energy_of_a_surface_on_a_grid(run, report):
    """Kerr's r = 3 in a slice with momentum: with K(., n) the energy is known, without it is not."""
    slice_ = isoembed.relativity.KerrSchild(1.0, (0.0, 0.0, 0.5))
    data = StarSurface.from_radius(slice_.spheroid(3.0)).data(slice_)
    metric = GridMetric.sampled(data.metric, 24, 32)
    theta, phi = np.meshgrid(metric.theta, metric.phi, indexing="ij")
    x, y = np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi)
    u = np.stack([x, y, np.cos(theta)], axis=2).reshape(-1, 3)
    np.savez("grid.npz", **{n: getattr(metric, n) for n in ("theta", "phi", "q_tt", "q_tp", "q_pp")})
    np.save("k.npy", data.mean_curvature(u).reshape(24, 32))
    np.save("p.npy", data.momentum(u).reshape(24, 32))
    e_theta, e_phi = angle_frame(u)
    j = data.normal_momentum(u)
    components = [(j * e_theta).sum(axis=1), (j * e_phi).sum(axis=1) * np.sin(theta).ravel()]
    np.save("j.npy", np.reshape(components, (2, 24, 32)))
    arguments = ["grid.npz", "--mean-curvature", "k.npy", "--momentum", "p.npy", "--wang-yau"]
    found = report(*arguments, "--normal-momentum", "j.npy")
    assert abs(found["wang_yau"] - 1.2474088054291813) <= found["errors"]["wang_yau"] <= 1e-6
    without = report(*arguments)
    assert without["wang_yau"] is None and "needs the normal_momentum K(., n)" in without["notes"][-1]
    status, _, err = run(*arguments, "--normal-momentum", "k.npy")
    assert status == 2 and "k.npy has the shape (24, 32), not (2, n, m)" in err
