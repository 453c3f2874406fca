"""``isoembed embed --best-fit``: what is written, what is said and with which status."""

import json
import os

import numpy as np
import pytest

import smooth_bodies
from isoembed.cli import main
from isoembed.cli.advice import in_options
from isoembed.io import InputFile, read_metric, write_metric
from isoembed.io.vtk import read_polydata
from isoembed.metric.polyhedral import PolyhedralMetric


@pytest.fixture
def run(tmp_path, monkeypatch, capfd):
    """Call the command where noisy.npz has no surface and exact.npz has one."""
    monkeypatch.chdir(tmp_path)
    metric = PolyhedralMetric.from_mesh(*smooth_bodies.ellipsoid(100))
    factors = 1 + 0.02 * np.random.default_rng(0).normal(size=len(metric.lengths))
    write_metric("exact.npz", metric)
    write_metric("noisy.npz", metric.with_lengths(metric.lengths * factors))

    def call(*arguments):
        status = main(["embed", *arguments])
        out, err = capfd.readouterr()
        return status, out, err

    return call


def residuals(metric, vertices):
    a, b = metric.edges.T
    return np.abs(np.linalg.norm(vertices[a] - vertices[b], axis=1) - metric.lengths) / metric.lengths.mean()


def test_without_it_noise_is_a_failure_with_a_diagnosis(run):
    status, out, err = run("noisy.npz", "-o", "a.npz", "--report", "r.json")
    assert status == 3
    assert out.startswith("not converged: r.json written, ")
    assert out.endswith("; --keep writes the best attempt\n")
    assert "take the best fit, --best-fit" in err
    assert err.count("\n") == 1
    assert not os.path.exists("a.npz")
    with open("r.json") as file:
        report = json.load(file)
    assert report["status"] == "not converged"
    assert in_options(report["message"]) in err


def test_the_report_tells_the_residual_of_the_file_that_is_written(run):
    status, out, err = run("noisy.npz", "--best-fit", "-o", "a.npz", "--report", "r.json")
    assert (status, err) == (0, "")
    assert out.startswith("best fit: a least-squares surface that misses the lengths")
    with open("r.json") as file:
        report = json.load(file)
    with np.load("a.npz") as archive:
        vertices, map_ = archive["vertices"], archive["residual"]
    metric = read_metric("noisy.npz")
    errors = residuals(metric, vertices)
    assert report["status"] == "best fit"
    assert report["residual"]["max"] == pytest.approx(errors.max(), rel=1e-9)
    assert report["best_fit"]["residual_rms"] == pytest.approx(np.sqrt(np.mean(errors**2)), rel=1e-9)
    assert report["best_fit"]["noise"] == pytest.approx(0.02, rel=0.5)
    assert report["message"] in out
    at_vertex = [errors[(metric.edges == v).any(axis=1)].max() for v in range(len(vertices))]
    np.testing.assert_allclose(map_, at_vertex, rtol=1e-9)
    # Meshes carry the map, and --quiet is quiet.
    assert run("noisy.npz", "--best-fit", "-o", "a.vtk", "--quiet") == (0, "", "")
    with InputFile("a.vtk") as file:
        np.testing.assert_allclose(read_polydata(file).fields["residual"], map_)


def test_without_output_the_summary_says_what_it_is(run):
    status, out, _ = run("noisy.npz", "--best-fit")
    assert status == 0
    assert out.startswith("best fit: a least-squares surface")
    assert "converged" not in out


def test_a_surface_that_exists_is_preferred(run):
    assert run("exact.npz", "--best-fit", "-o", "a.npz", "--report", "r.json")[0] == 0
    with open("r.json") as file:
        assert json.load(file)["status"] == "converged"


@pytest.mark.parametrize("method", ["paper", "alexandrov"])
def test_other_methods_have_none(run, method):
    status, out, err = run("noisy.npz", "--method", method, "--best-fit", "-o", "a.npz")
    assert (status, out) == (2, "")
    assert err == (
        f"isoembed: error: --best-fit needs the method 'aim': the method '{method}' has no best fit\n"
    )
    assert not os.path.exists("a.npz")


def test_other_methods_repair_nothing(run):
    status, out, err = run("noisy.npz", "--repair", "1e-6", "-o", "a.npz")
    assert (status, out) == (2, "")
    assert err == "isoembed: error: --repair needs the method 'alexandrov': the method 'aim' has no repair\n"
    assert not os.path.exists("a.npz")
