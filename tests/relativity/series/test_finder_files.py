"""Series of horizons in files of BHaHAHA, GRChombo and SpECTRE."""

import pickle
from types import SimpleNamespace

import numpy as np
import pytest

from evolutions import write_slices
from finder_files import (
    bhahaha_diagnostics,
    bhahaha_text,
    grchombo_stats,
    grchombo_text,
    lopsided,
    write_ylm,
    ylm_legend,
    ylm_row,
    ylm_text,
)
from isoembed.io.files import FileError
from isoembed.relativity import KerrSchild
from isoembed.relativity.series.moments import moments, simulation

SLICE = KerrSchild(1.0, (0.0, 0.0, 0.0))
TIMES = {0: 0.0, 32: 0.25, 64: 0.5}


def when(found):
    return [(moment.series, moment.iteration, moment.time) for moment in found]


def write_bhahaha(folder, table=True):
    for k, time in TIMES.items():
        (folder / f"h.t{k:07d}.ah1.gp").write_text(bhahaha_text(center=(time, 0.0, 0.0), time=time))
    if table:
        (folder / "BHaHAHA_diagnostics.ah1.gp").write_text(bhahaha_diagnostics(TIMES.items()))


@pytest.mark.parametrize("table", [True, False])
def test_a_folder_of_bhahaha(table, tmp_path):
    write_bhahaha(tmp_path, table)
    found = moments([tmp_path], SLICE)
    assert when(found) == [("ah1", k, time if table else None) for k, time in TIMES.items()]
    shapes = [moment.shape.read() for moment in found]
    assert [shape.time for shape in shapes] == list(TIMES.values())
    np.testing.assert_allclose([shape.center[0] for shape in shapes], list(TIMES.values()), atol=1e-9)


def test_bhahaha_and_slices_of_the_same_iterations(tmp_path):
    write_bhahaha(tmp_path)
    write_slices(tmp_path)
    found = moments([tmp_path], f"{tmp_path}/gxx.{{iteration}}.npz")
    assert [moment.slice.name for moment in found] == [f"{tmp_path}/gxx.{k}.npz" for k in TIMES]


def test_a_simulation_of_the_einstein_toolkit_with_bhahaha(tmp_path):
    write_bhahaha(tmp_path)
    shapes, slices = simulation(SimpleNamespace(allfiles=sorted(map(str, tmp_path.iterdir()))))  # as kuibit's
    assert when(shapes) == [("ah1", k, time) for k, time in TIMES.items()] and not slices


def write_grchombo(folder, numbers=(0, 1, 2)):
    for number in numbers:
        (folder / f"coords_AH1_{number:06d}.dat").write_text(grchombo_text())
    stats = grchombo_stats([(0.25 * number, number, (number, 0.0, 0.0)) for number in numbers])
    (folder / "stats_AH1.dat").write_text(stats)


def test_a_folder_of_grchombo(tmp_path):
    """Matched by time: the number of a file is no iteration."""
    write_grchombo(tmp_path)
    (tmp_path / "constraints.dat").write_text("# time Ham\n0.0 1.0\n")
    (tmp_path / "damaged.dat.gz").write_bytes(b"\x1f\x8b")
    write_slices(tmp_path, "gxx_t{time:.6f}.npz")
    found = pickle.loads(pickle.dumps(moments([tmp_path], f"{tmp_path}/gxx_t{{time}}.npz")))
    assert when(found) == [("AH1", None, 0.0), ("AH1", None, 0.25), ("AH1", None, 0.5)]
    assert [moment.slice.name for moment in found] == [
        f"{tmp_path}/gxx_t{t:.6f}.npz" for t in (0.0, 0.25, 0.5)
    ]
    np.testing.assert_array_equal(found[2].shape.read().center, [2.0, 0.0, 0.0])


def test_the_hash_of_grchombos_coordinates_includes_their_origin(tmp_path):
    write_grchombo(tmp_path)
    before = [moment.shape.digest() for moment in moments([tmp_path], SLICE)]
    (tmp_path / "stats_AH1.dat").write_text(
        grchombo_stats([(0.25 * n, n, (n if n < 2 else 2.5, 0.0, 0.0)) for n in range(4)])
    )
    after = [moment.shape.digest() for moment in moments([tmp_path], SLICE)]
    assert before[:2] == after[:2] and before[2] != after[2]


def test_grchombo_without_its_table(tmp_path):
    write_grchombo(tmp_path)
    (tmp_path / "stats_AH1.dat").unlink()
    with pytest.raises(FileError, match=r"coords_AH1_000000\.dat has no table stats_AH<number>\.dat"):
        moments([tmp_path], SLICE)


def test_a_file_of_grchombo_that_its_table_does_not_name(tmp_path):
    """The others are read all the same."""
    write_grchombo(tmp_path)
    (tmp_path / "coords_AH1_000007.dat").write_text(grchombo_text())
    *others, last = moments([tmp_path / f"coords_AH1_{n:06d}.dat" for n in (0, 7)], SLICE)
    assert [moment.time for moment in others] == [0.0] and last.time is None
    with pytest.raises(FileError, match="has no row of the file 7"):
        last.shape.read()


@pytest.mark.parametrize("text", [True, False])
def test_all_times_of_spectres_coefficients(text, tmp_path):
    legend = ylm_legend(4)
    rows = [ylm_row(t, (t, 0.0, 0.0), lambda u, t=t: t + lopsided(u)) for t in (0.5, 0.0, 0.25)]
    if text:
        for name in ("AhA", "AhB"):
            (tmp_path / f"{name}_Ylm.dat").write_text(ylm_text(rows, legend))
    else:
        pytest.importorskip("h5py")
        write_ylm(tmp_path / "R.h5", {f"{name}_Ylm.dat": (rows, legend) for name in ("AhA", "AhB")})
    found = moments([tmp_path], SLICE)
    assert when(found) == [(name, None, t) for name in ("AhA", "AhB") for t in (0.0, 0.25, 0.5)]
    assert len({moment.shape.digest() for moment in found}) == 3
    for moment in found:
        shape = moment.shape.read()
        r = np.linalg.norm(shape.points - [moment.time, 0.0, 0.0], axis=1)
        u = (shape.points - [moment.time, 0.0, 0.0]) / r[:, None]
        np.testing.assert_allclose(r, moment.time + lopsided(u), rtol=1e-13)
    assert {moment.series for moment in moments([tmp_path], SLICE, surface="AhB_Ylm.dat")} == {"AhB"}
