"""Embedded surfaces of slices: reports, meshes, warm starts, and what does not embed."""

import json
from dataclasses import replace

import numpy as np
import pytest

from isoembed.errors import InvalidParameter, NotEmbedded
from isoembed.mesh.triangulation import Triangulation
from isoembed.relativity import (
    EmbeddedSurface,
    KerrNewmanHorizon,
    PainleveGullstrand,
    StarSurface,
    SurfaceData,
    embed_surface,
    embedded_report,
)
from isoembed.smooth import AxisymmetricEmbedding, solve
from isoembed.surface.measures import face_areas, volume

Z_AXIS = (0.0, 0.0, 1.0)
ENERGIES = ("irreducible_mass", "christodoulou_mass", "hawking", "brown_york", "liu_yau")
HORIZON = KerrNewmanHorizon(1.0, 0.5)
SLICE = ("k", "p", "theta_plus", "theta_minus")


def within(estimate, exact, largest=1e-10):
    assert estimate.error <= largest
    assert abs(estimate.value - exact) <= estimate.error


@pytest.fixture(scope="module")
def horizon():
    return embed_surface(HORIZON.data(), vertices=100)


@pytest.fixture(scope="module")
def falling():
    """Schwarzschild, r = 6, in a flat slice."""
    return embed_surface(
        StarSurface.sphere((0.0, 0.0, 0.0), 6.0).data(PainleveGullstrand(1.0), Z_AXIS), vertices=60
    )


# reports


def test_the_reason_without_a_wang_yau_energy_is_an_exception():
    surface = embed_surface(SurfaceData(HORIZON), vertices=60)
    assert isinstance(surface.wang_yau, InvalidParameter)
    report = embedded_report(surface, surface.wang_yau)
    assert report["wang_yau"] is None and report["errors"]["wang_yau"] is None
    assert report["notes"][-1] == str(surface.wang_yau)
    assert "wang_yau" not in surface.report


def test_the_report_is_strict_json(horizon):
    report = json.loads(json.dumps(horizon.report, allow_nan=False))
    assert report["status"] == "embedded"
    assert report["name"] == "Kerr-Newman horizon of mass 1, spin 0.5, charge 0"
    assert report["brown_york"] == horizon.energies.brown_york.value
    assert report["error_estimate"] == max(report["errors"][name] for name in ENERGIES)
    assert report["embedding"] == {
        "degree": horizon.embedding.harmonics.degree,
        "order": 1,
        "residual": horizon.embedding.residual,
        "least_gaussian_curvature": pytest.approx(0.196152422706, abs=2e-3),
        "volume": pytest.approx(30.103897179572039, rel=1e-10),
    }
    assert "int H dA with H = (k1 + k2)/2" in report["conventions"]["integrated_mean_curvature"]


def test_a_report_without_k_is_strict_json():
    found = embed_surface(SurfaceData(HORIZON), vertices=60)
    report = json.loads(json.dumps(found.report, allow_nan=False))
    assert report["brown_york"] is report["hawking"] is report["christodoulou_mass"] is None
    assert report["integrated_mean_curvature"] == pytest.approx(24.300446945608874, rel=1e-12)
    assert report["notes"]


# meshes


def check_mesh(tables, surface, n):
    """A closed mesh with n vertices that looks outward, of about the surface's area and volume."""
    vertices, faces = tables["vertices"], tables["faces"]
    assert vertices.shape == (n, 3) and Triangulation(faces).n_vertices == n
    assert all(np.isfinite(values).all() for values in tables.values())
    assert face_areas(faces, vertices).sum() == pytest.approx(surface.embedding.area, rel=5.0 / n)
    assert volume(faces, vertices) == pytest.approx(surface.embedding.volume, rel=10.0 / n)
    vectors = ("vertices", "faces", "slice_coordinates")
    assert all(tables[name].shape == (n,) for name in tables if name not in vectors)


