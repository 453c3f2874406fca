"""Bent ellipsoids: the bean, along a parabola, and the tube, around a circle."""

from dataclasses import dataclass
from math import pi
from typing import ClassVar

import numpy as np

from isoembed.arrays import Floats
from isoembed.gallery.mapped import MappedSurface
from isoembed.gallery.surface import MAX_ASPECT, SurfaceWithAxes, option, positive, semiaxes


@dataclass(frozen=True)
class Bean(MappedSurface, SurfaceWithAxes):
    """The ellipsoid bent along a parabola: z rises by h (x/a)^2, and the ends by h.

    Its volume is that of the ellipsoid; K < 0 on its inner side if the bend is sharper than the girth.
    """

    name: ClassVar[str] = "bean"
    axes: tuple[float, float, float] = option((1.6, 0.7, 0.7), "semi-axes a b c", semiaxes)
    height: float = option(0.9, "height h of the ends over the middle")

    def _check(self) -> None:
        maximum = MAX_ASPECT * min(self.axes)
        if abs(self.height) > maximum:
            raise ValueError(f"{self.name}: |height| must be at most {maximum:.6g}, not {self.height}")

    def _points(self, u: Floats) -> Floats:
        points = u * self._semiaxes
        points[:, 2] += self.height / self._unit * u[:, 0] ** 2
        return points

    def _differential(self, u: Floats) -> Floats:
        J = np.tile(np.diag(self._semiaxes), (len(u), 1, 1))
        J[:, 2, 0] = 2.0 * self.height / self._unit * u[:, 0]
        return J

    def _second_differential(self, u: Floats, normals: Floats) -> Floats:
        second = np.zeros((len(u), 3, 3))
        second[:, 0, 0] = 2.0 * self.height / self._unit * normals[:, 2]
        return second


@dataclass(frozen=True)
class BentTube(MappedSurface, SurfaceWithAxes):
    """The ellipsoid bent around a circle of radius R, on which its x-axis is wound.

    The circle of radius R lies in the plane of x and z and touches the x-axis from below; a point at x is
    mapped to the angle x/R at the distance R + z from the center. The volume is that of the ellipsoid; K < 0
    on the inner side.
    """

    name: ClassVar[str] = "bent-tube"
    axes: tuple[float, float, float] = option((1.65, 0.45, 0.45), "semi-axes a b c", semiaxes)
    radius: float = option(1.5, "radius R of the circle, more than c and more than a/pi", positive)

    def _check(self) -> None:
        minimum = 1.0001 * max(self.axes[2], self.axes[0] / pi)
        if self.radius < minimum:
            raise ValueError(f"{self.name}: radius must be at least {minimum:.6g}, not {self.radius}")

    def _polar(self, u: Floats) -> tuple[float, Floats, Floats, Floats, Floats]:
        """Angle a/R, sine and cosine of the angle, distance from the center and its excess over R."""
        R = self.radius / self._unit
        turn, excess = self._semiaxes[0] / R, self._semiaxes[2] * u[:, 2]
        return turn, np.sin(turn * u[:, 0]), np.cos(turn * u[:, 0]), R + excess, excess

    def _points(self, u: Floats) -> Floats:
        turn, sin, cos, distance, excess = self._polar(u)
        # R (cos - 1) without cancellation: R may be large.
        sunk = 2.0 * self.radius / self._unit * np.sin(0.5 * turn * u[:, 0]) ** 2
        return np.stack([distance * sin, self._semiaxes[1] * u[:, 1], excess * cos - sunk], axis=1)

    def _differential(self, u: Floats) -> Floats:
        turn, sin, cos, distance, _ = self._polar(u)
        J = np.zeros((len(u), 3, 3))
        J[:, 0, 0], J[:, 2, 0] = turn * distance * cos, -turn * distance * sin
        J[:, 1, 1] = self._semiaxes[1]
        J[:, 0, 2], J[:, 2, 2] = self._semiaxes[2] * sin, self._semiaxes[2] * cos
        return J

    def _second_differential(self, u: Floats, normals: Floats) -> Floats:
        turn, sin, cos, distance, _ = self._polar(u)
        second = np.zeros((len(u), 3, 3))
        second[:, 0, 0] = -(turn**2) * distance * (normals[:, 0] * sin + normals[:, 2] * cos)
        second[:, 0, 2] = self._semiaxes[2] * turn * (normals[:, 0] * cos - normals[:, 2] * sin)
        second[:, 2, 0] = second[:, 0, 2]
        return second
