"""Command line interface ``isoembed``: parser, exit status of every error, subcommands imported on demand.

Exit status: 0 done, 2 the input or the command line is wrong, 3 no embedding within the tolerance, no
horizon or no proof was found, 130 interrupted by Ctrl-C, 143 by SIGTERM.
"""

import argparse
import re
import shlex
import sys
import time
import warnings
from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

from isoembed import __version__
from isoembed.cli import completion
from isoembed.cli import help as help_
from isoembed.cli.console import (
    OK,
    WRONG,
    OutputError,
    UsageError,
    nothing_printed,
    occupy_closed_streams,
    print_error,
    print_out,
)
from isoembed.cli.help import COMMANDS, FIRST_STEPS
from isoembed.cli.signals import Interruption, handled
from isoembed.cli.startup import import_numpy_lazily, uncollected
from isoembed.similar_names import did_you_mean
from isoembed.threads import reserve_threads_of_process
from isoembed.typed_numbers import MILLIMETERS, number

# Bytes.  With 60 to 560 million, libraries fail to load in various ways: they hang, abort, or raise anything.
ADDRESS_SPACE = 800_000_000
OTHER_NAMES = {
    **{"--image": "--picture", "--plot": "--picture", "--page": "--html", "--report": "--json"},
    **dict.fromkeys(("--height", "--width", "--length"), "--size"),
}
"""Names of options in other programs, with their equivalents."""


class Parser(argparse.ArgumentParser):
    """A parser with one-line error messages that accepts numbers such as -1e-3."""

    usual: Collection[str] = ()
    examples: Collection[str] = ()
    words: Sequence[str] = ()

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self.register("type", float, number)
        self._negative_number_matcher = re.compile(r"-(\d+\.?\d*|\.\d+)(e[-+]?\d+)?$", re.IGNORECASE)

    def format_help(self) -> str:
        """Help text; see `isoembed.cli.help`."""
        return help_.text(self, self.usual, self.examples)

    def _print_message(self, message: str, file: Any = None) -> None:
        """Print the help or the version to standard output."""
        print_out(message.removesuffix("\n"))

    def parse_known_args(self, *args: Any, **options: Any) -> Any:
        """Parse arguments; the error for an unknown option suggests the most similar one."""
        self.words = [*args[0]] if args and args[0] else []
        found, rest = super().parse_known_args(*args, **options)
        for word in rest:
            name = word.partition("=")[0]
            if name.startswith("--"):
                usual = OTHER_NAMES.get(name)
                known = self._option_string_actions
                question = did_you_mean(usual if usual in known else name, known)
                self.error(f"unrecognized arguments: {name}{question}")
            if word in MILLIMETERS and word in self.words[1:]:
                self.error(f"unrecognized arguments: {word}; did you mean {self._before(word)}{word}?")
            if question := self._without_option(word):
                self.error(f"unrecognized arguments: {word}{question}")
        return found, rest

    def _before(self, word: str) -> str:
        """Preceding word on the command line."""
        return self.words[self.words.index(word) - 1]

    def _without_option(self, word: str) -> str:
        """Suggestion to insert -o before a file name, if it is missing."""
        is_missing = "-o" in self._option_string_actions and "-o" not in self.words
        if is_missing and Path(word).suffix[1:2].isalpha():
            return f"; did you mean -o {shlex.quote(word)}?"
        return ""

    def error(self, message: str) -> None:  # type: ignore[override]
        """Exit with an error message, which suggests the most similar choice for a mistyped one."""
        if unknown := re.match(r"argument (.*?): invalid choice: '(.*?)' \(choose from (.*)\)", message):
            argument, given, choices = unknown.groups()
            question = did_you_mean(given, [*re.findall(r"[^', ]+", choices), "--help"])
            if argument == "COMMAND" and given == "help":
                question = ": of a command, isoembed COMMAND --help; of all, isoembed --help"
            if argument == "COMMAND" and Path(given).suffix:
                question = f"; to embed a file: isoembed embed {shlex.quote(given)}"
            message = (
                f"unknown command {given!r}{question}" if argument == "COMMAND" else f"{message}{question}"
            )
        if message.endswith("required: -o/--output") and len(self.words) > 1:
            message += self._without_option(self.words[-1])
        if typed := re.fullmatch(r"(argument .*?): invalid (float|int) value: (.*)", message):
            argument, kind, given = typed.groups()
            message = f"{argument}: {given} is not a {'whole ' if kind == 'int' else ''}number"
            if re.fullmatch(r"'[\d.]+,\d+'", given):
                message += ": write a point for the comma"
        print_error(f"{message} (see '{self.prog} --help')")
        raise SystemExit(WRONG)


