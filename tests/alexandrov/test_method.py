"""``method="alexandrov"``: the polyhedron of a metric, whatever its triangles."""

import itertools
import json
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

import isoembed
import zoo
from isoembed import Alexandrov, ConvexPolyhedron, GluedMetric, MeshNote, PolyhedralMetric, embed
from isoembed.alexandrov import newton, relaxation
from isoembed.io import read_metric
from isoembed.metric.convexity import noise_level, repair_level
from isoembed.metric.repair import repaired
from lost_edges import octahedron_with_a_lost_edge
from places import SHARED
from scrambling import scramble

SQUARE = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])


def scrambled(vertices, faces, seed):
    """The metric of a surface on random triangles, which need not be a simplicial complex."""
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    tables = GluedMetric.of(metric).half_edges()
    scramble(tables, 10 * len(vertices), np.random.default_rng(seed))
    return GluedMetric(tables.faces, tables.twins, tables.face_lengths)


def grid_cube(n):
    """The unit cube with n x n squares, each cut in two, on every side."""
    vertices, faces = zoo.cube()
    points, triangles = [], []
    for side in range(6):
        axis, far = divmod(side, 2)
        u, v = (k for k in range(3) if k != axis)
        i, j = (index.ravel() for index in np.meshgrid(np.arange(n + 1), np.arange(n + 1), indexing="ij"))
        grid = np.zeros((len(i), 3))
        grid[:, axis], grid[:, u], grid[:, v] = far, i / n, j / n
        a = np.array([p * (n + 1) + q for p in range(n) for q in range(n)])
        quads = np.stack([a, a + n + 1, a + n + 2, a + 1], axis=1)
        if (far == 1) == (axis == 1):
            quads = quads[:, ::-1]
        offset = sum(map(len, points))
        triangles += [offset + quads[:, [0, 1, 2]], offset + quads[:, [0, 2, 3]]]
        points.append(grid)
    del vertices, faces
    unique, index = np.unique(np.round(np.concatenate(points), 12), axis=0, return_inverse=True)
    return unique, index.ravel()[np.concatenate(triangles)]


@given(st.integers(4, 40), st.integers(0, 10**6))
def test_hulls_from_scrambled_triangles(n, seed):
    vertices, faces = zoo.random_hull(n, seed)
    found = embed(scrambled(vertices, faces, seed), method="alexandrov")
    assert isinstance(found, ConvexPolyhedron)
    assert zoo.aligned(found.vertices, vertices) < 1e-9
    assert found.residual < 1e-10 and not found.surface.concave_edges.any()
    assert {frozenset(f) for f in found.faces.tolist()} == {frozenset(f) for f in faces.tolist()}


@settings(max_examples=12)
@given(st.integers(0, 10**6), st.sampled_from([1e-150, 1e-12, 1.0, 1e12, 1e150]))
def test_neither_scale_nor_labels_nor_mirror_matter(seed, scale):
    vertices, faces = zoo.random_hull(12, seed)
    found = embed(PolyhedralMetric.from_mesh(vertices * scale, faces), method="alexandrov")
    assert zoo.aligned(found.vertices / scale, vertices) < 1e-10
    moved, turned, new = zoo.relabeled(vertices, faces[:, ::-1], seed)
    other = embed(PolyhedralMetric.from_mesh(moved * scale, turned), method="alexandrov")
    assert zoo.aligned(other.vertices[new] / scale, vertices) < 1e-10


@pytest.mark.parametrize("n", [2, 5, 12])
def test_flat_vertices_find_their_places(n):
    vertices, faces = grid_cube(n)
    found = embed(scrambled(vertices, faces, n), method="alexandrov")
    assert zoo.aligned(found.vertices, vertices) < 1e-10
    assert len(found.flat_vertices) == len(vertices) - 8
    assert found.volume == pytest.approx(1, rel=1e-10)
    assert found.integrated_mean_curvature == pytest.approx(3 * np.pi, rel=1e-8)
    assert sorted(len(outline) for outline in found.polygons) == [4 * n] * 6
    assert isoembed.certify(found).certified


def test_polygons_are_the_faces_from_outside():
    vertices, faces = zoo.cube()
    found = embed(PolyhedralMetric.from_mesh(vertices, faces), method="alexandrov")
    assert len(found.polygons) == 6
    for outline, f in zip(found.polygons, range(6), strict=True):
        points = found.vertices[outline]
        normal = np.cross(points[1] - points[0], points[2] - points[1])
        assert normal @ (points.mean(axis=0) - found.vertices.mean(axis=0)) > 0
        triangles = found.faces[found.surface.flat_faces.of_triangles == f]
        assert set(triangles.ravel()) == set(outline)


