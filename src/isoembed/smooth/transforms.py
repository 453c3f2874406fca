"""Coefficients of functions in spherical harmonics: from a Gauss rule, resized."""

import numpy as np

from isoembed.arrays import Floats, Mask
from isoembed.meshing.sphere import directions_at
from isoembed.smooth.harmonics import Harmonics


def resized(coefficients: Floats, old: Harmonics, new: Harmonics) -> Floats:
    """Coefficients (size, c) of functions in other harmonics: cut off or filled up with zeros."""
    place = {label: i for i, label in enumerate(zip(*new.labels, strict=True))}
    result = np.zeros((new.size, coefficients.shape[1]))
    for i, label in enumerate(zip(*old.labels, strict=True)):
        if label in place:
            result[place[label]] = coefficients[i]
    return result


def trimmed(coefficients: Floats, harmonics: Harmonics, needed: Mask) -> tuple[Floats, Harmonics]:
    """Coefficients (size, ...) in the lowest degree and order that hold all of those that are needed."""
    degrees, orders = harmonics.labels
    fewer = Harmonics(int(degrees[needed].max()), int(np.abs(orders[needed]).max()))
    kept = (degrees <= fewer.degree) & (np.abs(orders) <= fewer.order)
    return coefficients[kept], fewer


def analyzed(
    values: Floats, u: Floats, weights: Floats, degree: int, order: int | None = None
) -> tuple[Floats, Harmonics]:
    """Coefficients (size,) of a function on a Gauss rule of degree + 1 circles of latitude.

    Parameters
    ----------
    values : ndarray, shape (n,)
        At the nodes.
    u, weights : ndarray, shapes (n, 3), (n,)
        A `gauss_rule`.
    degree, order : int
        Of the harmonics, by default in all orders; each circle has more than twice as many nodes.

    Notes
    -----
    Fourier series on each circle, then Legendre series in each order.
    """
    harmonics = Harmonics(degree, degree if order is None else order)
    around = len(values) // (degree + 1)
    z, w = u[::around, 2], weights[::around, None] * (0.5 * around)
    Y = harmonics.values(directions_at(z, 0.0))
    fourier = np.fft.rfft(values.reshape(-1, around), axis=1) * (2.0 / around)
    fourier[:, 0] *= 0.5
    coefficients = np.empty(harmonics.size)
    _, orders = harmonics.labels
    for m in range(harmonics.order + 1):
        P, f = Y[:, orders == m], fourier[:, m : m + 1]
        projection = (w if m else 2.0 * w) * P
        c = projection.T @ f
        c += projection.T @ (f - P @ c)  # the weights of long rules have lost two digits
        coefficients[orders == m] = c[:, 0].real
        if m:
            coefficients[orders == -m] = -c[:, 0].imag
    return coefficients, harmonics
