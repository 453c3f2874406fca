"""The exact polyhedron against the number of vertices, and against random bodies.

    python benchmarks/alexandrov.py [--sizes N ...] [--sweep SEEDS] [--json FILE]

Sizes: the convex hull of N Fibonacci points on the (3, 2, 1) ellipsoid, from a scrambled triangulation of its
metric, in a process of its own for every row.  Printed are the seconds of the whole embedding and of its
stages, factorizations, the total over the time of one factorization of the same matrix, the exponent of the
total in N, the largest edge error, the distance to the discarded coordinates over the diameter, whether every
vertex is there, and the peak of memory.

Sweep: random convex bodies of 8 to 200 vertices, scrambled, aspects to 300: how many are solved to 1e-9
against the hull they came from, how many are reported as failures, and how many are wrong.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
from scipy.spatial import ConvexHull

from stages import aligned

SIZES = (1000, 3226, 12800, 51200, 160_000, 640_000, 1_000_000)
BODIES = {
    "ball": (1.0, 1.0, 1.0),
    "ellipsoid": (3.0, 1.0, 0.3),
    "needle 10": (10.0, 1.0, 1.0),
    "needle 30": (30.0, 1.0, 1.0),
    "slab 30": (1.0, 1.0, 1 / 30),
    "needle 300": (300.0, 1.0, 1.0),
    "slab 300": (1.0, 1.0, 1 / 300),
}
"""Points on these ellipsoids; with points in a cube and in a normal distribution, the bodies of the sweep."""

ONE_THREAD = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
SOLVED = 1e-9  # of the diameter


def outward_hull(points):
    """Faces of the convex hull, outward, and its vertices, without gaps."""
    hull = ConvexHull(points)
    faces = hull.simplices.astype(np.int64)
    a, b, c = (hull.points[faces[:, k]] for k in range(3))
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), hull.equations[:, :3]) < 0
    faces[inward] = faces[inward][:, ::-1]
    used, renumbered = np.unique(faces, return_inverse=True)
    return hull.points[used], renumbered.reshape(-1, 3)


def fibonacci(n, axes=(3.0, 2.0, 1.0)):
    """Points spread evenly over a sphere, stretched."""
    i = np.arange(n) + 0.5
    z, angle = 1 - 2 * i / n, i * np.pi * (1 + 5**0.5)
    radius = np.sqrt(1 - z * z)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), z]) * axes


def scrambled(vertices, faces, seed, thinnest):
    """The metric of a body, on triangles that were flipped at random, none of them thinner than asked."""
    from isoembed import GluedMetric, PolyhedralMetric
    from isoembed.intrinsic.loops import flip

    mesh = GluedMetric.of(PolyhedralMetric.from_mesh(vertices, faces)).half_edges()
    for h in np.random.default_rng(seed).integers(0, mesh.corners.size, 10 * len(vertices)):
        flip(h, mesh.views, thinnest)
    return GluedMetric(mesh.faces, mesh.twins, mesh.face_lengths)


def one_factorization(polyhedron):
    """Least seconds of three: order, analyze and factor ``d kappa / d r`` at the solution."""
    from isoembed import GluedMetric
    from isoembed.alexandrov.newton import Analyses, pinned
    from isoembed.alexandrov.polytope import Polytope
    from isoembed.linalg import Work

    metric, vertices = polyhedron.metric, polyhedron.vertices
    tables = GluedMetric.of(metric).half_edges()
    p = Polytope.over(tables, np.linalg.norm(vertices - vertices.mean(axis=0), axis=1))
    seconds = []
    for _ in range(3):
        start = time.perf_counter()
        pinned(p, Analyses.of(tables, Work()))
        seconds.append(time.perf_counter() - start)
    return min(seconds)


def measure(n):
    """Measure one row of the table of sizes."""
    import isoembed

    small, faces = outward_hull(fibonacci(200))  # compiles
    isoembed.embed(scrambled(small, faces, 0, 0.05), method=isoembed.Alexandrov())
    vertices, faces = outward_hull(fibonacci(n))
    metric = scrambled(vertices, faces, 0, 0.05)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    seconds = []
    for _ in range(3 if n <= 20_000 else 1):
        start = time.perf_counter()
        polyhedron = isoembed.embed(metric, method=isoembed.Alexandrov())
        seconds.append(time.perf_counter() - start)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return {
        "vertices": n,
        "seconds": min(seconds),
        "stages": {stage.name: stage.seconds for stage in polyhedron.stages},
        "factorizations": sum(stage.factorizations for stage in polyhedron.stages),
        "one": one_factorization(polyhedron),
        "residual": polyhedron.residual,
        "aligned": aligned(polyhedron.vertices, vertices),
        "peak_mb": peak / 1024,
        "before_mb": before / 1024,
    }


def sizes_table(sizes):
    """Measure and print the table of sizes."""
    rows = []
    print(f"{'N':>8} {'seconds':>8} {'factor.':>7} {'total/one':>9} {'exponent':>8} "
          f"{'residual':>8} {'aligned':>8} {'peak MB':>8}  stages")  # fmt: skip
    last = None
    for n in sizes:
        command = [sys.executable, __file__, "--row", str(n)]
        done = subprocess.run(command, check=True, capture_output=True, text=True, env=ONE_THREAD)
        row = json.loads(done.stdout)
        rows.append(row)
        exponent = "" if last is None else f"{growth(last, row):.2f}"
        stages = ", ".join(f"{name} {seconds:.2f}" for name, seconds in row["stages"].items())
        print(f"{n:8d} {row['seconds']:8.2f} {row['factorizations']:7d} "
              f"{row['seconds'] / row['one']:9.1f} {exponent:>8} {row['residual']:8.0e} "
              f"{row['aligned']:8.0e} {row['peak_mb']:8.0f}  {stages}", flush=True)  # fmt: skip
        last = row
    return rows


def growth(a, b):
    """The exponent between two rows."""
    return np.log(b["seconds"] / a["seconds"]) / np.log(b["vertices"] / a["vertices"])


def body(name, seed):
    """One random convex body."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(8, 200))
    if name == "cube":
        return outward_hull(rng.uniform(-1, 1, (n, 3)))
    points = rng.normal(size=(n, 3))
    if name == "normal":
        return outward_hull(points)
    return outward_hull(points / np.linalg.norm(points, axis=1)[:, None] * BODIES[name])


