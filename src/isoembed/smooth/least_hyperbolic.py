"""Least Gaussian curvature of a metric, without bias, and of a hyperbolic space in which it embeds."""

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

DIRECTIONS = 4000  # number of samples of the curvature
SURE = 3.0  # errors in standard deviations


@dataclass(frozen=True)
class LeastHyperbolic:
    """Euclidean or hyperbolic space of least absolute curvature in which a metric is known to embed.

    Attributes
    ----------
    space : Space
        Space of curvature `of_revolution` if the metric is axisymmetric, else `gaussian_curvature`; Euclidean
        space if that is not negative.
    gaussian_curvature : float
        Least Gaussian curvature of the metric, min K.  The metric embeds in spaces of curvature less than
        min K by Pogorelov's theorem, and for min K itself with a surface that need not be smooth where K is
        least (arXiv:1401.6026).  For a metric with errors, an estimate corrected for the bias of the minimum
        of a noisy function.
    of_revolution : float or None
        Greatest curvature of space that admits a surface of revolution with the metric, at least min K; None
        if the metric is not axisymmetric.
    error : float
        Error of the decisive one of the two, from errors of the metric and rounding.
    """

    space: Space
    gaussian_curvature: float
    of_revolution: float | None
    error: float = 0.0

    @property
    def curvature_error(self) -> float:
        """Error of the curvature of the space; for Euclidean space, how negative it may be within errors."""
        if not self.space.is_euclidean:
            return self.error
        return max(0.0, self.error - self._bound)

    @property
    def explanation(self) -> str:
        """Sentence on the space in which the metric embeds, with the reason."""
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
    """Find the hyperbolic space of least absolute curvature in which a metric on the sphere embeds.

    Parameters
    ----------
    metric : TwoMetric
        Metric; its errors are used if it is that of a surface in a slice or on a grid.

    Returns
    -------
    LeastHyperbolic

    Raises
    ------
    InvalidMetric
        The metric is not positive definite somewhere, or not smooth.

    Notes
    -----
    If the Gaussian curvature satisfies K > k everywhere, hyperbolic space of curvature k < 0 has exactly one
    surface with the metric, which is convex (Pogorelov); for K >= k there is one, too [1]_.  Surfaces of
    revolution exist in less curved spaces, with a known bound; no bound is known for other metrics.

    The minimum of a noisy function is biased to low values, as min is concave.  The mean of min(K + d) and
    min(K - d) over deviations d of K, minus min K, estimates this bias, which is removed.  The error of a
    minimum is at most that of the function: three times the root mean square of max |d|, plus the bias and
    the truncation of K.

    References
    ----------
    .. [1] C.-Y. Lin and Y.-K. Wang, "On isometric embeddings into anti-de Sitter spacetimes", Int. Math. Res.
       Not. 2015, 7130; arXiv:1401.6026.
    """
    minimum, spread = _minimum_gaussian_curvature(metric)
    profile = _profile(metric)
    if profile is None:
        space = Space(minimum.value) if minimum.value < 0.0 else EUCLIDEAN
        return LeastHyperbolic(space, minimum.value, None, minimum.error)
    greatest = profile.greatest_curvature
    space = EUCLIDEAN if profile.embeds else Space(greatest)
    # (1 - rho'^2) / rho^2 is a mean of K over the cap inside the circle; for small caps it includes noise of
    # the truncated degrees of K, which doubled the error where it was measured.
    error = profile.greatest_curvature_error + 3.0 * spread
    return LeastHyperbolic(space, minimum.value, greatest, error)


def _profile(metric: TwoMetric) -> AxisymmetricEmbedding | None:
    """Surface of revolution of an axisymmetric metric; None without symmetry or if it is too noisy."""
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


def _minimum_gaussian_curvature(metric: TwoMetric) -> tuple[Estimate, float]:
    """Least K, and the error of K from the errors of the lengths."""
    if isinstance(metric, DeviatingMetric):
        K = UncertainCurvature.of(metric)
        return _unbiased(K), SURE * K.largest
    lengths = getattr(metric, "error", EXACT).pointwise
    smooth = spectral_curvature(metric, lengths)
    u = np.concatenate([fibonacci_directions(DIRECTIONS), [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]])
    error = smooth.error.pointwise
    return Estimate(_lowest(smooth, u, smooth(u)), error), error if lengths > 0.0 else 0.0


def _unbiased(K: UncertainCurvature) -> Estimate:
    """Least K, corrected for the bias of the minimum."""
    values = K.values
    minimum = float(values.min())
    bias = 0.0
    for source in K.deviations:
        ends = [0.5 * float((values + d).min() + (values - d).min()) for d in source]
        bias += float(np.mean(ends)) - minimum
    error = SURE * K.largest
    near = values <= minimum + 2.0 * error
    cut = float(K.cut[near].max(initial=0.0))
    return Estimate(_lowest(K, K.u, values) - bias, error - bias + cut)


def _lowest(K: Callable[[Floats], Floats], u: Floats, values: Floats) -> float:
    """Least value of K, refined from values at dense directions u (n, 3)."""
    minimum = float(values.min())
    for i in np.argsort(values)[:4]:  # start from the lowest samples
        frame = np.stack(angle_frame(u[i : i + 1]))[:, 0]

        def near(step: Floats, start: Floats = u[i], frame: Floats = frame) -> float:
            moved = start + step @ frame
            return float(K((moved / np.linalg.norm(moved))[None, :])[0])

        size = 1.0 / np.sqrt(DIRECTIONS)
        simplex = size * np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
        # The error of the minimum is quadratic in that of its position.
        options = {"xatol": 1e-7, "fatol": 0.0, "initial_simplex": simplex}
        minimum = min(minimum, float(minimize(near, np.zeros(2), method="Nelder-Mead", options=options).fun))
    return minimum
