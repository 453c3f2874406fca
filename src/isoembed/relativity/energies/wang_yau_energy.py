"""Wang-Yau quasi-local energy, for a given time function or the optimal one."""

from collections.abc import Callable
from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter, NotEmbedded
from isoembed.relativity.energies.smooth_energies import smooth_energies
from isoembed.relativity.energies.time_function import TimeFunction, TimeRaisedMetric
from isoembed.relativity.energies.wang_yau_result import WangYau, inadmissible
from isoembed.relativity.energies.wang_yau_search import Search
from isoembed.relativity.spacetimes.surface_data import SurfaceData
from isoembed.smooth.embedding import SmoothEmbedding
from isoembed.smooth.solve import embed_smooth
from isoembed.smooth.sphere_map import SphereMap
from isoembed.smooth.two_metric import TwoMetric


def wang_yau(
    data: SurfaceData,
    tau: TimeFunction | Floats | Callable[[Floats], ArrayLike] | Literal["optimal"] | None = None,
    *,
    embedding: SmoothEmbedding | None = None,
    degrees: tuple[int, ...] = (2, 4, 6, 8),
    accuracy: float = 1e-9,
) -> WangYau:
    """Wang-Yau energy E(tau) of a surface, for a given or the optimal time function.

    Parameters
    ----------
    data : SurfaceData
        Surface with k, and with p and K(., n) unless they vanish.  Alternatively, ``mean_curvature`` and
        ``normal_momentum`` may be the norm of the mean curvature vector and the connection alpha of the
        normal bundle.
    tau : TimeFunction, ndarray, callable, "optimal" or None
        Time function: an array (size,) of coefficients in all harmonics up to some degree, in the order of
        `Harmonics`; or a callable that takes directions u (n, 3) and returns tau (n,).  None is tau = 0.
        "optimal" minimizes the energy by Newton's method from tau = 0, in spherical harmonics.
    embedding : SmoothEmbedding, optional
        Embedding of ``data.metric`` in Euclidean space, if already computed.  If the metric does not embed,
        a given tau suffices for which ``q + d tau d tau`` does.
    degrees : tuple of int
        Degrees of tau, in order of refinement until the energy converges.
    accuracy : float
        Change of the energy at convergence, relative to the irreducible mass ``sqrt(A / 16 pi)``.

    Returns
    -------
    WangYau

    Raises
    ------
    InvalidParameter
        The mean curvature vector is not spacelike and outward somewhere, so that the energy is not real; or
        the surface is a horizon and tau is not 0.
    NotEmbedded
        The metric, or ``q + d tau d tau`` for a given tau, does not embed, or harmonics of degree 96 do not
        resolve the surface.
    NoMinimum
        The search ended while the energy was still decreasing.

    Notes
    -----
    Signature - + + +, H the trace of the second fundamental form.  The error is the change when X is embedded
    in 3/4 of its harmonics, and that from the next lower degree of tau.

    The energy of a horizon is the limit ``int k0 dA / 8 pi`` of the least energies of surfaces that tend to
    it, whose tau tends to 0; the energy of any other tau has no limit (Zhao, Andersson and Yau).

    References
    ----------
    M.-T. Wang and S.-T. Yau, Phys. Rev. Lett. 102 (2009) 021101; Commun. Math. Phys. 288 (2009) 919;
    B. Zhao, L. Andersson and S.-T. Yau, arXiv:2406.10751.
    """
    if not degrees or min(degrees) < 1:
        raise InvalidParameter(
            f"the degrees of tau are {degrees}: there must be at least one, and all must be positive"
        )
    time = None if isinstance(tau, str) and tau == "optimal" else _time_function(tau)
    at = TimeFunction.zero()
    if embedding is None:
        try:
            embedding = embed_smooth(data.metric, shape=data.shape)
        except NotEmbedded:
            if time is None or not np.any(time.coefficients[1:]):
                raise
            at, embedding = time, embed_smooth(TimeRaisedMetric(data.metric, time))
    if not embedding.space.is_euclidean:
        raise InvalidParameter(
            f"the embedding is in {embedding.space.name} space: the reference here is Minkowski space; see "
            "chen_wang_yau"
        )
    if data.marginal:
        return _limit(data, embedding, time)
    coordinates = embedding.coordinates
    own = at.in_coordinates(coordinates)
    search = Search(_in_directions_of(embedding, data), embedding.in_own_directions, own)
    if time is None:
        found = search.minimum(degrees, accuracy)
    else:
        found = search.result_at(own if time is at else time.in_coordinates(coordinates))
    return found if coordinates is None else _returned(found, data.metric, coordinates)


def _in_directions_of(embedding: SmoothEmbedding, data: SurfaceData) -> SurfaceData:
    """Data as functions of the directions of the harmonics of an embedding."""
    F = embedding.coordinates
    if F is None:
        return data
    moved = data.in_coordinates(F)
    return moved if data.shape is not None else replace(moved, shape=F.forward)


def _returned(found: WangYau, metric: TwoMetric, coordinates: SphereMap) -> WangYau:
    """Result in the original directions u, from one in the directions v of a map u = F(v)."""
    R, notes = coordinates.rotation, found.notes
    if R is None:
        tau = replace(found.tau, coordinates=coordinates)
        notes += ("tau is in harmonics of the directions v of the embedding, u = F(v)",)
    else:
        tau = found.tau.in_coordinates(SphereMap.linear(R.T))
    embedding = replace(found.embedding, metric=TimeRaisedMetric(metric, tau), coordinates=coordinates)
    return replace(found, tau=tau, embedding=embedding, notes=notes)


def _limit(data: SurfaceData, embedding: SmoothEmbedding, time: TimeFunction | None) -> WangYau:
    """Limit of the energies of surfaces that tend to a horizon, where |H| = 0."""
    if time is not None and np.any(time.coefficients[1:]):
        raise InvalidParameter(
            "the mean curvature vector of a horizon is null: the energy of surfaces that tend to it grows "
            "without bound for every tau but 0, for which it tends to int k0 dA / 8 pi"
        )
    energy = smooth_energies(data, embedding).liu_yau
    assert energy is not None
    notes = [
        "the surface is a horizon: this is the limit int k0 dA / 8 pi of the least energies of surfaces that "
        "approach it, for which tau tends to 0 (Zhao, Andersson and Yau, arXiv:2406.10751)"
    ]
    if embedding.least_curvature <= 0.0:
        notes.append(inadmissible(embedding.least_curvature))
    return WangYau(
        energy=energy,
        tau=TimeFunction.zero(),
        embedding=embedding,
        admissible=embedding.least_curvature,
        gradient=0.0,
        least_second_derivative=None,
        embeddings=1,
        notes=tuple(notes),
    )


def _time_function(tau: TimeFunction | Floats | Callable[[Floats], ArrayLike] | str | None) -> TimeFunction:
    if tau is None:
        return TimeFunction.zero()
    if isinstance(tau, TimeFunction):
        return tau
    if isinstance(tau, np.ndarray):
        return TimeFunction.from_array(tau)
    if not callable(tau):
        raise InvalidParameter(f'tau is {tau!r}, not a TimeFunction, an array, a function, "optimal" or None')
    return TimeFunction.of(tau)
