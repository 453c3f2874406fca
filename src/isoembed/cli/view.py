"""``isoembed view``: a surface in the browser or as a picture."""

import argparse
import tempfile
import webbrowser
from pathlib import Path

from isoembed.cli.options import add_merge_option, add_output_option, add_quiet_option
from isoembed.cli.outputs import check_answer, written
from isoembed.cli.pictures import add_color_option, color_of
from isoembed.cli.screen import UsageError, print_aside, print_out
from isoembed.cli.status import OK
from isoembed.embedding.embedding import Embedding
from isoembed.io import read_surface, write_atomically
from isoembed.io.files import ending
from isoembed.io.registry import MESH_ENDINGS, METRIC_ENDINGS
from isoembed.plot import PICTURE_ENDINGS, picture_writer
from isoembed.plot.endings import PAGE_ENDINGS
from isoembed.plot.page import page_writer, write_page

EXAMPLES = (
    "isoembed view surface.ply",
    "isoembed view surface.ply -o surface.png --color gaussian-curvature",
)


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options of ``isoembed view``."""
    parser.add_argument(
        "file",
        type=Path,
        metavar="FILE",
        help=f"a surface with vertices ({' '.join((*METRIC_ENDINGS, *MESH_ENDINGS))}); if it holds lengths, "
        "too, length errors are against those",
    )
    add_output_option(
        parser,
        f"{' '.join(PAGE_ENDINGS)}: a page for the browser, in one file; {' '.join(PICTURE_ENDINGS)}: a "
        "picture (default: a page in a new temporary folder, which is opened in the browser)",
    )
    add_color_option(parser)
    add_merge_option(parser)
    add_quiet_option(parser)


def run(options: argparse.Namespace) -> int:
    """Show the surface; return the exit status."""
    output = options.output
    if output:
        check_answer(output, (*PAGE_ENDINGS, *PICTURE_ENDINGS), options.file)
    if options.color and (not output or ending(output) in PAGE_ENDINGS):
        raise UsageError(
            f"--color is for pictures ({' '.join(PICTURE_ENDINGS)}): a page shows all quantities"
        )
    surface = read_surface(options.file, merge=options.merge)
    if not output:
        return _browse(surface, options.file)
    if ending(output) in PAGE_ENDINGS:
        writer = page_writer(output, surface, title=options.file.name)
    else:
        writer = picture_writer(output, surface, color=color_of(options))
    write_atomically({output: writer})
    print_aside(f"{surface.triangulation.n_vertices:,} vertices\n{written(options, output)}")
    return OK


def _browse(surface: Embedding, path: Path) -> int:
    page = Path(tempfile.mkdtemp(prefix="isoembed-")) / f"{path.stem}.html"
    write_page(page, surface, title=path.name)
    opened = webbrowser.open(page.as_uri())
    print_out(str(page) if opened else f"{page}: no browser could be opened here; open this file in one")
    return OK
