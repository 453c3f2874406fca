"""``isoembed view``: a surface in the browser or as a picture."""

import argparse
import tempfile
import webbrowser
from collections.abc import Mapping, Sequence
from pathlib import Path

from isoembed.cli.console import OK, UsageError, print_aside, print_out
from isoembed.cli.options import READABLE, add_merge_option, add_output_option
from isoembed.cli.outputs import check_answer, written
from isoembed.cli.pictures import add_color_option, shown
from isoembed.cli.same_triangles import check_same_triangles
from isoembed.embedding.embedding import Embedding
from isoembed.io import write_atomically
from isoembed.io.files import ending
from isoembed.io.surface import read_with_curvatures
from isoembed.plot import PICTURE_ENDINGS, animation_writer, frames_of, picture_writer
from isoembed.plot.coloring import EMPTY, Quantity, from_file
from isoembed.plot.endings import ANIMATION_ENDINGS, PAGE_ENDINGS
from isoembed.plot.film import Frame
from isoembed.plot.page import page_writer, write_page

EXAMPLES = (
    "isoembed view surface.ply",
    "isoembed view small.ply larger.ply largest.ply -o swelling.gif",
)


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options of ``isoembed view``."""
    parser.add_argument(
        "files",
        nargs="+",
        type=Path,
        metavar="FILE",
        help=f"a surface with vertices ({READABLE}); length errors refer "
        "to the lengths in the file, if any, and colors show its mean_curvature or gaussian_curvature "
        "at the vertices, if present; several surfaces on the same triangles are a series: a page has "
        "a slider, and a film moves from each to the next",
    )
    add_output_option(
        parser,
        f"{' '.join(PAGE_ENDINGS)}: a page for the browser, in one file; {' '.join(PICTURE_ENDINGS)}: a "
        f"picture of a single surface; {' '.join(ANIMATION_ENDINGS)}: a film (default: "
        "a page in a new temporary folder, which is opened in the browser)",
    )
    add_color_option(parser)
    add_merge_option(parser)


def run(options: argparse.Namespace) -> int:
    """Show the surface; return the exit status."""
    output, files = options.output, options.files
    if output:
        check_answer(output, (*PAGE_ENDINGS, *PICTURE_ENDINGS, *ANIMATION_ENDINGS), *files)
    is_picture = output is not None and ending(output) in PICTURE_ENDINGS
    if options.color and not is_picture:
        raise UsageError(
            f"--color is for pictures ({' '.join(PICTURE_ENDINGS)}): a page shows all quantities, a film the "
            "mean curvature"
        )
    if is_picture and len(files) > 1:
        raise UsageError("a picture shows a single surface: for several, make a page or a film")
    read = [read_with_curvatures(path, merge=options.merge) for path in files]
    surfaces, given = [surface for surface, _ in read], from_file(read[-1][1]) if len(read) == 1 else EMPTY
    for path, each in zip(files, surfaces, strict=True):
        check_same_triangles(each.metric, surfaces[-1].metric, path, files[-1], "a series has")
    surface, title = surfaces[-1], files[-1].name
    frames = frames_of(surfaces, [path.stem for path in files]) if len(files) > 1 else ()
    if not output:
        return _browse(surface, files[-1], frames, given)
    if ending(output) in PAGE_ENDINGS:
        writer = page_writer(output, surface, frames=frames, title=title, given=given)
    elif is_picture:
        writer = picture_writer(output, surface, color=shown(options, surface, given))
    else:
        writer = animation_writer(output, surface, frames)
    write_atomically({output: writer})
    print_aside(f"{surface.triangulation.n_vertices:,} vertices\n{written(options, output)}")
    return OK


def _browse(surface: Embedding, path: Path, frames: Sequence[Frame], given: Mapping[str, Quantity]) -> int:
    page = Path(tempfile.mkdtemp(prefix="isoembed-")) / f"{path.stem}.html"
    write_page(page, surface, frames=frames, title=path.name, given=given)
    opened = webbrowser.open(page.as_uri())
    print_out(str(page) if opened else f"{page}: no browser could be opened here; open this file in one")
    return OK
