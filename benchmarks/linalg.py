"""Cost of the sparse solver on an ellipsoid: ``python benchmarks/linalg.py [N ...]``.

Matrices: J J^T on the edges; a Laplacian on the vertices, less a little, which makes it indefinite; and J^T J
with a penalty, on the coordinates. Each is ordered by our dissection, analyzed, factored and solved, by dense
fronts; by SuperLU in the same order, and in the order it takes by itself; and by CHOLMOD and PARDISO where
scikit-sparse and pypardiso are installed, which order and analyze every time.

Seconds of the processor are the best of three, the ratio is to the fronts' factorization, a solve is without
refinement, and memory is what the factors are foreseen to take. At last come exponents of all of them.
"""

import sys
import time
from importlib.util import find_spec

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu
from scipy.spatial import ConvexHull

from isoembed.linalg import analyze, dissect


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


def laplacian(graph):
    """The graph's Laplacian, less a multiple of the identity that leaves few negative eigenvalues."""
    shift = 30 / graph.shape[0]
    matrix = sp.csc_array(sp.diags_array(graph.sum(axis=1) - shift) - graph)
    matrix.sort_indices()
    return matrix


def penalized(graph, jacobian):
    """J^T J + P, P a Laplacian on each coordinate, with all entries of neighbors stored."""
    pattern = sp.csc_array(sp.kron(graph + sp.eye_array(graph.shape[0]), np.ones((3, 3))))
    penalty = sp.kron(laplacian(graph) + sp.eye_array(graph.shape[0]), np.eye(3))
    matrix = sp.csc_array(jacobian.T @ jacobian + penalty + 1e-300 * pattern)
    matrix.sort_indices()
    return matrix


def best(function, *arguments):
    """Least seconds of three runs, and the result."""
    seconds = []
    for _ in range(3):
        start = time.process_time()
        result = function(*arguments)
        seconds.append(time.process_time() - start)
    return min(seconds), result


def ours(matrix, order, definite):
    """Seconds to analyze, factor and solve by fronts, and bytes that the factors take."""
    b = np.random.default_rng(0).normal(size=order.size)
    analyzing, solver = best(lambda: analyze(matrix, order, definite=definite))
    factoring, factor = best(solver.factor, matrix.data)
    solving, _ = best(factor.solve, b, 0)
    return analyzing, factoring, solving, solver.needs


def superlu(matrix, spec):
    """The same by SuperLU, which analyzes every time, with an order of SciPy's."""
    b = np.random.default_rng(0).normal(size=matrix.shape[0])
    options = {"diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}
    factoring, factor = best(lambda: splu(matrix, permc_spec=spec, **options))
    solving, _ = best(factor.solve, b)
    return 0.0, factoring, solving, 12 * factor.nnz


def cholmod(matrix):
    """The same by CHOLMOD's L D L^T, in an order of its own; the memory is not known."""
    from sksparse.cholmod import cholesky

    b = np.random.default_rng(0).normal(size=matrix.shape[0])
    factoring, factor = best(lambda: cholesky(matrix, mode="auto"))
    solving, _ = best(factor, b)
    return 0.0, factoring, solving, 0


def pardiso(matrix):
    """The same by PARDISO, in an order of its own; the memory is not known."""
    import pypardiso

    rows, b = sp.csr_matrix(matrix), np.random.default_rng(0).normal(size=matrix.shape[0])
    solver = pypardiso.PyPardisoSolver(mtype=11)
    factoring, _ = best(lambda: solver.factorize(rows))
    solving, _ = best(solver.solve, rows, b)
    return 0.0, factoring, solving, 0


def report(n):
    """Print the table of one size; return seconds by matrix and by who factors."""
    edges, graph, jacobian = rigidity(n)
    dissecting, dissection = best(dissect, graph)
    vertex, _ = best(lambda: dissect(graph).vertex_order())
    edge, order = best(lambda: dissect(graph).edge_order(edges))
    print(f"\nN = {n}: coordinates of the dissection {dissecting:.3f} s, ", end="")
    print(f"with the order of the vertices {vertex:.3f}, of the edges {edge:.3f}")
    heads = ("analyze", "factor", "solve", "ratio", "MB")
    print(f"{'matrix':10} {'by':8} {'rows':>9}", *(f"{head:>8}" for head in heads))
    matrices = {
        "J J^T": (gram(edges, jacobian), order, True),
        "Laplacian": (laplacian(graph), dissection.vertex_order(), False),
        "J^T J + P": (penalized(graph, jacobian), dissection.block_order(3), True),
    }
    found = {}
    for name, (matrix, order, definite) in matrices.items():
        ordered = sp.csc_matrix(matrix[order][:, order])
        rows = {
            "fronts": ours(matrix, order, definite),
            "SuperLU": superlu(ordered, "NATURAL"),
            "MMD": superlu(sp.csc_matrix(matrix), "MMD_AT_PLUS_A"),
        }
        if definite and find_spec("sksparse"):
            rows["CHOLMOD"] = cholmod(sp.csc_matrix(matrix))
        if find_spec("pypardiso"):
            rows["PARDISO"] = pardiso(matrix)
        for who, (*seconds, size) in rows.items():
            numbers = *seconds, seconds[1] / rows["fronts"][1]
            shown = *(f"{number:8.4f}" for number in numbers), f"{size / 1e6:8.1f}"
            print(f"{name:10} {who:8} {order.size:9}", *shown, flush=True)
            found[name, who] = *seconds, size
    return found


def main(sizes):
    """Measure all sizes, and the exponents between the first and the last."""
    tables = [report(n) for n in sizes]
    if len(sizes) > 1:
        print(f"\nexponents from {sizes[0]} to {sizes[-1]}: analyze, factor, solve, memory")
    for key, first in tables[0].items() if len(sizes) > 1 else ():
        pairs = zip(first, tables[-1][key], strict=True)
        powers = [np.log(b / a) / np.log(sizes[-1] / sizes[0]) if a > 0 else np.nan for a, b in pairs]
        print(f"{key[0]:12} {key[1]:9}", *(f"{power:8.2f}" for power in powers))


if __name__ == "__main__":
    main([int(n) for n in sys.argv[1:]] or [3_000, 12_000, 40_000])
