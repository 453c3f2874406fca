"""Films (GIF, MP4) of the deformation to a surface, with a final rotation."""

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from isoembed.arrays import Floats
from isoembed.embedding.embedding import Embedding
from isoembed.io.files import FileError, Writer, ending, write_atomically
from isoembed.io.registry import check_output
from isoembed.plot.coloring import mean_curvature
from isoembed.plot.curved_space import Drawn
from isoembed.plot.endings import ANIMATION_ENDINGS
from isoembed.plot.film import ANSWER, Frame
from isoembed.plot.infinity import ball
from isoembed.plot.panel import Panel
from isoembed.plot.picture import INK, PAPER, check_drawable, color_scale, draw_view
from isoembed.plot.view import View, camera

IMAGES_PER_SECOND = 10  # of a film file
LONGEST = 6.0  # seconds from the first surface to the final one
TURN = 3.0  # seconds of the final rotation


Pixels = NDArray[np.uint8]

WIDTH, DPI = 5.6, 100  # inches, dots per inch
FOOT, HEAD = 0.5, 0.6  # inches, below and above the surface


@dataclass(frozen=True, eq=False)
class _Image:
    """Contents of one image of a film."""

    vertices: Floats
    values: Floats
    turn: float
    heading: str
    caption: str


def animation_writer(path: str | os.PathLike[str], embedding: Embedding, frames: Sequence[Frame]) -> Writer:
    """Writer of a film in the format of the path's ending; see `write_atomically` and `write_animation`."""
    check_animation(path)
    images = tuple(_images(embedding, frames))
    return pixels_writer(path, _drawn(embedding, images), [1 / IMAGES_PER_SECOND] * len(images))


def write_animation(path: str | os.PathLike[str], embedding: Embedding, frames: Sequence[Frame]) -> None:
    """Write a film of the deformation to a surface, colored by mean curvature, as ``.gif`` or ``.mp4``.

    Computed surfaces are interpolated linearly; the film ends with a rotation of the final surface.

    Parameters
    ----------
    path : path
    embedding : Embedding
        The final surface.
    frames : sequence of Frame
        From `Film.frames`; if it contains only the final surface, the film shows its rotation.

    Raises
    ------
    FileError
        The ending is unknown, the file cannot be written, or matplotlib, or for MP4 imageio-ffmpeg, is not
        installed.
    """
    check_output(path, ANIMATION_ENDINGS)
    write_atomically({Path(path): animation_writer(path, embedding, frames)})


def check_animation(path: str | os.PathLike[str]) -> None:
    """Raise an error if a package required for the film is missing.

    Raises
    ------
    FileError
    """
    check_drawable()
    if ending(path) == ".mp4" and find_spec("imageio_ffmpeg") is None:
        raise FileError("MP4 needs imageio-ffmpeg: pip install matplotlib imageio-ffmpeg; a .gif does not")


def _images(embedding: Embedding, frames: Sequence[Frame]) -> Iterator[_Image]:
    """Images in order."""
    shown = frames if frames else (Frame(ANSWER, 0.0, embedding.residual, embedding.vertices),)
    between = len(shown) - 1
    # half a second from one surface to the next
    steps = max(1, round(min(0.5, LONGEST / max(between, 1)) * IMAGES_PER_SECOND))
    texts = [_texts(embedding, frame) for frame in shown]
    for k in range(between):
        for s in np.arange(steps) / steps:
            vertices = (1 - s) * shown[k].vertices + s * shown[k + 1].vertices
            yield _Image(vertices, _values(embedding, vertices), 0.0, *texts[k])
    last, values = shown[-1].vertices, _values(embedding, shown[-1].vertices)
    for turn in np.linspace(0, 2 * np.pi, round(TURN * IMAGES_PER_SECOND), endpoint=False):
        yield _Image(last, values, float(turn), *texts[-1])


