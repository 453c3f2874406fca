"""Surfaces with boundary and of higher genus, against closed forms and discarded coordinates."""

import re
from dataclasses import replace

import numpy as np
import pytest

import discs
import isoembed
import smooth_bodies
import zoo
from isoembed import (
    Embedding,
    InvalidMetric,
    InvalidParameter,
    NotEmbedded,
    PolyhedralMetric,
    Sheet,
    SheetEmbedding,
    embed,
    realizations,
)
from isoembed.cli.summary import summary
from isoembed.metric.conformal_sphere import conformal_sphere
from isoembed.metric.dents import dents
from isoembed.metric.least_space import least_convex_space
from isoembed.surface.alignment import aligned, distance

CAP = 2 * np.pi * (1 - np.cos(1))  # int H^2 of a round cap


def cap(points, faces, angle=1.0):
    x = discs.round_cap(points, angle)
    return x, PolyhedralMetric.from_mesh(x, faces)


def apart(x, y):
    """As `distance`, of mirror images, too: surfaces with boundary have no outside."""
    return min(distance(x, y), distance(x * [1, 1, -1], y))


def rim(metric):
    return np.concatenate(metric.triangulation.boundaries)


def bumpy(points):
    x, y = points.T
    return np.column_stack([points, 0.25 * np.sin(2.2 * x + 0.3) * np.cos(1.9 * y) + 0.1 * x * y])


@pytest.mark.parametrize("mesh", [discs.hexagonal(6), discs.irregular(200)], ids=["hexagonal", "irregular"])
def test_convex_cap(mesh):
    x, metric = cap(*mesh)
    found = embed(metric.scaled(7.5), boundary="plane")
    assert isinstance(found, SheetEmbedding)
    assert found.residual < 1e-13
    # Irregular triangles are not those of the convex polyhedron: some of the edges are concave.
    assert (found.uniqueness is not None) == (not found.surface.concave_edges.any()) == (len(x) == 127)
    assert np.ptp(found.vertices[rim(metric), 2]) < 1e-12
    assert distance(found.vertices / 7.5, x) < 1e-12


@pytest.mark.parametrize("how", [{"boundary": "free"}, {}, {"method": "alexandrov"}])
def test_surfaces_with_boundary_in_curved_space_are_refused(how):
    square = PolyhedralMetric([[0, 1, 2], [0, 2, 3]], [1.0] * 5, curvature=-1.0)
    with pytest.raises(
        (InvalidMetric, InvalidParameter), match=r"handles are embedded in R\^3 only, with flat tr"
    ):
        embed(square, **how)


def test_volume_of_a_cap_is_that_over_the_plane_of_its_boundary():
    exact, off = np.pi / 3 * (2 + np.cos(1)) * (1 - np.cos(1)) ** 2, []
    for rings in (5, 10):
        points, faces = discs.hexagonal(rings)
        found = embed(cap(points, faces)[1].scaled(3.0), boundary="plane")
        off.append(found.volume / 27 / exact - 1)
        assert isoembed.report(found)["volume"] == found.volume
        for image in (found.vertices * [1, 1, -1], found.vertices + np.array([5, -3, 7])):
            assert replace(found, vertices=image).volume == pytest.approx(found.volume, rel=1e-12)
    assert abs(off[1]) < abs(off[0]) / 3
    square = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]
    pyramid = embed(PolyhedralMetric(square, [1.0] * 8), boundary="plane")
    assert pyramid.volume == pytest.approx(1 / (3 * 2**0.5), rel=1e-12)
    assert "volume      0.235702" in summary(pyramid, isoembed.report(pyramid))
    with pytest.raises(InvalidMetric, match="boundary"):
        _ = replace(pyramid, vertices=pyramid.vertices @ zoo.rotation(1)).volume


