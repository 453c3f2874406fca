"""Newton's method from a surface with boundary to a nearby one with other lengths or boundary data."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from isoembed.arrays import Floats
from isoembed.errors import NotEmbedded
from isoembed.mesh.triangulation import frozen
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.nonlinear.acceptance import LineSearch, contraction
from isoembed.nonlinear.newton import newton
from isoembed.nonlinear.stopping import below, short_step
from isoembed.progress.stages import Log
from isoembed.sheets.bending import BendingEnergy
from isoembed.sheets.convex_cap import with_heights
from isoembed.sheets.derivatives import SheetDerivatives, bending_factor
from isoembed.sheets.length_constraints import EXACT, LengthConstraints
from isoembed.sheets.surface import BALANCED, SheetEmbedding

STEPS = 30  # maximum number of Newton steps


def nearby_sheet(sheet: SheetEmbedding, metric: PolyhedralMetric, boundary: Floats | None) -> SheetEmbedding:
    """Surface near a given one, with the same kind of boundary condition.

    Parameters
    ----------
    sheet : SheetEmbedding
    metric : PolyhedralMetric
        Metric on the same triangles.
    boundary : ndarray, shape (B,) or (B, 3), or None
        Heights or positions, if prescribed.

    Returns
    -------
    SheetEmbedding
        Surface found; with a given curve, and with handles, a least-squares fit that need not have converged
        to the lengths.

    Raises
    ------
    NotEmbedded
        No surface was found.
    """
    unit, normalized = metric.unit, metric.normalized
    log, x = Log(None), sheet.vertices / unit
    properties: dict[str, Any] = {}
    is_settled = True
    with log.stage("near") as recorder:
        if sheet.heights is not None:
            heights = sheet.heights if boundary is None else boundary
            x = with_heights(normalized, x, heights / unit, recorder)
            properties["heights"] = frozen(np.array(heights))
        elif sheet.tensions is not None:
            x, tensions, imbalance = _least_bending(normalized, x, sheet.tensions * unit)
            properties |= {"tensions": frozen(tensions / unit), "imbalance": imbalance}
        else:
            if boundary is not None:
                x = x.copy()
                x[np.concatenate(metric.triangulation.boundaries)] = boundary / unit
            x, is_settled = _least_squares(normalized, x)
    properties |= {"stages": log.stages, "message": "", "uniqueness": None}
    found = replace(sheet, metric=metric, vertices=unit * x, **properties)
    is_exact = sheet.heights is not None or sheet.tensions is not None
    is_found = (found.converged if is_exact else is_settled) and (found.imbalance or 0.0) <= BALANCED
    if not is_found:
        raise NotEmbedded(found.message, found)
    return found


def _least_bending(metric: PolyhedralMetric, start: Floats, tensions: Floats) -> tuple[Floats, Floats, float]:
    """Vertices and tensions in equilibrium near given ones, and the remaining imbalance."""
    energy, lengths = BendingEnergy(metric), LengthConstraints(metric)
    n, scale = start.size, max(2 * float(energy.form.diagonal().mean()), 1.0)

    def unbalanced(unknowns: Floats) -> Floats:
        x, y = unknowns[:n].reshape(-1, 3), scale * unknowns[n:]
        forces = (2 * (energy.form @ x) + lengths.forces(x, y)) / scale
        return np.concatenate([forces.ravel(), lengths.residuals(x)])

    def solve(unknowns: Floats, residuals: Floats) -> Floats:
        factor, _ = bending_factor(energy, lengths, unknowns[:n].reshape(-1, 3), scale * unknowns[n:])
        return factor.solve(np.append(residuals, np.zeros(6)))[: len(residuals)]

    found = newton(
        np.append(start, tensions / scale),
        unbalanced,
        solve,
        contraction(1.0),
        converged=below(EXACT * metric.mean_length),
        max_iterations=STEPS,
    ).point
    imbalance = float(np.abs(found.residual[:n]).max())
    return found.x[:n].reshape(-1, 3), scale * found.x[n:], imbalance


def _least_squares(metric: PolyhedralMetric, start: Floats) -> tuple[Floats, bool]:
    """Least-squares vertices near a start, by Newton's method, and whether the iteration converged."""
    lengths, inner = LengthConstraints(metric), ~metric.triangulation.boundary_edges

    def solve(x: Floats, r: Floats) -> Floats:
        return SheetDerivatives.of_least_squares(lengths, x).newton_step(r[inner])

    x = newton(
        start,
        lengths.residuals,
        solve,
        LineSearch(decrease=0.0, shortest=1e-3),
        norm=lambda p: float(np.sum(p.residual[inner] ** 2)),
        converged=short_step(1e-10 * metric.mean_length),
        max_iterations=STEPS,
    ).point.x
    # Rounding limits the decrease of the squares before the gradient: one more step doubles the digits.
    step = solve(x, lengths.residuals(x))
    # A longer final step means that no minimum was found.
    return x - step, bool(np.abs(step).max() <= 1e-7 * metric.mean_length)
