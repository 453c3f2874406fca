"""Moments of what a command line names: files, folders, patterns, axes of time."""

import pickle

import numpy as np
import pytest

from evolutions import STEPS, mass, time, write_evolution, write_shapes, write_slices
from isoembed.errors import InvalidParameter
from isoembed.io.files import FileError
from isoembed.relativity import CartesianGrid, KerrNewmanHorizon, KerrSchild
from isoembed.relativity.series.moments import moments
from isoembed.smooth.grid_metric import GridMetric

LABELS = [f"ah1.t{k}" for k in STEPS]


def labels(found):
    return [moment.label for moment in found]


def check_slices(found):
    """Each has the slice of its mass, read in another process around the horizon only."""
    for moment in pickle.loads(pickle.dumps(found)):
        geometry = moment.slice.read(np.full(3, -1.5), np.full(3, 1.5))
        psi4 = (1.0 + 0.5 * mass(moment.iteration) / 1.5) ** 4
        np.testing.assert_allclose(geometry.metric(np.array([[0, 0, 1.5]]))[0], psi4 * np.eye(3), atol=1e-3)
    assert len({moment.slice.digest() for moment in found}) == len({moment.slice for moment in found})


def test_files_in_any_order_with_their_times(tmp_path):
    paths = write_shapes(tmp_path, ("ah10", "ah2"))
    tables = [tmp_path / "BH_diagnostics.ah2.gp", tmp_path / "BH_diagnostics.ah10.gp"]
    found = moments([*tables, *map(str, paths[::-1])], KerrSchild(1.0, (0, 0, 0)))
    assert labels(found) == [f"{name}.t{k}" for name in ("ah2", "ah10") for k in STEPS]
    assert [moment.time for moment in found] == [time(k) for k in STEPS] * 2
    assert {moment.slice.name for moment in found} == {"KerrSchild"}
    assert found[0].shape.read().iteration == 0
    assert len({moment.shape.digest() for moment in found}) == 3  # those of ah2 and ah10 are the same
    (only,) = {moment.series for moment in moments([tmp_path], KerrSchild(1.0, (0, 0, 0)), surface="ah2")}
    assert only == "ah2"


def test_horizons_without_a_table_have_no_times(tmp_path):
    write_shapes(tmp_path, table=False)
    found = moments([tmp_path], KerrSchild(1.0, (0, 0, 0)))
    assert [(moment.iteration, moment.time) for moment in found] == [(k, None) for k in STEPS]


@pytest.mark.parametrize(
    "pattern", ["gxx.{iteration}.npz", "gxx.{iteration:06d}.npz", "gxx_t{time:.6f}.npz", "gxx.{time}.npz"]
)
def test_a_pattern(tmp_path, pattern):
    write_shapes(tmp_path)
    write_slices(tmp_path, pattern)
    found = moments([tmp_path], f"{tmp_path}/{pattern}")
    assert labels(found) == LABELS
    check_slices(found)


@pytest.mark.parametrize("pattern", ["gxx.{iteration}.npz", "gxx_t{time:.6f}.npz"])
def test_a_folder(tmp_path, pattern):
    (tmp_path / "slices").mkdir()
    write_slices(tmp_path / "slices", pattern)
    write_shapes(tmp_path / "slices")
    found = moments([tmp_path / "slices"], tmp_path / "slices")
    assert labels(found) == LABELS
    check_slices(found)


@pytest.mark.parametrize("iterations", [False, True])
def test_an_axis_of_time(tmp_path, iterations):
    pytest.importorskip("h5py")
    write_shapes(tmp_path)
    write_evolution(tmp_path / "all.h5", iterations=iterations)
    found = moments([tmp_path], tmp_path / "all.h5")
    assert labels(found) == LABELS
    assert found[1].slice.name == f"{tmp_path}/all.h5 (index 1)"
    check_slices(found)


def test_the_hash_of_a_slice_is_that_of_its_own_data(tmp_path):
    pytest.importorskip("h5py")
    write_shapes(tmp_path)
    write_evolution(tmp_path / "all.h5")
    before = [moment.slice.digest() for moment in moments([tmp_path], tmp_path / "all.h5")]
    import h5py

    with h5py.File(tmp_path / "all.h5", "r+") as file:
        file["gyz"][1, 3, 4, 5] += 1e-15
    after = [moment.slice.digest() for moment in moments([tmp_path], tmp_path / "all.h5")]
    assert [a == b for a, b in zip(before, after, strict=True)] == [True, False, True]


def test_one_slice_for_all(tmp_path):
    write_shapes(tmp_path)
    write_slices(tmp_path, "slice.npz", steps=(0,))
    found = moments([tmp_path / "h.t0.ah1.gp", tmp_path / "h.t64.ah1.gp"], tmp_path / "slice.npz")
    assert [moment.slice.path for moment in found] == [f"{tmp_path}/slice.npz"] * 2
    grid = found[0].slice.read(np.full(3, -0.5), np.full(3, 0.5))
    assert isinstance(grid, CartesianGrid)


def test_horizons_without_slices_are_rows(tmp_path):
    write_shapes(tmp_path)
    write_slices(tmp_path, steps=(32,))
    (tmp_path / "h.t32.ah1.gp").write_text("cut short")
    found = moments([tmp_path], f"{tmp_path}/gxx.{{iteration}}.npz")
    assert labels(found) == LABELS
    with pytest.raises(
        FileError, match=r"no slice for ah1 at iteration 64 \(.*\): slices are at iterations 32$"
    ):
        found[2].slice.read(np.zeros(3), np.ones(3))
    with pytest.raises(FileError, match=r"h\.t32\.ah1\.gp has no line '# N_patches"):
        found[1].shape.read()


