"""Best fit: smooth surface fitted to noisy lengths in least squares; estimated noise and weight; outliers.

Exact surfaces of noisy lengths have dimples, and for large errors often none is found.  The best fit
minimizes

    ``|r|^2 + mu |R x|^2``,

with the errors r of the lengths and the roughness R of `isoembed.aim.regularized_energy`.  Without errors, mu
could vanish; with errors, the surface would follow them.  mu is determined from the lengths themselves, as
the one that best predicts each length from the others, by generalized cross-validation.

References
----------
Golub, Heath and Wahba, Generalized cross-validation as a method for choosing a good ridge parameter,
Technometrics 21 (1979).
Girard, A fast 'Monte-Carlo cross-validation' procedure for large least squares problems with noisy data,
Numer. Math. 56 (1989).
"""

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from isoembed.aim.regularized_energy import RegularizedEnergy
from isoembed.arrays import Floats, Indices
from isoembed.embedding.measured import SIGNIFICANCE, edges_near
from isoembed.linalg import SingularMatrix
from isoembed.linalg.work import Budget
from isoembed.metric.curvature import deficits
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.progress.stages import StageRecorder
from isoembed.surface.smoothness import misfits, robust_mean

WEIGHT = 10.0  # mean edge lengths^2; initial mu, too large for dimples
MAX_STEPS = 8  # Gauss-Newton steps for each mu
REDUNDANT = 0.1  # least redundancy number of a length that others can contradict
DOUBT = 2.0  # in errors; fits with larger residuals of the other lengths do not test one
TELLING = 0.1  # least degrees of freedom, over the edges, for a noise estimate
FREE = 20.0  # degrees of freedom that distinguish half the noise from all of it
CANDIDATES = 4  # number of largest residuals tested as outliers
PERSISTENT = 0.85  # share of the residual of a wrong length that remains at a third of mu
COARSE = 1000  # largest number of vertices of a surface that may be rough as well as noisy
ROUGH = 0.5  # share of the deficits not predicted by neighbors, for noisy lengths
UNBIASED = 0.1  # mean edge lengths^2; largest mu of a fit whose residuals tell the errors of the lengths
PROBES = 4  # random vectors for degrees of freedom, accurate to a percent


@dataclass(frozen=True)
class BestFit:
    """A smooth surface fitted to given lengths.

    Attributes
    ----------
    vertices : ndarray, shape (V, 3)
        Vertices, in the unit of the lengths.
    weight : float
        mu, over the square of the mean edge length.
    noise : float
        Estimated root mean square of the errors of the lengths, over the mean edge length: that of the
        residuals, corrected for the degrees of freedom of the fit.
    degrees_of_freedom : float
        Degrees of freedom of the residuals, at least 1: the edges minus those of the fit.
    scatter : float
        `noise` of the fit with the smallest score so far, among those with enough degrees of freedom; 0 if
        there is none, or if few are left and a smaller mu might have a smaller score.  Of a `best_fit`, the
        `Fits.scatter`.
    left_over : float
        Expected sum of the squared residuals for errors of the lengths with the variance 1.
    predicted : ndarray, shape (E,), or None
        Lengths of the edges suspected to be wrong, on fits without them, over the mean edge length; NaN for
        the others.
    alike : ndarray of int, or None
        Other edges, an error of which explains the residuals as well as one of those suspected.
    """

    vertices: Floats
    weight: float
    noise: float
    degrees_of_freedom: float
    scatter: float = 0.0
    left_over: float = 0.0
    predicted: Floats | None = None
    alike: Indices | None = None

    @property
    def score(self) -> float:
        """Cross-validation score; smaller for better predictions of lengths."""
        return self.noise / math.sqrt(self.degrees_of_freedom)

    def prediction_error(self, error: float) -> float:
        """Cross-validation score for errors of at least this size, over the mean edge length."""
        return float(max(self.noise, error) / np.sqrt(self.degrees_of_freedom))


def best_fit(
    metric: PolyhedralMetric,
    energy: RegularizedEnergy,
    start: Floats,
    recorder: StageRecorder,
    most: float,
) -> BestFit | None:
    """Fit a smooth surface to the lengths of a metric.

    Parameters
    ----------
    metric : PolyhedralMetric
        Scaled to a mean edge length of about 1.
    energy : RegularizedEnergy
        Energy of this metric about the start.
    start : ndarray, shape (V, 3)
        A smooth surface of similar shape and size, such as the polyhedron of a nearby convex metric.
    recorder : StageRecorder
        Recorder of the Gauss-Newton steps.
    most : float
        Budget in factorizations; the first mu is always tried.

    Returns
    -------
    BestFit or None
        None if no smooth surface is near to the lengths.
    """
    fits = Fits(metric, energy, recorder, Budget(recorder.work, most))
    best = first = fits.fit(start, WEIGHT)
    for direction in (-1, 1):
        last = first
        for level in range(1, 8 + 1):  # values of mu, down or up
            if fits.exhausted:
                break
            # Powers of ten suffice: the score has a broad minimum.
            last = fits.fit(last.vertices, WEIGHT * 10.0 ** (direction * level))
            if not last.score < 0.995 * best.score:  # stop at smaller gains
                break
            best = last
        if best is not first:
            break
    a, b = metric.edges.T
    missed = metric.space.distances(best.vertices[a], best.vertices[b]) - metric.lengths
    # Mean edge lengths; a surface with larger residuals has lost its shape.
    near = np.sqrt(np.mean(missed**2)) < 0.3 * metric.mean_length
    return replace(best, scatter=fits.scatter(best)) if best.score < np.inf and near else None


