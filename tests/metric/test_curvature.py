"""Angles, deficits, dual areas, Gaussian curvature: closed forms, a second way, needles, scales, rates."""

from decimal import Decimal, localcontext
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import discs
import zoo
from curved import body
from isoembed.metric.curvature import (
    area,
    corner_angles,
    deficits,
    dual_areas,
    face_areas,
    gaussian_curvature,
)
from isoembed.metric.glued import GluedMetric
from isoembed.metric.inspection import inspect
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.space import Space
from regular_in_space import SOLIDS, regular_solid

PLATONIC = {
    # body: (mesh, angles at a vertex, area in squared edges)
    "tetrahedron": (zoo.tetrahedron(), 3, 3**0.5),
    "octahedron": (zoo.octahedron(), 4, 2 * 3**0.5),
    "icosahedron": (zoo.icosahedron(), 5, 5 * 3**0.5),
}


@pytest.mark.parametrize(("mesh", "degree", "squares"), PLATONIC.values(), ids=PLATONIC.keys())
def test_platonic_bodies_of_triangles(mesh, degree, squares):
    metric = PolyhedralMetric.from_mesh(*mesh)
    size = metric.mean_length
    n = metric.triangulation.n_vertices
    assert corner_angles(metric) == pytest.approx(np.pi / 3, rel=1e-14)
    assert deficits(metric) == pytest.approx(2 * np.pi - degree * np.pi / 3, rel=1e-13)
    assert face_areas(metric) == pytest.approx(3**0.5 / 4 * size**2, rel=1e-14)
    assert area(metric) == pytest.approx(squares * size**2, rel=1e-14)
    assert dual_areas(metric) == pytest.approx(squares * size**2 / n, rel=1e-14)
    assert gaussian_curvature(metric) == pytest.approx(4 * np.pi / (squares * size**2), rel=1e-13)


def test_cube():
    metric = PolyhedralMetric.from_mesh(*zoo.cube())
    angles = np.sort(corner_angles(metric), axis=1)
    assert angles == pytest.approx(np.tile([np.pi / 4, np.pi / 4, np.pi / 2], (12, 1)), rel=1e-14)
    assert deficits(metric) == pytest.approx(np.pi / 2, rel=1e-13)
    # However the squares are cut, a square's circumcenter is its middle: each corner gets a quarter of it.
    assert dual_areas(metric) == pytest.approx(0.75, rel=1e-14)


def test_four_right_triangles():
    """All faces have sides 3, 4, 5, opposite edges are equal: a rectangle covered twice."""
    metric = PolyhedralMetric(zoo.TETRAHEDRON, [3.0, 4.0, 5.0, 5.0, 4.0, 3.0])
    assert np.sort(corner_angles(metric), axis=1) == pytest.approx(
        np.tile([np.arcsin(0.6), np.arcsin(0.8), np.pi / 2], (4, 1)), rel=1e-14
    )
    assert deficits(metric) == pytest.approx(np.pi, rel=1e-14)
    assert face_areas(metric) == pytest.approx(6.0, rel=1e-14)
    assert dual_areas(metric) == pytest.approx(6.0, rel=1e-14)


@given(n=st.integers(4, 60), seed=st.integers(0, 10**6))
def test_sums(n, seed):
    metric = PolyhedralMetric.from_mesh(*zoo.random_hull(n, seed))
    assert corner_angles(metric).sum(axis=1) == pytest.approx(np.pi, rel=1e-13)
    assert deficits(metric).sum() == pytest.approx(4 * np.pi, rel=1e-12)  # Gauss-Bonnet
    assert deficits(metric).min() > 0  # a convex body
    assert dual_areas(metric).sum() == pytest.approx(area(metric), rel=1e-10)


