"""Uniformization in the continuum: a smooth metric is conformal to that of a round sphere.

With ``e^{2u} g`` of constant curvature kbar, ``K - Laplace(u) = kbar e^{2u}``; in harmonics, by Galerkin's
method, and Newton's.  The round metric's embedding are the three eigenfunctions of its Laplacian with the
eigenvalue -2 kbar.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import eigh

from isoembed.smooth import Harmonics, TwoMetric, gaussian_curvature
from reproduction.arrays import Floats
from reproduction.baselines.isometry import IsometrySystem

DENSE = 4  # heights of nodes a degree: the Gaussian curvature varies faster than the metric
STEPS = 30  # of Newton's method, at most
SETTLED = 1e-9  # change of the conformal factor in the last of them
CONFORMAL = slice(1, 4)  # eigenfunctions that Moebius maps of the sphere change u by


@dataclass(frozen=True, eq=False)
class RoundSphere:
    """The round sphere that a metric g is conformal to, of the same area.

    Attributes
    ----------
    harmonics : Harmonics
    factors : ndarray, shape (size,)
        The coefficients of u; ``e^{2u} g`` is round.
    coefficients : ndarray, shape (size, 3)
        Of the embedding of the round metric.
    least_curvature : float
        The least Gaussian curvature of g at the nodes, times the squared radius of the sphere.
    settled : bool
        Whether Newton's method converged.
    """

    harmonics: Harmonics
    factors: Floats
    coefficients: Floats
    least_curvature: float
    settled: bool


def uniformized(metric: TwoMetric, harmonics: Harmonics) -> RoundSphere:
    """The conformal factor and the embedding of the round metric.

    Parameters
    ----------
    metric : TwoMetric
    harmonics : Harmonics
        In which u and the embedding are sought.

    Returns
    -------
    RoundSphere
        One of the solutions that Moebius maps of the sphere make of each other: every Newton step is
        orthogonal to them.

    Raises
    ------
    InvalidMetric
        The metric is not positive definite somewhere.
    """
    system = IsometrySystem.of(metric, harmonics, DENSE * (harmonics.degree + 1))
    K = gaussian_curvature(metric, system.u) * system.unit**2
    area = system.root**2
    total = float(area @ K)  # 1 by Gauss and Bonnet, up to the quadrature
    Y = harmonics.values(system.u)
    stiffness = np.zeros((harmonics.size, harmonics.size))  # the constant harmonic has no derivatives
    for along in np.moveaxis(system.B, 1, 0):
        stiffness[1:, 1:] += along.T @ (area[:, None] * along)

    factors, settled = np.zeros(harmonics.size), False
    for _ in range(STEPS):
        u = Y @ factors
        factors[0] -= 0.5 * np.log(area @ np.exp(2.0 * u)) / Y[0, 0]  # the area is kept
        round_area = area * np.exp(2.0 * (Y @ factors))
        eigenvalues, modes = eigh(stiffness, Y.T @ (round_area[:, None] * Y))
        if settled:
            break
        excess = modes.T @ (Y.T @ (area * K - total * round_area) + stiffness @ factors)
        steps = -excess / (eigenvalues - 2.0 * total)
        steps[CONFORMAL] = 0.0
        change = modes @ steps
        size = float(np.abs(Y @ change).max())
        factors = factors + change / max(1.0, size)
        settled = size < SETTLED

    # Coordinates of the unit sphere have the mean square 1/3.
    C = modes[:, CONFORMAL] / np.sqrt(3.0)
    first, second = np.moveaxis(system.B @ C[1:], 1, 0)
    if area @ np.einsum("ni,ni->n", np.cross(first, second), Y @ C) < 0.0:
        C = -C
    return RoundSphere(harmonics, factors, system.unit * C, float(K.min()), settled)