class Outlier(NamedTuple):
    """An outlier among the lengths, against a fit to the others.

    Attributes
    ----------
    edge : int
    missed : float
        Excess of the edge.
    magnitude : float
        Magnitude of its studentized residual, times the standard deviation.
    scatter, nearby : float
        Standard deviations estimated from all residuals, and from those of edges nearby.
    """

    edge: int
    missed: float
    magnitude: float
    scatter: float
    nearby: float


def looks_noisy(metric: PolyhedralMetric, vertices: Floats) -> bool:
    """Whether the lengths are like those of a smooth surface with errors.

    The test uses the deficits in the charts of a nearby surface, (V, 3): on a smooth surface they are
    predicted by their neighbors.  For meshes with 2,000 to 20,000 vertices the deviation is at most 4 %; with
    errors of a thousandth of an edge it is 60 to 140 %.
    """
    if metric.triangulation.n_vertices <= COARSE:
        return False
    given = deficits(metric)[:, None]
    missed = misfits(metric.triangulation, vertices, given)
    return bool(robust_mean(np.abs(missed)) > ROUGH * robust_mean(np.abs(given)))


class Fits:
    """Fits to one metric for any mu."""

    def __init__(
        self,
        metric: PolyhedralMetric,
        energy: RegularizedEnergy,
        recorder: StageRecorder,
        budget: Budget,
    ) -> None:
        self._metric, self._energy, self._recorder = metric, energy, recorder
        self._budget = budget
        self._telling: list[BestFit] = []
        signs = np.random.default_rng(0).choice([-1.0, 1.0], size=(PROBES, len(metric.lengths)))
        self._probes = signs[:, np.argsort(np.argsort(metric.lengths))]  # independent of edge numbers

    @property
    def exhausted(self) -> bool:
        """Whether another fit might exceed the budget."""
        return self._budget.spent + MAX_STEPS + 1 > self._budget.limit

    def fit(self, vertices: Floats, weight: float) -> BestFit:
        """The fit nearest to these vertices, with mu in units of the squared mean edge length."""
        lengths, unit = self._metric.lengths, self._metric.mean_length
        mu = weight * unit**2
        x = self._energy.minimized(vertices, lengths, mu, 0.01, MAX_STEPS, self._recorder)
        r = self._energy.residuals(x, lengths)
        try:
            free, left_over = self._traces(x, mu)
        except SingularMatrix:
            return BestFit(x, weight, np.inf, 1.0)
        noise = float(np.sqrt(r @ r / free)) / unit
        found = BestFit(x, weight, noise, free, left_over=left_over)
        if free > TELLING * len(r):  # otherwise the score is not accurate to a percent
            self._telling.append(found)
        if not self._telling:
            return found
        best = min(self._telling, key=lambda one: one.score)
        # Otherwise a smaller mu may be better.
        is_least = free > FREE or best is not self._telling[-1]
        return replace(found, scatter=best.noise if is_least else 0.0)

    def scatter(self, fit: BestFit) -> float:
        """Root mean square of the errors of the lengths, over the mean edge length, by a fit.

        Errors with the variance s^2 leave residuals with an expected sum of squares ``s^2 trace (I - H)^2``,
        which the probes estimate as well.  If mu is large, H is not all of the fit: its charts are those of
        a start that depends on the lengths, too, and contain half of their errors.  A smaller mu, up to
        `UNBIASED`, releases these, and smooths away less of the body.
        """
        fit = fit if fit.weight <= UNBIASED or self.exhausted else self.fit(fit.vertices, UNBIASED)
        if not fit.score < np.inf:
            return fit.noise
        r = self._energy.residuals(fit.vertices, self._metric.lengths)
        return float(np.sqrt(r @ r / fit.left_over)) / self._metric.mean_length

    def _traces(self, x: Floats, mu: float) -> tuple[float, float]:
        """Traces of ``I - H`` and of its square, where I - H maps errors of the lengths to residuals.

        ``H = J (J^T J + mu R^T R)^-1 J^T``.  They are estimated by random vectors (Girard): the means of
        ``z^T (I - H) z`` and of ``|(I - H) z|^2``, with z of random signs.
        """
        self._solve = self._energy.solver(x, self._metric.lengths, mu, 0.0)
        left = np.array([self._left(x, z) for z in self._probes])
        trace = float(np.sum(self._probes * left)) / PROBES
        return max(trace, 1.0), float(np.sum(left**2)) / PROBES  # smaller traces are not resolved

    def _left(self, x: Floats, errors: Floats) -> Floats:
        """``(I - H) e`` with H of the last fit; raises SingularMatrix."""
        energy, lengths = self._energy, self._metric.lengths
        return errors - energy.rates(x, lengths, self._solve(energy.forces(x, lengths, errors)))

    def outlier(self, fit: BestFit, error: float, most: float) -> Outlier | None:
        """The length with the largest studentized residual in a fit to the others, if that exceeds `most`.

        The fit is the last one.  The residual in a fit to the others is ``r_e / (1 - H_ee)``, with standard
        deviation ``s / sqrt(1 - H_ee)``; s is estimated from its other residuals, but at least the error.
        Only the `CANDIDATES` with the largest residuals are tested.
        """
        if not fit.score < np.inf or np.isinf(most):
            return None
        r = self._energy.residuals(fit.vertices, self._metric.lengths)
        found = None
        large = np.argsort(-np.abs(r))[:CANDIDATES]
        for e in large[np.abs(r[large]) > np.sqrt(REDUNDANT) * most * error].tolist():
            tested = self.tested(fit, e)
            if tested is None:
                continue
            deviation = max(error, tested.scatter)
            studentized = tested.magnitude / deviation
            if studentized > most and deviation < DOUBT * error:
                found, most = tested, studentized
        return found

    def stands_out(self, fit: BestFit, edge: int, limit: float) -> bool:
        """Whether a residual of the last fit exceeds a limit, in deviations of those nearby."""
        tested = self.tested(fit, edge)
        return tested is not None and tested.magnitude > limit * max(tested.scatter, tested.nearby)

    def alike(self, fit: BestFit, edge: int, error: float) -> Indices:
        """Edges nearby, an error of which explains the last fit as well as one of this edge, the best first.

        Without a length, the minimum of the fit is smaller by the square of its studentized residual.  The
        difference of two of these is twice the logarithm of a likelihood ratio.  All lengths are compared,
        however little others contradict them.
        """
        near = edges_near(self._metric.triangulation, edge)
        if not fit.score < np.inf:
            return near
        r, least = self._energy.residuals(fit.vertices, self._metric.lengths), np.finfo(float).eps
        try:
            columns = [(e, self._left(fit.vertices, np.eye(1, len(r), e)[0])) for e in (edge, *near.tolist())]
        except SingularMatrix:
            return near
        gains = np.array([r[e] ** 2 / max(column[e], least) for e, column in columns])
        left = r - r[edge] / max(columns[0][1][edge], least) * columns[0][1]
        variance = max(error**2, float(left @ left) / max(fit.degrees_of_freedom - 1.0, 1.0))
        order = np.argsort(-gains[1:], kind="stable")
        return near[order[gains[1:][order] >= gains[0] + 2.0 * np.log(SIGNIFICANCE) * variance]]

    def tested(self, fit: BestFit, edge: int) -> Outlier | None:
        """An edge in a fit to the others; None if they do not contradict it.  The fit is the last."""
        column = self._column(fit, edge)
        if column is None:
            return None
        r = self._energy.residuals(fit.vertices, self._metric.lengths)
        redundancy = float(column[edge])
        missed = float(r[edge] / redundancy)
        squares = (r - missed * column) ** 2
        near = edges_near(self._metric.triangulation, edge)
        free = fit.degrees_of_freedom - column @ column / redundancy
        nearby = len(near) * fit.degrees_of_freedom / len(r)
        return Outlier(
            edge,
            missed,
            abs(missed) * float(np.sqrt(redundancy)),
            float(np.sqrt(squares.sum() / max(free, 1.0))),
            float(np.sqrt(squares[near].sum() / max(nearby, 1.0))),
        )

    def persists(self, fit: BestFit, outlier: Outlier, limit: float) -> bool:
        """Whether the last fit, with a smaller mu, has as large a residual of a length as the previous one.

        A residual due to smoothing decreases, and is like those nearby.  That of a wrong length does not
        decrease, or exceeds a limit in deviations of those nearby.
        """
        now = self.tested(fit, outlier.edge)
        if now is None or abs(now.missed) <= PERSISTENT * abs(outlier.missed):
            return False
        return outlier.magnitude > limit * outlier.nearby or now.magnitude >= outlier.magnitude

    def _column(self, fit: BestFit, edge: int) -> Floats | None:
        """A column of ``I - H``, None if the other lengths do not contradict this one."""
        unit = np.zeros(len(self._metric.lengths))
        unit[edge] = 1.0
        try:
            column = self._left(fit.vertices, unit)
        except SingularMatrix:
            return None
        return column if column[edge] >= REDUNDANT else None
