"""Surfaces of slices from their data to their energies: closed forms, reports, meshes, warm starts."""

import json
from dataclasses import replace

import numpy as np
import pytest

from isoembed.errors import InvalidParameter, NotEmbedded
from isoembed.mesh.triangulation import Triangulation
from isoembed.relativity import (
    EmbeddedSurface,
    KerrNewmanErgosphere,
    KerrNewmanHorizon,
    KerrNewmanSphere,
    KerrSchild,
    PainleveGullstrand,
    StarSurface,
    SurfaceData,
    embed_surface,
)
from isoembed.smooth import AxisymmetricEmbedding, GridMetric, solve
from isoembed.surface.measures import face_areas, volume

Z_AXIS = (0.0, 0.0, 1.0)
ENERGIES = ("irreducible_mass", "christodoulou_mass", "hawking", "brown_york", "liu_yau")
HORIZON = KerrNewmanHorizon(1.0, 0.5)


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


# energies


def test_a_horizon(horizon):
    found = horizon.energies
    within(found.area, 46.898333599528960)
    within(found.integrated_mean_curvature, 24.300446945608874)
    within(found.brown_york, 1.9337681253680011)
    within(found.liu_yau, 1.9337681253680011)
    within(found.hawking, 0.9659258262890682)
    within(found.christodoulou_mass, 1.0)


BROWN_YORK = {(0.5, 3.0): 1.2474088054291813, (0.5, 6.0): 1.0992882037637871, (0.8, 3.0): 1.2196541460073282}


@pytest.mark.parametrize(("a", "r"), BROWN_YORK)
def test_kerr_at_a_constant_radius(a, r):
    found = embed_surface(KerrNewmanSphere(r, 1.0, a).data(), vertices=60).energies
    within(found.brown_york, BROWN_YORK[a, r])
    assert found.liu_yau.value == pytest.approx(found.brown_york.value, abs=1e-13)  # p = 0


def test_energies_of_the_mean_curvature_vector_do_not_depend_on_the_slice():
    """The surfaces r = const of both slices are the same surfaces of spacetime."""
    geometry = KerrSchild(1.0, (0.0, 0.0, 0.8))
    surface = StarSurface.from_radius(geometry.spheroid(3.0))
    found = embed_surface(surface.data(geometry, Z_AXIS), vertices=60).energies
    resting = embed_surface(KerrNewmanSphere(3.0, 1.0, 0.8).data(), vertices=60).energies
    within(found.liu_yau, BROWN_YORK[0.8, 3.0], 1e-10)
    for name in ("area", "integrated_mean_curvature", "hawking", "liu_yau"):
        ours, theirs = getattr(found, name), getattr(resting, name)
        assert abs(ours.value - theirs.value) <= ours.error + theirs.error
    assert found.brown_york.value < resting.brown_york.value - 0.1


def test_a_falling_slice(falling):
    within(falling.energies.brown_york, 0.0)
    within(falling.energies.liu_yau, 1.1010205144336438)
    within(falling.energies.hawking, 1.0)


def test_an_ergosphere_whose_mean_curvature_changes_its_sign():
    found = embed_surface(KerrNewmanErgosphere(0.5).data(), vertices=200).energies
    within(found.integrated_mean_curvature, 33.021720529589184, 1e-9)
    within(found.area, 84.498458825124000)
    assert found.liu_yau is None and found.notes[0].startswith("k = -")


# uncertain data


def test_uncertain_lengths_loosen_what_is_asked_for(horizon):
    found = embed_surface(replace(HORIZON.data(), relative_error=1e-4), vertices=60)
    assert found.embedding.tolerance == pytest.approx(1e-2)
    assert found.embedding.harmonics.degree <= horizon.embedding.harmonics.degree
    for name in ("area", "integrated_mean_curvature", *ENERGIES):
        loose, exact = getattr(found.energies, name), getattr(horizon.energies, name)
        assert loose.error > 1e3 * exact.error
        assert abs(loose.value - exact.value) <= loose.error + exact.error


def test_data_that_are_wrong_within_their_error_are_embedded():
    """A grid that does not resolve the metric: the truth is within the errors."""
    coarse = GridMetric.sampled(KerrNewmanHorizon(1.0, 0.8), 10, 4)
    assert 1e-6 < coarse.truncation < 1e-2
    found = embed_surface(SurfaceData(coarse, marginal=True, relative_error=coarse.truncation), vertices=60)
    within(found.energies.area, 40.212385965949353, 1.0)
    within(found.energies.integrated_mean_curvature, 22.730557214111993, 1.0)


def test_a_grid_that_resolves_the_metric():
    grid = GridMetric.sampled(KerrNewmanHorizon(1.0, 0.8), 48, 96)
    found = embed_surface(SurfaceData(grid, marginal=True, relative_error=grid.truncation), vertices=60)
    within(found.energies.area, 40.212385965949353, 1e-9)
    within(found.energies.liu_yau, 1.8088402699295326, 1e-9)


# reports


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
    assert all(tables[name].shape == (n,) for name in tables if name not in ("vertices", "faces"))


def test_the_mesh_of_a_horizon(horizon):
    tables = horizon.mesh(200)
    assert set(tables) == {"vertices", "faces", "mean_curvature", "gaussian_curvature", "residual", "k"}
    check_mesh(tables, horizon, 200)
    assert tables["residual"].max() <= 1.5 * horizon.embedding.residual
    np.testing.assert_allclose(tables["k"], 0.0, atol=1e-12)
    assert np.all(tables["mean_curvature"] > 0.0)
    # Its vertices are on the surface of revolution.
    exact = AxisymmetricEmbedding.of(HORIZON)
    assert np.ptp(tables["vertices"], axis=0).max() <= 2.0 * np.sqrt(HORIZON.radius**2 + 0.25) ** 2
    assert exact.embeds


def test_the_mesh_of_a_sphere_in_a_slice_with_momentum(falling):
    tables = falling.mesh(60)
    assert set(tables) >= {"k", "p"}
    check_mesh(tables, falling, 60)
    np.testing.assert_allclose(tables["mean_curvature"], 1.0 / 6.0, rtol=1e-11)
    np.testing.assert_allclose(tables["gaussian_curvature"], 1.0 / 36.0, rtol=1e-11)
    np.testing.assert_allclose(tables["k"], 1.0 / 3.0, rtol=1e-11)
    np.testing.assert_allclose(np.abs(tables["p"]), np.sqrt(2.0 / 6.0) / 3.0, rtol=1e-11)
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


def test_what_does_not_embed(monkeypatch):
    monkeypatch.setattr(solve, "SOLVE", replace(solve.SOLVE, degrees=(8, 12, 16)))
    data = KerrNewmanHorizon(1.0, 0.9).data()
    with pytest.raises(NotEmbedded, match=r"no surface of revolution has this metric for theta < 0\.561403"):
        embed_surface(data, vertices=100)
    fit = embed_surface(data, vertices=100, best_fit=True)
    assert fit.report["status"] == "best fit"
    assert any(
        "not an embedding, but the best fit: lengths are off by up to" in note for note in fit.energies.notes
    )
    assert fit.energies.brown_york.error > 1e-9
