"""One run of ``isoembed embed`` on a mesh in a file, in a process of its own, and what it took."""

import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from functools import partial
from pathlib import Path

import numpy as np

from isoembed import PolyhedralMetric
from isoembed.aim.levels import HELD
from isoembed.io import write_metric
from stages import aligned

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def kept_mesh(path, make):
    """The path, with a mesh in it: the one that is there, or else one that is made, its labels shuffled."""
    if not path.exists():
        vertices, faces = make()
        rng = np.random.default_rng(1)
        label = rng.permutation(len(vertices))
        shuffled = np.empty_like(vertices)
        shuffled[label] = vertices
        np.savez(path, vertices=shuffled, faces=label[faces][rng.permutation(len(faces))])
    return path


def read_mesh(path):
    """Vertices and faces."""
    with np.load(path) as kept:
        return kept["vertices"], kept["faces"]


def run(command, threads, seconds=resource.RLIM_INFINITY):
    """Run it alone, to its end or for so many seconds of the processor.

    Its exit status, seconds of the processor and of the clock, peak memory in MB, and what it said.
    """
    begin = time.perf_counter()
    child = subprocess.Popen(
        command,
        env={**os.environ, **dict.fromkeys(THREADS, str(threads))},
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=partial(resource.setrlimit, resource.RLIMIT_CPU, (seconds, seconds)),
    )
    message = child.stderr.read()
    _, status, used = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    clock = time.perf_counter() - begin
    return child.returncode, used.ru_utime + used.ru_stime, clock, used.ru_maxrss / 1024, message


def embedding(inside, metric, *options):
    """The command that embeds a metric in a folder, in which it leaves the surface."""
    write_metric(inside / "metric.npz", metric)
    isoembed = shutil.which("isoembed", path=Path(sys.executable).parent) or "isoembed"
    written = ["-o", str(inside / "surface.npz"), *map(str, options)]
    return [isoembed, "embed", str(inside / "metric.npz"), *written, "--quiet"]


def least_without_report(path, threads=1, runs=3):
    """The least seconds of the processor of some runs that write the surface and nothing else."""
    with tempfile.TemporaryDirectory() as scratch:
        command = embedding(Path(scratch), PolyhedralMetric.from_mesh(*read_mesh(path)))
        return min(run(command, threads)[1] for _ in range(runs))


def measure(path, most, threads=1, seconds=resource.RLIM_INFINITY):
    """Embed the lengths of a mesh.

    Parameters
    ----------
    path : Path
        Of the mesh.
    most : int
        Edges up to which one factorization of J J^T is timed.
    threads : int
    seconds : int
        Of the processor, after which the run is ended.
    """
    vertices, faces = read_mesh(path)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    row = {"n": len(vertices), "threads": threads}
    with tempfile.TemporaryDirectory() as scratch:
        inside = Path(scratch)
        command = embedding(inside, metric, "--report", inside / "report.json", "--keep")
        status, cpu, clock, peak, message = run(command, threads, seconds)
        row |= {"status": status, "cpu": cpu, "clock": clock, "peak": peak}
        if not (inside / "report.json").exists():
            return row | {"failed": message.strip() or f"ended after {cpu:.0f} CPU s"}
        report = json.loads((inside / "report.json").read_text())
        with np.load(inside / "surface.npz") as found:
            error = aligned(found["vertices"], vertices)
    return row | {
        "one": one_in_own_process(path, threads) if metric.triangulation.n_edges <= most else None,
        "factorizations": sum(stage["factorizations"] for stage in report["stages"]),
        "stages": report["stages"],
        "residual": report["residual"]["max"],
        "aligned": error,
        "inverted": report["convexity"]["inverted_vertices"],
    }


def one_in_own_process(path, threads, of="edges"):
    """Seconds of the processor of one factorization, `of_edges` or `of_vertices`, in a process of its own."""
    mesh = f"*read_mesh({str(path.resolve())!r})"
    call = f"from command_runs import *; print(of_{of}({mesh}))"
    environment = {**os.environ, **dict.fromkeys(THREADS, str(threads))}
    here = Path(__file__).parent
    return float(subprocess.check_output([sys.executable, "-c", call], env=environment, cwd=here, text=True))


def of_edges(vertices, faces):
    """Least seconds of the processor of two numeric factorizations of J J^T."""
    from isoembed.surface.rigidity import LengthSystem

    metric = PolyhedralMetric.from_mesh(vertices, faces)
    system = LengthSystem(metric.triangulation)
    x, lengths = vertices / metric.unit, metric.lengths / metric.unit
    # Analyzed once; of many vertices J J^T may be singular to rounding.
    return least_seconds(lambda: system.linearized(x, lengths, HELD))


def of_vertices(vertices, faces):
    """Least seconds of the processor of two numeric factorizations of ``-d kappa / d r`` at the surface."""
    from isoembed import GluedMetric
    from isoembed.alexandrov.newton import Analyses, pinned
    from isoembed.alexandrov.polytope import Polytope
    from isoembed.linalg import Work

    metric = PolyhedralMetric.from_mesh(vertices, faces)
    x = (vertices - vertices.mean(axis=0)) / metric.unit
    radii = np.linalg.norm(x, axis=1)
    tables = GluedMetric.of(metric.normalized).half_edges(directed=False)
    p = Polytope.on(tables, radii)
    solution = pinned(p, Analyses.of(tables, Work()), x / radii[:, None])
    return least_seconds(lambda: solution.refactorized(p))


def least_seconds(work):
    """Of the processor, of two times."""
    seconds = []
    for _ in range(2):
        start = time.process_time()
        work()
        seconds.append(time.process_time() - start)
    return min(seconds)


HEAD = (
    f"{'surface':<24} {'N':>9} {'thr.':>4} {'cpu s':>7} {'clock s':>7} {'one':>6} "
    f"{'cpu/one':>9} {'fact.':>5} {'MB':>6} {'edge error':>10} {'aligned':>8} {'inv.':>4}  stages, s"
)


def show(name, row, remark=""):
    """Print a row."""
    start = f"{name:<24} {row['n']:>9,} {row['threads']:>4} "
    if "failed" in row:
        print(start + row["failed"] + remark, flush=True)
        return
    one = "" if row["one"] is None else f"{row['one']:.2f}"
    ratio = f"{row['cpu'] / row['one']:.1f}" if row["one"] else ""  # clocks show 0 for the smallest
    stages = ", ".join(f"{s['name']} {s['seconds']:.2f} ({s['factorizations']})" for s in row["stages"])
    print(
        start + f"{row['cpu']:>7.1f} {row['clock']:>7.1f} {one:>6} {ratio:>9} {row['factorizations']:>5} "
        f"{row['peak']:>6.0f} {row['residual']:>10.0e} {row['aligned']:>8.0e} {row['inverted']:>4}  {stages}"
        + ("" if row["status"] == 0 else f"  EXIT {row['status']}")
        + remark,
        flush=True,
    )


def exponent(rows):
    """Slope of the processor's seconds over N, logarithmic, from 40,000 to 640,000 or what there is of it."""
    rows = [row for row in rows if "failed" not in row and 40_000 <= row["n"] <= 640_000]
    if len(rows) < 2:
        return None
    return float(np.polyfit(np.log([row["n"] for row in rows]), np.log([row["cpu"] for row in rows]), 1)[0])
