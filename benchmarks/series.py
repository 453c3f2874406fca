"""A long series of horizons on one and on two processes, and what a run costs beside its horizons.

    python benchmarks/series.py [--count N] [--vertices N] [--json FILE]

The horizons are those of Kerr-Schild slices of mass 1 whose spin grows from .3 to .7 while it turns about the
z-axis at an angle of .7.

Printed are the seconds of the clock on one and on two processes, from their start to their end, and the
ratio; the seconds of a horizon that begins from a mesh and of one that begins from the one before; the peak
of the memory of a worker; what digests, sending and keeping add to a task, over computing it; the largest
error of the mass and the largest of the stated ones; and the makespan on 2, 16 and 1,000 workers: chunks of
the measured seconds, each given to the worker that is free first, whose own start takes what it took here.
The simulated time on two workers beside the measured one tells what that is worth.
"""

import argparse
import heapq
import json
import pickle
import resource
import tempfile
import time
from pathlib import Path

import numpy as np

from isoembed.relativity import HorizonOptions, HorizonTask, KerrSchild, Moment, StarSurface
from isoembed.relativity.series.source import HeldShape, HeldSlice
from isoembed.runs import Store, Workers, run
from isoembed.runs.run import CHUNK
from isoembed.runs.task import key_of

TILT, TURNS = 0.7, 2.0
SAMPLE = 2 * CHUNK  # tasks whose parts are timed one by one
WORKERS = (2, 16, 1000)


def moment(k, t):
    """The horizon of a slice, t from 0 to 1."""
    phi = 2.0 * np.pi * TURNS * t
    axis = np.array([np.sin(TILT) * np.cos(phi), np.sin(TILT) * np.sin(phi), np.cos(TILT)])
    geometry = KerrSchild(1.0, (0.3 + 0.4 * t) * axis)
    surface = StarSurface.from_radius(geometry.spheroid(geometry.horizon))
    return Moment("ah1", t, k, HeldShape(surface), HeldSlice(geometry))


def series(count, vertices):
    options = HorizonOptions(vertices=vertices)
    return [HorizonTask(moment(k, t), options) for k, t in enumerate(np.linspace(0.0, 1.0, count))]


def carried_out(tasks, jobs, folder):
    """Seconds of the clock, and the outcomes in the order of the tasks."""
    start = time.perf_counter()
    with Workers(jobs) as workers:
        outcomes = list(run(tasks, store=Store.made(folder), executor=workers))
    seconds = time.perf_counter() - start
    place = {task.label: k for k, task in enumerate(tasks)}
    return seconds, sorted(outcomes, key=lambda outcome: place[outcome.result.label])


def overhead(tasks, folder):
    """Seconds of computing tasks, and of what is done beside it, in this process."""
    computed = beside = 0.0
    store, before = Store.made(folder), None
    tasks[0].compute(None)  # compiles, or loads what was compiled
    for k, task in enumerate(tasks):
        start = time.perf_counter()
        result = task.compute(None if k % CHUNK == 0 else before)
        middle = time.perf_counter()
        sent = pickle.loads(pickle.dumps(task))
        key = key_of(sent.digest())
        assert store.find(task.label, key) is None
        store.keep(result, key)
        before = pickle.loads(pickle.dumps(result))
        computed, beside = computed + middle - start, beside + time.perf_counter() - middle
    return computed, beside


def makespan(chunks, workers, start):
    """Seconds until the last of the chunks is done, each given to the worker that is free first."""
    free = [start] * workers
    for seconds in chunks:
        heapq.heappush(free, heapq.heappop(free) + seconds)
    return max(free)


def in_chunks(seconds, size):
    return [sum(seconds[k : k + size]) for k in range(0, len(seconds), size)]


def measured(count, vertices):
    tasks = series(count, vertices)
    found = {"horizons": count, "vertices": vertices}
    with tempfile.TemporaryDirectory() as folder:
        computed, beside = overhead(tasks[:SAMPLE], Path(folder) / "alone")
        found["overhead"] = beside / computed
        for jobs in (1, 2):
            found[f"seconds on {jobs}"], outcomes = carried_out(tasks, jobs, Path(folder) / str(jobs))
            found[f"memory on {jobs}"] = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024.0
            if jobs == 1:
                seconds = [outcome.seconds for outcome in outcomes]
    found["ratio"] = found["seconds on 1"] / found["seconds on 2"]
    reports = [outcome.result.report for outcome in outcomes]
    found["embedded"] = sum(outcome.result.status == "embedded" for outcome in outcomes)
    found["mass error"] = max(abs(report["christodoulou_mass"] - 1.0) for report in reports)
    found["stated error"] = max(report["errors"]["christodoulou_mass"] for report in reports)
    found["within"] = sum(
        abs(report["christodoulou_mass"] - 1.0) <= report["errors"]["christodoulou_mass"]
        for report in reports
    )
    cold = seconds[CHUNK::CHUNK] or seconds[:1]  # of the first chunk, something is loaded besides
    warm = [each for k, each in enumerate(seconds) if k % CHUNK]
    found["from a mesh"], found["from the one before"] = float(np.median(cold)), float(np.median(warm))
    # Of a process: importing, and loading what was compiled, which its first task waits for.
    start = found["seconds on 1"] - sum(seconds) + max(seconds[0] - found["from a mesh"], 0.0)
    seconds[0] = min(seconds[0], found["from a mesh"])
    found["start of a worker"] = start
    for workers in WORKERS:
        found[f"makespan on {workers}"] = makespan(in_chunks(seconds, CHUNK), workers, start)
        alone = [found["from a mesh"]] * count
        found[f"makespan on {workers}, chunks of one"] = makespan(alone, workers, start)
    return found


def lines(found):
    yield (
        f"{found['horizons']} horizons with {found['vertices']} vertices, {found['embedded']} embedded; the "
        f"mass is off by {found['mass error']:.0e} at most, {found['stated error']:.0e} is stated, "
        f"{found['within']} within"
    )
    yield (
        f"{found['seconds on 1']:.1f} s on one process, {found['seconds on 2']:.1f} s on two: "
        f"{found['ratio']:.2f} times faster"
    )
    yield (
        f"a horizon takes {found['from a mesh']:.2f} s from a mesh, {found['from the one before']:.2f} s "
        f"from the one before; digests, sending and keeping add {100.0 * found['overhead']:.1f} %"
    )
    yield (
        f"memory of a worker: {found['memory on 1']:.0f} MB; its start takes "
        f"{found['start of a worker']:.1f} s"
    )
    for workers in WORKERS:
        eight, one = (found[f"makespan on {workers}{size}"] for size in ("", ", chunks of one"))
        beside = f" (measured: {found['seconds on 2']:.1f} s)" if workers == 2 else ""
        yield (
            f"simulated on {workers} workers: {eight:.1f} s in chunks of {CHUNK}{beside}, {one:.1f} s in "
            "chunks of one"
        )


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--count", type=int, default=48, metavar="N", help="horizons (default 48)")
    parser.add_argument("--vertices", type=int, default=100, metavar="N", help="of a mesh (default 100)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the numbers to this file")
    options = parser.parse_args()
    if options.count < SAMPLE:
        parser.error(f"--count must be at least {SAMPLE}, not {options.count}")
    found = measured(options.count, options.vertices)
    for line in lines(found):
        print(line, flush=True)
    if options.json:
        options.json.write_text(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