def test_energies_of_a_round_cap_converge_from_either_side():
    """k1^2 + k2^2 is 2 K here, and of meshes either number may be the smaller."""
    exact, off = 4 * np.pi * (1 - np.cos(1)), []
    for mesh in (discs.hexagonal(5), discs.hexagonal(10)):
        found = embed(cap(*mesh)[1], boundary="plane")
        off.append([found.second_form_energy / exact - 1, 2 * found.total_absolute_curvature / exact - 1])
        sheet = isoembed.report(found)["sheet"]
        assert sheet["second_form_energy"] == found.second_form_energy
        assert sheet["total_absolute_curvature"] == found.total_absolute_curvature
    assert (np.abs(off[1]) < np.abs(off[0]) / 3).all()
    text = summary(found, isoembed.report(found))
    assert f"int H^2 dA {found.surface.bending_energy:.4g}" in text and "bending energy" not in text


@pytest.mark.parametrize("angle", [0.5, 1.5])
def test_least_bending_of_a_round_cap(angle):
    _, metric = cap(*discs.hexagonal(10), angle)
    found = embed(metric, boundary="free")
    assert found.residual < 1e-13
    assert found.imbalance < 1e-8
    assert found.uniqueness.kind == "searched"
    assert found.surface.bending_energy == pytest.approx(2 * np.pi * (1 - np.cos(angle)), rel=0.01)
    bent = [found.surface.bending_energy, embed(metric, boundary="plane").surface.bending_energy]
    assert bent[0] < bent[1]
    assert found.tensions.shape == metric.lengths.shape


@pytest.mark.parametrize("unit", [1e-200, 1e200])
def test_integrated_mean_curvature_of_tiny_and_huge_sheets(unit):
    faces = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]
    one, other = (embed(PolyhedralMetric(faces, [each] * 8), boundary="plane") for each in (1.0, unit))
    expected = one.integrated_mean_curvature
    assert expected > 1.0
    assert other.integrated_mean_curvature / unit == pytest.approx(expected, rel=1e-12)
    assert other.mean_curvature * unit == pytest.approx(one.mean_curvature, rel=1e-12)


def test_least_bending_does_not_depend_on_numbers_mirror_or_unit():
    points, faces = discs.irregular(120)
    x, metric = cap(points, faces)
    energy = embed(metric, boundary="free").surface.bending_energy
    new = np.random.default_rng(0).permutation(len(x))
    moved = np.empty_like(x)
    moved[new] = x
    for other in (
        PolyhedralMetric.from_mesh(moved, new[faces]),
        PolyhedralMetric.from_mesh(x, faces[:, ::-1]),
        metric.scaled(1e-3),
    ):
        assert embed(other, boundary="free").surface.bending_energy == pytest.approx(energy, rel=1e-8)


def test_bending_that_is_no_minimum_is_said():
    start = np.random.default_rng(0).normal(size=(len(DISC), 3))
    found = embed(ROUND, boundary="free", start=start)
    assert found.residual < 1e-12
    assert ("not at a minimum" in found.message) == (found.imbalance > 1e-6)
    assert embed(ROUND, boundary="free").message.endswith(
        "found from one start: other surfaces may bend less"
    )


def test_an_energy_below_that_of_all_smooth_surfaces_is_said():
    """A coarse catenoid: int k1^2 + k2^2 is 2 int |K| of it."""
    for count, is_coarse in ((12, True), (36, False)):
        x, faces = discs.band(count, round(0.4 * count), lambda t: (np.cosh(1.5 * t - 0.75), 1.5 * t))
        found = embed(PolyhedralMetric.from_mesh(x, faces), boundary="free")
        exact = 8 * np.pi * np.tanh(0.75)
        assert 2 * found.total_absolute_curvature == pytest.approx(exact, rel=0.08 if is_coarse else 0.02)
        assert ("too coarse to determine the bending energy" in found.message) == is_coarse
        assert "of least bending is not proven" in isoembed.certify(found).reason


def test_a_flat_disc_stays_flat():
    points, faces = discs.irregular(100)
    x = np.column_stack([points, 0 * points[:, 0]])
    found = embed(PolyhedralMetric.from_mesh(x, faces), boundary="free")
    assert found.second_form_energy < 1e-12
    assert distance(found.vertices, x) < 1e-9
    # Nothing bends less: forces that are left, and other starts, are no matter.
    assert replace(found, imbalance=1e-5).message.endswith(
        f"{found.edges[found.residuals.argmax()].tolist()}"
    )


