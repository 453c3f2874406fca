"""Reading and writing of checkpoints, as NumPy archives."""

import os
from functools import partial
from pathlib import Path
from typing import Any

from isoembed.io import npz
from isoembed.io.files import FileError, Writer, check_ending, write_atomically
from isoembed.io.input_file import InputFile
from isoembed.io.registry import check_output
from isoembed.progress.checkpoints import Checkpoint
from isoembed.progress.fingerprint import Fingerprint

CHECKPOINT_ENDINGS = (".npz",)

KEPT, STATE = "kept/", "state/"  # prefixes of the array names, which the method chooses
TEXTS = ("key", "metric", "method", "version")
TOLERANCE = "tolerance"
FACTORIZATIONS = "factorizations"


def read_checkpoint(path: str | os.PathLike[str]) -> Checkpoint:
    """Read a checkpoint.

    Parameters
    ----------
    path : path
        Ends with ``.npz``.

    Returns
    -------
    Checkpoint

    Raises
    ------
    FileError
        The file cannot be read, holds no checkpoint, or was written by an earlier version.
    """
    check_ending(path, CHECKPOINT_ENDINGS)
    with InputFile(path) as file:
        tables = npz.read(file)
    if "stage" in tables and "key" not in tables:
        raise FileError(f"{file} is a checkpoint of an earlier isoembed, which this version cannot resume")
    scalar = partial(npz.scalar, tables, otherwise=f"{file} is not a checkpoint")
    texts = {name: scalar(name, "U") for name in TEXTS}
    fingerprint = Fingerprint(texts["metric"], texts["method"], scalar(TOLERANCE, "f"), texts["version"])
    arrays, state = (npz.with_prefix(tables, prefix) for prefix in (KEPT, STATE))
    return Checkpoint(texts["key"], arrays, state, fingerprint, scalar(FACTORIZATIONS, "i"))


def checkpoint_writer(checkpoint: Checkpoint) -> Writer:
    """Writer of the checkpoint; see `write_atomically`.

    Raises
    ------
    ValueError
        The checkpoint has no fingerprint; those handed out by `isoembed.embed` have one.
    """
    fingerprint = checkpoint.fingerprint
    if fingerprint is None:
        raise ValueError("the checkpoint does not say which computation it belongs to")
    tables: dict[str, Any] = {KEPT + name: array for name, array in checkpoint.arrays.items()}
    tables |= {STATE + name: array for name, array in checkpoint.state.items()}
    tables |= {name: getattr(fingerprint, name) for name in ("metric", "method", "version")}
    tables |= {"key": checkpoint.key, TOLERANCE: fingerprint.tolerance}
    tables[FACTORIZATIONS] = checkpoint.factorizations
    return lambda temporary: npz.write(temporary, tables)


def write_checkpoint(path: str | os.PathLike[str], checkpoint: Checkpoint) -> None:
    """Write a checkpoint atomically.

    Parameters
    ----------
    path : path
        Ends with ``.npz``.
    checkpoint : Checkpoint
        Checkpoint, such as that of an `isoembed.Interrupted`.

    Raises
    ------
    FileError
        The ending is not ``.npz`` or the file cannot be written.
    ValueError
        The checkpoint has no fingerprint.
    """
    check_output(path, CHECKPOINT_ENDINGS)
    write_atomically({Path(path): checkpoint_writer(checkpoint)})
