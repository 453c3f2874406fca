"""Horizons and grid data of kuibit, compared with what their files hold."""

import pickle

import numpy as np
import pytest

h5py = pytest.importorskip("h5py")
pytest.importorskip("kuibit")

from kuibit.grid_data import UniformGridData  # noqa: E402
from kuibit.simdir import SimDir  # noqa: E402

from carpet_data import CURVATURE, METRIC, Level, cube, write_carpet  # noqa: E402
from horizon_texts import ORIGIN, diagnostics_text, lopsided, shape_text  # noqa: E402
from isoembed.errors import InvalidParameter  # noqa: E402
from isoembed.io.files import FileError  # noqa: E402
from isoembed.relativity.horizons.ahfinderdirect import read_ahfinderdirect  # noqa: E402
from isoembed.relativity.series.carpet_files import carpet_slices  # noqa: E402
from isoembed.relativity.series.kuibit_data import GridDataSlice, kuibit_shape  # noqa: E402
from isoembed.relativity.spacetimes.kerr_slices import KerrSchild  # noqa: E402

KERR = KerrSchild(1.0, (0.1, 0.2, 0.5))
LEVELS = (Level(0.4, (cube(4.8),)), Level(0.2, (cube(3.0),), 2))
BOX = np.full(3, -2.0), np.full(3, 2.0)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    write_carpet(folder, KERR, LEVELS, iteration=128, time=0.8, stale=False)
    (folder / "h.t128.ah1.gp").write_text(shape_text(lopsided))
    (folder / "h.t128.ah2.gp").write_text(
        shape_text(lambda u: 0.5 + 0.1 * u[:, 0], half={2: 1}, origin=ORIGIN * [1, 1, 0])
    )
    for number in (1, 2):
        text = diagnostics_text([(0, 0.0, 50.0), (128, 0.8, 50.0)])
        (folder / f"BH_diagnostics.ah{number}.gp").write_text(text)
    return folder


@pytest.fixture(scope="module")
def fields(folder):
    functions = SimDir(str(folder)).gf.xyz
    return {name: functions[name][128] for name in (*METRIC, *CURVATURE)}


def test_hierarchical_data_give_what_the_files_give(folder, fields):
    [listed] = carpet_slices(folder.iterdir())
    mine, theirs = listed.source.read(*BOX), GridDataSlice(fields).read(*BOX)
    assert theirs.origin == pytest.approx(mine.origin)
    np.testing.assert_array_equal(theirs.gamma, mine.gamma)
    np.testing.assert_array_equal(theirs.K, mine.K)
    assert theirs.notes == mine.notes


def test_uniform_data_are_one_level(fields):
    [coarse] = fields["gxx"][0]
    assert isinstance(coarse, UniformGridData)
    uniform = {name: fields[name][0][0] for name in METRIC}
    grid = GridDataSlice(uniform).read(*BOX)
    assert grid.spacing == pytest.approx((0.4, 0.4, 0.4))
    assert "the slice has no K_ij: it is assumed to be time-symmetric" in grid.notes


def test_sources_of_grid_data_are_sent_to_other_processes(fields):
    source = GridDataSlice(fields)
    again = pickle.loads(pickle.dumps(source))
    assert again.digest() == source.digest()
    np.testing.assert_array_equal(again.read(*BOX).gamma, source.read(*BOX).gamma)
    assert GridDataSlice({**fields, "gxx": 2.0 * fields["gxx"]}).digest() != source.digest()


def test_what_is_missing_is_said(fields):
    with pytest.raises(FileError, match="grid data of kuibit has no gxy"):
        GridDataSlice({name: fields[name] for name in METRIC if name != "gxy"}).read(*BOX)
    with pytest.raises(FileError, match="no refinement level covers"):
        GridDataSlice(fields).read(np.full(3, -9.0), np.full(3, 9.0))
    with pytest.raises(InvalidParameter, match="'alp' is not one of the fields"):
        GridDataSlice({**fields, "alp": fields["gxx"]})
    with pytest.raises(InvalidParameter, match="gxx is a ndarray, not data of kuibit"):
        GridDataSlice({"gxx": np.zeros((9, 9, 9))})


@pytest.mark.parametrize("number", [1, 2])
def test_shapes_of_horizons_are_those_of_their_files(folder, number):
    horizon = SimDir(str(folder)).horizons.get_apparent_horizon(number)
    shape = kuibit_shape(horizon, 128, f"ah{number}")
    expected = read_ahfinderdirect(folder / f"h.t128.ah{number}.gp")
    np.testing.assert_array_equal(shape.points, expected.points)
    np.testing.assert_array_equal(shape.faces, expected.faces)
    assert (shape.name, shape.iteration) == (f"ah{number}", 128)
    with pytest.raises(InvalidParameter, match=r"the horizon of kuibit has no shape: .* 64"):
        kuibit_shape(horizon, 64)
