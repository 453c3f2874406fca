"""The default method from 10,000 vertices to a million, through the command: files in, files out.

    python benchmarks/million.py [--sizes N ...] [--backends NAME ...] [--threads T ...] [--only PART ...]
                                 [--meshes DIR] [--json FILE]

Parts: "sizes", the paper's ellipsoid and drum in nearly equilateral, unstructured triangles; "poor", the
ellipsoid at 40,000 vertices in triangles whose least angle is a hundredth of a degree (vertices strewn at
random) and in triangles squeezed 10 : 1; "bent", surfaces where K < 0 at the sizes of --bent.

Every row is one run of ``isoembed embed`` in a process of its own, from a metric in a file to a surface and a
report in files: seconds of the processor and of the clock, start-up, input and output among them; the peak of
memory; what the stages took and their factorizations; the largest edge error, the distance to the discarded
coordinates over the diameter, and the inverted vertices.  "one" is the time of the processor for one numeric
factorization of J J^T, the edges x edges matrix of Newton's method on the lengths, at the surface and by the
same backend (not above --most edges); "total / one" leaves start-up, input and output out.  The exponent is
that of the seconds of all stages, from 40,000 to 640,000 vertices.  With --meshes, meshes made once are kept
in a folder.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from isoembed import Aim, PolyhedralMetric
from isoembed.gallery import CassiniPeanut, Drum, Ellipsoid, Ergosphere, HarmonicSurface, triangulate
from isoembed.io import write_metric
from isoembed.linalg import available_backends
from stages import aligned

SIZES = (10_000, 40_000, 160_000, 640_000, 1_000_000)
POOR = 40_000
SURFACES = {
    "ellipsoid": lambda n: triangulate(Ellipsoid((3, 2, 1)), n),
    "drum": lambda n: triangulate(Drum(), n),
    "random": lambda n: strewn(n),
    "squeezed": lambda n: squeezed(n),
    "ergosphere 0.3": lambda n: triangulate(Ergosphere(epsilon=0.3), n),
    "ergosphere 0.1": lambda n: triangulate(Ergosphere(epsilon=0.1), n),
    "peanut": lambda n: triangulate(CassiniPeanut(), n),
    "y43": lambda n: triangulate(HarmonicSurface(4, 3, 0.15), n),
}
PARTS = ("sizes", "poor", "bent")
BENT = ("ergosphere 0.3", "ergosphere 0.1", "peanut", "y43")


def strewn(n):
    """Points of the ellipsoid that know nothing of one another, in the triangles of their sphere's hull."""
    from scipy.spatial import ConvexHull

    u = np.random.default_rng(0).normal(size=(n, 3))
    u /= np.linalg.norm(u, axis=1)[:, None]
    faces = ConvexHull(u).simplices.astype(np.int64)
    inward = np.linalg.det(u[faces]) < 0
    faces[inward] = faces[inward][:, ::-1]
    return u * [3.0, 2.0, 1.0], faces


def squeezed(n):
    """Good triangles of a long ellipsoid, pressed together along it."""
    vertices, faces = triangulate(Ellipsoid((3, 2, 10)), n)
    return vertices * [1.0, 1.0, 0.1], faces


def mesh(name, n, folder):
    """The mesh, its labels shuffled, made or read."""
    path = folder / f"{name.replace(' ', '-')}_{n}.npz"
    if not path.exists():
        vertices, faces = SURFACES[name](n)
        rng = np.random.default_rng(1)
        label = rng.permutation(n)
        shuffled = np.empty_like(vertices)
        shuffled[label] = vertices
        np.savez(path, vertices=shuffled, faces=label[faces][rng.permutation(len(faces))])
    with np.load(path) as kept:
        return kept["vertices"], kept["faces"]


def run(command, threads):
    """Run it alone; its exit status, seconds of the processor and of the clock, and peak memory in MB."""
    names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
    environment = {**os.environ, **dict.fromkeys(names, str(threads))}
    begin = time.perf_counter()
    child = subprocess.Popen(command, env=environment, stderr=subprocess.PIPE, text=True)
    message = child.stderr.read()
    _, status, used = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    clock = time.perf_counter() - begin
    return child.returncode, used.ru_utime + used.ru_stime, clock, used.ru_maxrss / 1024, message


