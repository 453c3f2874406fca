"""What the first run of a command costs, with nothing compiled, and what later ones do.

    python benchmarks/cold_start.py [--only NAME ...]

Each row is a command line, run in processes of its own with a cache of compiled code that is empty at first:
CPU seconds of the first run, the functions that were compiled in it and what that took of the clock, then the
least CPU seconds of three runs after it, the ratio of the two, and the limit that the first is to keep.
"""

import argparse
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

ROWS = {  # the surface to embed, if any; the command line; most CPU seconds of its first run
    "convex 400": ("ellipsoid --vertices 400", "embed", 2.5),
    "convex 400, alexandrov": ("ellipsoid --vertices 400", "embed --method alexandrov", 2.5),
    "ergosphere 1,000": ("ergosphere --epsilon .3 --vertices 1000", "embed", 8.0),
    "convex 5,000": ("ellipsoid --vertices 5000", "embed", 8.0),
    "energy, Kerr horizon": (None, "energy --spacetime kerr --spin .5 --surface horizon", 4.0),
    "surface": (None, "surface ellipsoid --vertices 400 -o surface.npz", None),
    "inspect": ("ellipsoid --vertices 400", "inspect", None),
    "smooth grid, triangulate": (
        None,
        "triangulate --spacetime kerr --spin .5 --surface horizon --vertices 400 -o t.npz",
        None,
    ),
    "energy, Wang-Yau": (None, "energy --wang-yau --spacetime kerr --spin .5 --surface r=4", None),
    "horizon, found": (None, "horizon --find --geometry kerr-schild --spin 0 0 .5", None),
}
COMMAND = """
import sys
from isoembed.cli import main
try:
    status = main()
except SystemExit as end:
    status = end.code
from isoembed.progress.compiling import COMPILING
print(COMPILING.functions, COMPILING.seconds, file=open("compiled", "w"))
sys.exit(status)
"""


def run(arguments, folder):
    """Exit status, CPU seconds, functions compiled and the seconds of that, of a command line in a folder."""
    one_thread = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    environment = {**os.environ, **one_thread, "NUMBA_CACHE_DIR": str(folder / "cache")}
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(
        [sys.executable, "-c", COMMAND, *arguments], cwd=folder, env=environment, capture_output=True
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    functions, seconds = (folder / "compiled").read_text().split()
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return done.returncode, cpu, int(functions), float(seconds)


def measure(surface, command):
    """Status, CPU seconds, functions and seconds of compilation of a first run; then least of three more."""
    with tempfile.TemporaryDirectory() as name:
        folder, arguments = Path(name), command.split()
        if surface:
            run(["surface", *surface.split(), "-o", "given.npz"], folder)
            for kept in (folder / "cache").glob("*/*"):
                kept.unlink()
            arguments.append("given.npz")
        first = run(arguments, folder)
        return *first, min(run(arguments, folder)[1] for _ in range(3))


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--only", nargs="*", default=list(ROWS), choices=list(ROWS), metavar="NAME")
    options = parser.parse_args()
    print(
        f"{'':26}{'first':>8}{'limit':>7}{'compiled':>10}{'seconds':>9}{'later':>8}{'ratio':>7}", flush=True
    )
    for name in options.only:
        surface, command, limit = ROWS[name]
        status, cpu, functions, seconds, later = measure(surface, command)
        said = "" if status == 0 else f"  exit {status}"
        missed = "  over the limit" if limit and cpu > limit else ""
        print(
            f"{name:26}{cpu:8.2f}{limit or '':>7}{functions:10d}{seconds:9.2f}{later:8.2f}{cpu / later:7.1f}"
            f"{said}{missed}",
            flush=True,
        )


if __name__ == "__main__":
    main()
