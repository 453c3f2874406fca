"""Slices in openPMD files of CarpetX, compared with the closed form that they were made of."""

import pickle

import numpy as np
import pytest

pytest.importorskip("openpmd_api")

from carpet_data import METRIC, Level, write_carpetx
from isoembed.io.files import FileError
from isoembed.relativity.series.carpetx import carpetx_slices
from isoembed.relativity.series.moments import simulation
from isoembed.relativity.spacetimes.kerr_slices import KerrSchild

KERR = KerrSchild(1.0, (0.1, 0.2, 0.5))
UPRIGHT = KerrSchild(1.0, (0.0, 0.0, 0.6))
LEVELS = (
    Level(0.4, (((-4.8, -4.4, -4.0), (4.8, 4.4, 4.4)),)),
    Level(0.2, (((-3.0, -3.2, -3.0), (3.4, 3.0, 3.2)),), 3),
)


def sphere(radius, n=200):
    u = np.random.default_rng(1).normal(size=(n, 3))
    return radius * u / np.linalg.norm(u, axis=1)[:, None]


def listed(folder):
    return carpetx_slices(path for path in sorted(folder.rglob("*")) if path.is_file())


def read(listing, x):
    return pickle.loads(pickle.dumps(listing.source)).read(x.min(axis=0), x.max(axis=0))


def worst(grid, geometry, x):
    metric = np.abs(grid.metric(x) - geometry.metric(x)).max()
    return max(metric, np.abs(grid.extrinsic_curvature(x) - geometry.extrinsic_curvature(x)).max())


def test_the_finest_level_that_covers_the_surface_is_read(tmp_path):
    for iteration in (0, 64):
        write_carpetx(tmp_path, KERR, LEVELS, iteration, 0.01 * iteration)
    first, second = listed(tmp_path)
    assert [(first.iteration, first.time), (second.iteration, second.time)] == [(0, 0.0), (64, 0.64)]
    fine, coarse = read(second, sphere(2.0)), read(second, sphere(2.6))
    assert (fine.spacing[0], coarse.spacing[0]) == pytest.approx((0.2, 0.4))
    assert worst(fine, KERR, sphere(2.0)) < 2e-5
    assert worst(coarse, KERR, sphere(2.6)) < 2e-3
    with pytest.raises(FileError, match="no refinement level covers"):
        read(second, sphere(4.0))


@pytest.mark.parametrize("shift", [0.0, 0.5])
def test_reflections_complete_the_grid(tmp_path, shift):
    level = Level(0.2, (((-3.0, -3.0, 0.0), (3.0, 3.0, 3.0)),), 2, shift=shift)
    write_carpetx(tmp_path, UPRIGHT, (level,), parameters="CarpetX::reflection_z = yes\n")
    assert worst(read(listed(tmp_path)[0], sphere(2.0)), UPRIGHT, sphere(2.0)) < 2e-5


def test_the_hash_is_of_the_data(tmp_path):
    hashes = []
    for number, geometry in enumerate((KERR, KERR, UPRIGHT)):
        write_carpetx(tmp_path / str(number), geometry, LEVELS[:1])
        hashes.append(listed(tmp_path / str(number))[0].source.digest())
    assert hashes[0] == hashes[1] != hashes[2]


def test_what_is_missing_or_damaged_is_said(tmp_path):
    write_carpetx(tmp_path / "metric", KERR, LEVELS[:1], names=METRIC)
    with pytest.raises(FileError, match="has no kxx, kxy, kxz, kyy, kyz, kzz"):
        read(listed(tmp_path / "metric")[0], sphere(2.0))
    damaged = tmp_path / "damaged" / "run.it00000000.bp4"
    damaged.mkdir(parents=True)
    (damaged / "data.0").write_bytes(b"")
    with pytest.raises(FileError, match=r"run\.it00000000\.bp4 is not a readable openPMD file"):
        listed(tmp_path / "damaged")


def test_simulations_of_carpetx(tmp_path):
    pytest.importorskip("kuibit")
    write_carpetx(tmp_path / "output-0000", KERR, LEVELS[:1], 32, 0.5)
    shapes, slices = simulation(tmp_path)
    assert shapes == []
    assert [(each.iteration, each.time) for each in slices] == [(32, 0.5)]