def test_metrics_have_deficits_and_an_area():
    """A regular octahedron of side 2, a square of side 3, and the octant of a sphere of radius 5, twice."""
    vertices, faces = zoo.octahedron()
    octahedron = PolyhedralMetric.from_mesh(2**0.5 * vertices, faces)
    assert octahedron.deficits == pytest.approx(2 * np.pi / 3, rel=1e-14)
    assert octahedron.area == pytest.approx(8 * 3**0.5, rel=1e-14)
    square = PolyhedralMetric.from_mesh([[0, 0, 0], [3, 0, 0], [3, 3, 0], [0, 3, 0]], [[0, 1, 2], [0, 2, 3]])
    assert square.deficits == pytest.approx(np.pi / 2, rel=1e-14)
    assert square.area == pytest.approx(9, rel=1e-14)
    octants = PolyhedralMetric([[0, 1, 2], [0, 2, 1]], [2.5 * np.pi] * 3, curvature=1 / 25)
    assert octants.deficits == pytest.approx(np.pi, rel=1e-14)
    assert octants.area == GluedMetric.of(octants).area == pytest.approx(25 * np.pi, rel=1e-14)


def test_gauss_bonnet_holds_for_lengths_that_come_from_no_surface():
    _, faces = zoo.icosphere(2)
    t = PolyhedralMetric.from_mesh(*zoo.icosphere(2)).triangulation
    lengths = 1 + 0.4 * np.random.default_rng(0).random(t.n_edges)
    assert deficits(PolyhedralMetric(faces, lengths)).sum() == pytest.approx(4 * np.pi, rel=1e-13)


def by_circumcenters(metric):
    """Lay each triangle in the plane and add up the signed kites corner, midpoint, circumcenter, midpoint."""
    duals = np.zeros(metric.triangulation.n_vertices)
    for face, (ab, bc, ca) in zip(metric.faces, metric.face_lengths, strict=True):
        x = (ab**2 + ca**2 - bc**2) / (2 * ab)
        corners = np.array([0, ab, x + 1j * np.sqrt(ca**2 - x**2)])
        _, b, c = corners
        # Center at equal distance from 0, b, c: Re(conj(b) z) = |b|^2 / 2 and likewise for c.
        rows = [[b.real, b.imag], [c.real, c.imag]]
        center = complex(*np.linalg.solve(rows, [abs(b) ** 2 / 2, abs(c) ** 2 / 2]))
        for k in range(3):
            polygon = [
                corners[k],
                (corners[k] + corners[k - 2]) / 2,
                center,
                (corners[k] + corners[k - 1]) / 2,
            ]
            duals[face[k]] += (
                sum((p.conjugate() * q).imag for p, q in zip(polygon, np.roll(polygon, -1), strict=True)) / 2
            )
    return duals


@pytest.mark.parametrize("seed", range(3))
def test_dual_areas_against_circumcenters_in_the_plane(seed):
    metric = PolyhedralMetric.from_mesh(*zoo.random_hull(40, seed))
    assert corner_angles(metric).max() > np.pi / 2  # obtuse triangles are among them
    assert dual_areas(metric) == pytest.approx(by_circumcenters(metric), rel=1e-9, abs=1e-12)


def test_a_dual_area_may_be_negative():
    tip, base = 1.999, 1.0  # two flat obtuse faces at edge 0-1 whose circumcenters lie far outside
    metric = PolyhedralMetric(zoo.TETRAHEDRON, [tip, 1.0, 1.0, 1.0, 1.0, base / 10])
    assert dual_areas(metric).min() < 0
    assert dual_areas(metric) == pytest.approx(by_circumcenters(metric), rel=1e-7)


@given(seed=st.integers(0, 10**6))
def test_angles_and_areas_against_coordinates(seed):
    vertices, faces = zoo.random_hull(30, seed)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    corners = vertices[faces]
    u, v = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
    cross = np.linalg.norm(np.cross(u, v), axis=2)
    assert corner_angles(metric) == pytest.approx(np.arctan2(cross, (u * v).sum(axis=2)), rel=1e-9)
    assert face_areas(metric) == pytest.approx(cross[:, 0] / 2, rel=1e-8)


