"""The pictures, pages and films that a command makes of its answer."""

import argparse
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path

from isoembed.cli.screen import UsageError
from isoembed.io.files import Writer
from isoembed.plot.animation import ANIMATION_ENDINGS, animation_writer, check_animation
from isoembed.plot.film import Film, Frame
from isoembed.plot.page import PAGE_ENDINGS, page_writer
from isoembed.plot.picture import PICTURE_ENDINGS, check_drawable, picture_writer
from isoembed.plot.quantity import MEAN_CURVATURE, QUANTITIES
from isoembed.surface.embedding import Embedding

PICTURES = {"picture": PICTURE_ENDINGS, "html": PAGE_ENDINGS, "animate": ANIMATION_ENDINGS}


def add_picture_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that say which pictures are made."""
    parser.add_argument(
        "--picture",
        type=Path,
        metavar="FILE",
        help=f"a picture of the surface: {' '.join(PICTURE_ENDINGS)}",
    )
    add_color_option(parser)
    parser.add_argument(
        "--html",
        type=Path,
        metavar="FILE.html",
        help="one page for the browser, with the surface to turn and color, the surfaces on the way along a "
        "slider, and the report",
    )
    parser.add_argument(
        "--animate",
        type=Path,
        metavar="FILE",
        help=f"the way to the surface as a film: {' '.join(ANIMATION_ENDINGS)}",
    )


def add_color_option(parser: argparse.ArgumentParser) -> None:
    """Add the option that says what the colors of a picture show."""
    parser.add_argument(
        "--color",
        choices=tuple(QUANTITIES),
        metavar="QUANTITY",
        help=f"what the colors of the picture show: {', '.join(QUANTITIES)} (default {MEAN_CURVATURE})",
    )


def check_pictures(options: argparse.Namespace) -> None:
    """Find out what cannot be drawn before anything is computed.

    Raises
    ------
    FileError, UsageError
        Naming what is missing.
    """
    if options.picture:
        check_drawable()
    if options.animate:
        check_animation(options.animate)
    if options.color and not options.picture:
        raise UsageError("--color needs a --picture whose colors it chooses")


def picture_writers(
    options: argparse.Namespace, embedding: Embedding, film: Film | None
) -> dict[str, Callable[[Path], Writer]]:
    """Makers of the pictures, by the names of their options."""

    @cache
    def frames() -> Sequence[Frame]:
        return () if film is None else film.frames(embedding)

    return {
        "picture": lambda path: picture_writer(path, embedding, color=options.color or MEAN_CURVATURE),
        "html": lambda path: page_writer(path, embedding, frames=frames()),
        "animate": lambda path: animation_writer(path, embedding, frames()),
    }
