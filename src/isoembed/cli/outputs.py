"""The files that a command writes: all checked before anything is computed, written together at the end."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Collection
from itertools import combinations
from pathlib import Path

from isoembed.cli.screen import UsageError
from isoembed.io import check_output, write_atomically
from isoembed.io.files import Writer


class Outputs(dict[str, Path]):
    """Files by the names of the options that ask for them."""

    @classmethod
    def of(cls, options: argparse.Namespace, **endings: Collection[str]) -> Outputs:
        """The files that are asked for by the options of these names, each with one of these endings.

        Raises
        ------
        FileError
            One of them cannot be written.
        """
        found = cls((name, path) for name in endings if (path := getattr(options, name)))
        for name, path in found.items():
            check_output(path, endings[name])
        return found

    def keep_apart(self) -> None:
        """Refuse two options that ask for the same file.

        Raises
        ------
        UsageError
        """
        for (name, path), (other, same) in combinations(self.items(), 2):
            if path.resolve() == same.resolve():
                raise UsageError(f"--{name} and --{other} are the same file {path}")

    def write(self, **writers: Callable[[Path], Writer]) -> None:
        """Write those of these files that are asked for, all or none.

        Raises
        ------
        FileError
            The system refused.
        """
        write_atomically({path: writers[name](path) for name, path in self.items() if name in writers})
