"""Differences and standard deviations of surfaces with boundary or handles."""

from dataclasses import replace

import numpy as np
import pytest

import discs
import isoembed
import zoo
from isoembed import InvalidParameter, PolyhedralMetric, Sensitivity, SheetEmbedding, embed
from isoembed.gallery import Ellipsoid, triangulate
from isoembed.sheets.bending import BendingEnergy
from isoembed.sheets.boundary_condition import with_boundary_condition
from isoembed.surface.curvature import integrated_mean_curvature
from isoembed.surface.derivatives import dihedral_rates, integral_gradients
from isoembed.surface.deviation import IntegralDeviation
from isoembed.surface.measures import area, volume

POINTS, FACES = discs.irregular(50)
DOME = discs.round_cap(POINTS, 1.0) * [1.0, 1.2, 1.1]
METRIC = PolyhedralMetric.from_mesh(DOME, FACES)
LOOP = METRIC.triangulation.boundaries[0]
CONDITIONS = {"plane": "plane", "free": "free", "curve": DOME[LOOP]}


def sheet(x, faces, **known):
    metric = PolyhedralMetric.from_mesh(x, faces)
    return SheetEmbedding(metric, x, method="given", tolerance=1e-10, condition="given", **known)


def integrals(t, x):
    return np.array([area(t.faces, x), volume(t.faces, x), integrated_mean_curvature(t, x)])


def test_a_sheet_is_its_moved_mirror_image():
    one = embed(METRIC, boundary="free")
    moved = one.vertices * [-1.0, 1.0, 1.0] @ zoo.rotation(3) + 5.0
    found = isoembed.compare(one, replace(one, vertices=moved))
    assert found.distance < 1e-13
    for name in ("normals", "dihedral_angles", "mean_curvature"):
        np.testing.assert_allclose(getattr(found.difference, name), 0.0, atol=1e-6)
    assert abs(found.difference.integrated_mean_curvature) < 1e-11
    assert np.isnan(found.difference.volume)
    assert (found.certified, found.same) == (False, None)
    assert "because no proof is made for surfaces with boundary" in found.reason


def test_spheres_of_two_radii():
    """H differs by 1 - 1/2, the area by 2 pi (1 - cos 1) (4 - 1)."""
    x = discs.round_cap(POINTS, 1.0)
    one, two = sheet(x, FACES), sheet(2 * x, FACES)
    found = isoembed.compare(two, one)
    assert np.median(found.difference.mean_curvature) == pytest.approx(0.5, rel=0.02)
    assert found.difference.area == pytest.approx(-3 * one.area, rel=1e-12)
    assert found.difference.integrated_mean_curvature == pytest.approx(-one.integrated_mean_curvature)
    far = np.linalg.norm(x - x.mean(axis=0), axis=1)
    np.testing.assert_allclose(found.difference.vertices, far, atol=1e-12)


def test_tori_have_volumes():
    x, faces = discs.torus(12, 8)
    found = isoembed.compare(sheet(x, faces), sheet(x * [1.0, 1.0, -1.1], faces))
    assert found.difference.volume == pytest.approx(0.1 * sheet(x, faces).volume, rel=1e-12)


@pytest.mark.parametrize("mesh", [(DOME, FACES), discs.torus(8, 6, 0.1)], ids=["dome", "torus"])
def test_gradients_of_integrals(mesh):
    x, h = mesh[0], 1e-6
    t = PolyhedralMetric.from_mesh(*mesh).triangulation
    v = np.random.default_rng(0).normal(size=x.shape)
    rates = (integrals(t, x + h * v) - integrals(t, x - h * v)) / (2 * h)
    known = [0, 1, 2] if t.is_closed else [0]
    found = np.einsum("kvi,vi->k", integral_gradients(t, x), v)
    np.testing.assert_allclose(found[known], rates[known], rtol=1e-7)
    assert (dihedral_rates(t, x, v)[t.boundary_edges] == 0).all()


