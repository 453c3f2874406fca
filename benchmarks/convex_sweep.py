"""The convex sweep: is every convex metric's polyhedron found, and is what is found right?

    python benchmarks/convex_sweep.py [--seeds N] [--first SEED] [--families NAME ...] [--jobs N]
                                      [--regular] [--json FILE] [--failures FILE]

Twenty families (`convex_families`) of random metrics that have a polyhedron: they come from coordinates, or
are doubly covered polygons, or convex polygons glued with no total angle above 2 pi (Alexandrov's theorem).
No solver decides this.  Every answer is checked by code that shares nothing with the solver (`convex_check`):
lengths of the returned triangles, given edges measured along the hull, area and volume of the hull, deficits.
Where the lengths determine the vertices, the vertices must also be within 1e-9 of the diameter of the
discarded ones.  They do where errors of a few machine epsilons of the lengths (256 after random flips), or as
large as those of the answer's lengths, move no vertex by 1e-9, by the rigidity matrices at the discarded
coordinates and at the answer, in which flat vertices are corners where rounding has made them some.  Flat
bodies, which may swell by the root of the rounding, nets, whose polyhedra nobody knows, and the worst of the
nearly flat are judged on the lengths alone.

With ``--regular`` it is the solids of the classics (`convex_regular`) instead, 4,644 of them.

A case is *found* if it passes, *refused* if the solver says that it found nothing, *off* if lengths and
convexity are right but determined vertices are elsewhere, and *wrong* if what is returned fails a check, or
if the solver ends in any other exception.  Metrics with noise have no polyhedron; they are asked for with a
``repair`` of twice the most negative deficit.  Checked are then the repaired lengths, that these are within
ten times the repair of the given ones, and that the vertices are within ten of its roots of those before the
noise.  Seconds are those of the processor.
"""

import argparse
import collections
import itertools
import json
import time
import traceback
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

import convex_check
import convex_families
import convex_regular

REQUIRED = {
    "needles and slabs to 1,000 : 1": (("needles", "slabs"), 0.99),
    "needles and slabs to 10,000 : 1": (("longer needles", "thinner slabs"), 0.90),
    "noise, repaired": (("noise",), 0.999),
    "solids of the classics": (tuple(convex_regular.COUNTS), 1.0),
}
"""Families that have a requirement of their own, and the share that is to be found."""

ALL_OTHERS = 0.999
SEEDS = 1000


def run(family, seed):
    """Make, solve and judge one case: a row."""
    import isoembed

    case = convex_families.make(family, seed)
    row = {
        "family": family,
        "seed": seed,
        "vertices": int(case.faces.max()) + 1,
        "size": case.size,
        "name": case.name,
    }
    start = time.process_time()
    try:
        metric = metric_of(case)
        found = isoembed.embed(metric, method=isoembed.Alexandrov(repair=case.repair))
        row["seconds"] = time.process_time() - start
        return row | judged(case, found)
    except (isoembed.NotEmbedded, isoembed.InvalidMetric) as refusal:
        row |= {"status": "refused", "message": f"{type(refusal).__name__}: {refusal}"}
    except Exception as error:  # a traceback is what the sweep looks for
        row |= {"status": "wrong", "message": f"{error!r} at {traceback.extract_tb(error.__traceback__)[-1]}"}
    return row | {"seconds": time.process_time() - start}


def metric_of(case):
    """What the solver gets."""
    import isoembed

    if case.twins is not None:
        return isoembed.GluedMetric(case.faces, case.twins, case.lengths, curvature=case.curvature)
    lengths = case.lengths.ravel()[convex_check.sides_of(case)]
    return isoembed.PolyhedralMetric(case.faces, lengths, curvature=case.curvature)


