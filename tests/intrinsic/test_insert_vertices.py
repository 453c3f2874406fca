"""Flat vertices come back to where they were, on triangles that are a simplicial complex."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import curved
import zoo
from isoembed.errors import InvalidMetric
from isoembed.intrinsic.flat_vertices import Removal, remove_flat_vertices
from isoembed.intrinsic.halfedges import HalfEdges
from isoembed.intrinsic.insert_vertices import insert_vertices
from isoembed.mesh.triangulation import Triangulation
from isoembed.space import Space
from isoembed.space.models import from_model
from scrambling import scramble
from sprinkled import box, checked, distances, doubled, polyhedron, sprinkled, tables_of, turning_errors


def there_and_back(tables, vertices, flat, seed):
    """Remove the flat vertices, flip to the polyhedron of the others, and put them back."""
    core, removal = remove_flat_vertices(tables, flat)
    scramble(core, 10 * (~flat).sum(), np.random.default_rng(seed), 1e-2)
    core, bent = polyhedron(core, vertices[~flat])
    return insert_vertices(core, removal, bent), core, bent


def worst_angle_sum(restored):
    """The largest sum of the two angles across from an edge inside a face of the polyhedron."""
    tables = restored.tables
    across = np.roll(checked(tables).triangles.angles, 1, axis=1).ravel()
    return (across + across[tables.twins])[~restored.kept].max()


@pytest.mark.parametrize("n", [2, 3, 5, 8, 16])
@pytest.mark.parametrize(
    "sides", [(1.0, 1.0, 1.0), (3.0, 2.0, 1.0), (1000.0, 1.0, 1.0), (1e-12, 1e-12, 1e-12), (1e12, 2e12, 1e12)]
)
def test_grids_on_boxes(n, sides):
    vertices, faces, flat = box(n, sides)
    tables = tables_of(vertices, faces)
    scramble(tables, 4 * len(vertices), np.random.default_rng(n), 1e-2 * min(sides) / max(sides))
    restored, core, bent = there_and_back(tables, vertices, flat, n)
    size = max(sides)
    found = restored.vertices(vertices[~flat])
    assert np.abs(found - vertices).max() < 1e-11 * size
    Triangulation(restored.tables.faces)  # raises unless it is a simplicial complex
    assert restored.kept.sum() == n * bent.sum() == 24 * n
    assert restored.tables.lengths == pytest.approx(distances(restored.tables, vertices), abs=1e-11 * size)
    assert worst_angle_sum(restored) < np.pi + 1e-6
    assert np.array_equal(restored.core, np.flatnonzero(~flat))
    assert np.array_equal(restored.flat, np.flatnonzero(flat))
    assert np.array_equal(restored.corners, core.faces[restored.faces])
    assert (restored.barycentric >= 0).all()
    assert restored.barycentric.sum(axis=1) == pytest.approx(np.ones(flat.sum()), rel=1e-15)


@given(st.integers(4, 20), st.integers(0, 100), st.integers(0, 10**6), st.sampled_from([1.0, 30.0, 300.0]))
def test_sprinkled_hulls(n, m, seed, length):
    body, hull = zoo.random_hull(n, seed)
    vertices, faces, flat = sprinkled(body * [length, 1, 1], hull, m, seed)
    tables = tables_of(vertices, faces)
    scramble(tables, 4 * len(vertices), np.random.default_rng(seed), 1e-2)
    restored, _, bent = there_and_back(tables, vertices, flat, seed)
    assert bent.all()
    assert np.abs(restored.vertices(vertices[~flat]) - vertices).max() < 1e-10 * length
    Triangulation(restored.tables.faces)
    assert restored.tables.lengths == pytest.approx(distances(restored.tables, vertices), abs=1e-10 * length)
    assert checked(restored.tables).deficits[flat] == pytest.approx(np.zeros(m), abs=1e-6)
    assert turning_errors(restored.tables).max() < 1e-6


@pytest.mark.parametrize("curvature", [-1.0, 1.0, 1e-14])
@pytest.mark.parametrize("size", [1e-2, 1.0, 3.0])
@given(st.integers(4, 20), st.integers(0, 60), st.integers(0, 10**6), st.sampled_from([1.0, 30.0]))
def test_in_hyperbolic_and_spherical_space(curvature, size, n, m, seed, aspect):
    x, faces, flat = curved.body(n, seed, curvature, size, m, aspect)
    tables = curved.tables_in(x, faces, curvature)
    scramble(tables, 4 * len(x), np.random.default_rng(seed), 1e-2)
    core, removal = remove_flat_vertices(tables, flat)
    scramble(core, 10 * n, np.random.default_rng(seed), 1e-2)
    core, bent = curved.polyhedron_in(core, x[~flat])
    restored = insert_vertices(core, removal, bent)
    assert np.abs(restored.vertices(x[~flat]) - x).max() < 1e-10 * size
    Triangulation(restored.tables.faces)
    found = curved.distances_in(restored.tables, x)
    assert restored.tables.lengths == pytest.approx(found, abs=1e-10 * size)
    # Directions grow around every vertex by the angles, and those of edges that were there are the same.
    total = curved.angle_sums(restored.tables)
    before = curved.tables_in(x, faces, curvature)
    known = {
        (a, b): direction
        for a, b, direction in zip(
            before.corners.tolist(), before.corners[before.twins].tolist(), before.directions, strict=True
        )
    }
    after = restored.tables
    for a, b, direction in zip(
        after.corners.tolist(), after.corners[after.twins].tolist(), after.directions, strict=True
    ):
        if (a, b) in known:
            turns = (direction - known[a, b]) / total[a]
            assert abs(turns - round(turns)) < 1e-6


@pytest.mark.parametrize("curvature", [-1.0, 1.0, 0.0])
@pytest.mark.parametrize("m", [1, 8])
def test_a_triangle_covered_twice_with_all_flat_vertices_on_its_sides(curvature, m):
    # Both sheets would need the same edges: one vertex is added.
    y = np.array([[-0.8, -0.5, 0.0], [0.8, -0.4, 0.0], [0.1, 0.8, 0.0]])
    side = np.repeat(np.arange(3), m)
    t = np.random.default_rng(m).uniform(0.1, 0.9, side.size)[:, None]
    space = Space(curvature)
    x = from_model(space, np.vstack([y, (1 - t) * y[side] + t * y[(side + 1) % 3]]), "projective")
    lengths = space.distances(x[[[0, 1, 2], [0, 2, 1]]], x[[[1, 2, 0], [2, 1, 0]]])
    twins = np.array([5, 4, 3, 2, 1, 0])
    tables = HalfEdges.of(np.array([[0, 1, 2], [0, 2, 1]]), twins, lengths, curvature)
    n = len(x)
    removal = Removal(
        np.arange(3),
        np.arange(3, n),
        side,
        tables.directions[side],
        space.distances(x[side], x[3:]),
        np.zeros(n - 3),
    )
    restored = insert_vertices(tables, removal, np.ones(6, dtype=bool))
    found = restored.vertices(x[:3])
    assert found == pytest.approx(np.vstack([x, space.center(x[:3])]), abs=1e-14)
    assert restored.tables.lengths == pytest.approx(curved.distances_in(restored.tables, found), abs=1e-13)
    Triangulation(restored.tables.faces)


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("m", [0, 1, 40])
def test_polygons_covered_twice(seed, m):
    # Both sheets have the same Delaunay triangulation, in which all diagonals are double.
    points, sheets = doubled(4 + seed % 5, seed, length=3.0)
    vertices, faces, flat = sprinkled(points, sheets, m, seed)
    restored, _, bent = there_and_back(tables_of(vertices, faces), vertices, flat, seed)
    assert bent.sum() == 2 * len(points)
    assert np.abs(restored.vertices(vertices[~flat]) - vertices).max() < 1e-10
    Triangulation(restored.tables.faces)


def test_a_square_covered_twice_has_one_diagonal_on_each_side():
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    tables = tables_of(vertices, np.array([[0, 1, 2], [0, 2, 3], [1, 0, 3], [1, 3, 2]]))
    restored, _, _ = there_and_back(tables, vertices, np.zeros(4, dtype=bool), 0)
    diagonals = restored.tables.lengths > 1.2
    assert diagonals.sum() == 4
    assert np.unique(restored.tables.corners[diagonals]).tolist() == [0, 1, 2, 3]


@pytest.mark.parametrize("seed", range(5))
def test_without_edges_to_keep_the_triangles_are_polygons(seed):
    vertices, faces, flat = box(4)
    core, removal = remove_flat_vertices(tables_of(vertices, faces), flat)
    scramble(core, 50, np.random.default_rng(seed), 1e-2)
    restored = insert_vertices(core, removal, np.zeros(core.twins.size, dtype=bool))
    assert not restored.kept.any()
    assert checked(restored.tables).deficits == pytest.approx(np.where(flat, 0, np.pi / 2), abs=1e-12)
    assert turning_errors(restored.tables).max() < 1e-12
    # The whole surface is found again from there.
    again, _ = remove_flat_vertices(restored.tables, flat)
    assert np.sort(again.lengths) == pytest.approx([1.0] * 24 + [2**0.5] * 12, rel=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_between_too_few_edges_the_triangles_are_polygons(seed):
    # Some of the cube's edges are not kept: the faces beside them make an L, or bend around a corner.
    vertices, faces, flat = box(3)
    core, removal = remove_flat_vertices(tables_of(vertices, faces), flat)
    core, bent = polyhedron(core, vertices[~flat])
    dropped = np.random.default_rng(seed).choice(np.flatnonzero(bent), 4)
    bent[dropped] = bent[core.twins[dropped]] = False
    restored = insert_vertices(core, removal, bent)
    assert np.abs(restored.vertices(vertices[~flat]) - vertices).max() < 1e-13
    assert checked(restored.tables).deficits == pytest.approx(np.where(flat, 0, np.pi / 2), abs=1e-13)
    assert restored.kept.sum() == 3 * bent.sum()


@pytest.mark.parametrize("off", [1e-3, 1e-6, 1e-7, 1e-9, 1e-10, 1e-12])
def test_near_an_edge_that_is_kept(off):
    # Next to the middle of an edge of the cube; where rounding brought it there, it is on the edge.
    body, hull = zoo.cube()
    face = next(f for f in hull if (body[f][:, 2] == 1).all())
    a, b, c = body[face]
    vertices = np.vstack([body, (0.5 - off / 2) * (a + b) + off * c])
    i, j, k = face
    others = [f for f in hull if f.tolist() != face.tolist()]
    tables = tables_of(
        np.vstack([body, (a + b + c) / 3]), np.vstack([others, [[i, j, 8], [j, k, 8], [k, i, 8]]])
    )
    flat = np.arange(9) == 8
    core, removal = remove_flat_vertices(tables, flat)
    where = Removal(
        removal.core,
        removal.removed,
        np.array([i]),
        tables.directions[[3 * (len(hull) - 1)]]
        + np.arctan2(*_in_plane(vertices[8] - a, b - a, c - a)[::-1]),
        np.array([np.linalg.norm(vertices[8] - a)]),
        removal.backs,
    )
    core, bent = polyhedron(core, body)
    restored = insert_vertices(core, where, bent)
    assert np.abs(restored.vertices(body) - vertices).max() < 1e-14
    Triangulation(restored.tables.faces)
    assert checked(restored.tables).deficits[8] == pytest.approx(0, abs=1e-7)
    assert (restored.kept.sum() == 26) == (off < 1e-11)
    errors = np.abs(restored.tables.lengths - distances(restored.tables, vertices))
    assert errors.max() < (off if off < 1e-11 else 1e-14)


def _in_plane(vector, x, y):
    """Coordinates of a vector, along x and across it toward y."""
    x = x / np.linalg.norm(x)
    across = y - (y @ x) * x
    return np.array([vector @ x, vector @ across / np.linalg.norm(across)])


def test_what_was_given_stays():
    vertices, faces, flat = box(3)
    core, removal = remove_flat_vertices(tables_of(vertices, faces), flat)
    core, bent = polyhedron(core, vertices[~flat])
    before, kept = core.copy(), bent.copy()
    restored = insert_vertices(core, removal, bent)
    for table in ("corners", "twins", "lengths", "directions"):
        assert np.array_equal(getattr(core, table), getattr(before, table))
    assert np.array_equal(bent, kept)
    for table in (restored.kept, restored.flat, restored.faces, restored.barycentric, restored.corners):
        assert not table.flags.writeable


@pytest.mark.slow  # a million triangles, where it is not compiled
def test_a_vertex_that_is_nowhere():
    vertices, faces, flat = box(2)
    core, removal = remove_flat_vertices(tables_of(vertices, faces), flat)
    distances = removal.distances.copy()
    distances[-1] = np.inf
    elsewhere = Removal(
        removal.core, removal.removed, removal.anchors, removal.directions, distances, removal.backs
    )
    with pytest.raises(
        InvalidMetric, match=f"vertex {removal.removed[-1]}, which is flat, is not found again"
    ):
        insert_vertices(core, elsewhere, np.ones(core.twins.size, dtype=bool))
