"""What the first runs of a command cost, and what later ones do.

    python benchmarks/cold_start.py [--only NAME ...]

Each row is a command line, run ten times in processes of its own: CPU seconds of the runs in their order, the
ratio of the first to the last, and the limit that the first is to keep.
"""

import argparse
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

RUNS = 10
ROWS = {  # the surface to embed, if any; the command line; most CPU seconds of its first run
    "convex 400": ("ellipsoid --vertices 400", "embed", 0.6),
    "convex 400, alexandrov": ("ellipsoid --vertices 400", "embed --method alexandrov", 0.6),
    "ergosphere 1,000": ("ergosphere --epsilon .3 --vertices 1000", "embed", 1.8),
    "convex 5,000": ("ellipsoid --vertices 5000", "embed", 0.9),
    "energy, Kerr horizon": (None, "energy --spacetime kerr --spin .5 --surface horizon", 1.8),
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


def run(arguments, folder):
    """Exit status and CPU seconds of a command line in a folder."""
    one_thread = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(
        [sys.executable, "-m", "isoembed", *arguments],
        cwd=folder,
        env={**os.environ, **one_thread},
        capture_output=True,
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return done.returncode, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def measure(surface, command):
    """Status of the first run, and CPU seconds of all of them."""
    with tempfile.TemporaryDirectory() as name:
        folder, arguments = Path(name), command.split()
        if surface:
            run(["surface", *surface.split(), "-o", "given.npz"], folder)
            arguments.append("given.npz")
        runs = [run(arguments, folder) for _ in range(RUNS)]
    return runs[0][0], [seconds for _, seconds in runs]


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--only", nargs="*", default=list(ROWS), choices=list(ROWS), metavar="NAME")
    options = parser.parse_args()
    for name in options.only:
        surface, command, limit = ROWS[name]
        status, seconds = measure(surface, command)
        said = "" if status == 0 else f"  exit {status}"
        missed = f"  over the limit of {limit}" if limit and seconds[0] > limit else ""
        numbers = " ".join(f"{each:5.2f}" for each in seconds)
        print(f"{name:26}{numbers}  {seconds[0] / seconds[-1]:4.1f}{said}{missed}", flush=True)


if __name__ == "__main__":
    main()
