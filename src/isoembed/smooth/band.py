"""Bands of axisymmetric surfaces between two circles of latitude."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from isoembed.arrays import Floats, Indices
from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.smooth.piecewise import Piecewise, fitted, value_at

if TYPE_CHECKING:
    from isoembed.smooth.axisymmetric import AxisymmetricEmbedding


@dataclass(frozen=True, eq=False)
class Band:
    """Embeddable part of an axisymmetric surface between two circles of latitude (or poles).

    Attributes
    ----------
    metric : AxisymmetricEmbedding
    start, stop : float
        Range of theta.
    """

    metric: AxisymmetricEmbedding = field(repr=False)
    start: float
    stop: float

    @property
    def area(self) -> float:
        """Area of the band."""
        return self.metric._area(self.start, self.stop)

    @property
    def height(self) -> float:
        """Extent along the axis, as an arc length."""
        return value_at(self._primitives[0], np.pi) * self.metric.unit

    @property
    def integrated_mean_curvature(self) -> float:
        """Integral of H dA with H = (k1 + k2)/2; finite although H is infinite on an edge."""
        # int k2 dA = 2 pi height.  int k1 dA = 2 pi int rho d(beta) is integrated by parts: beta, the turning
        # angle of the meridian, needs one derivative less and is finite at the edges.  From each of the two,
        # over 2 pi, curved space subtracts k rho^2 d(height).
        # At edges and poles beta is 0 or pi; computing it would lose half of the digits.
        edges = np.array([self.start, self.stop])
        turned = np.where(self.metric._terms(np.cos(edges))[1] > 0.0, 0.0, np.pi)
        before, after = turned * self.metric.rho(edges) / self.metric.unit
        height, moment = (value_at(f, np.pi) for f in self._primitives)
        return np.pi * (height + float(after - before) - moment) * self.metric.unit

    def z(self, theta: ArrayLike) -> Floats:
        """Height (n,) at theta (n,) in the band, zero at half its extent: the ambient coordinate z.

        Raises
        ------
        InvalidParameter
            An angle is outside the band; the message names the first one.
        InvalidMetric
            The band is in spherical space and longer than half of a great circle, beyond the hemisphere
            covered by ambient coordinates.
        """
        theta = checked_angles(theta)
        slack = 1e-14 * np.pi
        outside = np.flatnonzero((theta < self.start - slack) | (theta > self.stop + slack))
        if outside.size:
            i = int(outside[0])
            raise InvalidParameter(
                f"theta[{i}] = {theta[i]:.9g} is outside the band from {self.start:.9g} to {self.stop:.9g}"
            )
        fraction = np.clip((theta - self.start) / (self.stop - self.start), 0.0, 1.0)
        fallen = self._primitives[0](2.0 * np.arcsin(np.sqrt(fraction))) * self.metric.unit
        space = self.metric.space
        if self.height * np.sqrt(max(space.curvature, 0.0)) >= np.pi:
            raise InvalidMetric(
                f"the surface is {self.height:.6g} long, more than half of a great circle,"
                f" pi {space.radius:.6g}: no hemisphere has it"
            )
        rho = self.metric.rho(theta)
        return np.sqrt(1.0 - space.curvature * rho * rho) * space.sn(0.5 * self.height - fallen)

    def mesh(self, around: int = 64) -> tuple[Floats, Indices]:
        """Triangulate the band.

        Parameters
        ----------
        around : int
            Number of vertices on each circle of latitude, at least 3.  The distance of circles equals the
            spacing of vertices on the widest circle.

        Returns
        -------
        vertices : ndarray, shape (V, 3)
        faces : ndarray, shape (F, 3)
            Triangles, counterclockwise as seen from outside, with a boundary at each edge other than a pole.
        """
        if around < 3:
            raise InvalidParameter(f"around must be at least 3, not {around}")
        fine = self.start + (self.stop - self.start) * np.linspace(0.0, 1.0, 2001)
        speed = np.sqrt(self.metric.T(np.cos(fine))) * self.metric.unit
        along = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(fine))])
        spacing = 2.0 * np.pi * float(self.metric.rho(fine).max()) / around
        rows = max(2, round(float(along[-1]) / spacing)) + 1
        theta = np.interp(np.linspace(0.0, along[-1], rows), along, fine)
        phi = 2.0 * np.pi / around * np.arange(around)
        rho, z = self.metric.rho(theta), self.z(theta)
        circles = np.stack(
            [np.outer(rho, np.cos(phi)), np.outer(rho, np.sin(phi)), np.repeat(z[:, None], around, axis=1)],
            axis=-1,
        ).reshape(-1, 3)
        # A pole is a single vertex.
        ring = np.arange(rows * around).reshape(rows, around)
        if self.start == 0.0:
            ring[0] = ring[0, 0]
        if self.stop == np.pi:
            ring[-1] = ring[-1, 0]
        upper, lower = ring[:-1], ring[1:]
        right, lower_right = np.roll(upper, -1, axis=1), np.roll(lower, -1, axis=1)
        faces = np.concatenate(
            [
                np.stack([upper, lower, lower_right], axis=-1).reshape(-1, 3),
                np.stack([upper, lower_right, right], axis=-1).reshape(-1, 3),
            ]
        )
        distinct = (np.diff(np.sort(faces, axis=1), axis=1) > 0).all(axis=1)
        used, renumbered = np.unique(faces[distinct], return_inverse=True)
        return circles[used], renumbered.reshape(-1, 3)

    @cached_property
    def _primitives(self) -> tuple[Piecewise, Piecewise]:
        """Primitives of -dh/d theta and of beta d rho/d theta - 2 k rho^2 dh/d theta, as functions of tau.

        h is the arc length along the axis (z in R^3), and beta the slope angle of the meridian, with
        tan(beta) = -dz/d rho in R^3.  theta = (start + stop)/2 - (stop - start)/2 cos(tau) makes square-root
        singularities at the edges smooth.
        """
        half = 0.5 * (self.stop - self.start)

        def integrands(tau: Floats) -> Floats:
            theta = self.start + 2.0 * half * np.sin(0.5 * tau) ** 2
            x, k = np.cos(theta), self.metric._k
            G, rho_theta = self.metric._terms(x)
            slope = np.sin(theta) * np.sqrt(np.maximum(G, 0.0))
            bent = k * np.sin(theta) ** 2 * self.metric.P(x)
            fall = slope / (1.0 - bent)
            turning = np.arctan2(slope, rho_theta) * rho_theta + 2.0 * bent * fall
            return np.stack([fall, turning]) * (half * np.sin(tau))

        shares = (np.arccos(self.metric.T.breaks[1:-1]) - self.start) / (2.0 * half)
        own = 2.0 * np.arcsin(np.sqrt(np.clip(shares, 0.0, 1.0)))  # resolve narrow features of the metric
        breaks = np.union1d([0.0, 0.5 * np.pi, np.pi], own)
        breaks = breaks[np.append(True, np.diff(breaks) > 1e-12)]
        breaks[-1] = np.pi
        (fall, moment), _ = fitted(integrands, breaks, weighted=True)
        return fall.primitive(), moment.primitive()


def checked_angles(theta: ArrayLike) -> Floats:
    """Checked angles (n,) from 0 to pi.

    Raises
    ------
    InvalidParameter
        An angle is outside this range; the message names the first one.
    """
    angles = np.atleast_1d(np.asarray(theta, dtype=np.float64))
    bad = np.flatnonzero(~((angles >= 0.0) & (angles <= np.pi)))
    if bad.size:
        raise InvalidParameter(f"theta[{bad[0]}] = {angles[bad[0]]:.9g} is not between 0 and pi")
    return angles