def test_damaged_slices_are_rows(tmp_path):
    write_shapes(tmp_path)
    write_slices(tmp_path)
    path = tmp_path / "gxx.32.npz"
    path.write_bytes(path.read_bytes()[:5000])
    for geometry in (tmp_path, f"{tmp_path}/gxx.{{iteration}}.npz"):
        found = moments(sorted(tmp_path.glob("h.*.gp")), geometry)
        assert labels(found) == LABELS
        with pytest.raises(FileError, match=r"gxx\.32\.npz is not an npz archive, or is cut short"):
            found[1].slice.read(np.zeros(3), np.ones(3))


def test_metrics_of_their_own(tmp_path):
    metric = GridMetric.sampled(KerrNewmanHorizon(1.0, 0.5).data().metric, 12, 24)
    for k in (10, 9):
        np.savez(
            tmp_path / f"AhC_{k:04d}.npz", theta=metric.theta, phi=metric.phi, time=k / 8,
            **dict(zip(("q_tt", "q_tp", "q_pp"), metric_components(metric), strict=True)),
        )  # fmt: skip
    found = moments([tmp_path])
    assert [(moment.label, moment.time, moment.slice) for moment in found] == [
        ("AhC.t9", 1.125, None),
        ("AhC.t10", 1.25, None),
    ]


def metric_components(metric):
    return metric.q_tt, metric.q_tp, metric.q_pp


@pytest.mark.parametrize(
    ("given", "geometry", "sentence"),
    [
        (
            ["h.t0.ah1.gp"],
            "gxx.{iteration}.h5",
            r"no file is named like \S+: in \S+ there are AhA.npz, BH_diagnostics.ah1.gp, ",
        ),
        (
            ["h.t0.ah1.gp"],
            "none/gxx.{iteration}.h5",
            r"no file is named like \S+: there is no folder \S+none$",
        ),
        (["h.t0.ah1.gp"], "none.npz", r"there is no file or folder \S+none\.npz"),
        (["h.t0.ah1.gp"], "AhA.npz", r"\S+AhA\.npz has no gxx, nor SpatialMetric_xx"),
        (["h.t7.ah1.gp"], "gxx.{iteration}.npz", r"there is no file \S+h\.t7\.ah1\.gp"),
        (
            ["BH_diagnostics.ah1.gp"],
            "gxx.{iteration}.npz",
            r"there are no horizons in \S+BH_diagnostics\.ah1\.gp",
        ),
        (
            ["h.t32.ah1.gp", "h.t64.ah1.gp"],
            "gxx.{iteration}.npz",
            r"no slice for ah1 at iteration 32 \(.*\): slices are at iterations 0; nor is",
        ),
        (
            ["h.t0.ah1.gp", "h.t32.ah1.gp"],
            None,
            r"h\.t0\.ah1\.gp holds .*, but no metric: .*: name it with geometry=",
        ),
    ],
)
def test_nothing_to_do_is_one_sentence(tmp_path, given, geometry, sentence):
    write_shapes(tmp_path)
    write_slices(tmp_path, steps=(0,))
    np.savez(tmp_path / "AhA.npz", points=np.eye(3))
    with pytest.raises(FileError, match=sentence):
        moments([tmp_path / name for name in given], geometry and f"{tmp_path}/{geometry}")


def test_what_is_there_twice(tmp_path):
    (tmp_path / "again").mkdir()
    paths = write_shapes(tmp_path) + write_shapes(tmp_path / "again", steps=(32,))
    with pytest.raises(
        InvalidParameter, match=r"\S+h\.t32\.ah1\.gp and \S+again/h\.t32\.ah1\.gp are both ah1 at it"
    ):
        moments(paths, KerrSchild(1.0, (0, 0, 0)))
    with pytest.raises(FileError, match=r"there is no horizon AhA, but ah1"):
        moments(paths, KerrSchild(1.0, (0, 0, 0)), surface="AhA")


def test_folders_of_something_else(tmp_path):
    """No simulation is looked for where none can be: kuibit need not be there."""
    write_shapes(tmp_path)
    for name in ("empty", "slices"):
        (tmp_path / name).mkdir()
    write_slices(tmp_path / "slices", steps=(0,))
    (slice_,) = (tmp_path / "slices").iterdir()
    for given, geometry, sentence in (
        (
            tmp_path,
            tmp_path / "empty",
            r"there are no files of slices in \S+: there are no files in \S+empty$",
        ),
        (tmp_path / "slices", slice_, r"no files of horizons in \S+: in \S+slices there are gxx\.0\.npz$"),
        (tmp_path / "empty", slice_, r"no files of horizons in \S+: there are no files in \S+empty$"),
        (
            tmp_path,
            "kerr-shild",
            r"there is no file or folder kerr-shild, nor a slice in closed form of that",
        ),
        (tmp_path, None, r"h\.t0\.ah1\.gp holds .*: name it with geometry=$"),
    ):
        with pytest.raises(FileError, match=sentence):
            moments([given], geometry)
    with pytest.raises(
        InvalidParameter, match=r"gxx\.0\.npz holds slices, not horizons: pass it as geometry="
    ):
        moments([slice_], slice_)
