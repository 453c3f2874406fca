"""Chen-Wang-Yau energy with an (anti-)de Sitter reference, for tau = 0.

The surface is embedded in the static slice of the reference, hyperbolic or spherical space of curvature
k = cosmological constant / 3.  V, the norm of the static Killing vector, is the cosine `Space.cs` of the
distance from the center of the static observers.  With k0 in that space and |H|^2 = k^2 - p^2,

    8 pi E = int V (k0 - |H|) dA.

With the energy-momentum ``8 pi (p_0, p) = int (w, x) (k0 - |H|) dA``, it is ``w_a p_0 + k a . p`` for
observers about the point (a, w_a).  Observers at rest make it stationary: ``a = p / E`` with
``E^2 = p_0^2 + k |p|^2``, a minimum in anti-de Sitter space and a maximum in de Sitter space.  As k tends to
0, a tends to the center of mass p / p_0.

References
----------
P.-N. Chen, M.-T. Wang, S.-T. Yau, arXiv:1603.02975; M.-T. Wang, S.-T. Yau, Comm. Anal. Geom. 15 (2007) 249,
arXiv:math/0602321 (the energy-momentum).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter
from isoembed.relativity.energies.smooth_energies import (
    FEWEST_HEIGHTS,
    GROWTH,
    RTOL,
    first_heights,
    is_symmetric,
    most_heights,
    smooth_energies,
    sphere_rule,
)
from isoembed.relativity.energies.wang_yau_functional import physical
from isoembed.relativity.spacetimes.surface_data import SurfaceData, momentum_of
from isoembed.reprs import short_repr
from isoembed.smooth.embedding import SmoothEmbedding
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.isometry import MetricSamples
from isoembed.smooth.sphere_transform import SphereTransform
from isoembed.smooth.two_metric import angle_frame, area_density
from isoembed.surface.estimate import Estimate


@short_repr
@dataclass(frozen=True)
class ChenWangYau:
    """Chen-Wang-Yau energy of a surface for observers at rest.

    Attributes
    ----------
    energy : Estimate
        Energy E, in the unit of length.
    momentum : ndarray, shape (4,)
        Energy p_0 for observers about the origin, a length, and p, a length squared.
    center : ndarray, shape (3,)
        Center of the observers at rest, with ambient coordinates x of `isoembed.Space`.
    gradient : float or None
        Norm of the gradient of E in the coefficients of tau at tau = 0, which are lengths; None for a
        horizon, whose mean curvature vector has no direction.
    notes : tuple of str
        Remarks on the interpretation of the energy.
    """

    energy: Estimate
    momentum: Floats
    center: Floats
    gradient: float | None
    notes: tuple[str, ...] = ()

    @property
    def report(self) -> dict[str, Any]:
        """Plain numbers, for JSON."""
        return {
            "momentum": self.momentum.tolist(),
            "center": self.center.tolist(),
            "gradient": self.gradient,
        }


def chen_wang_yau(
    data: SurfaceData, embedding: SmoothEmbedding, *, curvature_error: float = 0.0
) -> ChenWangYau:
    """Wang-Yau energy of a surface for tau = 0, with the static spacetime of its embedding as reference.

    Parameters
    ----------
    data : SurfaceData
        Surface with k, and with p and K(., n) unless they vanish.
    embedding : SmoothEmbedding
        Embedding of ``data.metric`` in hyperbolic or spherical space of curvature cosmological constant / 3;
        in Euclidean space V = 1, and the energy is that of Kijowski, Liu and Yau.
    curvature_error : float
        Error of the curvature of the reference, in 1/length^2.

    Raises
    ------
    InvalidParameter
        The mean curvature vector is not spacelike and outward; the energy-momentum is not timelike; or V is
        not positive on the surface, in de Sitter space.

    Notes
    -----
    The energy of Chen, Wang and Yau is defined for every embedding in the reference, given by a time function
    tau; optimal embeddings are its critical points.  The first derivative at tau = 0 is that of ``int
    V^2 alpha(grad tau) dA / 8 pi``, with alpha the connection of the normal bundle.  It vanishes in
    time-symmetric slices and for axisymmetric surfaces of Kerr spacetimes; see `gradient`.
    """
    plain = smooth_energies(data, embedding)
    radius = float(np.sqrt(plain.area.value / (4.0 * np.pi)))
    if plain.liu_yau is None:
        raise InvalidParameter(next(note for note in reversed(plain.notes) if "k " in note))
    k = embedding.space.curvature
    symmetric = is_symmetric(data, embedding)
    n, before = first_heights(embedding), np.inf
    while True:
        u, weights = sphere_rule(n, symmetric, embedding.coordinates)
        momentum = _momentum(data, embedding, u, weights)
        square = momentum[0] ** 2 + k * float(momentum[1:] @ momentum[1:])
        if not square > 0.0:
            raise InvalidParameter(
                f"the energy-momentum {momentum.tolist()} is not timelike: no static observers are at rest"
            )
        value = float(np.copysign(np.sqrt(square), momentum[0]))
        error, before = abs(value - before), value
        n = int(GROWTH * n)
        if error <= RTOL * radius or (np.isfinite(error) and n > most_heights(symmetric)):
            break
    center = momentum[1:] / value
    potential = _potential(embedding, u, center)
    i = int(np.argmin(potential))
    if not potential[i] > 0.0:
        raise InvalidParameter(
            f"V = {potential[i]:.3g} at u = {u[i].tolist()}: the surface reaches beyond the cosmological "
            "horizon of the static observers"
        )
    # V changes with the curvature, too: on spheres dE/dk is then 2 V times as large.
    by_space = 3.0 * embedding.volume * curvature_error / (8.0 * np.pi)
    error += float(potential.max()) * (plain.liu_yau.error + 2.0 * by_space) + embedding.residual * abs(value)
    gradient, notes = None if data.marginal else _gradient(data, embedding, center), []
    # A smaller derivative in tau, relative to E / areal radius, counts as zero.
    if gradient is not None and gradient > 1e-6 * abs(value) / radius:
        notes.append(
            f"tau = 0 is not critical for the Wang-Yau energy: the norm of its derivatives is {gradient:.3g}"
        )
    return ChenWangYau(Estimate(value, error), momentum, center, gradient, tuple(notes))


def _momentum(data: SurfaceData, embedding: SmoothEmbedding, u: Floats, weights: Floats) -> Floats:
    """Energy-momentum (4,) by quadrature on the sphere."""
    excess = 2.0 * embedding.mean_curvature(u)
    if not data.marginal:
        assert data.mean_curvature is not None
        squared = data.mean_curvature(u) ** 2 - momentum_of(data, u) ** 2
        excess = excess - np.sqrt(np.maximum(squared, 0.0))
    x = embedding.points(u)
    density = weights * area_density(data.metric.tensor(u)) * excess / (8.0 * np.pi)
    return np.append(density @ embedding.space.heights(x), density @ x)


def _potential(embedding: SmoothEmbedding, u: Floats, center: Floats) -> Floats:
    """V (n,) of observers about the center."""
    space, x = embedding.space, embedding.points(u)
    return np.asarray(space.heights(x) * space.heights(center) + space.curvature * (x @ center))


def _gradient(data: SurfaceData, embedding: SmoothEmbedding, center: Floats) -> float:
    """Norm of the gradient of the energy in the coefficients of tau, at tau = 0."""
    n = FEWEST_HEIGHTS
    samples = MetricSamples.of(data.metric, n, 2 * n)
    k, p, alpha = physical(data, samples)
    frames = samples.frames @ np.stack(angle_frame(samples.u), axis=2)
    if np.any(p):  # alpha = K(., n) - d psi
        transform = SphereTransform(Harmonics(n // 2, n // 2), n, 2 * n)
        psi = transform.analysis(np.arctanh(p / k)[:, None])
        alpha = alpha - (frames @ transform.gradients(psi))[:, :, 0]
    weights = samples.areas * _potential(embedding, samples.u, center) ** 2 / (8.0 * np.pi)
    tau = Harmonics(8, 8)  # harmonics of the time functions
    along = np.einsum("nai,nim->nam", samples.frames, tau.gradients(samples.u)[1])
    return float(np.linalg.norm(np.einsum("n,na,nam->m", weights, alpha, along, optimize=True)))
