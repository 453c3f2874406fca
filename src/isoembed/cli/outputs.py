"""Output files of a command: checked before the computation, written together after it."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Collection, Sequence
from itertools import combinations
from pathlib import Path

from isoembed.cli.console import UsageError, is_terminal, print_aside
from isoembed.io import SURFACE_ENDINGS, FileError, check_output, write_atomically
from isoembed.io.files import Writer, ending
from isoembed.reprs import listed


class Outputs(dict[str, Path]):
    """Output files by option name."""

    @classmethod
    def of(cls, options: argparse.Namespace, **endings: Collection[str]) -> Outputs:
        """Output files of the given options, each with its permitted endings.

        Raises
        ------
        FileError
            A file cannot be written.
        """
        found = cls((name, path) for name in endings if (path := getattr(options, name)))
        for name, path in found.items():
            check_output(path, endings[name])
        return found

    def keep_apart(self, *inputs: Path) -> None:
        """Raise UsageError if two options name the same file, or one of the inputs."""
        for (name, path), (other, same) in combinations(self.items(), 2):
            if path.resolve() == same.resolve():
                raise UsageError(f"--{name} and --{other} are the same file {path}")
        for path in self.values():
            _check_inputs(path, inputs)

    def write(self, **writers: Callable[[Path], Writer]) -> list[Path]:
        """Write the requested files sequentially, each atomically; return those written.

        A failure does not prevent the others from being written.

        Raises
        ------
        FileError
            Some files could not be written; the message names them, and those written.
        """
        written, failures = [], []
        for name, path in self.items():
            if name in writers:
                try:
                    write_atomically({path: writers[name](path)})
                    written.append(path)
                except FileError as error:
                    failures.append(str(error))
                except MemoryError:
                    failures.append(f"cannot write {path}: there is not enough memory for it")
        if failures:
            raise FileError("; ".join([*failures, *(f"{path} is written" for path in written)]))
        return written


def check_folder(path: Path) -> None:
    """Raise UsageError if an output folder is a file, or has the name of a surface."""
    if path.exists() and not path.is_dir():
        raise UsageError(f"the output {path} is not a folder")
    if not path.exists() and ending(path) in SURFACE_ENDINGS:
        raise UsageError(
            f"the output {path} would be a folder for several files: give one without {path.suffix}"
        )


def written(options: argparse.Namespace, *files: Path | str) -> str:
    """Last line of a command: the written files, if any, and the elapsed time."""
    if not files:
        return elapsed(options)
    return f"{listed(list(map(str, files)))} written, {elapsed(options)}"


def print_written(options: argparse.Namespace, *files: Path) -> None:
    """Print the last line of a command; without files only on a terminal, so that pipes are reproducible."""
    if files or is_terminal(sys.stdout):
        print_aside(written(options, *files))


def elapsed(options: argparse.Namespace) -> str:
    """Time taken by the command."""
    return f"{time.monotonic() - options.began:.1f} s"


def check_answer(path: Path, endings: Collection[str], *inputs: Path) -> None:
    """Raise FileError or UsageError if the result of a computation cannot be written, or is an input."""
    check_output(path, endings)
    _check_inputs(path, inputs)


def _check_inputs(path: Path, inputs: Collection[Path]) -> None:
    if path.resolve() in {each.resolve() for each in inputs}:
        raise UsageError(f"the output is the input {path}")


def stems(files: Sequence[str]) -> list[str]:
    """File name stems for the outputs of several input files.

    Raises
    ------
    UsageError
        Two files have the same stem.
    """
    names = [Path(name).name.removesuffix(".gz").rsplit(".", 1)[0] or Path(name).name for name in files]
    for k, name in enumerate(names):
        if name in names[:k]:
            raise UsageError(f"{files[names.index(name)]} and {files[k]} have the same name: {name}")
    return names