class _Completion(argparse.Action):
    """Option ``--completion``: print the completion script of a shell, for all subcommands."""

    def __call__(
        self, parser: argparse.ArgumentParser, namespace: Any, shell: Any, option: Any = None
    ) -> None:
        print_out(completion.script(build_parser([*COMMANDS]), shell))
        parser.exit()


def build_parser(arguments: Sequence[str]) -> Parser:
    """Create the parser; options of a subcommand are loaded only if its name is among the arguments."""
    parser = Parser(
        prog="isoembed",
        description="Find the surface in Euclidean, hyperbolic or spherical 3-space from its triangles and "
        "edge lengths.",
        allow_abbrev=False,
    )
    parser.examples = [line.strip() for line in FIRST_STEPS.splitlines()[1:3]]
    parser.add_argument("--version", action="version", version=f"isoembed {__version__}")
    parser.add_argument(
        "--completion",
        action=_Completion,
        choices=completion.SHELLS,
        metavar="SHELL",
        help=f"print the completion script for a shell: {', '.join(completion.SHELLS)}",
    )
    others = Parser(add_help=False)

    def subparser(prog: str, **options: Any) -> Parser:
        """Parser of a subcommand; those that are not among the arguments have one in common."""
        return Parser(prog, allow_abbrev=False, **options) if prog.split()[-1] in arguments else others

    commands = parser.add_subparsers(  # type: ignore[call-overload]  # a function is no class
        title="commands", metavar="COMMAND", required=True, parser_class=subparser
    )
    for name, purpose in COMMANDS.items():
        command = commands.add_parser(name, help=purpose, description=f"{purpose[0].upper()}{purpose[1:]}.")
        if name in arguments:
            module = _loaded(name)
            from isoembed.cli.options import add_quiet_option  # loads numpy

            module.configure(command)
            add_quiet_option(command)
            command.set_defaults(run=module.run)
            command.examples, command.usual = module.EXAMPLES, getattr(module, "USUAL", ())
            shown = "list all options" if command.usual else argparse.SUPPRESS  # --help lists all of few
            command.add_argument("--help-all", action=help_.ShowAll, help=shown)
    return parser


def _loaded(name: str) -> ModuleType:
    """Import a subcommand and its libraries.

    Raises
    ------
    UsageError
        The limit on the address space is too small for the libraries.
    """
    limit = _address_space()
    if limit is not None and limit < ADDRESS_SPACE:
        raise UsageError(f"an address space of {limit} bytes is too small: libraries need {ADDRESS_SPACE}")
    import_numpy_lazily()
    if limit is None:
        from isoembed.linalg.memory import keep_freed_memory

        keep_freed_memory()
    return import_module(f"isoembed.cli.{name}")


def _address_space() -> int | None:
    """Limit on the address space of this process in bytes, if any."""
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
        Command-line arguments; by default those of the process.

    Returns
    -------
    int
        Exit status.
    """
    arguments = sys.argv[1:] if argv is None else list(argv)
    began = time.monotonic()
    occupy_closed_streams()
    interruption = Interruption()
    try:
        with handled(interruption):
            if not arguments:
                print_out(FIRST_STEPS)
            if argv is None:
                reserve_threads_of_process()
            with uncollected() if argv is None else nullcontext():
                options = build_parser(arguments).parse_args(arguments, argparse.Namespace(began=began))
            return _run(options)
    except SystemExit as stop:  # argparse: --help, --version, invalid command line
        return int(stop.code or OK)
    except (UsageError, OutputError) as error:
        print_error(str(error))
        return WRONG
    except KeyboardInterrupt as stop:
        print_error(str(stop) or "interrupted")
        return interruption.status
    except MemoryError as error:
        memory = sys.modules.get("isoembed.linalg.memory")  # too little memory may be left to load it
        out_of_memory = memory is not None and isinstance(error, memory.OutOfMemory)
        known = "" if out_of_memory else "there is not enough memory for this"
        print_error(": ".join(part for part in (known, str(error)) if part))
        return WRONG


def _run(options: argparse.Namespace) -> int:
    # These load numpy, which --help and --version do not need.
    from isoembed.cli.waiting import waiting
    from isoembed.errors import InvalidMetric, InvalidParameter
    from isoembed.io import FileError

    notes: list[str] = []
    silent = options.quiet and not getattr(options, "json", False)
    try:
        with (
            _gathered(notes),
            waiting(quiet=options.quiet) as options.waiting,
            nothing_printed() if silent else nullcontext(),
        ):
            status = int(options.run(options))
    except (UsageError, OutputError, FileError, InvalidMetric, InvalidParameter) as error:
        print_error(f"{error} (note: {'; '.join(notes)})" if notes else str(error))
        return WRONG
    for note in () if options.quiet else notes:
        print_error(note, "note")
    return status


@contextmanager
def _gathered(notes: list[str]) -> Iterator[None]:
    """Collect the mesh notes issued in the block."""
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