def measure(name, n, backend, threads, folder, most):
    """One row."""
    vertices, faces = mesh(name, n, folder)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    with tempfile.TemporaryDirectory() as scratch:
        inside = Path(scratch)
        write_metric(inside / "metric.npz", metric)
        isoembed = shutil.which("isoembed", path=Path(sys.executable).parent) or "isoembed"
        files = ["-o", str(inside / "surface.npz"), "--report", str(inside / "report.json"), "--keep"]
        command = [isoembed, "embed", str(inside / "metric.npz"), *files, "--quiet"]
        status, cpu, clock, peak, message = run([*command, "--parameter", f"backend={backend}"], threads)
        if not (inside / "report.json").exists():
            return {"name": name, "n": n, "backend": backend, "threads": threads, "failed": message.strip()}
        report = json.loads((inside / "report.json").read_text())
        with np.load(inside / "surface.npz") as found:
            error = aligned(found["vertices"], vertices)
    one = None
    if metric.triangulation.n_edges <= most:
        done = subprocess.run(
            [sys.executable, __file__, "--one", name, str(n), backend, "--meshes", str(folder)],
            env={**os.environ, "OMP_NUM_THREADS": str(threads), "MKL_NUM_THREADS": str(threads)},
            stdout=subprocess.PIPE,
            text=True,
            check=True,
        )
        one = float(done.stdout)
    return {
        "name": name,
        "n": n,
        "backend": backend,
        "threads": threads,
        "status": status,
        "cpu": cpu,
        "clock": clock,
        "peak": peak,
        "one": one,
        "solving": sum(stage["seconds"] for stage in report["stages"]),
        "factorizations": sum(stage["factorizations"] for stage in report["stages"]),
        "stages": report["stages"],
        "residual": report["residual"]["max"],
        "aligned": error,
        "inverted": report["convexity"]["inverted_vertices"],
    }


def one_factorization(vertices, faces, backend):
    """Least seconds of the processor of two numeric factorizations of J J^T."""
    from isoembed.surface.rigidity import LengthSystem

    metric = PolyhedralMetric.from_mesh(vertices, faces)
    system = LengthSystem(metric.triangulation, backend=backend)
    J = system._matrix(vertices / metric.unit, metric.lengths / metric.unit)
    seconds = []
    for _ in range(2):
        start = time.process_time()
        system._factor(J)
        seconds.append(time.process_time() - start)
    return min(seconds)


HEAD = (
    f"{'surface':<15} {'N':>9} {'backend':>8} {'thr.':>4} {'cpu s':>7} {'clock s':>7} {'one':>6} "
    f"{'total/one':>9} {'fact.':>5} {'MB':>6} {'edge error':>10} {'aligned':>8} {'inv.':>4}  stages, s"
)


def show(row):
    """Print a row."""
    start = f"{row['name']:<15} {row['n']:>9,} {row['backend']:>8} {row['threads']:>4} "
    if "failed" in row:
        print(start + row["failed"], flush=True)
        return
    one = "" if row["one"] is None else f"{row['one']:.2f}"
    ratio = "" if row["one"] is None else f"{row['solving'] / row['one']:.1f}"
    stages = ", ".join(f"{s['name']} {s['seconds']:.2f} ({s['factorizations']})" for s in row["stages"])
    print(
        start + f"{row['cpu']:>7.1f} {row['clock']:>7.1f} {one:>6} {ratio:>9} {row['factorizations']:>5} "
        f"{row['peak']:>6.0f} {row['residual']:>10.0e} {row['aligned']:>8.0e} {row['inverted']:>4}  {stages}"
        + ("" if row["status"] == 0 else f"  EXIT {row['status']}"),
        flush=True,
    )


def exponent(rows):
    """Slope of the stages' seconds over N, logarithmic, from 40,000 to 640,000 or what there is of it."""
    rows = [row for row in rows if "solving" in row and 40_000 <= row["n"] <= 640_000]
    if len(rows) < 2:
        return None
    return float(
        np.polyfit(np.log([row["n"] for row in rows]), np.log([row["solving"] for row in rows]), 1)[0]
    )


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--sizes", type=int, nargs="+", default=(10_000, 40_000))
    parser.add_argument("--bent", type=int, nargs="+", default=(10_000,))
    parser.add_argument("--backends", nargs="+", default=available_backends())
    parser.add_argument("--threads", type=int, nargs="+", default=(1,))
    parser.add_argument("--only", nargs="+", choices=PARTS, default=PARTS)
    parser.add_argument("--most", type=int, default=2_000_000, help="edges, for the column one")
    parser.add_argument("--meshes", type=Path, help="where to keep meshes")
    parser.add_argument("--json", type=Path, help="write the rows to this file")
    parser.add_argument("--one", nargs=3, metavar=("NAME", "N", "BACKEND"), help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        folder = arguments.meshes or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        if arguments.one:
            name, n, backend = arguments.one
            print(one_factorization(*mesh(name, int(n), folder), Aim(backend=backend).backend))
            return
        wanted = [("sizes", name, arguments.sizes) for name in ("ellipsoid", "drum")]
        wanted += [("poor", name, (POOR,)) for name in ("random", "squeezed")]
        wanted += [("bent", name, arguments.bent) for name in BENT]
        rows = []
        print(HEAD, flush=True)
        for part, name, sizes in wanted:
            if part not in arguments.only:
                continue
            for backend in arguments.backends:
                for threads in arguments.threads:
                    batch = []
                    for n in sizes:
                        batch.append(measure(name, n, backend, threads, folder, arguments.most))
                        show(batch[-1])
                    if (slope := exponent(batch)) is not None:
                        print(f"{name}, {backend}, {threads} thread(s): exponent {slope:.2f}", flush=True)
                    rows += batch
    if arguments.json:
        arguments.json.write_text(json.dumps(rows, indent=1))


if __name__ == "__main__":
    main()
