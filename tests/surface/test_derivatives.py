"""Derivatives of a surface by its lengths, against differences, closed forms and identities."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import isoembed
import zoo
from isoembed.gallery import CassiniPeanut, Ellipsoid, triangulate
from isoembed.linalg import SingularMatrix
from isoembed.metric.variation import area_derivative
from isoembed.surface import curvature, measures
from isoembed.surface.rigidity import LengthSystem, length_residuals

BODIES = {"ellipsoid": Ellipsoid((3.0, 2.0, 1.0)), "peanut": CassiniPeanut()}
CURVATURES = (-0.2, 0.0, 0.1)


def surface(body, n=120, k=0.0):
    x, faces = triangulate(body, n, irregular=3)
    metric = isoembed.PolyhedralMetric.from_mesh(x / 3, faces, curvature=k)
    return isoembed.Embedding(metric, x / 3, method="given", tolerance=1e-10)


def realized(found, lengths):
    """The vertices with these lengths, by Newton's method."""
    system, x = LengthSystem(found.triangulation, space=found.space), found.vertices
    for _ in range(6):
        x = x - system.step(x, lengths, length_residuals(found.triangulation, x, lengths, found.space))
    return x


def changes(found, size, seed=0):
    return size * np.random.default_rng(seed).standard_normal(len(found.metric.edges))


@pytest.mark.parametrize("k", CURVATURES)
@pytest.mark.parametrize("name", BODIES)
def test_distances_change_as_differences_do(name, k):
    found = surface(BODIES[name], k=k)
    dl = changes(found, 1e-3)
    velocity, h = isoembed.Sensitivity(found).jvp(dl), 2e-6 if name == "peanut" else 1e-3
    i, j = np.triu_indices(len(found.vertices), 7)
    distances = [
        found.space.distances(x[i], x[j])
        for x in (
            realized(found, found.metric.lengths + h * dl),
            realized(found, found.metric.lengths - h * dl),
            found.vertices + h * velocity,
            found.vertices - h * velocity,
        )
    ]
    rates = distances[2] - distances[3]
    assert np.abs(distances[0] - distances[1] - rates).max() < 1e-6 * np.abs(rates).max()


@pytest.mark.parametrize("k", CURVATURES)
def test_products_with_the_transpose(k):
    found = surface(BODIES["peanut"], k=k)
    rng = np.random.default_rng(1)
    dl, g = rng.standard_normal((2, 354)), rng.standard_normal((2, 120, 3))
    forward, backward = (
        np.einsum("avi,bvi->ab", isoembed.Sensitivity(found).jvp(dl), g),
        dl @ isoembed.Sensitivity(found).vjp(g).T,
    )
    assert np.allclose(forward, backward, rtol=1e-11, atol=1e-11 * np.abs(forward).max())


def test_velocity_has_no_translation_and_no_rotation():
    found = surface(BODIES["ellipsoid"])
    velocity = isoembed.Sensitivity(found).jvp(changes(found, 1.0))
    size = np.abs(velocity).sum()
    assert np.abs(velocity.sum(axis=0)).max() < 1e-12 * size
    assert np.abs(np.cross(found.vertices, velocity).sum(axis=0)).max() < 1e-12 * size


def test_scaling_all_lengths_scales_the_surface():
    found = surface(BODIES["ellipsoid"])
    variation = isoembed.Sensitivity(found).variation(found.metric.lengths)
    x = found.vertices - found.vertices.mean(axis=0)
    assert np.allclose(variation.velocity, x, rtol=0, atol=1e-12)
    assert np.abs(variation.acceleration).max() < 1e-11
    assert np.abs(variation.dihedral_rates).max() < 1e-11
    assert np.allclose(variation.area, (2 * found.area, 2 * found.area), rtol=1e-12)
    assert np.allclose(variation.volume, (3 * found.volume, 6 * found.volume), rtol=1e-11)
    first, second = variation.integrated_mean_curvature
    assert np.isclose(first, found.integrated_mean_curvature, rtol=1e-12) and abs(second) < 1e-11


def test_first_and_second_derivatives_against_differences():
    found = surface(BODIES["ellipsoid"])
    t, dl, h = found.triangulation, changes(found, 1e-3), 0.005
    variation = isoembed.Sensitivity(found).variation(dl)
    x = [realized(found, found.metric.lengths + s * h * dl) for s in (-2, -1, 0, 1, 2)]
    for name, function in (
        ("area", lambda y: measures.area(t.faces, y)),
        ("volume", lambda y: measures.volume(t.faces, y)),
        ("integrated_mean_curvature", lambda y: curvature.integrated_mean_curvature(t, y)),
    ):
        a, b, c, d, e = map(function, x)
        first = (8 * (d - b) - (e - a)) / (12 * h)
        second = (16 * (b + d) - 30 * c - (a + e)) / (12 * h * h)
        assert np.isclose(getattr(variation, name)[0], first, rtol=1e-6)
        assert np.isclose(getattr(variation, name)[1], second, rtol=1e-5)
    angles = [curvature.dihedral_angles(t, y) for y in x]
    rates = (8 * (angles[3] - angles[1]) - (angles[4] - angles[0])) / (12 * h)
    assert np.abs(rates - variation.dihedral_rates).max() < 1e-6 * np.abs(rates).max()


