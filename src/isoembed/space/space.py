"""Space of constant curvature, and its points.

A point is ``X = (x, w)`` on the hyperboloid ``w^2 = 1 - k |x|^2`` in Minkowski space, or on the sphere with
this equation in R^4; it is stored as x, which is a length.  A point at distance r from the origin in
direction u has ``x = sn(r) u`` and ``w = cs(r)``.  In Euclidean space k = 0, w = 1 and x is the point itself,
and all formulas tend to this case, to rounding, as k tends to zero.  For the sphere, x represents the open
hemisphere about the origin.
"""

from __future__ import annotations

import math
import numbers
import sys
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter


@dataclass(frozen=True, repr=False)
class Space:
    """Euclidean, hyperbolic or spherical 3-space.

    Parameters
    ----------
    curvature : float
        Sectional curvature k, in 1/length^2: zero, negative or positive.

    Raises
    ------
    InvalidParameter
        The curvature is not finite.

    Examples
    --------
    >>> Hyperbolic(0.25).radius
    2.0
    """

    curvature: float = 0.0

    def __post_init__(self) -> None:
        k = self.curvature
        if isinstance(k, bool) or not isinstance(k, numbers.Real) or not math.isfinite(k):
            raise InvalidParameter(f"the curvature of space is {k!r}, not a finite number")
        # No negative zero and no subnormal numbers: such a space is indistinguishable from R^3.
        object.__setattr__(self, "curvature", float(k) if abs(k) >= sys.float_info.min else 0.0)

    def __repr__(self) -> str:
        if self.is_euclidean:
            return "Euclidean()"
        return f"{self.name.capitalize()}({abs(self.curvature)!r})"

    @property
    def is_euclidean(self) -> bool:
        """Whether the curvature is zero."""
        return self.curvature == 0

    @property
    def name(self) -> str:
        """``"euclidean"``, ``"hyperbolic"`` or ``"spherical"``."""
        return "euclidean" if self.is_euclidean else "spherical" if self.curvature > 0 else "hyperbolic"

    @property
    def root(self) -> float:
        """``sqrt(|k|)``."""
        return math.sqrt(abs(self.curvature))

    @property
    def radius(self) -> float:
        """Radius of curvature, ``1 / sqrt(|k|)``; infinite in Euclidean space."""
        return math.inf if self.is_euclidean else 1 / self.root

    def scaled(self, factor: float) -> Space:
        """Space in another unit, with every length multiplied by this factor."""
        if self.is_euclidean:
            return self
        with np.errstate(all="ignore"):  # an overflowing curvature is refused as infinite
            return Space(float(np.float64(self.curvature) / factor / factor))

    def sn(self, x: ArrayLike) -> Floats:
        """Sine of lengths: ``sin(x sqrt(k)) / sqrt(k)``, x, or the same with sinh."""
        if self.is_euclidean:
            return np.asarray(x, dtype=np.float64)
        y = self.root * np.asarray(x)
        return (np.sin(y) if self.curvature > 0 else np.sinh(y)) / self.root

    def cs(self, x: ArrayLike) -> Floats:
        """Cosine of lengths, the derivative of `sn`."""
        if self.is_euclidean:
            return np.ones(np.shape(x))
        y = self.root * np.asarray(x)
        return np.cos(y) if self.curvature > 0 else np.cosh(y)

    def asn(self, s: ArrayLike) -> Floats:
        """Inverse of `sn`: lengths, on the sphere up to a quarter of a great circle."""
        if self.is_euclidean:
            return np.asarray(s, dtype=np.float64)
        y = self.root * np.asarray(s)
        return (np.arcsin(np.minimum(y, 1.0)) if self.curvature > 0 else np.arcsinh(y)) / self.root

    def versine(self, x: ArrayLike) -> Floats:
        """``(1 - cs(x)) / k`` without cancellation; x^2 / 2 in Euclidean space."""
        s = self.sn(np.asarray(x) / 2)
        return 2 * s * s

    def chord(self, l: ArrayLike) -> Floats:
        """Chords, in the space around hyperboloid or sphere, of points at distances l."""
        return 2 * self.sn(np.asarray(l) / 2)

    def arc(self, chord: ArrayLike) -> Floats:
        """Distances of points with these chords, the inverse of `chord`."""
        return 2 * self.asn(np.asarray(chord) / 2)

    def heights(self, x: Floats) -> Floats:
        """``w = sqrt(1 - k |x|^2)`` of points (..., 3): the cosine of the distance from the origin."""
        if self.is_euclidean:
            return np.ones(np.shape(x)[:-1])
        r = self.root * np.linalg.norm(x, axis=-1)
        return np.hypot(1.0, r) if self.curvature < 0 else np.sqrt((1 - r) * (1 + r))

    def chords(self, x: Floats, y: Floats) -> Floats:
        """Chords between points (..., 3) and (..., 3)."""
        d = x - y
        if self.is_euclidean:
            return np.linalg.norm(d, axis=-1)
        # Conformal coordinates have the least cancellation far from the origin of hyperbolic space.
        here, there = self.heights(x), self.heights(y)
        drop = self.curvature * np.einsum("...i,...i->...", d, x + y) / (here + there)
        moved = (1 + there)[..., None] * d + drop[..., None] * y
        return np.sqrt(np.einsum("...i,...i->...", moved, moved) / ((1 + here) * (1 + there)))

    def distances(self, x: Floats, y: Floats) -> Floats:
        """Distances between points (..., 3) and (..., 3)."""
        return self.arc(self.chords(x, y))

    def translated(self, x: Floats, a: Floats) -> Floats:
        """Translate points (..., 3) by the translation from the origin to a (..., 3) along their line.

        Raises
        ------
        InvalidParameter
            On the sphere, a point leaves the open hemisphere about the origin.
        """
        k, w, height = self.curvature, self.heights(x), self.heights(a)
        product = np.einsum("...i,...i->...", a, x)
        if k > 0 and (w * height <= k * product).any():
            i = int(np.argmax(np.ravel(w * height <= k * product)))
            raise InvalidParameter(f"point {i} is moved out of the half of the sphere about the origin")
        return x + a * (w - k * product / (1 + height))[..., None]

    def seen_from(self, a: Floats, x: Floats) -> Floats:
        """Positions of points x (..., n) after the translation of points a (..., n) to the origin.

        Directions are correct even for points that leave the hemisphere about the origin.
        """
        if self.is_euclidean:
            return x - a
        along = self.curvature * np.einsum("...i,...i->...", a, x) / (1 + self.heights(a))
        return x - a * (self.heights(x) + along)[..., None]

    def exponential(self, x: Floats, v: Floats) -> Floats:
        """Exponential map: end points of geodesics from x (..., 3) with initial velocities v (..., 3).

        The velocities are vectors at the origin, by the translation from x to the origin.
        """
        length = np.linalg.norm(v, axis=-1)
        ratio = np.where(length > 0, self.sn(length) / np.where(length > 0, length, 1.0), 1.0)
        return self.translated(ratio[..., None] * v, x)

    def logarithm(self, x: Floats, y: Floats) -> Floats:
        """Logarithm map: velocities v (..., 3) for which `exponential` at x (..., 3) gives y (..., 3)."""
        z = self.translated(y, -x)
        size = np.linalg.norm(z, axis=-1)
        ratio = np.where(size > 0, self.arc(self.chords(x, y)) / np.where(size > 0, size, 1.0), 1.0)
        return ratio[..., None] * z

    def center(self, x: Floats) -> Floats:
        """Centroid (3,) of points (n, 3): the point in the direction of the sum of their X."""
        w = float(self.heights(x).mean())
        mean = x.mean(axis=0)
        return mean / np.sqrt(w * w + self.curvature * float(mean @ mean))

    def centered(self, x: Floats) -> Floats:
        """Move points (n, 3) so that their `center` is the origin."""
        return self.translated(x, -self.center(x))


def Euclidean() -> Space:  # noqa: N802 - as a class is named
    """Euclidean space, R^3."""
    return Space()


EUCLIDEAN = Euclidean()


def Hyperbolic(k: float = 1.0) -> Space:  # noqa: N802
    """Hyperbolic space H^3 of curvature -k.

    Raises
    ------
    InvalidParameter
        k is not positive and finite.
    """
    return Space(-_positive(k, "; Hyperbolic(k) has the curvature -k"))


def Spherical(k: float = 1.0) -> Space:  # noqa: N802
    """3-sphere S^3 of curvature k.

    Raises
    ------
    InvalidParameter
        k is not positive and finite.
    """
    return Space(_positive(k))


def _positive(k: float, convention: str = "") -> float:
    if not isinstance(k, numbers.Real) or not 0 < k < math.inf:
        raise InvalidParameter(
            f"the curvature of space must be a positive finite number, not {k!r}{convention}"
        )
    return float(k)
