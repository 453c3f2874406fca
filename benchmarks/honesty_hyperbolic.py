"""Inputs of honesty.py in the least hyperbolic space: noisy horizons, twisted coordinates, extreme Kerr.

What is true comes from quadratures of the meridian in extended precision; nothing of isoembed is used for it.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from itertools import pairwise

import numpy as np

from honesty_grids import Case
from honesty_surfaces import sampled
from honesty_truth import kerr_horizon, rotation
from isoembed.meshing.sphere import fibonacci_directions
from isoembed.relativity import (
    KerrNewmanHorizon,
    KerrSchild,
    StarSurface,
    SurfaceData,
    embed_surface,
    find_horizon,
)
from isoembed.smooth import GridMetric, PulledBack

SPIN = 0.93
POINTS = ((600, 1e-6), (600, 1e-4), (2000, 1e-3))
SOUGHT = ("area", "integrated_mean_curvature", "liu_yau")
STEP = 1e-7  # of differences in extended precision


def in_space(q_tt, rho2, k):
    """Area, int H dA and int 2 H dA / 8 pi of a surface of revolution in the space of curvature k.

    Parameters
    ----------
    q_tt, rho2 : callable
        The metric q_tt dtheta^2 + rho2 dphi^2, functions of theta in extended precision, even about pi / 2.
    """
    x, w = np.polynomial.legendre.leggauss(200)
    edges = np.linspace(np.longdouble(0.0), np.arccos(np.longdouble(0.0)), 9)
    area = H = np.longdouble(0.0)
    for a, b in pairwise(edges):
        t = a + (b - a) * (1.0 + x.astype(np.longdouble)) / 2.0
        rho = np.sqrt(rho2(t))
        near = [np.sqrt(rho2(t + j * STEP)) for j in (-2, -1, 1, 2)]
        slope = (near[0] - near[3] + 8.0 * (near[2] - near[1])) / (12.0 * STEP)
        bent = k * rho**2
        fall = np.sqrt(np.maximum(q_tt(t) * (1.0 - bent) - slope**2, 0.0))
        dt = w * (b - a) / 2.0
        area += dt @ (4.0 * np.pi * rho * np.sqrt(q_tt(t)))
        # At the pole the meridian's angle is 0, on the equator pi / 2, and int rho d(angle) is by parts.
        H += 2.0 * np.pi * (dt @ (fall * (1.0 - 2.0 * bent) / (1.0 - bent) - np.arctan2(fall, slope) * slope))
    rim = np.sqrt(rho2(edges[-1:]))[0]
    H = float(H + np.pi**2 * rim)
    return {"area": float(area), "integrated_mean_curvature": H, "liu_yau": H / (4.0 * np.pi)}


@cache
def kerr(a):
    """The truth for the Kerr horizon, whose K is least at the poles."""
    body, r = kerr_horizon(np.longdouble(a)), 1.0 + np.sqrt(1.0 - np.longdouble(a) ** 2)
    k = min((r * r - 3.0 * a * a) / (r * r + a * a) ** 2, 0.0)
    return in_space(body.E, lambda t: np.sin(t) ** 2 * body.P(t), k)


@dataclass(frozen=True)
class Boosted:
    """The Kerr horizon at one time of an observer who moves along its spin."""

    a: float
    v: float
    axes: np.ndarray

    def metric(self):
        r = 1.0 + np.sqrt(1.0 - self.a**2)
        s = np.hypot(r, self.a)

        def differential(u):
            return np.broadcast_to(np.diag([s, s, r]) @ self.axes.T, (len(u), 3, 3))

        def ambient(u):
            x, y, z = (u @ self.axes * [s, s, r]).T
            null = [(r * x + self.a * y) / s**2, (r * y - self.a * x) / s**2, z / r + self.v]
            l = np.stack(null, axis=1)
            H = r**3 / (r**4 + (self.a * z) ** 2)
            flat = np.diag([1.0, 1.0, 1.0 - self.v**2])
            return flat + (2.0 * H)[:, None, None] * l[:, :, None] * l[:, None, :]

        return PulledBack(differential, ambient)


def solved(data):
    return embed_surface(data, space="hyperbolic").energies


def case(name, truth, data: Callable, kind="hyperbolic"):
    return Case(kind, name, truth, lambda: solved(data()), sought=SOUGHT)


@cache
def hole():
    return KerrSchild(1.0, tuple(SPIN * np.array([0.48, 0.6, 0.64])))


def cloud(count, level, seed):
    rng = np.random.default_rng([seed, count])
    u = rng.normal(size=(count, 3))
    u /= np.linalg.norm(u, axis=1)[:, None]
    x = hole().spheroid(hole().horizon)(u)[:, None] * u
    return StarSurface.from_points(x + level * rng.normal(size=x.shape), (0.0, 0.0, 0.0))


def found(spacing):
    reach = float(hole().spheroid(hole().horizon)(fibonacci_directions(50)).max()) + 0.6
    return find_horizon(sampled(hole(), spacing, reach, 0.0)).data()


def on_grid(n, level, seed):
    turned = rotation(5)
    metric = Boosted(SPIN, 0.0, turned).metric()
    exact, rng = GridMetric.sampled(metric, n, 2 * n), np.random.default_rng([seed, n])
    noisy = (q * (1.0 + level * rng.normal(size=q.shape)) for q in (exact.q_tt, exact.q_tp, exact.q_pp))
    return SurfaceData(GridMetric(exact.theta, exact.phi, *noisy), marginal=True)


def cases(seeds):
    """All of them."""
    for spacing in (0.094, 0.064):
        yield case(f"found on a grid, spacing {spacing:g}", kerr(SPIN), lambda h=spacing: found(h))
    for seed in range(seeds):
        for count, level in POINTS:
            yield case(
                f"{count} points, noise {level:g}",
                kerr(SPIN),
                lambda n=count, e=level, k=seed: cloud(n, e, k).data(hole(), marginal=True),
            )
        for n, level in ((24, 0.0), (24, 1e-6), (48, 1e-8)):
            yield case(
                f"{n} x {2 * n} grid, noise {level:g}",
                kerr(SPIN),
                lambda n=n, e=level, k=seed: on_grid(n, e, k),
            )
    for a in (0.95, 1.0):
        yield case(f"Kerr horizon {a:g}", kerr(a), KerrNewmanHorizon(1.0, a).data, "revolved")
    for a, v, seed in ((0.8, 0.5, 1), (0.95, 0.3, 2), (0.95, 0.8, 3)):
        yield case(
            f"boosted along its spin {a:g} by {v:g}",
            kerr(a),
            lambda a=a, v=v, k=seed: SurfaceData(Boosted(a, v, rotation(k)).metric(), marginal=True),
            "revolved",
        )
