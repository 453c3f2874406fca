"""Robust least-squares fit of spherical harmonics to scattered values, with errors."""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass

import numpy as np
from scipy.linalg import qr, solve_triangular, svdvals
from scipy.spatial import cKDTree

from isoembed.arrays import Floats, Indices, Mask
from isoembed.smooth.harmonics import Harmonics

OUTLYING = 8.0  # standard deviations: noise has 5 at most
ROUNDING = 1e-9  # residual over the largest value that is no outlier
FEWEST = 40  # values, of which an outlier can be told
LEVERAGE = 0.9  # largest weight of a value in the fit at its own place
DEVIATIONS = 12  # random deviations, from which errors are estimated
MISSING = 2  # further degrees of the deviations


@dataclass(frozen=True)
class ScatteredFit:
    """Harmonics fitted to scattered values.

    Attributes
    ----------
    coefficients : ndarray, shape (size,)
    harmonics : Harmonics
    misfit : float
        Root mean square of what is missed of the values that were not left out.
    deviations : ndarray, shape (N, size of the harmonics of two degrees more)
        Possible errors, drawn at random: coefficients in the harmonics of ``deviating(harmonics)``.
    left_out : ndarray of int, shape (k,)
        Outliers: values that alone are far from what all others say.
    apart : ndarray, shape (k,)
        How far each lies above the fit.
    """

    coefficients: Floats
    harmonics: Harmonics
    misfit: float
    deviations: Floats
    left_out: Indices
    apart: Floats


def deviating(harmonics: Harmonics) -> Harmonics:
    """The harmonics of the errors of a fit: some degrees more, and all orders."""
    degree = harmonics.degree + MISSING
    return Harmonics(degree, degree)


def white(harmonics: Harmonics, size: float, *functions: int) -> Floats:
    """Random deviations (N, size of `deviating`, *functions) of this root mean square, alike in harmonics."""
    count = deviating(harmonics).size
    drawn = np.random.default_rng(0).normal(size=(DEVIATIONS, count, *functions))
    return drawn * (size * np.sqrt(4.0 * np.pi * DEVIATIONS / drawn.size))


def fitted(u: Floats, values: Floats, weights: Floats) -> ScatteredFit:
    """Harmonics fitted to scattered values by weighted least squares, without single outliers.

    Parameters
    ----------
    u : ndarray, shape (n, 3)
        Directions.
    values, weights : ndarray, shape (n,)

    Notes
    -----
    The degree is the one of least generalized cross-validation [1]: what follows is noise.  It is lower where
    holes between the directions would leave coefficients undetermined.  Degrees are tried until residuals of
    neighbors are unlike.

    An outlier is missed by the fit to the others by more than eight times what these are usually missed by,
    everywhere and nearby.  If there are more than one in fifty, none is left out.

    The deviations are fits to the residuals with random signs [2], each the residual of the fit to all other
    values; and in the two degrees that follow, random ones as large as their coefficients would be.  Where
    these are not determined the coefficients are as large as all residuals.

    References
    ----------
    [1] G. Golub, M. Heath and G. Wahba, Technometrics 21 (1979) 215.
    [2] C. F. J. Wu, Ann. Stat. 14 (1986) 1261.
    """
    kept = np.ones(len(u), dtype=bool)
    first = fit = _LeastSquares.of(u, values, weights)
    while len(u) >= FEWEST:
        out = _outliers(fit, kept, u, values, weights)
        if not out.any():
            break
        kept &= ~out
        if np.count_nonzero(~kept) > max(1.0, 0.02 * len(u)):  # more are a feature of the values
            fit, kept[:] = first, True
            break
        fit = _LeastSquares.of(u[kept], values[kept], weights[kept])
    return ScatteredFit(
        fit.coefficients,
        fit.harmonics,
        fit.misfit,
        fit.deviations(),
        np.flatnonzero(~kept),
        fit.missed(u[~kept], values[~kept]),
    )