def sweep(seeds):
    """Solve random bodies and print what came of them."""
    import isoembed

    rows = []
    print("body           solved  failed  wrong  factorizations    worst  seconds")
    for name in ("normal", "cube", *BODIES):
        solved, failed, wrong, counts, worst, start = 0, [], [], [], 0.0, time.perf_counter()
        for seed in range(seeds):
            vertices, faces = body(name, seed)
            try:
                polyhedron = isoembed.embed(scrambled(vertices, faces, seed, 1e-3), method="alexandrov")
            except (isoembed.NotEmbedded, isoembed.InvalidMetric):
                failed.append(seed)
                continue
            off = aligned(polyhedron.vertices, vertices)
            counts.append(sum(stage.factorizations for stage in polyhedron.stages))
            worst = max(worst, off)
            if off <= SOLVED:
                solved += 1
            else:
                wrong.append(seed)
        seconds = time.perf_counter() - start
        rows.append({"body": name, "solved": solved, "failed": failed, "wrong": wrong, "worst": worst})
        most = f"{np.median(counts):.0f} (max {max(counts)})"
        counted = f"{name:12} {solved:8d} {len(failed):7d} {len(wrong):6d}"
        print(f"{counted} {most:>15} {worst:8.0e} {seconds:8.1f}", flush=True)
    return rows


def main():
    """Run what is asked."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--sizes", type=int, nargs="*", default=list(SIZES[:4]))
    parser.add_argument("--sweep", type=int, default=60, metavar="SEEDS")
    parser.add_argument("--json", type=Path)
    parser.add_argument("--row", type=int, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.row:
        print(json.dumps(measure(options.row)))
        return
    rows = sizes_table(options.sizes)
    rows += sweep(options.sweep) if options.sweep else []
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1))


if __name__ == "__main__":
    main()