def _texts(embedding: Embedding, frame: Frame) -> tuple[str, str]:
    """Heading and caption of a surface."""
    surface = frame.surface(embedding)
    place = "" if frame.t is None else f"     t = {frame.t:.2f}"
    inverted = int(
        surface.surface.inverted_vertices.sum() + surface.surface.partially_inverted_vertices.sum()
    )
    return (
        f"{frame.stage}{place}",
        f"{embedding.triangulation.n_vertices:,} vertices     "
        f"{int(surface.surface.concave_edges.sum()):,} concave edges     "
        f"{inverted:,} inverted or partially inverted vertices",
    )


def _values(embedding: Embedding, vertices: Floats) -> Floats:
    """Mean curvature at the vertices."""
    with np.errstate(divide="ignore", invalid="ignore"):  # vertices of zero area
        return embedding._shaped(vertices, ANSWER).mean_curvature


def _drawn(embedding: Embedding, images: Sequence[_Image]) -> Iterator[Pixels]:
    """Rendered images as pixels, (height, width, 3), in order."""
    from isoembed.plot.windowless import WindowlessFigure

    shown = mean_curvature(embedding)
    scale = color_scale(*shown.bounds)
    drawn = Drawn.of(embedding)
    pose = drawn.pose(embedding.vertices)
    placed = [pose.put(drawn.put(image.vertices)) for image in images]
    size = max(float(np.linalg.norm(points, axis=1).max()) for points in placed)
    ups = [points @ camera(image.turn)[1] for points, image in zip(placed, images, strict=True)]
    bottom, top = float(min(up.min() for up in ups)), float(max(up.max() for up in ups))
    if around := ball(pose, drawn.infinity):
        size = max(size, float(np.linalg.norm(around[0])) + around[1])
        bottom, top = -size, size
    height = top - bottom
    tall = WIDTH * height / (2 * size) + FOOT + HEAD
    tall = 2 * round(tall * DPI / 2) / DPI  # films require even heights
    for image in images:
        picture = WindowlessFigure(WIDTH, tall, facecolor=PAPER, dpi=DPI)
        axes = picture.add_axes((0.0, FOOT / tall, 1.0, 1 - (FOOT + HEAD) / tall))
        panel = Panel.of(drawn, image.vertices, replace(shown, values=image.values))
        draw_view(axes, View.of(panel.vertices, panel.faces, pose, image.turn), panel, scale)
        axes.set_xlim(-1.02 * size, 1.02 * size)
        axes.set_ylim(bottom - 0.02 * height, top + 0.02 * height)
        picture.text(
            0.5, 1 - 0.5 * HEAD / tall, image.heading, ha="center", va="center", fontsize=12, color=INK
        )
        picture.text(0.5, 0.5 * FOOT / tall, image.caption, ha="center", va="center", fontsize=9, color=INK)
        yield picture.pixels()


def pixels_writer(path: str | os.PathLike[str], pixels: Iterator[Pixels], seconds: Sequence[float]) -> Writer:
    """Writer of a film in the format of the path's ending, from images and their durations."""
    return (_write_gif if ending(path) == ".gif" else _write_mp4)(pixels, seconds)


def _write_gif(pixels: Iterator[Pixels], seconds: Sequence[float]) -> Writer:
    def write(temporary: Path) -> None:
        from PIL import Image

        # An octree keeps rare colors, such as the lightest ones at a tip; a median cut does not.
        octree = Image.Quantize.FASTOCTREE
        first, *others = (Image.fromarray(image).quantize(256, method=octree) for image in pixels)
        times = [10 * round(100 * x) for x in seconds]
        first.save(temporary, save_all=True, append_images=others, duration=times, loop=0)

    return write


def _write_mp4(pixels: Iterator[Pixels], seconds: Sequence[float]) -> Writer:
    def write(temporary: Path) -> None:
        from imageio_ffmpeg import write_frames

        shortest, film = min(seconds), None
        for image, time in zip(pixels, seconds, strict=True):
            if film is None:
                size = image.shape[1], image.shape[0]
                film = write_frames(str(temporary), size, fps=1 / shortest, macro_block_size=2, quality=6)
                film.send(None)
            for _ in range(round(time / shortest)):
                film.send(image)
        if film is not None:
            film.close()

    return write
