"""Files of slices: one, and those of an evolution, whole and in parts."""

import numpy as np
import pytest

from gridded import sampled
from isoembed.io.files import FileError
from isoembed.relativity.spacetimes.kerr_slices import KerrSchild
from isoembed.relativity.spacetimes.slice_file import (
    GAMMA,
    Instant,
    K,
    instants,
    read_cartesian_grid,
    slice_arrays,
)


def tables(curved):
    rng = np.random.default_rng(4)
    arrays = {name: rng.normal(size=(8, 9, 10)) for name in (GAMMA + K if curved else GAMMA)}
    return arrays | {"origin": np.array([1.0, 2.0, 3.0]), "spacing": np.array(0.5)}


def write(path, arrays, attributes=False):
    if path.suffix == ".npz":
        np.savez(path, **arrays)
        return
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w") as file:
        for name, array in arrays.items():
            if attributes and name in ("origin", "spacing"):
                file.attrs[name] = array
            else:
                file[name] = array


@pytest.mark.parametrize("curved", [False, True])
@pytest.mark.parametrize(("name", "attributes"), [("a.npz", False), ("a.h5", False), ("a.hdf5", True)])
def test_files(tmp_path, name, attributes, curved):
    arrays = tables(curved)
    write(tmp_path / name, arrays, attributes)
    grid = read_cartesian_grid(tmp_path / name)
    assert grid.origin == (1.0, 2.0, 3.0)
    assert grid.spacing == (0.5, 0.5, 0.5)
    assert grid.time_symmetric is not curved
    x = np.array([[1.0, 2.5, 4.0]])  # the grid point [0, 1, 2]
    np.testing.assert_allclose(
        grid.metric(x)[0][np.triu_indices(3)], [arrays[name][0, 1, 2] for name in GAMMA]
    )
    if curved:
        expected = [arrays[name][0, 1, 2] for name in K]
        np.testing.assert_allclose(grid.extrinsic_curvature(x)[0][np.triu_indices(3)], expected)


@pytest.mark.parametrize(
    ("spoil", "sentence"),
    [
        (lambda t: t.pop("gyz"), "has no gyz"),
        (lambda t: t.pop("kyz"), "has no kyz"),
        (lambda t: (t.pop("origin"), t.pop("spacing")), "has no origin and no spacing"),
        (
            lambda t: t.update(gxz=t["gxz"][:, :, 1:]),
            r"gxz in \S+ has the shape \(8, 9, 9\), gxx \(8, 9, 10\)",
        ),
        (lambda t: t.update(kxx=t["kxx"] * 1j), "kxx in .* does not hold real numbers"),
        (lambda t: t.update(spacing=np.ones(2)), r"spacing in \S+ must be three numbers or one, not 2"),
        (lambda t: t.update(spacing=np.array(-1.0)), "the spacing in x must be positive, not -1.0"),
        (lambda t: t.update(origin=np.array([np.inf, 0, 0])), "the origin must be three finite numbers"),
    ],
)
@pytest.mark.parametrize("name", ["a.npz", "a.h5"])
def test_files_that_lack_something(tmp_path, name, spoil, sentence):
    arrays = tables(curved=True)
    spoil(arrays)
    write(tmp_path / name, arrays)
    with pytest.raises(FileError, match=sentence):
        read_cartesian_grid(tmp_path / name)


def test_what_is_no_array_in_hdf5(tmp_path):
    """A named type in the place of a component, and a data set without a shape."""
    h5py = pytest.importorskip("h5py")
    for value in (np.dtype("f8"), h5py.Empty("f8")):
        write(tmp_path / "s.h5", tables(curved=False))
        with h5py.File(tmp_path / "s.h5", "a") as file:
            del file["gxx"]
            file["gxx"] = value
        with pytest.raises(FileError, match="has no gxx"):
            read_cartesian_grid(tmp_path / "s.h5")


def test_other_files(tmp_path):
    with pytest.raises(FileError, match=r"the ending '\.txt', not one of \.npz"):
        read_cartesian_grid(tmp_path / "a.txt")
    with pytest.raises(FileError, match="there is no file"):
        read_cartesian_grid(tmp_path / "a.npz")


TIMES = np.array([0.0, 0.5, 1.25])


def write_evolution(path, moving=True, **others):
    """Slices of a grid that moves, at `TIMES`."""
    h5py = pytest.importorskip("h5py")
    each = [tables(curved=True) for _ in TIMES]
    with h5py.File(path, "w") as file:
        for k, name in enumerate((*GAMMA, *K)):
            file[name] = np.stack([one[name] * (1 + t + k) for t, one in enumerate(each)])
        file["origin"] = np.array([1.0, 2.0, 3.0]) + (TIMES[:, None] if moving else 0.0)
        file["spacing"] = 0.5
        file["time"] = TIMES
        for name, values in others.items():
            if name in file:
                del file[name]
            file[name] = values
    return path


