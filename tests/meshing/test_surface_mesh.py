"""The triangulations: shape of the triangles, topology, determinism, rates of convergence."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

import zoo
from isoembed.gallery import (
    SURFACES,
    Bean,
    BentTube,
    CassiniPeanut,
    Drum,
    Ellipsoid,
    Ergosphere,
    HarmonicSurface,
    KerrHorizon,
    Sphere,
    Superellipsoid,
    triangulate,
)
from isoembed.meshing import surface_mesh
from isoembed.meshing.blue_noise import blue_noise_directions
from isoembed.meshing.flips import corner_angles, flip_to_delaunay, flip_where_touched, twin_halfedges
from isoembed.meshing.lloyd import lloyd_step
from isoembed.meshing.sphere import fibonacci_lattice
from isoembed.meshing.surface import spread_directions, vertex_density
from isoembed.meshing.touch_up import GOOD, INWARD, OUTSIDE, judge
from isoembed.surface.intersection import self_intersections


def angles(x, faces):
    """Corner angles in degrees by the law of cosines: not the formula of the package."""
    l2 = [((x[faces[:, i]] - x[faces[:, j]]) ** 2).sum(axis=1) for i, j in ((1, 2), (2, 0), (0, 1))]
    return np.degrees(
        np.arccos(
            [
                (l2[b] + l2[c] - l2[a]) / (2 * np.sqrt(l2[b] * l2[c]))
                for a, b, c in ((0, 1, 2), (1, 2, 0), (2, 0, 1))
            ]
        )
    )


def connected(surface, n):
    """The hull of the directions that a regular mesh starts from, and its half-edges' twins."""
    _, faces = zoo.outward_hull(spread_directions(surface, fibonacci_lattice(n)))
    return faces, twin_halfedges(faces)


def volume(x, faces):
    return np.einsum("ij,ij->", x[faces[:, 0]], np.cross(x[faces[:, 1]], x[faces[:, 2]])) / 6.0


