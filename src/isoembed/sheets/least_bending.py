"""Isometric surfaces of least bending energy: the thin-sheet limit.

The minimum of `bending.BendingEnergy` among the surfaces that have the lengths.  Where the curvature is not
positive, it is approached along ``sum r^2 / (2 epsilon) + W(x)``, epsilon to zero, as of a sheet that becomes
thinner; then Newton's method is applied to the equations with the lengths as constraints, whose multipliers
are the tensions of the edges.
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
from isoembed.sheets.length_constraints import LengthConstraints
from isoembed.surface.rigidity import edge_rows
from isoembed.surface.vertex_system import HeldTriangle, VertexSystem

STIFFNESSES = tuple(10.0**-k for k in range(4, 10))  # epsilon over the area, one after the other
TRIED = 20  # Newton steps at most for each of several starts
KEPT = 2  # of these, when the sheets are thick
DISTINCT = 1.0005, 1.05  # times the least energy, from and to which the second is another surface to be found
THINNER = tuple(10.0**-k for k in range(10, 13))  # the same, where forces were not balanced
DESCENT = 40  # Newton steps at most for each
SETTLED = 1e-6  # mean edge lengths: a shorter step ends the descent for one epsilon
NEWTON = 60  # steps at most with the lengths as constraints
AUGMENTED = 1e-10  # epsilon over the area in the matrix of these steps, at first
SEARCH = LineSearch(decrease=0.1, shortest=2.0**-7)
SMALLER = 3  # times that a tenth of epsilon is tried
STIFFER = 0.3, 1.0, 3.0, 10.0, 30.0  # shares of the bending form that are added where that is not definite
ROUNDING = 1e-11  # imbalance that is left
EXACT = 1e-14  # residual in mean edge lengths that is


@dataclass(frozen=True, eq=False)
class LeastBending:
    """A surface of least bending energy, or the last iterate.

    Attributes
    ----------
    vertices : ndarray, shape (V, 3)
    multipliers : ndarray, shape (E,)
        Of the lengths: the tension of each edge, where the bending modulus is 2 and edges pull.
    imbalance : float
        Largest force on a vertex that bending and tensions leave, over the mean diagonal of the form.
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
    """Minimize the energy of elastic sheets, each thinner than the last, from a start of any lengths."""
    x = start
    held = HeldTriangle.of(x, lengths.triangulation.faces[0])
    sheet = ElasticSheet(lengths, energy.form, held, recorder)
    recorder.show(vertices=x)
    for stiffness in stiffnesses:
        epsilon = stiffness * energy.area
        x = sheet.relaxed(x, epsilon, DESCENT, SETTLED)
        recorder.show(vertices=x)
    return LeastBending(x, lengths.residuals(x) / epsilon, np.inf)


def most_promising(
    energy: BendingEnergy,
    lengths: LengthConstraints,
    starts: Sequence[Floats],
    stiffnesses: Sequence[float],
    recorder: StageRecorder,
) -> list[Floats]:
    """The one or two starts from which thick elastic sheets bend least, the best first.

    Parameters
    ----------
    energy : BendingEnergy
    lengths : LengthConstraints
    starts : sequence of ndarray, shape (V, 3)
        At least two.
    stiffnesses : sequence of float
        Epsilon over the area; the first two are tried.
    recorder : StageRecorder
    """
    kept = [(start, start) for start in starts]
    for stiffness in stiffnesses[:2]:
        epsilon = stiffness * energy.area
        tried = []
        for start, x in kept:
            held = HeldTriangle.of(x, lengths.triangulation.faces[0])
            sheet = ElasticSheet(lengths, energy.form, held, recorder)
            x = sheet.relaxed(x, epsilon, TRIED, SETTLED)
            tried.append((sheet.value(x, epsilon), start, x))
        tried.sort(key=lambda each: each[0])
        kept = [(start, x) for _, start, x in tried[:KEPT]]
    (least, best, _), (value, second, _) = tried[:2]
    return [best, second] if DISTINCT[0] < value / least < DISTINCT[1] else [best]


def balanced(
    energy: BendingEnergy, lengths: LengthConstraints, start: LeastBending, recorder: StageRecorder
) -> LeastBending:
    """Newton's method for least bending with the lengths as constraints.

    Each step solves ``[[B, J^T], [J, 0]] [d, y] = -[g, r]``, B being 2 Q and the stress of the multipliers,
    and is shortened until ``|g| + |r|`` decreases.
    """
    metric, t = energy.metric, lengths.triangulation
    system, held = VertexSystem(t, energy.form, recorder.work), HeldTriangle.of(start.vertices, t.faces[0])
    epsilon = AUGMENTED * energy.area
    size = max(2 * float(energy.form.diagonal().mean()), 1 / energy.area)  # one triangle does not bend
    x, y, unit = start.vertices, start.multipliers, metric.mean_length

    def equations(x: Floats, y: Floats) -> tuple[Floats, Floats]:
        return 2 * (energy.form @ x) + lengths.forces(x, y), lengths.residuals(x)

    g, r = equations(x, y)
    imbalance = float(np.abs(g).max()) / size
    for _ in range(NEWTON):
        rows = edge_rows(t, x, metric.lengths)
        recorder.iterations += 1
        try:
            factor, epsilon = _factored(system, rows, y / metric.lengths, epsilon, held)
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
            break  # at rounding, or no minimum near
        x, y = x + part * d, y + part * dy
        imbalance, residual = float(np.abs(g).max()) / size, float(np.abs(r).max()) / unit
        recorder.show(residual=residual, vertices=x)
        if imbalance < ROUNDING and residual < EXACT:
            break
    return LeastBending(x, y, imbalance)


def _constrained_step(
    t: Triangulation, factor: SymmetricFactor, rows: Floats, g: Floats, r: Floats, epsilon: float
) -> tuple[Floats, Floats]:
    """Steps of the vertices, (V, 3), and of the multipliers, (E,), from the factors of ``A``.

    ``A = J^T J + epsilon B``, and conjugate gradients solve ``J A^-1 J^T (epsilon y) = r - J A^-1 (epsilon g
    + J^T r)``: all but few eigenvalues of this matrix are near 1.
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
    held: HeldTriangle,
) -> tuple[SymmetricFactor, float]:
    """Factors of ``J^T J + epsilon B``, and an epsilon with which it is definite.

    The finer the mesh, the less it has to be.  Where no epsilon makes it so, the surface is no minimum:
    bending is made stiffer in these steps.
    """
    smaller = ((epsilon * 0.1**k, 0.0) for k in range(SMALLER))
    for part, more in (*smaller, *((epsilon, more) for more in STIFFER)):
        try:
            weight = 2 * part * (1 + more)
            return system.penalized(rows, weight, tensions=part * stress, held=held), part
        except SingularMatrix:
            continue
    stretched = epsilon * np.maximum(stress, 0.0)  # without the stress of compressed edges it is definite
    return system.penalized(rows, 2 * epsilon, tensions=stretched, held=held), epsilon
