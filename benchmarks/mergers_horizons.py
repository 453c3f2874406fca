"""Horizons of two black holes at rest, by shooting: truth of mergers.py, with nothing of isoembed in it.

Brill and Lindquist's slice has the metric psi^4 delta, psi = 1 + sum m / 2 r.  A horizon that is symmetric
about the line of the holes is a curve (rho, z) of arc length s (of flat space) with the angle a of its
tangent, rho' = cos a, z' = - sin a, and its mean curvature vanishes: a' = - sin a / rho - 4 d_n log psi.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial import chebyshev
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, minimize_scalar, root

TOLERANCE = 1e-13  # of the integration
START = 1e-5  # distance from the axis, over the distance from the nearest hole
LONGEST = 5.0  # arc length, over the sum of the masses
WAIST = 0.4
SHORT = 0.01  # steps where values between them count
ENDS = 0.766197428  # of common horizons, equal masses whose sum is 1
FLAT_WAIST = 0.62783144  # the least distance with K = 0


@dataclass(frozen=True)
class Holes:
    """Two masses and the distance of their places, +- distance / 2 on the z-axis."""

    masses: tuple[float, float]
    distance: float

    @property
    def heights(self):
        return np.array([0.5, -0.5]) * self.distance

    def psi(self, rho, z):
        """The factor with its derivatives in rho and z."""
        fall = 0.5 * np.array(self.masses)
        above = z - self.heights
        r = np.sqrt(rho**2 + above**2)
        return 1.0 + np.sum(fall / r), -np.sum(fall * rho / r**3), -np.sum(fall * above / r**3)

    def shot(self, height, side, plane, max_step=np.inf):
        """The curve from a point of the axis to a plane z, mirrored if the side is -1.

        Its columns: rho, z, a, area, the integral of H so far.  None if it does not come there.
        """

        def field(rho, z):
            psi, across, along = self.psi(rho, side * z)
            return psi, across, side * along

        def change(_, y):
            rho, z, a = y[:3]
            psi, across, along = field(rho, z)
            sin, cos = np.sin(a), np.cos(a)
            turn = -sin / rho - 4.0 * (across * sin + along * cos) / psi
            slope = psi * (psi * cos + 2.0 * rho * (across * cos - along * sin))  # of psi^2 rho
            rise = np.sqrt(max(psi**4 - slope**2, 0.0))
            # int rho d alpha, alpha the angle of the meridian in Euclidean space, is - int alpha d rho.
            bend = np.pi * (rise - np.arctan2(rise, slope) * slope)
            return [cos, -sin, turn, 2.0 * np.pi * rho * psi**4, bend]

        def arrived(_, y):
            return y[1] - side * plane

        def returned(_, y):
            return y[0] - 0.1 * begin[0]

        arrived.terminal = returned.terminal = True
        psi, _, along = field(0.0, side * height)
        c, e = -2.0 * along / psi, START * float(np.min(np.abs(height - self.heights)))
        begin = [e, side * height - 0.5 * c * e**2, c * e, np.pi * psi**4 * e**2, 0.0]
        found = solve_ivp(
            change,
            (0.0, LONGEST * sum(self.masses)),
            begin,
            method="DOP853",
            rtol=TOLERANCE,
            atol=1e-15,
            events=(arrived, returned),
            dense_output=max_step < np.inf,
            max_step=max_step,
        )
        return found if len(found.t_events[0]) else None

    def horizon(self, top, bottom, plane=0.0):
        """The horizon whose curve meets the axis near these heights; the plane is one between them."""

        def apart(ends):
            curves = [self.shot(h, side, plane) for h, side in zip(ends, (1, -1), strict=True)]
            if None in curves:
                return np.full(2, 9.0)
            (r, _, a), (s, _, b) = (curve.y[:3, -1] for curve in curves)
            return np.array([r - s, a + b - np.pi])

        if self.masses[0] == self.masses[1] and top == -bottom:
            # One unknown, and its root between two heights.
            for width in (1e-4, 3e-4, 1e-3, 3e-3):
                low, high = (apart((h, -h))[1] for h in (top - width, top + width))
                if low * high < 0.0:
                    h = brentq(lambda h: apart((h, -h))[1], top - width, top + width, xtol=1e-15)
                    return Horizon(self, h, -h, plane)
            raise ValueError(f"no horizon near {top}")
        found = root(apart, (top, bottom), tol=1e-14)
        if np.abs(found.fun).max() > 1e-9:
            raise ValueError(f"no horizon near {top}, {bottom}: {found.message}")
        return Horizon(self, *found.x, plane)


@dataclass(frozen=True)
class Horizon:
    """One that was found, by its heights on the axis."""

    holes: Holes
    top: float
    bottom: float
    plane: float

    @cached_property
    def _curves(self):
        step = SHORT * (self.top - self.bottom)
        return [self.holes.shot(h, side, self.plane, step) for h, side in ((self.top, 1), (self.bottom, -1))]

    @property
    def area(self):
        return sum(curve.y[3, -1] for curve in self._curves)

    @property
    def irreducible_mass(self):
        return np.sqrt(self.area / (16.0 * np.pi))

    @property
    def integrated_mean_curvature(self):
        """That of the surface of revolution in Euclidean space."""
        total = sum(curve.y[4, -1] for curve in self._curves)
        for side, curve in zip((1, -1), self._curves, strict=True):
            rho, z, a = curve.y[:3, -1]
            psi, across, along = self.holes.psi(rho, side * z)
            slope = psi * (psi * np.cos(a) + 2.0 * rho * (across * np.cos(a) - side * along * np.sin(a)))
            rise = np.sqrt(psi**4 - slope**2)
            total += np.pi * psi**2 * rho * np.arctan2(rise, slope)
        return total

    @property
    def liu_yau(self):
        """int k0 dA / 8 pi."""
        return self.integrated_mean_curvature / (4.0 * np.pi)

    @cached_property
    def least_curvature(self):
        """The least Gaussian curvature."""
        part = np.linspace(0.01, 1.0, 2000)
        return min(
            self._curvature(curve.sol(part * curve.t[-1]), side).min()
            for side, curve in zip((1, -1), self._curves, strict=True)
        )

    @property
    def equator_curvature(self):
        """The Gaussian curvature where the curves meet."""
        return float(self._curvature(self._curves[0].y, 1)[-1])

    def _curvature(self, curve, side):
        """-R'' / R along the meridian, R = psi^2 rho, at points of a curve."""
        rho, z, a = curve[:3]
        fall = 0.5 * np.array(self.holes.masses)[:, None]
        above = side * z - self.holes.heights[:, None]
        r = np.sqrt(rho**2 + above**2)
        psi = 1.0 + (fall / r).sum(axis=0)
        across, along = -(fall * rho / r**3).sum(axis=0), -side * (fall * above / r**3).sum(axis=0)
        rr = (fall * (3.0 * rho**2 - r**2) / r**5).sum(axis=0)
        rz = side * (fall * 3.0 * rho * above / r**5).sum(axis=0)
        zz = (fall * (3.0 * above**2 - r**2) / r**5).sum(axis=0)
        sin, cos = np.sin(a), np.cos(a)
        turn = -sin / rho - 4.0 * (across * sin + along * cos) / psi
        forward = across * cos - along * sin  # of psi, along the curve
        bend = rr * cos**2 - 2.0 * rz * sin * cos + zz * sin**2 - (across * sin + along * cos) * turn
        change = -sin * turn + 2.0 * (cos / psi - rho * forward / psi**2) * forward + 2.0 * rho / psi * bend
        return -change / (psi**4 * rho)

    def _points(self, off, theta):
        """rho and z on both curves where off(rho, z, s, theta) vanishes, s the part of the length."""
        upper, lower = self._curves
        first, last = upper.y[0, 0], lower.y[0, 0]  # as far as the axis is from where they begin
        middle = first + upper.t[-1]
        length = middle + lower.t[-1] + last

        def at(s):
            side, curve, s = (1, upper, s - first) if s <= middle else (-1, lower, length - last - s)
            rho, z = curve.sol(s)[:2]
            return rho, side * z

        found = [brentq(lambda s, t=t: off(*at(s), s / length, t), 0.0, length, xtol=1e-15) for t in theta]
        return np.array([at(s) for s in found]).T

    def radius(self, degree=200, center=None):
        """The radius about a point of the axis as a polynomial in the cosine z of the direction."""
        center = 0.5 * (self.top + self.bottom) if center is None else center
        theta = np.pi * (np.arange(degree) + 0.5) / degree
        rho, z = self._points(lambda rho, z, _, t: rho * np.cos(t) - (z - center) * np.sin(t), theta)
        return interpolated(np.hypot(rho, z - center))

    def meridian(self, degree=200):
        """rho / sin(theta) and z, polynomials in cos(theta), theta growing with the length of the curve.

        It grows 1 + WAIST times as fast halfway as on the average.
        """
        theta = np.pi * (np.arange(degree) + 0.5) / degree

        def off(rho, z, s, t):
            return s - 0.5 * WAIST / np.pi * np.sin(2.0 * np.pi * s) - t / np.pi

        rho, z = self._points(off, theta)
        return interpolated(rho / np.sin(theta)), interpolated(z)


def interpolated(values):
    """The polynomial in cos(theta) with these values at cell-centered theta, without its rounding."""
    n = len(values)
    theta = np.pi * (np.arange(n) + 0.5) / n
    c = 2.0 / n * np.cos(np.outer(np.arange(n), theta)) @ values
    c[0] *= 0.5
    last = int(np.flatnonzero(np.abs(c) > 2e-15 * np.abs(c).max())[-1]) + 1
    return lambda z: chebyshev.chebval(z, c[:last])


def last_distance():
    """The largest distance with a common horizon, equal masses whose sum is 1, and its height."""

    def distance(height):
        def off(d):
            return Holes((0.5, 0.5), d).shot(height, 1, 0.0).y[2, -1] - 0.5 * np.pi

        return brentq(off, 0.76, 0.77, xtol=1e-15)

    found = minimize_scalar(lambda h: -distance(h), bracket=(0.630, 0.6325, 0.635), tol=1e-6)
    return -found.fun, found.x


def flat_waist():
    """The distance, of equal masses whose sum is 1, at which K = 0 on the equator of the outer horizon."""

    def curvature(d):
        top = float(np.interp(d, (0.6, 0.7), (0.603358540, 0.629421811)))
        horizon = Holes((0.5, 0.5), d).horizon(top, -top)
        return horizon.equator_curvature

    return brentq(curvature, 0.62, 0.64, xtol=1e-12)


TABLE = {  # masses, distance, heights on the axis, plane; what findings of another computation say
    "equal, d = 0.5, outer": ((0.5, 0.5), 0.5, 0.576438845, -0.576438845, 0.0),
    "equal, d = 0.6, outer": ((0.5, 0.5), 0.6, 0.603358540, -0.603358540, 0.0),
    "equal, d = 0.7, outer": ((0.5, 0.5), 0.7, 0.629421811, -0.629421811, 0.0),
    "equal, d = 0.765, outer": ((0.5, 0.5), 0.765, 0.635604616, -0.635604616, 0.0),
    "equal, d = 0.5, inner": ((0.5, 0.5), 0.5, 0.447490688, -0.447490688, 0.0),
    "equal, d = 0.5, individual": ((0.5, 0.5), 0.5, 0.417, 0.083, 0.25),
    "equal, d = 1.0, individual": ((0.5, 0.5), 1.0, 0.70, 0.30, 0.5),
    "(0.2, 0.8), d = 0.5, outer": ((0.2, 0.8), 0.5, 0.5, -0.65, -0.1),
}