def test_edges_of_the_input_are_drawn_on_the_result():
    vertices, faces = zoo.cube()
    metric = scrambled(vertices, faces, 1)
    found = embed(metric, method="alexandrov")
    points, starts = found.edge_paths.points(found.vertices), found.edge_paths.point_offsets
    assert len(starts) == metric.n_edges + 1
    h = np.flatnonzero(np.arange(metric.twins.size) < metric.twins)
    bent = 0
    for e, (i, j) in enumerate(pairwise(starts)):
        path = points[i:j]
        steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
        assert steps.sum() == pytest.approx(metric.face_lengths.ravel()[h[e]], rel=1e-12)
        # On the surface: within the faces of the cube.
        inside = found.vertices.min(axis=0) - 1e-12
        assert (path >= inside).all()
        bent += len(path) > 2
    assert bent > 0
    assert found.path_residuals.max() < 1e-13


def test_a_doubly_covered_polygon():
    angle = 2 * np.pi * np.arange(7) / 7
    outline = np.column_stack([2 * np.cos(angle), np.sin(angle)])
    found = embed(GluedMetric(*zoo.doubly_covered(outline)), method="alexandrov")
    assert zoo.aligned(found.vertices, np.column_stack([outline, np.zeros(7)])) < 1e-12
    assert found.volume == 0 and len(found.polygons) == 2
    perimeter = np.linalg.norm(outline - np.roll(outline, 1, axis=0), axis=1).sum()
    assert found.integrated_mean_curvature == pytest.approx(np.pi * perimeter / 2, rel=1e-12)
    assert "doubly covered" in isoembed.certify(found).reason and not isoembed.certify(found).certified


def test_a_doubly_covered_triangle():
    faces, twins, lengths = zoo.doubly_covered(np.array([[0.0, 0], [4, 0], [0, 3]]))
    for metric in (GluedMetric(faces, twins, lengths), PolyhedralMetric(faces, [4.0, 3.0, 5.0])):
        found = embed(metric, method="alexandrov")
        assert found.area == pytest.approx(12) and found.residual < 1e-14
    with pytest.raises(isoembed.InvalidParameter, match="doubly covered triangle"):
        embed(metric, method="aim")


def test_what_is_not_convex_is_refused_by_name():
    vertices, faces = zoo.icosphere(1)
    vertices[20] *= 1.5
    with pytest.raises(isoembed.InvalidMetric, match=r"vertex \d+ has total angle .* > 2 pi"):
        embed(PolyhedralMetric.from_mesh(vertices, faces), method="alexandrov")


def with_centers(vertices, faces):
    """Every face cut into three at its center."""
    n, f = len(vertices), len(faces)
    corners = [np.stack([faces[:, k], faces[:, (k + 1) % 3], n + np.arange(f)], axis=1) for k in range(3)]
    return np.vstack([vertices, vertices[faces].mean(axis=1)]), np.concatenate(corners)


@pytest.mark.parametrize("noise", [1e-4, 1e-6, 1e-8, 1e-10])
def test_noise_is_repaired_where_asked_and_reported(noise):
    vertices, faces = with_centers(*zoo.octahedron())
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    rng = np.random.default_rng(1)
    noisy = metric.with_lengths(metric.lengths * (1 + noise * rng.normal(size=len(metric.lengths))))
    with pytest.raises(isoembed.InvalidMetric, match="> 2 pi"):
        embed(noisy, method="alexandrov")
    found = embed(noisy, method=Alexandrov(repair=100 * noise))
    assert zoo.aligned(found.vertices, vertices) < 10 * noise
    said = isoembed.report(found)["repair"]
    assert len(said["vertices"]) == 8 and min(said["deficits"]) < 0 < max(said["deficits"])
    assert isoembed.report(found)["input"]["negative_deficits"] == sum(d < 0 for d in said["deficits"])
    assert 0 < said["largest_relative_length_change"] < 100 * noise
    assert isoembed.report(embed(metric, method=Alexandrov(repair=noise)))["repair"] is None


