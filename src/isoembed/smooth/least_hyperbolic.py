"""Least curvature of a hyperbolic space in which a metric embeds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from isoembed.arrays import Floats
from isoembed.errors import InvalidMetric
from isoembed.meshing.sphere import fibonacci_directions
from isoembed.smooth.axisymmetric import AxisymmetricEmbedding
from isoembed.smooth.spectral_curvature import spectral_curvature
from isoembed.smooth.sphere_map import SphereMap, metric_in
from isoembed.smooth.symmetry import axis_of_symmetry
from isoembed.smooth.two_metric import TwoMetric, angle_frame
from isoembed.smooth.uncertain import EXACT
from isoembed.smooth.uncertain_curvature import DeviatingMetric, UncertainCurvature
from isoembed.space import EUCLIDEAN, Space
from isoembed.surface.estimate import Estimate

DIRECTIONS = 4000  # where the curvature is sampled
SURE = 3.0  # standard deviations that errors are


@dataclass(frozen=True)
class LeastHyperbolic:
    """The space of least curvature, Euclidean or hyperbolic, that is known to take a metric.

    Attributes
    ----------
    space : Space
        Of the curvature `of_revolution` if the metric is symmetric about an axis, else `gaussian_curvature`,
        or Euclidean space where these are not negative.
    gaussian_curvature : float
        The least Gaussian curvature of the metric, min K.  A space of this curvature takes the metric: for
        less than min K by Pogorelov's theorem, for min K itself with a surface that need not be smooth where
        K is least (arXiv:1401.6026).  Where the metric has errors, it is an estimate without the bias of the
        least value of noise.
    of_revolution : float or None
        The greatest curvature of space in which there is a surface of revolution with the metric, at least
        min K; None if the metric is not symmetric about an axis.
    error : float
        By how much the one of the two that decides is uncertain: by the errors of the metric, and rounding.
    """

    space: Space
    gaussian_curvature: float
    of_revolution: float | None
    error: float = 0.0

    @property
    def curvature_error(self) -> float:
        """Error of the curvature of the space; for Euclidean space, how negative the curvature may be."""
        if not self.space.is_euclidean:
            return self.error
        return max(0.0, self.error - self._bound)

    @property
    def explanation(self) -> str:
        """A sentence: in which space the metric embeds, and why."""
        if self.of_revolution is None:
            least = f"the least Gaussian curvature is {Estimate(self.gaussian_curvature, self.error)}"
        else:
            bound = Estimate(self.of_revolution, self.error)
            least = (
                f"the least Gaussian curvature is {self.gaussian_curvature:.9g}, and a surface of revolution "
                f"with this metric exists in spaces of curvature up to {bound}"
            )
        if self.space.is_euclidean:
            return f"the metric embeds in Euclidean space: {least}"
        curvature = Estimate(self.space.curvature, self.error)
        return f"the metric embeds in hyperbolic space of curvature {curvature}: {least}"

    @property
    def _bound(self) -> float:
        return self.gaussian_curvature if self.of_revolution is None else self.of_revolution


def least_hyperbolic(metric: TwoMetric) -> LeastHyperbolic:
    """Find the least curvature of hyperbolic space with which it takes a metric on the sphere.

    Parameters
    ----------
    metric : TwoMetric
        Those of surfaces in slices and of grids tell their errors.

    Returns
    -------
    LeastHyperbolic

    Raises
    ------
    InvalidMetric
        The metric is not positive definite somewhere, or not smooth.

    Notes
    -----
    If the Gaussian curvature is K > k everywhere, hyperbolic space of curvature k < 0 has exactly one surface
    with the metric, which is convex (Pogorelov); for K >= k there is one, too [1]_.  Surfaces of revolution
    need less where K < k, which can be said exactly; what other metrics need there is not known.

    The least value of a function with noise is too low, as min is concave: the mean of min(K + d) and
    min(K - d) over deviations d of K is less than min K by an estimate of this bias, which is removed.  No
    minimum is off by more than the function is anywhere: the error is three times the root mean square of
    max |d|, and the bias, and what is cut off with the degrees of K that are noise.

    References
    ----------
    .. [1] C.-Y. Lin and Y.-K. Wang, "On isometric embeddings into anti-de Sitter spacetimes", Int. Math. Res.
       Not. 2015, 7130; arXiv:1401.6026.
    """
    least, spread = _least_gaussian_curvature(metric)
    profile = _profile(metric)
    if profile is None:
        space = Space(least.value) if least.value < 0.0 else EUCLIDEAN
        return LeastHyperbolic(space, least.value, None, least.error)
    greatest = profile.greatest_curvature
    space = EUCLIDEAN if profile.embeds else Space(greatest)
    # (1 - rho'^2) / rho^2 is a mean of K over the cap inside of the circle; that of small caps has noise in
    # degrees that are cut off from K, which doubled it where it was measured.
    error = profile.greatest_curvature_error + 3.0 * spread
    return LeastHyperbolic(space, least.value, greatest, error)


def _profile(metric: TwoMetric) -> AxisymmetricEmbedding | None:
    """The meridian of a metric that is symmetric about an axis, if noise leaves it smooth."""
    turn = axis_of_symmetry(metric)
    if turn is None:
        return None
    own = metric if np.array_equal(turn, np.eye(3)) else metric_in(metric, SphereMap.linear(turn))
    try:
        return AxisymmetricEmbedding.of(own)
    except InvalidMetric:
        if not isinstance(metric, DeviatingMetric):
            raise
        return None


def _least_gaussian_curvature(metric: TwoMetric) -> tuple[Estimate, float]:
    """The least K, and by how much K anywhere is uncertain because the lengths are."""
    if isinstance(metric, DeviatingMetric):
        K = UncertainCurvature.of(metric)
        return _unbiased(K), SURE * K.largest
    lengths = getattr(metric, "error", EXACT).pointwise
    smooth = spectral_curvature(metric, lengths)
    u = np.concatenate([fibonacci_directions(DIRECTIONS), [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]])
    error = smooth.error.pointwise
    return Estimate(_lowest(smooth, u, smooth(u)), error), error if lengths > 0.0 else 0.0


def _unbiased(K: UncertainCurvature) -> Estimate:
    """The least K without the bias of a minimum."""
    values = K.values
    least = float(values.min())
    bias = 0.0
    for source in K.deviations:
        ends = [0.5 * float((values + d).min() + (values - d).min()) for d in source]
        bias += float(np.mean(ends)) - least
    error = SURE * K.largest
    near = values <= least + 2.0 * error
    cut = float(K.cut[near].max(initial=0.0))
    return Estimate(_lowest(K, K.u, values) - bias, error - bias + cut)


def _lowest(K: Callable[[Floats], Floats], u: Floats, values: Floats) -> float:
    """The least value of K, from those at dense directions u (n, 3)."""
    least = float(values.min())
    for i in np.argsort(values)[:4]:  # start from the lowest samples
        frame = np.stack(angle_frame(u[i : i + 1]))[:, 0]

        def near(step: Floats, start: Floats = u[i], frame: Floats = frame) -> float:
            moved = start + step @ frame
            return float(K((moved / np.linalg.norm(moved))[None, :])[0])

        size = 1.0 / np.sqrt(DIRECTIONS)
        simplex = size * np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
        # The error of the value is the square of that of the place.
        options = {"xatol": 1e-7, "fatol": 0.0, "initial_simplex": simplex}
        least = min(least, float(minimize(near, np.zeros(2), method="Nelder-Mead", options=options).fun))
    return least
