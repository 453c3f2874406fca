"""Symmetries of runs."""

import numpy as np
import pytest

from isoembed.relativity.series.grid_symmetry import IDENTITY, symmetry_in
from isoembed.relativity.spacetimes.cartesian_grid import ENTRY

REFLECTION = "ReflectionSymmetry::reflection_{} = {}\n"


@pytest.mark.parametrize(
    ("parameters", "maps"),
    [
        ("", 1),
        (REFLECTION.format("z", "no"), 1),
        (REFLECTION.format("z", "yes"), 2),
        ("".join(REFLECTION.format(axis, '"yes"') for axis in "xyz"), 8),
        ("RotatingSymmetry180::poison_boundaries = no\n", 2),
        ("RotatingSymmetry180::poison_boundaries = no\n" + REFLECTION.format("z", "1"), 4),
        ("RotatingSymmetry90::poison_boundaries = no\n", 4),
        ("CarpetX::reflection_x = yes\n", 2),
        ("grid::domain = octant\n", 8),
        ("grid::domain = quadrant\ngrid::quadrant_direction = z\n", 4),
        ("grid::domain = bitant\ngrid::bitant_plane = xy\n", 2),
    ],
)
def test_maps_are_a_group(parameters, maps):
    symmetry = symmetry_in(parameters)
    assert symmetry[0] == IDENTITY
    assert len(set(symmetry)) == len(symmetry) == maps
    assert {a.after(b) for a in symmetry for b in symmetry} == set(symmetry)


@pytest.mark.parametrize("turn", symmetry_in("RotatingSymmetry90::x = no\nCarpetX::reflection_z = yes\n"))
def test_points_values_and_matrices_go_the_same_way(turn):
    rng = np.random.default_rng(5)
    matrix = np.zeros((3, 3))
    matrix[range(3), turn.source] = turn.sign
    x, six = rng.normal(size=3), rng.normal(size=6)
    np.testing.assert_array_equal(matrix @ x, turn.sign * turn.permuted(x))
    expected = matrix @ six[ENTRY] @ matrix.T
    for k, (i, j) in enumerate(((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))):
        source, sign = turn.entry(k)
        assert sign * six[source] == expected[i, j]
    values = rng.normal(size=(2, 3, 4))
    centers = (np.array(values.shape) - 1) / 2
    turned = turn.turned(values)
    old = np.array([1, 2, 0])
    new = matrix @ (old - centers) + (np.array(turned.shape) - 1) / 2
    assert turned[tuple(np.rint(new).astype(int))] == values[tuple(old)]
