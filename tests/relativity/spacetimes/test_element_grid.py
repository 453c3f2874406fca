"""Slices on curved elements: converge exponentially to the closed form, and say their errors."""

import numpy as np
import pytest

from elements import gauss, gauss_lobatto, shell
from isoembed.errors import InvalidParameter
from isoembed.relativity.energies.embedded_surface import embed_surface
from isoembed.relativity.spacetimes.element_grid import Element, ElementGrid
from isoembed.relativity.spacetimes.kerr_slices import KerrSchild
from isoembed.relativity.spacetimes.schwarzschild import IsotropicSchwarzschild
from isoembed.relativity.spacetimes.star_surface import StarSurface

HOLE = KerrSchild(1.0, (0.0, 0.3, 0.4))


def directions(n, seed=0):
    u = np.random.default_rng(seed).normal(size=(n, 3))
    return u / np.linalg.norm(u, axis=1, keepdims=True)


X = directions(200) * np.linspace(1.6, 2.6, 200)[:, None]


@pytest.mark.parametrize("nodes", [gauss, gauss_lobatto])
def test_convergence(nodes):
    misses = []
    for n in (4, 7, 10):
        grid = ElementGrid(shell(HOLE, n=(n, n, n), nodes=nodes))
        misses.append(
            [
                np.abs(getattr(grid, name)(X) - getattr(HOLE, name)(X)).max()
                for name in ("metric", "gradient", "extrinsic_curvature")
            ]
        )
    assert np.all(np.array(misses[1]) < 0.1 * np.array(misses[0]))
    assert np.all(np.array(misses[2]) < 0.1 * np.array(misses[1]))
    assert np.all(np.array(misses[2]) < [1e-5, 2e-4, 1e-5])


@pytest.mark.parametrize(("n", "along"), [((4, 4, 4), 1 / 12 * np.pi * 2.6), ((9, 9, 3), 0.5)])
def test_the_least_diameter_is_12_distances_between_nodes(n, along):
    """In the shell of 24 elements, 1.6 < r < 2.6, the nodes are on the half circle, or on the radius."""
    grid = ElementGrid(shell(HOLE, n=n))
    assert grid.least_diameter(X) == pytest.approx(12 * along, rel=0.1)


def test_polynomials_are_exact():
    """Of a cube that is sheared and stretched, with other numbers of nodes along each axis."""
    nodes = (gauss_lobatto(4), gauss(5), gauss_lobatto(3))
    place = np.stack(np.meshgrid(*nodes, indexing="ij"), axis=-1)
    map_ = np.array([[2.0, 0.3, 0.0], [0.0, 1.0, 0.5], [-0.2, 0.0, 0.7]])
    points = place @ map_.T + [5.0, 0.0, -3.0]

    def gamma(x):
        g = np.zeros((*x.shape[:-1], 6))
        g[..., 0], g[..., 3], g[..., 5] = 9 + x[..., 0] ** 2, 20 + x[..., 1] - x[..., 0], 9 + x[..., 2] ** 2
        g[..., 1] = 0.1 * x[..., 0] * x[..., 2]
        return g

    grid = ElementGrid([Element(nodes, points, gamma(points))])
    x = np.random.default_rng(1).uniform(-1, 1, (40, 3)) @ map_.T + [5.0, 0.0, -3.0]
    np.testing.assert_allclose(grid.metric(x)[:, *np.triu_indices(3)], gamma(x), atol=1e-12)
    slope = grid.gradient(x)
    np.testing.assert_allclose(slope[:, 0, 0, 0], 2 * x[:, 0], atol=1e-12)
    np.testing.assert_allclose(slope[:, 2, 1, 0], 0.1 * x[:, 0], atol=1e-12)
    np.testing.assert_allclose(slope[:, 1, 1, 1], 1.0, atol=1e-12)
    assert grid.time_symmetric and "time-symmetric" in grid.notes[0]
    assert not grid.extrinsic_curvature(x).any()


def test_stated_errors_are_at_least_those_made():
    surface, exact = StarSurface.sphere((0, 0, 0), 2.1), IsotropicSchwarzschild(1.0)
    u, errors = directions(50, 3), []
    for n in (5, 8):
        grid = ElementGrid(shell(exact, n=(n, n, n)))
        made = surface.mean_curvature(grid, u) - surface.mean_curvature(exact, u)
        said = grid.error(lambda slice_: surface.mean_curvature(slice_, u)[None])[0]
        assert np.abs(made).max() < np.abs(said).max()
        errors.append(np.abs(said).max())
    assert errors[1] < 0.1 * errors[0]


@pytest.mark.slow
def test_energies_of_a_surface_through_elements():
    surface = StarSurface.sphere((0, 0, 0), 2.1)
    there, exact = (
        embed_surface(surface.data(slice_)).energies.brown_york
        for slice_ in (ElementGrid(shell(HOLE, n=(9, 9, 9))), HOLE)
    )
    assert abs(there.value - exact.value) < there.error < 1e-2


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: ElementGrid([]), "must have at least one element"),
        (
            lambda: ElementGrid(
                [*shell(HOLE, n=(3, 3, 3)), *shell(IsotropicSchwarzschild(1.0), n=(3, 3, 3))]
            ),
            "all or none of the elements must have K_ij",
        ),
        (
            lambda: Element((gauss(3),) * 3, np.zeros((3, 3, 3, 3)), np.zeros((3, 3, 3, 3))),
            r"an element has gamma of the shape \(3, 3, 3, 3\), not \(3, 3, 3, 6\)",
        ),
        (
            lambda: ElementGrid(shell(HOLE, n=(3, 3, 3))).metric(np.array([[0, 0, 2.0], [0, 0, 2.9]])),
            r"point 1, \(0, 0, 2\.9\), lies in none of the 24 elements of the slice",
        ),
    ],
)
def test_refusals(make, sentence):
    with pytest.raises(InvalidParameter, match=sentence):
        make()
