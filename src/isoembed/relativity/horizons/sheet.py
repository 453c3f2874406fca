"""Maps of the sphere into a slice that are moved along their normals, and given better coordinates."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from scipy.fft import dct

from isoembed.arrays import Floats
from isoembed.relativity.horizons.surface_family import Jet
from isoembed.relativity.spacetimes.surface import Surface
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.sphere_transform import SphereTransform
from isoembed.smooth.transforms import resized

AROUND = 4
"""Angles phi of maps that are symmetric about z, whose coordinates have the orders 0 and 1."""


@dataclass(frozen=True, eq=False)
class Sheet:
    """A map of the unit sphere: coordinates in spherical harmonics, with coefficients (size, 3).

    Attributes
    ----------
    degree : int
    symmetric : bool
        About z: only the orders 0 and 1 are there.
    coefficients : ndarray, shape (size, 3)
    """

    degree: int
    symmetric: bool
    coefficients: Floats

    @classmethod
    def of(cls, surface: Surface, degree: int, *, symmetric: bool) -> Sheet:
        """Projection of a surface, in its own directions."""
        T = _transform(degree, 2 * max(degree, surface.harmonics.degree) + 4, symmetric)
        return cls(degree, symmetric, T.analysis(surface.points(T.u)))

    @property
    def harmonics(self) -> Harmonics:
        """Those of the coordinates."""
        return harmonics_of(self.degree, self.symmetric)

    @property
    def radius(self) -> float:
        """The mean distance from the mean point, root-mean-square over the directions."""
        return float(np.sqrt(np.sum(self.coefficients[1:] ** 2) / (4.0 * np.pi)))

    @property
    def tail(self) -> float:
        """The largest coefficient of high degree over the radius."""
        high = self.harmonics.labels[0] > 0.875 * self.degree
        return float(np.abs(self.coefficients[high]).max()) / self.radius

    def in_degree(self, degree: int) -> Sheet:
        """The same map, cut off or filled up with zeros."""
        new = harmonics_of(degree, self.symmetric)
        return Sheet(degree, self.symmetric, resized(self.coefficients, self.harmonics, new))

    def jet(self, n: int) -> Jet:
        """The map at the nodes of n circles; with symmetry at those of one meridian."""
        jet = Jet.of(_transform(self.degree, n, self.symmetric), self.coefficients)
        step = AROUND if self.symmetric else 1
        return Jet(jet.value[::step], jet.first[::step], jet.second[::step])

    def normals(self) -> Sheet:
        """The unit normals of flat space, in the same harmonics."""
        T = _transform(self.degree, 2 * self.degree + 4, self.symmetric)
        return replace(self, coefficients=T.analysis(_normals(T, self.coefficients)))

    def moved(self, direction: Sheet, f: Floats, harmonics: Harmonics) -> Sheet:
        """The map ``X + f D`` in the same harmonics, f (size,) in given ones."""
        T = _transform(self.degree, 2 * self.degree + 4, self.symmetric)
        shift = SphereTransform(harmonics, T.n, T.around).values(f[:, None])
        x = T.values(self.coefficients) + shift * T.values(direction.coefficients)
        return replace(self, coefficients=T.analysis(x))

    def even(self) -> Sheet:
        """The same surface, nearly, in coordinates in which it needs fewer harmonics.

        With symmetry, by the length of the meridian.  Otherwise high degrees are damped, but only along the
        surface: of Veerapaneni, Rahimian, Biros and Zorin, J. Comput. Phys. 230 (2011) 5610.
        """
        if self.symmetric:
            return self._by_length()
        T = _transform(self.degree, 2 * self.degree + 4, self.symmetric)
        # The highest degree is damped by exp(-2).
        damped = np.exp(-2.0 * (self.harmonics.labels[0] / self.degree) ** 2)[:, None]
        c = self.coefficients
        for _ in range(10):
            n = _normals(T, c)
            change = T.values((damped - 1.0) * c)
            change -= np.einsum("ni,ni->n", change, n)[:, None] * n
            c = c + T.analysis(change)
        return replace(self, coefficients=c)

    def _by_length(self) -> Sheet:
        # Angles along a meridian, and terms of the series of its length.
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

        T = _transform(self.degree, 2 * self.degree + 4, self.symmetric)
        aim = series[0] * np.arccos(T.u[::AROUND, 2])
        t = np.interp(aim, length(theta), theta)
        for _ in range(8):  # Newton's method
            t = t - (length(t) - aim) / (series[0] + np.cos(np.outer(t, k)) @ series[1:])
        on_meridian = self.harmonics.derivatives(_meridian(t)[0], self.coefficients)[0]
        rho, z = np.repeat(on_meridian[:, 0], AROUND), np.repeat(on_meridian[:, 2], AROUND)
        phi = np.arctan2(T.u[:, 1], T.u[:, 0])
        x = np.stack([rho * np.cos(phi), rho * np.sin(phi), z], axis=1)
        return replace(self, coefficients=T.analysis(x))


def harmonics_of(degree: int, symmetric: bool) -> Harmonics:
    """Those of coordinates of this degree."""
    return Harmonics(degree, min(1, degree) if symmetric else degree)


@lru_cache(maxsize=4)
def _transform(degree: int, n: int, symmetric: bool) -> SphereTransform:
    return SphereTransform(harmonics_of(degree, symmetric), n, AROUND if symmetric else 2 * n)


def _normals(T: SphereTransform, coefficients: Floats) -> Floats:
    first = T.gradients(coefficients)
    normal = np.cross(first[:, 0], first[:, 1])
    return np.asarray(normal / np.linalg.norm(normal, axis=1)[:, None])


def _meridian(theta: Floats) -> tuple[Floats, Floats]:
    """Directions on the meridian phi = 0, and the tangents along it."""
    zero = np.zeros_like(theta)
    sin, cos = np.sin(theta), np.cos(theta)
    return np.stack([sin, zero, cos], axis=1), np.stack([cos, zero, -sin], axis=1)
