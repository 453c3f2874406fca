"""Maps of the unit sphere in spherical harmonics: displacement along normals, reparametrization."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.fft import dct

from isoembed.arrays import Floats
from isoembed.relativity.spacetimes.jet import Jet
from isoembed.relativity.spacetimes.surface import Surface
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.sphere_transform import SphereTransform
from isoembed.smooth.transforms import resized

AROUND = 4
"""Number of angles phi for maps symmetric about z, whose coordinates have orders 0 and 1."""


@dataclass(frozen=True, eq=False)
class HarmonicMap:
    """Map X of the unit sphere, with coordinates in spherical harmonics.

    Attributes
    ----------
    harmonics : Harmonics
    coefficients : ndarray, shape (harmonics.size, 3)
        Coefficients of X, lengths.
    """

    harmonics: Harmonics
    coefficients: Floats

    @classmethod
    def projected(cls, surface: Surface, degree: int, *, symmetric: bool) -> HarmonicMap:
        """Projection of a surface, in its own directions."""
        n = 2 * max(degree, surface.harmonics.degree) + 4
        T = SphereTransform(coordinate_harmonics(degree, symmetric), n, AROUND if symmetric else 2 * n)
        return cls(T.harmonics, T.analysis(surface.points(T.u)))

    @property
    def degree(self) -> int:
        """Degree of the harmonics."""
        return self.harmonics.degree

    @property
    def symmetric(self) -> bool:
        """Whether the map is symmetric about z, with orders 0 and 1 only."""
        return self.harmonics.order <= 1

    @property
    def radius(self) -> float:
        """Root-mean-square distance from the mean point over the directions."""
        return float(np.sqrt(np.sum(self.coefficients[1:] ** 2) / (4.0 * np.pi)))

    def in_degree(self, degree: int, *, symmetric: bool | None = None) -> HarmonicMap:
        """Map in another degree, truncated or padded with zeros."""
        new = coordinate_harmonics(degree, self.symmetric if symmetric is None else symmetric)
        return HarmonicMap(new, resized(self.coefficients, self.harmonics, new))

    def jet(self, u: Floats) -> Jet:
        """Second-order jet of the map in the directions u (n, 3)."""
        return Jet.of_tensors(u, *self.harmonics.derivatives(u, self.coefficients))

    def jet_at_nodes(self, n: int) -> Jet:
        """Jet at the nodes on n circles, with symmetry on one meridian only."""
        jet = Jet.at_nodes(_transform(self.harmonics, n), self.coefficients)
        return jet[:: AROUND if self.symmetric else 1]

    def normals(self) -> HarmonicMap:
        """Unit normals with respect to flat space, in the same harmonics."""
        T = self._fine
        return HarmonicMap(self.harmonics, T.analysis(_normals(T, self.coefficients)))

    def displaced(self, direction: HarmonicMap, f: Floats, harmonics: Harmonics) -> HarmonicMap:
        """Map ``X + f D`` in the same harmonics, with f (size,) in given ones."""
        T = self._fine
        shift = SphereTransform(harmonics, T.n, T.around).values(f[:, None])
        x = T.values(self.coefficients) + shift * T.values(direction.coefficients)
        return HarmonicMap(self.harmonics, T.analysis(x))

    def reparametrized(self) -> HarmonicMap:
        """Nearly the same surface in a parametrization that needs fewer harmonics.

        With symmetry, the parameter is the arc length of the meridian.  Otherwise the tangential part of high
        degrees is damped, following Veerapaneni, Rahimian, Biros and Zorin, J. Comput. Phys. 230 (2011) 5610.
        """
        if self.symmetric:
            return self._by_length()
        T = self._fine
        # The highest degree is damped by exp(-2).
        damped = np.exp(-2.0 * (self.harmonics.labels[0] / self.degree) ** 2)[:, None]
        c = self.coefficients
        for _ in range(10):
            n = _normals(T, c)
            change = T.values((damped - 1.0) * c)
            change -= np.einsum("ni,ni->n", change, n)[:, None] * n
            c = c + T.analysis(change)
        return HarmonicMap(self.harmonics, c)

    def _by_length(self) -> HarmonicMap:
        # Numbers of angles along a meridian, and of terms of the series of its arc length.
        samples, terms = 20 * self.degree, 6 * self.degree
        theta = (np.arange(samples) + 0.5) * np.pi / samples
        u, along = _meridian(theta)
        _, first, _ = self.harmonics.derivatives(u, self.coefficients)
        speed = np.linalg.norm(np.einsum("nij,nj->ni", first, along), axis=1)
        series = dct(speed, type=2)[: terms + 1] / samples
        series[0] *= 0.5
        k = np.arange(1, terms + 1)

        def length(t: Floats) -> Floats:
            return np.asarray(series[0] * t + np.sin(np.outer(t, k)) @ (series[1:] / k))

        T = self._fine
        aim = series[0] * np.arccos(T.u[::AROUND, 2])
        t = np.interp(aim, length(theta), theta)
        for _ in range(8):  # Newton's method
            t = t - (length(t) - aim) / (series[0] + np.cos(np.outer(t, k)) @ series[1:])
        on_meridian = self.harmonics.derivatives(_meridian(t)[0], self.coefficients)[0]
        rho, z = np.repeat(on_meridian[:, 0], AROUND), np.repeat(on_meridian[:, 2], AROUND)
        phi = np.arctan2(T.u[:, 1], T.u[:, 0])
        x = np.stack([rho * np.cos(phi), rho * np.sin(phi), z], axis=1)
        return HarmonicMap(self.harmonics, T.analysis(x))

    @property
    def _fine(self) -> SphereTransform:
        """Transform with twofold oversampling."""
        return _transform(self.harmonics, 2 * self.degree + 4)


def coordinate_harmonics(degree: int, symmetric: bool) -> Harmonics:
    """Harmonics of coordinates: with symmetry about z those of orders 0 and 1."""
    return Harmonics(degree, min(1, degree) if symmetric else degree)


@lru_cache(maxsize=4)
def _transform(harmonics: Harmonics, n: int) -> SphereTransform:
    return SphereTransform(harmonics, n, AROUND if harmonics.order <= 1 else 2 * n)


def _normals(T: SphereTransform, coefficients: Floats) -> Floats:
    first = T.gradients(coefficients)
    normal = np.cross(first[:, 0], first[:, 1])
    return np.asarray(normal / np.linalg.norm(normal, axis=1)[:, None])


def _meridian(theta: Floats) -> tuple[Floats, Floats]:
    """Directions on the meridian phi = 0, and tangents along it."""
    zero = np.zeros_like(theta)
    sin, cos = np.sin(theta), np.cos(theta)
    return np.stack([sin, zero, cos], axis=1), np.stack([cos, zero, -sin], axis=1)
