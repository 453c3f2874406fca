"""Multilevel pull-back for large meshes with negative curvature.

The guided path is followed for a few thousand evenly spread vertices, then refined on levels with more of
them, followed by Newton's method on all lengths, with steps split into smooth and rough components.  The size
of the last level grows more slowly than the number of all vertices, because the error of quintics decreases
faster than the edge length.
"""

from collections.abc import Mapping
from contextlib import suppress
from math import ceil, log
from typing import Any

import numpy as np
from numpy.typing import NDArray

from isoembed.aim.interpolated_energy import InterpolatedEnergy
from isoembed.aim.regularized_continuation import FADE, SHORTEST, guided
from isoembed.aim.split_newton import SplitNewton
from isoembed.arrays import Floats
from isoembed.errors import InvalidMetric
from isoembed.linalg import SingularMatrix
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.nonlinear.descent import Reason
from isoembed.nonlinear.stopping import below
from isoembed.progress.stages import StageRecorder
from isoembed.surface.cells import VertexCells
from isoembed.surface.interpolation import Stencils
from isoembed.surface.length_newton import length_newton
from isoembed.surface.rigidity import LengthSystem, length_residuals
from isoembed.surface.smoothness import QuinticResiduals

LEAST_VERTICES = 16_000  # below, a single level is as fast
GUIDED = 1_500  # vertices of the guided path
FINEST = 4.5  # vertices of the last level, over the number of all to the power 5/8
GROWTH = 3.1  # ratio of successive levels; larger ones are too far for a step
SPLIT = (1e-2, 1e-4)  # successive mu of split steps
NEWTON_CLOSE = 4e-3  # mean edge lengths over vertices; residual from which Newton's method converges reliably
HELD = 4e-15  # damping of the last steps if J J^T is singular to rounding
LANDED = 1e-4  # mean edge lengths; largest residual after the last step of a successful path
# mu of the steps with quintics; if it decreases faster, vertices stay on a wrong side
QUINTIC = (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10)


def goes_by_levels(metric: PolyhedralMetric, checkpoint: Mapping[str, NDArray[Any]] | None) -> bool:
    """Whether to use levels: for many vertices in Euclidean space, unless a resumed run abandoned them."""
    is_abandoned = checkpoint is not None and "split" not in checkpoint
    many = metric.triangulation.n_vertices >= LEAST_VERTICES
    return metric.space.is_euclidean and many and not is_abandoned


def pulled_back_by_levels(
    metric: PolyhedralMetric,
    system: LengthSystem,
    start: Floats,
    recorder: StageRecorder,
    checkpoint: Mapping[str, NDArray[Any]] | None = None,
) -> Floats | None:
    """Pull a convex surface back to the vicinity of the lengths of a metric, for Newton's method.

    Parameters
    ----------
    metric : PolyhedralMetric
        Scaled to a mean edge length of about 1.
    system : LengthSystem
    start : ndarray, shape (V, 3)
        A convex surface of a nearby metric.
    recorder : StageRecorder
    checkpoint : mapping of str to ndarray, optional
        Checkpoint of an interrupted pull-back.

    Returns
    -------
    ndarray, shape (V, 3), or None
        None if the start is not convex, or Newton's method would not converge.

    Raises
    ------
    SingularMatrix
        The equations of a step are singular.
    """
    n = metric.triangulation.n_vertices
    convex = start - start.mean(axis=0)
    x = None if checkpoint is None else checkpoint.get("split")
    if x is None:
        x = _guided(metric, system, convex, recorder)
    if x is None:
        return None
    recorder.keep(split=x)
    recorder.show(vertices=x, level=f"{n:,} vertices")
    for count in _counts(n):
        stencils = _stencils(metric, convex, count)
        if stencils is None:
            return None
        energy = InterpolatedEnergy(metric, stencils, convex, x, recorder.work)
        settling = 1e-6 * energy.unit**2  # mean edge lengths^2; mu of the coarse steps
        z = energy.relaxed(x[stencils.cells.vertices], energy.lengths, settling, 0.0, recorder)
        split = _split(system, metric.lengths, energy)
        x, z = split.step(split.P @ z, z, SPLIT[0], recorder)
        del energy
    for mu in SPLIT[1:]:
        x, z = split.step(x, z, mu, recorder)
    quintics = QuinticResiduals.of(metric.triangulation, x)
    residual = _error(metric, x)
    for mu in QUINTIC:
        if residual < mu:
            continue
        x = split.smooth_step(x, quintics, mu, recorder)
        residual = _error(metric, x)
        recorder.show(residual=residual, vertices=x)
        if residual < NEWTON_CLOSE / n:
            break
    if not residual < LANDED:
        return None
    return _ended(system, metric.lengths, x, recorder) if residual < NEWTON_CLOSE / n else x