def test_the_mesh_of_a_horizon(horizon):
    tables = horizon.mesh(200)
    there = {"vertices", "faces", "mean_curvature", "gaussian_curvature", "residual", *SLICE}
    assert set(tables) == there | {"angular_momentum_density"}
    check_mesh(tables, horizon, 200)
    assert tables["residual"].max() <= 1.5 * horizon.embedding.residual
    for name in SLICE:
        np.testing.assert_allclose(tables[name], 0.0, atol=1e-12)
    assert np.all(tables["mean_curvature"] > 0.0)
    # Its vertices are on the surface of revolution.
    exact = AxisymmetricEmbedding.of(HORIZON)
    assert np.ptp(tables["vertices"], axis=0).max() <= 2.0 * np.sqrt(HORIZON.radius**2 + 0.25) ** 2
    assert exact.embeds


def test_the_mesh_of_a_sphere_in_a_slice_with_momentum(falling):
    tables = falling.mesh(60)
    assert set(tables) >= {*SLICE, "slice_coordinates"}
    check_mesh(tables, falling, 60)
    np.testing.assert_allclose(tables["mean_curvature"], 1.0 / 6.0, rtol=1e-11)
    np.testing.assert_allclose(tables["gaussian_curvature"], 1.0 / 36.0, rtol=1e-11)
    np.testing.assert_allclose(tables["k"], 1.0 / 3.0, rtol=1e-11)
    p = tables["p"]
    np.testing.assert_allclose(np.abs(p), np.sqrt(2.0 / 6.0) / 3.0, rtol=1e-11)
    np.testing.assert_allclose(tables["theta_plus"], 1.0 / 3.0 - p, rtol=1e-11)
    np.testing.assert_allclose(tables["theta_minus"], -1.0 / 3.0 - p, rtol=1e-11)
    # Outside of the hole outgoing rays expand and ingoing ones converge, as in any other slice.
    np.testing.assert_allclose(tables["theta_plus"] * tables["theta_minus"], -4.0 / 36.0 * (1.0 - 2.0 / 6.0))
    # A sphere about the origin is where it is in the slice.
    np.testing.assert_allclose(tables["slice_coordinates"], tables["vertices"], atol=1e-11)
    assert tables["residual"].max() < 1e-12


def test_too_few_vertices(horizon):
    with pytest.raises(InvalidParameter, match="the number of vertices must be at least 12, not 5"):
        horizon.mesh(5)


# what is handed on


def test_a_warm_start_needs_no_mesh(horizon, monkeypatch):
    monkeypatch.setattr(solve, "graded_mesh", lambda *_, **__: pytest.fail("a mesh was made"))
    found = embed_surface(KerrNewmanHorizon(1.0, 0.6).data(), start=horizon)
    assert isinstance(found, EmbeddedSurface)
    within(found.energies.integrated_mean_curvature, 23.898597646410372)


@pytest.mark.slow
def test_what_does_not_embed_but_for_errors_of_lengths_is_embedded(monkeypatch):
    # Beyond Smarr's limit no surface of revolution has the metric; one has lengths that a percent allows.
    monkeypatch.setattr(solve, "DEGREES", (8, 12))
    data = replace(KerrNewmanHorizon(1.0, 0.9).data(), relative_error=0.01)
    surface = embed_surface(data, vertices=100)
    assert surface.embedding.residual < 0.01 and surface.report["status"] == "embedded"
    assert any("the Gaussian curvature is negative in places" in note for note in surface.energies.notes)


@pytest.mark.slow
def test_what_does_not_embed(monkeypatch):
    monkeypatch.setattr(solve, "DEGREES", (8, 12, 16))
    data = KerrNewmanHorizon(1.0, 0.9).data()
    with pytest.raises(NotEmbedded, match=r"no surface of revolution has this metric for theta < 0\.561403"):
        embed_surface(data, vertices=100)
    fit = embed_surface(data, vertices=100, best_fit=True)
    assert fit.report["status"] == "best fit"
    assert any("a best fit, not an embedding: lengths differ by up to" in note for note in fit.energies.notes)
    assert fit.energies.brown_york.error > 1e-9
