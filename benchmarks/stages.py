"""Cost of each stage against the number of vertices.

    python benchmarks/stages.py [--sizes N ...] [--json FILE]

For the paper's ellipsoid and drum and both methods: seconds, factorizations and steps a stage, the time of a
stage over that of one factorization of J J^T, exponents fitted over N, accuracy (edge error, distance to the
discarded coordinates over the diameter, inverted vertices) and peak memory. "steps" is the least Tsteps with
which the paper's method finds the surface that the lengths are from, without its convexity routine.
"""

import argparse
import json
import resource
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

import isoembed

SIZES = (400, 800, 1600, 3226, 6400, 12800)
CASES = ("ellipsoid", "drum")
TOLERANCE = {"aim": 1e-10, "paper": 1e-6}


def aligned(found, true):
    """Largest distance after the best rigid motion, mirror images allowed, over the diameter."""
    from isoembed.surface.alignment import distance

    diameter = 2 * np.linalg.norm(true - true.mean(axis=0), axis=1).max()
    return min(distance(x, true) for x in (found, found * [1, 1, -1])) / diameter


def one_factorization(metric, vertices):
    """Least seconds of five Newton steps, each one factorization of J J^T with its solves."""
    from isoembed.surface.rigidity import LengthSystem, length_residuals

    unit = metric.mean_length
    system = LengthSystem(metric.triangulation)
    lengths, vertices = metric.lengths / unit, vertices / unit
    residuals = length_residuals(metric.triangulation, vertices, lengths)
    seconds = []
    for _ in range(5):
        start = time.perf_counter()
        system.step(vertices, lengths, residuals)
        seconds.append(time.perf_counter() - start)
    return min(seconds)


def measure(name, n, method):
    """Embed one surface from its lengths; what it took."""
    from isoembed import NotEmbedded, PolyhedralMetric, embed
    from isoembed.gallery import SURFACES, triangulate

    vertices, faces = triangulate(SURFACES[name](), n)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    start = time.perf_counter()
    try:
        surface = embed(metric, method=method, tolerance=TOLERANCE[method])
    except NotEmbedded as error:
        surface = error.embedding
    seconds = time.perf_counter() - start
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return {
        "case": name,
        "method": method,
        "vertices": n,
        "seconds": seconds,
        "one": one_factorization(metric, surface.vertices),
        "peak_mb": peak / 1024,
        "before_mb": before / 1024,
        "aligned": aligned(surface.vertices, vertices),
        **{key: isoembed.report(surface)[key] for key in ("status", "residual", "convexity", "stages")},
    }


def exponent(rows, cost):
    """Slope of log(cost) over log(N)."""
    points = [(row["vertices"], cost(row)) for row in rows]
    if len(points) < 2 or min(value for _, value in points) <= 0:
        return float("nan")
    n, value = np.log(points).T
    return np.polyfit(n, value, 1)[0]


def seconds_in(row, name):
    """Seconds in the stages of this name; not every run has all of them."""
    return sum(stage["seconds"] for stage in row["stages"] if stage["name"] == name)


def show(rows):
    """Print the table of one case and method, and its exponents."""
    first = rows[0]
    print(f"\n{first['case']}, method {first['method']}, tolerance {TOLERANCE[first['method']]:.0e}")
    names = [stage["name"] for stage in first["stages"]]
    print(
        f"{'N':>6} {'seconds':>8} {'one':>7} {'ratio':>6} {'fact.':>6} {'steps':>6} {'edge error':>11} "
        f"{'aligned':>8} {'inverted':>9} {'peak MB':>8}  "
        + "  ".join(f"{name} s / one (fact.)" for name in names)
    )
    for row in rows:
        one, stages, inverted = row["one"], row["stages"], row["convexity"]
        parts = [f"{s['seconds']:.3f} / {s['seconds'] / one:.1f} ({s['factorizations']})" for s in stages]
        factorizations = sum(s["factorizations"] for s in stages)
        counts = f"{inverted['inverted_vertices']} + {inverted['partially_inverted_vertices']}"
        print(
            f"{row['vertices']:>6} {row['seconds']:>8.2f} {one:>7.3f} {row['seconds'] / one:>6.1f} "
            f"{factorizations:>6} {row['steps'] or 'none':>6} {row['residual']['max']:>11.1e} "
            f"{row['aligned']:>8.0e} {counts:>9} {row['peak_mb']:>8.0f}  " + "  ".join(parts)
        )
    print(f"exponents: total {exponent(rows, lambda row: row['seconds']):.2f}", end="")
    for name in dict.fromkeys(names):
        print(f", {name} {exponent(rows, lambda row, name=name: seconds_in(row, name)):.2f}", end="")
    print()


def in_own_process(name, n, what):
    """Measure in a process of its own: its peak memory counts from that of the process that starts it."""
    command = [sys.executable, __file__, "--measure", name, str(n), what]
    return json.loads(subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout)


def fewest_steps(name, n):
    """Least Tsteps up to 16 that lead to the given surface without the convexity routine, or None."""
    from isoembed import Embedding, NotEmbedded, Paper, PolyhedralMetric, embed
    from isoembed.gallery import SURFACES, triangulate

    vertices, faces = triangulate(SURFACES[name](), n)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    exact = Embedding(metric, vertices, method="exact", tolerance=TOLERANCE["paper"])
    for steps in range(1, 17):
        try:
            found = embed(metric, method=Paper(Tsteps=steps, convexity="none"), tolerance=TOLERANCE["paper"])
        except NotEmbedded:
            continue
        if found.distance(exact) < 1e-3:  # mean edge lengths; other realizations are 70 times farther
            return steps
    return None


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sizes", type=int, nargs="+", default=SIZES, metavar="N")
    parser.add_argument("--json", type=Path, help="write the rows to this file")
    parser.add_argument("--measure", nargs=3, metavar=("NAME", "N", "METHOD"), help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.measure:
        name, n, method = arguments.measure
        if method == "steps":
            print(json.dumps(fewest_steps(name, int(n))))
        else:
            print(json.dumps(measure(name, int(n), method)))
        return
    everything = []
    for name in CASES:
        steps = {n: in_own_process(name, n, "steps") for n in arguments.sizes}
        for method in TOLERANCE:
            rows = [{**in_own_process(name, n, method), "steps": steps[n]} for n in arguments.sizes]
            show(rows)
            everything += rows
        print(f"fewest adiabatic steps (Tsteps) against N: {steps}")
    if arguments.json:
        arguments.json.write_text(json.dumps(everything, indent=1))


if __name__ == "__main__":
    main()
