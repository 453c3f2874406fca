"""Sparse direct solvers: one small face over SuperLU, CHOLMOD and PARDISO.

`dissect` orders a surface mesh by nested dissection, `analyze` prepares a pattern once, and its `factor` and
`solve` do the numbers, with iterative refinement and the same errors, `SingularMatrix` and `OutOfMemory`,
whatever the backend.
"""

from isoembed.linalg.backend import SingularMatrix, available_backends, chosen_backend
from isoembed.linalg.dissection import Dissection, dissect
from isoembed.linalg.factor import (
    Factor,
    Solver,
    SymmetricFactor,
    analyze,
    factor_general,
)
from isoembed.linalg.memory import OutOfMemory

__all__ = [
    "Dissection",
    "Factor",
    "OutOfMemory",
    "SingularMatrix",
    "Solver",
    "SymmetricFactor",
    "analyze",
    "available_backends",
    "chosen_backend",
    "dissect",
    "factor_general",
]
