"""Surfaces with boundary and the torus: closed forms against quadrature, and their meshes."""

import numpy as np
import pytest

from isoembed import InvalidParameter, PolyhedralMetric
from isoembed.gallery import SURFACES, Cap, Catenoid, Cone, Enneper, Torus, triangulate
from isoembed.meshing.flips import corner_angles
from isoembed.meshing.sphere import directions_at
from isoembed.meshing.zone import ZoneLayout
from isoembed.surface.measures import face_areas

ZOO = (
    *(Cap(), Cap(2.0, 2.9), Cone(), Cone(1.0, 0.2, 3.0), Catenoid(), Catenoid(0.5, 4.0)),
    *(Enneper(), Enneper(1.7), Torus(), Torus(3.0, 2.0)),
)


def forms(surface, theta, phi):
    """First and second fundamental forms (n, 2, 2) by differences of fourth order."""

    def X(i, j):
        u = directions_at(np.cos(theta + i * h), phi + j * h)
        return surface._unit * surface._points(u)

    h = 1e-3
    weights = {-2: 1 / 12, -1: -2 / 3, 1: 2 / 3, 2: -1 / 12}
    tangents = [sum(w * X(k * a, k * b) for k, w in weights.items()) / h for a, b in ((1, 0), (0, 1))]
    seconds = {-2: -1 / 12, -1: 4 / 3, 0: -5 / 2, 1: 4 / 3, 2: -1 / 12}
    tt, pp, both = (
        sum(w * X(k * a, k * b) for k, w in seconds.items()) / h**2 for a, b in ((1, 0), (0, 1), (1, 1))
    )
    normal = np.cross(*tangents)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    tp = 0.5 * (both - tt - pp)
    first_form = np.einsum("ani,bni->nab", np.array(tangents), np.array(tangents))
    second = np.einsum("abni,ni->nab", np.array([[tt, tp], [tp, pp]]), normal)
    return first_form, second


@pytest.mark.parametrize("surface", ZOO, ids=repr)
def test_energies_and_area_are_those_of_the_fundamental_forms(surface):
    nodes, weights = np.polynomial.legendre.leggauss(24)
    start, stop = surface.zone
    theta = 0.5 * (start + stop) + 0.5 * (stop - start) * nodes
    theta, phi = (a.ravel() for a in np.meshgrid(theta, 2 * np.pi * np.arange(32) / 32, indexing="ij"))
    first_form, second = forms(surface, theta, phi)
    dA = np.sqrt(np.linalg.det(first_form)) * np.repeat(weights, 32) * (stop - start) / 2 * 2 * np.pi / 32
    shape = np.linalg.solve(first_form, second)
    H = np.trace(shape, axis1=1, axis2=2) / 2
    assert surface.area == pytest.approx(dA.sum(), rel=1e-6)
    assert surface.bending_energy == pytest.approx(dA @ H**2, rel=1e-5, abs=1e-6)
    squares = np.trace(shape @ shape, axis1=1, axis2=2)
    assert surface.second_form_energy == pytest.approx(dA @ squares, rel=1e-5)


@pytest.mark.parametrize("surface", ZOO, ids=repr)
def test_the_first_fundamental_form_is_that_of_the_points(surface):
    theta = np.linspace(*surface.zone, 7)[1:-1]
    phi = np.linspace(0.3, 5.0, 5)
    u = directions_at(np.cos(theta), phi)
    first_form, _ = forms(surface, theta, phi)
    e_theta = np.stack([np.cos(theta) * np.cos(phi), np.cos(theta) * np.sin(phi), -np.sin(theta)], axis=1)
    e_phi = np.sin(theta)[:, None] * np.stack([-np.sin(phi), np.cos(phi), 0 * phi], axis=1)
    v = np.stack([e_theta, e_phi], axis=1)
    found = np.einsum("nai,nij,nbj->nab", v, surface._tensor(u), v) * surface._unit**2
    np.testing.assert_allclose(found, first_form, rtol=1e-8, atol=1e-8 * np.abs(first_form).max())


