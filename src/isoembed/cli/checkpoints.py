"""Checkpoint files of a command: written every few minutes and on interruption, read with ``--resume``."""

import argparse
import shlex
import signal
import tempfile
import time
from contextlib import suppress
from pathlib import Path

from isoembed.cli.console import UsageError, print_error
from isoembed.cli.outputs import Outputs
from isoembed.cli.signals import handled
from isoembed.errors import Interrupted
from isoembed.io import CHECKPOINT_ENDINGS, FileError, check_output, checkpoint_writer, write_atomically
from isoembed.progress.checkpoints import Checkpoint
from isoembed.progress.stages import Progress

ENDING = ".checkpoint.npz"  # appended to the name of the output
FOLDER = "isoembed-checkpoint-"  # prefix of temporary folders
PERIOD = 120.0  # seconds between two checkpoints


def add_checkpoint_options(parser: argparse.ArgumentParser) -> None:
    """Add the options for reading and writing checkpoints."""
    parser.add_argument(
        "--checkpoint",
        type=Path,
        metavar="FILE.npz",
        help="checkpoint file, written every two minutes and on interruption (default: the name of the "
        f"output with {ENDING}; without an output, the file of --resume, if any)",
    )
    parser.add_argument(
        "--resume",
        type=Path,
        metavar="FILE.npz",
        help="resume from the checkpoint of an interrupted run with the same input, method and tolerance",
    )


def checkpoint_file(options: argparse.Namespace, outputs: Outputs, source: str) -> Path | None:
    """Path of the checkpoint; None if none is written.

    Raises
    ------
    FileError, UsageError
        The requested checkpoint cannot be written, or is another file of this run.
    """
    path: Path | None = options.checkpoint or options.resume
    if options.output and not options.checkpoint:
        path = options.output.with_name(options.output.name + ENDING)
    if path is None:
        return None
    if options.checkpoint:
        check_output(path, CHECKPOINT_ENDINGS)
    others = {f"--{name}": other for name, other in outputs.items()}
    for name, other in {"INPUT": Path(source), **others}.items():
        if other.resolve() == path.resolve():
            raise UsageError(f"{name} and the checkpoint are the same file {path}")
    return path


class Checkpoints:
    """Checkpoints of one run: written every few minutes, and on interruption.

    If the file cannot be written, a new temporary folder is used.

    Parameters
    ----------
    path : path or None
        File of the checkpoints, each replacing the previous one.
    resumed : Checkpoint, optional
        Checkpoint from which the run resumes, which need not be rewritten.
    """

    def __init__(self, path: Path | None, resumed: Checkpoint | None = None) -> None:
        self._path = path
        self._last, self._begun = resumed, time.monotonic()
        self._written: list[Path] = []

    def listen(self, progress: Progress) -> None:
        """Write the checkpoint of a snapshot if it is new and the last one is old enough."""
        checkpoint, last = progress.checkpoint, self._last
        if checkpoint is None or checkpoint is last or time.monotonic() < self._begun + PERIOD:
            return
        if self._path is not None:
            complaint, written = self._write(checkpoint)
            if complaint:
                print_error(f"{complaint}; {_place(self._path if written else None)}")
        self._last, self._begun = checkpoint, time.monotonic()

    def leave(self, interrupted: Interrupted, method: str) -> str:
        """Write the checkpoint of an interrupted run; return a message about it.

        Parameters
        ----------
        interrupted : Interrupted
        method : str
            Name of the method.
        """
        checkpoint = interrupted.checkpoint
        if checkpoint is None:
            why = f"there is no checkpoint, as the method {method!r} kept nothing to go on from"
            return f"{interrupted}; {why}"
        if self._path is None:
            return f"{interrupted}; there is no checkpoint: neither --output nor --checkpoint names its file"
        with handled(signal.SIG_IGN):  # takes a moment; the interruption is already known
            complaint, written = self._write(checkpoint)
        where = _place(self._path if written else None)
        return "; ".join(part for part in (str(interrupted), complaint, where) if part)

    def left(self) -> str:
        """Clause on the location of the last checkpoint, if any, to end a sentence."""
        return f"; {_place(self._written[-1])}" if self._written else ""

    def remove(self) -> None:
        """Remove the checkpoints of this run after it is finished."""
        for path in self._written:
            with suppress(OSError):
                path.unlink(missing_ok=True)
                if path.parent.name.startswith(FOLDER):
                    path.parent.rmdir()

    def _write(self, checkpoint: Checkpoint) -> tuple[str, bool]:
        """Write to the file, or else to a temporary folder; return an error message, and the success."""
        assert self._path is not None
        writer, complaint = checkpoint_writer(checkpoint), ""
        try:
            write_atomically({self._path: writer})
        except FileError as error:
            complaint = str(error)
            try:
                folder = Path(tempfile.mkdtemp(prefix=FOLDER))
            except OSError:
                return complaint, False
            try:
                write_atomically({folder / self._path.name: writer})
            except FileError:
                folder.rmdir()
                return complaint, False
            self._path = folder / self._path.name
        if self._path not in self._written:
            self._written.append(self._path)
        return complaint, True


def _place(path: Path | None) -> str:
    """Clause on the location of a checkpoint and how to resume from it."""
    if path is None:
        return "there is no checkpoint"
    again = f"resume with the same command and --resume {shlex.quote(str(path))}"
    return f"the checkpoint is in {path}: {again}"
