"""Pull-back guided by a vanishing bending energy, for metrics that Newton's method alone loses.

Where the curvature is negative, surfaces flex: many have nearly the same lengths, and plain Newton steps
wander among them.  A little of the bending energy ``|K x|^2``, K the cotangent Laplacian of the given metric
and K x twice the mean curvature vector times area, keeps the surface smooth all the way back; then its weight
is let go to zero.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import cast

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array

from isoembed.aim.pullback import extrapolated
from isoembed.linalg import Dissection, SingularMatrix
from isoembed.metric.curvature import Triangles
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.stages import Tally
from isoembed.surface.rigidity import VertexSystem, length_residuals

Floats = NDArray[np.float64]

STEPS = 12
WEIGHT = 2.5  # of the bending energy, over V: a plateau from a hundredth of it on
SWEEPS = 2  # Gauss-Newton steps at each t, and again at t = 0
FADE = 0.3  # of the weight from step to step at the end
FADED = 60  # such steps at most
SMALLEST_COTANGENT = 0.01  # weights of K below this would reward bending across obtuse triangles


def cotangent_laplacian(metric: PolyhedralMetric) -> csr_array:
    """The Laplacian K of linear finite elements, (V, V), its negative weights clamped."""
    triangulation = metric.triangulation
    across = np.roll(triangulation.face_edges, -1, axis=1)
    half = Triangles.of(metric.face_lengths).cotangents / 2
    weights = np.maximum(cast(Floats, np.bincount(across.ravel(), half.ravel())), SMALLEST_COTANGENT)
    a, b = triangulation.edges.T
    n = triangulation.n_vertices
    ends = (np.concatenate([a, b]), np.concatenate([b, a]))
    adjacency = csr_array((np.tile(weights, 2), ends), shape=(n, n))
    return csr_array(diags_array(adjacency.sum(axis=1)) - adjacency)


def bending_pull_back(
    metric: PolyhedralMetric,
    start: Floats,
    lengths: Callable[[float], Floats],
    tally: Tally,
    *,
    residual_tolerance: float,
    dissection: Dissection | None = None,
    backend: str | None = None,
) -> Floats:
    """Follow a path of metrics from an embedded one, guided by bending, and let the bending go.

    Parameters
    ----------
    metric : PolyhedralMetric
        The given one, at t = 0.
    start : ndarray, shape (V, 3)
        Realizes the metric at t = 1.
    lengths : callable
        The lengths at t, shape (E,).
    tally : Tally
    residual_tolerance : float
        Stop letting go when every length is right to this.
    dissection, backend
        As in `VertexSystem`.

    Returns
    -------
    ndarray, shape (V, 3)
    """
    K = cotangent_laplacian(metric)
    system = VertexSystem(metric.triangulation, csr_array(K.T @ K), dissection, backend)
    mu = WEIGHT / metric.triangulation.n_vertices
    known: list[tuple[float, Floats]] = []
    for t in np.linspace(1, 0, STEPS + 1)[1:].tolist():
        x = extrapolated(known[-3:], t) if known else start
        for _ in range(SWEEPS):
            x = _relaxed(system, x, lengths(t), mu, tally, t)
        known.append((t, x))
    given = lengths(0.0)
    for _ in range(SWEEPS):
        x = _relaxed(system, x, given, mu, tally, 0.0)
    for _ in range(FADED):
        if np.abs(length_residuals(metric.triangulation, x, given)).max() <= residual_tolerance:
            break
        mu *= FADE
        before, x = x, _relaxed(system, x, given, mu, tally, 0.0)
        if x is before:  # every step goes uphill: there is nothing to be had by going on
            break
    return x


def _relaxed(system: VertexSystem, x: Floats, lengths: Floats, mu: float, tally: Tally, t: float) -> Floats:
    """One Gauss-Newton step on ``|r|^2 + mu |K x|^2``, damped until it does not go uphill."""

    def measured(y: Floats) -> tuple[Floats, float]:
        r = length_residuals(system.triangulation, y, lengths)
        return r, float(r @ r + mu * np.sum(y * (system.penalty @ y)))

    r, energy = measured(x)
    damping = 0.0
    while damping <= 1e3 * mu:
        try:
            trial = x - system.penalized_step(x, lengths, r, mu, damping)
        except SingularMatrix:
            break
        tally.iterations += 1
        tally.factorizations += 1
        r_trial, energy_trial = measured(trial)
        if energy_trial <= energy:
            tally.show(t=t, residual=float(np.abs(r_trial).max()))
            return trial
        damping = max(10 * damping, mu)
    return x
