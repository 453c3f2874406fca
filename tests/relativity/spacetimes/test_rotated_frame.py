"""Slices in another frame, and with a part of their extrinsic curvature, against closed forms."""

import numpy as np
import pytest

from gridded import sampled
from isoembed.relativity.horizons.symmetry_axis import symmetry_axis
from isoembed.relativity.spacetimes.kerr_slices import KerrSchild
from isoembed.relativity.spacetimes.schwarzschild import BrillLindquist, IsotropicSchwarzschild
from isoembed.relativity.spacetimes.star_surface import StarSurface
from isoembed.relativity.spacetimes.transformed import RotatedFrame, ScaledCurvature, Translated

ROTATION = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
ROTATION *= np.linalg.det(ROTATION)
ORIGIN = np.array([1.0, -2.0, 0.5])
X = np.random.default_rng(1).normal(size=(20, 3)) + 3.0
SPIN = np.array([0.1, 0.2, 0.6])


def test_a_tilted_hole_in_a_frame_of_its_own():
    framed = RotatedFrame(Translated(KerrSchild(1.0, (ROTATION @ SPIN).tolist()), ORIGIN), ORIGIN, ROTATION)
    upright = KerrSchild(1.0, SPIN)
    for field in ("metric", "gradient", "extrinsic_curvature"):
        assert getattr(framed, field)(X) == pytest.approx(getattr(upright, field)(X), abs=1e-14)
    ((_, at),) = framed.black_holes
    assert at == pytest.approx((0.0, 0.0, 0.0), abs=1e-15)
    assert not framed.time_symmetric


def test_the_box_of_a_grid_in_another_frame():
    grid = sampled(KerrSchild(1.0, SPIN), 9, 2.0, center=X[0])
    moved = Translated(grid, (1.0, 0.0, 0.0))
    np.testing.assert_allclose(moved.box, np.add(grid.box, (1.0, 0.0, 0.0)))
    low, high = RotatedFrame(moved, np.zeros(3), ROTATION).box
    corners = np.array(
        [[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])]
    )
    apart = corners @ ROTATION.T - X[0] - (1.0, 0.0, 0.0)
    np.testing.assert_allclose(np.linalg.norm(apart, axis=1), 2.0)
    assert moved.notes == grid.notes
    assert moved.least_diameter(X) == grid.least_diameter(X) == 20 * 0.5


def test_the_expansion_does_not_depend_on_the_frame():
    geometry = KerrSchild(1.0, SPIN)
    u = X / np.linalg.norm(X, axis=1)[:, None]
    here = StarSurface.sphere((0.0, 0.0, 0.0), 2.5)
    theta = here.expansion(RotatedFrame(geometry, np.zeros(3), ROTATION), u)
    assert theta == pytest.approx(here.expansion(geometry, u @ ROTATION.T), abs=1e-13)


def test_a_part_of_the_extrinsic_curvature():
    geometry = KerrSchild(1.0, SPIN)
    sphere, u = StarSurface.sphere((0.0, 0.0, 0.0), 2.5), X / np.linalg.norm(X, axis=1)[:, None]
    k, p = sphere.mean_curvature(geometry, u), sphere.momentum(geometry, u)
    for factor in (0.0, 0.3, 1.0):
        scaled = ScaledCurvature(geometry, factor)
        assert sphere.expansion(scaled, u) == pytest.approx(k - factor * p, abs=1e-14)
        assert scaled.time_symmetric == (factor == 0.0)


def test_axes_of_symmetry():
    sphere = StarSurface.sphere((0.0, 0.0, 0.0), 3.0)
    found = symmetry_axis(KerrSchild(1.0, SPIN), sphere)
    assert np.cross(found.rotation[:, 2], SPIN) == pytest.approx(np.zeros(3), abs=1e-12)
    axis = np.array([0.48, 0.6, 0.64])
    pair = BrillLindquist((0.3, 0.7), (0.2 * axis, -0.3 * axis))
    assert np.cross(symmetry_axis(pair, sphere).rotation[:, 2], axis) == pytest.approx(np.zeros(3), abs=1e-12)


def test_no_axis_where_there_is_none():
    three = BrillLindquist((0.3, 0.4, 0.5), ((0.5, 0.0, 0.0), (0.0, 0.4, 0.1), (-0.3, -0.2, 0.3)))
    assert symmetry_axis(three, StarSurface.sphere((0.0, 0.0, 0.0), 3.0)) is None
    off_center = StarSurface.sphere((0.1, 0.2, 0.0), 3.0)
    found = symmetry_axis(Translated(IsotropicSchwarzschild(1.0), (0.0, 0.0, 0.3)), off_center)
    assert np.cross(found.rotation[:, 2], (0.1, 0.2, -0.3)) == pytest.approx(np.zeros(3), abs=1e-12)
