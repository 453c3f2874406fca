"""Folders of simulations: horizons and slices as kuibit finds them."""

import sys

import numpy as np
import pytest

h5py = pytest.importorskip("h5py")
pytest.importorskip("kuibit")

from kuibit.simdir import SimDir  # noqa: E402

from carpet_data import Level, cube, write_carpet  # noqa: E402
from horizon_texts import diagnostics_text, shape_text  # noqa: E402
from isoembed.io.files import FileError  # noqa: E402
from isoembed.relativity.series.moments import moments, simulation  # noqa: E402
from isoembed.relativity.spacetimes.kerr_slices import KerrSchild  # noqa: E402
from places import SHARED  # noqa: E402

HOLE = KerrSchild(1.0, (0.0, 0.0, 0.0))
LEVELS = (Level(0.4, (cube(4.0),)),)


def write_horizons(folder, iterations, radius=2.0, times=None):
    folder.mkdir(parents=True, exist_ok=True)
    for iteration in iterations:
        text = shape_text(lambda u: np.full(len(u), radius), origin=np.zeros(3))
        (folder / f"h.t{iteration}.ah1.gp").write_text(text)
    if times is not None:
        rows = [(iteration, time, 50.26) for iteration, time in zip(iterations, times, strict=True)]
        (folder / "BH_diagnostics.ah1.gp").write_text(diagnostics_text(rows))


@pytest.fixture
def run(tmp_path):
    """Two restarts with horizons twice as often as slices."""
    for restart in range(2):
        folder = tmp_path / f"output-000{restart}" / "run"
        iterations = range(128 * restart, 128 * restart + 129, 64)
        write_horizons(folder, iterations, 2.0 + 0.1 * restart, [0.1 * n / 16 for n in iterations])
        for iteration in iterations[::2]:
            write_carpet(folder, HOLE, LEVELS, iteration=iteration, time=0.1 * iteration / 16)
    return tmp_path


def test_horizons_and_slices_of_all_restarts(run):
    shapes, slices = simulation(run)
    assert sorted(shape.iteration for shape in shapes) == [0, 64, 128, 192, 256]
    assert {shape.iteration: shape.time for shape in shapes} == pytest.approx(
        {n: 0.1 * n / 16 for n in range(0, 257, 64)}
    )
    [twice] = [shape.shape.read() for shape in shapes if shape.iteration == 128]
    np.testing.assert_allclose(np.linalg.norm(twice.points, axis=1), 2.1)
    assert [(each.iteration, each.time) for each in slices] == [(0, 0.0), (128, 0.8), (256, 1.6)]


def test_moments_without_a_slice_say_so(run):
    there = {moment.iteration: moment for moment in moments([run])}
    low, high = np.full(3, -2.1), np.full(3, 2.1)
    assert there[128].slice.read(low, high).spacing == pytest.approx((0.4, 0.4, 0.4))
    with pytest.raises(FileError, match="64"):
        there[64].slice.read(low, high)
    assert [moment.label for moment in there.values()] == [f"ah1.t{n}" for n in range(0, 257, 64)]


def test_a_simdir_is_a_simulation(run):
    sim = SimDir(str(run))
    assert [[len(part) for part in simulation(given)] for given in (sim, run)] == [[5, 3], [5, 3]]
    assert moments([sim]) == moments([run])


def test_times_that_no_table_tells_are_those_of_the_slices(tmp_path):
    write_horizons(tmp_path, [0, 64])
    write_carpet(tmp_path, HOLE, LEVELS, iteration=64, time=0.4)
    shapes, _ = simulation(tmp_path)
    assert {shape.iteration: shape.time for shape in shapes} == {0: None, 64: 0.4}


def test_folders_without_anything_and_no_folders_are_refused(tmp_path):
    with pytest.raises(FileError, match="there are no files of horizons or of slices in the folder"):
        simulation(tmp_path)
    with pytest.raises(FileError, match="there is no folder"):
        simulation(tmp_path / "none")


@pytest.mark.shared
def test_a_run_of_the_einstein_toolkit(tmp_path):
    """Shapes and tables of kuibit's own tests; without AHFinderDirect the surfaces of QuasiLocalMeasures."""
    shapes, slices = simulation(SHARED / "real" / "kuibit")
    there = {(shape.series, shape.iteration): shape.time for shape in shapes}
    assert there == {("ah1", 0): 0.0, ("ah1", 1024): 6.4, ("ah2", 0): 0.0}
    assert slices == []
    surface = tmp_path / "surface01_00000000.vtk.gz"
    surface.write_bytes((SHARED / "real" / "kuibit" / surface.name).read_bytes())
    [shape] = simulation(tmp_path)[0]
    assert (shape.series, shape.iteration, len(shape.shape.read().points)) == ("surface01", 0, 2812)


def test_without_kuibit_one_sentence_says_how_to_get_it(run, monkeypatch):
    monkeypatch.setitem(sys.modules, "kuibit.simdir", None)
    with pytest.raises(FileError, match=r"needs kuibit: pip install kuibit h5py"):
        simulation(run)
