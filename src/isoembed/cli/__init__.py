"""The command ``isoembed``: one file a subcommand, each imported when it is called for.

Exit status: 0 done, 2 the input or the command line is wrong, 3 no embedding within the tolerance, no
horizon or no proof was found, 130 interrupted by Ctrl-C, 143 by SIGTERM.
"""

import argparse
import re
import sys
import warnings
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from importlib import import_module
from types import ModuleType
from typing import Any

from isoembed import __version__
from isoembed.cli.collection import uncollected
from isoembed.cli.screen import OutputError, UsageError, occupy_closed_streams, print_error, print_out
from isoembed.cli.signals import Interruption, handled
from isoembed.cli.status import OK, WRONG

COMMANDS = {
    "certify": "prove that an exact surface is near the one in a file, and that no other one is",
    "compare": "say how far two surfaces with the same lengths are apart, with proven errors",
    "deviation": "say how far a surface may be off because its lengths have errors",
    "embed": "find the surface that has the given edge lengths",
    "energy": "compute quasi-local energies of a surface in spacetime (Hawking, Brown-York, Liu-Yau, ...)",
    "glue": "build a solid from a paper net: polygons whose sides are glued together",
    "horizon": "embed horizons, from files or found in a slice, and compute their energies",
    "inspect": "say what kind of metric a file holds, and what that means for its embedding",
    "nets": "solve classic nets: the Latin cross, tetramonohedra, pita forms, D-forms, ...",
    "realizations": "search for surfaces with the same lengths near the one in a file",
    "series": "embed the horizons of a whole simulation, each in its own slice: tables, plots, films",
    "surface": "write the metric of a closed-form surface (ellipsoid, drum, Kerr horizon, ...)",
    "triangulate": "cut a smooth 2-metric into triangles with geodesic lengths",
    "unfold": "make a paper net of a solid, to print, cut, fold and glue",
    "view": "look at a surface, in the browser or as a picture",
}

FIRST_STEPS = """\
Five things to try:
  isoembed surface ellipsoid --axes 3 2 1 --vertices 100 -o metric.npz
  isoembed embed metric.npz -o surface.ply
  isoembed inspect surface.ply
  isoembed unfold surface.ply -o net.svg
  isoembed view surface.ply -o surface.html"""

# Bytes.  Libraries loaded into 60 to 560 million fail in their own ways: they hang, abort, or raise anything.
ADDRESS_SPACE = 800_000_000


class Parser(argparse.ArgumentParser):
    """A parser whose complaints are one line, and to which -1e-3 is a number."""

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self._negative_number_matcher = re.compile(r"-(\d+\.?\d*|\.\d+)(e[-+]?\d+)?$", re.IGNORECASE)

    def _print_message(self, message: str, file: Any = None) -> None:
        """Print the help, or the version: as an answer."""
        print_out(message.removesuffix("\n"))

    def parse_known_args(self, *args: Any, **options: Any) -> Any:
        """Parse, and answer a mistyped option with the most similar one of this command."""
        found, rest = super().parse_known_args(*args, **options)
        for word in rest:
            name = word.partition("=")[0]
            if name.startswith("--") and (question := _did_you_mean(name, self._option_string_actions)):
                self.error(f"unrecognized arguments: {name}{question}")
        return found, rest

    def error(self, message: str) -> None:  # type: ignore[override]
        """Refuse the command line."""
        if unknown := re.match(r"argument COMMAND: invalid choice: '(.*?)'", message):
            message = f"unknown command {unknown[1]!r}{_did_you_mean(unknown[1], COMMANDS)}"
        print_error(f"{message} (see '{self.prog} --help')")
        raise SystemExit(WRONG)


def _did_you_mean(name: str, known: Iterable[str]) -> str:
    """A question that names the most similar of the known names, if there is one."""
    from difflib import get_close_matches

    return "".join(f"; did you mean {near!r}?" for near in get_close_matches(name, known, n=1))


