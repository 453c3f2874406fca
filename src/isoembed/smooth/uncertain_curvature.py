"""Gaussian curvature of a noisy metric: spectral truncation and uncertainty."""

from __future__ import annotations

import math
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
    """Metric with an error estimate."""

    def deviations(self, u: Floats) -> tuple[Floats, ...]:
        """Changes (N, n, 3, 3) of the tensor at u (n, 3), for each independent source of errors.

        They are random samples, whose root mean square is a standard deviation.
        """
        ...


@dataclass(frozen=True)
class UncertainCurvature:
    """Gaussian curvature of a metric, in harmonics of the degrees above the noise.

    Attributes
    ----------
    harmonics : Harmonics
    coefficients : ndarray, shape (size,)
        Coefficients of K, in 1/length^2.
    u : ndarray, shape (n, 3)
        Nodes, dense enough for the harmonics.
    values : ndarray, shape (n,)
        K at the nodes.
    deviations : tuple of ndarray, shape (N, n)
        Samples of the error of K at the nodes, for each source of errors; see `DeviatingMetric`.
    cut : ndarray, shape (n,)
        Estimated truncation error, by extrapolation of the decay; zero without truncation.
    """

    harmonics: Harmonics
    coefficients: Floats
    u: Floats
    values: Floats
    deviations: tuple[Floats, ...]
    cut: Floats

    @classmethod
    def of(cls, metric: DeviatingMetric) -> UncertainCurvature:
        """Curvature of a metric with known deviations.

        Raises
        ------
        InvalidMetric
            Raised by the metric.

        Notes
        -----
        Differentiation amplifies noise of degree l by l^2, while K decays exponentially with the degree if
        the metric is analytic: beyond some degree there is only noise, which would bias the least K.
        """
        unit, own = in_own_unit(metric)
        harmonics, coefficients, settled = metric_series(own, 0.0)
        n = max(harmonics.degree + 8, 64)  # spacing of at most three degrees (angle), for the least K
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
        spectrum = _Spectrum(harmonics, series, deviations)
        if not settled:
            deviations = [scale * source for scale, source in zip(spectrum.scales, deviations, strict=True)]
            spectrum = _Spectrum(harmonics, series, deviations)
        degrees, last = harmonics.labels[0], spectrum.last
        retained = (degrees <= last)[:, None]
        highest = spectrum.beyond * (retained & (degrees > last - 2)[:, None])
        scale = 1.0 / unit / unit
        return cls(
            harmonics,
            scale * (retained * series)[:, 0],
            transform.u,
            scale * transform.values(retained * series)[:, 0],
            tuple(scale * transform.values(retained * source).T for source in deviations),
            scale * np.abs(transform.values(highest * series)[:, 0]),
        )

    @property
    def largest(self) -> float:
        """Root mean square of the largest deviation, for all sources together."""
        sizes = [np.abs(source).max(axis=1) / np.sqrt(len(source)) for source in self.deviations]
        return math.hypot(*(float(size) for source in sizes for size in source))  # without overflow

    def __call__(self, u: Floats) -> Floats:
        """K (n,) at unit vectors u (n, 3)."""
        return self.harmonics.derivatives(u, self.coefficients)[0]


class _Spectrum:
    """Power spectra of K and of its deviations by degree."""

    def __init__(self, harmonics: Harmonics, series: Floats, deviations: list[Floats]) -> None:
        degrees = harmonics.labels[0]
        self.power = _by_degree(degrees, series[:, 0] ** 2)
        self.sources = [_by_degree(degrees, np.mean(source**2, axis=1)) for source in deviations]
        self.noise = sum(self.sources, np.zeros(len(self.power)))

    @property
    def scales(self) -> list[float]:
        """Factors, at least 1, that scale the sources to the power of K in high degrees.

        Sources may underestimate their size; an unresolved K consists of errors in high degrees.
        """
        high = slice(2 * len(self.power) // 3, None)
        power, noise = (float(np.median(values[high])) for values in (self.power, self.noise))
        return [
            max(1.0, float(np.sqrt(power / noise))) if np.median(source[high]) > 0.1 * noise else 1.0
            for source in self.sources
        ]

    @property
    def last(self) -> int:
        """Highest degree that, together with the previous one, has twice the amplitude of the noise.

        Degrees are paired because every other one may vanish by symmetry.
        """
        return int(np.flatnonzero(_pairs(self.power) > 4.0 * _pairs(self.noise)).max(initial=0))

    @property
    def beyond(self) -> float:
        """Estimated ratio of all truncated degrees to the last two, by geometric extrapolation."""
        last, pairs = self.last, _pairs(self.power)
        if last + 1 == len(pairs):
            return 0.0
        before = float(pairs[max(last - 2, 0)])
        ratio = min(np.sqrt(float(pairs[last]) / before), 0.9) if before > 0.0 else 0.9
        return float(ratio / (1.0 - ratio))


def _by_degree(degrees: Indices, squares: Floats) -> Floats:
    """Sums of squares (size,) over the orders of each degree."""
    return np.bincount(degrees, squares).astype(np.float64)


def _pairs(squares: Floats) -> Floats:
    """Sums of each degree and the previous one."""
    return squares + np.concatenate([[0.0], squares[:-1]])
