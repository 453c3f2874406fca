"""Films as files: their images show the surfaces on the way, and then the answer from all sides."""

import sys

import numpy as np
import pytest

import isoembed
import smooth_bodies
import zoo
from isoembed import Embedding, Paper, PolyhedralMetric
from isoembed.gallery import Bean, Sphere, triangulate
from isoembed.io import FileError
from isoembed.plot import Film, Frame, animation, write_animation
from isoembed.plot.animation import DPI, FOOT, HEAD, IMAGES_PER_SECOND, WIDTH

pytest.importorskip("matplotlib")
Image = pytest.importorskip("PIL.Image")

TURN, LONGEST = 1.2, 1.0  # seconds
AROUND = round(TURN * IMAGES_PER_SECOND)


@pytest.fixture(scope="module", autouse=True)
def short():
    """Films of this module are shorter than others."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(animation, "TURN", TURN)
        patch.setattr(animation, "LONGEST", LONGEST)
        yield


def images_of(path):
    images = []
    with Image.open(path) as file:
        for k in range(file.n_frames):
            file.seek(k)
            images.append(np.asarray(file.convert("RGB")).astype(int))
    return images


@pytest.fixture(scope="module")
def film(tmp_path_factory):
    """The pull-back of a small ellipsoid: its surface, frames and images."""
    vertices, faces = smooth_bodies.ellipsoid()
    taken = Film()
    surface = isoembed.embed(
        PolyhedralMetric.from_mesh(vertices, faces), method=Paper(Tsteps=2), progress=taken
    )
    frames = taken.frames(surface)
    path = tmp_path_factory.mktemp("film") / "gap.gif"
    write_animation(path, surface, frames)
    with Image.open(path) as file:
        assert file.info["loop"] == 0
    return surface, frames, images_of(path)


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


def test_nothing_is_cut_off(tmp_path):
    # A disk with a spike on one side: the middle of its vertices is not the middle of the picture.
    vertices, faces = zoo.icosphere(2)
    spiked = vertices * [3.0, 3.0, 1.0]
    spiked[np.argmax(spiked[:, 2])] = [0.0, 0.0, 4.0]
    metric = PolyhedralMetric.from_mesh(spiked, faces)
    surface = Embedding(metric, spiked, method="exact", tolerance=1e-10)
    write_animation(tmp_path / "a.gif", surface, ())
    for image in images_of(tmp_path / "a.gif"):
        middle = image[round(HEAD * DPI) : -round(FOOT * DPI)]
        rows = np.flatnonzero((np.ptp(middle, axis=2) > 25).any(axis=1))
        assert 1 < rows[0] < rows[-1] < len(middle) - 2


def test_rare_colors_stay(tmp_path):
    # A bean has little but its ends that is strongly curved, and the largest values are yellow.
    vertices, faces = triangulate(Bean(), 300)
    bean = Embedding(PolyhedralMetric.from_mesh(vertices, faces), vertices, method="exact", tolerance=1e-10)
    write_animation(tmp_path / "a.gif", bean, ())
    red, green, blue = images_of(tmp_path / "a.gif")[0].reshape(-1, 3).T
    assert ((red + green) / 2 - blue).max() > 150


@pytest.mark.parametrize("scales", [(1, 1, 0), (0, 0, 0)])
def test_a_surface_on_the_way_may_be_folded_flat(scales, tmp_path):
    vertices, faces = zoo.icosphere(0)
    sphere = Embedding(PolyhedralMetric.from_mesh(vertices, faces), vertices, method="exact", tolerance=1e-10)
    frames = [Frame("folded", 1.0, None, vertices * scales), Frame("answer", 0.0, 0.0, vertices)]
    write_animation(tmp_path / "a.gif", sphere, frames)
    assert len(images_of(tmp_path / "a.gif")) > AROUND


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
