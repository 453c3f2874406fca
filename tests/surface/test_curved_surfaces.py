"""Surfaces in hyperbolic and spherical space: measures of spheres and solids; isometries; Schlaefli."""

import numpy as np
import pytest

import curved
import isoembed
import zoo
from isoembed import Hyperbolic, InvalidParameter, PolyhedralMetric, Space, Spherical
from isoembed.embedding.embedding import Embedding
from isoembed.mesh.triangulation import Triangulation
from isoembed.space.models import from_model, to_model
from isoembed.surface import alignment, convexity, curvature, measures

SPACES = [Hyperbolic(1.0), Hyperbolic(0.2), Spherical(0.4), Hyperbolic(1e-14), Spherical(1e-300)]


def metric_of(x, faces, space):
    t = Triangulation(faces)
    a, b = t.edges.T
    return PolyhedralMetric(faces, space.distances(x[a], x[b]), curvature=space.curvature)


def embedding(x, faces, space, **options):
    return Embedding(metric_of(x, faces, space), x, **({"method": "test", "tolerance": 1e-10} | options))


def measured(t, x, space):
    """Area, volume, int H dA, bending energy, dihedral angles."""
    return [
        measures.area(t.faces, x, space),
        measures.volume(t.faces, x, space),
        curvature.integrated_mean_curvature(t, x, space),
        curvature.bending_energy(t, x, space=space),
        *curvature.dihedral_angles(t, x, space),
    ]


@pytest.mark.parametrize("space", SPACES, ids=repr)
def test_spheres(space):
    """Radius 1; errors fall with the square of the edge length."""
    k, r, off = space.curvature, 1.0, []
    sn, cs = float(space.sn(r)), float(space.cs(r))
    ball = 4 * np.pi * (r - sn * cs) / (2 * k) if abs(k) > 1e-3 else 4 * np.pi / 3
    exact = np.array([4 * np.pi * sn**2, ball, 4 * np.pi * sn * cs, 4 * np.pi])
    for level in (2, 3):
        x, faces = zoo.icosphere(level)
        off.append(np.array(measured(Triangulation(faces), sn * x, space)[:4]) / exact - 1)
    assert np.abs(off[1][:3]).max() < 0.02
    assert off[0][:2] / off[1][:2] == pytest.approx(4, rel=0.05)
    assert abs(off[1][2]) < abs(off[0][2]) / 3.5
    assert 0 < off[1][3] < off[0][3] / 3.5 < 0.01


@pytest.mark.parametrize("space", SPACES, ids=repr)
def test_isometries_and_scales_change_nothing(space):
    x, faces = zoo.random_hull(25, 1)
    t = Triangulation(faces)
    moved = space.translated(x, np.array([0.3, -0.2, 0.1])) @ zoo.rotation(1)
    assert measured(t, moved, space) == pytest.approx(measured(t, x, space), rel=1e-11)
    assert alignment.distance(moved, x, space) < 3e-15
    one, twice = measured(t, x, space), measured(t, 2 * x, space.scaled(2.0))
    assert np.array(twice[:3]) / one[:3] == pytest.approx([4, 8, 2], rel=1e-14)


@pytest.mark.parametrize("curvature_of_space", [-1.0, 0.3])
@pytest.mark.parametrize("size", [0.1, 3.0])
def test_faces_may_be_cut(curvature_of_space, size):
    space = Space(curvature_of_space)
    x, faces, _ = curved.body(12, 0, curvature_of_space, size)
    y, finer = zoo.subdivided(to_model(space, x, "projective"), faces)
    y = from_model(space, y, "projective")
    t, u = Triangulation(faces), Triangulation(finer)
    assert measured(u, y, space)[:3] == pytest.approx(measured(t, x, space)[:3], rel=1e-12)
    assert not convexity.concave_edges(u, y, space).any()
    flat = np.abs(curvature.dihedral_angles(u, y, space)) < 1e-10
    assert flat.sum() == 3 * len(faces)


@pytest.mark.parametrize("curvature_of_space", [-1.0, 0.5])
def test_schlaefli(curvature_of_space):
    """With exterior angles: ``2 k dV = - sum l dtheta``."""
    space = Space(curvature_of_space)
    x, faces = zoo.random_hull(12, 3)
    t, d, h = Triangulation(faces), np.random.default_rng(0).standard_normal(x.shape), 1e-4

    def change(value):
        return (value(x + h * d) - value(x - h * d)) / (2 * h)

    volume = change(lambda y: measures.volume(faces, y, space))
    angles = change(lambda y: curvature.dihedral_angles(t, y, space))
    lengths = measures.edge_lengths(t.edges, x, space)
    assert -lengths @ angles == pytest.approx(2 * curvature_of_space * volume, rel=1e-5)


