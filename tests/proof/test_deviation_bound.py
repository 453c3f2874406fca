"""Bounds on what errors of the lengths do, against surfaces that have them."""

import numpy as np
import pytest

import isoembed
import zoo
from isoembed.gallery import CassiniPeanut, Ellipsoid, Ergosphere, triangulate
from isoembed.metric.variation import area_derivative
from isoembed.surface.curvature import dihedral_angles
from isoembed.surface.derivatives import volume_gradient
from isoembed.surface.rigidity import LengthSystem
from noisy import ARRAYS, SCALARS, differences, realized, surface

BODIES = ((Ellipsoid((3.0, 2.0, 1.0)), 1e-6), (CassiniPeanut(), 1e-10))


@pytest.mark.parametrize(("body", "largest"), BODIES)
def test_a_hundred_noises_are_within_the_bound(body, largest):
    found, rng = surface(body, 100), np.random.default_rng(6)
    errors = largest * rng.uniform(0.5, 1, len(found.metric.lengths))
    bound, sigma = (
        isoembed.Sensitivity(found).deviation_bound(errors),
        isoembed.Sensitivity(found).deviation(errors),
    )
    assert bound.reason == ""
    for name in (*ARRAYS, *SCALARS):
        assert np.all(getattr(sigma, name) < getattr(bound, name)), name
    system = LengthSystem(found.triangulation)
    for _ in range(100):
        lengths = found.metric.lengths + rng.choice([-1, 1], len(errors)) * errors
        for name, change in differences(found, realized(found, system, lengths)).items():
            assert (np.abs(change) <= getattr(bound, name)).all(), name


@pytest.mark.parametrize(("body", "largest"), BODIES)
def test_integrals_come_near_their_bounds(body, largest):
    """With the worst signs of all errors, if these are so small that first order is all."""
    found, errors = surface(body, 100), largest / 100
    bound, system = isoembed.Sensitivity(found).deviation_bound(errors), LengthSystem(found.triangulation)
    rates = {
        "area": area_derivative(found.metric),
        "volume": isoembed.Sensitivity(found).vjp(volume_gradient(found.triangulation, found.vertices)),
        "integrated_mean_curvature": dihedral_angles(found.triangulation, found.vertices) / 2,
    }
    for name, rate in rates.items():
        lengths = found.metric.lengths + errors * np.sign(rate)
        change = differences(found, realized(found, system, lengths))[name]
        assert 0.8 < change / getattr(bound, name) < 1, name


@pytest.mark.skipif(np.finfo(np.longdouble).eps > 1e-18, reason="long doubles have no more digits here")
@pytest.mark.parametrize("body", (CassiniPeanut(), Ergosphere(0.1)))
def test_the_exact_surface_is_within_the_bounds_without_errors(body):
    """That of the lengths as they are, found and measured in long doubles."""
    metric = isoembed.PolyhedralMetric.from_mesh(*triangulate(body, 200, irregular=2))
    found = isoembed.embed(metric)
    t, lengths = metric.triangulation, metric.lengths.astype(np.longdouble)
    system, x = LengthSystem(t), found.vertices.astype(np.longdouble)
    for _ in range(4):
        missed = lengths_of(t, x) - lengths
        x = x - system.step(found.vertices, metric.lengths, missed.astype(np.float64))
    assert np.abs(missed).max() < 1e-17
    bound, theta = isoembed.Sensitivity(found).deviation_bound(0), angles_of(t, x)
    a, b, c = x[t.faces].transpose(1, 0, 2) - x.mean(axis=0)
    normals = np.cross(b - a, c - a)
    areas = np.sqrt((normals**2).sum(axis=1)) / 2
    around = np.zeros(t.n_vertices, dtype=np.longdouble)
    integrals = np.zeros(t.n_vertices, dtype=np.longdouble)
    for corner in range(3):  # the center of the circumcircle, and the middles of the two sides
        p, q, r = (x[t.faces[:, (corner + k) % 3]] for k in range(3))
        u, v, w = q - p, r - p, normals
        squares = [(each**2).sum(axis=1)[:, None] for each in (u, v, w)]
        center = (squares[0] * np.cross(v, w) + squares[1] * np.cross(w, u)) / (2 * squares[2])
        kites = np.cross(u / 2, center) + np.cross(center, v / 2)
        np.add.at(around, t.faces[:, corner], (kites * w).sum(axis=1) / np.sqrt(squares[2][:, 0]) / 2)
    np.add.at(integrals, t.edges.ravel(), np.repeat(lengths * theta / 4, 2))
    exact = {
        "dihedral_angles": theta - dihedral_angles(t, found.vertices),
        "mean_curvature": integrals / around - found.mean_curvature,
        "area": areas.sum() - found.area,
        "volume": (a * normals).sum() / 6 - found.volume,
        "integrated_mean_curvature": integrals.sum() - found.integrated_mean_curvature,
    }
    for name, off in exact.items():
        assert np.all(np.abs(off) <= getattr(bound, name)) and np.max(getattr(bound, name)) < 1e-9, name


def lengths_of(t, x):
    """Distances of the ends of the edges, in the precision of the vertices."""
    return np.sqrt(((x[t.edges[:, 0]] - x[t.edges[:, 1]]) ** 2).sum(axis=1))


def angles_of(t, x):
    """Exterior dihedral angles, in the precision of the vertices."""
    a, b, c = x[t.faces].transpose(1, 0, 2)
    n = np.cross(b - a, c - a)
    left, right = n[t.edge_faces[:, 0]], n[t.edge_faces[:, 1]]
    along = x[t.edges[:, 1]] - x[t.edges[:, 0]]
    across = (np.cross(left, right) * along).sum(axis=1) / np.sqrt((along**2).sum(axis=1))
    return np.arctan2(across, (left * right).sum(axis=1))


def test_no_bound_is_proven_for_large_errors():
    bound = isoembed.Sensitivity(surface(CassiniPeanut(), 60)).deviation_bound(0.1)
    assert bound.reason.startswith("the residuals are too large: h = 2 K rho / sigma^2 is ")
    assert all(np.isinf(getattr(bound, name)).all() for name in (*ARRAYS, *SCALARS))


def test_no_bound_is_proven_where_a_vertex_is_flat():
    x, faces = zoo.tetrahedron()
    a, b, c = faces[0]
    split = np.vstack([faces[1:], [[a, b, 4], [b, c, 4], [c, a, 4]]])
    flat = np.vstack([x, x[faces[0]].mean(axis=0)])
    metric = isoembed.PolyhedralMetric.from_mesh(flat, split)
    bound = isoembed.Sensitivity(
        isoembed.Embedding(metric, flat, method="given", tolerance=1e-10)
    ).deviation_bound(0)
    assert bound.reason and np.isinf(bound.volume)


def test_the_exact_tetrahedron_is_within_the_bound_without_errors():
    found = isoembed.embed(isoembed.PolyhedralMetric.from_mesh(*zoo.tetrahedron()))
    bound, [l, *_] = isoembed.Sensitivity(found).deviation_bound(0), found.metric.lengths
    exact = {
        "area": np.sqrt(3) * l**2,
        "volume": l**3 / np.sqrt(72),
        "integrated_mean_curvature": 3 * l * (np.pi - np.arccos(1 / 3)),
    }
    for name, value in exact.items():
        assert abs(getattr(found, name) - value) < getattr(bound, name) < 1e-12
    assert (
        np.abs(found.mean_curvature / exact["integrated_mean_curvature"] * exact["area"] - 1) < 1e-13
    ).all()