def exactly(a, b, c):
    """Area, and tangents of half the angles across from a, b, c, from the given floats, to 60 digits."""
    a, b, c = (Fraction(float(x)) for x in (a, b, c))
    s = (a + b + c) / 2
    parts = [s - a, s - b, s - c]
    with localcontext() as context:
        context.prec = 60

        def root(q):
            return (Decimal(q.numerator) / Decimal(q.denominator)).sqrt()

        tangents = [root(parts[k - 1] * parts[k - 2] / (s * parts[k])) for k in range(3)]
        return float(root(s * parts[0] * parts[1] * parts[2])), [float(t) for t in tangents]


NEEDLES = {
    "needle": (1.0, 1.0, 1e-13),
    "lopsided needle": (1.0, 1.0 + 0.3e-9, 1e-9),
    "cap": (1.0, 0.5 + 1e-13, 0.5 + 1e-13),
    "lopsided cap": (1.0, 0.3 + 1e-14, 0.7 + 1e-14),
    "one rounding": (1.0, 0.75, float(np.nextafter(0.25, 1))),
    "ordinary": (3.0, 3.5, 4.0),
}


@pytest.mark.parametrize("sides", NEEDLES.values(), ids=NEEDLES.keys())
@pytest.mark.parametrize("scale", [2.0**-500, 1.0, 2.0**40])
@pytest.mark.parametrize("turn", range(3))
def test_needles_and_caps_keep_their_digits(sides, scale, turn):
    """All four faces alike (opposite edges equal), against rational arithmetic on the same floats."""
    a, b, c = np.roll(sides, turn)
    metric = PolyhedralMetric(zoo.TETRAHEDRON, np.array([a, b, c, c, b, a]) * scale)
    square, halves = exactly(a, b, c)
    # Face 0 is (0, 1, 2) with sides 01 = a, 12 = c, 20 = b.
    angle_across = 2 * np.arctan(halves)
    assert corner_angles(metric)[0] == pytest.approx(angle_across[[2, 1, 0]], rel=4e-15, abs=0)
    if scale > 1e-100:  # else the square underflows
        assert face_areas(metric) == pytest.approx(square * scale**2, rel=4e-15, abs=0)


@given(seed=st.integers(0, 10**6), exponent=st.sampled_from([-150, -12, 12, 150]))
def test_scaling(seed, exponent):
    vertices, faces = zoo.random_hull(20, seed)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    scaled = metric.with_lengths(metric.lengths * 10.0**exponent)
    assert corner_angles(scaled) == pytest.approx(corner_angles(metric), rel=1e-11)
    assert deficits(scaled) == pytest.approx(deficits(metric), rel=1e-9, abs=1e-13)
    unit = 10.0**exponent
    assert dual_areas(scaled) / unit / unit == pytest.approx(dual_areas(metric), rel=1e-7, abs=1e-12)
    assert gaussian_curvature(scaled) * unit * unit == pytest.approx(gaussian_curvature(metric), rel=1e-7)


@given(seed=st.integers(0, 10**6))
def test_labels_and_orientation_change_nothing(seed):
    vertices, faces = zoo.random_hull(25, seed)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    points, other, new = zoo.relabeled(vertices, faces, seed)
    for twin, number in [
        (PolyhedralMetric.from_mesh(points, other), new),
        (PolyhedralMetric.from_mesh(vertices, faces[:, ::-1]), np.arange(25)),
    ]:
        assert deficits(twin)[number] == pytest.approx(deficits(metric), rel=1e-10)
        assert dual_areas(twin)[number] == pytest.approx(dual_areas(metric), rel=1e-8, abs=1e-12)
        assert area(twin) == pytest.approx(area(metric), rel=1e-11)


