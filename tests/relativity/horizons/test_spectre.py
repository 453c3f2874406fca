"""SpECTRE's surface data, from files written here in its layout."""

import sys

import numpy as np
import pytest

from isoembed.io.files import FileError
from isoembed.mesh.triangulation import Triangulation
from isoembed.relativity.horizons.spectre import read_spectre
from places import SHARED

h5py = pytest.importorskip("h5py")

FILES = SHARED / "real" / "spectre_SurfaceTestData.h5"
CENTER = np.array([5.0, -1.0, 0.25])


def ellipsoid(l, time):
    """Points of a moving ellipsoid on Gauss-Legendre times equiangular nodes, theta running fastest."""
    theta = np.arccos(np.polynomial.legendre.leggauss(l + 1)[0])[::-1]
    p, t = (
        a.ravel() for a in np.meshgrid(2.0 * np.pi / (2 * l + 1) * np.arange(2 * l + 1), theta, indexing="ij")
    )
    u = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], axis=1)
    return u, u * [1.2, 1.0, 0.8] + CENTER + [time, 0.0, 0.0]


def write(path, surfaces, l=8, change=None):
    """`surfaces` maps a name to its times, in any order."""
    with h5py.File(path, "w") as file:
        for name, times in surfaces.items():
            for k, time in enumerate(times):
                group = file.create_group(f"{name}.vol/ObservationId{97 * k + 5}")
                group.attrs["observation_value"] = time
                u, points = ellipsoid(l, time)
                for i, axis in enumerate("xyz"):
                    group[f"InertialCoordinates_{axis}"] = points[:, i]
                group["RicciScalar"] = u[:, 2] + time
                group["total_extents"] = np.array([l + 1, 2 * l + 1], dtype=np.uint64)
                group["connectivity"] = np.arange(8, dtype=np.int32)
                group["quadratures"] = np.array([0, 4], dtype=np.int32)
                if change is not None:
                    change(group)
        file["src.tar.gz"] = np.zeros(4, dtype=np.int8)
    return path


def test_a_surface_at_a_time(tmp_path):
    path = write(tmp_path / "horizons.h5", {"AhA": [0.5]})
    shape = read_spectre(path)
    assert len(shape.points) == 9 * 17 and Triangulation(shape.faces).n_vertices == 9 * 17
    assert (shape.name, shape.time, shape.source) == ("AhA", 0.5, str(path))
    relative = (shape.points - CENTER - [0.5, 0.0, 0.0]) / [1.2, 1.0, 0.8]
    np.testing.assert_allclose(np.linalg.norm(relative, axis=1), 1.0, rtol=1e-14)
    np.testing.assert_allclose(shape.center - CENTER, [0.5, 0.0, 0.0], atol=1e-13)
    assert list(shape.fields) == ["RicciScalar"]
    np.testing.assert_allclose(shape.fields["RicciScalar"], relative[:, 2] + 0.5, atol=1e-14)
    assert "153 points of a horizon and RicciScalar there, but no metric" in shape.contents
    a, b, c = (shape.points - shape.center)[shape.faces.T]
    assert np.all(np.einsum("fi,fi->f", a, np.cross(b, c)) > 0)


def test_choices(tmp_path):
    path = write(tmp_path / "horizons.h5", {"AhA": [0.3, 0.1, 0.2], "Nested/AhB": [7.0]})
    assert read_spectre(path, "AhA", 0).time == 0.1
    assert read_spectre(path, "AhA.vol", -1).time == 0.3
    assert read_spectre(path, "AhA", np.int64(1)).time == 0.2
    assert read_spectre(path, "AhA", 0.3).time == 0.3
    assert read_spectre(path, "AhA", "ObservationId102").time == 0.1
    assert read_spectre(path, "Nested/AhB").time == 7.0


