"""Integrals over smooth surfaces: closed forms, fourth order, estimates that hold, and what is refused."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import zoo
from isoembed.errors import InvalidParameter
from isoembed.gallery import (
    CassiniPeanut,
    Ellipsoid,
    Ergosphere,
    HarmonicSurface,
    KerrHorizon,
    Sphere,
    triangulate,
)
from isoembed.mesh.triangulation import Triangulation
from isoembed.meshing.sphere import hull_faces
from isoembed.smooth.geodesics import geodesic_lengths
from isoembed.smooth.two_metric import AngleMetric, PulledBack
from isoembed.surface import curvature, measures
from isoembed.surface.rigidity import LengthSystem, length_residuals
from isoembed.surface.shape_operator import normal_curvatures, second_derivatives, shape_operators
from isoembed.surface.smooth_integrals import (
    SmoothIntegrals,
)

COARSE, FINE = 500, 2000
AXES = np.array([2.0, 1.5, 1.0])
ELLIPSOID = Ellipsoid(tuple(AXES))
KERR = KerrHorizon(spin=0.8)
SURFACES = (
    Sphere(),
    ELLIPSOID,
    KERR,
    Ergosphere(epsilon=0.5),
    CassiniPeanut(),
)


@cache
def mesh(surface, n, irregular=None):
    vertices, faces = triangulate(surface, n, irregular=irregular)
    return Triangulation(faces), vertices


@cache
def integrals(surface, n, irregular=None):
    return SmoothIntegrals(*mesh(surface, n, irregular), "chord")


def fibonacci(n):
    """Directions (n, 3), spread evenly."""
    z = 1 - (2 * np.arange(n) + 1) / n
    phi = np.pi * (5**0.5 - 1) * np.arange(n)
    return np.stack([np.sqrt(1 - z**2) * np.cos(phi), np.sqrt(1 - z**2) * np.sin(phi), z], axis=1)


def kerr_components(theta, phi):
    """The horizon's metric in Boyer and Lindquist's angles."""
    a, r = KERR.spin, 1 + np.sqrt(1 - KERR.spin**2)
    sigma = r**2 + (a * np.cos(theta)) ** 2
    return sigma, 0.0, ((r**2 + a**2) * np.sin(theta)) ** 2 / sigma


def realized(triangulation, vertices, lengths):
    """The polyhedron with these lengths, by Newton's method from one near it."""
    system, x = LengthSystem(triangulation), vertices
    for _ in range(8):
        x = x - system.step(x, lengths, length_residuals(triangulation, x, lengths))
    assert np.allclose(measures.edge_lengths(triangulation.edges, x), lengths, rtol=1e-11)
    return x


@cache
def geodesic(name, n, irregular=None):
    """The triangulation, its lengths and the vertices of the polyhedron with geodesics for its edges."""
    if name == "kerr-horizon":
        u, faces = zoo.outward_hull(fibonacci(n))
        t, x = Triangulation(faces), KERR.point(u)
        metric = AngleMetric(kerr_components)
    elif name == "sphere":
        t, x = mesh(Sphere(), n, irregular)
        metric, u = PulledBack(lambda u: np.broadcast_to(np.eye(3), (len(u), 3, 3))), x
    else:
        t, x = mesh(ELLIPSOID, n, irregular)
        metric = PulledBack(lambda u: np.broadcast_to(np.diag(AXES), (len(u), 3, 3)))
        u = x / AXES
    a, b = t.edges.T
    lengths = geodesic_lengths(metric, u[a], u[b])
    return t, lengths, realized(t, x, lengths)


def ellipsoid_operators(x, axes):
    """Shape operators and unit normals of an ellipsoid."""
    gradient = x / axes**2
    norm = np.linalg.norm(gradient, axis=1)
    normal = gradient / norm[:, None]
    P = np.eye(3) - normal[:, :, None] * normal[:, None, :]
    return P @ np.diag(1 / axes**2) @ P / norm[:, None, None], normal


def rms(a):
    return np.sqrt(np.mean(a**2))


