"""Horizons of an evolution in one file, and what cannot be listed."""

import os
import pickle

import numpy as np
import pytest

from isoembed.io.files import FileError
from isoembed.relativity import CoordinateShape, KerrNewmanHorizon, SurfaceData
from isoembed.relativity.horizons.horizon_file import read_horizon
from isoembed.relativity.horizons.time_axis import horizon_times
from isoembed.relativity.series.shape_files import shapes_in_files
from isoembed.smooth.grid_metric import GridMetric
from places import SHARED

h5py = pytest.importorskip("h5py")

TIMES = np.array([0.5, 1.0, 1.75])
ICOSAHEDRON = np.array(
    [[s, t * 1.618, 0.0] for s in (1, -1) for t in (1, -1)]
    + [[0.0, s, t * 1.618] for s in (1, -1) for t in (1, -1)]
    + [[t * 1.618, 0.0, s] for s in (1, -1) for t in (1, -1)]
)


def points(time):
    return ICOSAHEDRON * [1.0, 1.0 + time, 1.0] + [time, 0.0, 0.0]


def write_points(group, faces=False):
    group["time"] = TIMES
    group["points"] = np.stack([points(time) for time in TIMES])
    group["height"] = group["points"][()][..., 2]
    group["center"] = np.stack([TIMES, 0.0 * TIMES, 0.0 * TIMES], axis=1)
    if faces:
        group["faces"] = CoordinateShape.star_shaped(ICOSAHEDRON, "", np.zeros(3)).faces
    return group


def write_metrics(group):
    """As many times as angles theta: the axis of time is told by the rank."""
    spins = np.linspace(0.1, 0.6, 12)
    metrics = [GridMetric.sampled(KerrNewmanHorizon(1.0, a).data().metric, 12, 24) for a in spins]
    group["time"], group["iteration"] = np.arange(12) / 4, 64 * np.arange(12)
    for name in ("theta", "phi"):
        group[name] = getattr(metrics[0], name)
    for name in ("q_tt", "q_tp", "q_pp"):
        group[name] = np.stack([getattr(metric, name) for metric in metrics])
    group["k"] = np.stack([a + np.zeros((12, 24)) for a in spins])
    return metrics


@pytest.mark.parametrize("faces", [False, True])
def test_points_with_an_axis_of_time(tmp_path, faces):
    with h5py.File(tmp_path / "run.h5", "w") as file:
        write_points(file, faces)
    listed = shapes_in_files([tmp_path / "run.h5"])
    assert [(one.series, one.iteration, one.time) for one in listed] == [
        ("run", None, time) for time in TIMES
    ]
    shapes = [pickle.loads(pickle.dumps(one.shape)).read() for one in listed]
    for shape, time in zip(shapes, TIMES, strict=True):
        np.testing.assert_array_equal(shape.points, points(time))
        np.testing.assert_array_equal(shape.fields["height"], shape.points[:, 2])
        np.testing.assert_array_equal(shape.center, [time, 0.0, 0.0] if not faces else shape.center)
        assert shape.time == time and shape.is_hull is not faces
    assert shapes[1].source == f"{tmp_path}/run.h5 (horizon, index 1)" == listed[1].shape.name


def test_horizons_in_groups(tmp_path):
    with h5py.File(tmp_path / "run.h5", "w") as file:
        write_points(file.create_group("ah1"))
        metrics = write_metrics(file.create_group("finds/ah2"))
    listed = shapes_in_files([tmp_path / "run.h5"])
    assert [one.series for one in listed] == ["ah1"] * 3 + ["finds/ah2"] * 12
    last = listed[-1]
    assert (last.iteration, last.time) == (64 * 11, 2.75)
    data = last.shape.read()
    assert isinstance(data, SurfaceData)
    np.testing.assert_array_equal(data.metric.q_tt, metrics[11].q_tt)
    np.testing.assert_allclose(data.mean_curvature(np.eye(3)), 0.6, rtol=1e-12)
    assert len({one.shape.digest() for one in listed}) == 15


def test_the_hash_of_a_horizon_is_that_of_its_own_data(tmp_path):
    with h5py.File(tmp_path / "run.h5", "w") as file:
        write_points(file)
    before = [one.shape.digest() for one in shapes_in_files([tmp_path / "run.h5"])]
    with h5py.File(tmp_path / "run.h5", "r+") as file:
        file["points"][2, 5, 1] += 1e-14
    after = [one.shape.digest() for one in shapes_in_files([tmp_path / "run.h5"])]
    assert before[:2] == after[:2] and before[2] != after[2]


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"time": [0.0, np.inf, 1.0]}, r"run\.h5: time 1 is inf"),
        ({"iteration": [0, 1]}, r"run\.h5: iteration is not one integer for each of the 3 times"),
        ({"iteration": [0.0, 1.0, 2.0]}, "iteration is not one integer"),
    ],
)
def test_axes_of_time_that_are_none(tmp_path, change, sentence):
    with h5py.File(tmp_path / "run.h5", "w") as file:
        write_points(file)
        for name, values in change.items():
            if name in file:
                del file[name]
            file[name] = values
    with pytest.raises(FileError, match=sentence):
        horizon_times(tmp_path / "run.h5")
    (listed,) = shapes_in_files([tmp_path / "run.h5"])  # what reading says is a row
    with pytest.raises(FileError, match=r"points has the shape \(3, 12, 3\), not \(V, 3\)"):
        listed.shape.read()