@dataclass(frozen=True)
class _LeastSquares:
    """A fit of harmonics, with its table (n, size) of orthonormal columns in the order of the degrees."""

    coefficients: Floats
    harmonics: Harmonics
    misfit: float
    Q: Floats
    R: Floats
    root: Floats
    residuals: Floats
    following: Floats

    @classmethod
    def of(cls, u: Floats, values: Floats, weights: Floats) -> _LeastSquares:
        m = len(u)
        most = max(0, min(40, int(np.sqrt(0.5 * m)) - 1))
        highest = min(most, 8)  # first degree; it is doubled
        root = np.sqrt(weights * (4.0 * np.pi / weights.sum()))
        while True:
            harmonics = Harmonics(highest, highest)
            by_degree = np.argsort(harmonics.labels[0], kind="stable")
            # One factorization serves all degrees: those of lower degree are its leading columns.
            table = root[:, None] * harmonics.values(u)[:, by_degree]
            Q, R = qr(table, mode="economic", overwrite_a=True)
            b = Q.T @ (root * values)
            rest = root * values - Q @ b
            left = float(np.sum(rest**2))
            sizes = (np.arange(highest + 1) + 1) ** 2
            squares = left + np.concatenate([np.cumsum(b[::-1] ** 2)[::-1], [0.0]])[sizes]
            validation = squares / (1.0 - sizes / m) ** 2
            # As good as the least of all, but for chance.
            best = int(np.argmax(validation <= (1.0 + np.sqrt(8.0 / m)) * validation.min()))
            if highest == most or (best <= 3 * highest // 4 and _is_noise(rest / root, u, values)):
                break
            highest = min(2 * highest, most)

        def undetermined(l: int) -> bool:
            singular = svdvals(R[: sizes[l], : sizes[l]])
            # The values hardly determine the highest harmonics.
            return bool(singular[-1] < 0.1 * singular[0])

        degree = bisect_left(range(best + 1), True, key=undetermined) - 1  # the highest that is determined
        size = sizes[degree]
        Q, R, chosen = Q[:, :size], R[:size, :size], Harmonics(degree, degree)
        coefficients = _sorted(solve_triangular(R, b[:size]), chosen)
        own = np.minimum(np.einsum("ij,ij->i", Q, Q), LEVERAGE)
        residuals = (root * values - Q @ b[:size]) / (root * (1.0 - own))
        misfit = float(np.sqrt(squares[degree] / (4.0 * np.pi)))
        following = b[size : (degree + 1 + MISSING) ** 2] if degree == best else b[:0]
        return cls(coefficients, chosen, misfit, Q, R, root, residuals, following)

    def missed(self, u: Floats, values: Floats) -> Floats:
        """Heights of values (n,) in the directions u (n, 3) above the fit."""
        return values - self.harmonics.values(u) @ self.coefficients

    def deviations(self) -> Floats:
        """See `ScatteredFit`."""
        random = np.random.default_rng(0)
        m, size = self.Q.shape
        signs = random.choice((-1.0, 1.0), (m, DEVIATIONS))
        drawn = solve_triangular(self.R, self.Q.T @ ((self.root * self.residuals)[:, None] * signs))
        more = deviating(self.harmonics)
        beyond = random.normal(size=(more.size - size, DEVIATIONS))
        if len(self.following) > 0:
            beyond *= np.sqrt(np.mean(self.following**2))
        else:
            beyond *= np.linalg.norm(self.root * self.residuals) / np.sqrt(len(beyond))
        return _sorted(np.concatenate([drawn, beyond]), more).T


def _sorted(by_degree: Floats, harmonics: Harmonics) -> Floats:
    """Coefficients in the order of the harmonics from one in which the degrees follow each other."""
    coefficients = np.empty_like(by_degree)
    coefficients[np.argsort(harmonics.labels[0], kind="stable")] = by_degree
    return coefficients


def _is_noise(rest: Floats, u: Floats, values: Floats) -> bool:
    """Whether what is left of values (n,) is unlike at neighbors, or negligible."""
    square = float(np.mean(rest**2))
    if square <= (ROUNDING * float(np.abs(values).max())) ** 2:
        return True
    nearest = cKDTree(u).query(u, 2)[1][:, 1]
    # In noise the correlation of neighbors is a few standard deviations at most.
    return float(np.mean(rest * rest[nearest])) <= 5.0 / np.sqrt(len(u)) * square


def _outliers(fit: _LeastSquares, kept: Mask, u: Floats, values: Floats, weights: Floats) -> Mask:
    """Mask of the values (n,), of those that were kept, that are outliers."""
    out = np.zeros(len(u), dtype=bool)
    out[kept] = np.abs(fit.residuals) > _usual(fit, values)
    rest = kept & ~out
    if not out.any() or np.count_nonzero(rest) < FEWEST // 2:
        return np.zeros_like(out)
    without = _LeastSquares.of(u[rest], values[rest], weights[rest])
    # Where a shape is not resolved all values nearby are missed, or several that are side by side.
    distances, near = cKDTree(u[rest]).query(u[out], 12)
    nearby = OUTLYING * np.sqrt(np.mean(without.residuals[near] ** 2, axis=1))
    missed = np.abs(without.missed(u[out], values[out]))
    other = cKDTree(u[out]).query(u[out], 2)[0][:, 1]  # infinite of one alone
    # An outlier is the only one among its three nearest values.
    out[out] = (missed > np.maximum(nearby, _usual(without, values))) & (other > distances[:, 2])
    return out


def _usual(fit: _LeastSquares, values: Floats) -> float:
    """Residual above which a value is an outlier."""
    deviation = 1.4826 * float(np.median(np.abs(fit.residuals)))  # if they are normal, the standard deviation
    return max(OUTLYING * deviation, ROUNDING * float(np.abs(values).max()))