@pytest.mark.parametrize(
    "choice, message",
    [
        ((), "holds several surfaces: choose one of AhA, AhB, by surface"),
        (("AhC",), "holds no surface AhC, but AhA, AhB"),
        (("AhA",), "AhA holds 2 observations: choose one of t = 0.1, 0.3, by observation"),
        (("AhA", "ObservationId6"), "AhA holds no observation ObservationId6$"),
        (("AhA", 2), "AhA holds no observation 2, but 2, t = 0.1, 0.3"),
        (("AhA", 2.0), "AhA holds no observation t = 2, but t = 0.1, 0.3"),
    ],
)
def test_what_is_there_is_listed(choice, message, tmp_path):
    path = write(tmp_path / "horizons.h5", {"AhA": [0.3, 0.1], "AhB": [0.0]})
    with pytest.raises(FileError, match=message):
        read_spectre(path, *choice)


def without_z(group):
    del group["InertialCoordinates_z"]


def short_y(group):
    values = group["InertialCoordinates_y"][1:]
    del group["InertialCoordinates_y"]
    group["InertialCoordinates_y"] = values


def other_extents(group):
    group["total_extents"][...] = [9, 16]


def volume_data(group):
    del group["total_extents"]
    group["total_extents"] = np.array([3, 3, 17])


def folded(group):
    group["InertialCoordinates_x"][9 * 3 + 4] = CENTER[0] - 1.0


def not_finite(group):
    group["InertialCoordinates_x"][20] = np.nan


def empty(group):
    for name in list(group):
        del group[name]
    group["total_extents"] = np.array([0, 17])
    for axis in "xyz":
        group[f"InertialCoordinates_{axis}"] = np.empty(0)


def flat(group):
    group["InertialCoordinates_z"][...] = 0.0


@pytest.mark.parametrize(
    "change, message",
    [
        (without_z, r"AhA at t = 0\) has no InertialCoordinates_z"),
        (short_y, r"has \[153, 152, 153\] coordinates"),
        (other_extents, "not the points of 9 x 16 grid"),
        (volume_data, "not the points of 3 x 3 x 17 grid"),
        (folded, r"the surface folds over at point \d+, .*: it is not star-shaped about \("),
        (not_finite, "point 20 is not finite"),
        (empty, r"AhA at t = 0\): 0 points: that is not a surface"),
        (flat, r"AhA at t = 0\): the 153 points lie in a plane"),
    ],
)
def test_malformed_groups(change, message, tmp_path):
    with pytest.raises(FileError, match=message):
        read_spectre(write(tmp_path / "horizons.h5", {"AhA": [0.0]}, change=change))


def test_files_without_surfaces(tmp_path):
    path = tmp_path / "other.h5"
    with h5py.File(path, "w") as file:
        file["theta"] = [1.0]
    with pytest.raises(FileError, match=r"holds no groups \*.vol or tables \*_Ylm.dat, but nothing"):
        read_spectre(path)
    path.write_bytes(b"no HDF5 at all")
    with pytest.raises(FileError, match="is not a readable HDF5 file"):
        read_spectre(path)
    with pytest.raises(FileError, match="there is no file"):
        read_spectre(tmp_path / "none.h5")


def test_without_h5py(tmp_path, monkeypatch):
    path = write(tmp_path / "horizons.h5", {"AhA": [0.0]})
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(FileError, match="needs h5py: pip install h5py"):
        read_spectre(path)


@pytest.mark.shared
def test_a_file_of_others():
    shape = read_spectre(FILES, "AhA", 0.02)
    assert len(shape.points) == 325 and Triangulation(shape.faces).n_vertices == 325
    # Nearly a sphere of radius 2, on which the Ricci scalar is twice the Gauss curvature.
    np.testing.assert_allclose(np.linalg.norm(shape.points - shape.center, axis=1), 2.0, rtol=0.03)
    np.testing.assert_allclose(shape.fields["RicciScalar"], 0.5, rtol=0.04)
