"""Cost of the sparse solver on J J^T of an ellipsoid: ``python benchmarks/linalg.py [N ...]``.

Seconds of the processor are the best of three. Ratios are to one SuperLU factorization ordered by our
dissection; fill is the entries of L + U per entry of the matrix. The first factorization of a pattern may
include an analysis. A solve is one without refinement. Memory is what the factors are foreseen to take.
"""

import sys
import time

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu
from scipy.spatial import ConvexHull

from isoembed.linalg import analyze, available_backends, dissect


def rigidity(n):
    """Edges and graph of a (3, 2, 1) ellipsoid with n vertices, and J, the derivative of its lengths."""
    k = np.arange(n) + 0.5
    z, angle = 1 - 2 * k / n, np.pi * (1 + 5**0.5) * k
    sphere = np.stack((np.sqrt(1 - z * z) * np.cos(angle), np.sqrt(1 - z * z) * np.sin(angle), z), axis=1)
    faces = ConvexHull(sphere).simplices.astype(np.int64)
    halves = np.concatenate((faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]))
    edges = np.unique(np.sort(halves, axis=1), axis=0)
    graph = sp.coo_array((np.ones(len(edges)), edges.T), shape=(n, n))
    d = (sphere[edges[:, 0]] - sphere[edges[:, 1]]) * (3, 2, 1)
    d /= np.linalg.norm(d, axis=1)[:, None]
    columns = (3 * edges[:, :, None] + np.arange(3)).reshape(-1)
    jacobian = sp.csr_array((np.stack((d, -d), axis=1).ravel(), columns, 6 * np.arange(len(edges) + 1)))
    return edges, (graph + graph.T).tocsr(), jacobian


def gram(edges, jacobian):
    """J J^T with every entry of the line graph stored, those that happen to be zero too."""
    incidence = sp.csr_array((np.ones(edges.size), edges.ravel(), 2 * np.arange(len(edges) + 1)))
    matrix = sp.csc_array(incidence @ incidence.T)
    matrix.sort_indices()
    columns = np.repeat(np.arange(len(edges)), np.diff(matrix.indptr))
    matrix.data = sp.csr_array(jacobian @ jacobian.T)[matrix.indices, columns]
    return matrix


def best(function, *arguments):
    """Least seconds of three runs, and the result."""
    seconds = []
    for _ in range(3):
        start = time.process_time()
        result = function(*arguments)
        seconds.append(time.process_time() - start)
    return min(seconds), result


def eliminate(matrix, ordering):
    """SuperLU down the diagonal, in an order of its own or in that of the matrix ("NATURAL")."""
    return splu(
        matrix, permc_spec=ordering, diag_pivot_thresh=0.0, options={"SymmetricMode": ordering != "COLAMD"}
    )


def report(n):
    edges, graph, jacobian = rigidity(n)
    matrix = gram(edges, jacobian)
    dissecting, order = best(lambda: dissect(graph).edge_order(edges))
    unit, lu = best(eliminate, sp.csc_array(matrix[order][:, order]), "NATURAL")
    print(
        f"\nN = {n}: J J^T has {len(edges)} rows and {matrix.nnz} entries; a factorization takes {unit:.3f} s"
    )
    print(f"{'order':14} order + factor     ratio      fill  / minimum degree")
    rows = [("dissection", dissecting + unit, lu.nnz)]
    for name in ("MMD_AT_PLUS_A", "COLAMD"):
        seconds, lu = best(eliminate, matrix, name)
        rows.append((name, seconds, lu.nnz))
    for name, seconds, entries in rows:
        print(f"{name:14} {seconds:12.3f} s {seconds / unit:9.2f} {entries / matrix.nnz:9.2f} ", end="")
        print(f"{entries / rows[1][2]:9.2f}")

    heads = ("dissect", "analyze", "first", "factor", "solve")
    print(f"{'backend':12}", *(f"{head:>8}" for head in heads), "s   the same / factorization", " " * 8, "MB")
    b = np.random.default_rng(0).normal(size=len(edges))
    for name in reversed(available_backends()):
        analyze(matrix, order, name).factor(matrix.data).solve(b)  # compiled and loaded
        analyzing, solver = best(analyze, matrix, order, name)
        megabytes = solver.needs / 1e6
        start = time.process_time()
        solver.factor(matrix.data)
        first = time.process_time() - start
        factoring, factor = best(solver.factor, matrix.data)
        solving, _ = best(factor.solve, b, 0)
        seconds = (dissecting, analyzing, first, factoring, solving)
        ratios = (f"{t / unit:6.3f}" for t in seconds)
        print(f"{name:12}", *(f"{t:8.4f}" for t in seconds), "  ", *ratios, f"{megabytes:8.0f}")


if __name__ == "__main__":
    for size in [int(n) for n in sys.argv[1:]] or [3_000, 12_000, 40_000]:
        report(size)