def test_noise_that_shows_once_negative_deficits_are_lifted():
    # One corner is so shallow that the worst of the noise is more than a thirtieth of its deficit.
    corners, faces = zoo.octahedron()
    n, (a, b, c) = len(corners), faces[0]
    corners = np.vstack([corners, 1.01 * corners[faces[0]].mean(axis=0)])
    body = corners, np.vstack([faces[1:], [[a, b, n], [b, c, n], [c, a, n]]])
    vertices, faces = with_centers(*zoo.subdivided(*body))
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    noise = 3e-7 * np.random.default_rng(1).normal(size=len(metric.lengths))
    noisy = metric.with_lengths(metric.lengths * (1 + noise))
    deficits = GluedMetric.of(noisy).deficits
    level = -3 * deficits.min()
    assert level < deficits[n] < 30 * level
    found = embed(noisy, method=Alexandrov(repair=level))
    assert len(found.flat_vertices) == len(vertices) - n - 1
    assert zoo.aligned(found.vertices, vertices) < 1e-4


@pytest.mark.shared
def test_the_tips_of_a_thin_lens_are_no_noise():
    metric = read_metric(SHARED / "trials" / "numbers" / "05_lens_1000gon.obj")
    deficits = GluedMetric.of(metric).deficits
    assert noise_level(deficits) == 0 and repair_level(deficits, 1e-12) is None
    assert repaired(metric, 3.2e-4)[0] is metric


@pytest.mark.parametrize("heights", [(90.573, -51.859), (150.0, -150.0)])
def test_needles(heights):
    # Deficits of .03 and less at the ring, and more than 6 at the tips.
    a = np.pi / 3 * np.arange(6)
    ring = np.stack([np.cos(a), np.sin(a), 0 * a], axis=1)
    vertices, faces = zoo.outward_hull(np.vstack([ring, [[0, 0, heights[0]], [0, 0, heights[1]]]]))
    found = embed(PolyhedralMetric.from_mesh(vertices, faces), method="alexandrov")
    volume = np.sqrt(3) / 2 * (heights[0] - heights[1])
    assert found.volume == pytest.approx(volume, rel=1e-9)


def test_a_needle_without_symmetry():
    points = [
        [0.385, -1.076, 0.077],
        [-0.33, 0.634, -0.673],
        [0.573, 0.549, -1.034],
        [0.093, 0.834, 0.6],
        [-1.91, -0.638, -3.674],
    ]
    vertices, faces = zoo.outward_hull(np.array(points) * (1, 1, 165.94))
    found = embed(PolyhedralMetric.from_mesh(vertices, faces), method="alexandrov")
    assert zoo.aligned(found.vertices, vertices) < 1e-6


def test_the_noise_is_a_number_of_radians():
    with pytest.raises(isoembed.InvalidParameter, match="repair is -1"):
        Alexandrov(repair=-1)


@pytest.mark.parametrize("digits", [5, 7, 9, 11])
@pytest.mark.parametrize("body", [zoo.tetrahedron, zoo.cube, zoo.icosahedron, lambda: zoo.random_hull(12, 1)])
def test_rounded_coordinates_with_flat_vertices_on_edges(body, digits):
    # Vertices that should be on an edge of the body are beside it by as much.
    vertices, faces = zoo.subdivided(*zoo.subdivided(*body()))
    turned = vertices @ zoo.rotation(7).T
    written = np.array([float(f"{x:.{digits - 1}e}") for x in turned.ravel()]).reshape(-1, 3)
    metric = PolyhedralMetric.from_mesh(written, faces)
    level = noise_level(GluedMetric.of(metric).deficits)
    found = embed(metric, method=Alexandrov(repair=1.1 * level))
    assert zoo.aligned(found.vertices, vertices) < 5 * np.abs(written - turned).max()
    assert found.residual < 1e-10
    assert len(found.flat_vertices) == len(vertices) - len(body()[0])


@pytest.mark.parametrize("seed", [1, 2])
def test_negative_deficits_within_the_tolerance_are_no_reason_to_refuse(seed):
    # What twelve digits leave; the residual is that of the lengths as they were given.
    vertices, faces = zoo.subdivided(*zoo.random_hull(12, seed))
    written = np.array([float(f"{x:.11e}") for x in (vertices @ zoo.rotation(7).T).ravel()]).reshape(-1, 3)
    metric = PolyhedralMetric.from_mesh(written, faces)
    assert -1e-10 < GluedMetric.of(metric).deficits.min() < -2e-12
    found = embed(metric, method="alexandrov")
    assert found.residual < 1e-10 and found.repair is None
    assert zoo.aligned(found.vertices, vertices) < 1e-11


