"""Surfaces whose energies are known, by nothing but closed forms and Gauss's quadrature.

A `Body` is symmetric about its axis; a `Placing` (unit, rotation, warp) hides that without changing what is
true.  Nothing of isoembed is used here.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

STEP = 1e-30  # of complex differentiation
NODES = 300  # in each of two halves of the meridian
ENERGIES = (
    "area",
    "integrated_mean_curvature",
    "irreducible_mass",
    "christodoulou_mass",
    "hawking",
    "brown_york",
    "liu_yau",
)
INTRINSIC = ("area", "irreducible_mass", "hawking")  # without an embedding
POWERS = {"area": 2}  # of the unit of length; the others have the first


def nothing(theta):
    return np.zeros_like(theta)


@dataclass(frozen=True)
class Body:
    """A surface ds^2 = E dtheta^2 + P sin^2(theta) dphi^2, with k and p.

    Functions of theta, all but k and p of complex ones, too.  `marginal`: k^2 = p^2 is taken for granted.
    `norm2`: k^2 - p^2, where k itself is not known.  `j`: K(d_phi, n) over sin^2, which tells the mass.
    """

    name: str
    E: Callable
    P: Callable
    k: Callable | None = None
    p: Callable = nothing
    norm2: Callable | None = None
    marginal: bool = False
    j: Callable | None = None
    mass: float | None = None

    def product(self, w, a, b):
        """Of vectors (n, 3) tangent at w, unit vectors, in the metric."""
        flat = np.hypot(w[:, 0], w[:, 1])
        theta = np.arctan2(flat, w[:, 2])
        around = np.stack([-w[:, 1], w[:, 0], 0.0 * flat], axis=1) / np.where(flat > 0.0, flat, 1.0)[:, None]
        around[flat == 0.0] = [0.0, 1.0, 0.0]
        along = np.cross(around, w)
        E, P = self.E(theta), self.P(theta)
        return E * dot(along, a) * dot(along, b) + P * dot(around, a) * dot(around, b)

    def values(self, function, w):
        """Its k or p at w (n, 3)."""
        return function(np.arctan2(np.hypot(w[:, 0], w[:, 1]), w[:, 2])) + 0.0 * w[:, 0]

    def truth(self):
        """The energies by name, None where one is not known."""
        x, w = np.polynomial.legendre.leggauss(NODES)
        theta = np.concatenate([np.pi / 4 * (1 + x), np.pi / 4 * (3 + x)])
        w = np.tile(np.pi / 4 * w, 2)
        complex_theta = theta + 1j * STEP
        rho = np.sin(complex_theta) * np.sqrt(self.P(complex_theta))
        E = np.real(self.E(theta)) + 0.0 * theta
        slope, rho = rho.imag / STEP, rho.real
        fall = np.sqrt(np.maximum(E - slope**2, 0.0))  # -dz / d theta
        dA = 2.0 * np.pi * w * rho * np.sqrt(E)
        k = None if self.k is None else self.k(theta) + 0.0 * theta
        norm2 = self.norm2(theta) if self.norm2 else None if k is None else k**2 - self.p(theta) ** 2
        # int rho d psi, psi the angle of the meridian, is - int psi d rho.
        H = np.pi * float(w @ (fall - np.arctan2(fall, slope) * slope))
        found = energies_of(dA, H, k, 0.0 * dA if self.marginal else norm2)
        return found | {"christodoulou_mass": self.mass}


def energies_of(dA, integrated_mean_curvature, k, norm2):
    """The energies by name from areas (n,), int H dA, k and k^2 - p^2 (n,)."""
    area = float(dA.sum())
    m = np.sqrt(area / (16.0 * np.pi))
    reference = integrated_mean_curvature / (4.0 * np.pi)
    return {
        "area": area,
        "integrated_mean_curvature": integrated_mean_curvature,
        "irreducible_mass": m,
        "christodoulou_mass": None,
        "hawking": None if norm2 is None else m * (1.0 - float(dA @ norm2) / (16.0 * np.pi)),
        "brown_york": None if k is None else reference - float(dA @ k) / (8.0 * np.pi),
        "liu_yau": None
        if norm2 is None or norm2.min() < 0.0
        else reference - float(dA @ np.sqrt(norm2)) / (8.0 * np.pi),
    }


def ball(radius, k=None, p=nothing, name="round sphere", **options):
    square = radius**2
    return Body(name, lambda t: square + 0.0 * t, lambda t: square + 0.0 * t, k, p, **options)


def schwarzschild(r, slice_="static"):
    """The sphere of areal radius r, M = 1, in the static, Kerr-Schild or Painleve-Gullstrand slice."""
    f = 1.0 - 2.0 / r
    k2 = {"static": f, "kerr-schild": 1.0 / (1.0 + 2.0 / r), "painleve-gullstrand": 1.0}[slice_]
    k, p = 2.0 / r * np.sqrt(k2), 2.0 / r * np.sqrt(k2 - f)
    return ball(r, lambda t: k + 0.0 * t, lambda t: p + 0.0 * t, f"r = {r:g}, {slice_}")


def kerr_horizon(a):
    r = 1.0 + np.sqrt(1.0 - a * a)

    def sigma(t):
        return r * r + (a * np.cos(t)) ** 2

    return Body(f"Kerr horizon {a:g}", sigma, lambda t: (r * r + a * a) ** 2 / sigma(t), marginal=True)


def spinning(a):
    """The horizon with K(., n), too."""
    body, r = kerr_horizon(a), 1.0 + np.sqrt(1.0 - a * a)

    def j(t):
        s, sigma = np.sin(t) ** 2, body.E(t)
        A = (r * r + a * a) ** 2
        dragging = a * (2.0 - 2.0 * r * (4.0 * r * (r * r + a * a) - 2.0 * a * a * (r - 1.0) * s) / A) / A
        return -0.5 * (A / sigma) ** 1.5 * dragging / np.sqrt(sigma)

    return replace(body, name=f"spinning hole {a:g}", j=j, mass=1.0)


def kerr_sphere(r, a):
    """Boyer-Lindquist r = const with its k there, where p = 0."""

    def sigma(t, r=r):
        return r * r + (a * np.cos(t)) ** 2

    def P(t, r=r):
        return r * r + a * a + 2.0 * r * (a * np.sin(t)) ** 2 / sigma(t, r)

    def k(t):
        s = r + 1j * STEP
        growth = np.log(sigma(t, s) * P(t, s)).imag / (2.0 * STEP)
        return np.sqrt((r * r - 2.0 * r + a * a) / sigma(t)) * growth

    return Body(f"Kerr r = {r:g}, a = {a:g}", sigma, P, k)


def isotropic(radius, offset=0.0, bulge=0.0):
    """|x - offset e_z| = radius + bulge cos^2 in isotropic Schwarzschild, M = 1; one of the two is zero."""

    def shape(t):
        c, s = np.cos(t), np.sin(t)
        return radius + bulge * c**2, -2.0 * bulge * c * s, -2.0 * bulge * (c**2 - s**2)

    def psi(t, r):
        return 1.0 + 0.5 / np.sqrt(r**2 + offset**2 + 2.0 * r * offset * np.cos(t))

    def E(t):
        r, slope, _ = shape(t)
        return psi(t, r) ** 4 * (r**2 + slope**2)

    def P(t):
        r = shape(t)[0]
        return psi(t, r) ** 4 * r**2

    def k(t):
        r, slope, bend = shape(t)
        root = np.sqrt(r**2 + slope**2)
        flat = (r**2 + 2.0 * slope**2 - r * bend) / root**3 + (1.0 + 2.0 * bulge * np.cos(t) ** 2 / r) / root
        factor = psi(t, r)
        outward = psi(t, r + 1j * STEP).imag / STEP * r / root
        return (flat + 4.0 * outward / factor) / factor**2

    return Body(f"isotropic {radius:g}, {offset:g} off, {bulge:g} bulged", E, P, k)


def boosted(rho, speed):
    """The sphere of isotropic radius rho, M = 1, at one time of an observer whom it passes.

    It is the graph t' = f(theta) in the cylinder r = const of Schwarzschild's spacetime.
    """
    psi, N = 1.0 + 0.5 / rho, (rho - 0.5) / (rho + 0.5)
    R = psi**2 * rho
    radial_slope = (rho - 0.5) / (rho + 0.5)  # dR / d(proper radius)
    lapse_slope = 1.0 / ((rho + 0.5) ** 2 * psi**2)

    def slope(t):
        return speed * rho * np.sin(t)

    def norm2(t):
        f, g = slope(t), slope(t + 1j * STEP).imag / STEP
        along = R * R - (N * f) ** 2
        radial = radial_slope / R + (R * radial_slope - N * lapse_slope * f**2) / along
        # The mean curvature of the graph within the cylinder; f / sin(theta) is smooth.
        W = np.sqrt(along) / R
        inside = N * (speed * rho * np.cos(t) + g + N**2 * f**2 * g / (R * W) ** 2) / (R * R * W)
        return radial**2 - inside**2

    return Body(
        f"boosted {speed:g}, rho = {rho:g}",
        lambda t: R * R - (N * slope(t)) ** 2,
        lambda t: R * R + 0.0 * t,
        norm2=norm2,
        marginal=rho == 0.5,
    )


def kinked(power, size, of_k=False):
    """A sphere whose equator is a kink of this power, in its metric or in k alone."""

    def bump(t):
        return 1.0 + size * (np.cos(t) * np.sign(np.cos(t).real)) ** power

    if of_k:
        return ball(1.0, bump, name=f"kink {power} in k")
    return Body(f"kink {power} in q", lambda t: bump(t) ** 2, lambda t: bump(t) ** 2, lambda t: 1.5 + 0.0 * t)


@dataclass(frozen=True)
class Placing:
    """How a body lies against the grid: w = rotation @ warped u, all lengths times the unit.

    `warp` and `fold`: u moves by warp times Re ((x + i y) exp(i phase))^fold along z before it is made a
    unit vector again; fold 0: a map of all directions.
    """

    unit: float = 1.0
    rotation: np.ndarray = field(default_factory=lambda: np.eye(3))
    warp: float = 0.0
    fold: int = 0
    phase: float = 0.0

    def moved(self, u):
        """Directions (n, 3), which may be complex, on the body's own sphere."""
        x, y, z = u.T
        if self.fold:
            shift = np.stack([0.0 * x, 0.0 * x, wave(u, self.fold, self.phase)], axis=1)
        else:
            shift = np.stack([y**2, z * x, x**2 - y * z], axis=1)
        v = u + self.warp * shift
        return v / np.sqrt((v**2).sum(axis=1))[:, None] @ self.rotation.T

    def components(self, body, theta, phi):
        """q_tt, q_tp, q_pp on the grid (n, m)."""
        u, shape = directions(theta, phi)
        along, _ = directions(theta + np.pi / 2, phi)
        around = np.stack([-u[:, 1], u[:, 0], 0.0 * u[:, 2]], axis=1)
        w = self.moved(u)
        d = [self.moved(u + 1j * STEP * v).imag / STEP for v in (along, around)]
        pairs = ((0, 0), (0, 1), (1, 1))
        return [self.unit**2 * body.product(w, d[i], d[j]).reshape(shape) for i, j in pairs]

    def values(self, body, function, theta, phi):
        """The body's k or p on the grid (n, m)."""
        u, shape = directions(theta, phi)
        return body.values(function, self.moved(u)).reshape(shape) / self.unit

    def one_form(self, body, theta, phi):
        """Components of the body's K(., n) for theta and phi on the grid, each (n, m)."""
        u, shape = directions(theta, phi)
        along, _ = directions(theta + np.pi / 2, phi)
        around = np.stack([-u[:, 1], u[:, 0], 0.0 * u[:, 2]], axis=1)
        w = self.moved(u)
        form = body.values(body.j, w)[:, None] * np.stack([-w[:, 1], w[:, 0], 0.0 * w[:, 2]], axis=1)
        return [dot(form, self.moved(u + 1j * STEP * v).imag / STEP).reshape(shape) for v in (along, around)]

    def scaled(self, truth):
        """Energies in this unit."""
        return {
            name: value if value is None else value * self.unit ** POWERS.get(name, 1)
            for name, value in truth.items()
        }


