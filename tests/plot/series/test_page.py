"""The page of a run, without a browser: what is in the file."""

import base64
import json
import re

import numpy as np
import pytest

from isoembed.errors import InvalidParameter
from isoembed.io import FileError
from isoembed.plot.series.page import write_series_page
from series_results import embedded, missing


def merger():
    """Two horizons, of meshes of their own, and the one around them; in the middle nothing is embedded."""
    pair = [
        embedded(name, k, 0.5 * k, center=(x, 0, 0), level=1 + k)
        for name, x in (("ah1", 1.0), ("ah2", -1.0))
        for k in (0, 1)
    ]
    common = [embedded("ah3", k, 0.5 * k, center=(0, 0, 0), half_axes=(4, 3, 3)) for k in (1, 3)]
    return [*pair, *common, missing("ah3", 2, 1.0, "not embedded", "K < 0 & </script>")]


def read(path):
    text = path.read_text(encoding="utf-8")
    found = {name: re.search(rf'id="{name}"[^>]*>([^<]*)<', text)[1] for name in ("data", "arrays", "moment")}
    return text, json.loads(found["data"]), base64.b64decode(found["arrays"])


def unpacked(arrays, entry):
    kind = np.dtype(f"<{entry['type']}")
    stored = np.frombuffer(arrays, kind, entry["count"], entry["at"])
    return entry["low"] + entry["step"] * stored.astype(float) if "step" in entry else stored


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    path = tmp_path_factory.mktemp("page") / "merger.html"
    write_series_page(path, merger())
    return path


def test_a_frame_for_each_time_with_a_mesh_of_its_own(page):
    _, data, arrays = read(page)
    assert [frame["stage"] for frame in data["frames"]] == ["t = 0.00", "t = 0.50", "t = 1.00", "t = 1.50"]
    assert [frame["mesh"] for frame in data["frames"]] == [0, 1, 2, 3]
    vertices = [unpacked(arrays, frame["positions"]).size // 3 for frame in data["frames"]]
    assert vertices == [2 * 42, 2 * 162 + 42, 0, 42]
    for mesh, n in zip(data["meshes"], vertices, strict=True):
        corners = unpacked(arrays, mesh["faces"])
        assert np.array_equal(np.unique(corners), np.arange(n))
    assert data["first"] == 0


def test_the_common_horizon_comes_last_and_is_seen_through(page):
    _, data, _ = read(page)
    counts = [(mesh["solid"], mesh["faces"]["count"] // 3) for mesh in data["meshes"]]
    assert counts == [(160, 160), (640, 720), (0, 0), (80, 80)]


def test_horizons_are_at_their_places(page):
    _, data, arrays = read(page)
    pose, entry = data["pose"], data["frames"][0]["positions"]
    vertices = unpacked(arrays, entry).reshape(-1, 3) * pose["size"] + pose["center"]
    one, two = vertices[:42].mean(axis=0), vertices[42:].mean(axis=0)
    stretch = np.sqrt(12.5 / (4 * np.pi)) / 0.5
    assert np.allclose(one - two, [2 * stretch, 0, 0], atol=1e-3)


def test_colors_begin_and_end_at_the_same_values_at_all_times(page):
    _, data, _ = read(page)
    assert [q["name"] for q in data["quantities"]] == ["mean curvature", "residual"]
    for quantity in data["quantities"]:
        bounds = {tuple(frame["values"][quantity["name"]]["bounds"]) for frame in data["frames"]}
        assert len(bounds) == 1


def test_what_is_lost_is_told(page):
    text, data, _ = read(page)
    assert data["frames"][2]["remarks"] == ["ah3: not embedded"]
    assert "3 horizons: 6 of 7 surfaces embedded · t = 0.00 to 1.50" in text
    report = json.loads(base64.b64decode(re.search(r"application/json;base64,([^\"]+)", text)[1]))
    assert [row["label"] for row in report if row["reason"]] == ["ah3.t2"]


def test_the_page_loads_nothing(page):
    text, _, _ = read(page)
    assert "default-src 'none'" in text
    assert not re.search(r"(?:src|href)=\"(?!data:)", text)


def test_one_mesh_of_many_times_is_there_once(tmp_path):
    write_series_page(tmp_path / "a.html", [embedded("ah1", k, k) for k in range(5)])
    _, data, _ = read(tmp_path / "a.html")
    assert [frame["mesh"] for frame in data["frames"]] == [0] * 5
    assert len(data["meshes"]) == 1


def test_of_many_times_evenly_many_are_taken(tmp_path, monkeypatch):
    monkeypatch.setattr("isoembed.plot.series.page.MAX_FRAMES", 20)
    write_series_page(tmp_path / "a.html", [embedded("ah1", k, k) for k in range(40)])
    _, data, _ = read(tmp_path / "a.html")
    assert len(data["frames"]) == 20
    assert data["frames"][-1]["stage"] == "t = 39.0"


def test_the_same_results_make_the_same_bytes(page, tmp_path):
    write_series_page(tmp_path / "merger.html", merger()[::-1])
    assert (tmp_path / "merger.html").read_bytes() == page.read_bytes()


def test_a_page_of_nothing_is_one_sentence(tmp_path):
    with pytest.raises(InvalidParameter, match="no horizon of the run is embedded"):
        write_series_page(tmp_path / "a.html", [missing("ah1", 0, 0.0, "failed", "killed")])
    with pytest.raises(FileError, match=r"has the ending '.htm'"):
        write_series_page(tmp_path / "a.htm", merger())
