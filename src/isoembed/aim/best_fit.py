"""Best fit: smooth surface fitted to noisy lengths in least squares, with estimated noise and weight.

Surfaces that have such lengths have dimples; where the errors are large, often none is found.
The best fit minimizes

    ``|r|^2 + mu |R x|^2``,

r the errors of the lengths and R the roughness, as in `isoembed.aim.regularized_energy`.  Were it
not for errors, mu could vanish; if it does, the surface follows them.  What they are the lengths themselves
tell: of all mu, the one is taken that best predicts each length from the others, by generalized
cross-validation.

References
----------
Golub, Heath and Wahba, Generalized cross-validation as a method for choosing a good ridge parameter,
Technometrics 21 (1979).
Girard, A fast 'Monte-Carlo cross-validation' procedure for large least squares problems with noisy data,
Numer. Math. 56 (1989).
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from isoembed.aim.regularized_energy import RegularizedEnergy
from isoembed.arrays import Floats
from isoembed.linalg import SingularMatrix
from isoembed.linalg.work import Budget
from isoembed.metric.curvature import deficits
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.progress.stages import StageRecorder
from isoembed.surface.smoothness import misfits, robust_mean

WEIGHT = 10.0  # mean edge lengths^2: the first mu, so large that no dimple catches it
MAX_STEPS = 8  # of the Gauss-Newton method, for each mu
REDUNDANT = 0.1  # share of a wrong length that its residual shows: if less, no other length contradicts it
DOUBT = 2.0  # errors: a fit that misses the other lengths by more is not a witness against one
TELLING = 0.1  # degrees of freedom, over the edges, of a fit whose noise is that of the lengths
FREE = 20.0  # degrees of freedom that tell half the noise from all of it
CANDIDATES = 4  # lengths with the largest residuals, of which one may stand out
PERSISTENT = 0.85  # share of what a length is missed by that a third of mu leaves of an error
COARSE = 1000  # vertices of the largest surface that may be rough as well as noisy
ROUGH = 0.5  # share of the deficits that neighbors do not expect, of lengths that look noisy
PROBES = 4  # random vectors that estimate degrees of freedom, to a percent


@dataclass(frozen=True)
class BestFit:
    """A surface that comes near to given lengths.

    Attributes
    ----------
    vertices : ndarray, shape (V, 3)
        In the unit of the lengths.
    weight : float
        mu, over the square of the mean edge length.
    noise : float
        Root mean square of the errors of the lengths, over the mean edge length, by this surface's account:
        of what it misses, corrected for what it followed.
    score : float
        By cross-validation: the less, the better it predicts lengths.
    scatter : float
        `noise` of the fit with the least score so far, of those with degrees of freedom enough to tell; 0 if
        there is none, or if few are left and a smaller mu might have a smaller score.
    """

    vertices: Floats
    weight: float
    noise: float
    score: float
    scatter: float = 0.0

    @property
    def degrees_of_freedom(self) -> float:
        """Degrees of freedom of the residuals, at least 1: the edges less those that the fit uses up."""
        return (self.noise / self.score) ** 2 if self.score < np.inf else 1.0


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
        Of mean edge length 1 or so.
    energy : RegularizedEnergy
        Of this metric, about the start.
    start : ndarray, shape (V, 3)
        A smooth surface of about this shape and size, such as the polyhedron of a convex metric nearby.
    recorder : StageRecorder
        Counts Gauss-Newton steps.
    most : float
        Factorizations: no mu but the first is tried where that might take more.

    Returns
    -------
    BestFit or None
        None if nothing as smooth comes near to the lengths.
    """
    fits = Fits(metric, energy, recorder, Budget(recorder.work, most))
    best = first = fits.fit(start, WEIGHT)
    for direction in (-1, 1):
        last = first
        for level in range(1, 8 + 1):  # values of mu, down or up
            if fits.exhausted:
                break
            # From one mu to the next: the score has a broad minimum.
            last = fits.fit(last.vertices, WEIGHT * 10.0 ** (direction * level))
            if not last.score < 0.995 * best.score:  # a smaller gain is not worth another mu
                break
            best = last
        if best is not first:
            break
    a, b = metric.edges.T
    missed = metric.space.distances(best.vertices[a], best.vertices[b]) - metric.lengths
    # Mean edge lengths: the mean miss of a surface that has lost its shape.
    near = np.sqrt(np.mean(missed**2)) < 0.3 * metric.mean_length
    return best if best.score < np.inf and near else None


class Outlier(NamedTuple):
    """A length that stands out of a fit, and how much longer its edge is on a fit to the others."""

    edge: int
    missed: float


