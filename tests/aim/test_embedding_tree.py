"""The embedding tree: an inscribed polyhedron from its lengths, the first edge, lengths no sphere has."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import smooth_bodies
import zoo
from isoembed.aim.embedding_tree import embedding_tree
from isoembed.metric.polyhedral import PolyhedralMetric


def inscribed(n, seed):
    """Hull of n random points on the unit sphere, none far from its neighbors."""
    x = np.random.default_rng(seed).normal(size=(n, 3))
    return zoo.outward_hull(x / np.linalg.norm(x, axis=1)[:, None])


def tree(metric, radius, root=0):
    return embedding_tree(metric, radius, root, smooth_bodies.recorder()).vertices


@given(st.integers(0, 10**6), st.floats(1e-3, 1e3))
def test_an_inscribed_polyhedron_is_recovered(seed, radius):
    x, faces = inscribed(60, seed)
    metric = PolyhedralMetric.from_mesh(radius * x, faces)
    root = int(np.argmin(metric.face_lengths.max(axis=1)))
    placed = tree(metric, radius, root)
    assert np.linalg.norm(placed, axis=1) == pytest.approx(radius, rel=1e-14)
    assert smooth_bodies.misfit(placed / radius, x) < 1e-7


@pytest.mark.parametrize("root", [0, 17, 319])
def test_from_any_root(root):
    x, faces = zoo.icosphere(2)
    placed = tree(PolyhedralMetric.from_mesh(x, faces), 1.0, root)
    assert smooth_bodies.misfit(placed, x) < 1e-10


def test_orientation_is_kept():
    x, faces = zoo.icosphere(1)
    placed = tree(PolyhedralMetric.from_mesh(x, faces), 1.0)
    a, b, c = (placed[faces[:, k]] for k in range(3))
    assert (np.einsum("ij,ij->i", np.cross(a, b), c) > 0).all()


@given(st.floats(1e-6, 1.4), st.floats(0.1, 10.0))
def test_the_first_edge_is_the_papers(length, r):
    l = length * r
    metric = PolyhedralMetric(zoo.TETRAHEDRON, [l] * 6)
    a, b, _ = tree(metric, r)[zoo.TETRAHEDRON[0]]
    assert a == pytest.approx([r / 2, r / 2, r / np.sqrt(2)], rel=1e-14)
    # Eqs. (xb)-(zb): at the same height, turned by the angle that the chord subtends on that circle.
    turned = 2 * np.arcsin(length / 2 / np.sqrt(0.5))
    angle = np.pi / 4 - turned
    assert b[:2] == pytest.approx(np.array([np.cos(angle), np.sin(angle)]) * r / np.sqrt(2), abs=1e-9 * r)
    assert b[2] == pytest.approx(r / np.sqrt(2), rel=1e-12)
    assert np.linalg.norm(b - a) == pytest.approx(l, rel=1e-9, abs=1e-15)


@pytest.mark.parametrize("root", [-1, 4, 100])
def test_there_is_no_such_root(root):
    metric = PolyhedralMetric(zoo.TETRAHEDRON, [1.0] * 6)
    with pytest.raises(ValueError, match=f"root is {root}, but the faces are numbered from 0 to 3"):
        tree(metric, 1.0, root)


@pytest.mark.parametrize("radius", [0.3, 0.5])
def test_lengths_beyond_the_sphere_get_points_on_it(radius):
    x, faces = inscribed(20, 0)
    placed = tree(PolyhedralMetric.from_mesh(x, faces), radius)
    assert np.linalg.norm(placed, axis=1) == pytest.approx(radius, rel=1e-13)


def test_layers_are_counted():
    recorder = smooth_bodies.recorder()
    x, faces = zoo.icosphere(1)
    embedding_tree(PolyhedralMetric.from_mesh(x, faces), 1.0, 0, recorder)
    # As many layers as triangles on the longest shortest way from the root, and none after.
    across = [{} for _ in faces]
    for f, face in enumerate(faces.tolist()):
        for g, other in enumerate(faces.tolist()):
            if len(set(face) & set(other)) == 2:
                across[f][g] = True
    seen, front, layers = {0}, [0], 0
    while front:
        layers += 1
        front = sorted({g for f in front for g in across[f]} - seen)
        seen |= set(front)
    assert recorder.iterations == layers


def test_every_vertex_is_placed_from_an_edge_of_a_layer_before():
    x, faces = inscribed(200, 3)
    metric = PolyhedralMetric.from_mesh(x, faces)
    root = 7
    found = embedding_tree(metric, 1.0, root, smooth_bodies.recorder())
    first = np.flatnonzero(found.pivots[:, 0] < 0)
    a, b, c = faces[root]
    assert set(first) == {a, b}
    assert set(found.pivots[c]) == {a, b}
    assert set(np.flatnonzero(found.layers == 0)) == {a, b, c}
    triangles = {frozenset(face) for face in metric.faces.tolist()}
    rest = np.setdiff1d(np.arange(200), [a, b, c])
    for v in rest:
        assert frozenset((v, *found.pivots[v])) in triangles
    assert (found.layers[found.pivots[rest]] < found.layers[rest, None]).all()
    # Each vertex stands as far from the two as the metric says.
    for k in range(2):
        ends = np.column_stack([rest, found.pivots[rest, k]])
        away = np.linalg.norm(found.vertices[rest] - found.vertices[ends[:, 1]], axis=1)
        lengths = metric.lengths[metric.triangulation.edge_indices(ends)]
        assert away == pytest.approx(lengths, abs=1e-6)
    assert not (found.vertices.flags.writeable or found.layers.flags.writeable)
