"""Available memory of the process.

Where memory is promised more often than it exists, a process that takes too much is killed without a word.
"""

import os
import sys
from pathlib import Path
from typing import Any

UNKNOWN = 1 << 62  # bytes: no bound is known
UNITS = ("bytes", "kB", "MB", "GB", "TB", "PB")


UNASKED = 1 << 24  # bytes: less is taken without asking, which is as fast as asking

PROC = Path("/proc")
CGROUPS = Path("/sys/fs/cgroup")

KEPT = {-3: 1 << 26, -1: -1, -2: 1 << 26}
"""Parameters of mallopt: M_MMAP_THRESHOLD and M_TOP_PAD in bytes, and no M_TRIM_THRESHOLD."""


class OutOfMemory(MemoryError):  # noqa: N818  (named for what it says, as SingularMatrix is)
    """The memory needed exceeds what this process may take; the message says by how much."""


def require_memory(needed: int, what: str) -> None:
    """Raise OutOfMemory unless this many bytes are free; `what`, in the plural, needs them in its message."""
    if needed > UNASKED:
        free = available_memory()
        if needed > free:
            _give_back()
            free = available_memory()
        if needed > free:
            raise OutOfMemory(
                f"{what} need about {readable(needed)} of memory, and {readable(free)} are free"
            )


def keep_freed_memory() -> None:
    """Have the C library keep what is freed for arrays to come, if it is glibc.

    By default it gives all large arrays back, and the system clears their pages when the next one touches
    them: a tenth of all the time that a million vertices take.  The largest are still given back, so that
    they leave no holes.  To be called once, by a process that is all ours.
    """
    if (mallopt := _c_library("mallopt")) is not None:
        for parameter, value in KEPT.items():
            mallopt(parameter, value)


def _give_back() -> None:
    if (trim := _c_library("malloc_trim")) is not None:
        trim(0)


def _c_library(name: str) -> Any:
    """A function of glibc, or None."""
    import ctypes

    return getattr(ctypes.CDLL(None), name, None) if sys.platform == "linux" else None


def readable(size: float) -> str:
    """A number of bytes, to three digits."""
    step = 0
    while size >= 999.5 and step < len(UNITS) - 1:
        size, step = size / 1000, step + 1
    return f"{size:.{1 if size < 99.95 and step else 0}f} {UNITS[step]}"


def available_memory() -> int:
    """Bytes that this process may still take: the least that the machine and its limits leave.

    Returns
    -------
    int
        What Linux calls available, and what control groups and the limit on the address space leave;
        elsewhere the free pages. `UNKNOWN` where nothing tells.
    """
    return max(0, min(_machine(), _control_groups(), _address_space()))


def _machine() -> int:
    for line in _lines(PROC / "meminfo"):
        if line.startswith("MemAvailable:"):
            return 1024 * int(line.split()[1])
    try:
        return os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError, OSError):
        return UNKNOWN


def _address_space() -> int:
    """Memory that RLIMIT_AS leaves; the size of the process comes first in `statm`, in pages."""
    try:
        import resource
    except ImportError:  # Windows
        return UNKNOWN
    limit = resource.getrlimit(resource.RLIMIT_AS)[0]
    if limit == resource.RLIM_INFINITY:
        return UNKNOWN
    used = [int(line.split()[0]) * resource.getpagesize() for line in _lines(PROC / "self" / "statm")]
    return limit - sum(used)


def _control_groups() -> int:
    """Memory left by the limits of the process's control group and those above it, in either version."""
    left = UNKNOWN
    for line in _lines(PROC / "self" / "cgroup"):
        _, controllers, path = line.split(":", 2)
        if controllers == "":
            root, limit, usage, reclaimable = CGROUPS, "memory.max", "memory.current", "inactive_file"
        elif "memory" in controllers.split(","):
            root, limit, usage = CGROUPS / "memory", "memory.limit_in_bytes", "memory.usage_in_bytes"
            reclaimable = "total_inactive_file"
        else:
            continue
        # Inside a container the path may be that outside: its own group then is the root.
        group = root / path.strip("/")
        for folder in (group, *group.parents):
            left = min(left, _left(folder, limit, usage, reclaimable))
            if folder == root:
                break
    return left


def _left(folder: Path, limit: str, usage: str, reclaimable: str) -> int:
    limits, used = _lines(folder / limit), _lines(folder / usage)
    if not (limits and used and limits[0].isdigit()):  # "max" is no limit
        return UNKNOWN
    cached = [
        int(line.split()[1]) for line in _lines(folder / "memory.stat") if line.startswith(reclaimable + " ")
    ]
    return int(limits[0]) - int(used[0]) + sum(cached)


def _lines(path: Path) -> list[str]:
    try:
        return path.read_text().splitlines()
    except OSError:
        return []
