"""Dask clusters."""

from __future__ import annotations

import re
from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager

from isoembed.errors import InvalidParameter

ADDRESS = re.compile(r"((tcp|tls|ucx|wss?)://)?[^/\s]+:\d+")
PATIENCE = 10.0  # seconds to wait for a scheduler


@contextmanager
def dask_workers(address: str) -> Iterator[Executor]:
    """Executor on the workers of a running Dask scheduler.

    Dask reruns the tasks of a lost worker on another.  All workers must see the files of the tasks and the
    store under the same paths, have isoembed installed, and have one thread each.

    Parameters
    ----------
    address : str
        ``tcp://host:port``.

    Raises
    ------
    InvalidParameter
        Dask is not installed, or the scheduler does not answer.
    """
    if not ADDRESS.fullmatch(address):
        raise InvalidParameter(f"{address!r} is not a scheduler address such as tcp://127.0.0.1:8786")
    try:
        from distributed import Client
    except ImportError:
        raise InvalidParameter("a cluster needs Dask: pip install distributed") from None
    try:
        client = Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError) as error:  # no answer, or an invalid address
        why = " ".join(str(error).split())
        raise InvalidParameter(f"there is no scheduler of Dask at {address}: {why}") from None
    with client:
        executor = client.get_executor(pure=False)
        try:
            yield executor
        except BaseException:
            executor.shutdown(wait=False)  # cancels running tasks
            raise
        executor.shutdown()