def test_hyperbolic_disc():
    """Gemmer and Venkataramani's bounds on int k1^2 + k2^2 at radius 1 are 6.825 and 7.774."""
    points, faces = discs.hexagonal(8)
    edges = PolyhedralMetric.from_mesh(discs.round_cap(points, 1.0), faces).edges
    metric = PolyhedralMetric(faces, discs.hyperbolic_lengths(points, 1.0, edges), edges)
    found = embed(metric, boundary="free")
    assert found.residual < 1e-10
    assert 0.97 * 6.825 < found.second_form_energy < 7.774  # of a coarse mesh


@pytest.mark.slow
def test_forces_are_balanced_on_irregular_meshes_of_negative_curvature():
    points, faces = discs.irregular(200)
    edges = PolyhedralMetric.from_mesh(discs.round_cap(points, 1.0), faces).edges
    metric = PolyhedralMetric(faces, discs.hyperbolic_lengths(points, 0.5, edges), edges)
    found = embed(metric, boundary="free")
    assert found.residual < 1e-13
    assert found.imbalance < 1e-8
    assert "not at a minimum" not in found.message


@pytest.mark.parametrize("mesh", [discs.hexagonal(6), discs.irregular(100)], ids=["hexagonal", "irregular"])
@pytest.mark.parametrize("surface", [bumpy, lambda p: discs.round_cap(p, 1.0)], ids=["bumpy", "flat curve"])
def test_given_curve(mesh, surface):
    x = surface(mesh[0])
    metric = PolyhedralMetric.from_mesh(x, mesh[1])
    curve = x[rim(metric)]
    found = embed(metric, boundary=curve)
    assert found.residual < 1e-12
    np.testing.assert_allclose(found.vertices[rim(metric)], curve, atol=1e-15)
    assert distance(found.vertices, x) < 1e-11


def test_a_measured_curve_takes_a_tolerance():
    points, faces = discs.hexagonal(4)
    x = bumpy(points)
    metric = PolyhedralMetric.from_mesh(x, faces)
    curve = x[rim(metric)]
    curve = curve + 1e-4 * np.random.default_rng(0).standard_normal(curve.shape)
    with pytest.raises(NotEmbedded, match=r"does not fit the lengths: .* for measured positions") as refusal:
        embed(metric, boundary=curve)
    tolerance = float(str(refusal.value).rpartition("=")[2])
    found = embed(metric, boundary=curve, tolerance=tolerance)
    assert found.converged and tolerance < 0.01
    assert distance(found.vertices, x) < 0.01
    assert "misses the lengths by up to" in isoembed.certify(found).reason
    exact = embed(metric, boundary=x[rim(metric)])
    assert "none can be proven to exist" in isoembed.certify(exact).reason


def test_given_curve_from_a_start():
    points, faces = discs.hexagonal(5)
    x = bumpy(points)
    metric = PolyhedralMetric.from_mesh(x, faces)
    found = embed(metric, boundary=x[rim(metric)], start=x + 0.01 * np.sin(7 * x))
    assert distance(found.vertices, x) < 1e-11


def test_given_heights():
    points, faces = discs.irregular(150)
    x, y = points.T
    vertices = np.column_stack([points, -0.5 * (x * x + y * y) - 0.08 * x**3 + 0.06 * x * y * y])
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    heights = vertices[rim(metric), 2] + 7.0
    found = embed(metric, boundary=heights)
    assert found.residual < 1e-13
    assert distance(found.vertices, vertices) < 1e-11
    assert np.abs(found.vertices[rim(metric), 2] - heights).max() < 1e-11
    heights[1] = np.nan
    with pytest.raises(InvalidParameter, match=r"the boundary at \[1\] is nan, which is not finite"):
        embed(metric, boundary=heights)


def test_heights_are_refused_between_which_an_edge_is_too_short():
    pyramid = PolyhedralMetric([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]], np.full(8, 3.0))
    with pytest.raises(InvalidParameter, match=r"ends of edge 1 \[0, 3\] differ by 1.667 times"):
        embed(pyramid, boundary=[0.0, 0.0, 5.0, 5.0])