@pytest.mark.parametrize("name", BODIES)
def test_identity_of_schlaefli(name):
    found = surface(BODIES[name])
    terms = found.metric.lengths * isoembed.Sensitivity(found).variation(changes(found, 1.0)).dihedral_rates
    assert abs(terms.sum()) < 1e-10 * np.abs(terms).sum()


@pytest.mark.parametrize("k", (-0.2, 0.1))
def test_identity_of_schlaefli_in_curved_space(k):
    found = surface(BODIES["ellipsoid"], k=k)
    t, space, dl, h = found.triangulation, found.space, changes(found, 1e-3), 0.01
    velocity = isoembed.Sensitivity(found).jvp(dl)
    sides = [found.vertices + s * h * velocity for s in (1, -1)]
    turned, grown = (
        f(t, sides[0], space) - f(t, sides[1], space)
        for f in (curvature.dihedral_angles, lambda t, x, space: measures.volume(t.faces, x, space))
    )
    assert np.isclose(found.metric.lengths @ turned, -2 * k * grown, rtol=1e-5)


def test_area_is_a_function_of_the_lengths():
    found = surface(BODIES["peanut"])
    dl = changes(found, 1.0)
    assert np.isclose(
        isoembed.Sensitivity(found).variation(dl).area[0], area_derivative(found.metric) @ dl, rtol=1e-10
    )


def test_convex_polyhedron_on_its_own_triangles():
    x = np.random.default_rng(0).standard_normal((40, 3)) * (3.0, 2.0, 1.0)
    x, faces = zoo.outward_hull(x / np.linalg.norm(x / (3.0, 2.0, 1.0), axis=1)[:, None])
    metric = isoembed.PolyhedralMetric.from_mesh(x, faces)
    found = isoembed.embed(metric, method="alexandrov")
    dl = changes(found, 1e-3)
    assert np.isclose(
        isoembed.Sensitivity(found).variation(dl).area[0], area_derivative(found.metric) @ dl, rtol=1e-10
    )


@settings(max_examples=8)
@given(st.floats(-300, 300))
def test_units(power):
    scale = 2.0 ** int(power)
    found = surface(BODIES["ellipsoid"], 40)
    dl = changes(found, 1e-2)
    large = isoembed.Embedding(
        found.metric.scaled(scale), found.vertices * scale, method="given", tolerance=1e-10
    )
    assert np.array_equal(
        isoembed.Sensitivity(large).jvp(dl * scale), isoembed.Sensitivity(found).jvp(dl) * scale
    )
    assert (
        isoembed.Sensitivity(large).variation(dl * scale).volume[1]
        == isoembed.Sensitivity(found).variation(dl).volume[1] * scale**3
    )


def test_what_flexes_has_no_derivatives():
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.25, 0.25, 0], [0, 0, 1.0]])
    faces = [[0, 3, 1], [1, 3, 2], [2, 3, 0], [0, 1, 4], [1, 2, 4], [2, 0, 4]]
    found = isoembed.Embedding(
        isoembed.PolyhedralMetric.from_mesh(corners, faces), corners, method="given", tolerance=1e-10
    )
    with pytest.raises(SingularMatrix):
        isoembed.Sensitivity(found).jvp(np.ones(9))


def test_refusals():
    found = surface(BODIES["ellipsoid"], 40)
    with pytest.raises(isoembed.InvalidParameter, match=r"the changes have the shape \(3,\)"):
        isoembed.Sensitivity(found).jvp(np.ones(3))
    with pytest.raises(isoembed.InvalidParameter, match=r"the gradient at \[0, 2\] are nan"):
        isoembed.Sensitivity(found).vjp(np.where(np.arange(3) == 2, np.nan, np.ones((40, 3))))
    with pytest.raises(isoembed.InvalidParameter, match="the changes have the shape"):
        isoembed.Sensitivity(found).variation(np.ones((2, 114)))
    with pytest.raises(isoembed.InvalidParameter, match=r"not in Hyperbolic\(0\.2\)"):
        isoembed.Sensitivity(surface(BODIES["ellipsoid"], 40, -0.2)).variation(np.ones(114))