def test_shape_operators_of_an_ellipsoid_are_of_third_order():
    errors = {}
    axes = np.array([1.5, 1.2, 1.0])
    for n in (COARSE, FINE):
        t, x = mesh(Ellipsoid(tuple(axes)), n)
        exact = ellipsoid_operators(x, axes)[0]
        errors[n] = [rms(shape_operators(t, x, degree) - exact) for degree in (4, 3)]
    assert errors[FINE][0] < errors[COARSE][0] / 8
    assert errors[FINE][0] < 1e-3 < 2 * errors[FINE][1]
    assert errors[FINE][1] < errors[COARSE][1] / 3


def test_hessians_on_an_ellipsoid():
    errors = []
    axes = np.array([1.5, 1.2, 1.0])
    for n in (COARSE, FINE):
        t, x = mesh(Ellipsoid(tuple(axes)), n)
        B, normal = ellipsoid_operators(x, axes)
        P = np.eye(3) - normal[:, :, None] * normal[:, None, :]
        # Of x y and of z: the Hessian in space along the surface, less B times the slope across it.
        flat = np.zeros((2, 3, 3))
        flat[0, 0, 1] = flat[0, 1, 0] = 1
        slopes = np.stack([normal[:, 0] * x[:, 1] + normal[:, 1] * x[:, 0], normal[:, 2]], axis=1)
        exact = P[:, None] @ flat @ P[:, None] - slopes[:, :, None, None] * B[:, None]
        found = second_derivatives(t, x, np.stack([x[:, 0] * x[:, 1], x[:, 2]], axis=1))[1]
        errors.append(rms(found - exact))
    assert errors[1] < min(errors[0] / 8, 2e-3)


def test_normal_curvatures_of_a_sphere():
    t, x = mesh(Sphere(), COARSE)
    exact = np.eye(3) - x[:, :, None] * x[:, None, :]
    assert np.allclose(normal_curvatures(t, x, exact), 1, rtol=5e-3)
    assert np.allclose(normal_curvatures(t, 3 * x, shape_operators(t, 3 * x)), 1 / 3, rtol=2e-2)


@given(seed=st.integers(0, 1000), size=st.sampled_from([1e-100, 0.3, 1e12, 1e100]))
def test_operators_turn_and_scale_with_the_surface(seed, size):
    t, x = mesh(ELLIPSOID, 200)
    R = zoo.rotation(seed)
    expected = R @ shape_operators(t, x) @ R.T
    assert np.allclose(size * shape_operators(t, size * x @ R.T), expected, rtol=0, atol=1e-9)


def test_tensors_take_nothing_from_the_normal_and_turn_over_with_it():
    t, x = mesh(ELLIPSOID, 200)
    B = shape_operators(t, x)
    assert np.allclose(B, B.transpose(0, 2, 1), atol=1e-12)
    assert np.abs(np.linalg.det(B)).max() < 1e-12
    assert np.allclose(shape_operators(Triangulation(t.faces[:, ::-1]), x), -B, atol=1e-9)


def test_too_few_neighbors_for_any_fit():
    x, faces = zoo.tetrahedron()
    t = Triangulation(faces)
    assert not shape_operators(t, x).any()
    volume = SmoothIntegrals(t, x, "chord").volume
    assert volume.value == pytest.approx(8 / 3) and volume.error == pytest.approx(np.pi * 8 / 3)


@pytest.mark.parametrize("vertices", [12, 20, 32])
def test_a_dozen_vertices_do_not_tell_a_surface(vertices):
    u = fibonacci(vertices)
    area = SmoothIntegrals(Triangulation(hull_faces(u)), u * AXES, "chord").area
    assert abs(area.value - ELLIPSOID.area) <= area.error <= 1.5 * area.value