@pytest.mark.parametrize("bump", [0.0, pytest.param(0.1, marks=pytest.mark.slow)])
def test_torus(bump):
    x, faces = discs.torus(24, 12, bump)
    metric = PolyhedralMetric.from_mesh(x, faces)
    assert metric.triangulation.genus == 1
    found = embed(metric, boundary="free")
    assert found.residual < 1e-12
    assert distance(found.vertices, x) < 1e-11
    assert isoembed.report(found)["sheet"]["genus"] == 1


def test_cylinder():
    x, faces = discs.band(24, 9, lambda t: (1.0, 1.5 * t))
    found = embed(PolyhedralMetric.from_mesh(x, faces), boundary="free")
    assert found.residual < 1e-12
    assert found.surface.bending_energy == pytest.approx(1.5 * np.pi / 2, rel=0.02)


def test_kerr_band():
    """A horizon too fast to be embedded whole has bands that are."""
    profile = horizon_profile(0.95, np.linspace(0.5, -0.5, 13))
    x, faces = discs.band(36, 12, lambda t: profile[round(12 * t)])
    metric = PolyhedralMetric.from_mesh(x, faces)
    found = embed(metric, boundary="free")
    assert found.residual < 1e-12
    assert apart(found.vertices, x) < 1e-9


def horizon_profile(a, m):
    """(rho, z) at the cosines m of the horizon of a Kerr hole of mass 1, by quadrature from the equator."""
    plus = 1 + np.sqrt(1 - a * a)
    eta, beta = np.sqrt(plus**2 + a * a), a * a / (plus**2 + a * a)

    def f(m):
        return (1 - m * m) / (1 - beta * (1 - m * m))

    def rise(m):
        h = 1e-5
        slope = eta * (np.sqrt(f(m + h)) - np.sqrt(f(m - h))) / (2 * h)
        return np.sqrt(eta**2 / f(m) - slope**2)

    nodes, weights = np.polynomial.legendre.leggauss(40)
    z = [x / 2 * np.sum(weights * rise(x * (nodes + 1) / 2)) for x in m]
    return np.stack([eta * np.sqrt(f(m)), z], axis=1)


DISC, FACES = discs.hexagonal(3)
SADDLE = PolyhedralMetric.from_mesh(np.column_stack([DISC, DISC[:, 0] * DISC[:, 1]]), FACES)
ROUND = cap(DISC, FACES)[1]
DOME_POINTS, DOME_FACES = discs.hexagonal(4)
ELLIPTIC = discs.round_cap(DOME_POINTS, 1.4) * [1.1, 1.0, 0.75]
CURVE = cap(DISC, FACES)[0][rim(ROUND)]
TETRAHEDRON = PolyhedralMetric([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]], [1.0] * 6)
RING = PolyhedralMetric.from_mesh(*discs.band(6, 2, lambda t: (1.0 + t, 0.0)))


@pytest.mark.parametrize(
    ("metric", "options", "error", "sentence"),
    [
        (ROUND, {}, InvalidMetric, "not closed; boundary='free' is for such surfaces"),
        (ROUND, {"start": np.zeros((37, 3))}, InvalidParameter, "give boundary='free'"),
        (ROUND, {"boundary": "flat"}, InvalidParameter, "the boundary is 'flat', none of 'free', 'plane'"),
        (ROUND, {"boundary": [1.0, 2.0]}, InvalidParameter, "18 vertices there, so it must be"),
        (ROUND, {"boundary": [[np.nan] * 3] * 18}, InvalidParameter, "not finite"),
        (ROUND, {"boundary": "free", "start": [[0, 0, 0]]}, InvalidParameter, "not \\(37, 3\\)"),
        (ROUND, {"boundary": "plane", "start": cap(DISC, FACES)[0]}, InvalidParameter, "takes no start"),
        (SADDLE, {"boundary": "plane"}, InvalidMetric, "deficit at vertex 1 is -0.1042 radians"),
        (SADDLE, {"boundary": np.zeros(18)}, InvalidMetric, "vertex 0 has the deficit -.*ill posed"),
        (ROUND, {"boundary": "free", "start": np.zeros((37, 3))}, InvalidParameter, "face 0 .* has no area"),
        (ROUND, {"boundary": np.zeros((18, 3))}, InvalidParameter, "edge \\d+ .* coincide in the boundary"),
        (ROUND, {"boundary": 5}, InvalidParameter, "the boundary has the shape \\(\\)"),
        (
            ROUND,
            {"boundary": "free", "length_errors": 0.1},
            InvalidParameter,
            "requires boundary='plane'",
        ),
        (ROUND, {"boundary": 3 * CURVE}, NotEmbedded, "vertices \\d+ and \\d+ differs .* in the order of"),
        (TETRAHEDRON, {"boundary": [1.0]}, InvalidParameter, "the metric has no boundary"),
        (RING, {"boundary": "plane"}, InvalidMetric, "2 boundaries and genus 0: a convex cap is a disc"),
    ],
)
def test_refusals(metric, options, error, sentence):
    with pytest.raises(error, match=sentence):
        embed(metric, **options)


