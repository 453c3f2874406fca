"""What the colors show, against closed forms."""

import numpy as np
import pytest

import discs
import zoo
from isoembed import Embedding, InvalidParameter, PolyhedralMetric
from isoembed.gallery import Ellipsoid, KerrHorizon, Sphere, triangulate
from isoembed.plot import QUANTITIES, Quantity, quantities, quantity
from isoembed.plot.coloring import face_means


def exact(surface, n, **how):
    vertices, faces = triangulate(surface, n, **how)
    return Embedding(PolyhedralMetric.from_mesh(vertices, faces), vertices, method="exact", tolerance=1e-10)


def test_all_of_them():
    found = quantities(exact(Ellipsoid((3.0, 2.0, 1.0)), 100))
    assert [*(q.name for q in found), "sides"] == list(QUANTITIES)
    assert all(q.values.shape == (100,) for q in found)


def test_curvatures_of_a_sphere():
    sphere = exact(Sphere(radius=2.0), 400)
    assert quantity(sphere, "mean curvature").values.mean() == pytest.approx(1 / 2, rel=0.02)
    assert quantity(sphere, "Gaussian curvature").values.mean() == pytest.approx(1 / 4, rel=0.01)
    assert quantity(sphere, "conformal factor").values == pytest.approx(0, abs=0.01)


def test_gaussian_curvature_is_unknown_where_there_is_no_dual_area():
    faces = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0.5, 0.1, 0], [0.5, 0, 0.1]])  # obtuse triangles only
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    values = quantity(
        Embedding(metric, vertices, method="exact", tolerance=1e-10), "Gaussian curvature"
    ).values
    assert np.isnan(values).tolist() == [True, True, False, False]


def test_colors_of_gaussian_curvature_leave_out_the_boundary():
    points, faces = discs.hexagonal(6)
    vertices = discs.round_cap(points, 1.0)
    cap = Embedding(PolyhedralMetric.from_mesh(vertices, faces), vertices, method="exact", tolerance=1e-10)
    shown = quantity(cap, "Gaussian curvature")
    assert (np.isnan(shown.values) == cap.triangulation.boundary_vertices).all()
    assert 0.9 < shown.bounds[0] < shown.bounds[1] < 1.1
    assert face_means(shown.values, cap.faces) == pytest.approx(1.0, rel=0.1)  # at the boundary, too


def test_the_residual_is_that_of_the_edges_around():
    vertices, faces = zoo.icosphere(1)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    moved = vertices.copy()
    moved[0] *= 1.01
    surface = Embedding(metric, moved, method="moved", tolerance=1e-10)
    shown = quantity(surface, "residual")
    assert shown.scale == "log"
    touched = np.append(surface.triangulation.adjacency[[0]].indices, 0)
    assert set(np.flatnonzero(shown.values > 1e-6)) == set(touched)
    assert shown.values.max() == pytest.approx(surface.residual)


def test_the_share_of_concave_edges():
    vertices, faces = zoo.icosphere(1)
    dented = vertices.copy()
    dented[0] *= 0.5
    surface = Embedding(PolyhedralMetric.from_mesh(dented, faces), dented, method="dented", tolerance=1e-10)
    values = quantity(surface, "concave edges").values
    assert values[0] == 1
    assert surface.surface.inverted_vertices[0]
    assert ((values >= 0) & (values <= 1)).all()
    assert values @ surface.triangulation.degrees == 2 * surface.surface.concave_edges.sum()


@pytest.mark.parametrize("spin", [0.5, 0.8])
def test_the_conformal_factor_of_a_surface_of_revolution(spin):
    """Isothermal latitude by quadrature: ds_sphere / ds = sech(psi) R / rho, d psi = ds / rho."""
    horizon, n = KerrHorizon(spin=spin), 2000
    surface = exact(horizon, n)
    theta = np.linspace(0, np.pi, 20001)[1:-1]
    x, _, z = horizon.point(np.column_stack([np.sin(theta), 0 * theta, np.cos(theta)])).T
    slope = np.hypot(np.gradient(x, theta), np.gradient(z, theta)) / x
    psi = np.concatenate([[0], np.cumsum((slope[1:] + slope[:-1]) / 2 * np.diff(theta))])
    psi -= psi[len(psi) // 2]
    radius = np.sqrt(horizon.area / (4 * np.pi))
    u = np.log(radius / (np.cosh(psi) * x))
    height = surface.vertices[:, 2]
    away = np.abs(height) < 0.98 * np.abs(height).max()
    expected = np.interp(height, z[::-1], u[::-1])
    found = quantity(surface, "conformal factor").values
    assert np.abs(found - expected)[away].max() < 0.02 * np.ptp(expected)


def test_bounds_are_never_empty():
    assert Quantity("", "", np.full(5, 2.0)).bounds == pytest.approx((1.9, 2.1))
    assert Quantity("", "", np.full(5, np.nan)).bounds == (0, 1)
    low, high = Quantity("", "", np.full(5, 1e-16), "log").bounds
    assert (low, high) == pytest.approx((1e-16, 1e-15))
    assert Quantity("", "", np.array([3e-9, 2e-7]), "log").bounds == pytest.approx((1e-9, 1e-6))
    assert Quantity("", "", np.zeros(5)).bounds == (0, 1)


def test_rounding_is_not_shown_as_structure():
    values = np.append(np.linspace(-1e-15, 1e-15, 1000), 2.0)  # the curvature of a finely divided cube
    assert Quantity("", "", values).bounds == pytest.approx((-2e-6, 2e-6), rel=1e-3)


@pytest.mark.parametrize("radius", [1e-152, 1e-154, 1e-200])
def test_gaussian_curvature_is_unknown_beyond_the_range_of_floats(radius):
    found = quantity(exact(Sphere(radius=radius), 42), "Gaussian curvature")
    assert np.isnan(found.values).all()
    assert found.bounds == (0, 1)


def test_a_metric_without_a_conformal_map():
    needle = exact(Ellipsoid((1.65, 0.05, 0.05)), 100)
    shown = quantity(needle, "conformal factor")
    assert np.isnan(shown.values).all()
    assert shown.label == "this surface has no conformal factor"
    assert "conformal factor" not in [q.name for q in quantities(needle)]


def test_what_is_not_there():
    surface = exact(Sphere(), 42)
    with pytest.raises(InvalidParameter, match="there is no quantity 'torsion' to show; there are mean curv"):
        quantity(surface, "torsion")
