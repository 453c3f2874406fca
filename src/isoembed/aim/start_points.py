"""Start points of Newton's method for other realizations near a surface.

They are ends of motions: all roots of the quadratic equations in combinations of several motions to predicted
realizations (`nearby_motions`, `nearby_realizations`).  Each has an expected roughness, as the intended
surface is among the smooth ones.  Motions that smooth the surface in different places are combined in one
additional start point.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from isoembed.aim.length_expansion import LengthExpansion
from isoembed.aim.nearby_motions import MOST_MOTIONS, Motions, nearby_motions
from isoembed.aim.nearby_realizations import predicted_motions, softest_motions
from isoembed.arrays import Floats
from isoembed.surface.smoothness import QuinticResiduals


class StartPoint(NamedTuple):
    """Start of Newton's method, and the expected roughness of the realization."""

    roughness: float
    vertices: Floats


class StartPoints(NamedTuple):
    """Start points, the smoothest first, and the number of systems of equations solved incompletely."""

    points: list[StartPoint]
    incomplete: int


def start_points(
    expansion: LengthExpansion, count: int, distance: float, hidden: int = 0, always: int = 0
) -> StartPoints:
    """Start points near a surface.

    Parameters
    ----------
    expansion : LengthExpansion
    count : int
        Largest number of motions combined.
    distance : float
        Largest distance of a realization, in mean edge lengths.
    hidden : int
        Number of softest motions projected out of all others, which they hide near a fold.
    always : int
        Number of softest motions combined with all others.

    Raises
    ------
    SingularMatrix
        The surface is not infinitesimally rigid.
    """
    near = 1.1 * distance  # margin for predicted motions
    softest = softest_motions(expansion, count)
    charts = QuinticResiduals.of(expansion.system.triangulation, expansion.vertices)
    found = nearby_motions(expansion, softest, near * float(expansion.lengths.mean()), charts, hidden)
    groups = _groups(found, softest[: min(always, count - 1)], count)
    nearest = len(groups) - max(len(found.motions) - MOST_MOTIONS, 0)
    now = charts.roughness(expansion.vertices)
    tried: list[Floats] = []
    incomplete = 0
    for i, group in enumerate(groups):
        # Nearly real roots are tried, too.
        predicted = predicted_motions(expansion, group, near, 0.3)
        incomplete += not predicted.complete
        for motion in predicted.motions:
            if i >= nearest and charts.roughness(expansion.vertices + motion) >= now:
                continue  # of the many long motions, only smoothing ones
            close = 0.05 * np.abs(motion).max()  # distance of identical roots
            if all(np.abs(motion - other).max() > close for other in tried):
                tried.append(motion)
    plausible = [motion for motion in tried if _is_plausible(expansion, motion)]
    return StartPoints(_smoothest_first(expansion, plausible, charts), incomplete)


def _groups(found: Motions, soft: Floats, count: int) -> list[Floats]:
    """Combinations of motions: the shortest ones, then each of the others with its neighbors.

    The soft motions are part of each combination.
    """
    count -= len(soft)
    size = np.linalg.norm(found.motions, axis=2)
    size = size / np.linalg.norm(size, axis=1, keepdims=True)
    together = size @ size.T
    np.fill_diagonal(together, np.inf)
    # Neighbors of each motion that is not among the shortest.
    beside = np.argsort(-together, axis=1, kind="stable")[count:, : min(3 + 1, count)]
    groups = [found.motions[:count], *(found.motions[each] for each in beside)]
    return [np.concatenate([soft, group]) for group in groups]


def _smoothest_first(
    expansion: LengthExpansion, motions: list[Floats], charts: QuinticResiduals
) -> list[StartPoint]:
    """Start points at the ends of motions, and at the end of the combined smoothing motions.

    Motions are combined if they act in different places, so that the residuals are additive.
    """
    x = expansion.vertices
    roughness = [charts.roughness(x + motion) for motion in motions]
    order = np.argsort(roughness, kind="stable")
    together, smoothest, count = np.zeros_like(x), charts.roughness(x), 0
    for i in order[: np.searchsorted(np.sort(roughness), smoothest)]:
        end = together + motions[i]
        expected = charts.roughness(x + end)
        apart = _residual_norm(expansion, together) + _residual_norm(expansion, motions[i])
        # Ratio of the residual of the combination to the sum of residuals.
        if expected < smoothest and (not count or _residual_norm(expansion, end) <= 1.5 * apart):
            together, smoothest, count = end, expected, count + 1
    found = [StartPoint(roughness[i], x + motions[i]) for i in order]
    return [StartPoint(smoothest, x + together), *found] if count > 1 else found


def _is_plausible(expansion: LengthExpansion, motion: Floats) -> bool:
    """Whether the residual at the end of a motion is small compared with its second-order terms."""
    bent = float(np.linalg.norm(expansion.bends(motion, motion)))
    return _residual_norm(expansion, motion) <= 0.7 * bent / 2  # share of the second-order terms


def _residual_norm(expansion: LengthExpansion, motion: Floats) -> float:
    """Norm of the residual at the end of a motion."""
    return float(np.linalg.norm(expansion.residuals_at(motion)))
