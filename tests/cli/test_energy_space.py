"""``--space`` of ``isoembed energy`` and ``isoembed horizon``: other spaces of reference, and refusals."""

from math import sqrt

import numpy as np
import pytest

from isoembed.io import read_metric
from isoembed.relativity import KerrNewmanHorizon
from isoembed.smooth import GridMetric
from strict_json import strict

HORIZON = ("--spacetime", "kerr", "--spin", 0.9, "--surface", "horizon")
DE_SITTER = ("--spacetime", "schwarzschild", "--cosmological-constant", -0.3, "--surface", "r=3")


def test_horizons_beyond_smarrs_limit(report):
    found = report(*HORIZON, "--space", "hyperbolic", "-o", "h.npz", "--vertices", 60)
    assert found["liu_yau"] == pytest.approx(1.8343379378, abs=1e-8)
    space = found["space"]
    assert space["name"] == "hyperbolic" and space["curvature"] == space["least"]["of_revolution"] < 0.0
    metric = read_metric("h.npz")
    assert metric.curvature == space["curvature"]
    assert metric.triangulation.n_vertices == 60


def test_curvatures_that_are_given(call, report):
    status, out, err = call("energy", *HORIZON, "--space", "hyperbolic=-0.2")
    assert (status, err) == (0, "")
    assert "in hyperbolic space of curvature -0.2\n" in out
    assert report(*HORIZON, "--space", "hyperbolic=-0.2")["space"] == {
        "name": "hyperbolic",
        "curvature": -0.2,
    }


def test_the_reference_may_be_anti_de_sitter_space(report):
    found = report(*DE_SITTER, "--space", "hyperbolic=-0.1", "--wang-yau")
    far, near = sqrt(1.9), sqrt(1.9 - 2.0 / 3.0)
    assert found["liu_yau"] == pytest.approx(3.0 * (far - near), rel=1e-12)
    assert found["wang_yau"] == pytest.approx(3.0 * far * (far - near), rel=1e-12)
    np.testing.assert_allclose(found["rest_frame"]["center"], 0.0, atol=1e-10)


@pytest.mark.slow
def test_horizon_files(call):
    grid = GridMetric.sampled(KerrNewmanHorizon(1.0, 0.9), 48, 1)
    np.savez("h.npz", theta=grid.theta, phi=grid.phi, q_tt=grid.q_tt, q_tp=grid.q_tp, q_pp=grid.q_pp)
    status, out, err = call("horizon", "h.npz", "--marginal", "--space", "hyperbolic", "--json")
    assert (status, err) == (0, "")
    found = strict(out)
    assert found["liu_yau"] == pytest.approx(1.8343379378, abs=1e-6)
    assert found["space"]["least"]["gaussian_curvature"] < 0.0


def test_triangles(call, report):
    mesh = ("--spacetime", "kerr", "--spin", 0.9, "--surface", "horizon", "--vertices", 300, "-o", "t.npz")
    assert call("triangulate", *mesh)[0] == 0
    found = report("t.npz", "--space", "hyperbolic=-0.2", "--lengths", "geodesic")
    assert found["space"] == {"name": "hyperbolic", "curvature": -0.2}
    exact = report(*HORIZON, "--space", "hyperbolic=-0.2")
    error = found["errors"]["integrated_mean_curvature"]
    assert abs(found["integrated_mean_curvature"] - exact["integrated_mean_curvature"]) < error < 0.2


@pytest.mark.parametrize(
    ("space", "sentence"),
    [
        ("spherical", "--space spherical needs its curvature"),
        ("hyperbolic=0.2", "0.2 is not the curvature of hyperbolic space, which is negative"),
        ("elliptic", "'elliptic' is not hyperbolic"),
    ],
)
def test_spaces_that_are_none(call, space, sentence):
    status, _, err = call("energy", *HORIZON, "--space", space)
    assert status == 2 and sentence in err


def test_a_space_that_does_not_do(call):
    status, out, err = call("energy", *HORIZON, "--space", "hyperbolic=-0.001", "--vertices", 60, "--json")
    assert status == 3 and "hyperbolic" in err
    assert strict(out)["space"] == {"name": "hyperbolic", "curvature": -0.001}


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (("--charge", 0.1), "charge cannot be combined with a cosmological constant"),
        (("--slice", "kerr-schild"), "slice kerr-schild cannot be combined with a cosmological constant"),
        (("--cosmological-constant", 0.5), "there is no horizon for"),
    ],
)
def test_cosmological_constants_that_do_not_do(call, options, sentence):
    status, _, err = call("energy", *HORIZON, "--cosmological-constant", -0.3, *options)
    assert status == 2 and sentence in err


def test_naming_the_space_that_a_file_is_in_changes_nothing(call, report):
    mesh = ("--spacetime", "kerr", "--spin", 0.9, "--surface", "horizon", "--vertices", 200, "-o", "t.npz")
    assert call("triangulate", *mesh)[0] == 0
    assert call("embed", "t.npz", "--space", "hyperbolic=-0.2", "-o", "found.ply")[0] == 0
    assert report("found.ply", "--space", "hyperbolic") == report("found.ply")