@pytest.mark.parametrize("size", [2.0**-1000, 2.0**-500, 2.0**500, 2.0**1000])
def test_measures_beyond_the_floats_are_infinite_or_zero(size):
    """Without a warning; the others are exact in powers of two."""
    metric = PolyhedralMetric.from_mesh(*zoo.octahedron())
    large = metric.scaled(size)
    for areas in (face_areas, dual_areas, area):
        with np.errstate(over="ignore"):
            expected = areas(metric) * size * size
        np.testing.assert_array_equal(areas(large), expected)
    with np.errstate(over="ignore"):
        expected = gaussian_curvature(metric) / size / size
    np.testing.assert_array_equal(gaussian_curvature(large), expected)
    assert GluedMetric.of(large).area == float(area(metric)) * size * size
    measures = {one.name: one for one in inspect(large).measures}
    assert float(measures["deficits"].text.split("4 pi to ")[1]) < 1e-14


def test_gaussian_curvature_is_unknown_on_a_boundary():
    """Where deficits are the exterior angles of the boundary."""
    points, faces = discs.hexagonal(8)
    metric = PolyhedralMetric.from_mesh(discs.round_cap(points, 1.0), faces)
    found, rim = gaussian_curvature(metric), metric.triangulation.boundary_vertices
    assert np.isnan(found[rim]).all()
    assert found[~rim] == pytest.approx(1.0, rel=0.1)


def test_gaussian_curvature_and_area_converge_on_the_sphere():
    errors, sizes = [], []
    for level in (2, 3, 4):
        metric = PolyhedralMetric.from_mesh(*zoo.icosphere(level))
        curvature = np.average(gaussian_curvature(metric), weights=dual_areas(metric))
        errors.append([abs(curvature - 1), 4 * np.pi - area(metric)])
        sizes.append(metric.mean_length)
    rates = np.diff(np.log(errors), axis=0) / np.diff(np.log(sizes))[:, None]
    assert rates == pytest.approx(2.0, abs=0.1)  # second order in the edge length


def test_deficits_have_the_derivative_that_the_cotangents_say():
    """Conformal change at one vertex, ``l_ij e^{(u_i + u_j) / 2}``: d(deficit_i)/du_j = -(cot + cot) / 2."""
    metric = PolyhedralMetric.from_mesh(*zoo.random_hull(15, 4))
    t, step = metric.triangulation, 1e-6

    def moved(j, u):
        factor = np.exp(u / 2 * (t.edges == j).sum(axis=1))
        return deficits(metric.with_lengths(metric.lengths * factor))

    angles = corner_angles(metric)
    face, corner = np.divmod(t.edge_halfedges, 3)
    weights = (1 / np.tan(angles[face, (corner + 2) % 3])).sum(axis=1) / 2
    laplacian = np.zeros((t.n_vertices, t.n_vertices))
    i, j = t.edges.T
    laplacian[i, j] = laplacian[j, i] = -weights
    laplacian -= np.diag(laplacian.sum(axis=1))
    numeric = [(moved(k, step) - moved(k, -step)) / (2 * step) for k in range(t.n_vertices)]
    assert np.array(numeric) == pytest.approx(laplacian, abs=1e-7)


@pytest.mark.parametrize("which", SOLIDS, ids=str)
def test_regular_solids_of_curved_spaces(which):
    solid, k = regular_solid(*which), which[1]
    metric = PolyhedralMetric.from_mesh(solid.points, solid.faces, curvature=k)
    sides = metric.lengths.min()
    assert sides == pytest.approx(solid.edge, rel=1e-13)
    assert deficits(metric) == pytest.approx(solid.deficit, rel=1e-12)
    assert area(metric) == pytest.approx(solid.area, rel=1e-12)
    if len(solid.faces[0]) <= 4:  # however squares are cut
        assert dual_areas(metric) == pytest.approx(solid.area / len(solid.points), rel=1e-12)
        assert gaussian_curvature(metric) == pytest.approx(
            k + solid.deficit * len(solid.points) / solid.area, rel=1e-12
        )


@given(n=st.integers(4, 60), seed=st.integers(0, 10**6), k=st.sampled_from([-1.0, 0.3, -1e-12, 1e-300]))
def test_sums_in_curved_spaces(n, seed, k):
    x, faces, _ = body(n, seed, k, 2.0)
    metric = PolyhedralMetric.from_mesh(x, faces, curvature=k)
    assert deficits(metric).sum() == pytest.approx(4 * np.pi - k * area(metric), rel=1e-12)
    assert deficits(metric).min() > 0
    assert dual_areas(metric).sum() == pytest.approx(area(metric), rel=1e-10)


