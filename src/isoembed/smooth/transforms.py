"""Coefficients of functions in spherical harmonics: from a Gauss rule, from scattered values, resized."""

from bisect import bisect_left
from dataclasses import dataclass

import numpy as np
from scipy.linalg import qr, solve_triangular, svdvals

from isoembed.arrays import Floats, Mask
from isoembed.meshing.sphere import directions_at
from isoembed.smooth.harmonics import Harmonics
from isoembed.thresholds import threshold


@dataclass(frozen=True)
class FitThresholds:
    """Thresholds of the fit of harmonics to scattered values."""

    first_degree: int = threshold(8, "count", "Highest degree tried first; it is doubled while it is needed.")
    highest_degree: int = threshold(40, "count", "Highest degree that is fitted.")
    determined: float = threshold(0.1, "relative", "Least singular value of a fit over the largest.")


FIT = FitThresholds()


def resized(coefficients: Floats, old: Harmonics, new: Harmonics) -> Floats:
    """Coefficients (size, c) of functions in other harmonics: cut off or filled up with zeros."""
    place = {label: i for i, label in enumerate(zip(*new.labels, strict=True))}
    result = np.zeros((new.size, coefficients.shape[1]))
    for i, label in enumerate(zip(*old.labels, strict=True)):
        if label in place:
            result[place[label]] = coefficients[i]
    return result


def trimmed(coefficients: Floats, harmonics: Harmonics, needed: Mask) -> tuple[Floats, Harmonics]:
    """Coefficients (size,) in the lowest degree and order that hold all of those that are needed."""
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


def fitted(u: Floats, values: Floats, weights: Floats) -> tuple[Floats, Harmonics, float]:
    """Harmonics fitted to scattered values by weighted least squares.

    Parameters
    ----------
    u : ndarray, shape (n, 3)
        Directions.
    values, weights : ndarray, shape (n,)

    Returns
    -------
    coefficients : ndarray, shape (size,)
    harmonics : Harmonics
        Their degree is the one of least generalized cross-validation: what follows is noise.  It is lower
        where holes between the directions would leave coefficients undetermined.
    misfit : float
        Root mean square of what is missed.

    References
    ----------
    G. Golub, M. Heath and G. Wahba, Technometrics 21 (1979) 215.
    """
    m = len(u)
    most = max(0, min(FIT.highest_degree, int(np.sqrt(0.5 * m)) - 1))
    highest = min(most, FIT.first_degree)
    root = np.sqrt(weights)
    while True:
        harmonics = Harmonics(highest, highest)
        by_degree = np.argsort(harmonics.labels[0], kind="stable")
        # One factorization serves all degrees: those of lower degree are its leading columns, and the data
        # as the last column become their components along them and, at the end, what is orthogonal to all.
        table = root[:, None] * np.column_stack([harmonics.values(u)[:, by_degree], values])
        (R,) = qr(table, mode="r", overwrite_a=True)
        b, left = R[: harmonics.size, -1], R[harmonics.size, -1] ** 2
        sizes = (np.arange(highest + 1) + 1) ** 2
        squares = left + np.concatenate([np.cumsum(b[::-1] ** 2)[::-1], [0.0]])[sizes]
        validation = squares / (1.0 - sizes / m) ** 2
        # As good as the least of all, but for chance.
        degree = int(np.argmax(validation <= (1.0 + np.sqrt(8.0 / m)) * validation.min()))
        if highest == most or degree <= 3 * highest // 4:
            break
        highest = min(2 * highest, most)

    def undetermined(l: int) -> bool:
        singular = svdvals(R[: sizes[l], : sizes[l]])
        return bool(singular[-1] < FIT.determined * singular[0])

    degree = bisect_left(range(degree + 1), True, key=undetermined) - 1  # the highest that is determined
    size = sizes[degree]
    chosen = Harmonics(degree, degree)
    coefficients = np.empty(size)
    coefficients[np.argsort(chosen.labels[0], kind="stable")] = solve_triangular(R[:size, :size], b[:size])
    return coefficients, chosen, float(np.sqrt(squares[degree] / weights.sum()))
