"""What functions took as Python in earlier processes: many short runs pay for compiled code together."""

import json
import os
from contextlib import suppress
from functools import lru_cache
from pathlib import Path

from isoembed.kernel.place import place_of

NAME = "interpreted.json"


@lru_cache
def earlier() -> dict[str, float]:
    """Seconds of each function, since it was last compiled, as they were when the process began."""
    return _read(_file())


def write(spent: dict[str, float], compiled: set[str]) -> None:
    """Add what functions took, and forget what those took that were compiled.

    Other processes may have written in between.  Where nothing can be written, nothing is.
    """
    file = _file()
    if file is None or not (spent or compiled):
        return
    before = _read(file)
    kept = {name: seconds for name, seconds in before.items() if name not in compiled}
    now = kept | {name: kept.get(name, 0.0) + seconds for name, seconds in spent.items()}
    with suppress(OSError):
        file.parent.mkdir(parents=True, exist_ok=True)
        new = file.with_name(f"{NAME}.{os.getpid()}")
        try:
            new.write_text(json.dumps(now, indent=0))
            new.replace(file)
        finally:
            new.unlink(missing_ok=True)  # what a full disk left of it


def _file() -> Path | None:
    place = place_of(Path(__file__).parent)
    return None if place is None else place / NAME


def _read(file: Path | None) -> dict[str, float]:
    if file is None:
        return {}
    try:
        found = json.loads(file.read_text())
    except (OSError, ValueError):  # there is none, or it is damaged
        return {}
    known = found.items() if isinstance(found, dict) else ()
    return {name: float(seconds) for name, seconds in known if isinstance(seconds, int | float)}
