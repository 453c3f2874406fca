"""Uniformization (paper, section 2.1) only as far as convexity: a convex metric near the given one.

The curvature diffuses over the surface until it is positive everywhere: small features are smoothed away, and
the large-scale shape remains.  A conformal change of the lengths, with one factor for each vertex, leads to a
metric with this curvature.  Unlike the uniform metric it is close to the given one if that is nearly convex,
and it is unique up to scale: no Moebius maps have to be fixed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property
from typing import cast

import numpy as np
from scipy.sparse import csc_array, diags_array

from isoembed.arrays import Floats
from isoembed.errors import InvalidMetric
from isoembed.intrinsic.delaunay import make_delaunay
from isoembed.intrinsic.vertex_matrix import vertex_matrix
from isoembed.linalg import SingularMatrix, Solver, Work, analyze, dissect
from isoembed.metric.conformal import equivalent
from isoembed.metric.convexity import deficit_rounding
from isoembed.metric.glued import GluedMetric
from isoembed.metric.laplacian import cotangent_laplacian, deficit_laplacian
from isoembed.nonlinear.acceptance import LineSearch
from isoembed.progress.stages import StageRecorder

SHARE = "deficit of a vertex's area on a sphere"
FAR_MARGIN = 0.05  # of a vertex's share of 4 pi, for the start of a continuation
NEAR_MARGIN = 0.005  # the same, for the start of Newton's method
SEARCH = LineSearch(decrease=0.1, shortest=1e-3)
PINNED = 1e-9  # Laplacian entries; shift of the diagonal that fixes the mean


class Convexification:
    """Convex metrics as starts of a pull-back; their distance from the given one grows with their margin.

    Parameters
    ----------
    original : GluedMetric
        Scaled to a mean edge length of about 1.

    Notes
    -----
    The curvature measure after the time tau is ``delta(tau) = M (M + tau K)^-1 delta(0)``, M the areas and K
    the cotangent Laplacian, on the intrinsic Delaunay triangulation; tau is doubled, starting from the square
    of the mean edge length.  The factors u of ``l_ij e^{(u_i + u_j) / 2}`` follow by Newton's method, as the
    derivative of the deficits is K (Springborn, Schroeder and Pinkall, ACM TOG 27, 2008); on the sphere and
    in the hyperbolic plane it is the `deficit_laplacian`, and the area determines u.  If a step
    would break a triangle, the current metric is made Delaunay by flips first.  The result then leaves the
    conformal class, which is not needed.
    """

    def __init__(self, original: GluedMetric) -> None:
        self.original = original
        self._tau = 0.0  # diffusion time; no requested margin was reached before it

    @cached_property
    def is_convex(self) -> bool:
        """Whether no deficit of the given metric is negative beyond rounding."""
        rounding = deficit_rounding(self.original)
        return bool((self.original.deficits >= -rounding).all())

    @property
    def negative_curvature(self) -> float:
        """Absolute sum of the negative deficits over the sum of all deficits."""
        return float(-np.minimum(self.original.deficits, 0.0).sum() / _total(self.original))

    def metric(self, margin: float, recorder: StageRecorder) -> GluedMetric | None:
        """A convex metric on the given vertices and its own triangulation; the given metric, if it is convex.

        Parameters
        ----------
        margin : float
            Least deficit of a vertex after the diffusion, relative to the share of its area on a round
            sphere.  Smaller margins give closer and, in places, flatter metrics.  Call with increasing
            margins: the diffusion continues from the previous time.
        recorder : StageRecorder
            Recorder of the Newton steps.

        Returns
        -------
        GluedMetric or None
            None if the margin was not reached.
        """
        if self.is_convex:
            return self.original
        try:
            found = self._changed(margin, recorder)
        except SingularMatrix:  # triangles too thin for floats
            found = None
        if found is None and self._smaller is not None:
            return self._smaller.metric(margin, recorder)
        return found

    @cached_property
    def _smaller(self) -> Convexification | None:
        """Convexification of the metric at half scale, in space of significant positive curvature.

        For a large fraction of a sphere's area the derivative of the deficits may become singular on the way
        to the convex metric; a smaller metric needs less curvature.
        """
        # Curvature of space times area, over 4 pi.
        if not 1 - _total(self.original) / (4 * np.pi) > 0.01:
            return None
        half = np.full(self.original.n_vertices, -np.log(2.0))
        return Convexification(equivalent(self.original, half))

    def _changed(self, margin: float, recorder: StageRecorder) -> GluedMetric | None:
        """Follow the conformal change; None if it stalls."""
        reached = _Delaunay.of(self.original, recorder.work)
        diffused = self._diffused(reached, margin, recorder)
        if diffused is None:
            return None
        goal, step = diffused
        lower = 0.5 * margin * reached.shares  # half of the margin suffices after the conformal change
        for count in range(100):
            missing = goal - reached.metric.deficits
            recorder.show(residual=float(np.abs(missing).max()))
            if (reached.metric.deficits >= lower).all():
                return reached.metric
            if count > 0:
                step = reached.solved(missing)
            recorder.iterations += 1
            off = float(np.linalg.norm(missing))
            for s in SEARCH.parameters():
                trial = reached.changed(s * step)
                if trial and SEARCH.accepts(float(np.linalg.norm(goal - trial.metric.deficits)), off, s):
                    break
            else:
                return None
            reached = trial if s == 1.0 else _Delaunay.of(trial.metric, recorder.work)
        return None

    def _diffused(
        self, triangles: _Delaunay, margin: float, recorder: StageRecorder
    ) -> tuple[Floats, Floats] | None:
        """The deficits at the first time at which all have the margin, if rounding allows.

        Also the first Newton step to them, which needs no factorization: from
        ``(M + tau K) M^-1 delta(tau) = delta(0)`` follows ``K u = delta(tau) - delta(0)`` for
        ``u = -tau M^-1 delta(tau)``.  On the sphere and in the hyperbolic plane the derivative is a
        different matrix, which is factored.
        """
        shape, first = triangles.metric.triangles, triangles.metric.mean_length**2
        shares = triangles.shares
        mass = shares / _total(triangles.metric) * shape.areas.sum() * shape.unit**2
        self._tau = self._tau or first
        by_factors = False
        last = first * 2.0**50  # longest diffusion time; beyond it, curvature is uneven by rounding only
        while self._tau < last:
            recorder.iterations += 1
            sources = triangles.metric.deficits / self._tau
            density, by_factors = triangles.steady(mass / self._tau, sources, by_factors)
            diffused = mass * density
            if (diffused >= margin * shares).all():
                if not triangles.metric.space.is_euclidean:
                    return diffused, triangles.solved(diffused - triangles.metric.deficits)
                step = -self._tau * density
                return diffused, step - step.mean()
            self._tau *= 2
        return None


@dataclass(frozen=True)
class _Delaunay:
    """A metric on its Delaunay triangulation, with a lazily created solver for its Laplacians."""

    metric: GluedMetric
    solver: Callable[[], Solver]

    @classmethod
    def of(cls, metric: GluedMetric, work: Work) -> _Delaunay:
        tables = metric.half_edges(directed=False)
        make_delaunay(tables, np.zeros(metric.n_vertices))

        @cache
        def solver() -> Solver:
            nothing = np.zeros(tables.corners.size), np.zeros(metric.n_vertices)
            pattern = vertex_matrix(
                tables.corners, tables.twins, *nothing
            )  # the Laplacian's values may vanish
            order = dissect(pattern).vertex_order()
            return analyze(pattern, order, definite=metric.curvature <= 0, work=work)

        return cls(GluedMetric.flipped(tables), solver)

    @property
    def shares(self) -> Floats:
        """Deficits of the vertex areas, a third of each triangle, on a sphere of the same area, (V,)."""
        areas = self.metric.triangles.areas
        share = np.bincount(self.metric.faces.ravel(), np.repeat(areas / areas.sum(), 3))
        return cast(Floats, _total(self.metric) / 3 * share)

    def shifted(self, K: csc_array, diagonal: Floats) -> csc_array:
        """A matrix with an added diagonal, in the pattern of the solver."""
        on_diagonal = K.indices == np.repeat(np.arange(len(diagonal)), np.diff(K.indptr))
        K.data[on_diagonal] += diagonal  # a sum of matrices would drop zeros
        return K

    @cached_property
    def _laplacian(self) -> csc_array:
        return cotangent_laplacian(self.metric)

    def steady(self, diagonal: Floats, sources: Floats, by_factors: bool) -> tuple[Floats, bool]:
        """Solve with the Laplacian plus a diagonal, by conjugate gradients; by factoring if these fail.

        Also returned is whether it was factored: conjugate gradients fail for smaller diagonals, too.
        """
        from scipy.sparse.linalg import cg  # slow to import, not needed for convex metrics

        matrix = self.shifted(self._laplacian.copy(), diagonal)
        if not by_factors:
            jacobi = diags_array(1 / matrix.diagonal())
            # More iterations would cost more than a factorization.
            found, failed = cg(matrix, sources, rtol=1e-7, maxiter=150, M=jacobi)
            if not failed:
                return cast(Floats, found), False
        return self.solver().factor(matrix.data).solve(sources), True

    def solved(self, missing: Floats) -> Floats:
        """Conformal factors that change the deficits by the given amounts, to first order."""
        # The curvature of space, of this sign, determines the mean, weakly if it is small.
        pinned = -PINNED if self.metric.curvature > 0 else PINNED
        matrix = self.shifted(deficit_laplacian(self.metric), np.full(len(missing), pinned))
        step: Floats = self.solver().factor(matrix.data).solve(missing)
        return step - step.mean() if self.metric.space.is_euclidean else step

    def changed(self, u: Floats) -> _Delaunay | None:
        """The metric with these conformal factors on the same triangles, if it exists."""
        try:
            return _Delaunay(equivalent(self.metric, u), self.solver)
        except InvalidMetric:
            return None


def _total(metric: GluedMetric) -> float:
    """The sum of the deficits, by the Gauss-Bonnet theorem."""
    if metric.space.is_euclidean:
        return 4 * np.pi
    triangles = metric.triangles
    return float(4 * np.pi - metric.curvature * triangles.areas.sum() * triangles.unit**2)
