"""Exit statuses, answers on standard output, and one-line errors on standard error."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout, suppress
from typing import Any, TextIO

from isoembed.cli.advice import in_options

OK, WRONG, NOT_EMBEDDED = 0, 2, 3
"""Exit statuses."""


class UsageError(ValueError):
    """A command line that is well-formed but invalid."""


class OutputError(RuntimeError):
    """Standard output cannot be written."""


def print_out(text: str) -> None:
    """Print an answer, with Python arguments replaced by options.

    A closed pipe (``| head``) is not an error.

    Raises
    ------
    OutputError
        Standard output is closed, or the system refuses for another reason, such as lack of space.
    """
    _print_out(in_options(text))


def _print_out(text: str) -> None:
    if sys.stdout is None:
        raise OutputError("cannot write to standard output: it is closed")
    try:
        print(_encodable(text, sys.stdout), flush=True)
    except BrokenPipeError:
        _abandon()
    except OSError as error:
        _abandon()
        raise OutputError(f"cannot write to standard output: {error.strerror}") from None


def print_aside(text: str) -> None:
    """Print information about written files; errors are ignored, as nothing is lost."""
    with suppress(OutputError):
        print_out(text)


@contextmanager
def nothing_printed() -> Iterator[None]:
    """Discard the answers printed in the block, for ``--quiet``."""
    with open(os.devnull, "w", encoding="utf-8") as nowhere, redirect_stdout(nowhere):
        yield


def print_json(document: Any) -> None:
    """Print an answer as strict JSON."""
    from isoembed.strict_json import strict_json  # loads numpy

    _print_out(strict_json(document, indent=2))


def print_error(message: str, kind: str = "error") -> None:
    """Print ``isoembed: error: message``, or another kind of message, in one line, like `print_out`."""
    if sys.stderr is not None:
        lines = f"isoembed: {kind}: {in_options(message)}".splitlines()
        line = " ".join(filter(None, map(str.strip, lines)))
        with suppress(OSError):  # standard error may be closed
            print(_encodable(line, sys.stderr), file=sys.stderr, flush=True)


def is_terminal(stream: TextIO | None) -> bool:
    """Whether a standard stream is open and a terminal."""
    return stream is not None and stream.isatty()


def occupy_closed_streams() -> None:
    """Open the null device in place of closed standard streams.

    Otherwise, the next file opened would take a stream's descriptor, and receive its output.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)


def _encodable(text: str, stream: TextIO) -> str:
    """Text with characters that the stream cannot encode replaced by escapes."""
    encoding = stream.encoding or "ascii"
    return text.encode(encoding, errors="backslashreplace").decode(encoding)


def _abandon() -> None:
    """Redirect standard output to the null device, so that closing it at exit does not fail again."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, sys.stdout.fileno())
    os.close(nowhere)
