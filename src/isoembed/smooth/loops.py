# cython: boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False, infer_types=True
"""Compiled loops over spherical harmonics."""

from __future__ import annotations

import numpy as np
from cython.cimports.isoembed.c_types import Complex, ConstComplex, ConstReal, Real
from cython.cimports.isoembed.intrinsic.chart import point


def summed(
    u: ConstReal[:, ::1],
    table: ConstComplex[:, :, ::1],
    a: ConstReal[:, ::1],
    b: ConstReal[:, ::1],
    sectoral: ConstReal[::1],
):
    """Sums of harmonics at u (n, 3), with the derivatives of their extension to R^3.

    Their shapes are (n, c), (n, c, 3) and (n, c, 3, 3).  A table of harmonics, which would take most of the
    time, is avoided; sums that depend on z only are shared by consecutive directions with the same z.
    """
    n, orders, degrees, count = u.shape[0], table.shape[0], table.shape[1], table.shape[2]
    value: Real[:, ::1] = np.zeros((n, count))
    gradient: Real[:, :, ::1] = np.zeros((n, count, 3))
    hessian: Real[:, :, :, ::1] = np.zeros((n, count, 3, 3))
    f0: Complex[:, ::1] = np.empty((orders, count), np.complex128)
    f1: Complex[:, ::1] = np.empty((orders, count), np.complex128)
    f2: Complex[:, ::1] = np.empty((orders, count), np.complex128)
    w0: Complex
    w1: Complex
    w2: Complex
    p0: Real
    p1: Real
    p2: Real
    for i in range(n):
        z = u[i, 2]
        w = point(u[i, 0], u[i, 1])
        if i == 0 or z != u[i - 1, 2]:
            for m in range(orders):
                p0, p1, p2 = sectoral[m], 0.0, 0.0
                before0, before1, before2 = 0.0, 0.0, 0.0
                for c in range(count):
                    f0[m, c], f1[m, c], f2[m, c] = p0 * table[m, m, c], 0.0j, 0.0j
                for l in range(m + 1, degrees):
                    next0 = a[m, l] * z * p0 - b[m, l] * before0
                    next1 = a[m, l] * (z * p1 + p0) - b[m, l] * before1
                    next2 = a[m, l] * (z * p2 + 2.0 * p1) - b[m, l] * before2
                    before0, before1, before2 = p0, p1, p2
                    p0, p1, p2 = next0, next1, next2
                    for c in range(count):
                        f0[m, c] = f0[m, c] + p0 * table[m, l, c]
                        f1[m, c] = f1[m, c] + p1 * table[m, l, c]
                        f2[m, c] = f2[m, c] + p2 * table[m, l, c]
        w0, w1, w2 = 1.0 + 0.0j, 0.0j, 0.0j  # w^m and its derivatives
        for m in range(orders):
            for c in range(count):
                g0, g1, g2 = f0[m, c], f1[m, c], f2[m, c]
                value[i, c] += (g0 * w0).real
                gradient[i, c, 0] += (g0 * w1).real
                gradient[i, c, 1] -= (g0 * w1).imag
                gradient[i, c, 2] += (g1 * w0).real
                hessian[i, c, 0, 0] += (g0 * w2).real
                hessian[i, c, 0, 1] -= (g0 * w2).imag
                hessian[i, c, 0, 2] += (g1 * w1).real
                hessian[i, c, 1, 2] -= (g1 * w1).imag
                hessian[i, c, 2, 2] += (g2 * w0).real
            w0, w1, w2 = w0 * w, w1 * w + w0, w2 * w + 2.0 * w1
        for c in range(count):
            hessian[i, c, 1, 1] = -hessian[i, c, 0, 0]
            hessian[i, c, 1, 0] = hessian[i, c, 0, 1]
            hessian[i, c, 2, 0] = hessian[i, c, 0, 2]
            hessian[i, c, 2, 1] = hessian[i, c, 1, 2]
    return np.asarray(value), np.asarray(gradient), np.asarray(hessian)
