"""Pictures, pages and films of a result, on request."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from isoembed.cli.console import UsageError
from isoembed.embedding.embedding import Embedding
from isoembed.io.files import Writer
from isoembed.plot.coloring import EMPTY, MEAN_CURVATURE, QUANTITIES, SIDES, Quantity, spelled, usual
from isoembed.plot.endings import ANIMATION_ENDINGS, PAGE_ENDINGS, PICTURE_ENDINGS

if TYPE_CHECKING:
    from isoembed.plot.film import Film, Frame

COLORS = {spelled(name): name for name in QUANTITIES}
"""Quantities shown in pictures, by command-line spelling."""

PICTURES = {"picture": PICTURE_ENDINGS, "html": PAGE_ENDINGS, "animate": ANIMATION_ENDINGS}


def add_picture_options(parser: argparse.ArgumentParser, *, films: bool = True) -> None:
    """Add the options for pictures."""
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
        help="one page for the browser, with an interactive surface, "
        f"{'the intermediate surfaces along a slider, ' if films else ''}and the report",
    )
    if not films:
        parser.set_defaults(animate=None)
        return
    parser.add_argument(
        "--animate",
        type=Path,
        metavar="FILE",
        help=f"film of the intermediate surfaces: {' '.join(ANIMATION_ENDINGS)}",
    )


def add_color_option(parser: argparse.ArgumentParser) -> None:
    """Add the option for the quantity shown by color."""
    parser.add_argument(
        "--color",
        type=spelled,
        choices=tuple(COLORS),
        metavar="QUANTITY",
        help=f"quantity shown by the colors of the picture: {', '.join(COLORS)} (default "
        f"{spelled(MEAN_CURVATURE)}, of polyhedra {spelled(SIDES)})",
    )


def shown(options: argparse.Namespace, embedding: Embedding, given: Mapping[str, Quantity]) -> str | Quantity:
    """Quantity shown by the colors of a picture; given quantities replace those of the surface."""
    name = COLORS[options.color] if options.color else usual(embedding)
    return given.get(name, name)


def check_pictures(options: argparse.Namespace) -> None:
    """Check before the computation that the requested pictures can be drawn.

    Raises
    ------
    FileError, UsageError
        A package or option is missing; the message names it.
    """
    if options.picture:
        from isoembed.plot.picture import check_drawable

        check_drawable()
    if options.animate:
        from isoembed.plot.animation import check_animation

        check_animation(options.animate)
    if options.color and not options.picture:
        raise UsageError("--color needs a --picture whose colors it chooses")


def film(options: argparse.Namespace) -> Film | None:
    """Listener that collects the intermediate surfaces, if they will be shown."""
    if not (options.html or options.animate):
        return None
    from isoembed.plot.film import Film

    return Film()


def picture_writers(
    options: argparse.Namespace,
    embedding: Embedding,
    film: Film | None = None,
    given: Mapping[str, Quantity] = EMPTY,
    caption: str = "",
) -> dict[str, Callable[[Path], Writer]]:
    """Writers of the requested pictures, by option name."""
    if not any(getattr(options, name) for name in PICTURES):
        return {}
    from isoembed.plot import animation_writer, page_writer, picture_writer

    @cache
    def frames() -> Sequence[Frame]:
        return () if film is None else film.frames(embedding)

    return {
        "picture": lambda path: picture_writer(
            path, embedding, color=shown(options, embedding, given), caption=caption
        ),
        "html": lambda path: page_writer(path, embedding, frames=frames(), given=given),
        "animate": lambda path: animation_writer(path, embedding, frames()),
    }
