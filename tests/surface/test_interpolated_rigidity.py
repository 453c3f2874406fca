"""Edges measured on interpolated surfaces."""

import numpy as np
from scipy.sparse import csr_array

from isoembed.gallery import Ellipsoid, triangulate
from isoembed.mesh.triangulation import Triangulation
from isoembed.surface.cells import VertexCells
from isoembed.surface.interpolated_rigidity import DIAGONAL_SHIFT, MAX_EDGES, InterpolatedRigidity
from isoembed.surface.interpolation import Stencils
from isoembed.surface.measures import edge_lengths


def rigidity(n=800, count=100):
    x, faces = triangulate(Ellipsoid((1.3, 1.1, 1)), n)
    triangulation = Triangulation(faces)
    lengths = edge_lengths(triangulation.edges, x)
    cells = VertexCells.of(triangulation, lengths, x, count)
    stencils = Stencils(cells, cells.triangulation(x))
    return triangulation, x, lengths, cells, InterpolatedRigidity(triangulation, stencils)


def dense(matrix, columns):
    """What a matrix does to each unit vector."""
    return np.column_stack([(matrix @ np.tile(unit[:, None], 3))[:, 0] for unit in np.eye(columns)])


def test_every_cell_is_measured_and_none_too_much():
    for count in (40, 100, 400):
        triangulation, _, _, cells, edges = rigidity(count=count)
        counts = np.bincount(edges.of_edge, minlength=len(cells.vertices))
        assert counts.min() >= 3
        assert counts.max() <= MAX_EDGES
        ends = cells.of_vertex[triangulation.edges[edges.edges]]
        assert (ends == edges.of_edge[:, None]).any(axis=1).all()
        whole = np.bincount(cells.of_vertex[triangulation.edges[:, 0]], minlength=len(counts))
        assert (counts[whole >= 60] == MAX_EDGES).all()


def test_interpolated_edges_are_those_of_the_surface():
    triangulation, x, _, cells, edges = rigidity(3000, 700)
    d = edges.interpolated(x)[1] @ x[cells.vertices]
    a, b = triangulation.edges[edges.edges].T
    assert np.abs(d - (x[a] - x[b])).max() < 1e-3 * np.linalg.norm(x[a] - x[b], axis=1).mean()


def test_the_factor_is_that_of_the_products_of_the_rows():
    _, x, lengths, cells, edges = rigidity()
    (_, differences), n = edges.interpolated(x), len(cells.vertices)
    rows = (differences @ x[cells.vertices]) / lengths[edges.edges][:, None]
    rng = np.random.default_rng(0)
    penalty = csr_array(np.diag(rng.uniform(0.1, 1.0, n)))
    J = np.einsum("ec,ek->eck", dense(differences, n), rows).reshape(len(rows), 3 * n)
    matrix = J.T @ J + np.kron(penalty.toarray(), np.eye(3))
    matrix[np.diag_indices_from(matrix)] *= 1 + DIAGONAL_SHIFT
    b = rng.normal(size=3 * n)
    np.testing.assert_allclose(matrix @ edges.factor(differences, rows, penalty).solve(b), b, atol=1e-6)
