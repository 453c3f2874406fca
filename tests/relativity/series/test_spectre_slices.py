"""Volume data of SpECTRE as the slices of a series, from files written here in its layout."""

import pickle

import numpy as np
import pytest

from elements import gauss, gauss_lobatto, shell
from isoembed.io.files import FileError
from isoembed.relativity.series.moments import moments
from isoembed.relativity.series.slice_files import read_slice, spectre_slices
from isoembed.relativity.spacetimes.kerr_slices import KerrSchild
from isoembed.relativity.spacetimes.spectre_volume import read_spectre_volume, volume_times

h5py = pytest.importorskip("h5py")

PAIRS = ("xx", "yx", "zx", "yy", "zy", "zz")
BASES = ("Chebyshev", "Legendre", "FiniteDifference", "SphericalHarmonic")
QUADRATURES = ("Gauss", "GaussLobatto", "CellCentered", "FaceCentered", "Equiangular")
LOW, HIGH = np.array([-2.2, -2.2, 1.7]), np.array([2.2, 2.2, 2.4])
X = np.array([[0.3, 0.2, 2.0], [-1.0, 0.4, 1.8]])


def hole(time):
    return KerrSchild(1.0 + time, (0.0, 0.3, 0.4))


def write(path, times, part=slice(None), nodes=gauss_lobatto, change=None):
    """All elements, or a part of them as one node of a cluster writes it."""
    with h5py.File(path, "w") as file:
        volume = file.create_group("VolumeData.vol")
        volume.attrs["dimension"] = np.uint64(3)
        for k, time in enumerate(times):
            elements = shell(hole(time), n=(6, 7, 8), nodes=nodes)[part]
            group = volume.create_group(f"ObservationId{1009 * k + 17}")
            group.attrs["observation_value"] = time
            group.attrs["Basis dictionary"], group.attrs["Quadrature dictionary"] = BASES, QUADRATURES
            group["total_extents"] = np.array([6, 7, 8] * len(elements), dtype=np.uint64)
            group["bases"] = np.full(3 * len(elements), 1, dtype=np.int32)
            group["quadratures"] = np.full(3 * len(elements), int(nodes is gauss_lobatto), dtype=np.int32)
            columns = {f"InertialCoordinates_{axis}": ("points", i) for i, axis in enumerate("xyz")}
            columns |= {f"SpatialMetric_{pair}": ("gamma", i) for i, pair in enumerate(PAIRS)}
            columns |= {f"ExtrinsicCurvature_{pair}": ("K", i) for i, pair in enumerate(PAIRS)}
            for name, (what, i) in columns.items():
                values = [getattr(element, what)[..., i].ravel(order="F") for element in elements]
                group[name] = np.concatenate(values)
            if change is not None:
                change(group)
    return path


@pytest.mark.parametrize("nodes", [gauss, gauss_lobatto])
def test_the_slice_of_one_file(tmp_path, nodes):
    path = write(tmp_path / "Volume0.h5", [0.5, 0.0], nodes=nodes)
    assert volume_times(path) == [0.0, 0.5]
    first, second = pickle.loads(pickle.dumps(spectre_slices([path])))
    assert (second.iteration, second.time) == (None, 0.5)
    grid = second.source.read(LOW, HIGH)
    assert len(grid.elements) < 24 and not grid.time_symmetric
    np.testing.assert_allclose(grid.metric(X), hole(0.5).metric(X), atol=1e-3)
    np.testing.assert_allclose(grid.extrinsic_curvature(X), hole(0.5).extrinsic_curvature(X), atol=1e-3)
    whole = read_spectre_volume([path], 0.5)
    np.testing.assert_array_equal(whole.metric(X), grid.metric(X))
    assert first.source.digest() != second.source.digest()


def test_the_whole_slice_of_one_file_or_folder(tmp_path):
    path = write(tmp_path / "Volume.h5", [0.5])
    whole = read_spectre_volume([path], 0.5).metric(X)
    np.testing.assert_array_equal(read_slice(path).metric(X), whole)
    folder = tmp_path / "nodes"
    folder.mkdir()
    for k in range(2):
        write(folder / f"Volume{k}.h5", [0.5], part=slice(k, None, 2))
    np.testing.assert_allclose(read_slice(folder).metric(X), whole, rtol=1e-12)
    write(path, [0.0, 0.5])
    with pytest.raises(
        FileError, match=r"Volume\.h5 holds 2 slices, and isoembed.relativity.read_slice reads one"
    ):
        read_slice(path)


def test_a_run_of_several_nodes(tmp_path):
    """A folder with volume files, a file of surfaces beside them."""
    for k in range(3):
        write(tmp_path / f"Volume{k}.h5", [0.0, 0.5], part=slice(k, None, 3))
    u = np.array([*np.eye(3), *-np.eye(3)])
    with h5py.File(tmp_path / "Surfaces.h5", "w") as file:
        for k, time in enumerate((0.5, 0.25, 0.0)):
            group = file.create_group(f"AhC.vol/ObservationId{k}")
            group.attrs["observation_value"] = time
            for i, axis in enumerate("xyz"):
                group[f"InertialCoordinates_{axis}"] = 2.0 * u[:, i]
    found = moments([tmp_path], tmp_path)
    assert [(moment.label, moment.slice.name.count("Volume")) for moment in found] == [
        ("AhC.T0", 3),
        ("AhC.T0.25", 0),
        ("AhC.T0.5", 3),
    ]
    grid = found[2].slice.read(np.full(3, -2.0), np.full(3, 2.0))
    assert len(grid.elements) == 24
    np.testing.assert_allclose(grid.metric(X), hole(0.5).metric(X), atol=1e-3)
    assert moments([tmp_path], tmp_path / "Volume0.h5")[0].slice.paths == (f"{tmp_path}/Volume0.h5",)


def replaced(name, values):
    def change(group):
        del group[name]
        group[name] = values

    return change


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda group: group.__delitem__("SpatialMetric_zy"), "has no SpatialMetric_yz"),
        (lambda group: group.__delitem__("bases"), "has no bases"),
        (lambda group: group.attrs.__delitem__("Basis dictionary"), "has no Basis dictionary"),
        (
            replaced("bases", [3] * 72),
            "element 1 has 6 points of the basis SphericalHarmonic and the quadrature Ga",
        ),
        (replaced("bases", [7] * 72), "7 is not in the dictionary Chebyshev, Legendre"),
        (replaced("bases", [1] * 69), r"are of \[24, 23, 24\] elements"),
        (replaced("total_extents", [6, 7, 9] * 24), "is not one number for each of the 9072 nodes"),
        (replaced("total_extents", [6.0, 7.0, 8.0] * 24), "total_extents is not three counts"),
    ],
)
def test_files_that_lack_something(tmp_path, change, sentence):
    path = write(tmp_path / "Volume0.h5", [0.0], change=change)
    with pytest.raises(FileError, match=sentence):
        read_spectre_volume([path], 0.0, (LOW, HIGH))


def test_what_is_not_there(tmp_path):
    path = write(tmp_path / "Volume0.h5", [0.0])
    with pytest.raises(FileError, match=r"have no elements from \(7, 7, 7\) to \(8, 8, 8\) at t = 0$"):
        read_spectre_volume([path], 0.0, (np.full(3, 7.0), np.full(3, 8.0)))
    with pytest.raises(FileError, match=r"has 0 slices SpatialMetric_xx \.\.\. at t = 1, not one"):
        read_spectre_volume([path], 1.0)
