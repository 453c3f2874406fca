"""Films of a run: an image for each time, the horizons at their places, and what is written below."""

import numpy as np
import pytest

from isoembed.errors import InvalidParameter
from isoembed.io import FileError
from isoembed.plot.series.film import _poses, write_series_film
from isoembed.plot.series.placing import PlacedHorizons
from isoembed.plot.series.scenes import scenes
from isoembed.plot.view import camera
from series_results import embedded, missing

Image = pytest.importorskip("PIL.Image")
pytest.importorskip("matplotlib.figure")


def merger():
    """Two horizons that approach, one of them lost for a while, and the one around both."""
    results = []
    for k in range(4):
        where = 3.0 - k, 0.5 * k, 0.0
        results.append(embedded("ah1", k, k, center=where))
        other = embedded("ah2", k, k, center=np.negative(where))
        results.append(missing("ah2", k, k, "not embedded", "K < 0") if k == 1 else other)
    return [*results, embedded("ah3", 3, 3, center=(0, 0, 0), half_axes=(4, 3, 3))]


@pytest.fixture(scope="module")
def film(tmp_path_factory):
    path = tmp_path_factory.mktemp("film") / "merger.gif"
    write_series_film(path, merger())
    return path


def images(path):
    with Image.open(path) as file:
        for k in range(file.n_frames):
            file.seek(k)
            yield file.info["duration"], np.asarray(file.convert("RGB"), dtype=float)


def test_there_is_an_image_for_each_time_and_the_last_one_stays(film):
    times = [duration for duration, _ in images(film)]
    assert times == [400] * 3 + [2000]


def test_the_picture_does_not_jump_where_one_is_lost_for_a_moment():
    there = [
        embedded(name, k, k, center=(x, 0, 0)) for name, x in (("ah1", 4), ("ah2", -4)) for k in range(40)
    ]
    lost = missing("ah1", 20, 20, "not embedded", "K < 0")
    results = [lost if result.label == lost.label else result for result in there]
    sizes = [pose.size for pose in _poses(scenes(PlacedHorizons.of(results)))]
    assert min(sizes) > 0.99 * max(sizes)


def test_horizons_that_grow_are_seen_in_one_scale():
    results = [embedded("ah1", k, k, half_axes=(r, r, r)) for k, r in enumerate(np.linspace(1.0, 1.5, 9))]
    assert len({pose.size for pose in _poses(scenes(PlacedHorizons.of(results)))}) == 1


def test_one_horizon_is_one_image(tmp_path):
    write_series_film(tmp_path / "one.gif", [embedded("ah1", 0, 0)])
    with Image.open(tmp_path / "one.gif") as file:
        assert (file.n_frames, file.size) == (1, (720, 600))


def test_the_same_results_make_the_same_bytes(film, tmp_path):
    write_series_film(tmp_path / "again.gif", merger()[::-1])
    assert (tmp_path / "again.gif").read_bytes() == film.read_bytes()


def test_nothing_leaves_the_picture():
    """Also where the horizons are far apart at first."""
    results = [embedded("ah1", k, k, center=(40.0 / (k + 1), -0.3 * k, 0.0)) for k in range(20)]
    results += [embedded("ah2", k, k, center=(-40.0 / (k + 1), 0.0, 0.2 * k)) for k in range(20)]
    shown = scenes(PlacedHorizons.of(results))
    poses = _poses(shown)
    for scene, pose in zip(shown, poses, strict=True):
        for horizon in scene.shown:
            _, up, _ = (pose.put(horizon.vertices) @ camera().T).T
            assert np.abs(up).max() <= 1.15
    sizes = [pose.size for pose in poses]
    assert sizes[0] > 3 * sizes[10]  # and what is near is seen large


def test_a_film_of_nothing_is_one_sentence(tmp_path):
    with pytest.raises(InvalidParameter, match="no horizon of the run is embedded"):
        write_series_film(tmp_path / "a.gif", [missing("ah1", 0, 0.0, "failed", "killed")])
    with pytest.raises(FileError, match=r"has the ending '.avi'"):
        write_series_film(tmp_path / "a.avi", merger())
    assert not list(tmp_path.iterdir())
