"""Bondarescu, Alcubierre and Seidel (2002): three functions in spherical harmonics whose metric fits best.

Theirs: the squared differences between the components of the given metric and of the metric that X induces,
summed over the sphere, are minimized in the space of the coefficients of X; where the residual is too large,
there are more coefficients.  Here the components are those in frames that are orthonormal in the given
metric, the sum is a Gauss rule weighted by its area, and the minimizer is the quasi-Newton method L-BFGS with
exact derivatives.  As in theirs, there is no guide but the start.

References
----------
M. Bondarescu, M. Alcubierre and E. Seidel, Isometric embeddings of black hole horizons in three-dimensional
flat space, Class. Quantum Grav. 19 (2002) 375, arXiv:gr-qc/0109093.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from isoembed import InvalidParameter
from isoembed.smooth import Harmonics, TwoMetric
from reproduction.arrays import Floats
from reproduction.baselines.isometry import IsometrySystem, strains

DECAY = 2  # bumps of degree l are as high as (l + 1)^-DECAY
ITERATIONS = 1500  # of L-BFGS, at most
MEMORY = 20  # steps that L-BFGS keeps
FLAT = 1e-15  # relative decrease of the sum of squares at which L-BFGS ends


@dataclass(frozen=True, eq=False)
class HarmonicMap:
    """A map X from the sphere into R^3 that was fitted to a metric.

    Attributes
    ----------
    harmonics : Harmonics
    coefficients : ndarray, shape (size, 3)
    strain : float
        Root mean square, over the area, of the differences of the metric's components in orthonormal frames.
    iterations : int
    settled : bool
        Whether the minimizer stopped because the sum of squares did not fall any more.
    """

    harmonics: Harmonics
    coefficients: Floats
    strain: float
    iterations: int
    settled: bool

    def points(self, u: Floats) -> Floats:
        """X (n, 3) at unit vectors u (n, 3)."""
        return np.asarray(self.harmonics.values(u) @ self.coefficients)


def sphere(metric: TwoMetric, harmonics: Harmonics, bumps: float = 0.0, seed: int = 0) -> Floats:
    """A start: the coefficients (size, 3) of the round sphere with the metric's area, X = R u.

    Parameters
    ----------
    metric : TwoMetric
    harmonics : Harmonics
        Of degree and order 1 at least.
    bumps : float
        Root mean square of a random displacement over the radius; higher degrees have lower bumps.
    seed : int
        Of the displacement.

    Raises
    ------
    InvalidParameter
        The harmonics do not reach degree and order 1.
    """
    if harmonics.order < 1:
        raise InvalidParameter(f"harmonics of order {harmonics.order} hold no sphere: order 1 is the least")
    radius = IsometrySystem.of(metric, Harmonics(1, 1)).unit
    degrees, orders = harmonics.labels
    C = np.zeros((harmonics.size, 3))
    for axis, order in enumerate((1, -1, 0)):  # x, y and z
        C[(degrees == 1) & (orders == order), axis] = np.sqrt(4.0 * np.pi / 3.0)
    random = np.random.default_rng(seed).standard_normal(C.shape) / (degrees[:, None] + 1.0) ** DECAY
    random[0] = 0.0
    random *= np.sqrt(4.0 * np.pi) / np.linalg.norm(random)
    return radius * (C + bumps * random)


def fit_harmonics(metric: TwoMetric, harmonics: Harmonics, start: Floats) -> HarmonicMap:
    """Minimize the mean square of the differences of the metrics from a start.

    Parameters
    ----------
    metric : TwoMetric
    harmonics : Harmonics
    start : ndarray, shape (size, 3)
        Coefficients, such as those of a `sphere`.

    Returns
    -------
    HarmonicMap
        Where the minimizer has ended, be it the least value or not.

    Raises
    ------
    InvalidParameter
        The start has another shape.
    """
    if start.shape != (harmonics.size, 3):
        raise InvalidParameter(f"the start has the shape {start.shape}, not ({harmonics.size}, 3)")
    system = IsometrySystem.of(metric, harmonics)
    weights = system.root**2

    def mean_square(x: Floats) -> tuple[float, Floats]:
        """The sum of squares and its derivatives by the coefficients, the constant harmonic left out."""
        tangents = system.B @ x.reshape(-1, 3)
        s = strains(tangents)
        X1, X2 = tangents[:, 0], tangents[:, 1]
        ws = weights[:, None] * s
        across = np.sqrt(2.0) * ws[:, 1, None]
        first, second = 2.0 * ws[:, 0, None] * X1 + across * X2, 2.0 * ws[:, 2, None] * X2 + across * X1
        slope = 2.0 * (system.B[:, 0].T @ first + system.B[:, 1].T @ second)
        return float((ws * s).sum()), slope.ravel()

    found = minimize(
        mean_square,
        (start[1:] / system.unit).ravel(),
        jac=True,
        method="L-BFGS-B",
        options={
            "maxiter": ITERATIONS,
            "maxfun": 2 * ITERATIONS,
            "maxcor": MEMORY,
            "ftol": FLAT,
            "gtol": 0.0,
        },
    )
    C = np.concatenate([start[:1], system.unit * found.x.reshape(-1, 3)])
    return HarmonicMap(harmonics, C, float(np.sqrt(found.fun)), int(found.nit), bool(found.success))


def projected(points: Floats, u: Floats, harmonics: Harmonics) -> Floats:
    """The coefficients (size, 3) of the best map through points (n, 3) that unit vectors u (n, 3) name."""
    return np.asarray(np.linalg.lstsq(harmonics.values(u), points, rcond=None)[0])
