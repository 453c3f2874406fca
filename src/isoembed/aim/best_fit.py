"""The best fit to lengths that no smooth surface has: as near to them as a smooth surface comes.

Errors of the lengths make dimples, and where they are larger than the curvature allows, no surface at all.
The best fit minimizes

    ``|r|^2 + mu |R x|^2``,

r the errors of the lengths and R the roughness, as in `isoembed.aim.regularized_continuation`.  Were it
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

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from isoembed.aim.regularized_continuation import Guide
from isoembed.linalg import SingularMatrix
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.progress.stages import StageRecorder
from isoembed.surface.rigidity import edge_rows, length_residuals

Floats = NDArray[np.float64]

WEIGHT = 10.0  # mu at first: so smooth that the surface comes from afar without being caught by dimples
FACTOR = 10.0  # from one mu to the next: the score has a broad minimum
LEVELS = 8  # such steps at most, down or up
BETTER = 0.995  # of the best score so far, or less, is worth another mu
SETTLED = 0.99  # of the energy is left, or more, after a step: the surface is where it belongs
STEPS = 8  # at most, for each mu
COLLAPSED = 0.3  # mean edge lengths: a surface that misses as much on average has lost its shape
PROBES = 4  # random vectors that estimate the degrees of freedom, to a percent or so


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
    """

    vertices: Floats
    weight: float
    noise: float


def best_fit(
    metric: PolyhedralMetric, start: Floats, recorder: StageRecorder, backend: str | None = None
) -> BestFit | None:
    """Fit a smooth surface to the lengths of a metric.

    Parameters
    ----------
    metric : PolyhedralMetric
        Of mean edge length 1 or so.
    start : ndarray, shape (V, 3)
        A smooth surface of about this shape and size, such as the polyhedron of the waypoint.
    recorder : StageRecorder
        Counts Gauss-Newton steps and factorizations.
    backend : str, optional
        As in `isoembed.linalg.analyze`.

    Returns
    -------
    BestFit or None
        None if nothing as smooth comes near to the lengths.
    """
    fits = _Fits(metric, start, recorder, backend)
    best = first = fits.fit(start, WEIGHT)
    for direction in (-1, 1):
        last = first
        for level in range(1, LEVELS + 1):
            last = fits.fit(last.vertices, WEIGHT * FACTOR ** (direction * level))
            if not last.score < BETTER * best.score:
                break
            best = last
        if best is not first:
            break
    a, b = metric.edges.T
    missed = np.linalg.norm(best.vertices[a] - best.vertices[b], axis=1) - metric.lengths
    if not (best.score < np.inf and np.sqrt(np.mean(missed**2)) < COLLAPSED * metric.mean_length):
        return None
    return BestFit(best.vertices, best.weight, best.noise)


@dataclass(frozen=True)
class _Fit:
    """The fit for one mu, the noise that it sees, and its score by cross-validation."""

    vertices: Floats
    weight: float
    noise: float
    score: float


class _Fits:
    """Fits to one metric for any mu."""

    def __init__(
        self, metric: PolyhedralMetric, start: Floats, recorder: StageRecorder, backend: str | None
    ) -> None:
        self._guide = Guide(metric, start, backend)
        self._triangulation, self._lengths = metric.triangulation, metric.lengths
        self._unit = metric.mean_length
        self._recorder = recorder
        self._probes = np.random.default_rng(0).choice([-1.0, 1.0], size=(PROBES, len(metric.lengths)))

    def fit(self, vertices: Floats, weight: float) -> _Fit:
        """The fit nearest to these vertices, with mu in units of the squared mean edge length."""
        mu = weight * self._unit**2
        x, energy = vertices, self._energy(vertices, mu)
        for _ in range(STEPS):
            x = self._guide.relaxed(x, self._lengths, mu, 0.0, self._recorder)
            before, energy = energy, self._energy(x, mu)
            if not energy < SETTLED * before:
                break
        r = length_residuals(self._triangulation, x, self._lengths)
        try:
            free = self._degrees_of_freedom(x, mu)
        except SingularMatrix:
            return _Fit(x, weight, np.inf, np.inf)
        noise = float(np.sqrt(r @ r / free)) / self._unit
        return _Fit(x, weight, noise, noise / np.sqrt(free))

    def _energy(self, x: Floats, mu: float) -> float:
        r = length_residuals(self._triangulation, x, self._lengths)
        return float(r @ r + mu * np.sum(x * self._guide.roughness(x, 0.0)))

    def _degrees_of_freedom(self, x: Floats, mu: float) -> float:
        """Trace of ``I - H``, which takes errors of the lengths to what the fit leaves of them.

        ``H = J (J^T J + mu R^T R)^-1 J^T``.  Its trace is estimated by random vectors (Girard): the mean of
        ``z^T (I - H) z``, with z of random signs.
        """
        triangulation = self._triangulation
        rows = edge_rows(triangulation, x, self._lengths)
        self._recorder.factorizations += 1
        solve = self._guide.solver(x, self._lengths, mu, 0.0)
        a, b = triangulation.edges.T
        left = 0.0
        for z in self._probes:
            d = solve(triangulation.incidence @ (rows * z[:, None]))
            left += float(z @ (z - np.einsum("ij,ij->i", rows, d[a] - d[b])))
        return max(left / PROBES, 1.0)  # the estimate is not good enough to tell less from none