def rotation(seed):
    """A rotation matrix."""
    q, r = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    q *= np.sign(np.diag(r))
    return q * np.linalg.det(q)


@dataclass(frozen=True)
class Ellipsoid:
    """X = (a x, b y, c z) of the direction u = (x, y, z), with any k and p of u."""

    name: str
    axes: tuple
    k: Callable = lambda u: 1.5 + 0.3 * u[:, 0] * u[:, 1]
    p: Callable = lambda u: 0.4 * u[:, 2]
    marginal: bool = False

    def product(self, w, a, b):
        """As of a `Body`."""
        return dot(a * np.array(self.axes), b * np.array(self.axes))

    def values(self, function, w):
        """As of a `Body`."""
        return function(w) + 0.0 * w[:, 0]

    def truth(self):
        """As of a `Body`."""
        z, w = np.polynomial.legendre.leggauss(160)
        u, _ = directions(np.arccos(z), np.arange(320) * (np.pi / 160))
        w, axes = np.repeat(w, 320) * (np.pi / 160), np.array(self.axes)
        dA = w * np.prod(axes) * np.linalg.norm(u / axes, axis=1)
        # int H dA is the integral of the support function over the directions of the normals.
        H = float(w @ np.linalg.norm(u * axes, axis=1))
        return energies_of(dA, H, self.k(u), self.k(u) ** 2 - self.p(u) ** 2)