def with_near_vertices(body, where, distance):
    """A body with a flat vertex near a corner, or with two flat ones near each other: (vertices, faces)."""
    vertices, faces = body
    a, b, c = (vertices[v] for v in faces[0])
    n, (i, j, k) = len(vertices), faces[0]
    if where == "corner, face":
        new = [a + distance * (b - a) + distance * (c - a)]
        cut = [[i, j, n], [j, k, n], [k, i, n]]
    elif where == "each other, face":
        center = (a + b + c) / 3
        new = [center, center + distance * ((b - center) + 0.5 * (c - center))]
        cut = [[i, j, n], [k, i, n], [n, j, n + 1], [j, k, n + 1], [k, n, n + 1]]
    else:  # on the edge from a to b
        places = [distance] if where == "corner, edge" else [0.4, 0.4 + distance]
        new = [a + t * (b - a) for t in places]
        chain = [i, *range(n, n + len(new)), j]
        other = next(f for f, face in enumerate(faces.tolist()) if f > 0 and {i, j} < set(face))
        (m,) = set(faces[other].tolist()) - {i, j}
        cut = [[p, q, k] for p, q in pairwise(chain)] + [[q, p, m] for p, q in pairwise(chain)]
        faces = np.delete(faces, other, axis=0)
    return np.vstack([vertices, new]), np.vstack([faces[1:], cut])


@pytest.mark.parametrize("distance", [1e-3, 1e-6, 1e-7, 1e-9])
@pytest.mark.parametrize("where", ["corner, face", "corner, edge", "each other, face", "each other, edge"])
def test_flat_vertices_near_corners_and_one_another(where, distance):
    for body in (zoo.tetrahedron(), zoo.random_hull(12, 3)):
        vertices, faces = with_near_vertices(body, where, distance)
        found = embed(PolyhedralMetric.from_mesh(vertices, faces), method="alexandrov")
        assert found.residual < 2e-14
        assert zoo.aligned(found.vertices, vertices) < 2e-14


def test_a_glued_metric_needs_this_method():
    metric = scrambled(*zoo.octahedron(), 0)
    with pytest.raises(isoembed.InvalidParameter, match='use the method "alexandrov"'):
        embed(metric, method="aim")


def test_failure_is_reported_with_what_there_is(monkeypatch):
    monkeypatch.setattr(newton, "MAX_STEPS", 0)
    monkeypatch.setattr(relaxation, "MAX_STEPS", 0)
    vertices, faces = grid_cube(2)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    with pytest.raises(isoembed.NotEmbedded, match="no polytope with zero curvature") as failure:
        embed(metric, method="alexandrov")
    attempt = failure.value.embedding
    assert attempt.metric is metric and attempt.residual > 1e-10
    assert attempt.residual < 1  # not far
    assert (
        isoembed.report(attempt)["status"] == "not converged"
        and isoembed.report(attempt)["uniqueness"] is None
    )
    assert failure.value.evidence.kind == "searched"
    assert "the polyhedron exists by Alexandrov's theorem" in failure.value.evidence.basis


@pytest.mark.parametrize(
    ("n", "apex", "height"), [(3, (0.3, 0.2), 0.1), (4, (0.3, 0.2), 0.02), (8, (0, 0), 0.01)]
)
def test_low_pyramids_are_finished_by_their_lengths(n, apex, height):
    angle = 2 * np.pi * np.arange(n) / n
    base = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    vertices, faces = zoo.outward_hull(np.vstack([base, [*apex, height]]))
    found = embed(PolyhedralMetric.from_mesh(vertices, faces), method="alexandrov")
    assert zoo.aligned(found.vertices, vertices) < 1e-10
    assert not found.surface.concave_edges.any()


def shallow_cap(seed, height):
    """A paraboloid of 30 vertices over a heptagon."""
    rng = np.random.default_rng(seed)
    r, a, b = 0.9 * np.sqrt(rng.random(30)), 2 * np.pi * rng.random(30), 2 * np.pi * np.arange(7) / 7
    cap = np.column_stack([r * np.cos(a), r * np.sin(a), 1 - r * r])
    vertices, faces = zoo.outward_hull(np.vstack([cap, np.column_stack([np.cos(b), np.sin(b), 0 * b])]))
    return vertices * [1, 1, height], faces