def test_a_file_that_has_become_shorter(tmp_path):
    with h5py.File(tmp_path / "run.h5", "w") as file:
        write_points(file)
    last = shapes_in_files([tmp_path / "run.h5"])[-1].shape
    with h5py.File(tmp_path / "run.h5", "w") as file:
        write_points(file)
        del file["time"]
        file["time"] = TIMES[:2]
    with pytest.raises(FileError, match="holds 2 horizons, and none with the index 2"):
        last.read()


def spectre(path, times, dimension=2):
    theta = np.arccos(np.polynomial.legendre.leggauss(5)[0])[::-1]
    t, p = np.meshgrid(theta, 2 * np.pi / 9 * np.arange(9))
    u = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], axis=-1).reshape(-1, 3)
    with h5py.File(path, "w") as file:
        for surface, dimensions in (("AhA", 2), ("AhB", 2), ("Elements", 3)):
            for k, time in enumerate(times):
                group = file.create_group(f"{surface}.vol/ObservationId{7919 * k % 101}")
                group.attrs["observation_value"] = time
                for i, axis in enumerate("xyz"):
                    group[f"InertialCoordinates_{axis}"] = (1.0 + time) * u[:, i]
                group["total_extents"] = np.array([5, 9], dtype=np.uint64)
            file[f"{surface}.vol"].attrs["dimension"] = dimensions
        file["AhA.vol/loop"] = file
        file["loop"] = file


def test_all_surfaces_of_spectre_at_all_times(tmp_path):
    spectre(tmp_path / "surfaces.h5", [0.3, 0.1, 0.2])
    listed = shapes_in_files([tmp_path / "surfaces.h5"])
    assert [(one.series, one.time) for one in listed] == [
        (name, time) for name in ("AhA", "AhB") for time in (0.1, 0.2, 0.3)
    ]
    shape = listed[-1].shape.read()
    assert (shape.time, shape.name) == (0.3, "AhB")
    np.testing.assert_allclose(np.linalg.norm(shape.points, axis=1), 1.3)
    assert len({one.shape.digest() for one in listed}) == 3  # the surfaces are the same


@pytest.mark.shared
def test_spectre_s_own_file():
    listed = shapes_in_files([SHARED / "real" / "spectre_SurfaceTestData.h5"])
    assert [(one.series, one.time) for one in listed] == [("AhA", time) for time in (0.0, 0.01, 0.02, 0.03)]
    assert listed[2].shape.read().time == 0.02


@pytest.mark.shared
def test_times_of_a_simulation():
    """The table of a run of the Einstein Toolkit beside its shapes."""
    folder = SHARED / "real" / "kuibit"
    listed = shapes_in_files(sorted(folder.glob("*.gp")))
    assert [(one.series, one.iteration, one.time) for one in listed] == [
        ("ah1", 0, 0.0),
        ("ah2", 0, 0.0),
        ("ah1", 1024, 6.4),
    ]


@pytest.mark.parametrize("many", [False, True])
def test_a_file_that_changes_while_it_is_read(tmp_path, monkeypatch, many):
    path = tmp_path / "run.h5"
    with h5py.File(path, "w") as file:
        group = write_points(file)
        if not many:
            time = group["points"][0]
            for name in list(group):
                del group[name]
            group["points"] = time
    source = shapes_in_files([path])[0].shape

    def read_and_change(file):
        shape = read_horizon(file)
        os.utime(path, ns=(1, 1))
        return shape

    assert len(source.read().points) == 12
    monkeypatch.setattr("isoembed.relativity.series.shape_sources.read_horizon", read_and_change)
    with pytest.raises(FileError, match=r"run\.h5 has changed while it was read"):
        source.read()


def test_names_that_are_no_text_and_links_to_nowhere(tmp_path):
    """As in damaged files."""
    spectre(tmp_path / "a.h5", [0.0])
    with h5py.File(tmp_path / "a.h5", "r+") as file:
        file[b"\xff.vol"] = np.arange(3.0)
        file[b"AhA.vol/ObservationId0/\xff"] = np.arange(3.0)
        file["AhA.vol/lost"] = h5py.SoftLink("/nowhere")
    first, second = shapes_in_files([tmp_path / "a.h5"])
    assert (first.series, second.series) == ("AhA", "AhB")
    assert first.shape.digest() == second.shape.digest()
