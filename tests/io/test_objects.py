"""Objects of trimesh and PyVista, out and in again; with stand-ins of them where they are not installed."""

import sys
import warnings
from types import SimpleNamespace

import numpy as np
import pytest

import isoembed
import zoo
from isoembed.gluing.classics import CLASSICS
from regular_in_space import regular_solid

SQUARES = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
CUBE = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])


@pytest.fixture(scope="module")
def ball():
    metric = isoembed.PolyhedralMetric.from_mesh(*zoo.icosphere(1))
    return isoembed.embed(metric)


@pytest.fixture(scope="module")
def hyperbolic():
    solid = regular_solid("cube", -1.0, 1.2)
    return isoembed.embed(
        isoembed.PolyhedralMetric.from_mesh(solid.points, solid.faces, curvature=-1.0), method="alexandrov"
    )


def test_trimesh_there_and_back(ball):
    pytest.importorskip("trimesh")
    mesh = isoembed.io.to_trimesh(ball)
    assert (
        mesh.is_watertight
        and mesh.volume == pytest.approx(ball.volume)
        and mesh.area == pytest.approx(ball.area)
    )
    assert (mesh.vertices == ball.vertices).all() and (mesh.faces == ball.faces).all()
    assert (mesh.vertex_attributes["mean_curvature"] == ball.mean_curvature).all()
    again = isoembed.PolyhedralMetric.from_trimesh(mesh)
    assert again.lengths == pytest.approx(ball.metric.lengths, rel=1e-9)


def test_bodies_of_trimesh():
    trimesh = pytest.importorskip("trimesh")
    metric = isoembed.PolyhedralMetric.from_trimesh(trimesh.creation.box((1, 2, 3)))
    assert isoembed.embed(metric, method="alexandrov").volume == pytest.approx(6)
    with pytest.raises(isoembed.InvalidParameter, match=r"type Scene has no vertices.*give one mesh"):
        isoembed.PolyhedralMetric.from_trimesh(trimesh.Scene())


def test_what_trimesh_changes_is_its_own(ball):
    pytest.importorskip("trimesh")
    mesh = isoembed.io.to_trimesh(ball)
    mesh.apply_scale(2.0)
    assert np.abs(ball.vertices).max() < 1.1 and not np.shares_memory(mesh.vertices, ball.vertices)


def test_pyvista_there_and_back(ball):
    pytest.importorskip("pyvista")
    mesh = isoembed.io.to_pyvista(ball)
    assert mesh.volume == pytest.approx(ball.volume) and mesh.n_open_edges == 0
    assert (mesh.points == ball.vertices).all() and mesh.points.dtype == np.float64
    assert (mesh.point_data["mean_curvature"] == ball.mean_curvature).all()
    assert (mesh.point_data["residual"] <= 1e-10).all()
    again = isoembed.PolyhedralMetric.from_pyvista(mesh)
    assert again.lengths == pytest.approx(ball.metric.lengths, rel=1e-9)
    mesh.points *= 2.0
    assert np.abs(ball.vertices).max() < 1.1


def test_faces_of_a_polyhedron_are_polygons_of_pyvista():
    pytest.importorskip("pyvista")
    solid = isoembed.embed(dict(CLASSICS["platonic"].make())["12 pentagons"], method="alexandrov")
    mesh = isoembed.io.to_pyvista(solid)
    assert mesh.n_cells == 12 and {cell.n_points for cell in mesh.cell} == {5}
    again = isoembed.PolyhedralMetric.from_pyvista(mesh)
    assert isoembed.embed(again, method="alexandrov").volume == pytest.approx((15 + 7 * np.sqrt(5)) / 4)


def test_bodies_of_pyvista():
    pv = pytest.importorskip("pyvista")
    prism = pv.Cylinder(radius=1.0, height=2.0, resolution=6)  # its points stand twice, in quadrilaterals
    with pytest.warns(isoembed.MeshNote, match="merged"):
        metric = isoembed.PolyhedralMetric.from_pyvista(prism, merge=1e-5)
    assert isoembed.embed(metric, method="alexandrov").volume == pytest.approx(3 * np.sqrt(3), rel=1e-6)
    with pytest.raises(isoembed.InvalidMetric, match="merge them"):
        isoembed.PolyhedralMetric.from_pyvista(prism)
    strips = pv.Sphere(theta_resolution=8, phi_resolution=8).strip()
    assert isoembed.PolyhedralMetric.from_pyvista(strips).triangulation.n_vertices == strips.n_points
    grid = pv.Sphere(theta_resolution=8, phi_resolution=8).cast_to_unstructured_grid()
    with pytest.raises(isoembed.InvalidParameter, match=r"UnstructuredGrid has no faces.*extract_surface"):
        isoembed.PolyhedralMetric.from_pyvista(grid)


@pytest.mark.parametrize("package", ["trimesh", "pyvista"])
def test_hyperbolic_space_is_kept(package, hyperbolic):
    pytest.importorskip(package)
    mesh = getattr(isoembed.io, f"to_{package}")(hyperbolic)
    again = getattr(isoembed.PolyhedralMetric, f"from_{package}")(mesh)
    assert again.curvature == -1.0
    assert isoembed.embed(again, method="alexandrov").volume == pytest.approx(hyperbolic.volume, rel=1e-8)


@pytest.mark.parametrize("package", ["trimesh", "pyvista"])
def test_without_the_package(package, ball, monkeypatch):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(ImportError, match=rf"to_{package} needs .*: pip install {package}"):
        getattr(isoembed.io, f"to_{package}")(ball)


def test_any_object_with_these_attributes_will_do():
    cells = np.concatenate([[4, *square] for square in SQUARES])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        metrics = [
            isoembed.PolyhedralMetric.from_trimesh(SimpleNamespace(vertices=CUBE, faces=SQUARES)),
            isoembed.PolyhedralMetric.from_pyvista(SimpleNamespace(points=CUBE, faces=cells)),
        ]
    mixed = np.concatenate([[3, 0, 1, 3, 3, 0, 3, 2], *([4, *square] for square in SQUARES[1:])])
    metrics.append(isoembed.PolyhedralMetric.from_pyvista(SimpleNamespace(points=CUBE, faces=mixed)))
    for metric in metrics:
        assert isoembed.embed(metric, method="alexandrov").volume == pytest.approx(1)


@pytest.mark.parametrize("cells", [[], [3], [0], [3, 0, 1, 2, 9], [-1, -1], [0, 0, 0]])
def test_cells_that_make_no_surface(cells):
    with pytest.raises(isoembed.InvalidMetric):
        isoembed.PolyhedralMetric.from_pyvista(SimpleNamespace(points=CUBE, faces=np.array(cells, dtype=int)))