def judged(case, found):
    """What the checks say of an answer."""
    checks = convex_check.check(case, found)
    row = {"checks": checks, "residual": max(checks["lengths"], checks["paths"])}
    failed = [name for name, most in convex_check.ALLOWED.items() if not checks[name] <= most]
    changed = float(np.abs(found.given.face_lengths / case.lengths - 1).max()) if case.repair else 0.0
    if not changed <= 10 * case.repair:
        return row | {"status": "wrong", "message": f"the repair changed lengths by {changed:.1e}"}
    if failed:
        return row | {
            "status": "wrong",
            "message": ", ".join(f"{name} {checks[name]:.1e}" for name in failed),
        }
    if case.points is None:
        return row | {"status": "found"}
    uncertainty = convex_check.uncertainty(case, found, row["residual"])
    allowed = max(convex_check.DISTANCE, 10 * case.repair**0.5)
    row["uncertainty"] = uncertainty
    row["distance"] = distance = convex_check.distance(found.vertices, case.points)
    row["determined"] = bool(uncertainty <= allowed)
    if row["determined"] and not distance <= allowed:
        return row | {"status": "off", "message": f"{distance:.1e} of the diameter away"}
    return row | {"status": "found"}


def rows_of(tasks, jobs):
    """Run all, in order; in processes of their own if there are to be several at once."""
    if jobs == 1:
        yield from (run(*task) for task in tasks)
        return
    with ProcessPoolExecutor(jobs) as pool:
        yield from pool.map(run, *zip(*tasks, strict=True), chunksize=10)


COLUMNS = ("refused", "off", "wrong", "determined", "distance", "residual", "seconds", "slowest")


def print_family(family, rows):
    """Print what came of a family."""
    count = collections.Counter(row["status"] for row in rows)
    done = [row for row in rows if row["status"] in ("found", "off")]
    far = max((row["distance"] for row in done if row.get("determined")), default=np.nan)
    residual = max((row["residual"] for row in done), default=np.nan)
    seconds = [row["seconds"] for row in rows]
    determined = sum(row.get("determined", False) for row in rows)
    print(
        f"{family:24} {len(rows):6d} {count['found']:6d} {count['refused']:8d} {count['off']:8d} "
        f"{count['wrong']:8d} {determined:10d} {far:8.0e} {residual:8.0e} {sum(seconds):8.1f} "
        f"{max(seconds):8.2f}",
        flush=True,
    )


def print_requirements(rows):
    """Print what was asked for and what was found."""
    apart = {family for families, _ in REQUIRED.values() for family in families}
    rest = {row["family"] for row in rows} - apart
    for name, (families, share) in {**REQUIRED, "all others": (rest, ALL_OTHERS)}.items():
        found = [row["status"] == "found" for row in rows if row["family"] in families]
        if found:
            percent = f"{100 * np.mean(found):.2f} % (asked: {100 * share:g} %)"
            print(f"{name}: {sum(found)} of {len(found)} found, {percent}")
    print(f"wrong: {sum(row['status'] == 'wrong' for row in rows)} (asked: 0)")


def main():
    """Run what is asked."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    counts = convex_regular.COUNTS
    names = [*convex_families.FAMILIES, *counts]
    parser.add_argument("--seeds", type=int, metavar="N", help="cases of every family: 1,000, or all")
    parser.add_argument("--regular", action="store_true", help="the solids of the classics")
    parser.add_argument("--first", type=int, default=0, metavar="SEED")
    parser.add_argument("--families", nargs="*", choices=names, metavar="NAME")
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="processes")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all rows")
    parser.add_argument("--failures", type=Path, metavar="FILE", help="write what was not found, and why")
    options = parser.parse_args()
    families = options.families or (counts if options.regular else convex_families.FAMILIES)
    tasks = [
        (family, number)
        for family in families
        for number in range(counts.get(family, options.first + SEEDS))[options.first :][: options.seeds]
    ]
    print(f"{'family':24} {'cases':>6} {'found':>6}", *(f"{name:>{max(8, len(name))}}" for name in COLUMNS))
    rows = []
    with threadpool_limits(1):  # matrices this small are slower on two, and several processes much slower
        for family, some in itertools.groupby(rows_of(tasks, options.jobs), lambda row: row["family"]):
            rows += list(some)
            print_family(family, [row for row in rows if row["family"] == family])
    print_requirements(rows)
    if options.json:
        options.json.write_text(json.dumps(rows, indent=0))
    if options.failures:
        failed = [row for row in rows if row["status"] != "found"]
        lines = [
            f"{row['family']}\t{row['seed']}\t{row['name']}\t{row['status']}\t{row['message']}\n"
            for row in failed
        ]
        options.failures.write_text("".join(lines))


if __name__ == "__main__":
    main()