def test_other_methods_and_spaces_refuse_a_boundary():
    with pytest.raises(InvalidMetric, match="not closed"):
        embed(ROUND, method="alexandrov")
    with pytest.raises(InvalidParameter, match="either boundary or method"):
        embed(ROUND, boundary="free", method="alexandrov")
    curved = PolyhedralMetric(FACES, ROUND.lengths, ROUND.edges, curvature=-0.1)
    with pytest.raises(InvalidParameter, match=r"embedded in R\^3 only"):
        embed(curved, boundary="free")


def test_a_sphere_is_no_less_a_surface():
    x, faces = zoo.icosphere(1)
    found = embed(PolyhedralMetric.from_mesh(x, faces), boundary="free", start=x)
    assert found.residual < 1e-12


def test_methods_compare_and_print():
    assert Sheet([[0, 0, 1]]) == Sheet(np.array([[0.0, 0, 1]]))
    assert "start=((0.0, 0.0, 1.0),)" in repr(Sheet("free", [[0, 0, 1]]))


def test_pictures_and_pages():
    found = embed(ROUND, boundary="plane")
    assert "genus" in found._repr_html_()
    assert found.surface.concave_edges.sum() == 0
    found = embed(ROUND, boundary="free")
    with pytest.raises(InvalidMetric, match="not closed"):
        _ = found.volume


def test_two_triangles_are_a_sheet():
    square = PolyhedralMetric.from_mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    found = embed(square, boundary="plane")
    assert found.residual < 1e-12
    assert found.second_form_energy < 1e-12


def test_a_flat_square_is_a_convex_cap():
    """Vertices inside are flat: Newton's matrix is singular, and the polyhedron has them in place."""
    x, faces = square(5)
    found = embed(PolyhedralMetric.from_mesh(x, faces), boundary="plane")
    assert found.residual < 1e-12
    assert distance(found.vertices, x) < 1e-9


def square(n):
    """A unit square of n by n squares, each cut along the same diagonal."""
    u, v = np.meshgrid(np.arange(n + 1) / n, np.arange(n + 1) / n, indexing="ij")
    x = np.stack([u.ravel(), v.ravel(), 0 * u.ravel()], axis=1)
    a = ((n + 1) * np.arange(n)[:, None] + np.arange(n)).ravel()
    return x, np.concatenate([np.stack([a, a + n + 1, a + n + 2], 1), np.stack([a, a + n + 2, a + 1], 1)])


def test_a_start_with_the_lengths_is_kept():
    """Where lengths fix the vertices to second order only, bending would lead astray."""
    x, faces = discs.torus(16, 10)
    found = embed(PolyhedralMetric.from_mesh(x, faces), boundary="free", start=x)
    assert distance(found.vertices, x) < 1e-12
    assert found.uniqueness is None
    assert found.tensions is None