def area(x, faces):
    a, b, c = (x[faces[:, i]] for i in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2.0


def integrated_mean_curvature(x, faces):
    """Half the sum of length times exterior dihedral angle, edge by edge."""
    left = {(int(f[c]), int(f[(c + 1) % 3])): k for k, f in enumerate(faces) for c in range(3)}
    n = np.cross(x[faces[:, 1]] - x[faces[:, 0]], x[faces[:, 2]] - x[faces[:, 0]])
    n /= np.linalg.norm(n, axis=1)[:, None]
    total = 0.0
    for (i, j), f in left.items():
        if i < j:
            d, m = x[j] - x[i], n[left[j, i]]
            length = np.linalg.norm(d)
            total += 0.5 * length * np.arctan2(np.cross(n[f], m) @ d / length, n[f] @ m)
    return total


def assert_closed_oriented_sphere(faces, n):
    """Every vertex has one closed fan, every edge two sides, and V - E + F = 2."""
    halfedges = {}
    link = [{} for _ in range(n)]
    for f in faces.tolist():
        assert len(set(f)) == 3
        for c in range(3):
            i, j, k = f[c], f[(c + 1) % 3], f[(c + 2) % 3]
            assert (i, j) not in halfedges
            halfedges[i, j] = f
            link[i][j] = k
    assert all((j, i) in halfedges for i, j in halfedges)
    assert n - len(halfedges) // 2 + len(faces) == 2
    for around in link:
        assert len(around) >= 3
        start = j = next(iter(around))
        steps = 0
        while steps == 0 or j != start:
            j, steps = around[j], steps + 1
        assert steps == len(around)


@pytest.mark.parametrize(
    ("surface", "n", "least", "most"),
    [
        (Ellipsoid((3, 2, 1)), 200, 37, 99),
        (Ellipsoid((3, 2, 1)), 800, 37, 99),
        (Ellipsoid((3, 2, 1)), 3226, 37, 99),
        (Ellipsoid((10, 1, 1)), 1000, 35, 100),
        (Ellipsoid((10, 10, 1)), 2000, 35, 100),
        (Ellipsoid((5, 4, 3)), 100, 37, 99),
        (Drum(), 3246, 37, 99),
        (Sphere(), 12, 37, 99),
        (Sphere(), 1000, 37, 99),
        (Superellipsoid(), 1200, 37, 99),
        (CassiniPeanut(), 1000, 37, 99),
        (HarmonicSurface(2, 2, 0.35), 1000, 37, 99),
        (HarmonicSurface(3, 3, 0.3), 1000, 37, 99),
        (HarmonicSurface(4, 3, 0.12), 1000, 37, 99),
        (Bean(), 1000, 37, 99),
        (BentTube(), 1000, 37, 99),
        (KerrHorizon(spin=0.0), 1000, 37, 99),
        (KerrHorizon(spin=0.5), 1000, 37, 99),
        (KerrHorizon(spin=0.8), 1000, 37, 99),
        (Ergosphere(1.5), 1000, 37, 99),
        (Ergosphere(0.3), 1000, 37, 99),
        (Ergosphere(0.1), 1000, 37, 99),
        (Ergosphere(0.02), 3226, 36, 100),
    ],
    ids=str,
)
def test_angle_window_topology_and_orientation(surface, n, least, most):
    x, faces = triangulate(surface, n)
    assert x.shape == (n, 3)
    assert faces.shape == (2 * n - 4, 3)
    assert faces.dtype == np.int64
    assert_closed_oriented_sphere(faces, n)
    assert angles(x, faces).min() > least
    assert angles(x, faces).max() < most
    assert_looks_outward(surface, x, faces)


def assert_looks_outward(surface, x, faces):
    """Every triangle looks outward: against the position it would not do for the peanut's waist."""
    assert volume(x, faces) > 0
    normal = np.cross(x[faces[:, 1]] - x[faces[:, 0]], x[faces[:, 2]] - x[faces[:, 0]])
    smooth = surface.normal(directions(surface, x))[faces].sum(axis=1)
    assert np.einsum("ij,ij->i", normal, smooth).min() > 0


def directions(surface, x):
    """Invert point(): in closed form where there is one, else by bisection in theta."""
    if isinstance(surface, HarmonicSurface):
        return x
    if isinstance(surface, Bean):
        return (x - [0, 0, 1] * (surface.height / surface.axes[0] ** 2 * x[:, :1] ** 2)) / surface.axes
    if isinstance(surface, BentTube):
        R, z = surface.radius, x[:, 2] + surface.radius
        return (
            np.stack([R * np.arctan2(x[:, 0], z), x[:, 1], np.hypot(x[:, 0], z) - R], axis=1) / surface.axes
        )
    if hasattr(surface, "axes"):
        return x / np.array(surface.axes)
    low, high = np.zeros(len(x)), np.full(len(x), np.pi)
    phi = np.arctan2(x[:, 1], x[:, 0])
    u = lambda t: np.stack([np.sin(t) * np.cos(phi), np.sin(t) * np.sin(phi), np.cos(t)], axis=1)  # noqa: E731
    for _ in range(60):
        middle = 0.5 * (low + high)
        above = surface.point(u(middle))[:, 2] > x[:, 2]
        low, high = np.where(above, middle, low), np.where(above, high, middle)
    return u(0.5 * (low + high))


@pytest.mark.slow
@pytest.mark.parametrize(
    "surface", [Ellipsoid((3, 2, 1)), Drum(), HarmonicSurface(), Bean(), Ergosphere(0.1)], ids=str
)
def test_large_meshes_have_the_same_window(surface, monkeypatch):
    monkeypatch.setattr(surface_mesh, "LARGE", 1000)
    n = 3000
    x, faces = triangulate(surface, n)
    assert x.shape == (n, 3)
    assert_closed_oriented_sphere(faces, n)
    assert angles(x, faces).min() > 38 - 1e-9
    assert angles(x, faces).max() < 97 + 1e-9
    assert_looks_outward(surface, x, faces)
    again = triangulate(surface, n)
    np.testing.assert_array_equal(again[0], x)
    np.testing.assert_array_equal(again[1], faces)


@pytest.mark.slow
def test_large_meshes_move_where_they_must(monkeypatch):
    surface, n = Ellipsoid((3, 2, 1)), 4000
    first = surface.point(spread_directions(surface, fibonacci_lattice(n)))
    faces = flip_to_delaunay(first, surface.normal(directions(surface, first)), *connected(surface, n))[0]
    bad = faces[((angles(first, faces) < 38) | (angles(first, faces) > 97)).any(axis=0)]
    monkeypatch.setattr(surface_mesh, "LARGE", 1000)
    x = triangulate(surface, n)[0]
    moved = np.linalg.norm(x - first, axis=1) > 1e-9
    assert 0.2 < moved.mean() < 0.8
    edge = np.sqrt(surface.area / n)
    distance = np.linalg.norm(x[moved][:, None] - first[np.unique(bad)], axis=2).min(axis=1)
    assert distance.max() < 8 * edge
    assert np.median(distance) < 2 * edge


def beyond(x, faces):
    """Degrees by which the angles are outside of the window."""
    return max(38 - angles(x, faces).min(), angles(x, faces).max() - 97)


@pytest.mark.slow
def test_a_large_mesh_that_is_not_finished_is_the_best_so_far(monkeypatch):
    monkeypatch.setattr(surface_mesh, "LARGE", 1000)
    surface, n, found = HarmonicSurface(16, 8, 0.5), 1500, []
    for patience in (1, 2, 10):
        monkeypatch.setattr("isoembed.meshing.touch_up.PATIENCE", patience)
        x, faces = triangulate(surface, n)
        assert_closed_oriented_sphere(faces, n)
        found.append(beyond(x, faces))
    assert found[0] >= found[1] >= found[2] > 0
    first = surface.point(spread_directions(surface, fibonacci_lattice(n)))
    normals = surface.normal(directions(surface, first))
    assert found[0] <= beyond(first, flip_to_delaunay(first, normals, *connected(surface, n))[0])


def test_triangles_are_judged_by_their_angles_and_by_where_they_look():
    x, faces = triangulate(Sphere(), 200)
    every, window = np.arange(len(faces)), np.radians([38.0, 97.0])
    verdicts = np.zeros(len(faces), dtype=np.int8)
    judge(x, x, faces, corner_angles(x, faces), window, every, verdicts)
    assert (verdicts == GOOD).all()
    x[0] += 0.7 * (x[faces[(faces == 0).any(axis=1)][0]].mean(axis=0) - x[0])
    spoilt = corner_angles(x, faces)
    judge(x, x, faces, spoilt, window, every, verdicts)
    outside = (spoilt < window[0]).any(axis=1) | (spoilt > window[1]).any(axis=1)
    assert 0 < outside.sum() < 10
    np.testing.assert_array_equal(verdicts == OUTSIDE, outside)
    spoilt[5, 1] = np.nan
    judge(x, x, faces, spoilt, window, np.array([5]), verdicts)
    assert verdicts[5] == OUTSIDE
    judge(x, -x, faces, spoilt, window, np.array([7]), verdicts)
    assert np.flatnonzero(verdicts == INWARD).tolist() == [7]


@pytest.mark.parametrize("irregular", [None, 0])
@pytest.mark.parametrize(
    "surface",
    [
        *(Drum(), CassiniPeanut(), KerrHorizon(spin=0.8), Ergosphere(0.1), Superellipsoid()),
        *(HarmonicSurface(), Bean(), BentTube()),
    ],
    ids=str,
)
def test_vertices_lie_on_the_surface(surface, irregular):
    x, _ = triangulate(surface, 300, irregular=irregular)
    np.testing.assert_allclose(surface.point(directions(surface, x)), x, atol=1e-11 * np.abs(x).max())


@pytest.mark.slow
@pytest.mark.parametrize("name", SURFACES)
def test_the_same_input_gives_the_same_mesh(name):
    for seed in (None, 3):
        one, two = (triangulate(SURFACES[name](), 150, irregular=seed) for _ in range(2))
        np.testing.assert_array_equal(one[0], two[0])
        np.testing.assert_array_equal(one[1], two[1])


@pytest.mark.slow
@settings(max_examples=20, deadline=None, derandomize=True)
@given(
    n=st.integers(12, 90),
    surface=st.one_of(
        st.builds(Ellipsoid, st.tuples(*[st.floats(0.5, 3.0)] * 3)),
        st.builds(Drum, st.tuples(*[st.floats(0.5, 3.0)] * 3)),
        st.builds(Superellipsoid, power=st.floats(2.0, 10.0)),
        st.builds(CassiniPeanut, a=st.floats(0.1, 0.95)),
        st.builds(KerrHorizon, spin=st.floats(-0.86, 0.86)),
        st.builds(Ergosphere, epsilon=st.floats(0.01, 3.0)),
        st.builds(HarmonicSurface, st.just(3), st.integers(0, 3), st.floats(-0.4, 0.4)),
        st.builds(Bean, height=st.floats(-1.0, 1.0)),
        st.builds(BentTube, radius=st.floats(1.0, 5.0)),
    ),
    seed=st.integers(0, 99),
)
def test_any_number_of_vertices_gives_a_valid_mesh(n, surface, seed):
    for irregular, least in ((None, 10), (seed, 0.5)):
        x, faces = triangulate(surface, n, irregular=irregular)
        assert len(x) == n
        assert_closed_oriented_sphere(faces, n)
        assert 0.3 * surface.volume < volume(x, faces) < 1.2 * surface.volume
        assert angles(x, faces).min() > least


@pytest.mark.slow
@pytest.mark.parametrize(
    ("surface", "irregular"),
    [
        *((Ellipsoid((3, 2, 1)), None), (Drum(), None), (KerrHorizon(spin=0.8), None)),
        *((CassiniPeanut(0.8, 1.2), None), (Ergosphere(0.5), None), (Ergosphere(0.5), 2)),
        *((HarmonicSurface(2, 2, 0.35), None), (Bean(height=0.5), 0), (BentTube(), 4)),
    ],
    ids=str,
)
def test_area_volume_and_mean_curvature_converge_to_second_order(surface, irregular):
    counts = np.array([250, 1000, 4000])
    meshes = [triangulate(surface, n, irregular=irregular) for n in counts]
    for measure, exact in (
        (area, surface.area),
        (volume, surface.volume),
        (integrated_mean_curvature, surface.integrated_mean_curvature),
    ):
        errors = np.abs([measure(*mesh) / exact - 1.0 for mesh in meshes])
        rate = np.polyfit(np.log(counts), np.log(errors), 1)[0]  # N is h^-2
        assert -1.3 < rate < -0.8, (measure.__name__, errors)
        assert errors[-1] < 3e-3


def test_scale_does_not_matter():
    for seed in (None, 5):
        x, faces = triangulate(Ellipsoid((3, 2, 1)), 200, irregular=seed)
        for scale in (1e-150, 1e12):
            y, other = triangulate(Ellipsoid((3 * scale, 2 * scale, scale)), 200, irregular=seed)
            np.testing.assert_array_equal(other, faces)
            np.testing.assert_allclose(y / scale, x, rtol=1e-9, atol=1e-9)


NOT_CONVEX = [
    *(Ergosphere(0.3), Ergosphere(0.1), Ergosphere(0.02), CassiniPeanut()),
    *(HarmonicSurface(2, 2, 0.35), HarmonicSurface(3, 3, 0.3), HarmonicSurface(4, 3, 0.12)),
    *(Bean(), BentTube()),
]


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("surface", NOT_CONVEX, ids=str)
def test_irregular_meshes_are_valid(surface, seed):
    x, faces = triangulate(surface, 700, irregular=seed)
    assert_closed_oriented_sphere(faces, 700)
    assert_looks_outward(surface, x, faces)
    assert len(self_intersections(faces, x)) == 0
    assert angles(x, faces).min() > 12
    assert angles(x, faces).max() < 142


@pytest.mark.slow
def test_a_large_irregular_mesh_has_the_same_angles():
    x, faces = triangulate(Ergosphere(0.1), 10_000, irregular=0)
    assert_looks_outward(Ergosphere(0.1), x, faces)
    assert angles(x, faces).min() > 15
    assert angles(x, faces).max() < 140


def test_irregular_meshes_differ_from_seed_to_seed_and_are_irregular():
    degrees = lambda faces: np.bincount(faces.ravel())  # noqa: E731
    one, two = (triangulate(Sphere(), 1000, irregular=seed)[1] for seed in (0, 1))
    assert np.any(np.sort(degrees(one)[:100]) != np.sort(degrees(two)[:100]))
    # Of the vertices a relaxed mesh has nine in ten with six neighbors, blue noise half.
    assert np.mean(degrees(triangulate(Sphere(), 1000)[1]) == 6) > 0.8
    for faces in (one, two):
        assert 0.4 < np.mean(degrees(faces) == 6) < 0.65


@pytest.mark.slow
@pytest.mark.parametrize("surface", [Sphere(), Drum(), Ergosphere(0.3), BentTube()], ids=str)
def test_blue_noise_keeps_its_distance_and_leaves_no_hole(surface):
    n = 3000
    u = blue_noise_directions(surface, n, 7)
    x, faces = triangulate(surface, n, irregular=7)
    np.testing.assert_allclose(surface.point(u), x, atol=1e-14)
    # The spacing of the densest packing with the local density, from its exact integral.
    even = spread_directions(Sphere(), fibonacci_lattice(20_000))
    total = 4 * np.pi * np.mean(surface.area_density(even) * vertex_density(surface, even))
    spacing = np.sqrt(2 / np.sqrt(3) * total / (n * vertex_density(surface, u)))
    edges = np.linalg.norm(x[faces] - x[np.roll(faces, -1, axis=1)], axis=2)
    relative = edges / (0.5 * (spacing[faces] + spacing[np.roll(faces, -1, axis=1)]))
    assert relative.min() > 0.5  # random points come as close as 0.01
    assert relative.max() < 2.2
    rng = np.random.default_rng(3)
    weight = surface.area_density(even) * vertex_density(surface, even)
    for axis in rng.normal(size=(6, 3)):  # the density, more evenly than the sqrt(n) of random points
        inside = even @ axis > 0.3 * np.linalg.norm(axis)
        expected = weight[inside].sum() / weight.sum()
        assert np.mean(u @ axis > 0.3 * np.linalg.norm(axis)) == pytest.approx(expected, abs=0.006)


def test_the_tips_of_an_ergosphere_are_resolved():
    # At epsilon = 0.1 the radius at the poles is 0.09; an even mesh of 1000 vertices has edges of 0.28.
    surface = Ergosphere(0.1)
    radius = 1.0 / np.sqrt(surface.gaussian_curvature([[0, 0, 1]])[0])
    x, faces = triangulate(surface, 1000)
    edges = np.linalg.norm(x[faces] - x[np.roll(faces, -1, axis=1)], axis=2)
    top = surface.point([[0, 0, 1]])[0]
    near = np.linalg.norm(x[faces].mean(axis=1) - top, axis=1) < radius
    assert near.sum() > 10
    assert np.median(edges[near]) < 0.7 * radius
    assert edges[near].max() < radius
    assert edges[~near].max() > 0.25


def test_a_sphere_is_not_graded_and_the_density_integrates_to_the_share():
    u = np.random.default_rng(0).normal(size=(50, 3))
    u /= np.linalg.norm(u, axis=1)[:, None]
    assert np.ptp(vertex_density(Sphere(3.0), u)) < 1e-12
    # int K dA = 4 pi on a convex surface: one vertex in eleven follows the curvature.
    u = spread_directions(Sphere(), fibonacci_lattice(40_000))
    surface = Drum()
    mean = np.mean(surface.area_density(u) * vertex_density(surface, u))
    assert 4 * np.pi * mean / surface.area == pytest.approx(1.1, rel=1e-4)


def test_meshes_of_one_surface_share_the_samples_of_its_density(monkeypatch):
    points, density = [], Ellipsoid._area_density
    monkeypatch.setattr(Ellipsoid, "_area_density", lambda self, u: points.append(len(u)) or density(self, u))
    first = triangulate(Ellipsoid((2, 1.1, 1.3)), 30)
    assert sum(points) > 100_000
    points.clear()
    again = triangulate(Ellipsoid((2, 1.1, 1.3)), 30)
    assert points == []
    for one, other in zip(first, again, strict=True):
        np.testing.assert_array_equal(one, other)
    triangulate(Ellipsoid((2, 1.1, 1.4)), 30)
    assert sum(points) > 100_000


@pytest.mark.slow
@pytest.mark.parametrize(
    "surface", [Drum(), Ellipsoid((10, 1, 1)), Ergosphere(0.1), CassiniPeanut()], ids=str
)
def test_spread_directions_have_the_wanted_density(surface):
    # The share of the points in a set is the share of the density's integral, to lattice accuracy.
    u = spread_directions(surface, fibonacci_lattice(5000))
    assert np.abs(np.linalg.norm(u, axis=1) - 1).max() < 1e-14
    even = spread_directions(Sphere(), fibonacci_lattice(200_000))
    weight = surface.area_density(even) * vertex_density(surface, even)
    rng = np.random.default_rng(3)
    for axis in rng.normal(size=(12, 3)):
        axis /= np.linalg.norm(axis)
        for level in (-0.4, 0.2, 0.9):
            expected = weight[even @ axis > level].sum() / weight.sum()
            assert np.mean(u @ axis > level) == pytest.approx(expected, abs=0.006)


def test_flips_reach_the_delaunay_triangulation_of_the_sphere():
    # On the sphere it is the convex hull: start from a mesh spoilt by random flips of it.
    x, faces = triangulate(Sphere(), 400)
    key = lambda f: sorted(tuple(np.roll(t, -int(np.argmin(t)))) for t in f.tolist())  # noqa: E731
    hull = flip_to_delaunay(x, x, faces, twin_halfedges(faces))[0]
    # The points moved along a shear are connected as a Delaunay mesh of a different surface.
    y = x * np.array([3.0, 1.0, 0.5])
    normal = x / np.array([3.0, 1.0, 0.5])
    spoilt, twin = flip_to_delaunay(y, normal, faces, twin_halfedges(faces))
    assert_closed_oriented_sphere(spoilt, 400)
    np.testing.assert_array_equal(twin, twin_halfedges(spoilt))
    changed = len(set(key(spoilt)) - set(key(hull)))
    assert changed > 50
    mended, twin = flip_to_delaunay(x, x, spoilt, twin)
    assert key(mended) == key(hull)
    np.testing.assert_array_equal(twin, twin_halfedges(mended))


@pytest.mark.parametrize("seed", range(3))
def test_flips_near_what_has_changed_are_those_of_a_whole_mesh(seed):
    x, faces = triangulate(Sphere(), 500)
    rng = np.random.default_rng(seed)
    chosen = rng.choice(500, 12, replace=False)
    x[chosen] += 0.12 * rng.normal(size=(12, 3))
    normals = x / np.linalg.norm(x, axis=1)[:, None]
    x = normals.copy()
    near, twin = faces.copy(), twin_halfedges(faces)
    corners = corner_angles(x, near)
    flip_where_touched(x, normals, near, twin, corners, np.flatnonzero(np.isin(faces, chosen).any(axis=1)))
    whole = flip_to_delaunay(x, normals, faces, twin_halfedges(faces))[0]
    assert (whole != faces).any(axis=1).sum() > 10
    np.testing.assert_array_equal(near, whole)
    np.testing.assert_array_equal(twin, twin_halfedges(near))
    np.testing.assert_array_equal(corners, corner_angles(x, near))


def test_no_edge_is_flipped_onto_an_existing_one():
    # A flat bipyramid: every equatorial edge asks for the flip to the axis, which three of them share.
    phi = 2 * np.pi * np.arange(3) / 3
    x = np.concatenate([np.stack([np.cos(phi), np.sin(phi), 0 * phi], axis=1), [[0, 0, 0.1], [0, 0, -0.1]]])
    faces = np.array([[0, 1, 3], [1, 2, 3], [2, 0, 3], [1, 0, 4], [2, 1, 4], [0, 2, 4]])
    flipped, _ = flip_to_delaunay(x, x, faces, twin_halfedges(faces))
    assert_closed_oriented_sphere(flipped, 5)


def test_lloyd_steps_are_tangent_and_vanish_on_the_icosahedron():
    golden = (1 + np.sqrt(5)) / 2
    x = np.array([[0, a, b * golden] for a in (1, -1) for b in (1, -1)], dtype=float)
    x = np.concatenate([x, np.roll(x, 1, axis=1), np.roll(x, 2, axis=1)]) / np.hypot(1, golden)
    faces = ConvexHull(x).simplices.astype(np.int64)
    step = lloyd_step(x, x, faces, np.ones(12))
    assert np.abs(step).max() < 1e-14
    u = spread_directions(Sphere(), fibonacci_lattice(300))
    faces = ConvexHull(u).simplices.astype(np.int64)
    step = lloyd_step(u, u, faces, np.ones(300))
    assert np.abs(np.einsum("ij,ij->i", step, u)).max() < 1e-15
    assert 1e-4 < np.linalg.norm(step, axis=1).max() < 0.1


def test_corner_angles_of_a_known_triangle():
    x = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.0]])
    np.testing.assert_allclose(
        np.degrees(corner_angles(x, np.array([[0, 1, 2]]))), [[45, 45, 90]], rtol=1e-14
    )


@pytest.mark.parametrize(
    ("n", "message"),
    [
        (11, "the number of vertices must be at least 12, not 11"),
        (-5, "the number of vertices must be at least 12, not -5"),
        (100.5, "the number of vertices must be an integer, not 100.5"),
        ("many", "the number of vertices must be an integer, not 'many'"),
    ],
)
def test_bad_vertex_counts_are_refused(n, message):
    with pytest.raises(ValueError, match=message):
        triangulate(Sphere(), n)


@pytest.mark.parametrize(
    ("seed", "message"),
    [
        (-1, "the seed of an irregular mesh must be at least 0, not -1"),
        (1.5, "the seed of an irregular mesh must be an integer, not 1.5"),
    ],
)
def test_bad_seeds_are_refused(seed, message):
    with pytest.raises(ValueError, match=message):
        triangulate(Sphere(), 100, irregular=seed)
