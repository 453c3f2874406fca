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
    """A metric with an error estimate."""

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
        Estimated size of the degrees that were cut off, as they fall like those before; zero if none was.
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
        harmonics, coefficients, settled = metric_series(own, 0.0)
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
        spectrum = _Spectrum(harmonics, series, deviations)
        if not settled:
            deviations = [scale * source for scale, source in zip(spectrum.scales, deviations, strict=True)]
            spectrum = _Spectrum(harmonics, series, deviations)
        degrees, last = harmonics.labels[0], spectrum.last
        kept = (degrees <= last)[:, None]
        highest = spectrum.beyond * (kept & (degrees > last - 2)[:, None])
        scale = 1.0 / unit / unit
        return cls(
            harmonics,
            scale * (kept * series)[:, 0],
            transform.u,
            scale * transform.values(kept * series)[:, 0],
            tuple(scale * transform.values(kept * source).T for source in deviations),
            scale * np.abs(transform.values(highest * series)[:, 0]),
        )

    @property
    def largest(self) -> float:
        """The largest deviation anywhere, for all sources together, in the mean square."""
        sizes = [np.abs(source).max(axis=1) / np.sqrt(len(source)) for source in self.deviations]
        return math.hypot(*(float(size) for source in sizes for size in source))  # which does not overflow

    def __call__(self, u: Floats) -> Floats:
        """K (n,) at the unit vectors u (n, 3)."""
        return self.harmonics.derivatives(u, self.coefficients)[0]


class _Spectrum:
    """Squares of K and of its deviations by degree."""

    def __init__(self, harmonics: Harmonics, series: Floats, deviations: list[Floats]) -> None:
        degrees = harmonics.labels[0]
        self.power = _by_degree(degrees, series[:, 0] ** 2)
        self.sources = [_by_degree(degrees, np.mean(source**2, axis=1)) for source in deviations]
        self.noise = sum(self.sources, np.zeros(len(self.power)))

    @property
    def scales(self) -> list[float]:
        """Factors, at least 1, of the sources, with which there is as much noise in high degrees as is seen.

        What a source says of its size may be too little, but where K has degrees without end they are errors.
        """
        high = slice(2 * len(self.power) // 3, None)
        seen, told = (float(np.median(values[high])) for values in (self.power, self.noise))
        return [
            max(1.0, float(np.sqrt(seen / told))) if np.median(source[high]) > 0.1 * told else 1.0
            for source in self.sources
        ]

    @property
    def last(self) -> int:
        """The highest degree that with the one before is twice as large as noise, which is more than chance.

        Symmetry leaves out every other one, of K as of its deviations.
        """
        return int(np.flatnonzero(_pairs(self.power) > 4.0 * _pairs(self.noise)).max(initial=0))

    @property
    def beyond(self) -> float:
        """All degrees after the last over that and the one before, if they fall as those before."""
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
    """Pairs of each degree and the one before."""
    return squares + np.concatenate([[0.0], squares[:-1]])