def test_what_is_about_spheres_is_refused():
    found = embed(ROUND, boundary="plane")
    for ask in (
        lambda: isoembed.Sensitivity(found).smallest_singular_value,
        lambda: isoembed.Sensitivity(found).variation(ROUND.lengths),
        lambda: isoembed.Sensitivity(found).deviation_bound(0.1),
        lambda: found.with_length_errors(0.1),
        lambda: realizations(found),
    ):
        with pytest.raises(InvalidMetric, match="closed surfaces of genus 0, and this one has a boundary"):
            ask()
    for ask in (
        lambda: Embedding(ROUND, found.vertices, method="given", tolerance=1e-10).volume,
        lambda: least_convex_space(ROUND),
        lambda: dents(SADDLE),
    ):
        with pytest.raises(InvalidMetric, match="not closed"):
            ask()
    torus = PolyhedralMetric.from_mesh(*discs.torus(8, 6))
    with pytest.raises(InvalidMetric, match="genus 1"):
        conformal_sphere(torus, smooth_bodies.recorder())


def test_a_tolerance_below_rounding_is_missed_in_words():
    with pytest.raises(NotEmbedded, match="lengths miss the tolerance 1e-30"):
        embed(ROUND, boundary="plane", tolerance=1e-30)


def test_a_cap_within_errors_is_near_the_exact_one():
    exact = embed(ROUND, boundary="plane")
    sigma = 1e-4
    noise = sigma * np.random.default_rng(1).standard_normal(ROUND.lengths.shape)
    noisy = PolyhedralMetric(ROUND.faces, 1e9 * (ROUND.lengths + noise), ROUND.edges)
    found = embed(noisy, boundary="plane", length_errors=1e9 * sigma)
    assert found.status == "converged" and found.chi_square <= found.chi_square_limit
    deviation = isoembed.Sensitivity(found).integral_deviation(found.length_errors)
    for name, power in (("area", 2), ("integrated_mean_curvature", 1)):
        bar = getattr(deviation, name) / 1e9**power
        error = getattr(found, name) / 1e9**power - getattr(exact, name)
        assert abs(error) < 3 * bar < 0.01 * getattr(exact, name)
    [loop] = ROUND.triangulation.boundaries
    assert np.abs(found.vertices[loop, 2]).max() < 1e-3
    off = aligned(found.vertices / 1e9, exact.vertices) - exact.vertices
    assert np.linalg.norm(off, axis=1).max() < 20 * sigma


@pytest.mark.parametrize(
    ("count", "angle", "size"),
    [(150, 0.4, 1e-3), (60, 0.6, 1e-5), (60, 0.6, 0.01), (60, 1.0, 1e-3), (60, 1.5, 1e-3)],
)
def test_a_measured_cap_meets_its_plane_at_any_angle(count, angle, size):
    """The double of a cap that is not vertical along its boundary has a crease there, which stays."""
    points, faces = discs.irregular(count)
    true = discs.round_cap(points, angle)
    metric = PolyhedralMetric.from_mesh(true, faces)
    sigma = size * metric.mean_length
    lengths = metric.lengths + np.random.default_rng(2).normal(0, sigma, len(metric.lengths))
    found = embed(metric.with_lengths(lengths), boundary="plane", length_errors=sigma)
    assert found.converged and apart(found.vertices, true) < 20 * sigma


def frustum(k, height):
    """A cap of a k-gon, a smaller one over it, and a point over that."""
    around = np.stack(
        [np.cos(2 * np.pi * np.arange(k) / k), np.sin(2 * np.pi * np.arange(k) / k), np.zeros(k)], 1
    )
    vertices = [*around, *(around / 2 + [0, 0, height]), [0, 0, 1.2 * height]]
    faces = [[i, (i + 1) % k, k + i] for i in range(k)]
    faces += [[(i + 1) % k, k + (i + 1) % k, k + i] for i in range(k)]
    return np.array(vertices), [*faces, *([k + i, k + (i + 1) % k, 2 * k] for i in range(k))]


def pyramid(k, height):
    around = 2 * np.pi * np.arange(k) / k
    vertices = np.column_stack([np.cos(around), np.sin(around), np.zeros(k)])
    return np.array([*vertices, [0, 0, height]]), [[i, (i + 1) % k, k] for i in range(k)]


