"""Interpolation of smooth functions from chosen vertices."""

from functools import cache

import numpy as np
import pytest

from isoembed.gallery import Ellipsoid, triangulate
from isoembed.mesh.triangulation import Triangulation
from isoembed.surface.cells import VertexCells
from isoembed.surface.interpolation import CellRows, Stencils
from isoembed.surface.measures import edge_lengths


@cache
def body(n):
    """A surface whose curvature 250 cells resolve: (vertices, faces)."""
    return triangulate(Ellipsoid((1.3, 1.1, 1)), n)


def interpolation(n, count):
    x, faces = body(n)
    triangulation = Triangulation(faces)
    cells = VertexCells.of(triangulation, edge_lengths(triangulation.edges, x), x, count)
    stencils = Stencils(cells, cells.triangulation(x))
    P = stencils.interpolation(x, faces, np.arange(n), cells.of_vertex)
    return x, cells, stencils, P


def test_constants_come_out_as_they_are():
    _, cells, stencils, P = interpolation(2000, 300)
    assert P.shape == (2000, len(cells.vertices))
    np.testing.assert_allclose(P.sum(axis=1), 1.0, atol=1e-11)
    assert (np.diff(P.indptr) == np.diff(stencils.pattern.indptr)[cells.of_vertex]).all()


def test_errors_of_smooth_functions_fall_with_the_sixth_power_of_the_spacing():
    errors = []
    for count in (250, 750):
        x, cells, _, P = interpolation(2000, count)
        values = np.sin(x[:, 0]) * np.exp(x[:, 1] / 2) + x[:, 2] ** 2
        errors.append(np.sqrt(np.mean((P @ values[cells.vertices] - values) ** 2)))
    assert errors[1] < 1e-4
    assert errors[0] / errors[1] > 3**2.5


@pytest.mark.parametrize("unit", [1e-3, 1e4])
def test_the_unit_does_not_matter(unit):
    x, cells, stencils, P = interpolation(2000, 300)
    faces = body(2000)[1]
    other = stencils.interpolation(unit * x, faces, np.arange(len(x)), cells.of_vertex)
    np.testing.assert_allclose(other.data, P.data, atol=1e-7)


def test_products_cell_by_cell_are_those_of_the_matrix():
    _, cells, stencils, P = interpolation(2000, 300)
    order, rng = np.argsort(cells.of_vertex), np.random.default_rng(0)
    rows = CellRows.of(stencils, P[order].data, order, cells.of_vertex[order])
    values, forces = rng.normal(size=(P.shape[1], 3)), rng.normal(size=(2000, 3))
    np.testing.assert_allclose(rows @ values, P @ values, atol=1e-12)
    np.testing.assert_allclose(rows.transposed(forces), P.T @ forces, atol=1e-12)
