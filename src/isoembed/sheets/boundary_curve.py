"""Isometric surfaces with a prescribed boundary curve.

The number of inner edges exceeds that of unknowns by the number of boundary vertices minus three: the surface
is exact if lengths and curve are compatible, and otherwise fitted by least squares.

An elastic sheet of decreasing thickness leads from a harmonic surface to the basin of attraction; starts with
bumps are tried in turn, as bumps may be on the wrong side.  Finally only the stabilizer of the bending energy
is kept: bending itself would push nearly flat vertices to the wrong side of their neighbors.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.sparse import csr_array, diags_array

from isoembed.aim.acceptance import REALIZED
from isoembed.aim.vertex_reflections import reflections, shallow
from isoembed.arrays import Floats, Mask
from isoembed.linalg import factor_general
from isoembed.mesh.triangulation import Triangulation
from isoembed.metric.curvature import face_areas
from isoembed.progress.stages import StageRecorder
from isoembed.sheets.bending import BendingEnergy
from isoembed.sheets.elastic_sheet import ElasticSheet
from isoembed.sheets.length_constraints import LengthConstraints
from isoembed.surface import measures
from isoembed.surface.smoothness import fine_roughness
from isoembed.surface.vertex_system import HeldVertices

STIFFNESSES = tuple(10.0 ** (-k / 2) for k in range(2, 13))  # successive epsilon over the area
BUMPED = 1e-4  # initial value for a start with a bump, which thicker sheets would flatten
SMOOTHEST = tuple(10.0**-k for k in range(5, 12))  # epsilon over the area, without bending
FLAT = 1e-6  # thickness over size below which a curve is planar


def starts(lengths: LengthConstraints, boundary: Floats, inside: Mask) -> Iterator[tuple[Floats, float]]:
    """Initial surfaces, (V, 3), each with the first epsilon over the area.

    First the harmonic one, with every inner vertex at the mean of its neighbors; then surfaces with bumps,
    and with a bump beside a dent.
    """
    t = lengths.triangulation
    laplacian = csr_array(diags_array(t.degrees.astype(np.float64)) - t.adjacency)
    free, fixed = np.flatnonzero(inside), np.flatnonzero(~inside)
    rows = laplacian[free]
    factor = factor_general(rows[:, free])
    vertices = boundary.copy()
    vertices[free] = factor.solve(-(rows[:, fixed] @ boundary[fixed]))
    curve = boundary[fixed] - boundary[fixed].mean(axis=0)
    _, sizes, axes = np.linalg.svd(curve, full_matrices=False)
    upward = axes[2] if axes[2, 2] >= 0 else -axes[2]  # the upper one of two mirror images
    bump = np.zeros(t.n_vertices)
    bump[free] = factor.solve(np.ones(len(free)))
    bump /= bump.max()
    if sizes[2] > FLAT * sizes[0]:
        yield vertices, STIFFNESSES[0]
    else:  # for a planar curve the harmonic surface is flat, and would stay so
        raised = np.outer(bump, upward)
        yield vertices + height_with_area(lengths, vertices, raised) * raised, BUMPED
    height = 0.3 * float(np.linalg.norm(curve, axis=1).max())  # of bumps
    away = (vertices - boundary[fixed].mean(axis=0)) @ axes.T
    for shape in (bump, bump * away[:, 0], bump * away[:, 1]):
        largest = float(np.abs(shape).max())
        if largest <= FLAT * float(np.abs(away).max()):  # all inner vertices are in the middle
            continue
        for side in (height, -height):
            yield vertices + np.outer(side / largest * shape, upward), BUMPED


def height_with_area(lengths: LengthConstraints, vertices: Floats, bump: Floats) -> float:
    """Height of a bump for which the surface has at least the area of the metric."""
    faces, goal = lengths.triangulation.faces, float(face_areas(lengths.metric).sum())
    height = lengths.metric.mean_length
    while measures.face_areas(faces, vertices + height * bump).sum() < goal:
        height *= 1.5
    return height


def through_curve(
    energy: BendingEnergy,
    lengths: LengthConstraints,
    boundary: Floats,
    start: Floats | None,
    recorder: StageRecorder,
) -> Floats:
    """Solve for the inner vertices by least squares of the inner edge lengths.

    Parameters
    ----------
    energy : BendingEnergy
    lengths : LengthConstraints
    boundary : ndarray, shape (V, 3)
        Positions; only those of boundary vertices are used.
    start : ndarray, shape (V, 3), or None
        Initial surface, by default `starts`.
    recorder : StageRecorder

    Returns
    -------
    ndarray, shape (V, 3)
    """
    t, unit = lengths.triangulation, lengths.metric.mean_length
    inside, inner = ~t.boundary_vertices, ~t.boundary_edges
    if not inside.any():
        return boundary
    clamped = HeldVertices.fixed(np.flatnonzero(~inside))
    smooth = ElasticSheet(lengths, energy.stabilizer, clamped, recorder)

    def tries() -> Iterator[tuple[ElasticSheet, Floats, float]]:
        """Elastic sheets, each with an initial surface and the first epsilon over the area."""
        first, *bumped = starts(lengths, boundary, inside)
        sheets = []
        for times in (10, 100):  # factors of the stabilizer in the bending form
            form = csr_array(energy.form + (times - 1) * energy.stabilizer)
            sheets.append(ElasticSheet(lengths, form, clamped, recorder))
            yield sheets[-1], *first
        for each in bumped:
            yield sheets[0], *each
        for x, _ in bumped:
            yield sheets[0], x, 1e-5  # if the bump is still flattened

    def released(x: Floats) -> Floats:
        for stiffness in SMOOTHEST:
            x = smooth.relaxed(x, stiffness * energy.area, 15)
        return settled(x)

    def settled(x: Floats) -> Floats:
        return smooth.relaxed(x, 0.0, 40, 1e-14)

    def squares(x: Floats) -> float:
        r = lengths.residuals(x)[inner]
        return float(r @ r)

    def is_realized(x: Floats) -> bool:
        return bool(np.abs(lengths.residuals(x)[inner]).max() < REALIZED * unit)

    if start is None:
        lowest: dict[ElasticSheet, float] = {}
        best, fewest = boundary, np.inf
        for sheet, x, first in tries():
            passed = [x]
            for stiffness in STIFFNESSES:
                if stiffness <= first:
                    x = sheet.relaxed(x, stiffness * energy.area, 15)
                    passed.append(x)
            value = sheet.value(x, STIFFNESSES[-1] * energy.area)
            if not value < 0.99 * lowest.get(sheet, np.inf):  # no improvement
                continue
            lowest[sheet], x = value, released(x)
            if squares(x) < fewest:
                best, fewest = x, squares(x)
                for y in passed:
                    residual = np.abs(lengths.residuals(y)[inner]).max()
                    recorder.show(residual=float(residual) / unit, vertices=y)
            if is_realized(x):
                break
        x = best
    else:
        x = released(np.where(inside[:, None], start, boundary))
    unreflected = x
    for _ in range(40):  # reflected vertices at most
        if is_realized(x):
            break
        moves, best = reflections(t, x), x
        for v in _doubtful(lengths, x, moves):
            y = x.copy()
            y[v] += moves[v]
            y = settled(y)
            if squares(y) < squares(best):
                best = y
            if is_realized(y):
                break
        if not squares(best) < 0.9 * squares(x):
            break
        x = best
    if is_realized(x):
        return _smoother(t, x)
    # Reflections that fit errors of measured lengths are dents.
    return min(unreflected, x, key=lambda y: fine_roughness(t, y))


def _smoother(t: Triangulation, x: Floats) -> Floats:
    """Surface with each inner vertex of degree three on the smoother side of its neighbors.

    The lengths are the same on both sides.
    """
    moves = reflections(t, x)
    for v in np.flatnonzero(~t.boundary_vertices & (t.degrees == 3)):
        y = x.copy()
        y[v] += moves[v]
        if fine_roughness(t, y) < fine_roughness(t, x):
            x = y
    return x


def _doubtful(lengths: LengthConstraints, x: Floats, moves: Floats) -> list[int]:
    """Inner vertices possibly on the wrong side: shallow ones, and those with the largest residuals."""
    t = lengths.triangulation
    r = np.where(t.boundary_edges, 0.0, lengths.residuals(x))
    residual_sums = np.abs(t.incidence) @ r**2
    residual_sums += t.adjacency @ residual_sums
    orders = shallow(t, x, lengths.lengths, r, moves), np.argsort(-residual_sums)
    inside = [order[~t.boundary_vertices[order]][:16] for order in orders]
    return list(dict.fromkeys(np.concatenate(inside).tolist()))
