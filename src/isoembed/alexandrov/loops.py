# cython: boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False, infer_types=True
"""Compiled loops over the pyramids of a polytope."""

from __future__ import annotations

import cython
import numpy as np
from cython.cimports.isoembed.c_types import ConstInt, ConstReal, Flag, Int, Real
from cython.cimports.isoembed.intrinsic.loops import following, preceding
from cython.cimports.isoembed.space.trigonometry import arc, twice_area
from cython.cimports.libc.math import atan2, sqrt

INF = cython.declare(cython.double, float("inf"))
PI = cython.declare(cython.double, 3.141592653589793)


def built(corners: ConstInt[::1], twins: ConstInt[::1], lengths: ConstReal[::1], r: ConstReal[::1]):
    """Unit vectors from the apex, shape (V, 3), by placing pyramid after pyramid, breadth first."""
    x: Real[:, ::1] = np.zeros((r.shape[0], 3))
    placed: Flag[::1] = np.zeros(r.shape[0], dtype=np.bool_)
    visited: Flag[::1] = np.zeros(corners.shape[0] // 3, dtype=np.bool_)
    queue: Int[::1] = np.empty(corners.shape[0] // 3, dtype=np.int64)
    foot = _foot(0, corners, twins, lengths, r)
    side = sqrt(max(r[corners[0]] * r[corners[0]] - foot * foot, 0.0))
    x[corners[0], 0], x[corners[0], 2] = -foot, side
    x[corners[twins[0]], 0], x[corners[twins[0]], 2] = lengths[0] - foot, side
    placed[corners[0]] = placed[corners[twins[0]]] = True
    queue[0], visited[0] = 0, True
    first: Int = 0
    last: Int = 1
    while first < last:
        h = queue[first]
        first += 1
        k = corners[preceding(h)]
        if not placed[k]:
            _place_across(h, x, corners, twins, lengths, r)
            placed[k] = True
        for turn in range(3):
            e = following(h) if turn == 0 else preceding(h) if turn == 1 else h
            t = twins[e]
            if not visited[t // 3]:
                visited[t // 3] = True
                queue[last] = t
                last += 1
    for v in range(r.shape[0]):
        size = max(sqrt(x[v, 0] * x[v, 0] + x[v, 1] * x[v, 1] + x[v, 2] * x[v, 2]), 1e-300)
        for c in range(3):
            x[v, c] /= size
    return np.asarray(x)


@cython.cfunc
@cython.exceptval(check=False)
def _foot(
    h: Int, corners: ConstInt[::1], twins: ConstInt[::1], lengths: ConstReal[::1], r: ConstReal[::1]
) -> Real:
    """Distance along half-edge i -> j of the foot of the perpendicular from the apex."""
    a, b = r[corners[h]], r[corners[twins[h]]]
    return (lengths[h] + (a - b) * (a + b) / lengths[h]) / 2


@cython.cfunc
@cython.exceptval(check=False)
def _place_across(
    h: Int,
    x: Real[:, ::1],
    corners: ConstInt[::1],
    twins: ConstInt[::1],
    lengths: ConstReal[::1],
    r: ConstReal[::1],
) -> cython.void:
    """Place the third corner of a face, given the ends of a half-edge, in a frame of the edge."""
    e0: Real
    e1: Real
    e2: Real
    w0: Real
    w1: Real
    w2: Real
    part: Real
    i, j, k = corners[h], corners[following(h)], corners[preceding(h)]
    l, b, c = lengths[h], lengths[following(h)], lengths[preceding(h)]
    along = (l + (c - b) * (c + b) / l) / 2  # of the third corner
    height = twice_area(l, b, c) / l
    e0, e1, e2 = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1], x[j, 2] - x[i, 2]
    size = max(sqrt(e0 * e0 + e1 * e1 + e2 * e2), 1e-300)
    e0, e1, e2 = e0 / size, e1 / size, e2 / size
    foot = _foot(h, corners, twins, lengths, r)
    w0, w1, w2 = x[i, 0] + foot * e0, x[i, 1] + foot * e1, x[i, 2] + foot * e2  # from the apex to the edge
    part = w0 * e0 + w1 * e1 + w2 * e2
    w0, w1, w2 = w0 - part * e0, w1 - part * e1, w2 - part * e2
    distance = max(sqrt(w0 * w0 + w1 * w1 + w2 * w2), 1e-300)
    w0, w1, w2 = w0 / distance, w1 / distance, w2 / distance
    # The angle about the edge follows from |x_k|^2 = r_k^2; the plane contains the apex if the cosine is 0.
    reach = (along - foot) * (along - foot) + height * height + distance * distance - r[k] * r[k]
    sine = max(-1.0, min(1.0, reach / (2 * distance * max(height, 1e-300))))
    cosine = sqrt(1 - sine * sine)
    x[k, 0] = x[i, 0] + along * e0 + height * (cosine * (w1 * e2 - w2 * e1) - sine * w0)
    x[k, 1] = x[i, 1] + along * e1 + height * (cosine * (w2 * e0 - w0 * e2) - sine * w1)
    x[k, 2] = x[i, 2] + along * e2 + height * (cosine * (w0 * e1 - w1 * e0) - sine * w2)


def evaluated(
    corners: ConstInt[::1],
    twins: ConstInt[::1],
    chords: ConstReal[::1],
    sines: ConstReal[::1],
    amplitudes: ConstReal[::1],
    r: ConstReal[::1],
    s: ConstReal[::1],
    k4: Real,
):
    i: Int
    j: Int
    e: Int
    t: Int
    a: Real
    l: Real
    c_ij: Real
    w: Real
    both: Real
    n = r.shape[0]
    x: Real[::1] = np.ones(n)
    y: Real[::1] = np.zeros(n)
    full: Real[::1] = np.ones(n)  # remaining full turns
    kappa: Real[::1] = np.empty(n)
    slope: Real[::1] = np.empty(corners.shape[0])  # d / h
    diagonal: Real[::1] = np.zeros(n)
    lowest: Real = INF
    area: Real
    h2: Real
    q: Real
    for f in range(0, corners.shape[0], 3):
        i, j, m = corners[f], corners[f + 1], corners[f + 2]
        a, b, c = chords[f], chords[f + 1], chords[f + 2]  # ij, jm, mi
        area = amplitudes[f // 3] if amplitudes.shape[0] else twice_area(a, b, c)
        if not area > 0:
            return np.asarray(kappa), np.asarray(slope), np.asarray(diagonal), -1.0
        # Differences of squares, without cancellation.
        ij = (r[i] - r[j]) * (r[i] + r[j])
        jm = (r[j] - r[m]) * (r[j] + r[m])
        mi = (r[m] - r[i]) * (r[m] + r[i])
        # Products of two sines and the cosine between, by chords: (a^2 + b^2 - c^2) / 2 - k a^2 b^2 / 4.
        ri, rj, rm = r[i] * r[i], r[j] * r[j], r[m] * r[m]
        aa, bb, cc = k4 * (a * a), k4 * (b * b), k4 * (c * c)
        c_ij, c_ji = (a * a + ij) / 2 - aa * ri, (a * a - ij) / 2 - aa * rj
        c_jm, c_mj = (b * b + jm) / 2 - bb * rj, (b * b - jm) / 2 - bb * rm
        c_mi, c_im = (c * c + mi) / 2 - cc * rm, (c * c - mi) / 2 - cc * ri
        at_i = (a * a + (c - b) * (c + b)) / 2 - aa * (c * c)  # at a corner
        at_j = (b * b + (a - c) * (a + c)) / 2 - bb * (a * a)
        at_m = (c * c + (b - a) * (b + a)) / 2 - cc * (b * b)
        a, b, c = sines[f], sines[f + 1], sines[f + 2]
        d_ij = (a * c_im - c_ij * at_i / a) / area
        d_jm = (b * c_ji - c_jm * at_j / b) / area
        d_mi = (c * c_mj - c_mi * at_m / c) / area
        # The squared height, from the corner with the least subtraction.
        qi, qj, qm = s[i] * s[i], s[j] * s[j], s[m] * s[m]
        if qi <= qj and qi <= qm:
            h2, q = qi - c_ij / a * (c_ij / a) - d_ij * d_ij, qi
        elif qj <= qm:
            h2, q = qj - c_jm / b * (c_jm / b) - d_jm * d_jm, qj
        else:
            h2, q = qm - c_mi / c * (c_mi / c) - d_mi * d_mi, qm
        lowest = min(lowest, h2 / q)
        if not h2 > 0:
            return np.asarray(kappa), np.asarray(slope), np.asarray(diagonal), lowest
        h = sqrt(h2)
        _turn(i, qi * at_i - c_ij * c_im, s[i] * h * area, x, y, full)
        _turn(j, qj * at_j - c_jm * c_ji, s[j] * h * area, x, y, full)
        _turn(m, qm * at_m - c_mi * c_mj, s[m] * h * area, x, y, full)
        slope[f], slope[f + 1], slope[f + 2] = d_ij / h, d_jm / h, d_mi / h
    for i in range(n):
        kappa[i] = 2 * PI * full[i] - atan2(y[i], x[i])
    # Half-edges below their twins, without an unpredictable branch.
    lower: Int[::1] = np.empty(corners.shape[0] // 2 + 1, dtype=np.int64)
    count: Int = 0
    for e in range(corners.shape[0]):
        lower[count] = e
        count += e < twins[e]
    for e in lower[:count]:
        t = twins[e]
        i, j = corners[e], corners[t]
        a, l = chords[e], sines[e]
        c_ij = (a * a + (r[i] - r[j]) * (r[i] + r[j])) / 2 - k4 * (a * a) * (r[i] * r[i])
        w = (slope[e] + slope[t]) / (l * (s[i] * s[i] - c_ij / l * (c_ij / l)))
        slope[e] = slope[t] = w * s[i] * s[j]
        # scalar product of the vectors from the apex to i and j
        both = w * (s[i] * s[i] * (1 - 2 * k4 * (a * a)) - c_ij * (1 - 2 * k4 * (r[i] * r[i])))
        diagonal[i] -= both
        diagonal[j] -= both
    return np.asarray(kappa), np.asarray(slope), np.asarray(diagonal), lowest


@cython.cfunc
@cython.exceptval(check=False)
def _turn(i: Int, cosine: Real, sine: Real, x: Real[::1], y: Real[::1], full: Real[::1]) -> cython.void:
    """Rotate the vector of vertex i by the angle, less than pi, of this cosine and sine, not normalized."""
    size = sqrt(cosine * cosine + sine * sine)
    c, s = cosine / size, sine / size
    before = y[i]
    x[i], y[i] = x[i] * c - before * s, x[i] * s + before * c
    full[i] -= before >= 0 and y[i] < 0


def jacobian_product(
    corners: ConstInt[::1], coupling: ConstReal[::1], diagonal: ConstReal[::1], v: ConstReal[:, ::1]
):
    result: Real[:, ::1] = np.empty((v.shape[0], v.shape[1]))
    for i in range(v.shape[0]):
        for c in range(v.shape[1]):
            result[i, c] = diagonal[i] * v[i, c]
    for f in range(0, corners.shape[0], 3):  # each half-edge contributes to its start
        i, j, k = corners[f], corners[f + 1], corners[f + 2]
        for c in range(v.shape[1]):
            result[i, c] += coupling[f] * v[j, c]
            result[j, c] += coupling[f + 1] * v[k, c]
            result[k, c] += coupling[f + 2] * v[i, c]
    return np.asarray(result)


def distances(corners: ConstInt[::1], twins: ConstInt[::1], x: ConstReal[:, ::1], k: Real):
    scales: Real[::1] = np.empty(x.shape[0])
    for i in range(scales.shape[0]):
        scales[i] = 1 + k / 4 * (x[i, 0] * x[i, 0] + x[i, 1] * x[i, 1] + x[i, 2] * x[i, 2])
    apart: Real[::1] = np.empty(corners.shape[0])
    for h in range(corners.shape[0]):
        i, j = corners[h], corners[twins[h]]
        a, b, c = x[i, 0] - x[j, 0], x[i, 1] - x[j, 1], x[i, 2] - x[j, 2]
        apart[h] = sqrt(a * a + b * b + c * c)
        if k != 0:
            apart[h] = arc(apart[h] / sqrt(scales[i] * scales[j]), k)
    return np.asarray(apart)
