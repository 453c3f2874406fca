"""The least curvature of hyperbolic space that takes a metric."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from isoembed.arrays import Floats
from isoembed.meshing.sphere import fibonacci_directions
from isoembed.smooth.axisymmetric import AxisymmetricEmbedding
from isoembed.smooth.spectral_curvature import spectral_curvature
from isoembed.smooth.sphere_map import SphereMap, metric_in
from isoembed.smooth.symmetry import axis_of_symmetry
from isoembed.smooth.two_metric import TwoMetric, angle_frame
from isoembed.smooth.uncertain import EXACT
from isoembed.space import EUCLIDEAN, Space
from isoembed.thresholds import threshold


@dataclass(frozen=True)
class LeastHyperbolicThresholds:
    """Thresholds of the search for the least Gaussian curvature."""

    directions: int = threshold(4000, "count", "Directions at which it is looked at.")
    polished: int = threshold(4, "count", "Of these, the lowest about which it is made least.")
    position: float = threshold(1e-7, "radians", "Error of the place: that of the value is its square.")


LEAST_HYPERBOLIC = LeastHyperbolicThresholds()


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
        K is least (arXiv:1401.6026).
    of_revolution : float or None
        The greatest curvature of space in which there is a surface of revolution with the metric, at least
        min K; None if the metric is not symmetric about an axis.
    """

    space: Space
    gaussian_curvature: float
    of_revolution: float | None

    @property
    def explanation(self) -> str:
        """A sentence: which space takes the metric, and by what."""
        least = f"the least Gaussian curvature is {self.gaussian_curvature:.9g}"
        if self.space.is_euclidean:
            return f"Euclidean space takes the metric: {least}{self._revolution}"
        return (
            f"hyperbolic space of curvature {self.space.curvature:.9g} takes the metric: {least}"
            f"{self._revolution}"
        )

    @property
    def _revolution(self) -> str:
        if self.of_revolution is None:
            return ""
        return f", and there is a surface of revolution up to the curvature {self.of_revolution:.9g} of space"


def least_hyperbolic(metric: TwoMetric) -> LeastHyperbolic:
    """Find the least curvature of hyperbolic space with which it takes a metric on the sphere.

    Parameters
    ----------
    metric : TwoMetric

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

    References
    ----------
    .. [1] C.-Y. Lin and Y.-K. Wang, "On isometric embeddings into anti-de Sitter spacetimes", Int. Math. Res.
       Not. 2015, 7130; arXiv:1401.6026.
    """
    turn = axis_of_symmetry(metric)
    least = _least_gaussian_curvature(metric)
    if turn is None:
        return LeastHyperbolic(Space(least) if least < 0.0 else EUCLIDEAN, least, None)
    own = metric if np.array_equal(turn, np.eye(3)) else metric_in(metric, SphereMap.linear(turn))
    profile = AxisymmetricEmbedding.of(own)
    greatest = profile.greatest_curvature
    space = EUCLIDEAN if profile.embeds else Space(greatest)
    return LeastHyperbolic(space, least, greatest)


def _least_gaussian_curvature(metric: TwoMetric) -> float:
    t = LEAST_HYPERBOLIC
    K = spectral_curvature(metric, getattr(metric, "error", EXACT).pointwise)
    u = np.concatenate([fibonacci_directions(t.directions), [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]])
    values = K(u)
    least = float(values.min())
    for i in np.argsort(values)[: t.polished]:
        frame = np.stack(angle_frame(u[i : i + 1]))[:, 0]

        def near(step: Floats, start: Floats = u[i], frame: Floats = frame) -> float:
            moved = start + step @ frame
            return float(K((moved / np.linalg.norm(moved))[None, :])[0])

        size = 1.0 / np.sqrt(t.directions)
        simplex = size * np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
        options = {"xatol": t.position, "fatol": 0.0, "initial_simplex": simplex}
        least = min(least, float(minimize(near, np.zeros(2), method="Nelder-Mead", options=options).fun))
    return least
