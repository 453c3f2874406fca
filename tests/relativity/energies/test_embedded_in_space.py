"""Energies with hyperbolic space for reference: Kerr horizons beyond Smarr's limit, and triangles."""

import numpy as np
import pytest

import isoembed
from isoembed.errors import NotEmbedded
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.relativity import (
    KerrNewmanErgosphere,
    KerrNewmanHorizon,
    KerrNewmanSphere,
    embed_surface,
    mesh_energies,
    unembedded_report,
)
from isoembed.relativity.energies.report import mesh_report
from isoembed.smooth import triangulate_metric
from isoembed.smooth.sphere_map import SphereMap
from isoembed.space import Hyperbolic, Space
from isoembed.space.models import from_model

# Quadratures of the closed form; Dunajski and Tod (arXiv:2107.12400) print 1.76569 for the limit.
LIMIT = 1.7656917209184877
TABLE = {0.9: 1.8343379378, 0.95: 1.9343168808, 0.99: 2.0102107853}


@pytest.mark.slow  # but for the command, tests/cli/test_energy_space.py
@pytest.mark.parametrize("spin", TABLE)
def test_the_table_of_horizons(spin):
    horizon = KerrNewmanHorizon(1.0, spin)
    surface = embed_surface(horizon.data(), space="hyperbolic")
    least = (horizon.radius**2 - 3.0 * spin**2) / (horizon.radius**2 + spin**2) ** 2
    assert surface.space.curvature == pytest.approx(least, rel=1e-9)
    assert surface.energies.liu_yau.value == pytest.approx(TABLE[spin], abs=1e-8)
    assert surface.energies.liu_yau.error < 1e-8
    report = surface.report["space"]
    assert report["name"] == "hyperbolic" and report["curvature"] == surface.space.curvature
    assert report["least"]["of_revolution"] == pytest.approx(least, rel=1e-9)


@pytest.mark.slow
def test_a_tilted_horizon():
    turn = np.array([[1.0, 0.0, 0.0], [0.0, 0.8, -0.6], [0.0, 0.6, 0.8]])
    data = KerrNewmanHorizon(1.0, 0.95).data().in_coordinates(SphereMap.linear(turn))
    assert embed_surface(data, space="hyperbolic").energies.liu_yau.value == pytest.approx(
        TABLE[0.95], abs=1e-6
    )


def test_the_energy_depends_on_the_curvature():
    horizon = KerrNewmanHorizon(1.0, 0.95)
    twice = Space(2.0 * (horizon.radius**2 - 3.0 * 0.95**2) / (horizon.radius**2 + 0.95**2) ** 2)
    surface = embed_surface(horizon.data(), space=twice)
    assert surface.energies.liu_yau.value == pytest.approx(2.165205282136, abs=1e-10)
    assert not surface.energies.notes and "least" not in surface.report["space"]


def test_within_the_limit_the_least_is_euclidean():
    surface = embed_surface(KerrNewmanHorizon(1.0, 0.5).data(), space="hyperbolic")
    assert surface.space.is_euclidean
    assert surface.energies.liu_yau.value == pytest.approx(1.9337681253680011, abs=1e-12)
    assert surface.report["space"]["least"]["gaussian_curvature"] > 0.0


@pytest.mark.slow
def test_spaces_of_too_little_curvature():
    data = KerrNewmanHorizon(1.0, 0.95).data()
    with pytest.raises(NotEmbedded, match="hyperbolic") as caught:
        embed_surface(data, space=Hyperbolic(0.1), vertices=60)
    assert unembedded_report(data, caught.value)["space"] == {"name": "hyperbolic", "curvature": -0.1}


def test_meshes_are_in_the_ball():
    surface = embed_surface(KerrNewmanSphere(3.0, spin=0.5).data(), space=Hyperbolic(0.2))
    mesh = surface.mesh(100)
    assert mesh["curvature"] == -0.2
    u = surface.embedding.triangulated(100).directions
    x = from_model(surface.space, mesh["vertices"], "conformal")
    np.testing.assert_allclose(x, surface.embedding.points(u), atol=1e-13)


@pytest.mark.slow
def test_triangles():
    sphere, space = KerrNewmanSphere(3.0, spin=0.8), Hyperbolic(0.1)
    exact = embed_surface(sphere.data(), space=space).energies
    mesh = triangulate_metric(sphere, 300)
    metric = PolyhedralMetric.on(mesh.metric.triangulation, mesh.metric.lengths, space)
    embedding = isoembed.embed(metric)
    found = mesh_energies(embedding, sphere.mean_curvature(mesh.directions), lengths="geodesic")
    assert found.liu_yau.value == pytest.approx(exact.liu_yau.value, rel=3e-3)
    assert abs(found.liu_yau.value - exact.liu_yau.value) < found.liu_yau.error
    report = mesh_report(embedding, found, "geodesic", "")
    assert report["space"] == {"name": "hyperbolic", "curvature": -0.1}


def test_where_the_curvature_is_below_that_of_space_it_is_said():
    surface = embed_surface(KerrNewmanErgosphere(1.0).data(), space=Hyperbolic(0.001))
    notes = surface.energies.notes
    assert any("the Gaussian curvature is less than the -0.001 of space in places" in note for note in notes)