class StarEllipsoid(Ellipsoid):
    """The same surface by the directions of its points, in which its metric is no polynomial."""

    def product(self, w, a, b):
        """As of a `Body`."""
        return super().product(*(self._own(w, v) for v in (w, a, b)))

    def values(self, function, w):
        """As of a `Body`."""
        return super().values(function, self._own(w, w))

    def _own(self, w, v):
        """The ellipsoid's own direction of the points in the directions w; how it changes with w along v."""
        axes = np.array(self.axes)
        length = np.linalg.norm(w / axes, axis=1)[:, None]
        if v is w:
            return w / axes / length
        u = w / axes / length
        return (v / axes - u * dot(u, v / axes)[:, None]) / length


def kerr_schild_sphere(a, height, radius, nodes=200):
    """Area of a coordinate sphere about a point of the spin's axis in the Kerr-Schild slice, M = 1.

    The slice's metric is the flat one and 2 H l_i l_j, l a unit covector.
    """
    c, weights = np.polynomial.legendre.leggauss(nodes)
    rho, z = radius * np.sqrt(1.0 - c * c), height + radius * c
    excess = rho**2 + z**2 - a * a
    r2 = 0.5 * (excess + np.sqrt(excess**2 + 4.0 * (a * z) ** 2))
    r = np.sqrt(r2)
    H = r**3 / (r2**2 + (a * z) ** 2)
    along = (r * rho / (r2 + a * a) * rho + z / r * radius * c) / radius  # l along the normal
    return float(2.0 * np.pi * radius**2 * weights @ np.sqrt(1.0 + 2.0 * H * (1.0 - along**2)))


def dot(a, b):
    return np.einsum("ni,ni->n", a, b)


def directions(theta, phi):
    """Unit vectors (n m, 3) at the nodes of a grid, and (n, m)."""
    t, f = np.meshgrid(theta, phi, indexing="ij")
    return np.stack([np.sin(t) * np.cos(f), np.sin(t) * np.sin(f), np.cos(t)], axis=-1).reshape(
        -1, 3
    ), t.shape


def wave(u, fold, phase=0.0):
    """Re ((x + i y) exp(i phase))^fold, of complex u (n, 3), too."""
    a, b = np.cos(phase) + 0.0 * u[:, 0], np.sin(phase) + 0.0 * u[:, 0]
    for _ in range(fold):
        a, b = a * u[:, 0] - b * u[:, 1], a * u[:, 1] + b * u[:, 0]
    return a


def peaked(width):
    """A function of the direction that is high at x = 1/2."""
    return lambda u: 1.0 + 0.3 / (1.0 + ((u[:, 0] - 0.5) / width) ** 2)
