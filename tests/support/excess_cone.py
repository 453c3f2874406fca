"""Cones with too much angle, which bend least: closed elastic curves on the unit sphere.

The directions u(s) of the rulings are a curve of the length 2 pi + surplus, whose curvature k has
``k'' + k^3 / 2 + (1 - tension) k = 0``; int k1^2 + k2^2 between two distances from the apex is
``ln(r2 / r1)`` times that of k^2 ds (Mueller, Ben Amar, Guven, arXiv:0807.1814).
"""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve

import discs
from isoembed import PolyhedralMetric


def elastic_curve(surplus, waves=2):
    """The integral of k^2 ds, and the angle of the highest ruling over the plane of symmetry."""
    first = np.sqrt(2 * 2 * (waves**2 - 1) * 0.05 / (2 * np.pi)), 1 - waves**2  # of small surplus
    for part in np.linspace(0.05, surplus, 10):
        quarter = (2 * np.pi + part) / (4 * waves)
        first = fsolve(lambda p, q=quarter: _missed(*p, q, waves), first, xtol=1e-12)
    end = _quarter(*first, quarter)
    axis, _ = _axes(end)
    return 4 * waves * end[11], float(np.arctan2(abs(axis[0]), abs(axis[2])))


def _quarter(curvature, tension, length):
    """k, k', u, its tangent and normal, and int k^2 ds at the end of a quarter of a wave."""

    def rates(_, y):
        k, u, t, n = y[0], y[2:5], y[5:8], y[8:11]
        return np.concatenate([[y[1], -(k**3) / 2 - (1 - tension) * k], t, k * n - u, -k * t, [k * k]])

    start = [curvature, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0]
    return solve_ivp(rates, (0, length), start, rtol=1e-10, atol=1e-12).y[:, -1]


def _missed(curvature, tension, length, waves):
    """The curvature at the end, which is an inflection, and how far that is turned about the axis."""
    end = _quarter(curvature, tension, length)
    _, across = _axes(end)
    return end[0], np.arctan2(end[3], end[2:5] @ across) - np.pi / (2 * waves)


def _axes(end):
    """The axis of symmetry, which the inflection is perpendicular to, and what is across it in the mirror."""
    u = end[2:5]
    axis = np.array([-u[2], 0.0, u[0]]) / np.hypot(u[0], u[2])
    return axis, np.array([axis[2], 0.0, -axis[0]])


def cone_metric(rings, surplus):
    """A disc of radius 1 in rings about an apex with the angle 2 pi + surplus, and a saddle to start from."""
    points, faces = discs.hexagonal(rings)
    r, phi = np.linalg.norm(points, axis=1), np.arctan2(points[:, 1], points[:, 0])
    a, b = PolyhedralMetric.from_mesh(discs.round_cap(points, 1.0), faces).edges.T
    turn = np.abs(phi[a] - phi[b])
    turn = np.minimum(turn, 2 * np.pi - turn) * (1 + surplus / (2 * np.pi))
    turn[(r[a] == 0) | (r[b] == 0)] = 0.0
    lengths = np.sqrt(r[a] ** 2 + r[b] ** 2 - 2 * r[a] * r[b] * np.cos(turn))
    start = np.column_stack([points, 0.4 * r * np.cos(2 * phi)])
    return PolyhedralMetric(faces, lengths, np.stack([a, b], axis=1)), start