@pytest.mark.parametrize(
    ("surface", "irregular"),
    [
        *((surface, None) for surface in SURFACES),
        (ELLIPSOID, 1),
        (Ergosphere(epsilon=0.5), 1),
        pytest.param(HarmonicSurface(), None, marks=pytest.mark.slow),
    ],
    ids=lambda given: getattr(given, "name", str(given)),
)
def test_inscribed_polyhedra(surface, irregular):
    for name in ("integrated_mean_curvature", "area", "volume"):
        exact = getattr(surface, name)
        coarse, fine = (getattr(integrals(surface, n, irregular), name) for n in (COARSE, FINE))
        assert abs(coarse.value - exact) <= coarse.error
        assert abs(fine.value - exact) <= fine.error
        assert fine.error < coarse.error / 8  # 16 for four times as many vertices, but for the mesh
        t, x = mesh(surface, FINE, irregular)
        raw = {
            "integrated_mean_curvature": curvature.integrated_mean_curvature(t, x),
            "area": measures.area(t.faces, x),
            "volume": measures.volume(t.faces, x),
        }[name]
        assert abs(fine.value - exact) < abs(raw - exact) / 10
        assert fine.error < abs(raw - exact)


@pytest.mark.parametrize(
    ("surface", "irregular"),
    [(Sphere(), None), (Sphere(), 1), (ELLIPSOID, None), (ELLIPSOID, 1), (KERR, None)],
    ids=lambda given: getattr(given, "name", str(given)),
)
def test_polyhedra_with_geodesic_lengths(surface, irregular):
    fine, coarse = (geodesic(surface.name, n, irregular) for n in (FINE, COARSE))
    for name in ("integrated_mean_curvature", "area"):
        exact = getattr(surface, name)
        better, good = (getattr(SmoothIntegrals(t, x, "geodesic"), name) for t, _, x in (fine, coarse))
        assert abs(good.value - exact) <= good.error
        assert abs(better.value - exact) <= better.error
        assert better.error < good.error / 8
    t, _, x = fine
    raw = curvature.integrated_mean_curvature(t, x) - surface.integrated_mean_curvature
    integral = SmoothIntegrals(t, x, "geodesic").integrated_mean_curvature
    found = integral.value - surface.integrated_mean_curvature
    assert abs(found) < abs(raw) / 10
    assert abs(SmoothIntegrals(t, x, "geodesic").area.value / surface.area - 1) < 2e-6


def test_triangles_without_area_have_nothing_over_them():
    x, faces = zoo.subdivided(*zoo.cube())
    x[faces[0, 0]] = (x[faces[0, 1]] + x[faces[0, 2]]) / 2
    t = Triangulation(faces)
    assert measures.face_areas(faces, x)[0] == 0
    for lengths in ("geodesic", "chord"):
        smooth = SmoothIntegrals(t, x, lengths)
        found = smooth.integrated_mean_curvature, smooth.area, smooth.integral(x[:, 0])
        assert np.isfinite([(estimate.value, estimate.error) for estimate in found]).all()


@pytest.mark.parametrize("name", ["area", "volume"])
def test_errors_fall_at_fourth_order(name):
    coarse, fine = (
        abs(getattr(integrals(KERR, n), name).value - getattr(KERR, name)) for n in (COARSE, 4 * FINE)
    )
    assert fine < coarse / 150  # 16 times as many vertices: 256 but for the mesh


def test_estimates_on_a_mesh_that_hardly_resolves_the_surface():
    surface = Ellipsoid((3, 2, 1))
    t, x = mesh(surface, 250, 1)
    exact = surface.integrated_mean_curvature
    found = SmoothIntegrals(t, x, "chord").integral(surface.mean_curvature(x / [3.0, 2.0, 1.0]))
    assert 1e-2 * exact < abs(found.value - exact) <= found.error < 3e-2 * exact


def test_geodesics_taken_for_chords_are_noticed():
    t, _, x = geodesic("sphere", COARSE)
    wrong = SmoothIntegrals(t, x, "chord").integrated_mean_curvature
    right = SmoothIntegrals(t, x, "geodesic").integrated_mean_curvature
    assert abs(right.value - 4 * np.pi) < 1e-4 < abs(wrong.value - 4 * np.pi)


