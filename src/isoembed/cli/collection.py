"""Garbage collector settings of a short-lived process."""

import atexit
import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def uncollected() -> Iterator[None]:
    """Load libraries in the block, and never look through what they brought, nor when the process ends.

    That would take each command a tenth of a second.  For a process that is all ours.
    """
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        gc.freeze()
        atexit.register(gc.freeze)
        if enabled:
            gc.enable()