@pytest.mark.parametrize("seed", [1, 7])
def test_shallow_caps_are_finished_by_their_lengths_where_newton_stalls(seed):
    vertices, faces = shallow_cap(seed, 1e-4)
    found = embed(PolyhedralMetric.from_mesh(vertices, faces), method="alexandrov")
    assert zoo.aligned(found.vertices, vertices) < 1e-9
    # One start of four, and no diagonal that makes a dent, however shallow.
    assert sum(stage.iterations for stage in found.stages) < 500
    assert isoembed.certify(found).certified


def test_what_failed_is_no_success_however_near_its_lengths(monkeypatch):
    monkeypatch.setattr(newton, "MAX_STEPS", 0)
    monkeypatch.setattr(relaxation, "MAX_STEPS", 0)
    with pytest.raises(isoembed.NotEmbedded, match="no polytope with zero curvature"):
        embed(PolyhedralMetric.from_mesh(*zoo.icosahedron()), method="alexandrov", tolerance=1.0)


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e6])
def test_the_certified_distance_is_in_the_unit_of_the_lengths(size):
    vertices, faces = zoo.random_hull(30, 2)
    found = embed(PolyhedralMetric.from_mesh(size * vertices, faces), method="alexandrov")
    assert isoembed.certify(found).certified
    assert (
        zoo.aligned(found.vertices, size * vertices) < 100 * isoembed.certify(found).distance + 1e-14 * size
    )
    assert 1e-17 * size < isoembed.certify(found).distance < 1e-11 * size


def test_deficits_that_rounding_hides_are_refused():
    sides = [1.0, 1.0, 2 - 1e-14]
    metric = GluedMetric([[0, 1, 2], [0, 2, 1]], [5, 4, 3, 2, 1, 0], [sides, sides[::-1]])
    with pytest.raises(
        isoembed.InvalidMetric, match="only 2 vertices have deficits above the rounding error"
    ):
        embed(metric, method="alexandrov")


def test_success_is_claimed_on_the_residual_of_what_is_returned():
    vertices, faces = zoo.icosahedron()
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    with pytest.raises(isoembed.NotEmbedded):
        embed(metric, method="alexandrov", tolerance=1e-30)


@pytest.mark.parametrize("curvature", [0.0, -1.0])
def test_given_edges_are_measured_on_the_vertices_that_are_returned(curvature):
    vertices, faces = zoo.cube()
    given = PolyhedralMetric.from_mesh(vertices / 4, faces, curvature=curvature)
    found = embed(given, method="alexandrov")
    flown = replace(found, vertices=found.vertices * np.where(np.arange(8) == 3, 1 + 1e-6, 1.0)[:, None])
    assert found.path_residuals.max() < 1e-14
    a, b = found.edge_paths.ends.T
    touched = (a == 3) | (b == 3)
    assert (flown.path_residuals[touched] > 1e-8).all()


def test_an_edge_that_is_hardly_bent_stays_if_it_is_long():
    # Two triangles of the top are bent by 5e-8 radians, and the other diagonal is the Delaunay one.
    top = np.array([[0.0, 0.0, 2e-8], [1.0, 0.1, 0.0], [1.3, 1.3, 2e-8], [0.1, 1.0, 0.0]])
    vertices = np.vstack([top, [[0.6, 0.6, -0.5]]])
    faces = [[0, 1, 2], [0, 2, 3], [1, 0, 4], [2, 1, 4], [3, 2, 4], [0, 3, 4]]
    found = embed(PolyhedralMetric.from_mesh(vertices, faces), method="alexandrov")
    assert {frozenset(f) for f in found.faces.tolist()} == {frozenset(f) for f in faces}
    assert zoo.aligned(found.vertices, vertices) < 1e-12


@pytest.mark.parametrize(
    ("mesh", "curvature", "which"),
    [
        (zoo.tetrahedron(), -1.0, "in curved space"),
        ((SQUARE, [[0, 1, 2], [0, 2, 3], [1, 0, 3], [2, 1, 3]]), 0.0, "of doubly covered polygons"),
    ],
)
def test_errors_of_lengths_that_are_unused(mesh, curvature, which):
    vertices, faces = mesh
    given = PolyhedralMetric.from_mesh(vertices / 4, faces, curvature=curvature)
    with pytest.warns(MeshNote, match=f"lengths {which} are taken as exact: their errors are unused"):
        found = embed(given, method="alexandrov", length_errors=1e-3)
    assert found.length_errors is None and found.converged