def test_curved_triangles_tend_to_flat_ones():
    flat = PolyhedralMetric.from_mesh(*zoo.random_hull(40, 1))

    def off(measure, k):
        curved = measure(PolyhedralMetric.on(flat.triangulation, flat.lengths, Space(k)))
        return np.abs(curved / measure(flat) - 1).max()

    for measure in (corner_angles, face_areas, dual_areas):
        assert off(measure, -1e-3) / off(measure, -1e-4) == pytest.approx(10, rel=0.01)
        assert off(measure, 1e-3) / off(measure, -1e-3) == pytest.approx(1, rel=0.05)
        assert off(measure, 1e-40) < 1e-13


@pytest.mark.parametrize("k", [-1.0, 1.0])
@pytest.mark.parametrize("base", [1e-14, 1e-7, 0.3, 2.0])
def test_isosceles_triangles(k, base):
    """Half of one has a right angle: ``sin(A / 2) = sn(a / 2) / sn(b)``, ``cos(B) = tn(a / 2) / tn(b)``."""
    space, b = Space(k), 1.25
    metric = PolyhedralMetric(zoo.TETRAHEDRON, [b, b, b, base, base, base], curvature=k)
    angles = np.sort(corner_angles(metric)[(metric.faces == 0).any(axis=1)], axis=1)
    at_apex = 2 * np.arcsin(space.sn(np.array(base / 2)) / space.sn(np.array(b)))
    tn = [space.sn(x) / space.cs(x) for x in np.array([base / 2, b])]
    expected = np.sort([at_apex, *[np.arccos(tn[0] / tn[1])] * 2])
    assert angles == pytest.approx(np.tile(expected, (3, 1)), rel=1e-14)


def by_circumcenters_on_the_sphere(metric):
    """Signed kites between corner, middles and circumcenter, by solid angles."""
    duals, triangles = np.zeros(metric.triangulation.n_vertices), np.eye(3)

    def solid_angle(a, b, c):
        return 2 * np.arctan2(a @ np.cross(b, c), 1 + a @ b + b @ c + c @ a)

    for face, (ab, bc, ca) in zip(metric.faces, metric.face_lengths, strict=True):
        cosine = (np.cos(bc) - np.cos(ab) * np.cos(ca)) / (np.sin(ab) * np.sin(ca))
        y = np.array([cosine, np.sqrt(1 - cosine**2)]) * np.sin(ca)
        p = np.array([triangles[2], [np.sin(ab), 0, np.cos(ab)], [*y, np.cos(ca)]])
        center = np.cross(p[1] - p[0], p[2] - p[0])
        center /= np.linalg.norm(center)
        for k in range(3):
            after, before = ((q := p[k] + p[k + m]) / np.linalg.norm(q) for m in (-2, -1))
            duals[face[k]] += solid_angle(p[k], after, center) + solid_angle(p[k], center, before)
    return duals


def test_dual_areas_against_circumcenters_on_the_sphere():
    x, faces, _ = body(30, 4, 1.0, 2.4)
    metric = PolyhedralMetric.from_mesh(x, faces, curvature=1.0)
    assert corner_angles(metric).max() > 2
    assert dual_areas(metric) == pytest.approx(by_circumcenters_on_the_sphere(metric), rel=1e-9, abs=1e-11)


def test_triangles_without_a_circumcenter_are_shared_in_thirds():
    metric = PolyhedralMetric(zoo.TETRAHEDRON, [3.0, 3.0, 3.0, 5.0, 5.0, 5.0], curvature=-1.0)
    assert dual_areas(metric).sum() == pytest.approx(area(metric), rel=1e-14)
    assert dual_areas(metric)[0] == pytest.approx(
        face_areas(metric)[(metric.faces == 0).any(axis=1)].sum() / 3
    )
