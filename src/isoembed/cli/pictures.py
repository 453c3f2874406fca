"""The pictures, pages and films that a command makes of its answer."""

from __future__ import annotations

import argparse
from pathlib import Path

from isoembed.cli.refusal import UsageError
from isoembed.io import check_output
from isoembed.io.files import Writer
from isoembed.plot.animation import ANIMATION_ENDINGS, animation_writer, check_animation
from isoembed.plot.film import Film
from isoembed.plot.page import PAGE_ENDINGS, page_writer
from isoembed.plot.picture import PICTURE_ENDINGS, check_drawable, picture_writer
from isoembed.plot.quantity import MEAN_CURVATURE, QUANTITIES
from isoembed.surface.embedding import Embedding

ENDINGS = {"picture": PICTURE_ENDINGS, "html": PAGE_ENDINGS, "animate": ANIMATION_ENDINGS}


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
    """Find out what cannot be made before anything is computed.

    Raises
    ------
    FileError, Refusal
        Naming the file.
    """
    for name, endings in ENDINGS.items():
        path = getattr(options, name)
        if path:
            check_output(path, endings)
    if options.picture:
        check_drawable()
    if options.animate:
        check_animation(options.animate)
    if options.color and not options.picture:
        raise UsageError("--color needs a --picture whose colors it chooses")


def film_for(options: argparse.Namespace) -> Film | None:
    """What takes the surfaces on the way, if anything shows them."""
    return Film() if options.html or options.animate else None


def picture_writers(
    options: argparse.Namespace, embedding: Embedding, film: Film | None
) -> dict[Path, Writer]:
    """What writes the pictures that are asked for."""
    writers: dict[Path, Writer] = {}
    if options.picture:
        writers[options.picture] = picture_writer(
            options.picture, embedding, color=options.color or MEAN_CURVATURE
        )
    if film is not None:
        frames = film.frames(embedding)
        if options.html:
            writers[options.html] = page_writer(options.html, embedding, frames=frames)
        if options.animate:
            writers[options.animate] = animation_writer(options.animate, embedding, frames)
    return writers