def test_functions_on_inscribed_polyhedra():
    for surface in (ELLIPSOID, CassiniPeanut()):
        for n in (COARSE, FINE):
            t, x = mesh(surface, n)
            # The Gauss-Bonnet theorem, and the integral of H, from exact values at the vertices.
            u = x / AXES if surface.name == "ellipsoid" else x
            K, H = surface.gaussian_curvature(u), surface.mean_curvature(u)
            for values, exact in ((K, 4 * np.pi), (H, surface.integrated_mean_curvature)):
                found = SmoothIntegrals(t, x, "chord").integral(values)
                assert abs(found.value - exact) <= found.error
        assert abs(found.value - exact) < 2e-4 * exact


def test_functions_on_polyhedra_with_geodesic_lengths():
    errors = []
    for n in (COARSE, FINE):
        t, _, x = geodesic("kerr-horizon", n)
        z = fibonacci(n)[:, 2]
        a, r = KERR.spin, 1 + np.sqrt(1 - KERR.spin**2)
        # The area of the horizon is (r^2 + a^2) times that of the sphere of directions.
        found = SmoothIntegrals(t, x, "geodesic").integral(z**4)
        exact = (r**2 + a**2) * 4 * np.pi / 5
        assert abs(found.value - exact) <= found.error < 2e-3 * exact
        errors.append(abs(found.value - exact))
    assert errors[1] < errors[0] / 8


def test_constants_integrate_to_the_area():
    for lengths in ("geodesic", "chord"):
        smooth = SmoothIntegrals(*mesh(KERR, COARSE), lengths)
        for value in (-2.0, 0.0, 1e-200):
            assert smooth.integral(np.full(COARSE, value)).value == pytest.approx(value * smooth.area.value)


@given(seed=st.integers(0, 1000), size=st.sampled_from([1e-100, 0.3, 1e12, 1e100]))
def test_motions_and_scales_change_nothing(seed, size):
    t, x = mesh(ELLIPSOID, 200)
    moved = SmoothIntegrals(t, size * (x @ zoo.rotation(seed).T + [5.0, -3.0, 1.0]), "chord")
    original = SmoothIntegrals(t, x, "chord")
    for a, b, power in (
        (moved.integrated_mean_curvature, original.integrated_mean_curvature, 1),
        (moved.area, original.area, 2),
        (moved.volume, original.volume, 3),
        (moved.integral(x[:, 2] ** 2), original.integral(x[:, 2] ** 2), 2),
    ):
        assert np.allclose([a.value / size**power, a.error / size**power], [b.value, b.error], rtol=1e-9)


def test_labels_change_nothing():
    t, x = mesh(ELLIPSOID, 200)
    moved, faces, _ = zoo.relabeled(x, t.faces, 3)
    found = SmoothIntegrals(Triangulation(faces), moved, "geodesic").integrated_mean_curvature
    expected = SmoothIntegrals(t, x, "geodesic").integrated_mean_curvature
    assert np.allclose([found.value, found.error], [expected.value, expected.error], rtol=1e-9)


def test_refusals():
    t, x = mesh(Sphere(), 200)
    with pytest.raises(InvalidParameter, match=r"^the lengths must be 'geodesic' or 'chord', not 'arc'$"):
        SmoothIntegrals(t, x, "arc")
    with pytest.raises(InvalidParameter, match=r"^the vertices have shape \(199, 3\), not \(200, 3\)$"):
        SmoothIntegrals(t, x[1:], "chord")
    broken = x.copy()
    broken[7] = 1.0, np.nan, 2.0
    with pytest.raises(
        InvalidParameter, match=r"^the vertices at vertex 7 are \[1\.0, nan, 2\.0\], which is not finite$"
    ):
        SmoothIntegrals(t, broken, "chord")
    with pytest.raises(InvalidParameter, match=r"^the values have shape \(3,\), not \(200,\)$"):
        SmoothIntegrals(t, x, "geodesic").integral([1.0, 2.0, 3.0])
    with pytest.raises(InvalidParameter, match=r"^the values at vertex 7 are nan, which is not finite$"):
        SmoothIntegrals(t, x, "geodesic").integral(broken[:, 1])
    with pytest.raises(
        InvalidParameter, match=r"^the volume requires vertices on the surface: lengths = 'chord'$"
    ):
        SmoothIntegrals(t, x, "geodesic").volume  # noqa: B018
