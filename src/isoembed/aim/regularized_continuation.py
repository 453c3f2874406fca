"""Guided adiabatic pull-back where the curvature is negative: as smooth as can be, all the way back.

There, surfaces flex: many have nearly the same lengths, and plain Newton steps wander among them.  Guided,
each step minimizes

    ``|r|^2 + mu (|R x|^2 + w |K x|^2)``,

r the errors of the lengths.  R takes every vertex to its difference from a cubic fitted to its neighbors: it
knows smooth surfaces of any shape, to fourth order in the edge length.  K, the cotangent Laplacian, takes x
to its mean curvature; it is stiffer at middle wavelengths but would flatten the surface.  So both guide the
surface from the waypoint to the given metric; there K is let go, and then R, after its place was taken by
quintics fitted twice, which know smooth surfaces better still.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from copy import copy
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array
from scipy.sparse.linalg import LinearOperator, cg

from isoembed.aim.pullback import extrapolated
from isoembed.linalg import SingularMatrix
from isoembed.metric.glued import GluedMetric
from isoembed.metric.laplacian import cotangent_laplacian
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.progress.stages import StageRecorder
from isoembed.surface.local_fit import edge_lengths_about
from isoembed.surface.rigidity import VertexSystem, edge_rows, length_residuals
from isoembed.surface.smoothness import fit_residuals

Floats = NDArray[np.float64]

STEPS = 6  # from t = 1 to t = 0
WEIGHT = 0.01  # mu at first: little, as a surface with unresolved edges keeps them only if it is
STIFFER, STIFFEST = 3.0, 10.0  # times mu, up to this, where a step goes uphill: the surface is too soft
BENDING = 3.0  # w on the way
LETTING_GO = (0.3, 0.03, 0.0)  # w at t = 0
FADE = 0.1  # of mu from step to step, after that
FADED = 15  # such steps at most
USUAL_FADE = 4  # as a rule
CLOSE = 1e-6  # mean edge lengths: from here, Newton's method does not get lost
STALLED = 0.9  # of the residual is left, or more, after two steps of the fading on end: the surface is lost
RHO = 3.5  # largest eigenvalue, or so, of the Laplacian of edges of length 1, which R's is 1
SMALLEST_COTANGENT = 0.01  # weights of K below this would reward bending across obtuse triangles
SHARE = 0.5  # of |K x|^2 that stands in for |R x|^2 in the preconditioner
SOLVED = 1e-3  # of the gradient: Gauss-Newton steps are not worth more
STIFFNESSES = (1.0, 2.0, 11.0, 101.0)  # tried one after the other until a step goes downhill


class Guide:
    """The energy ``|r|^2 + mu (|R x|^2 + w |K x|^2)`` of surfaces with the triangles of a metric.

    Parameters
    ----------
    metric : PolyhedralMetric
        Gives K.
    vertices : ndarray, shape (V, 3)
        Of a surface near enough for its charts to be smooth on those sought; gives R.
    backend : str, optional
        As in `isoembed.linalg.analyze`.
    """

    def __init__(self, metric: PolyhedralMetric, vertices: Floats, backend: str | None = None) -> None:
        self.triangulation = metric.triangulation
        self._lengths = edge_lengths_about(self.triangulation, metric.lengths)
        K = csr_array(cotangent_laplacian(GluedMetric.of(metric), least=SMALLEST_COTANGENT) / RHO)
        self._KK = csr_array(K.T @ K)
        self._system = VertexSystem(self.triangulation, self._KK, backend)
        self._guide_by(fit_residuals(self.triangulation, vertices))

    def finer(self, vertices: Floats) -> Guide:
        """The same with quintic fits, applied twice, in the charts of these vertices in the place of R."""
        other = copy(self)
        residuals = fit_residuals(self.triangulation, vertices, 5)
        other._guide_by(csr_array(residuals @ residuals))
        return other

    def _guide_by(self, residuals: csr_array) -> None:
        """Take R from these residuals of fits, each row of unit norm over the edge length there."""
        size = self._lengths * np.sqrt(residuals.multiply(residuals).sum(axis=1))
        self._R = csr_array(diags_array(1 / size) @ residuals)
        self._RT = csr_array(self._R.T)

    def roughness(self, vertices: Floats, w: float) -> Floats:
        """``(R^T R + w K^T K) x``, shape (V, 3): half the gradient of the penalty."""
        return self._RT @ (self._R @ vertices) + w * (self._KK @ vertices)

    def solver(self, vertices: Floats, lengths: Floats, mu: float, w: float) -> Callable[[Floats], Floats]:
        """Prepare to solve ``(J^T J + mu (R^T R + w K^T K)) d = g`` for d, (V, 3), by conjugate gradients.

        The matrix with K in the place of R, sparser by far, is factored, and preconditions: a handful of
        iterations is enough.

        Raises
        ------
        SingularMatrix
            It is not positive definite to working precision.
        """
        triangulation = self.triangulation
        rows = edge_rows(triangulation, vertices, lengths)
        factor = self._system.penalized(rows, mu * (w + SHARE))
        a, b = triangulation.edges.T

        def product(d: Floats) -> Floats:
            x = d.reshape(-1, 3)
            stretch = np.einsum("ij,ij->i", rows, x[a] - x[b])
            return (triangulation.incidence @ (rows * stretch[:, None]) + mu * self.roughness(x, w)).ravel()

        n = 3 * triangulation.n_vertices
        matrix = LinearOperator((n, n), matvec=product, dtype=np.float64)
        inverse = LinearOperator((n, n), matvec=lambda g: factor.solve(g, sweeps=0), dtype=np.float64)

        def solve(gradient: Floats) -> Floats:
            with np.errstate(all="ignore"):  # of a matrix too ill-conditioned for it, it makes no numbers
                d = cg(matrix, gradient.ravel(), rtol=SOLVED, M=inverse, maxiter=100)[0].reshape(-1, 3)
            if not np.isfinite(d).all():
                raise SingularMatrix("conjugate gradients broke down")
            return d

        return solve

    def step(
        self,
        vertices: Floats,
        lengths: Floats,
        mu: float,
        w: float,
        recorder: StageRecorder,
        stiffness: float = 1.0,
    ) -> tuple[Floats, bool]:
        """One Gauss-Newton step, and whether it goes downhill.

        Parameters
        ----------
        vertices : ndarray, shape (V, 3)
        lengths : ndarray, shape (E,)
        mu, w : float
        recorder : StageRecorder
        stiffness : float
            Shortens the step where surfaces are soft: the matrix is that of mu times this.
        """

        def measured(x: Floats) -> tuple[Floats, Floats, float]:
            r, pull = length_residuals(self.triangulation, x, lengths), self.roughness(x, w)
            return r, pull, float(r @ r + mu * np.sum(x * pull))

        r, pull, energy = measured(vertices)
        rows = edge_rows(self.triangulation, vertices, lengths)
        gradient = self.triangulation.incidence @ (rows * r[:, None]) + mu * pull
        recorder.iterations += 1
        recorder.factorizations += 1
        try:
            trial = vertices - self.solver(vertices, lengths, stiffness * mu, w)(gradient)
        except SingularMatrix:
            return vertices, False
        r, _, reached = measured(trial)
        recorder.show(residual=float(np.abs(r).max()))
        return trial, bool(reached <= energy)

    def relaxed(
        self, vertices: Floats, lengths: Floats, mu: float, w: float, recorder: StageRecorder
    ) -> Floats:
        """A step that does not go uphill, however short; the vertices themselves if there is none."""
        for stiffness in STIFFNESSES:
            trial, downhill = self.step(vertices, lengths, mu, w, recorder, stiffness)
            if downhill:
                return trial
        return vertices


def regularized_continuation(
    guide: Guide,
    start: Floats,
    lengths: Callable[[float], Floats],
    recorder: StageRecorder,
    kept: Mapping[str, NDArray[Any]] | None = None,
) -> Floats:
    """Follow a path of metrics from an embedded one at t = 1, then let go of what guides.

    Parameters
    ----------
    guide : Guide
    start : ndarray, shape (V, 3)
        Realizes the metric at t = 1.
    lengths : callable
        The lengths at t, shape (E,), in units of the mean edge length or so.
    recorder : StageRecorder
    kept : mapping of str to ndarray, optional
        What an interrupted pull-back kept, to go on from.

    Returns
    -------
    ndarray, shape (V, 3)
        Where it did not get lost, near enough to the metric at t = 0 for Newton's method.
    """
    mu, given = WEIGHT, lengths(0.0)
    known: list[tuple[float, Floats]] = []
    steps = np.linspace(1, 0, STEPS + 1).tolist()
    usual = len(steps) + len(LETTING_GO) + 2 + USUAL_FADE
    if kept is not None:
        mu, known = float(kept["mu"]), list(zip(kept["t"].tolist(), kept["x"], strict=True))
        steps = [t for t in steps if t < known[-1][0]]
    for t in steps:
        recorder.show(t=t)
        guess = extrapolated(known[-3:], t) if known else start
        x, downhill = guide.step(guess, lengths(t), mu, BENDING, recorder)
        while not downhill and mu < STIFFEST:
            mu *= STIFFER
            x, downhill = guide.step(guess, lengths(t), mu, BENDING, recorder)
        known = [*known[-2:], (t, x if downhill else guess)]
        recorder.keep(start=start, mu=mu, t=[t for t, _ in known], x=[x for _, x in known])
        recorder.show(done=min(recorder.iterations / usual, 1.0), vertices=known[-1][1])
    x = known[-1][1]
    for w in (BENDING, *LETTING_GO):
        x = guide.relaxed(x, given, mu, w, recorder)
        recorder.show(done=min(recorder.iterations / usual, 1.0), vertices=x)
    mu *= FADE
    x = guide.relaxed(x, given, mu, 0.0, recorder)
    found, residual = _let_go(guide.finer(x), x, given, mu, recorder)
    if residual > CLOSE:  # edges too long for quintics to know the surface
        found = min((found, residual), _let_go(guide, x, given, mu, recorder), key=lambda pair: pair[1])[0]
    return found


def _let_go(
    guide: Guide, x: Floats, lengths: Floats, mu: float, recorder: StageRecorder
) -> tuple[Floats, float]:
    """Let mu vanish; the last surface, and its residual."""
    before, slow = np.inf, 0
    for _ in range(FADED):
        x = guide.relaxed(x, lengths, mu, 0.0, recorder)
        residual = float(np.abs(length_residuals(guide.triangulation, x, lengths)).max())
        slow = slow + 1 if residual > STALLED * before else 0
        if residual <= CLOSE or slow == 2:
            break
        before = residual
        mu *= FADE
    return x, residual