def _ended(system: LengthSystem, lengths: Floats, x: Floats, recorder: StageRecorder) -> Floats:
    """Newton steps to the lengths, with slight damping once J J^T is singular to rounding.

    If they do not converge, the later polish may.
    """
    exact, left = below(1e-12 * lengths.mean()), 8  # mean edge lengths, and steps
    for damping in (0.0, HELD):
        found = length_newton(
            system, x, lengths, recorder=recorder, damping=damping, converged=exact, max_iterations=left
        )
        x, left = found.point.x, left - found.iterations - 1
        if found.reason is not Reason.SINGULAR:
            break
        recorder.iterations += 1
    return x


def _counts(n: int) -> list[int]:
    """Numbers of vertices on the levels after the guided path, in order, for n vertices in all."""
    first = _first(n)
    growth = FINEST * n ** (5 / 8) / first
    steps = max(ceil(log(growth) / log(GROWTH)), 1)
    return [round(first * growth ** (k / steps)) for k in range(1, steps + 1)]


def _first(n: int) -> int:
    """Number of vertices of the guided path, for n vertices in all."""
    return GUIDED if n < 100_000 else 1_700


def _error(metric: PolyhedralMetric, x: Floats) -> float:
    """The largest error of a length, in mean edge lengths."""
    return float(np.abs(length_residuals(metric.triangulation, x, metric.lengths)).max() / metric.mean_length)


def _guided(
    metric: PolyhedralMetric, system: LengthSystem, convex: Floats, recorder: StageRecorder
) -> Floats | None:
    """The surface at the end of the guided path, after steps for all lengths with renewed charts.

    The charts of the convex surface are inaccurate: as mu decreases, soft motions would follow their errors,
    on ergospheres with narrow necks beyond recovery.
    """
    followed = _followed(metric, convex, recorder)
    if followed is None:
        return None
    energy, z, mu = followed
    split = _split(system, metric.lengths, energy)
    x, z = split.step(split.P @ z, z, SPLIT[0], recorder)
    for _ in range(2):  # steps in the charts of the last surface, with decreasing mu
        energy.in_charts_of(x)
        z = energy.relaxed(z, energy.lengths, mu, 0.0, recorder)
        split = _split(system, metric.lengths, energy)
        x, z = split.step(split.P @ z, z, SPLIT[0], recorder)
        mu *= FADE
    return x


def smooth_start(metric: PolyhedralMetric, start: Floats, recorder: StageRecorder) -> Floats:
    """The interpolated end of the guided path, smooth and near to the lengths even if they are noisy.

    For fewer vertices, or if the path fails, the convex start, (V, 3).
    """
    if not goes_by_levels(metric, None):
        return start
    convex = start - start.mean(axis=0)
    with suppress(SingularMatrix, InvalidMetric):  # coarse vertices on needle-shaped triangles
        followed = _followed(metric, convex, recorder)
        if followed is not None:
            energy, z, mu = followed
            energy.in_charts_of(energy.P @ z)
            return energy.P @ energy.relaxed(z, energy.lengths, mu, 0.0, recorder)
    return start


def _followed(
    metric: PolyhedralMetric, convex: Floats, recorder: StageRecorder
) -> tuple[InterpolatedEnergy, Floats, float] | None:
    """The energy of the coarse vertices, their positions at the end of the path, (C, 3), and the last mu."""
    stencils = _stencils(metric, convex, _first(len(convex)))
    if stencils is None:
        return None
    energy = InterpolatedEnergy(metric, stencils, convex, convex, recorder.work)
    ends = metric.edges[energy.edges.edges]
    ratio = np.linalg.norm(convex[ends[:, 0]] - convex[ends[:, 1]], axis=1) / energy.lengths
    ratio = np.maximum(ratio, SHORTEST)
    chosen = convex[stencils.cells.vertices]
    recorder.show(level=f"{len(chosen):,} of {len(convex):,} vertices")
    z, mu = guided(energy, chosen, lambda t: energy.lengths * ratio**t, recorder)
    return energy, z, mu


def _split(system: LengthSystem, lengths: Floats, energy: InterpolatedEnergy) -> SplitNewton:
    """Split Newton's method with the interpolation of the energy for smooth motions."""
    if energy.factor is None:
        raise SingularMatrix("no step of the coarse surface has factors")
    return SplitNewton(system, lengths, energy.P, energy.factor)


def _stencils(metric: PolyhedralMetric, convex: Floats, count: int) -> Stencils | None:
    """Evenly spread vertices and their triangulation; None if the surface is not convex."""
    cells = VertexCells.of(metric.triangulation, metric.lengths, convex, count)
    triangulation = cells.triangulation(convex)
    return None if triangulation is None else Stencils(cells, triangulation)
