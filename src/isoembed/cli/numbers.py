"""Arrays of numbers from ``.npy`` files."""

from pathlib import Path
from tokenize import TokenError

import numpy as np
from numpy.lib.format import MAGIC_PREFIX

from isoembed.arrays import Floats
from isoembed.io import FileError
from isoembed.io.files import open_input


def read_numbers(path: Path) -> Floats:
    """Read one array of real numbers.

    Raises
    ------
    FileError
        The file cannot be read, or has other contents; the message names the first nonfinite entry.
    """
    try:
        with open_input(path) as file:
            is_npy = file.peek().startswith(MAGIC_PREFIX)  # type: ignore[attr-defined]
            # numpy takes other files for pickles, and its message says how to load these.
            array = np.load(file, allow_pickle=False) if is_npy else None
    except FileError:
        raise
    except (ValueError, OSError, EOFError, SyntaxError, TokenError, MemoryError) as error:
        raise FileError(f"{path} is not a readable .npy file: {str(error).splitlines()[0]}") from None
    if array is None:
        raise FileError(f"{path} is not a .npy file")
    if array.dtype.kind not in "iuf":
        raise FileError(f"{path} does not hold one array of numbers")
    finite = np.isfinite(array)
    if not finite.all():
        index = tuple(int(i) for i in np.argwhere(~finite)[0])
        raise FileError(f"{path}: entry {index} is {array[index]}")
    return array.astype(np.float64)
