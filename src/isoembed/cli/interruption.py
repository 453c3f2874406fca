"""An interrupted run leaves a checkpoint, and another one goes on from it."""

import argparse
import shlex
import signal
from pathlib import Path

from isoembed.cli.outputs import Outputs
from isoembed.cli.screen import UsageError
from isoembed.cli.signals import handled
from isoembed.errors import Interrupted
from isoembed.io import CHECKPOINT_ENDINGS, FileError, check_output, checkpoint_writer, write_atomically

ENDING = ".checkpoint.npz"  # after the name of the output


def add_checkpoint_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that say where a checkpoint is, and where it goes."""
    parser.add_argument(
        "--checkpoint",
        type=Path,
        metavar="FILE.npz",
        help="where an interruption leaves what was reached (default: the name of the output and "
        f"{ENDING}; without an output, the file of --resume, if any)",
    )
    parser.add_argument(
        "--resume",
        type=Path,
        metavar="FILE.npz",
        help="go on from the checkpoint of an interrupted run with the same input, method and tolerance",
    )


def checkpoint_file(options: argparse.Namespace, outputs: Outputs) -> Path | None:
    """Where a checkpoint would go, if anywhere.

    Raises
    ------
    FileError, UsageError
        It cannot be written where it was asked for, or is another file of this run.
    """
    path: Path | None = options.checkpoint or options.resume
    if options.output and not options.checkpoint:
        path = options.output.with_name(options.output.name + ENDING)
    if path is None:
        return None
    if options.checkpoint:
        check_output(path, CHECKPOINT_ENDINGS)
    others = {f"--{name}": other for name, other in outputs.items()}
    for name, other in {"INPUT": Path(options.input), **others}.items():
        if other.resolve() == path.resolve():
            raise UsageError(f"{name} and the checkpoint are the same file {path}")
    return path


def save_checkpoint(interrupted: Interrupted, path: Path | None, method: str) -> str:
    """Leave the checkpoint, and say so in a sentence.

    Parameters
    ----------
    interrupted : Interrupted
    path : path or None
        Where the checkpoint goes.
    method : str
        The name of the method.
    """
    checkpoint = interrupted.checkpoint
    if checkpoint is None:
        return f"{interrupted}; there is no checkpoint, as the method {method!r} kept nothing to go on from"
    if path is None:
        return f"{interrupted}; there is no checkpoint, as neither --output nor --checkpoint says where"
    try:
        with handled(signal.SIG_IGN):  # this takes a moment, and the wish is known
            write_atomically({path: checkpoint_writer(checkpoint)})
    except FileError as error:
        return f"{interrupted}; there is no checkpoint: {error}"
    again = f"the same command with --resume {shlex.quote(str(path))} goes on from it"
    return f"{interrupted}; the checkpoint is in {path}: {again}"
