"""The default method where K < 0, at 40,000 vertices and more, through the command: files in, files out.

    python benchmarks/bent.py [--sizes N ...] [--bodies NAME ...] [--kinds KIND ...]
                              [--meshes DIR] [--json FILE]

Nine bodies; at 160,000 vertices five of them, at 640,000 one ergosphere, irregular.  Regular meshes have
nearly equilateral triangles, irregular ones are of blue noise.

Every row is as in ``million.py``, with the default of everything and one thread.  At its end it says where a
limit is missed: on seconds of the processor and memory, by size, and on the distance to the discarded
coordinates, a millionth of the diameter.  A run is ended at five times its limit of seconds.  Last come
counts of the rows that are aligned, and that are within all limits.  A small run before the first row
compiles what it needs; what is compiled later on is among the stages.
"""

import argparse
import json
import tempfile
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from command_runs import HEAD, exponent, kept_mesh, measure, show
from isoembed.gallery import HarmonicSurface, triangulate
from realizations import ALIGNED, GALLERY

BODIES = {
    **{name: GALLERY[name] for name in ("peanut", "saddle", "trefoil", "tube", "bean")},
    "y43": HarmonicSurface(degree=4, order=3, amplitude=0.15),
    **{name: GALLERY[name] for name in ("ergosphere 0.3", "ergosphere 0.1", "ergosphere 0.02")},
}
KINDS = {"regular": None, "irregular": 0}
LARGE = ("ergosphere 0.3", "ergosphere 0.1", "ergosphere 0.02", "peanut", "trefoil")
LARGEST = ("ergosphere 0.3",)
EDGES = 2_000_000  # above, one factorization of J J^T is not timed
SMALL = 2000  # vertices
PATIENCE = 5  # limits of seconds
EXPONENT = 1.2


@dataclass(frozen=True)
class Limit:
    """Most seconds of the processor, and memory in MB, of a run with so many vertices."""

    vertices: int
    seconds: float
    memory: float = float("inf")

    def missed(self, row):
        """What of a row is beyond the limits, in words."""
        if "failed" in row:
            return ["no surface"]
        return [
            *([f"off by {row['aligned']:.0e}"] if not row["aligned"] <= ALIGNED else []),
            *([f"{row['cpu']:.0f} s > {self.seconds:g}"] if row["cpu"] > self.seconds else []),
            *([f"{row['peak']:.0f} MB > {self.memory:g}"] if row["peak"] > self.memory else []),
        ]


LIMITS = (Limit(40_000, 20), Limit(160_000, 120, 4096), Limit(640_000, 600, 12288))


def limit(n):
    """That of the least size as large; beyond all, of the largest."""
    return next((each for each in LIMITS if n <= each.vertices), LIMITS[-1])


def wanted(sizes, bodies, kinds):
    """Body, kind and sizes of the rows."""
    for body in bodies:
        for kind in kinds:
            few = [
                n
                for n in sizes
                if not (n == 160_000 and body not in LARGE)
                and not (n == 640_000 and (body not in LARGEST or kind == "regular"))
            ]
            if few:
                yield body, kind, few


def main():
    """Run what is asked."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--sizes", type=int, nargs="+", default=(40_000,), metavar="N")
    parser.add_argument("--bodies", nargs="+", choices=BODIES, default=BODIES, metavar="NAME")
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=KINDS, metavar="KIND")
    parser.add_argument("--meshes", type=Path, help="where to keep meshes")
    parser.add_argument("--json", type=Path, help="write the rows to this file")
    options = parser.parse_args()
    rows, slopes = [], {}
    print(HEAD, flush=True)
    with tempfile.TemporaryDirectory() as scratch:
        folder = options.meshes or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        measure(kept_mesh(Path(scratch) / "small.npz", partial(triangulate, BODIES["peanut"], SMALL)), 0)
        for body, kind, sizes in wanted(options.sizes, options.bodies, options.kinds):
            name, batch = f"{body}, {kind}", []
            for n in sizes:
                make = partial(triangulate, BODIES[body], n, irregular=KINDS[kind])
                path = kept_mesh(folder / f"{body.replace(' ', '-')}_{kind}_{n}.npz", make)
                row = measure(path, EDGES, seconds=int(PATIENCE * limit(n).seconds))
                row = {"name": name, **row, "missed": limit(n).missed(row)}
                show(name, row, "".join(f"  ** {each}" for each in row["missed"]))
                batch.append(row)
            if (slope := exponent(batch)) is not None:
                slopes[name] = slope
                print(f"{name}: exponent {slope:.2f}", flush=True)
            rows += batch
    print(f"\naligned: {sum(row.get('aligned', 1.0) <= ALIGNED for row in rows)} of {len(rows)}, "
          f"within all limits: {sum(not row['missed'] for row in rows)}")  # fmt: skip
    if slopes:
        steep = max(slopes, key=slopes.get)
        print(f"largest exponent: {slopes[steep]:.2f} ({steep}); {EXPONENT} are allowed")
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1))


if __name__ == "__main__":
    main()
