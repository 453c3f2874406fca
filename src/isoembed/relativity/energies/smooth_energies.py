"""Quasi-local energies of a smooth embedding by spectral quadrature, with errors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats
from isoembed.meshing.sphere import gauss_rule
from isoembed.relativity.energies.energies import Energies, Integrals, norm_hindrance
from isoembed.relativity.horizons.spin import Spin
from isoembed.relativity.spacetimes.surface_data import SurfaceData, error_of, momentum_of, values_of
from isoembed.smooth.embedding import SmoothEmbedding
from isoembed.smooth.isometry import SYMMETRIC_ANGLES
from isoembed.smooth.sphere_map import SphereMap
from isoembed.smooth.two_metric import area_density, is_axisymmetric, is_symmetric_about_z
from isoembed.smooth.uncertain import Uncertainty
from isoembed.surface.estimate import Estimate

ROUNDING = 3e-14  # relative rounding error of sums over many nodes
RTOL = 3e-13  # relative change of a converged integral with more nodes
GROWTH = 1.5  # ratio of successive numbers of circles of nodes
FEWEST_HEIGHTS = 32  # initial number of circles of nodes
SCATTER = 0.5  # least ratio of the standard deviation to the largest error


def smooth_energies(
    data: SurfaceData, embedding: SmoothEmbedding, spin: Spin | None = None, *, curvature_error: float = 0.0
) -> Energies:
    """Energies of a surface with a smooth embedding.

    Parameters
    ----------
    data : SurfaceData
    embedding : SmoothEmbedding
        Embedding of ``data.metric``.
    spin : Spin, optional
        Spin of the surface; its J enters the Christodoulou mass of a horizon.
    curvature_error : float
        Error of the curvature k of space, in 1/length^2.

    Notes
    -----
    The error of the quadrature is the change from fewer nodes; that of int k0 dA is twice the
    ``curvature_error`` of the embedding; errors of lengths contribute to every integral.

    For a given metric ``d int H dA / dk = -3/2 V - k dV/dk``, with V the volume, by the Schlaefli formula for
    the change of int H dA - V of surfaces with metric -k q in space of curvature -1.  As V increases with k,
    the first term is a bound for k <= 0.
    """
    n = first_heights(embedding)
    values, notes = _integrated(data, n, is_symmetric(data, embedding), embedding.coordinates)
    reference = 2.0 * embedding.integrated_mean_curvature
    relative = ROUNDING + data.lengths_error.mean + data.displacement
    error = 2.0 * embedding.curvature_error + relative * abs(reference)
    error += 3.0 * embedding.volume * curvature_error
    k = embedding.space.curvature
    allowed = max(1e-6 * abs(k), curvature_error)  # tolerance for K below the curvature of space
    if embedding.converged and embedding.least_curvature - k < -allowed:
        below = f"less than the {k:.3g} of space" if k else "negative"
        notes.append(
            f"the Gaussian curvature is {below} in places, least {embedding.least_curvature:.3g}: other "
            "embeddings, with other energies, cannot be excluded (a dimple and its reflection have the same "
            "metric, for one, and either may have been found)"
        )
    if not embedding.converged:
        error += embedding.residual * abs(reference)
        notes.append(f"a best fit, not an embedding: lengths differ by up to {embedding.residual:.1e}")
    return _energies(data, {**values, "reference": Estimate(reference, error)}, notes, spin)


def intrinsic_energies(data: SurfaceData, spin: Spin | None = None) -> Energies:
    """Energies of a surface that require no embedding."""
    symmetric = is_axisymmetric(data.metric) and _lies_symmetrically(data)
    return _energies(data, *_integrated(data, FEWEST_HEIGHTS, symmetric), spin)


def is_symmetric(data: SurfaceData, embedding: SmoothEmbedding) -> bool:
    """Whether embedding, k and p are symmetric about the z-axis of the directions of the embedding."""
    harmonics = embedding.harmonics
    return harmonics.order < harmonics.degree and _lies_symmetrically(data, embedding.coordinates)


def _lies_symmetrically(data: SurfaceData, coordinates: SphereMap | None = None) -> bool:
    """Whether k and p are symmetric about the z-axis, of the coordinates if given."""

    def symmetric(name: str, function: Callable[[Floats], Floats]) -> bool:
        if coordinates is None:
            return is_symmetric_about_z(lambda u: values_of(function, u, name))
        return is_symmetric_about_z(lambda v: values_of(function, coordinates.forward(v), name))

    named = {"the mean curvature": data.mean_curvature, "the momentum": data.momentum}
    return all(function is None or symmetric(name, function) for name, function in named.items())


def _energies(
    data: SurfaceData, values: dict[str, Estimate], notes: list[str], spin: Spin | None
) -> Energies:
    about = data.angular_momentum
    if spin is None or (about is not None and data.axis is None):
        J: Estimate | float | None = about
    else:
        J = spin.J + Estimate(data.electromagnetic_angular_momentum or 0.0, 0.0)
        if data.marginal and data.charge and data.electromagnetic_angular_momentum is None:
            notes.append(
                "the electromagnetic part of J is unknown: the Christodoulou mass and J / M^2 use the part "
                "of K_ij only"
            )
    if data.marginal and J is None:
        notes.append("J and the Christodoulou mass are unknown: they require K(., n), j_t and j_p in a file")
    if spin is not None and data.axis is not None and about is not None and spin.misses(about):
        notes.append(
            f"about the axis that was given J is {about:.6g}, "
            f"and {spin.J.value:.6g} about the one that was found"
        )
    return Energies.of(
        Integrals(**values),
        angular_momentum=J if data.marginal else None,
        charge=data.charge,
        notes=(*data.notes, *notes),
    )


def _integrated(
    data: SurfaceData, n: int, symmetric: bool, coordinates: SphereMap | None = None
) -> tuple[dict[str, Estimate], list[str]]:
    """Integrals over the surface by their names in `Integrals`, and reasons for missing ones.

    The number of circles of nodes is increased until the integrals converge or a limit is reached.  With
    axial symmetry the nodes are rotated each time, to detect departures from symmetry.
    """
    relative = ROUNDING + data.lengths_error.mean + data.displacement
    max_heights = most_heights(symmetric)
    settled: dict[str, Estimate] = {}
    before: dict[str, Estimate] = {}
    turned = False
    while True:
        nodes = _Nodes.of(data, *sphere_rule(n, symmetric, coordinates, turned))
        values, notes = nodes.integrals(relative)
        last = GROWTH * n > max_heights
        for name in values.keys() - settled.keys():
            value, error = values[name].value, values[name].error
            change = abs(value - before[name].value) if name in before else np.inf
            if last and name not in before:
                change = 0.0  # the integral was undefined with fewer nodes
            if last or change <= max(RTOL * abs(value), error):
                settled[name] = Estimate(value, change + error)
        if last or settled.keys() == values.keys():
            return settled, notes
        n, before, turned = int(GROWTH * n), values, not turned


def first_heights(embedding: SmoothEmbedding) -> int:
    """Initial number of circles of nodes on an embedded surface."""
    return max(FEWEST_HEIGHTS, int(GROWTH * embedding.harmonics.degree))


def most_heights(symmetric: bool) -> int:
    """Largest number of circles of nodes."""
    return 6000 if symmetric else 256


def sphere_rule(
    n: int, symmetric: bool, coordinates: SphereMap | None, turned: bool = False
) -> tuple[Floats, Floats]:
    """Nodes u (m, 3) on n circles, with few nodes each about an axis of symmetry, and quadrature weights.

    Rotated nodes lie midway between the others.
    """
    around = SYMMETRIC_ANGLES if symmetric else 2 * n
    v, weights = gauss_rule(n, around)
    if turned:
        c, s = np.cos(np.pi / around), np.sin(np.pi / around)
        v = v @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    if coordinates is None:
        return v, weights
    return coordinates.forward(v), weights * coordinates.jacobian(v)


@dataclass(frozen=True)
class _Nodes:
    """Data at the nodes u (n, 3) of a quadrature."""

    u: Floats
    dA: Floats
    k: Floats | None
    p: Floats
    k_error: Uncertainty
    p_error: Uncertainty
    marginal: bool
    doubtful: bool

    @classmethod
    def of(cls, data: SurfaceData, u: Floats, weights: Floats) -> _Nodes:
        k = None if data.mean_curvature is None else values_of(data.mean_curvature, u, "the mean curvature")
        p = momentum_of(data, u)
        dA = weights * area_density(data.metric.tensor(u))
        errors = error_of(data.mean_curvature), error_of(data.momentum)
        return cls(u, dA, k, p, *errors, data.marginal, data.doubtful)

    def integrals(self, relative: float) -> tuple[dict[str, Estimate], list[str]]:
        """Integrals by their names in `Integrals`, and reasons for missing ones."""
        area = float(self.dA.sum())
        values, notes = {"area": Estimate(area, 2.0 * relative * area)}, []
        if self.k is not None:
            error = 2.0 * relative * _sum(self.dA, np.abs(self.k)) + self.k_error.mean * area
            values["k"] = Estimate(_sum(self.dA, self.k), error)
        else:
            notes.append("k is not given: there is no Brown-York energy")
        if self.marginal and not (self.doubtful and self.k is not None):
            return {**values, "norm": Estimate(0.0, 0.0), "squared": Estimate(0.0, 0.0)}, notes
        if self.k is None:
            return values, notes
        if self.marginal:
            size = np.abs(self.k**2 - self.p**2)
            values["squared"] = Estimate(0.0, _sum(self.dA, size))
            return {**values, "norm": Estimate(0.0, _sum(self.dA, np.sqrt(size)))}, notes
        squared, smooth = self.k**2 - self.p**2, 2.0 * relative * (self.k**2 + self.p**2)
        # Noise that averages out in k and p remains in their squares.
        spread = SCATTER**2 * (self.k_error.pointwise**2 + self.p_error.pointwise**2)
        smooth = smooth + self._shift(self.k_error.mean, self.p_error.mean)
        anywhere = smooth + self._shift(self.k_error.pointwise, self.p_error.pointwise) + spread
        values["squared"] = Estimate(_sum(self.dA, squared), _sum(self.dA, smooth) + spread * area)
        # Negative values of smaller magnitude relative to the largest k^2 or k are rounding.
        trapped, largest = 1e-9, float(np.abs(self.k).max())
        allowed = (
            max(trapped * largest, self.k_error.pointwise),
            max(trapped * largest**2, float(anywhere.max())),
        )
        hindrance = norm_hindrance(self.k, squared, self._place, allowed)
        if hindrance:
            return values, [*notes, hindrance]
        values["norm"] = self._norm(squared, smooth, anywhere)
        return values, notes

    def _shift(self, k: float, p: float) -> Floats:
        """First-order change of ``k^2 - p^2`` from errors of k and p."""
        assert self.k is not None
        return 2.0 * (np.abs(self.k) * k + np.abs(self.p) * p)

    def _norm(self, squared: Floats, smooth: Floats, anywhere: Floats) -> Estimate:
        """``int sqrt(k^2 - p^2)`` with its error, from averaged errors and the curvature of the root."""
        middle, low, high, lower, upper = (
            np.sqrt(np.maximum(squared + shift, 0.0))
            for shift in (0.0, -smooth, smooth, -SCATTER * anywhere, SCATTER * anywhere)
        )
        bend = np.abs(0.5 * (lower + upper) - middle)
        return Estimate(_sum(self.dA, middle), _sum(self.dA, high - low + bend))

    def _place(self, i: int) -> str:
        x, y, z = self.u[i]
        return f"theta = {np.arccos(z):.3f}, phi = {np.arctan2(y, x) % (2.0 * np.pi):.3f}"


def _sum(weights: Floats, values: Floats) -> float:
    return float(weights @ values)