def build_parser(arguments: Sequence[str]) -> Parser:
    """Make the parser; a subcommand's options are loaded only if its name is among the arguments."""
    parser = Parser(
        prog="isoembed",
        description="From the triangles and edge lengths of a closed surface to the surface in Euclidean, "
        "hyperbolic or spherical 3-space.",
        epilog="Exit status: 0 done; 2 wrong input or command line; 3 no embedding within the tolerance, or "
        "no horizon; 130 interrupted by Ctrl-C, 143 by SIGTERM.",
        allow_abbrev=False,
    )
    parser.add_argument("--version", action="version", version=f"isoembed {__version__}")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    for name, purpose in COMMANDS.items():
        command = commands.add_parser(name, help=purpose, description=f"{purpose[0].upper()}{purpose[1:]}.")
        command.allow_abbrev = False
        if name in arguments:
            module = _loaded(name)
            module.configure(command)
            command.set_defaults(run=module.run)
    return parser


def _loaded(name: str) -> ModuleType:
    """Import a subcommand, and with it the libraries.

    Raises
    ------
    UsageError
        A limit on the address space leaves no room for them.
    """
    limit = _address_space()
    if limit is not None and limit < ADDRESS_SPACE:
        raise UsageError(f"an address space of {limit} bytes is too small: libraries need {ADDRESS_SPACE}")
    from isoembed.cli.lazy_numpy import import_lazily

    import_lazily()
    if limit is None:
        from isoembed.linalg.memory import keep_freed_memory

        keep_freed_memory()
    return import_module(f"isoembed.cli.{name}")


def _address_space() -> int | None:
    """The limit on the bytes of this process, if there is one."""
    try:
        from resource import RLIM_INFINITY, RLIMIT_AS, getrlimit
    except ImportError:  # Windows
        return None
    limit = getrlimit(RLIMIT_AS)[0]
    return None if limit == RLIM_INFINITY else limit


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command.

    Parameters
    ----------
    argv : sequence of str, optional
        The arguments; by default those of the process.

    Returns
    -------
    int
        The exit status.
    """
    arguments = sys.argv[1:] if argv is None else list(argv)
    occupy_closed_streams()
    interruption = Interruption()
    try:
        with handled(interruption):
            if not arguments:
                print_out(FIRST_STEPS)
            with uncollected() if argv is None else nullcontext():
                options = build_parser(arguments).parse_args(arguments)
            return _run(options)
    except SystemExit as stop:  # argparse: --help, --version, a wrong command line
        return int(stop.code or OK)
    except (UsageError, OutputError) as error:
        print_error(str(error))
        return WRONG
    except KeyboardInterrupt as stop:
        print_error(str(stop) or "interrupted")
        return interruption.status
    except MemoryError as error:
        memory = sys.modules.get("isoembed.linalg.memory")  # there may be no room to load it
        said = memory is not None and isinstance(error, memory.OutOfMemory)
        known = "" if said else "there is not enough memory for this"
        print_error(": ".join(part for part in (known, str(error)) if part))
        return WRONG


def _run(options: argparse.Namespace) -> int:
    # These load numpy, which --help and --version do without.
    from isoembed.errors import InvalidMetric, InvalidParameter
    from isoembed.io import FileError

    notes: list[str] = []
    quiet = getattr(options, "quiet", False)
    try:
        with _gathered(notes):
            status = int(options.run(options))
    except (UsageError, OutputError, FileError, InvalidMetric, InvalidParameter) as error:
        print_error("; ".join([str(error), *notes]))
        return WRONG
    for note in () if quiet else notes:
        print_error(note, "note")
    return status


@contextmanager
def _gathered(notes: list[str]) -> Iterator[None]:
    """Gather the notes on meshes that come up in the block."""
    from isoembed.errors import MeshNote

    def show(message: Warning | str, category: type[Warning], *where: Any) -> None:
        if issubclass(category, MeshNote):
            notes.append(str(message))
        else:
            others(message, category, *where)

    with warnings.catch_warnings():
        warnings.simplefilter("always", MeshNote)
        others, warnings.showwarning = warnings.showwarning, show  # type: ignore[assignment]
        yield