def test_slices_of_an_evolution(tmp_path):
    path = write_evolution(tmp_path / "a.h5", iteration=[0, 2, 5])
    assert instants(path) == [Instant(0, 0.0, 0), Instant(2, 0.5, 1), Instant(5, 1.25, 2)]
    first, last = (read_cartesian_grid(path, k) for k in (0, 2))
    assert first.origin == (1.0, 2.0, 3.0) and last.origin == (2.25, 3.25, 4.25)
    k = np.arange(6)[:, None, None, None]
    np.testing.assert_allclose(last.gamma * (1 + k), first.gamma * (3 + k), rtol=1e-14)
    arrays = dict(slice_arrays(path, 2))
    assert list(arrays) == ["origin", "spacing", *GAMMA, *K]
    np.testing.assert_array_equal(arrays["gyz"], last.gamma[4])
    np.testing.assert_array_equal(arrays["kyz"], last.K[4])


def test_three_times_and_three_spacings(tmp_path):
    path = write_evolution(tmp_path / "a.h5", moving=False, spacing=[0.5, 0.25, 0.125])
    assert read_cartesian_grid(path, 1).spacing == (0.5, 0.25, 0.125)
    path = write_evolution(tmp_path / "b.h5", spacing=[[0.5] * 3, [0.25, 0.5, 1.0], [2.0] * 3])
    assert read_cartesian_grid(path, 1).spacing == (0.25, 0.5, 1.0)


@pytest.mark.parametrize("name", ["a.npz", "a.h5"])
def test_one_slice_may_say_its_time(tmp_path, name):
    write(tmp_path / name, tables(curved=False))
    assert instants(tmp_path / name) == [Instant(None, None, None)]
    write(tmp_path / name, tables(curved=False) | {"time": np.array(0.5), "iteration": np.array(7)})
    assert instants(tmp_path / name) == [Instant(7, 0.5, None)]
    write(tmp_path / name, {"points": np.ones((4, 3)), "time": np.array(0.5)})
    assert instants(tmp_path / name) == []


@pytest.mark.parametrize(
    ("others", "index", "sentence"),
    [
        ({}, None, "holds 3 slices, and isoembed.relativity.read_slice reads one"),
        ({}, 3, "holds 3 slices, and none with the index 3"),
        ({"origin": np.ones((2, 3))}, 0, r"origin in \S+ must be three numbers, not 6"),
    ],
)
def test_choices_of_a_slice(tmp_path, others, index, sentence):
    with pytest.raises(FileError, match=sentence):
        read_cartesian_grid(write_evolution(tmp_path / "a.h5", **others), index)


@pytest.mark.parametrize(
    ("others", "sentence"),
    [
        ({"time": [0.0, np.nan, 1.0]}, r"time in \S+ does not hold finite numbers"),
        ({"time": np.zeros((3, 1))}, r"time in \S+ has the shape \(3, 1\), and not one axis"),
        ({"iteration": [1, 2]}, r"iteration in \S+ has the shape \(2,\), time \(3,\)"),
    ],
)
def test_times_that_are_none(tmp_path, others, sentence):
    with pytest.raises(FileError, match=sentence):
        instants(write_evolution(tmp_path / "a.h5", **others))


@pytest.mark.parametrize("ending", ["npz", pytest.param("h5", marks=pytest.mark.slow)])
def test_a_part_has_the_same_digits(tmp_path, ending):
    """The box of the surface, with enough around it: as in the whole grid, up to rounding of coordinates."""
    whole = sampled(KerrSchild(1.0, (0.0, 0.0, 0.0)), 62, 3.05)
    path = tmp_path / f"a.{ending}"
    parts = {name: whole.gamma[k] for k, name in enumerate(GAMMA)} | {
        name: whole.K[k] for k, name in enumerate(K)
    }
    write(path, parts | {"origin": np.array(whole.origin), "spacing": np.array(whole.spacing)})
    low, high = np.array([0.97, -0.4, -2.7]), np.array([1.68, 0.4, -1.2])
    part = read_cartesian_grid(path, box=(low, high))
    assert part.gamma.shape == (6, 29, 30, 30)  # cut at the face in z
    x = low + (high - low) * np.random.default_rng(3).random((50, 3))
    np.testing.assert_allclose(part.gradient(x), whole.gradient(x), atol=1e-12)
    np.testing.assert_allclose(part.extrinsic_curvature(x), whole.extrinsic_curvature(x), atol=1e-13)

    def gradients(slice_):
        return slice_.gradient(x).reshape(len(x), -1).T

    np.testing.assert_allclose(part.error(gradients), whole.error(gradients), atol=1e-11)
    with pytest.raises(
        FileError,
        match=r"extends from \(-3.05, -3.05, -3.05\) to \(3.05, 3.05, 3.05\), and the requested box",
    ):
        read_cartesian_grid(path, box=(low, high + 1.4))