@pytest.mark.parametrize("surface", [*ZOO[:-1], Torus(2.0, 1.0)], ids=repr)
@pytest.mark.parametrize("n", [40, 400])
def test_triangles_are_nearly_equilateral_and_vertices_on_the_surface(surface, n):
    x, faces = triangulate(surface, n)
    t = PolyhedralMetric.from_mesh(x, faces).triangulation
    assert t.n_vertices == len(x) == n
    closed = isinstance(surface, Torus)
    assert (t.genus, len(t.boundaries)) == ((1, 0) if closed else (0, sum(z > 0 for z in surface.zone)))
    angles = np.degrees(corner_angles(x, faces))
    assert angles.min() > (33 if n == 400 else 15)
    assert angles.max() < (101 if n == 400 else 125)
    rim = sum(map(len, t.boundaries))
    assert set(np.concatenate([*t.boundaries, np.zeros(0)]).astype(int)) == set(range(rim))
    for loop in t.boundaries:
        sides = np.linalg.norm(x[loop] - x[np.roll(loop, 1)], axis=1)
        assert sides.max() < 1.15 * sides.min()


def test_areas_of_meshes_converge_with_the_second_order():
    errors = []
    for n in (100, 1600):
        x, faces = triangulate(Enneper(), n)
        errors.append(abs(face_areas(faces, x).sum() / Enneper().area - 1))
    assert errors[0] < 0.01
    assert 3.2 < np.log2(errors[0] / errors[1]) < 4.8


def test_irregular_meshes_differ_with_the_seed_and_keep_the_boundary():
    one, again, other = (triangulate(Catenoid(), 200, irregular=seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(one[0], again[0])
    t = PolyhedralMetric.from_mesh(*one).triangulation
    rim = sum(map(len, t.boundaries))
    np.testing.assert_array_equal(one[0][:rim], other[0][:rim])
    assert np.abs(one[0][rim:] - other[0][rim:]).max() > 0.1
    angles = np.degrees(corner_angles(*one))
    assert 10 < angles.min() < 30


@pytest.mark.parametrize("scale", [1e-150, 1e100])
def test_the_unit_does_not_matter(scale):
    for one, other in (
        (Cap(), Cap(scale)),
        (Cone(), Cone(0.8, 0.3 * scale, scale)),
        (Catenoid(), Catenoid(scale, 2 * scale)),
        (Torus(), Torus(2 * scale, 0.8 * scale)),
    ):
        x, faces = triangulate(one, 60)
        y, again = triangulate(other, 60)
        np.testing.assert_array_equal(faces, again)
        np.testing.assert_allclose(y / scale, x, rtol=1e-9, atol=1e-12)
        assert other.area / scale / scale == pytest.approx(one.area, rel=1e-12)
        assert other.bending_energy == pytest.approx(one.bending_energy, rel=1e-12)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Cap(angle=3.2), "cap: angle must be less than 3.1, not 3.2"),
        (lambda: Cap(radius=0), "cap: radius must be positive, not 0.0"),
        (lambda: Cone(1.5), "cone: slope must be at most 1, not 1.5"),
        (lambda: Cone(0.5, 2.0, 1.0), "cone: inner must be at most 0.999 outer = 0.999, not 2.0"),
        (lambda: Catenoid(1.0, 20.0), "catenoid: height must be at most 10 waist = 10, not 20.0"),
        (lambda: Enneper(2.0), "enneper: radius must be at most 1.7, not 2.0"),
        (lambda: Torus(1.0, 1.0), "torus: tube must be at most 0.999 ring = 0.999, not 1.0"),
    ],
)
def test_bad_parameters_are_named(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_too_few_vertices_for_the_boundaries():
    with pytest.raises(InvalidParameter, match="20 vertices are too few: nearly equilateral triangles"):
        triangulate(Cone(1.0, 0.99, 1.0), 20)


def test_number_and_size_of_edges_are_inverse():
    for name in ("cap", "cone", "torus"):
        surface = SURFACES[name]()
        layout = ZoneLayout(
            surface.zone, surface._tensor, surface._area_density, lambda u: np.ones(len(u)), surface.is_ring
        )
        for n in (30, 3000):
            assert layout.vertices(layout.size(n)) == pytest.approx(n, rel=1e-12)
