"""Isometric surfaces with a prescribed boundary curve.

Inside, the edges are more equations than unknowns, by three less than the boundary has vertices: a surface is
found exactly where lengths and curve belong together, and fitted by least squares elsewhere.

An elastic sheet that becomes thinner leads from a harmonic surface to the basin; starts with bumps are tried
in turn, as bumps may be on the wrong side.  Then only the stabilizer of the bending energy is left: bending
itself would push vertices that are nearly flat to the wrong side of their neighbors.
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

STIFFNESSES = tuple(10.0 ** (-k / 2) for k in range(2, 13))  # epsilon over the area, one after the other
BUMPED = 1e-4  # the first for a start with a bump, which thicker sheets would flatten
THIN = 1e-5  # the first where these flatten it, too
BUMP = 0.3  # height of a bump over the radius of the curve
STABILIZERS = 10, 100  # times the stabilizer, beside the bending
SMOOTHEST = tuple(10.0**-k for k in range(5, 12))  # epsilon over the area, without bending
DESCENT = 15  # Newton steps at most for each
SETTLED = 1e-6  # mean edge lengths: a shorter step ends the descent for one epsilon
NEWTON = 40  # steps without bending, at most
LESS = 0.99  # share of the energy of another surface
ROUNDS = 40  # vertices that are reflected at most
REFLECTED = 16  # vertices whose reflections are tried, before a minimum counts as the least
BETTER = 0.9  # share of the squares that is left by a reflection that helps
FLAT = 1e-6  # thickness over size of a curve that is in a plane


def starts(lengths: LengthConstraints, boundary: Floats, inside: Mask) -> Iterator[tuple[Floats, float]]:
    """Surfaces to start from, (V, 3), each with the first epsilon over the area.

    With every vertex inside at the mean of its neighbors; then with bumps, and with a bump beside a dent.
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
    upward = axes[2] if axes[2, 2] >= 0 else -axes[2]  # of mirror images in a plane, the upper one
    bump = np.zeros(t.n_vertices)
    bump[free] = factor.solve(np.ones(len(free)))
    bump /= bump.max()
    if sizes[2] > FLAT * sizes[0]:
        yield vertices, STIFFNESSES[0]
    else:  # of a flat curve all is flat, and would stay so
        raised = np.outer(bump, upward)
        yield vertices + height_with_area(lengths, vertices, raised) * raised, BUMPED
    height = BUMP * float(np.linalg.norm(curve, axis=1).max())
    away = (vertices - boundary[fixed].mean(axis=0)) @ axes.T
    for shape in (bump, bump * away[:, 0], bump * away[:, 1]):
        largest = float(np.abs(shape).max())
        if largest <= FLAT * float(np.abs(away).max()):  # all vertices inside are in the middle
            continue
        for side in (height, -height):
            yield vertices + np.outer(side / largest * shape, upward), BUMPED


def height_with_area(lengths: LengthConstraints, vertices: Floats, bump: Floats) -> float:
    """Height of a bump with which a surface has the area of the metric, or a little more."""
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
    """Solve for the vertices inside, by least squares of the lengths there.

    Parameters
    ----------
    energy : BendingEnergy
    lengths : LengthConstraints
    boundary : ndarray, shape (V, 3)
        Positions; only those of the boundary's vertices are used.
    start : ndarray, shape (V, 3), or None
        By default `starts`.
    recorder : StageRecorder

    Returns
    -------
    ndarray, shape (V, 3)
    """
    t, unit = lengths.triangulation, lengths.metric.mean_length
    inside, inner = ~t.boundary_vertices, ~t.boundary_edges
    if not inside.any():
        return boundary
    held = HeldVertices.fixed(np.flatnonzero(~inside))
    smooth = ElasticSheet(lengths, energy.stabilizer, held, recorder)

    def tries() -> Iterator[tuple[ElasticSheet, Floats, float]]:
        """Sheets that bend, each with a start and the first epsilon over the area."""
        first, *bumped = starts(lengths, boundary, inside)
        sheets = []
        for times in STABILIZERS:
            form = csr_array(energy.form + (times - 1) * energy.stabilizer)
            sheets.append(ElasticSheet(lengths, form, held, recorder))
            yield sheets[-1], *first
        for each in bumped:
            yield sheets[0], *each
        for x, _ in bumped:
            yield sheets[0], x, THIN

    def released(x: Floats) -> Floats:
        for stiffness in SMOOTHEST:
            x = smooth.relaxed(x, stiffness * energy.area, DESCENT, SETTLED)
        return settled(x)

    def settled(x: Floats) -> Floats:
        return smooth.relaxed(x, 0.0, NEWTON, 1e-14)

    def squares(x: Floats) -> float:
        r = lengths.residuals(x)[inner]
        return float(r @ r)

    def is_realized(x: Floats) -> bool:
        return bool(np.abs(lengths.residuals(x)[inner]).max() < REALIZED * unit)

    if start is None:
        least: dict[ElasticSheet, float] = {}
        best, fewest = boundary, np.inf
        for sheet, x, first in tries():
            passed = [x]
            for stiffness in STIFFNESSES:
                if stiffness <= first:
                    x = sheet.relaxed(x, stiffness * energy.area, DESCENT, SETTLED)
                    passed.append(x)
            value = sheet.value(x, STIFFNESSES[-1] * energy.area)
            if not value < LESS * least.get(sheet, np.inf):  # as before, or worse
                continue
            least[sheet], x = value, released(x)
            if squares(x) < fewest:
                best, fewest = x, squares(x)
                for y in passed:
                    missed = np.abs(lengths.residuals(y)[inner]).max()
                    recorder.show(residual=float(missed) / unit, vertices=y)
            if is_realized(x):
                break
        x = best
    else:
        x = released(np.where(inside[:, None], start, boundary))
    unreflected = x
    for _ in range(ROUNDS):
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
        if not squares(best) < BETTER * squares(x):
            break
        x = best
    if is_realized(x):
        return _smoother(t, x)
    # Reflections are dents where they fit the errors of measured lengths.
    return min(unreflected, x, key=lambda y: fine_roughness(t, y))


def _smoother(t: Triangulation, x: Floats) -> Floats:
    """The surface with each vertex inside that has three neighbors on the smoother side of them.

    On both sides it has the lengths.
    """
    moves = reflections(t, x)
    for v in np.flatnonzero(~t.boundary_vertices & (t.degrees == 3)):
        y = x.copy()
        y[v] += moves[v]
        if fine_roughness(t, y) < fine_roughness(t, x):
            x = y
    return x


def _doubtful(lengths: LengthConstraints, x: Floats, moves: Floats) -> list[int]:
    """Vertices inside that may be on the wrong side: shallow ones, and where the lengths are missed most."""
    t = lengths.triangulation
    r = np.where(t.boundary_edges, 0.0, lengths.residuals(x))
    missed = np.abs(t.incidence) @ r**2
    missed += t.adjacency @ missed
    orders = shallow(t, x, lengths.lengths, r, moves), np.argsort(-missed)
    inside = [order[~t.boundary_vertices[order]][:REFLECTED] for order in orders]
    return list(dict.fromkeys(np.concatenate(inside).tolist()))
