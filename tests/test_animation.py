"""Films as files: their images show the surfaces on the way, and then the answer from all sides."""

import sys

import numpy as np
import pytest

import isoembed
import smooth
from isoembed import Embedding, Paper, PolyhedralMetric
from isoembed.gallery import Sphere, triangulate
from isoembed.io import FileError
from isoembed.plot import Film, write_animation
from isoembed.plot.animation import DPI, FOOT, HEAD, IMAGES_A_SECOND, TURN, WIDTH

pytest.importorskip("matplotlib")
Image = pytest.importorskip("PIL.Image")

AROUND = round(TURN * IMAGES_A_SECOND)


@pytest.fixture(scope="module")
def film(tmp_path_factory):
    """The pull-back of a small ellipsoid: its surface, frames and images."""
    vertices, faces = smooth.ellipsoid()
    taken = Film()
    surface = isoembed.embed(
        PolyhedralMetric.from_mesh(vertices, faces), method=Paper(Tsteps=2), progress=taken
    )
    frames = taken.frames(surface)
    path = tmp_path_factory.mktemp("film") / "gap.gif"
    write_animation(path, surface, frames)
    with Image.open(path) as file:
        images = []
        for k in range(file.n_frames):
            file.seek(k)
            images.append(np.asarray(file.convert("RGB")).astype(int))
        assert file.info["loop"] == 0
    return surface, frames, images


def inked(image):
    """Rows and columns that the surface covers, without the texts above and below."""
    colored = np.ptp(image[round(HEAD * DPI) : -round(FOOT * DPI)], axis=2) > 25
    rows, columns = np.flatnonzero(colored.any(axis=1)), np.flatnonzero(colored.any(axis=0))
    return np.ptp(rows), np.ptp(columns)


def test_a_sphere_becomes_an_ellipsoid(film):
    _, frames, images = film
    assert len(images) > AROUND + len(frames) - 1
    tall, wide = inked(images[0])
    assert tall == pytest.approx(wide, rel=0.03)  # the uniform surface, in equal axes
    tall, wide = inked(images[-AROUND])
    assert wide > 1.3 * tall


def test_the_viewer_walks_around_the_answer(film):
    *_, images = film
    last = images[-AROUND:]
    wide = [inked(image)[1] for image in last]
    half = AROUND // 2
    # From behind an ellipsoid has the same width; along its longest axis it is less.
    assert wide[0] == pytest.approx(wide[half], rel=0.03)
    assert min(wide) < 0.8 * max(wide)
    assert len({image.tobytes() for image in last}) == AROUND


def test_the_answer_alone_is_walked_around(tmp_path):
    vertices, faces = triangulate(Sphere(radius=1e-150), 42)
    sphere = Embedding(PolyhedralMetric.from_mesh(vertices, faces), vertices, method="exact", tolerance=1e-10)
    write_animation(tmp_path / "a.gif", sphere, ())
    with Image.open(tmp_path / "a.gif") as file:
        assert file.n_frames == AROUND


def test_mp4(film, tmp_path):
    reader = pytest.importorskip("imageio_ffmpeg")
    surface, frames, _ = film
    write_animation(tmp_path / "a.mp4", surface, frames[-1:])
    described = reader.read_frames(str(tmp_path / "a.mp4"))
    about = next(described)
    described.close()
    assert about["size"][0] == round(WIDTH * DPI)
    assert about["duration"] == pytest.approx(TURN, abs=0.2)


def test_what_cannot_be_filmed(film, tmp_path, monkeypatch):
    surface, frames, _ = film
    with pytest.raises(FileError, match=r"not one of \.gif \.mp4"):
        write_animation(tmp_path / "a.avi", surface, frames)
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(FileError, match="pictures need matplotlib"):
        write_animation(tmp_path / "a.gif", surface, frames)
    monkeypatch.undo()
    monkeypatch.setattr("isoembed.plot.animation.find_spec", lambda name: None)
    with pytest.raises(FileError, match=r"MP4 needs imageio-ffmpeg: .* a \.gif does not"):
        write_animation(tmp_path / "a.mp4", surface, frames)
    assert not list(tmp_path.iterdir())
