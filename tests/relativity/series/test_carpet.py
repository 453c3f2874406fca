"""Slices in HDF5 files of Carpet, compared with the closed form that they were made of."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

h5py = pytest.importorskip("h5py")

from carpet_data import CURVATURE, METRIC, Level, cube, write_carpet  # noqa: E402
from isoembed.io.files import FileError  # noqa: E402
from isoembed.relativity.series.carpet_files import carpet_slices  # noqa: E402
from isoembed.relativity.series.slice_files import slices_in_file  # noqa: E402
from isoembed.relativity.spacetimes.kerr_slices import KerrSchild  # noqa: E402

KERR = KerrSchild(1.0, (0.1, 0.2, 0.5))
UPRIGHT = KerrSchild(1.0, (0.0, 0.0, 0.6))
SCHWARZSCHILD = KerrSchild(1.0, (0.0, 0.0, 0.0))
LEVELS = (Level(0.4, (cube(4.8),)), Level(0.2, (cube(3.0),), 3))


def sphere(radius, n=200):
    u = np.random.default_rng(1).normal(size=(n, 3))
    return radius * u / np.linalg.norm(u, axis=1)[:, None]


def listed(folder):
    return carpet_slices(path for path in folder.rglob("*") if path.is_file())


def read(folder, x, iteration=0):
    source = {each.iteration: each.source for each in listed(folder)}[iteration]
    return pickle.loads(pickle.dumps(source)).read(x.min(axis=0), x.max(axis=0))


def worst(grid, geometry, x):
    """Largest errors of the metric, of its gradient and of the extrinsic curvature."""
    return [
        np.abs(getattr(grid, name)(x) - getattr(geometry, name)(x)).max()
        for name in ("metric", "gradient", "extrinsic_curvature")
    ]


@pytest.fixture(scope="module")
def kerr(tmp_path_factory):
    folder = tmp_path_factory.mktemp("kerr")
    write_carpet(folder, KERR, LEVELS, iteration=128, time=0.8)
    return folder


def test_the_finest_level_that_covers_the_surface_is_read(kerr):
    x = sphere(2.0)
    grid = read(kerr, x, 128)
    assert grid.spacing == pytest.approx((0.2, 0.2, 0.2))
    assert max(worst(grid, KERR, x)) < 3e-4  # ghost zones hold 1000
    assert grid.gamma.shape == grid.K.shape == (6, 31, 31, 31)
    assert grid.notes == (
        "the slice is read from refinement level 1 of 0 to 1, of the spacing (0.2, 0.2, 0.2)",
    )


def test_what_is_not_covered_with_the_stencil_is_read_from_the_next_coarser_level(kerr):
    x = sphere(2.5)
    grid = read(kerr, x, 128)
    assert grid.spacing == pytest.approx((0.4, 0.4, 0.4))
    assert max(worst(grid, KERR, x)) < 3e-2
    errors = grid.error(lambda slice_: slice_.metric(x).reshape(-1, 9).T)
    assert np.abs(errors).max() > worst(grid, KERR, x)[0] / 3


def test_what_no_level_covers_is_one_sentence(kerr):
    with pytest.raises(
        FileError, match=r"no refinement level covers .* level 0 .* from \(-4.8, -4.8, -4.8\)"
    ):
        read(kerr, sphere(4.5), 128)


def test_errors_fall_as_the_eighth_power_of_the_spacing(tmp_path):
    center = (1.6, 0.8, 0.8)
    x = center + sphere(0.4)
    errors = []
    for number, spacing in enumerate((0.2, 0.1)):
        folder = tmp_path / str(number)
        write_carpet(folder, KERR, (Level(spacing, (cube(1.4, center),), 2),))
        errors.append(worst(read(folder, x), KERR, x))
    rates = np.log2(np.array(errors[0]) / errors[1])
    assert (rates > [7.0, 6.0, 7.0]).all()


def test_only_the_part_around_the_surface_is_read(kerr):
    center = np.array([0.0, 0.0, 1.9])
    x = center + sphere(0.3)
    grid = read(kerr, x, 128)
    low, high = grid.box
    assert (low >= x.min(axis=0) - 11 * 0.2).all()
    assert (high <= x.max(axis=0) + 11 * 0.2).all()
    assert max(worst(grid, KERR, x)) < 1e-2


@pytest.mark.parametrize(
    ("grouped", "processes", "pieces"), [(True, 1, 1), (True, 3, 3), (False, 2, 4), (False, 1, 1)]
)
def test_groups_processes_and_components_make_no_difference(tmp_path, kerr, grouped, processes, pieces):
    level = replace(LEVELS[1], pieces=pieces, axis=2)
    write_carpet(tmp_path, KERR, (level,), grouped=grouped, processes=processes)
    x = sphere(2.0)
    np.testing.assert_array_equal(read(tmp_path, x).gamma, read(kerr, x, 128).gamma)


def test_files_of_their_own_for_iterations(tmp_path):
    write_carpet(tmp_path, KERR, (LEVELS[0],))
    for path in list(tmp_path.iterdir()):
        path.rename(path.with_name(path.name.replace(".xyz", ".iter_0")))
    (tmp_path / "gxx.iter_0.idx.h5").write_bytes(b"an index, which has no data")
    assert read(tmp_path, sphere(2.6)).spacing == pytest.approx((0.4, 0.4, 0.4))


def test_each_of_two_boxes_of_a_level_is_found(tmp_path):
    centers = np.array([[2.4, 0.0, 0.0], [-2.4, 0.4, 0.0]])
    write_carpet(tmp_path, KERR, (LEVELS[0], Level(0.1, tuple(cube(0.9, center) for center in centers), 2)))
    for center in centers:
        x = center + sphere(0.4)
        grid = read(tmp_path, x)
        assert grid.spacing == pytest.approx((0.1, 0.1, 0.1))
        assert max(worst(grid, KERR, x)) < 1e-5
    common = np.concatenate(centers + sphere(0.4)[:, None])
    assert read(tmp_path, common).spacing == pytest.approx((0.4, 0.4, 0.4))


def test_a_gap_between_boxes_is_not_covered(tmp_path):
    boxes = tuple(((-3.0, -3.0, low), (3.0, 3.0, high)) for low, high in ((-3.0, -0.2), (0.2, 3.0)))
    write_carpet(tmp_path, KERR, (LEVELS[0], Level(0.2, boxes)))
    assert read(tmp_path, sphere(2.0)).spacing[0] == pytest.approx(0.4)


def test_files_without_ghost_zones(tmp_path):
    write_carpet(tmp_path, KERR, (LEVELS[1],), ghosts=0, parameters="IOHDF5::output_ghost_points = no\n")
    with h5py.File(tmp_path / "gxx.xyz.h5", "a") as file:
        for data in file.values():
            if "cctk_nghostzones" in data.attrs:
                data.attrs["cctk_nghostzones"] = np.full(3, 3)
    x = sphere(2.0)
    assert max(worst(read(tmp_path, x), KERR, x)) < 3e-4


@pytest.mark.parametrize(
    ("geometry", "kept", "parameters", "shift"),
    [
        (UPRIGHT, (2,), "ReflectionSymmetry::reflection_z = yes\n", 0.0),
        (SCHWARZSCHILD, (0, 1, 2), "grid::domain = octant\n", 0.5),
        (UPRIGHT, (0,), "RotatingSymmetry180::poison_boundaries = yes\n", 0.5),
        (UPRIGHT, (0, 1), "RotatingSymmetry90::poison_boundaries = yes\n", 0.0),
    ],
)
def test_what_symmetric_runs_leave_out_is_completed(tmp_path, geometry, kept, parameters, shift):
    level = Level(0.2, (cube(3.0),), 2, shift=shift)
    write_carpet(tmp_path, geometry, (level,), kept=kept, parameters=parameters)
    x = sphere(2.0)
    assert max(worst(read(tmp_path, x), geometry, x)) < 3e-4


def test_without_its_symmetry_half_a_grid_does_not_cover(tmp_path):
    write_carpet(tmp_path, UPRIGHT, (LEVELS[1],), kept=(2,))
    with pytest.raises(FileError, match="no refinement level covers"):
        read(tmp_path, sphere(2.0))


def test_of_restarts_the_last_counts(tmp_path):
    for restart, geometry in enumerate((SCHWARZSCHILD, KERR)):
        folder = tmp_path / f"output-{restart + 9:04d}" / "run"
        write_carpet(folder, geometry, (LEVELS[0],), iteration=64, time=0.5)
    write_carpet(tmp_path / "output-0009" / "run", SCHWARZSCHILD, (LEVELS[0],), iteration=0)
    assert [(each.iteration, each.time) for each in listed(tmp_path)] == [(0, 0.0), (64, 0.5)]
    x = sphere(2.6)
    assert max(worst(read(tmp_path, x, 64), KERR, x)) < 3e-2
    assert max(worst(read(tmp_path, x, 0), SCHWARZSCHILD, x)) < 3e-2


def test_a_damaged_restart_is_passed_over_where_another_is_whole(tmp_path):
    for restart in range(2):
        write_carpet(tmp_path / f"output-000{restart}", KERR, (LEVELS[0],), iteration=64 * restart)
    write_carpet(tmp_path / "output-0000", KERR, (LEVELS[0],), iteration=64)
    damaged = tmp_path / "output-0001" / "kxx.xyz.h5"
    damaged.write_bytes(damaged.read_bytes()[:1000])
    x = sphere(2.6)
    assert max(worst(read(tmp_path, x, 64), KERR, x)) < 3e-2
    write_carpet(tmp_path / "output-0002", KERR, (LEVELS[0],), iteration=128)
    damaged = tmp_path / "output-0002" / "kyy.xyz.h5"
    damaged.write_bytes(damaged.read_bytes()[:1000])
    with pytest.raises(FileError, match=r"kyy\.xyz\.h5 is not a readable HDF5 file"):
        read(tmp_path, x, 128)


@pytest.mark.parametrize(
    ("names", "match"),
    [
        (METRIC, "has no kxx, kxy, kxz, kyy, kyz, kzz: gxx ... gzz and kxx ... kzz are needed"),
        ([*METRIC[1:], *CURVATURE], "has no gxx"),
        ([*METRIC, *CURVATURE[:-2]], "has no kyz, kzz"),
    ],
)
def test_missing_fields_are_named(tmp_path, names, match):
    write_carpet(tmp_path, KERR, (LEVELS[0],), names=names)
    with pytest.raises(FileError, match=match):
        read(tmp_path, sphere(2.0))


def test_a_missing_file_of_a_process_is_named(tmp_path):
    write_carpet(tmp_path, KERR, (LEVELS[1],), processes=3)
    (tmp_path / "gxy.xyz.file_1.h5").unlink()
    with pytest.raises(FileError, match="3 processes wrote files, but of gxy only those of 2 exist"):
        read(tmp_path, sphere(2.0))


def test_a_conformal_metric_is_refused(tmp_path):
    write_carpet(tmp_path, KERR, (LEVELS[0],), parameters="ADMBase::metric_type = static conformal\n")
    with pytest.raises(FileError, match="metric_type is static conformal"):
        read(tmp_path, sphere(2.0))


def test_a_component_off_the_lattice_is_refused(tmp_path):
    write_carpet(tmp_path, KERR, (LEVELS[1],))
    with h5py.File(tmp_path / "gxx.xyz.h5", "a") as file:
        data = file["ADMBASE::gxx it=0 tl=0 rl=0 c=1"]
        data.attrs["origin"] = data.attrs["origin"] + 0.05
    with pytest.raises(FileError, match=r"component that begins at .* is not on the lattice of the level"):
        read(tmp_path, sphere(2.0))


def test_fields_on_different_points_are_refused(tmp_path):
    write_carpet(tmp_path, KERR, (LEVELS[1],))
    with h5py.File(tmp_path / "gyy.xyz.h5", "a") as file:
        name = "ADMBASE::gyy it=0 tl=0 rl=0 c=1"
        del file[name]
        file[name] = np.zeros((4, 4, 4))
    with pytest.raises(FileError, match=r"gyy it=0 tl=0 rl=0 c=1 has \(4, 4, 4\) points, but gxx"):
        read(tmp_path, sphere(2.0))


def test_what_is_gone_since_the_listing_is_said(tmp_path):
    write_carpet(tmp_path, KERR, (LEVELS[0],))
    source = listed(tmp_path)[0].source
    with h5py.File(tmp_path / "kxz.xyz.h5", "a") as file:
        del file["ADMBASE::kxz it=0 tl=0 rl=0 c=0"]
    for reading in (source.digest, lambda: source.read(*[np.full(3, x) for x in (-2.0, 2.0)])):
        with pytest.raises(FileError, match=r"kxz\.xyz\.h5 is not a readable HDF5 file"):
            reading()
    (tmp_path / "kxz.xyz.h5").unlink()
    with pytest.raises(FileError, match=r"there is no file .*kxz\.xyz\.h5"):
        source.digest()


def test_the_hash_is_of_the_data_of_the_iteration(tmp_path):
    write_carpet(tmp_path, KERR, (LEVELS[0],))
    before = listed(tmp_path)[0].source.digest()
    write_carpet(tmp_path, KERR, (LEVELS[0],), iteration=1)
    assert listed(tmp_path)[0].source.digest() == before
    with h5py.File(tmp_path / "kzz.xyz.h5", "a") as file:
        file["ADMBASE::kzz it=0 tl=0 rl=0 c=0"][3:11, 5, 5] += 1e-12
    assert listed(tmp_path)[0].source.digest() != before


def test_slices_of_planes_and_checkpoints_are_left_alone(tmp_path):
    for name in ("gxx.xy.h5", "checkpoint.chkpt.it_0.file_0.h5", "alp.xyz.h5", "admbase-lapse.xyz.h5"):
        (tmp_path / name).write_bytes(b"no HDF5")
    assert listed(tmp_path) == []


def test_one_file_is_no_slice(kerr):
    with pytest.raises(FileError, match=r"gxx\.xyz\.h5 is a part of a slice, .*: name the folder"):
        slices_in_file(kerr / "gxx.xyz.h5")


def test_files_none_of_which_can_be_read_are_an_error(tmp_path):
    (tmp_path / "gxx.h5").write_bytes(b"no HDF5")
    with pytest.raises(FileError, match=r"gxx\.h5 is not a readable HDF5 file"):
        listed(tmp_path)
