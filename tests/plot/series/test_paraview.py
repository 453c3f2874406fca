"""A run for ParaView: what the collection names is there, at its time."""

from xml.etree import ElementTree

import numpy as np
import pytest

from isoembed.io import FileError
from isoembed.io.input_file import InputFile
from isoembed.io.vtp import read
from isoembed.plot.series.paraview import write_paraview
from series_results import embedded, missing


@pytest.fixture(scope="module")
def results():
    return [
        embedded("ah2", 10, 0.1 + 0.2, center=(0, 1, 0)),
        embedded("ah1", 10, 0.1 + 0.2, center=(1, 0, 0), level=2),
        embedded("ah1", 2, 0.1, center=(2, 0, 0)),
        missing("ah1", 20, 0.4, "not embedded", "K < 0"),
        missing("ah2", 30, None, "failed", "killed"),
    ]


def entries(path):
    return [element.attrib for element in ElementTree.parse(path).getroot().iter("DataSet")]


def test_the_collection_names_every_embedded_horizon_at_its_time(results, tmp_path):
    write_paraview(tmp_path / "run.pvd", results)
    found = entries(tmp_path / "run.pvd")
    assert [(float(e["timestep"]), e["part"], e["name"]) for e in found] == [
        (0.1, "0", "ah1"),
        (0.1 + 0.2, "0", "ah1"),
        (0.1 + 0.2, "1", "ah2"),
    ]
    assert [e["file"] for e in found] == ["run/ah1.t2.vtp", "run/ah1.t10.vtp", "run/ah2.t10.vtp"]
    assert {path.name for path in (tmp_path / "run").iterdir()} == {e["file"][4:] for e in found}


def test_a_surface_is_at_its_place_with_its_data(results, tmp_path):
    write_paraview(tmp_path / "run.pvd", results)
    path = tmp_path / "run" / "ah1.t10.vtp"
    with InputFile(path) as file:
        tables = read(file)
    given = results[1].arrays
    assert np.array_equal(tables["faces"], given["faces"])
    moved = tables["vertices"] - given["vertices"]
    assert np.allclose(moved, moved[0])
    assert moved[0, 0] > 1.0
    for name in ("mean_curvature", "residual", "slice_coordinates"):
        assert f'Name="{name}"' in path.read_text("ascii")


def test_the_same_results_make_the_same_bytes(results, tmp_path):
    for name, given in (("one", results), ("two", results[::-1])):
        (tmp_path / name).mkdir()
        write_paraview(tmp_path / name / "run.pvd", given)
    for path in sorted((tmp_path / "one").rglob("*.*")):
        assert path.read_bytes() == (tmp_path / "two" / path.relative_to(tmp_path / "one")).read_bytes()


def test_what_cannot_be_written_is_one_sentence(results, tmp_path):
    (tmp_path / "run").write_text("in the way")
    with pytest.raises(FileError, match=r"cannot make the folder .*run: File exists"):
        write_paraview(tmp_path / "run.pvd", results)
    with pytest.raises(FileError, match=r"has the ending '.vtk'"):
        write_paraview(tmp_path / "run.vtk", results)
