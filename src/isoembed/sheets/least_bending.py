"""Isometric surfaces of least bending energy: the thin-sheet limit.

Minimizes `bending.BendingEnergy` among the surfaces with the given lengths.  If the curvature is not
positive, the minimum is approached along ``sum r^2 / (2 epsilon) + W(x)`` with epsilon to zero, as for sheets
of decreasing thickness; then Newton's method is applied to the equations with the lengths as constraints,
whose Lagrange multipliers are the tensions of the edges.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse.linalg import LinearOperator, cg

from isoembed.arrays import Floats
from isoembed.linalg import SingularMatrix, SymmetricFactor
from isoembed.mesh.triangulation import Triangulation
from isoembed.nonlinear.acceptance import LineSearch
from isoembed.progress.stages import StageRecorder
from isoembed.sheets.bending import BendingEnergy
from isoembed.sheets.elastic_sheet import ElasticSheet
from isoembed.sheets.length_constraints import EXACT, LengthConstraints
from isoembed.surface.rigidity import edge_rows
from isoembed.surface.vertex_system import HeldTriangle, VertexSystem

STIFFNESSES = tuple(10.0**-k for k in range(4, 10))  # successive epsilon over the area
DISTINCT = 1.0005, 1.05  # range of energies, over the least one, in which the second surface is kept
THINNER = tuple(10.0**-k for k in range(10, 13))  # further epsilons if forces are not balanced
SEARCH = LineSearch(decrease=0.1, shortest=2.0**-7)


@dataclass(frozen=True, eq=False)
class LeastBending:
    """Surface of least bending energy, or the last iterate.

    Attributes
    ----------
    vertices : ndarray, shape (V, 3)
    multipliers : ndarray, shape (E,)
        Multipliers of the lengths: tensions of the edges (positive: they pull), for bending modulus 2.
    imbalance : float
        Largest net force of bending and tensions on a vertex, over the mean diagonal of the form.
    """

    vertices: Floats
    multipliers: Floats
    imbalance: float


def thinned(
    energy: BendingEnergy,
    lengths: LengthConstraints,
    start: Floats,
    recorder: StageRecorder,
    stiffnesses: Sequence[float] = STIFFNESSES,
) -> LeastBending:
    """Minimize the energy of successively thinner elastic sheets, from a start with any lengths."""
    x, sheet = start, elastic_sheet(energy, lengths, start, recorder)
    recorder.show(vertices=x)
    for stiffness in stiffnesses:
        epsilon = stiffness * energy.area
        x = sheet.relaxed(x, epsilon, 40)
        recorder.show(vertices=x)
    return LeastBending(x, lengths.residuals(x) / epsilon, np.inf)


def elastic_sheet(
    energy: BendingEnergy, lengths: LengthConstraints, x: Floats, recorder: StageRecorder
) -> ElasticSheet:
    """Elastic sheet without rigid motions of its first triangle, which is that of x."""
    return ElasticSheet(lengths, energy.form, HeldTriangle.of(x, lengths.triangulation.faces[0]), recorder)


def most_promising(
    energy: BendingEnergy,
    lengths: LengthConstraints,
    starts: Sequence[Floats],
    stiffnesses: Sequence[float],
    recorder: StageRecorder,
) -> list[Floats]:
    """Select one or two starts from which thick elastic sheets have the least energy, best first.

    Parameters
    ----------
    energy : BendingEnergy
    lengths : LengthConstraints
    starts : sequence of ndarray, shape (V, 3)
        At least two initial surfaces.
    stiffnesses : sequence of float
        Epsilon over the area; the first two are used.
    recorder : StageRecorder
    """
    candidates = [(start, start) for start in starts]
    for stiffness in stiffnesses[:2]:
        epsilon = stiffness * energy.area
        tried = []
        for start, x in candidates:
            sheet = elastic_sheet(energy, lengths, x, recorder)
            x = sheet.relaxed(x, epsilon, 20)
            tried.append((sheet.value(x, epsilon), start, x))
        tried.sort(key=lambda each: each[0])
        candidates = [(start, x) for _, start, x in tried[:2]]
    (lowest, best, _), (value, second, _) = tried[:2]
    return [best, second] if DISTINCT[0] < value / lowest < DISTINCT[1] else [best]


def balanced(
    energy: BendingEnergy, lengths: LengthConstraints, start: LeastBending, recorder: StageRecorder
) -> LeastBending:
    """Newton's method for least bending with the lengths as constraints.

    Each step solves ``[[B, J^T], [J, 0]] [d, y] = -[g, r]``, where B is 2 Q plus the stress matrix of the
    multipliers, and is shortened until ``|g| + |r|`` decreases.
    """
    metric, t = energy.metric, lengths.triangulation
    system, clamped = VertexSystem(t, energy.form, recorder.work), HeldTriangle.of(start.vertices, t.faces[0])
    epsilon = 1e-10 * energy.area
    size = max(2 * float(energy.form.diagonal().mean()), 1 / energy.area)  # a single triangle has no bending
    x, y, unit = start.vertices, start.multipliers, metric.mean_length

    def equations(x: Floats, y: Floats) -> tuple[Floats, Floats]:
        return 2 * (energy.form @ x) + lengths.forces(x, y), lengths.residuals(x)

    g, r = equations(x, y)
    imbalance = float(np.abs(g).max()) / size
    for _ in range(60):
        rows = edge_rows(t, x, metric.lengths)
        recorder.iterations += 1
        try:
            factor, epsilon = _factored(system, rows, y / metric.lengths, epsilon, clamped)
        except SingularMatrix:
            break
        d, dy = _constrained_step(t, factor, rows, g, r, epsilon)
        longest = float(np.linalg.norm(d, axis=1).max())
        before = float(np.linalg.norm(g) / size + np.linalg.norm(r))
        for part in SEARCH.parameters(min(1.0, 0.5 * unit / longest) if longest > 0 else 1.0):
            g, r = equations(x + part * d, y + part * dy)
            if SEARCH.accepts(float(np.linalg.norm(g) / size + np.linalg.norm(r)), before, part):
                break
        else:
            break  # at rounding, or no minimum nearby
        x, y = x + part * d, y + part * dy
        imbalance, residual = float(np.abs(g).max()) / size, float(np.abs(r).max()) / unit
        recorder.show(residual=residual, vertices=x)
        if imbalance < 1e-11 and residual < EXACT:
            break
    return LeastBending(x, y, imbalance)


def _constrained_step(
    t: Triangulation, factor: SymmetricFactor, rows: Floats, g: Floats, r: Floats, epsilon: float
) -> tuple[Floats, Floats]:
    """Steps of the vertices, (V, 3), and of the multipliers, (E,), from the factors of ``A``.

    ``A = J^T J + epsilon B``, and conjugate gradients solve ``J A^-1 J^T (epsilon y) = r - J A^-1 (epsilon g
    + J^T r)``: all but a few eigenvalues of this matrix are close to 1.
    """

    def solve(forces: Floats) -> Floats:
        return factor.solve(forces.ravel(), sweeps=1).reshape(-1, 3)

    def pulled(tensions: Floats) -> Floats:
        return solve(t.incidence @ (rows * tensions[:, None]))

    def grown(d: Floats) -> Floats:
        return np.einsum("ei,ei->e", rows, t.incidence.T @ d)

    d = -solve(epsilon * g + t.incidence @ (rows * r[:, None]))
    left = r + grown(d)
    matrix = LinearOperator((len(r), len(r)), matvec=lambda w: grown(pulled(w)), dtype=np.float64)
    w = cg(matrix, left, rtol=1e-8, maxiter=200)[0] if left.any() else left
    return d - pulled(w), w / epsilon


def _factored(
    system: VertexSystem,
    rows: Floats,
    stress: Floats,
    epsilon: float,
    clamped: HeldTriangle,
) -> tuple[SymmetricFactor, float]:
    """Factors of ``J^T J + epsilon B``, and an epsilon for which it is positive definite.

    Finer meshes need a smaller epsilon.  If there is none, the surface is not a minimum, and the bending form
    is made stiffer in these steps.
    """
    smaller = ((epsilon * 0.1**k, 0.0) for k in range(3))
    # If the matrix is not definite, multiples of the bending form are added.
    for part, more in (*smaller, *((epsilon, more) for more in (0.3, 1.0, 3.0, 10.0, 30.0))):
        try:
            weight = 2 * part * (1 + more)
            return system.penalized(rows, weight, tensions=part * stress, clamped=clamped), part
        except SingularMatrix:
            continue
    stretched = epsilon * np.maximum(stress, 0.0)  # definite without the stress of compressed edges
    return system.penalized(rows, 2 * epsilon, tensions=stretched, clamped=clamped), epsilon
