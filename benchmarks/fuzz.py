"""A fuzzer: random metrics of 32 families, every answer checked by independent code.

    python benchmarks/fuzz.py [--count N] [--first SEED] [--families NAME ...] [--rows FILE]
                              [--failures FOLDER] [--limit SECONDS]
    python benchmarks/fuzz.py --again FILE ...

A case is a family and a number, and is embedded twice: as it is, and with other numbers of vertices and faces
and in another unit.  Where the triangles of a convex body are a simplicial complex, every fourth is embedded
by the default method instead of Alexandrov's.  Checked are lengths, in extended precision; of polyhedra the
convexity, area, volume, deficits, and given edges by unfolding the triangles that they cross; what the answer
claims of its residual; a certificate's distance, where the coordinates are known; the other realizations that
it names; and whether both answers are the same.

found        all checks passed
another      lengths are right, but the surface or that of the copy is not that which the lengths came from
refused      by a sentence, of metrics that have no surface, or of which nobody knows
lost         refused, though there is a surface
FALSE        a check failed, or a metric without a surface was embedded
differ       the copy was refused and the original was not, or the other way round, or is another polyhedron
exception    anything else that was raised
warning      a warning was given
hang, crash  the process was ended after so many seconds of the processor, or ended itself

Rows are appended to a file as they come, and a run that was ended goes on where it was.  Cases of the last
six kinds are kept as files, which ``--again`` runs.
"""

import argparse
import collections
import json
import multiprocessing
import os
import signal
import time
from contextlib import suppress
from dataclasses import fields
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

import fuzz_families
from convex_cases import Case
from fuzz_verdict import KEPT, KINDS, run

IDLE = 20  # limits of seconds, by the clock, after which nothing will come


def worker(pipe, limit):
    """Run cases as they come, in a process of its own, each for so many seconds of the processor."""
    os.nice(10)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # Where the other process has ended, so does this one.
    with threadpool_limits(1), suppress(EOFError, ConnectionError):
        run(fuzz_families.make("hulls", 0), "hulls", 0)  # compiles
        run(fuzz_families.make("dents", 0), "dents", 0)
        pipe.send(None)
        while True:
            family, seed, case = pipe.recv()
            case = case or fuzz_families.make(family, seed)
            signal.setitimer(signal.ITIMER_PROF, limit)  # ends the process
            row = run(case, family, seed)
            signal.setitimer(signal.ITIMER_PROF, 0)
            pipe.send((row, case if row["kind"] in KEPT else None))


class Workers:
    """One process at a time; another where one has ended."""

    def __init__(self, limit):
        self.limit, self.process = limit, None

    def start(self):
        context = multiprocessing.get_context("spawn")
        self.pipe, theirs = context.Pipe()
        self.process = context.Process(target=worker, args=(theirs, self.limit), daemon=True)
        self.process.start()
        theirs.close()
        self.pipe.recv()

    def run(self, family, seed, case=None):
        """The row of a case, and the case if it is to be kept."""
        if self.process is None:
            self.start()
        start = time.monotonic()
        try:
            self.pipe.send((family, seed, case))
            if self.pipe.poll(IDLE * self.limit):
                return self.pipe.recv()
        except (EOFError, ConnectionError):
            pass
        self.process.kill()
        self.process.join()
        code, self.process = self.process.exitcode, None
        hung = code in (-signal.SIGPROF, -signal.SIGKILL)
        row = {"family": family, "seed": seed, "method": "", "seconds": time.monotonic() - start}
        row |= {"kind": "hang" if hung else "crash", "message": f"the process ended with {code}"}
        return row, case or fuzz_families.make(family, seed)


def keep(folder, case, row):
    """Write a case that failed."""
    folder.mkdir(parents=True, exist_ok=True)
    name = row["family"].replace(" ", "-").replace(",", "").replace("<", "below")
    tables = {field.name: getattr(case, field.name) for field in fields(Case) if field.name != "core"}
    points, faces = case.core or (None, None)
    tables |= {"core_points": points, "core_faces": faces, "row": json.dumps(row)}
    tables = {key: value for key, value in tables.items() if value is not None}
    np.savez_compressed(folder / f"{name}-{row['seed']}.npz", **tables)


def kept(path):
    """A case that was kept, its family and number."""
    with np.load(path) as tables:
        values = {key: tables[key] for key in tables.files}
    row = json.loads(str(values.pop("row")))
    core = (values.pop("core_points", None), values.pop("core_faces", None))
    values = {key: value if value.ndim else value.item() for key, value in values.items()}
    case = Case(**{"twins": None} | values, core=core if core[0] is not None else None)
    return case, row["family"], row["seed"]


def tell(row):
    """Print a row that somebody should look at."""
    at = f"{row['family']} {row['seed']} ({row['method']}, {row.get('vertices', '?')} vertices)"
    print(f"  {row['kind']}: {at}: {row['message'][:300]}", flush=True)


def print_counts(rows):
    """Counts by family."""
    print(f"{'family':24} {'cases':>7}", *(f"{kind:>9}" for kind in KINDS), f"{'seconds':>9} {'slowest':>8}")
    by = collections.defaultdict(list)
    for row in rows:
        by[row["family"]].append(row)
    for family, some in [*by.items(), ("all", rows)]:
        count = collections.Counter(row["kind"] for row in some)
        seconds = [row["seconds"] for row in some]
        counts = (f"{count[kind]:9d}" for kind in KINDS)
        print(f"{family:24} {len(some):7d}", *counts, f"{sum(seconds):9.1f} {max(seconds, default=0):8.2f}")


def main():
    """Run what is asked."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--count", type=int, default=20, metavar="N", help="cases of every family")
    parser.add_argument("--first", type=int, default=0, metavar="SEED")
    parser.add_argument(
        "--families", nargs="*", default=fuzz_families.FAMILIES, choices=fuzz_families.FAMILIES
    )
    parser.add_argument("--rows", type=Path, metavar="FILE", help="where rows are, and are appended")
    parser.add_argument("--failures", type=Path, metavar="FOLDER", help="where cases that fail are kept")
    parser.add_argument("--limit", type=float, default=60.0, metavar="SECONDS", help="of a case")
    parser.add_argument("--again", type=Path, nargs="+", metavar="FILE", help="cases that were kept")
    options = parser.parse_args()
    workers = Workers(options.limit)
    if options.again:
        for path in options.again:
            case, family, seed = kept(path)
            tell(workers.run(family, seed, case)[0])
        return
    rows = []
    if options.rows and options.rows.exists():
        rows = [json.loads(line) for line in options.rows.read_text().splitlines()]
    done = {(row["family"], row["seed"]) for row in rows}
    tasks = [
        (family, seed)
        for seed in range(options.first, options.first + options.count)
        for family in options.families
        if (family, seed) not in done
    ]
    with suppress(KeyboardInterrupt):
        for family, seed in tasks:
            row, case = workers.run(family, seed)
            rows.append(row)
            if options.rows:
                with options.rows.open("a") as file:
                    file.write(json.dumps(row) + "\n")
            if row["kind"] in KEPT:
                tell(row)
                if options.failures:
                    keep(options.failures, case, row)
    print_counts(rows)


if __name__ == "__main__":
    main()
