"""Slices on refinement levels, each point on the finest one around it, compared with closed forms."""

import pickle

import numpy as np
import pytest

from isoembed.errors import InvalidParameter
from isoembed.io.files import FileError
from isoembed.relativity.horizons.finder import find_horizon
from isoembed.relativity.series.slice_files import read_slice
from isoembed.relativity.spacetimes.kerr_slices import KerrSchild
from isoembed.relativity.spacetimes.star_surface import StarSurface
from patch_data import Grid, plain, write_amrex

KERR = KerrSchild(1.0, (0.1, 0.2, 0.2))
WHOLE = (((0, 0, 0), (24, 24, 24)),)
NESTED = Grid((-6.0,) * 3, 0.5, (WHOLE, (((8, 8, 8), (32, 32, 32)),)))
UNEVEN = Grid((-6.0,) * 3, 0.5, (WHOLE, (((6, 6, 6), (36, 36, 18)),)))  # the fine level ends at z = 0


def sphere(radius, n=300):
    u = np.random.default_rng(1).normal(size=(n, 3))
    return radius * u / np.linalg.norm(u, axis=1)[:, None]


def errors(geometry, x, exact=KERR):
    """Largest errors of the metric, of its gradient and of K_ij at each point."""
    pairs = (
        (getattr(geometry, name)(x) - getattr(exact, name)(x)).reshape(len(x), -1)
        for name in ("metric", "gradient", "extrinsic_curvature")
    )
    return np.array([np.abs(difference).max(axis=1) for difference in pairs])


@pytest.fixture(scope="module")
def nested(tmp_path_factory):
    folder = tmp_path_factory.mktemp("nested") / "plt00000"
    write_amrex(folder, KERR, NESTED, plain)
    return folder


def test_each_point_is_interpolated_on_the_finest_level_around_it(tmp_path):
    write_amrex(tmp_path / "plt", KERR, UNEVEN, plain)
    x = sphere(2.5)
    metric, gradient, curvature = errors(read_slice(tmp_path / "plt"), x)
    fine = x[:, 2] < -4 * 0.25  # four cells away from the end of the level
    assert fine.sum() > 50
    assert metric[fine].max() < 1e-4 < metric[~fine].max() < 3e-2
    assert gradient[fine].max() < 1e-3 < gradient[~fine].max() < 1e-1
    assert curvature[fine].max() < 3e-4 < curvature[~fine].max() < 1e-1


def test_errors_fall_as_the_eighth_power_of_the_spacing(tmp_path):
    x = np.array([4.0, 1.0, -1.0]) + sphere(0.5, 40)
    worst = []
    for number, spacing in enumerate((0.5, 0.25)):
        start, cells = int(np.rint(8 / spacing)), int(np.rint(10 / spacing))
        boxes = ((((start, start // 2, start // 2), (cells,) * 3),),)
        write_amrex(tmp_path / str(number), KERR, Grid((-8.0,) * 3, spacing, boxes), plain)
        worst.append(errors(read_slice(tmp_path / str(number)), x).max(axis=1))
    assert (np.log2(worst[0] / worst[1]) > [7.0, 6.0, 7.0]).all()


def test_the_least_diameter_is_20_spacings_of_the_coarsest_level_there(nested):
    geometry = read_slice(nested)
    assert geometry.least_diameter(sphere(1.0)) == pytest.approx(20 * 0.25)
    assert geometry.least_diameter(sphere(3.5)) == pytest.approx(20 * 0.5)


def test_stated_errors_cover(nested):
    geometry, x = read_slice(nested), sphere(2.0)
    stated = np.abs(geometry.error(lambda slice_: slice_.metric(x).reshape(len(x), 9).T)).max(axis=0)
    assert (errors(geometry, x)[0] < 3 * stated).mean() > 0.99


def test_points_outside_are_refused(nested):
    geometry = read_slice(nested)
    low, high = geometry.box
    np.testing.assert_allclose([low, high], [[-4.25] * 3, [4.25] * 3])
    geometry.metric(np.stack([low + 1e-9, high - 1e-9]))
    with pytest.raises(
        InvalidParameter,
        match=r"point 1, \(4\.5, 0, 0\), is in no refinement level of .*plt00000 with 4 points on each side",
    ):
        geometry.metric(np.array([[0.0, 0.0, 3.0], [4.5, 0.0, 0.0]]))
    with pytest.raises(InvalidParameter, match="point 0, "):
        geometry.metric(np.full((1, 3), np.nan))


def test_files_that_change_are_noticed(nested, tmp_path):
    write_amrex(tmp_path / "plt", KERR, NESTED, plain)
    geometry = read_slice(tmp_path / "plt")
    copy = pickle.loads(pickle.dumps(geometry))
    np.testing.assert_array_equal(copy.metric(sphere(2.0)), geometry.metric(sphere(2.0)))
    (tmp_path / "plt" / "Level_0" / "Cell_D_00000").write_bytes(b"")
    np.testing.assert_array_equal(geometry.metric(sphere(2.0)), copy.metric(sphere(2.0)))  # was read before
    with pytest.raises(FileError, match="has changed since it was opened"):
        geometry.metric(sphere(4.0))


def test_cubes_are_dropped_without_a_change(tmp_path, monkeypatch):
    write_amrex(tmp_path / "plt", KERR, NESTED, plain)
    geometry, x = read_slice(tmp_path / "plt"), sphere(2.0)
    before = geometry.metric(x)
    monkeypatch.setattr("isoembed.relativity.series.amr_grid.KEPT", 1)
    for radius in (3.0, 4.0, 1.8):
        geometry.metric(sphere(radius))
    np.testing.assert_array_equal(geometry.metric(x), before)
    assert len(geometry._cubes) <= 8


@pytest.mark.slow
def test_a_horizon_across_the_end_of_a_level(tmp_path):
    boxes = ((((0, 0, 0), (48, 48, 48)),), (((24, 24, 24), (48, 48, 24)),))
    write_amrex(tmp_path / "plt", KERR, Grid((-6.0,) * 3, 0.25, boxes), plain)
    geometry = read_slice(tmp_path / "plt")
    assert "2 refinement levels, with spacings from 0.25 to 0.125" in geometry.notes[0]
    found = find_horizon(geometry, StarSurface.sphere((0, 0, 0), 2.2))
    assert abs(found.area / find_horizon(KERR).area - 1) < 1e-4
