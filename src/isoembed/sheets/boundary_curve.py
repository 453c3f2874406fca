"""Isometric surfaces with a prescribed boundary curve.

Inside, the edges are more equations than unknowns, by three less than the boundary has vertices: a surface is
found exactly where lengths and curve belong together, and fitted by least squares elsewhere.  The start is
harmonic; bending of decreasing weight leads from there to the lengths.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.sparse import csr_array, diags_array, kron

from isoembed.arrays import Floats, Mask
from isoembed.linalg import factor_general
from isoembed.metric.curvature import face_areas
from isoembed.nonlinear.acceptance import LineSearch
from isoembed.nonlinear.newton import newton
from isoembed.nonlinear.stopping import short_step
from isoembed.progress.stages import StageRecorder
from isoembed.sheets.bending import BendingEnergy
from isoembed.sheets.length_constraints import LengthConstraints
from isoembed.surface import measures

WEIGHTS = tuple(10.0**-k for k in range(3, 13))  # epsilon over the area, one after the other
DESCENT = 4  # Gauss-Newton steps at most for each
NEWTON = 30  # without bending, at most
ROUNDS = 40  # vertices that are reflected at most
REFLECTED = 16  # vertices whose reflections are tried, before a minimum counts as the least
BETTER = 0.9  # share of the squares that is left by a reflection that helps
REALIZED = 1e-11  # largest residual of a realization, in mean edge lengths
FLAT = 1e-6  # thickness over size of a curve that is in a plane
SETTLED = 1e-6  # mean edge lengths: a shorter step ends the descent for one weight


def harmonic(lengths: LengthConstraints, boundary: Floats, inside: Mask) -> Floats:
    """Positions, (V, 3), with every vertex inside at the mean of its neighbors."""
    t = lengths.triangulation
    laplacian = csr_array(diags_array(t.degrees.astype(np.float64)) - t.adjacency)
    free, fixed = np.flatnonzero(inside), np.flatnonzero(~inside)
    vertices = boundary.copy()
    if not len(free):
        return vertices
    rows = laplacian[free]
    factor = factor_general(rows[:, free])
    vertices[free] = factor.solve(-(rows[:, fixed] @ boundary[fixed]))
    curve = boundary[fixed] - boundary[fixed].mean(axis=0)
    _, sizes, axes = np.linalg.svd(curve, full_matrices=False)
    if sizes[2] > FLAT * sizes[0]:
        return vertices
    # Of a flat curve all is flat, and would stay so: a bump of the area of the metric leaves the plane.
    bump = np.zeros(t.n_vertices)
    bump[free] = factor.solve(np.ones(len(free)))
    goal = float(face_areas(lengths.metric).sum())

    def area(height: float) -> float:
        return float(measures.face_areas(t.faces, vertices + height * np.outer(bump, axes[2])).sum())

    height = lengths.metric.mean_length / bump.max()
    while area(height) < goal:
        height *= 1.5
    return vertices + height * np.outer(bump, axes[2])


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
        By default `harmonic`.
    recorder : StageRecorder

    Returns
    -------
    ndarray, shape (V, 3)
    """
    t, unit = lengths.triangulation, lengths.metric.mean_length
    inside, inner = ~t.boundary_vertices, ~t.boundary_edges
    x = harmonic(lengths, boundary, inside) if start is None else np.where(inside[:, None], start, boundary)
    free = np.flatnonzero(np.repeat(inside, 3))
    if not len(free):
        return x
    form = csr_array(kron(2 * energy.form, np.eye(3), format="csr"))[free][:, free]

    def minimized(start: Floats, epsilon: float, most: int, shortest: float) -> Floats:
        """The minimum near a start, by Gauss-Newton steps, the last one no longer than this."""

        def solve(vertices: Floats, r: Floats) -> Floats:
            recorder.show(residual=float(np.abs(r).max()) / unit)
            J = lengths.jacobian(vertices)[np.flatnonzero(inner)][:, free]
            gradient = J.T @ r + 2 * epsilon * (energy.form @ vertices).ravel()[free]
            recorder.factorizations += 1
            recorder.iterations += 1
            step = np.zeros(vertices.size)
            # Singular where the lengths leave a motion free.
            step[free] = factor_general(J.T @ J + epsilon * form).solve(gradient)
            return step.reshape(-1, 3)

        return newton(
            start,
            lambda x: lengths.residuals(x)[inner],
            solve,
            LineSearch(decrease=0.0, shortest=1e-3),
            norm=lambda p: float(p.residual @ p.residual) / 2 + epsilon * energy.value(p.x),
            converged=short_step(shortest),
            max_iterations=most,
        ).point.x

    for weight in WEIGHTS:
        x = minimized(x, weight * energy.area, DESCENT, SETTLED * unit)

    def settled(vertices: Floats) -> Floats:
        return minimized(vertices, 0.0, NEWTON, 1e-14 * unit)

    def squares(vertices: Floats) -> float:
        r = lengths.residuals(vertices)[inner]
        return float(r @ r)

    x = settled(x)
    for _ in range(ROUNDS):
        for start in _reflected(lengths, x, inner):
            y = settled(start)
            if squares(y) < BETTER * squares(x):
                x = y
                break
        else:
            break
        if np.abs(lengths.residuals(x)[inner]).max() < REALIZED * unit:
            break
    return x


def _reflected(lengths: LengthConstraints, x: Floats, inner: Mask) -> Iterator[Floats]:
    """The surface with one vertex reflected through its neighbors, where lengths are missed most first.

    Where a vertex is nearly flat, both sides of its neighbors are minima of the squares.
    """
    t = lengths.triangulation
    squares = np.where(inner, lengths.residuals(x) ** 2, 0.0)
    if squares.max() < (REALIZED * lengths.metric.mean_length) ** 2:
        return
    missed = np.abs(t.incidence) @ squares
    missed = np.where(t.boundary_vertices, -1.0, missed + t.adjacency @ missed)
    for v in np.argsort(-missed)[: min(REFLECTED, int((missed >= 0).sum()))]:
        near = x[t.adjacency.indices[t.adjacency.indptr[v] : t.adjacency.indptr[v + 1]]]
        middle = near.mean(axis=0)
        normal = np.linalg.svd(near - middle)[2][2]
        y = x.copy()
        y[v] -= 2 * ((x[v] - middle) @ normal) * normal
        yield y