def test_the_ideal_limit_of_the_regular_tetrahedron():
    """Its volume tends to 3 Lambda(pi/3) = 1.0149416064096536, with dihedral angles of pi/3."""
    x, faces = zoo.tetrahedron()
    space, r = Hyperbolic(1.0), 9.0
    x = np.sinh(r) * x / np.linalg.norm(x, axis=1)[:, None]
    assert measures.volume(faces, x, space) == pytest.approx(1.0149416064096536, abs=1e-5)
    theta = curvature.dihedral_angles(Triangulation(faces), x, space)
    assert theta == pytest.approx(np.full(6, np.pi - np.pi / 3), abs=1e-4)


def test_the_spherical_simplex():
    """A sixteenth of the 3-sphere, with right dihedral angles, moved to be about the origin: 2 pi^2 / 16."""
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])  # and w = 1, 0, 0, 0
    c = np.full(3, 0.5)
    w = 1 - np.abs(corners).sum(axis=1)  # of the corners; the centroid has w = 1/2, too
    x = corners - c[None] * (w + corners @ c / 1.5)[:, None]
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    space = Spherical(1.0)
    if measures.volume(faces, to_model(space, x, "projective")) < 0:
        faces = faces[:, ::-1]
    assert measures.volume(faces, x, space) == pytest.approx(np.pi**2 / 8, rel=1e-12)
    assert measures.area(faces, x, space) == pytest.approx(4 * np.pi / 2, rel=1e-12)
    assert curvature.dihedral_angles(Triangulation(faces), x, space) == pytest.approx(np.full(6, np.pi / 2))


@pytest.mark.parametrize("space", SPACES[:3], ids=repr)
def test_embeddings(space):
    x, faces, _ = curved.body(30, 0, space.curvature, 2.0)
    surface = embedding(x, faces, space)
    assert surface.space == space
    assert surface.residual < 1e-15
    assert not surface.surface.concave_edges.any()
    assert not surface.surface.rough_edges.any()
    assert not len(surface.surface.self_intersections)
    mirrored = embedding(x * [-1, 1, 1], faces, space)
    assert mirrored.volume == pytest.approx(surface.volume, rel=1e-12)
    moved = embedding(space.translated(x, np.array([0.2, 0.1, 0.0])), faces, space)
    assert surface.distance(moved) < 1e-14
    assert isoembed.Sensitivity(moved).smallest_singular_value == pytest.approx(
        isoembed.Sensitivity(surface).smallest_singular_value, rel=5e-3
    )
    assert moved.mean_curvature == pytest.approx(surface.mean_curvature, rel=1e-10)
    report = isoembed.report(surface)
    assert report["space"] == {"name": space.name, "curvature": space.curvature, "model": "conformal"}
    assert report["residual"]["max"] == surface.residual


def test_an_embedding_in_another_unit():
    space = Hyperbolic(0.5)
    x, faces = zoo.random_hull(20, 2)
    metric = metric_of(x, faces, space).scaled(1e-9)
    normalized = metric.normalized
    found = Embedding(normalized, 1e-9 * x / metric.unit, method="test", tolerance=1e-10)
    surface = found._in_unit_of(metric)
    assert surface.space == metric.space
    assert surface.space.curvature == pytest.approx(-0.5e18)
    assert surface.vertices == pytest.approx(1e-9 * x, rel=1e-14)
    again = Embedding(metric, surface.vertices, method="test", tolerance=1e-10)
    assert (surface.area, surface.volume) == (again.area, again.volume)
    assert np.array_equal(surface.mean_curvature, again.mean_curvature)


def test_dents_are_counted():
    space = Hyperbolic(1.0)
    x, faces = zoo.icosphere(2)
    dented = x.copy()
    dented[100] *= 0.8
    surface = embedding(dented, faces, space)
    assert np.flatnonzero(surface.surface.inverted_vertices).tolist() == [100]
    assert convexity.dent_depths(surface.triangulation, dented, space).max() > 0.1


def test_surfaces_that_cross_themselves():
    x, faces = zoo.icosphere(1)
    x[0] *= -3.0
    surface = embedding(x, faces, Hyperbolic(1.0))
    assert len(surface.surface.self_intersections)


def test_points_beyond_the_half_of_the_sphere():
    x, faces = zoo.random_hull(10, 0)
    metric = metric_of(x, faces, Spherical(0.5))
    with pytest.raises(InvalidParameter, match="point 3 is 3 from the center of the ambient model"):
        Embedding(metric, np.where(np.arange(10)[:, None] == 3, [3.0, 0, 0], x), method="test", tolerance=1.0)


def test_curvature_to_zero_is_linear():
    x, faces = zoo.random_hull(20, 4)
    t = Triangulation(faces)
    flat = np.array(measured(t, x, Space(0.0))[:3])
    off = [np.array(measured(t, x, Space(k))[:3]) - flat for k in (-1e-4, -1e-5)]
    assert off[0] / off[1] == pytest.approx(10, rel=1e-3)