@pytest.mark.parametrize("size", [1e-9, 1e-5, 1e-3])
@pytest.mark.parametrize("true", [pyramid(7, 0.4), frustum(4, 0.7)])
def test_a_measured_cap_of_few_vertices_is_the_convex_one(true, size):
    """Too few for local fits of either half: their roughness does not tell a dent from a convex cap."""
    metric = PolyhedralMetric.from_mesh(*true)
    sigma = size * metric.mean_length
    lengths = metric.lengths + np.random.default_rng(0).normal(0, sigma, len(metric.lengths))
    found = embed(metric.with_lengths(lengths), boundary="plane", length_errors=sigma)
    assert found.converged and apart(found.vertices, true[0]) < 5 * sigma


def test_a_triangle_is_no_cap_to_fit():
    with pytest.raises(InvalidMetric, match="determine it without a fit"):
        embed(PolyhedralMetric([[0, 1, 2]], [3.0, 4.0, 5.0]), boundary="plane", length_errors=0.1)


def test_a_cap_that_two_vertices_of_the_boundary_divide_is_not_fitted():
    halves = PolyhedralMetric(
        [[0, 1, 2], [0, 2, 3]], [1.0, 1.0, 2**0.5, 1.0, 1.0], [[0, 1], [1, 2], [0, 2], [2, 3], [0, 3]]
    )
    with pytest.raises(InvalidMetric, match=r"edge 1 \[0, 2\] joins two vertices of the boundary inside"):
        embed(halves, boundary="plane", length_errors=0.01)


def test_a_cap_takes_errors_that_are_too_large():
    """Edges of the boundary are once on the doubled cap, those inside twice: all count as much."""
    dome = PolyhedralMetric.from_mesh(ELLIPTIC, DOME_FACES)
    for sigma in np.geomspace(1e-4, 0.1, 16) * dome.mean_length:
        found = embed(dome, boundary="plane", length_errors=sigma)
        assert found.chi_square <= found.chi_square_limit


def test_a_wrong_length_of_a_cap_is_found_from_its_digits():
    """The exact cap is rough, so a smooth one is fitted within the digits: without the length, if at all."""
    dome = PolyhedralMetric.from_mesh(4000 * ELLIPTIC, DOME_FACES)
    lengths = dome.lengths + np.random.default_rng(6).normal(0, 1, len(dome.lengths))
    lengths[0] -= 60
    typed = dome.with_lengths(np.round(lengths))
    exact = embed(typed, boundary="plane", length_errors=0)
    assert exact.surface.rough_edges.any()
    found = embed(typed, boundary="plane")
    assert distance(found.vertices, exact.vertices) < 1e-6
    assert "fitted without them: edge 0 [0, 1] (+4 %), with which all other lengths agree" in found.message


@pytest.mark.parametrize(("edge", "off"), [(54, -12.0), (84, 12.0), (114, -12.0)])
def test_a_large_blunder_on_an_open_cap(edge, off):
    """It is named, no other edge is, and the length that is said is that of the others."""
    points, faces = discs.irregular(60)
    cap = PolyhedralMetric.from_mesh(150 * discs.round_cap(points, np.pi / 2) * [1.1, 1.0, 0.75], faces)
    lengths = cap.lengths + np.random.default_rng(4).normal(0, 0.3, len(cap.lengths))
    lengths[edge] += off
    named = rf"fitted without them: edge {edge} \[\d+, \d+\] \([^)]* to (\S+)\), with which all other"
    with pytest.raises(NotEmbedded, match=named) as caught:
        embed(cap.with_lengths(lengths), boundary="plane", length_errors=0.3)
    said = re.search(named, str(caught.value))
    assert abs(float(said[1]) - cap.lengths[edge]) < abs(off) / 6


def test_deviations_of_a_cap_with_too_many_digits_are_of_the_scatter():
    vertical = discs.round_cap(DOME_POINTS, np.pi / 2) * [
        1.1,
        1.0,
        0.75,
    ]  # at the boundary: its double is smooth
    dome = PolyhedralMetric.from_mesh(4000 * vertical, DOME_FACES)
    noise = np.random.default_rng(0).normal(0, 3, len(dome.lengths))
    found = embed(
        dome.with_lengths(np.round(dome.lengths + noise, 1)), boundary="plane", length_errors=0.0289
    )
    assert "and the deviations are of; the errors, 0.029, are those of the last digit" in found.message
    sigma = isoembed.Sensitivity(found).integral_deviation(found.length_errors)
    assert abs(found.area - embed(dome, boundary="plane").area) < 3 * sigma.area


