"""Cache prefetching for compiled modules, declared in ``prefetch.pxd``; no operation in interpreted runs."""

from isoembed.arrays import Floats


def prefetch(values: Floats, first: int, last: int) -> None:
    """Fetch the part of an array in this range into the cache while other work goes on."""
