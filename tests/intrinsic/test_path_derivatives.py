"""Derivatives of the lengths of paths: against paths over changed triangles, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest

import isoembed
import zoo
from isoembed.intrinsic.edge_paths import edge_paths
from isoembed.intrinsic.path_derivatives import path_derivatives
from isoembed.intrinsic.polygons import lay_out
from scrambling import scramble
from sprinkled import tables_of


def paths_over(original, final):
    """The edges of one triangulation on another of the same metric, each triangle a polygon."""
    return edge_paths(
        original, final, lay_out(final, np.ones(final.corners.size, dtype=bool)), original.edges
    )


def both(seed, flips=400):
    """A hull's triangles, and others after random flips, with what those of the hull are on these."""
    hull = tables_of(*zoo.random_hull(20, seed))
    other = hull.copy()
    scramble(other, flips, np.random.default_rng(seed), thinnest=0.02)
    return hull, other


@pytest.mark.parametrize("seed", range(4))
def test_lengths_are_homogeneous(seed):
    # All lengths grow alike, so that the sum of derivatives times lengths is the path's length.
    hull, other = both(seed)
    paths = paths_over(other, hull)
    assert np.diff(paths.offsets).max() > 2
    assert np.allclose(path_derivatives(paths) @ hull.lengths, paths.lengths, rtol=1e-12)


@pytest.mark.parametrize("seed", range(4))
def test_against_the_same_flips_of_other_lengths(seed):
    # A flip's new edge is a path over two triangles, whose length the flip knows.
    hull, other = both(seed)
    h = 1e-6
    changes = np.random.default_rng(seed).standard_normal(hull.corners.size)
    changes = h * (changes + changes[hull.twins])
    sides = []
    for sign in (1, -1):
        mesh = hull._replace(lengths=hull.lengths + sign * changes).copy()
        scramble(mesh, 400, np.random.default_rng(seed), thinnest=0.02)
        assert np.array_equal(mesh.corners, other.corners)
        sides.append(mesh.lengths[other.edges])
    rates = path_derivatives(paths_over(other, hull)) @ changes
    assert np.abs((sides[0] - sides[1]) / 2 - rates).max() < 1e-6 * np.abs(rates).max()


def test_what_has_none():
    hull, other = both(0)
    paths = paths_over(other, hull)
    lost = replace(paths, distances=np.where(np.arange(len(paths.ends)) == 3, np.nan, paths.distances))
    with pytest.raises(
        isoembed.InvalidParameter, match=r"the path of edge 3 \[\d+, \d+\] has not been found"
    ):
        path_derivatives(lost)
    with pytest.raises(isoembed.InvalidParameter, match="the triangles have the curvature -1, not 0"):
        path_derivatives(replace(paths, tables=hull._replace(curvature=-1.0)))
