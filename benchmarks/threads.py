"""Seconds on all cores over those on one: ``python benchmarks/threads.py [--vertices N] [--threads K]``.

Factors of J J^T of an ellipsoid, a solve with them without refinement, and `embed` of the ellipsoid and of an
ergosphere, K < 0, with as many vertices. Every row has seconds of the clock and of the processor for one
thread and for all, the medians of three in turn, their ratios, and whether the results have the same bits.
"""

import argparse
import time

import numpy as np
import scipy.sparse as sp
from threadpoolctl import threadpool_limits

import isoembed
from isoembed import PolyhedralMetric
from isoembed.gallery import Ellipsoid, Ergosphere, triangulate
from isoembed.linalg import analyze, dissect
from isoembed.threads import thread_count
from linalg import gram, rigidity

REPEATS = 3


def measured(compute, threads):
    """Result, seconds of the clock and of the processor."""
    with threadpool_limits(threads):
        wall, cpu = time.perf_counter(), time.process_time()
        result = compute()
        return result, time.perf_counter() - wall, time.process_time() - cpu


def show(name, compute, threads, bits=lambda result: result):
    """Print a row; ``bits`` has an array for each result."""
    rows = [[measured(compute, count) for count in (1, threads)] for _ in range(REPEATS)]
    (one, one_cpu), (many, many_cpu) = np.median([[each[1:] for each in row] for row in rows], axis=0)
    same = all(np.array_equal(bits(a[0]), bits(b[0])) for a, b in rows)
    print(f"{name:28} {one:8.3f} {one_cpu:8.3f} {many:8.3f} {many_cpu:8.3f}   {many / one:5.2f} "
          f"{many_cpu / one_cpu:5.2f}   {'same bits' if same else 'OTHER BITS'}", flush=True)  # fmt: skip


def metric(surface, n):
    """The metric of a gallery surface."""
    return PolyhedralMetric.from_mesh(*triangulate(surface, n, irregular=0))


def main():
    """Print all rows."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--vertices", type=int, default=40_000, metavar="N")
    parser.add_argument("--threads", type=int, default=thread_count(), metavar="K")
    options = parser.parse_args()
    n, threads = options.vertices, options.threads
    print(f"{n} vertices, one thread and {threads}: seconds, of the processor, ratios")
    edges, graph, jacobian = rigidity(n)
    matrix = gram(edges, jacobian)
    solver = analyze(matrix, dissect(sp.csc_array(graph)).edge_order(edges))
    b = np.random.default_rng(0).normal(size=len(edges))

    def solved(factor):
        return factor.solve(b, sweeps=0)

    for single in (False, True):
        factor = solver.factor(matrix.data, single=single)
        precision = "single" if single else "double"
        show(f"factor, {precision}", lambda s=single: solver.factor(matrix.data, single=s), threads, solved)
        show(f"solve, {precision}", lambda f=factor: f.solve(b, sweeps=0), threads)
    for name, surface in (("ellipsoid", Ellipsoid((3, 2, 1))), ("ergosphere .3", Ergosphere(epsilon=0.3))):
        lengths = metric(surface, n)
        show(f"embed, {name}", lambda m=lengths: isoembed.embed(m, length_errors=0).vertices, threads)


if __name__ == "__main__":
    main()