@pytest.mark.parametrize("size", [40000, 40800, 43600])
def test_a_cap_of_rounded_lengths_may_have_negative_deficits_within_them(size):
    points, faces = discs.irregular(60)
    cap = size * discs.round_cap(points, 0.05)
    metric = PolyhedralMetric.from_mesh(cap, faces)
    rounded = metric.with_lengths(np.round(metric.lengths))
    with pytest.raises(InvalidMetric, match="but is nonnegative on a convex cap"):
        embed(rounded, boundary="plane", length_errors=0)
    found = embed(rounded, boundary="plane")
    assert found.converged and "those of the last digit" in found.message
    assert apart(found.vertices, cap) < 40.0
    lengths = rounded.lengths.copy()
    lengths[0] += 100
    with pytest.raises(InvalidMetric, match="; with length_errors=E a smooth cap is fitted"):
        embed(rounded.with_lengths(lengths), boundary="plane")


@pytest.mark.parametrize(("height", "farthest"), [(0.1, 6e-3), (0.02, 5e-2)])
def test_shallow_measured_caps_are_not_crumpled(height, farthest):
    """Lengths do not tell on which side of its neighbors a vertex is, nor the height of the second cap."""
    points, faces = discs.irregular(200)
    cap = discs.round_cap(points, height)
    metric = PolyhedralMetric.from_mesh(cap, faces)
    error = 1e-4 * metric.mean_length
    noise = error * np.random.default_rng(0).normal(size=len(metric.lengths))
    found = embed(metric.with_lengths(metric.lengths + noise), boundary="plane", length_errors=error)
    assert apart(found.vertices, cap) < farthest * metric.mean_length
    volume = isoembed.report(found)["deviation"]["volume"]
    assert volume is None if height < 0.1 else volume < 0.02 * found.volume


@pytest.mark.parametrize("unit", [1.0, 3e-5])
@pytest.mark.parametrize("error", [1e-12, 1e-11])
@pytest.mark.parametrize("rise", [0.0, 1.0])
def test_angles_that_errors_within_the_tolerance_make_negative(rise, error, unit):
    """Flat hexagon, or frustum of a pyramid, with vertices on their sides and inside of their faces."""
    round_, faces = discs.hexagonal(8)
    r, turn = np.linalg.norm(round_, axis=1), np.arctan2(round_[:, 1], round_[:, 0]) * 3 / np.pi
    corners = np.exp(1j * np.pi / 3 * np.arange(7))
    start = np.floor(turn % 6 + 1e-9).astype(int)
    flat = r * (corners[start] + (turn % 6 - start) * (corners[start + 1] - corners[start]))
    vertices = np.column_stack([flat.real, flat.imag, rise * np.minimum(0.5, 1 - r)])
    exact = PolyhedralMetric.from_mesh(unit * vertices, faces)
    noise = error * np.random.default_rng(0).normal(size=len(exact.lengths))
    metric = exact.with_lengths(exact.lengths * (1 + noise))
    assert -1e-7 < metric.deficits.min() < -2 * error
    found = embed(metric, boundary="plane")
    assert found.residual < 10 * error
    assert apart(found.vertices / unit, vertices) < 1e-4
    if rise == 0.0:
        assert np.ptp(found.vertices[:, 2]) == 0.0 and not found.surface.concave_edges.any()
    with pytest.raises(InvalidMetric, match="but is nonnegative on a convex cap"):
        embed(exact.with_lengths(exact.lengths * (1 + 1e3 * noise)), boundary="plane")


def test_a_rounded_cap_says_how_to_have_error_bars():
    dome = PolyhedralMetric.from_mesh(4000 * ELLIPTIC, DOME_FACES)
    rounded = dome.with_lengths(np.round(dome.lengths))
    hint = "; the lengths look rounded: length_errors=0.29 gives error bars"
    assert embed(rounded, boundary="plane").message.endswith(hint)
    assert isinstance(embed(rounded, boundary="plane", length_errors=0.29), isoembed.MeasuredSurface)
