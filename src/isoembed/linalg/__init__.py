"""Sparse direct solvers without external libraries.

`dissect` orders a surface mesh by nested dissection, `analyze` prepares a pattern once, and its `factor` and
`solve` do the numbers, with iterative refinement and the same errors, `SingularMatrix` and `OutOfMemory`.
Symmetric matrices are factored as L D L^T by dense fronts, those that are not symmetric by scipy's SuperLU.

Looked at in November 2026 and not taken:

- no wheels for Linux, macOS and Windows: scikit-sparse (CHOLMOD, compiled against headers of SuiteSparse),
  scikit-umfpack, petsc4py, PyMUMPS, python-mumps (Linux and NumPy 1 only), pyspral, cmeel-spral (no Python);
- the license: kvxopt, cholespy and sksparse_minimal (GPL; the last two bring CHOLMOD, for definite matrices),
  pypardiso and the like (PARDISO, proprietary; no faster than what is here);
- no elimination order can be given: rslab (J J^T of 480,000 unknowns: 8.5 s for its own order and 1.8 s a
  factorization, or .9 and 3.3 s; here 1.1 s), feral-solver (120,000: 2 and .6 s; here .2 s);
- column by column: qdldl; one maker's processors: macldlt (Apple), nvmath (NVIDIA).
"""

from isoembed.linalg.dissection import Dissection, dissect
from isoembed.linalg.factor import (
    Factor,
    Solver,
    SymmetricFactor,
    analyze,
    factor_general,
)
from isoembed.linalg.memory import OutOfMemory
from isoembed.linalg.singular import SingularMatrix
from isoembed.linalg.work import Work

__all__ = [
    "Dissection",
    "Factor",
    "OutOfMemory",
    "SingularMatrix",
    "Solver",
    "SymmetricFactor",
    "Work",
    "analyze",
    "dissect",
    "factor_general",
]
