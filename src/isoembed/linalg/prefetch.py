"""Prefetching for compiled modules, declared in ``prefetch.pxd``; nothing in interpreted runs."""

from isoembed.arrays import Floats


def prefetch(values: Floats, first: int, last: int) -> None:
    """Fetch a range of an array into the cache, as far as it exists, while other work goes on."""