def test_on_a_sphere_it_is_what_schlaefli_gives():
    metric = PolyhedralMetric.from_mesh(*triangulate(Ellipsoid((3, 2, 1)), 60)).normalized
    surface = embed(metric)
    sensitivity, count = Sensitivity(surface), len(metric.lengths)
    errors = np.random.default_rng(1).uniform(1e-4, 1e-3, count)
    expected = sensitivity.integral_deviation(errors)
    derivatives, shared, exact = sensitivity._derivatives, np.arange(count), np.zeros(count)
    found = IntegralDeviation.of_sheet(derivatives, metric, surface.vertices, errors, shared, exact)
    for name in ("area", "volume", "integrated_mean_curvature"):
        assert getattr(found, name) == pytest.approx(getattr(expected, name), rel=1e-9)


@pytest.mark.parametrize("name", CONDITIONS)
def test_of_one_wrong_length_the_deviation_is_the_change(name):
    t, condition = METRIC.triangulation, CONDITIONS[name]
    surface, h = embed(METRIC, boundary=condition), 1e-5
    e = int(np.flatnonzero(~t.boundary_edges)[7])
    errors = np.zeros(t.n_edges)
    errors[e] = 1.0
    fits = BendingEnergy(METRIC)  # constant, unlike those of the changed lengths
    changed, volumes, curved, bent = [], [], [], []
    for step in (h, -h):
        lengths = METRIC.lengths.copy()
        lengths[e] += step
        tolerance = 1e-3 if name == "curve" else 1e-10
        found = embed(METRIC.with_lengths(lengths), boundary=condition, tolerance=tolerance)
        changed.append(found.vertices)
        volumes.append(np.nan if name == "free" else found.volume)
        curved.append(fits.mean_curvature(found.vertices))
        bent.append(fits.areas @ curved[-1])
    rates = (integrals(t, changed[0]) - integrals(t, changed[1])) / (2 * h)
    found = Sensitivity(surface).integral_deviation(errors)
    assert found.area == pytest.approx(abs(rates[0]), rel=1e-4)
    of_fits = abs(bent[0] - bent[1]) / (2 * h)  # 1/2 sum l theta may change half as much
    assert found.integrated_mean_curvature == pytest.approx(of_fits, rel=1e-4)
    under = abs(volumes[0] - volumes[1]) / (2 * h)  # over the plane of the boundary
    assert found.volume == pytest.approx(under, rel=1e-4, nan_ok=True)
    everywhere = Sensitivity(surface).deviation(errors)
    assert everywhere.integrated_mean_curvature == found.integrated_mean_curvature
    at_vertices = np.abs(curved[0] - curved[1]) / (2 * h)
    np.testing.assert_allclose(everywhere.mean_curvature, at_vertices, atol=1e-4 * at_vertices.max())
    moved = np.linalg.norm(changed[0] - changed[1], axis=1) / (2 * h)
    if name == "curve":
        np.testing.assert_allclose(everywhere.vertices, moved, atol=1e-4 * moved.max())


@pytest.mark.parametrize("body", ["ellipsoid", "torus"])
def test_integrals_of_closed_surfaces_are_those_of_the_polyhedron(body):
    """Whatever the method: that of their standard deviations, and of differences."""
    x, faces = triangulate(Ellipsoid((3, 2, 1)), 60) if body == "ellipsoid" else discs.torus(12, 8)
    metric = PolyhedralMetric.from_mesh(x, faces)
    found = embed(metric, boundary="free", start=x)
    expected = integrals(metric.triangulation, found.vertices)[2]
    assert found.integrated_mean_curvature == pytest.approx(expected, rel=1e-12)
    larger = embed(metric.scaled(1.1), boundary="free", start=1.1 * x)
    change = isoembed.compare(found, larger).difference.integrated_mean_curvature
    expected = larger.integrated_mean_curvature - found.integrated_mean_curvature
    assert change == pytest.approx(expected, rel=1e-10)


def test_a_surface_from_a_file_is_held_as_it_was():
    found = embed(METRIC.scaled(3.0), boundary="free")
    read = with_boundary_condition(replace(found, tensions=None, imbalance=None), "free")
    np.testing.assert_allclose(read.tensions, found.tensions, atol=1e-8 * np.abs(found.tensions).max())
    assert read.imbalance < 1e-10
    off = found.vertices.copy()
    off[5] += 0.01
    assert with_boundary_condition(replace(found, vertices=off), "free").imbalance > 1e-4
    with pytest.raises(InvalidParameter, match=r"the heights of 'plane': its vertex \d+ is off by 0"):
        with_boundary_condition(found, "plane", np.zeros(len(LOOP)))