def test_errors_of_lengths_are_kept_where_the_core_is_no_simplicial_complex(monkeypatch):
    given = PolyhedralMetric.from_mesh(*zoo.octahedron())

    def refuse(tables):
        raise isoembed.InvalidMetric("edge (0, 1) is in 4 faces")

    monkeypatch.setattr("isoembed.alexandrov.polyhedron.metric_on", refuse)
    found = embed(given, method="alexandrov", length_errors=1e-3)
    assert found.metric.precision is None and set(found.length_errors.tolist()) == {1e-3}


@pytest.mark.filterwarnings("ignore:.*reversed to match")
def test_faces_of_a_solid_whose_lengths_have_errors_of_a_percent():
    points = {p for q in itertools.permutations((0, 1, 2)) for p in itertools.product(*((k, -k) for k in q))}
    stretched = np.array(sorted(points)) @ (np.eye(3) + 0.2 * np.random.default_rng(0).normal(size=(3, 3)))
    exact = PolyhedralMetric.from_mesh(stretched, ConvexHull(stretched).simplices)
    unit = 0.01 * np.sqrt(12) * exact.mean_length
    rounded = PolyhedralMetric(exact.faces, np.rint(exact.lengths / unit), exact.edges)
    found = embed(rounded, method="alexandrov", length_errors=12**-0.5)
    assert sorted(map(len, found.polygons)) == [4] * 6 + [6] * 8


@pytest.mark.filterwarnings("ignore:.*reversed to match")
def test_errors_of_lengths_flatten_no_edge_that_they_do_not_bend():
    directions = np.random.default_rng(0).normal(size=(150, 3))
    points = directions / np.linalg.norm(directions, axis=1)[:, None] * [3, 2, 1]
    exact = PolyhedralMetric.from_mesh(points, ConvexHull(points).simplices)
    sigma = 1e-4 * exact.mean_length
    errors = sigma * np.random.default_rng(0).normal(size=len(exact.lengths))
    found = embed(exact.with_lengths(exact.lengths + errors), method="alexandrov", length_errors=sigma)
    deviation = isoembed.Sensitivity(found).deviation(sigma).dihedral_angles
    flat = ~found.surface.flat_faces.edges
    # Of deviations that were estimated to a third, the limit is five.
    assert (np.abs(found.surface.dihedral_angles[flat]) < 7 * deviation[flat]).all()


def test_the_report():
    vertices, faces = grid_cube(2)
    metric = scrambled(vertices, faces, 3)
    report = isoembed.report(embed(metric, method="alexandrov"))
    json.dumps(report, allow_nan=False)
    assert report["status"] == "converged" and report["method"] == "alexandrov"
    assert report["input"]["edges"] == metric.n_edges
    assert report["polyhedron"] == {"vertices": 8, "faces": 6, "flat_vertices": 18}
    assert report["certificate"]["certified"]
    assert report["uniqueness"]["evidence"] == "proved"
    assert "no other convex polyhedron" in report["uniqueness"]["basis"]
    assert report["residual"]["max"] >= report["residual"]["paths"]
    names = [stage["name"] for stage in report["stages"]]
    assert names == ["flat vertices", "polytope", "placement", "edge paths"]


def test_an_edge_that_is_not_found():
    lost = octahedron_with_a_lost_edge()
    a, b = lost.edge_paths.ends[5]
    assert lost.residual == np.inf and not lost.converged
    assert lost.message.startswith(f"the given edge from vertex {a} to {b} was not found")
    residual = isoembed.report(lost)["residual"]
    assert residual["max"] is residual["paths"] is None
    assert residual["mean"] < 1e-14
    json.dumps(isoembed.report(lost), allow_nan=False)


def test_two_factorizations():
    vertices, faces = zoo.icosphere(4)
    found = embed(scrambled(vertices * [3.0, 2.0, 1.0], faces, 0), method=Alexandrov())
    assert sum(stage.factorizations for stage in found.stages) == 2
    assert zoo.aligned(found.vertices, vertices * [3.0, 2.0, 1.0]) < 1e-12


def test_a_certificate_is_in_the_unit_of_its_polyhedron():
    metric = isoembed.PolyhedralMetric.from_mesh(*zoo.icosphere(1))
    body = isoembed.embed(metric.normalized, method="alexandrov")
    before = isoembed.certify(body)
    after = isoembed.certify(body._in_unit_of(metric.scaled(1024.0)))
    assert before.certified and after.certified
    assert after.distance / before.distance == 1024.0 * metric.unit
