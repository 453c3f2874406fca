"""Well spread vertices and their cells."""

import numpy as np
import pytest
from scipy.sparse.csgraph import dijkstra

import smooth_bodies
from isoembed.mesh.triangulation import Triangulation
from isoembed.surface.cells import VertexCells
from isoembed.surface.measures import edge_lengths


def ellipsoid(n):
    vertices, faces = smooth_bodies.ellipsoid(n)
    triangulation = Triangulation(faces)
    return triangulation, vertices, edge_lengths(triangulation.edges, vertices)


@pytest.mark.parametrize("count", [100, 300])
def test_about_as_many_are_chosen_as_wanted_and_each_is_in_its_own_cell(count):
    triangulation, x, lengths = ellipsoid(2000)
    cells = VertexCells.of(triangulation, lengths, x, count)
    assert 0.6 * count < len(cells.vertices) < 1.6 * count
    assert (cells.of_vertex[cells.vertices] == np.arange(len(cells.vertices))).all()
    assert cells.of_vertex.min() == 0


def test_no_vertex_is_far_from_the_one_of_its_cell_and_those_are_not_near_to_each_other():
    triangulation, x, lengths = ellipsoid(2000)
    cells = VertexCells.of(triangulation, lengths, x, 200)
    hops = dijkstra(triangulation.adjacency, indices=cells.vertices, unweighted=True)
    assert hops[cells.of_vertex, np.arange(len(x))].max() <= 5
    apart = hops[:, cells.vertices] + 99 * np.eye(len(cells.vertices))
    assert apart.min() >= 2


def test_cells_are_smaller_where_charts_are_distorted():
    triangulation, x, lengths = ellipsoid(2000)
    even = VertexCells.of(triangulation, lengths, x, 200)
    stretched = np.where(x[triangulation.edges].mean(axis=1)[:, 0] > 0, 1.0, 3.0)
    graded = VertexCells.of(triangulation, lengths * stretched, x, 200)
    near = [np.abs(x[cells.vertices, 0]) < 0.4 for cells in (even, graded)]
    assert near[1].mean() > 1.5 * near[0].mean()


def test_the_triangles_of_chosen_vertices_cover_a_convex_surface_and_no_other():
    triangulation, x, lengths = ellipsoid(2000)
    cells = VertexCells.of(triangulation, lengths, x, 200)
    coarse = cells.triangulation(x)
    assert coarse.n_vertices == len(cells.vertices)
    assert len(coarse.faces) == 2 * len(cells.vertices) - 4
    dented = x.copy()
    dented[cells.vertices[7]] *= 0.5
    assert cells.triangulation(dented) is None
