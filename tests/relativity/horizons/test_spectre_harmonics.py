"""Harmonic coefficients of SpECTRE, from files written here in its layout."""

import numpy as np
import pytest

from finder_files import lopsided, write_ylm, ylm_legend, ylm_row, ylm_text
from isoembed.io.files import FileError
from isoembed.relativity import read_horizon, read_spectre
from isoembed.relativity.horizons.spectre import spectre_tables, spectre_times

h5py = pytest.importorskip("h5py")

CENTER = np.array([5.0, -1.0, 0.25])
LEGEND = ylm_legend(4)


def write(path, *rows, name="ObservationAhC_Ylm.dat", legend=LEGEND):
    if path.suffix == ".dat":
        path.write_text(ylm_text(rows, legend))
        return path
    return write_ylm(path, {name: (rows, legend)})


def check(shape, radius=lopsided, center=CENTER):
    np.testing.assert_array_equal(shape.center, center)
    arrows = shape.points - center
    r = np.linalg.norm(arrows, axis=1)
    np.testing.assert_allclose(r, radius(arrows / r[:, None]), rtol=1e-13)


@pytest.mark.parametrize("name", ["Reductions.h5", "ObservationAhC_Ylm.dat"])
@pytest.mark.parametrize("degree", [3, 4])
def test_a_surface(degree, name, tmp_path):
    """Of a degree below that of the columns, which are then 0."""
    path = write(tmp_path / name, ylm_row(0.5, CENTER, degree=degree))
    shape = read_horizon(path)
    assert (shape.name, shape.time, shape.source) == ("ObservationAhC", 0.5, str(path))
    check(shape)


def test_the_lowest_coefficients(tmp_path):
    """In closed form, as in SpECTRE's Strahlkorper::average_radius and physical_center."""
    mean, shift = 2.0, np.array([0.3, -0.2, 0.1])
    lowest = mean * np.sqrt(8.0), *(shift[[1, 2, 0]] / [-np.sqrt(0.75), np.sqrt(0.375), np.sqrt(0.75)])
    path = write(tmp_path / "R.h5", [0.0, *CENTER, 1.0, *lowest], legend=ylm_legend(1))
    check(read_horizon(path), lambda u: mean + u @ shift)


def test_a_sphere_of_degree_0(tmp_path):
    legend = ["Time", *(f"ExpansionCenter_{axis}" for axis in "xyz"), "Lmax", "coef(0,0)"]  # no frame
    path = write(tmp_path / "SurfacesYlm.h5", [0.0, *CENTER, 0.0, 1.5 * np.sqrt(8.0)], legend=legend)
    with h5py.File(path, "r+") as file:
        file["ObservationAhC_Ylm.dat"].attrs["Legend"] = np.array(legend, "S")
    check(read_horizon(path), lambda u: np.full(len(u), 1.5))


@pytest.mark.parametrize("name", ["Reductions.h5", "ObservationAhC_Ylm.dat"])
def test_a_time_is_chosen(name, tmp_path):
    times = (1.0, 0.5, 2.0)
    path = write(tmp_path / name, *(ylm_row(t, CENTER + t, lambda u, t=t: t + lopsided(u)) for t in times))
    assert spectre_times(path) == {"ObservationAhC": [(0.5, "1"), (1.0, "0"), (2.0, "2")]}
    with pytest.raises(FileError, match=r"ObservationAhC holds 3 observations: choose one of t = 0\.5, 1, 2"):
        read_horizon(path)
    for chosen, time in ((1.0, 1.0), (0, 0.5), (-1, 2.0), ("0", 1.0)):
        shape = read_spectre(path, "ObservationAhC", chosen)
        assert shape.time == time
        check(shape, lambda u, time=time: time + lopsided(u), CENTER + time)
    for missing in (3.0, 3, "3", "row"):
        with pytest.raises(FileError, match="holds no observation"):
            read_spectre(path, None, missing)


def test_several_surfaces_in_groups(tmp_path):
    table = ([ylm_row(0.5, CENTER)], LEGEND)
    mass = ([[0.5, 1.0]], ["Time", "ChristodoulouMass"])
    path = write_ylm(tmp_path / "R.h5", {"AhA_Ylm.dat": table, "deep/AhB_Ylm.dat": table, "AhA.dat": mass})
    assert list(spectre_times(path)) == ["AhA", "deep/AhB"]
    with pytest.raises(FileError, match="holds several surfaces: choose one of AhA, deep/AhB, by surface"):
        read_horizon(path)
    for name in ("AhA", "AhA_Ylm.dat", "deep/AhB"):
        check(read_spectre(path, name))


def test_points_of_the_same_surface_are_preferred(tmp_path):
    path = write(tmp_path / "both.h5", ylm_row(0.5, CENTER), name="AhA_Ylm.dat")
    with h5py.File(path, "r+") as file:
        group = file.create_group("AhA.vol/ObservationId7")
        group.attrs["observation_value"] = 0.5
    assert list(spectre_tables(path)[0]) == []
    assert list(spectre_times(path)) == ["AhA"]


def test_another_frame(tmp_path):
    path = write(tmp_path / "R.h5", ylm_row(0.5, CENTER), legend=ylm_legend(4, "Distorted"))
    with pytest.raises(FileError, match=r"\(ObservationAhC at t = 0\.5\) is in the Distorted frame"):
        read_horizon(path)


def changed(**values):
    names = {"mass": "coef(2,-1)", "high": "coef(4,1)"}
    row = ylm_row(0.5, CENTER, degree=3)
    for name, value in values.items():
        row[LEGEND.index(names.get(name, name))] = value
    return row


@pytest.mark.parametrize(
    "change, message",
    [
        ({"mass": np.nan}, r"coef\(2,-1\) is nan"),
        ({"high": 0.1}, r"has Lmax = 3, but a coef\(4,1\) that is not 0"),
        ({"Lmax": 5.0}, r"has Lmax = 5, but no coef\(5,"),
        ({"Lmax": 2.5}, r"Lmax is 2\.5, not a degree"),
        ({"Lmax": -1.0}, r"Lmax is -1\.0, not a degree"),
        ({"coef(1,0)": 4.0}, r"the radius is not positive everywhere, but -"),
    ],
)
def test_rows_that_are_no_surface(change, message, tmp_path):
    path = write(tmp_path / "R.h5", changed(**change))
    with pytest.raises(FileError, match=message):
        read_horizon(path)


def test_without_a_center(tmp_path):
    path = write(tmp_path / "R.h5", [0.5, 1.0, 2.0], legend=["Time", "Lmax", "coef(0,0)"])
    with pytest.raises(FileError, match="has no columns Lmax and ExpansionCenter_x, _y and _z"):
        read_horizon(path)


@pytest.mark.parametrize("rows, time", [([ylm_row(0.5, CENTER)], "t"), (np.zeros((0, 30)), "Time")])
def test_without_times(rows, time, tmp_path):
    path = write_ylm(tmp_path / "R.h5", {"AhC_Ylm.dat": (rows, [time, *LEGEND[1:]])})
    with pytest.raises(FileError, match="holds no observation: there is no time in it"):
        read_horizon(path)


def test_a_text_file_that_is_cut_short(tmp_path):
    path = tmp_path / "AhC_Ylm.dat"
    path.write_text(ylm_text([ylm_row(0.5, CENTER)], LEGEND[:-1]))
    with pytest.raises(FileError, match="has 30 columns, but names 29"):
        read_horizon(path)
