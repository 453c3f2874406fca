"""The Gaussian curvature of a metric with errors: the degrees above the noise, and its deviations."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.smooth.geodesics import in_own_unit
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.spectral_curvature import PAIRS, curvature_of_derivatives, metric_series
from isoembed.smooth.sphere_transform import SphereTransform
from isoembed.smooth.two_metric import TwoMetric


@runtime_checkable
class DeviatingMetric(TwoMetric, Protocol):
    """A metric that tells what it may be off by."""

    def deviations(self, u: Floats) -> tuple[Floats, ...]:
        """Changes (N, n, 3, 3) of the tensor at u (n, 3), for each independent source of errors.

        They are drawn at random: the root of their mean square is a standard deviation.
        """
        ...


@dataclass(frozen=True)
class UncertainCurvature:
    """The Gaussian curvature of a metric, in harmonics of the degrees that are above the noise.

    Attributes
    ----------
    harmonics : Harmonics
    coefficients : ndarray, shape (size,)
        Of K, in 1/length^2.
    u : ndarray, shape (n, 3)
        Nodes, dense enough for the harmonics.
    values : ndarray, shape (n,)
        K there.
    deviations : tuple of ndarray, shape (N, n)
        What K may be off by there, for each source of errors; see `DeviatingMetric`.
    cut : ndarray, shape (n,)
        The part of the highest two degrees that were kept, a measure of those that were cut off; zero if
        none was.
    """

    harmonics: Harmonics
    coefficients: Floats
    u: Floats
    values: Floats
    deviations: tuple[Floats, ...]
    cut: Floats

    @classmethod
    def of(cls, metric: DeviatingMetric) -> UncertainCurvature:
        """Curvature of a metric whose deviations are known.

        Raises
        ------
        InvalidMetric
            What the metric raises.

        Notes
        -----
        Derivatives of degree l multiply noise by l^2, and the degrees of K fall exponentially where the
        metric is analytic: from some degree on there is only noise, which the least K would collect.
        """
        unit, own = in_own_unit(metric)
        harmonics, coefficients, _ = metric_series(own, 0.0)
        n = max(harmonics.degree + 8, 64)  # three degrees apart at most, for the least K among the nodes
        full = harmonics.order == harmonics.degree
        transform = SphereTransform(harmonics, n, 2 * n if full else 2 * harmonics.order + 4)

        def curvature(series: Floats) -> Floats:
            return curvature_of_derivatives(
                transform.u,
                transform.values(series),
                transform.gradients(series),
                transform.hessians(series),
            )

        def changed(tensor: Floats) -> Floats:
            change = tensor[:, PAIRS[0], PAIRS[1]] / unit / unit
            return curvature(coefficients + transform.analysis(change)) - values

        values = curvature(coefficients)
        series = transform.analysis(values[:, None])
        deviations = [
            transform.analysis(np.stack([changed(tensor) for tensor in source], axis=1))
            for source in metric.deviations(transform.u)
        ]
        degrees = harmonics.labels[0]
        last = _last_above_noise(degrees, series, deviations)
        kept = (degrees <= last)[:, None]
        highest = kept & (degrees > last - 2)[:, None] if last < harmonics.degree else 0.0 * kept
        scale = 1.0 / unit / unit
        return cls(
            harmonics,
            scale * (kept * series)[:, 0],
            transform.u,
            scale * transform.values(kept * series)[:, 0],
            tuple(scale * transform.values(kept * source).T for source in deviations),
            scale * np.abs(transform.values(highest * series)[:, 0]),
        )

    def __call__(self, u: Floats) -> Floats:
        """K (n,) at the unit vectors u (n, 3)."""
        return self.harmonics.derivatives(u, self.coefficients)[0]


def _last_above_noise(degrees: Indices, series: Floats, deviations: list[Floats]) -> int:
    """The highest degree in which coefficients (size, 1) are larger than deviations (size, N)."""
    noise = sum((np.mean(source**2, axis=1) for source in deviations), np.zeros(len(series)))
    power, of_noise = (np.bincount(degrees, squares) for squares in (series[:, 0] ** 2, noise))
    seen = np.flatnonzero(power > 4.0 * of_noise)  # twice the size
    return int(seen.max(initial=0))