def looks_noisy(metric: PolyhedralMetric, vertices: Floats) -> bool:
    """Whether lengths of many edges are like those of a smooth surface with errors: none has them exactly.

    By the deficits, in the charts of a surface nearby, (V, 3): on a smooth surface they are those that their
    neighbors expect.  Of meshes with 2,000 to 20,000 vertices they miss that by at most 4 %, with errors of a
    thousandth of an edge by 60 to 140 %.
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
        self._probes = signs[:, np.argsort(np.argsort(metric.lengths))]  # whatever the numbers of the edges

    @property
    def exhausted(self) -> bool:
        """Whether another fit might take more than is left."""
        return self._budget.spent + MAX_STEPS + 1 > self._budget.limit

    def fit(self, vertices: Floats, weight: float) -> BestFit:
        """The fit nearest to these vertices, with mu in units of the squared mean edge length."""
        lengths, unit = self._metric.lengths, self._metric.mean_length
        mu = weight * unit**2
        x = self._energy.minimized(vertices, lengths, mu, 0.001, MAX_STEPS, self._recorder)
        r = self._energy.residuals(x, lengths)
        try:
            free = self._degrees_of_freedom(x, mu)
        except SingularMatrix:
            return BestFit(x, weight, np.inf, np.inf)
        noise = float(np.sqrt(r @ r / free)) / unit
        found = BestFit(x, weight, noise, noise / np.sqrt(free))
        if free > TELLING * len(r):  # with fewer, the score is not known to a percent
            self._telling.append(found)
        if not self._telling:
            return found
        best = min(self._telling, key=lambda one: one.score)
        # Else smaller mu may be better still.
        is_least = free > FREE or best is not self._telling[-1]
        return replace(found, scatter=best.noise if is_least else 0.0)

    def _degrees_of_freedom(self, x: Floats, mu: float) -> float:
        """Trace of ``I - H``, which takes errors of the lengths to what the fit leaves of them.

        ``H = J (J^T J + mu R^T R)^-1 J^T``.  Its trace is estimated by random vectors (Girard): the mean of
        ``z^T (I - H) z``, with z of random signs.
        """
        self._solve = self._energy.solver(x, self._metric.lengths, mu, 0.0)
        left = sum(float(z @ self._left(x, z)) for z in self._probes)
        return max(left / PROBES, 1.0)  # the estimate is not good enough to tell less from none

    def _left(self, x: Floats, errors: Floats) -> Floats:
        """``(I - H) e``, H being that of the last fit; raises SingularMatrix."""
        energy, lengths = self._energy, self._metric.lengths
        return errors - energy.rates(x, lengths, self._solve(energy.forces(x, lengths, errors)))

    def outlier(self, fit: BestFit, error: float, most: float) -> Outlier | None:
        """The length that a fit to the others misses by the most deviations, if these are more than `most`.

        The fit is the last one.  The residual of that to the others is ``r_e / (1 - H_ee)``, of deviation
        ``s / sqrt(1 - H_ee)``; s is estimated from its other residuals, but no less than the error.  Only the
        `CANDIDATES` with the largest residuals are looked at.
        """
        if not fit.score < np.inf or np.isinf(most):
            return None
        r = self._energy.residuals(fit.vertices, self._metric.lengths)
        found = None
        large = np.argsort(-np.abs(r))[:CANDIDATES]
        for e in large[np.abs(r[large]) > np.sqrt(REDUNDANT) * most * error].tolist():
            column = self._column(fit, e)
            if column is None:
                continue
            redundancy = column[e]
            others = r - r[e] / redundancy * column
            free = max(fit.degrees_of_freedom - column @ column / redundancy, 1.0)
            deviation = max(error, np.sqrt(others @ others / free))
            studentized = abs(r[e]) / np.sqrt(redundancy) / deviation
            if studentized > most and deviation < DOUBT * error:
                found, most = Outlier(e, float(r[e] / redundancy)), studentized
        return found

    def missed(self, fit: BestFit, edge: int) -> float:
        """Excess of an edge on a fit to the other lengths; 0 if these do not tell.  The fit is the last."""
        column = self._column(fit, edge)
        r = self._energy.residuals(fit.vertices, self._metric.lengths)
        return 0.0 if column is None else float(r[edge] / column[edge])

    def persists(self, fit: BestFit, outlier: Outlier) -> bool:
        """Whether the last fit, of a smaller mu, misses a length by as much as the one before.

        What a fit has smoothed away shrinks, to two thirds with a third of mu; an error of a length does not.
        """
        return abs(self.missed(fit, outlier.edge)) > PERSISTENT * abs(outlier.missed)

    def _column(self, fit: BestFit, edge: int) -> Floats | None:
        """A column of ``I - H``, None if the other lengths do not contradict this one."""
        unit = np.zeros(len(self._metric.lengths))
        unit[edge] = 1.0
        try:
            column = self._left(fit.vertices, unit)
        except SingularMatrix:
            return None
        return column if column[edge] >= REDUNDANT else None
