"""``isoembed nets``: classic paper nets and the solids they fold to."""

import argparse

from isoembed.cli.console import NOT_EMBEDDED, OK, UsageError, print_aside, print_error, print_json, print_out
from isoembed.cli.options import add_json_option, add_output_option
from isoembed.cli.outputs import written
from isoembed.gluing.classics import CLASSICS
from isoembed.gluing.folding import fold
from isoembed.io import SURFACE_ENDINGS, check_output, surface_writer, write_atomically

EXAMPLES = (
    "isoembed nets",
    "isoembed nets latin-cross -o solid.obj",
)

SOLIDS = ("tetrahedron", "cube", "octahedron", "dodecahedron", "icosahedron")


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options of ``isoembed nets``."""
    parser.add_argument(
        "name",
        metavar="NAME",
        nargs="?",
        type=_name,
        choices=tuple(CLASSICS),
        help=f"net to solve: {', '.join(CLASSICS)}; without NAME, list them",
    )
    add_output_option(
        parser,
        f"files for the solids, in the format of the extension ({' '.join(SURFACE_ENDINGS)}): -o "
        "solid.obj writes solid-1.obj, solid-2.obj, ...",
    )
    add_json_option(parser, "print one JSON object, with a list of the solids, instead of text")


def _name(text: str) -> str:
    if text.lower() in SOLIDS:
        raise argparse.ArgumentTypeError(f"{text!r} is one of the nets of 'platonic'")
    return text


def run(options: argparse.Namespace) -> int:
    """List the families of nets, or embed those of one family; return the exit status."""
    if options.name is None:
        if options.json:
            raise UsageError(f"--json needs the NAME of a net: {', '.join(CLASSICS)}")
        width = max(map(len, CLASSICS))
        print_out("\n".join(f"{name:{width}}  {classic.purpose}" for name, classic in CLASSICS.items()))
        return OK
    nets, output = CLASSICS[options.name].make(), options.output
    paths = [output.with_name(f"{output.stem}-{k + 1}{output.suffix}") for k in range(len(nets)) if output]
    for path in paths:
        check_output(path, SURFACE_ENDINGS)
    found = fold(nets)
    solids = {paths[one.number - 1]: one.polyhedron for one in found.folded if output}
    try:
        write_atomically({path: surface_writer(path, solid) for path, solid in solids.items()})
    finally:
        if options.json:
            print_json(found.report)
        elif output:
            print_aside(f"{found}\n{written(options, *solids)}")
        else:
            print_out(str(found))
    for failure in found.failures:
        print_error(failure)
    return NOT_EMBEDDED if found.failures else OK
