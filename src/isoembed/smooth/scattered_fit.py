"""Robust least-squares fit of spherical harmonics to scattered values, with errors."""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass

import numpy as np
from scipy.linalg import qr, solve_triangular, svdvals
from scipy.spatial import cKDTree

from isoembed.arrays import Floats, Indices, Mask
from isoembed.smooth.harmonics import Harmonics

OUTLYING = 8.0  # least residual of an outlier in standard deviations: noise has 5 at most
ROUNDING = 1e-9  # largest residual attributed to rounding, relative to the largest value
FEWEST = 40  # least number of values for the detection of outliers
LEVERAGE = 0.9  # largest leverage of a value
DEVIATIONS = 12  # number of random deviations for error estimates
MISSING = 2  # additional degrees of the deviations


@dataclass(frozen=True)
class ScatteredFit:
    """Harmonics fitted to scattered values.

    Attributes
    ----------
    coefficients : ndarray, shape (size,)
    harmonics : Harmonics
    misfit : float
        Root mean square of the residuals, without outliers.
    deviations : ndarray, shape (N, size of the harmonics of two degrees more)
        Random samples of the error: coefficients in the harmonics of ``deviating(harmonics)``.
    left_out : ndarray of int, shape (k,)
        Indices of outliers, isolated values far from a fit to the others.
    apart : ndarray, shape (k,)
        Residuals of the outliers.
    """

    coefficients: Floats
    harmonics: Harmonics
    misfit: float
    deviations: Floats
    left_out: Indices
    apart: Floats


def deviating(harmonics: Harmonics) -> Harmonics:
    """Harmonics for the errors of a fit: two degrees more, and all orders."""
    degree = harmonics.degree + MISSING
    return Harmonics(degree, degree)


def white(harmonics: Harmonics, size: float, *functions: int) -> Floats:
    """Random deviations (N, size of `deviating`, *functions) of given root mean square, as white noise.

    Of what is exact there is a single one, zero.
    """
    count = deviating(harmonics).size
    if size == 0.0:
        return np.zeros((1, count, *functions))
    drawn = np.random.default_rng(0).normal(size=(DEVIATIONS, count, *functions))
    return drawn * (size * np.sqrt(4.0 * np.pi * DEVIATIONS / drawn.size))


def fitted(u: Floats, values: Floats, weights: Floats) -> ScatteredFit:
    """Fit harmonics to scattered values by weighted least squares, without isolated outliers.

    Parameters
    ----------
    u : ndarray, shape (n, 3)
        Directions.
    values, weights : ndarray, shape (n,)

    Notes
    -----
    The degree minimizes generalized cross-validation [1]; higher degrees are noise.  It is lower if gaps
    between the directions leave coefficients undetermined.  Degrees are tried until residuals of neighbors
    are uncorrelated.

    An outlier deviates from the fit to the others by more than eight times the standard deviation, both
    globally and locally.  If there are more than one in fifty, none is left out.

    The deviations are fits to the leave-one-out residuals with random signs [2], and random coefficients in
    the two following degrees, of the size of fitted ones.  If these are not determined, the size is that of
    all residuals.

    References
    ----------
    [1] G. Golub, M. Heath and G. Wahba, Technometrics 21 (1979) 215.
    [2] C. F. J. Wu, Ann. Stat. 14 (1986) 1261.
    """
    inliers = np.ones(len(u), dtype=bool)
    first = fit = _LeastSquares.of(u, values, weights)
    while len(u) >= FEWEST:
        out = _outliers(fit, inliers, u, values, weights)
        if not out.any():
            break
        inliers &= ~out
        if np.count_nonzero(~inliers) > max(1.0, 0.02 * len(u)):  # more are a feature of the values
            fit, inliers[:] = first, True
            break
        fit = _LeastSquares.of(u[inliers], values[inliers], weights[inliers])
    return ScatteredFit(
        fit.coefficients,
        fit.harmonics,
        fit.misfit,
        fit.deviations(),
        np.flatnonzero(~inliers),
        fit.held_out_residuals(u[~inliers], values[~inliers]),
    )


@dataclass(frozen=True)
class _LeastSquares:
    """Least-squares fit of harmonics with its QR factorization, columns in order of degree."""

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
        max_degree = max(0, min(40, int(np.sqrt(0.5 * m)) - 1))
        highest = min(max_degree, 8)  # initial degree, which is doubled
        root = np.sqrt(weights * (4.0 * np.pi / weights.sum()))
        while True:
            harmonics = Harmonics(highest, highest)
            by_degree = np.argsort(harmonics.labels[0], kind="stable")
            # One factorization serves all degrees: lower degrees are its leading columns.
            table = root[:, None] * harmonics.values(u)[:, by_degree]
            Q, R = qr(table, mode="economic", overwrite_a=True)
            b = Q.T @ (root * values)
            rest = root * values - Q @ b
            left = float(np.sum(rest**2))
            sizes = (np.arange(highest + 1) + 1) ** 2
            squares = left + np.concatenate([np.cumsum(b[::-1] ** 2)[::-1], [0.0]])[sizes]
            validation = squares / (1.0 - sizes / m) ** 2
            # The lowest degree that is as good as the best within chance.
            best = int(np.argmax(validation <= (1.0 + np.sqrt(8.0 / m)) * validation.min()))
            if highest == max_degree or (best <= 3 * highest // 4 and _is_noise(rest / root, u, values)):
                break
            highest = min(2 * highest, max_degree)

        def undetermined(l: int) -> bool:
            singular = svdvals(R[: sizes[l], : sizes[l]])
            # The values hardly determine the highest harmonics.
            return bool(singular[-1] < 0.1 * singular[0])

        degree = bisect_left(range(best + 1), True, key=undetermined) - 1  # the highest determined degree
        size = sizes[degree]
        Q, R, chosen = Q[:, :size], R[:size, :size], Harmonics(degree, degree)
        coefficients = _sorted(solve_triangular(R, b[:size]), chosen)
        own = np.minimum(np.einsum("ij,ij->i", Q, Q), LEVERAGE)
        residuals = (root * values - Q @ b[:size]) / (root * (1.0 - own))
        misfit = float(np.sqrt(squares[degree] / (4.0 * np.pi)))
        following = b[size : (degree + 1 + MISSING) ** 2] if degree == best else b[:0]
        return cls(coefficients, chosen, misfit, Q, R, root, residuals, following)

    def held_out_residuals(self, u: Floats, values: Floats) -> Floats:
        """Residuals (n,) of values in the directions u (n, 3)."""
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
    """Coefficients in the order of the harmonics, from those sorted by degree."""
    coefficients = np.empty_like(by_degree)
    coefficients[np.argsort(harmonics.labels[0], kind="stable")] = by_degree
    return coefficients


def _is_noise(rest: Floats, u: Floats, values: Floats) -> bool:
    """Whether residuals (n,) of values are uncorrelated between neighbors, or negligible."""
    square = float(np.mean(rest**2))
    if square <= (ROUNDING * float(np.abs(values).max())) ** 2:
        return True
    nearest = cKDTree(u).query(u, 2)[1][:, 1]
    # The correlation of neighbors in noise is at most a few standard deviations.
    return float(np.mean(rest * rest[nearest])) <= 5.0 / np.sqrt(len(u)) * square


def _outliers(fit: _LeastSquares, inliers: Mask, u: Floats, values: Floats, weights: Floats) -> Mask:
    """Mask (n,) of outliers among the values kept so far."""
    out = np.zeros(len(u), dtype=bool)
    out[inliers] = np.abs(fit.residuals) > _usual(fit, values)
    rest = inliers & ~out
    if not out.any() or np.count_nonzero(rest) < FEWEST // 2:
        return np.zeros_like(out)
    without = _LeastSquares.of(u[rest], values[rest], weights[rest])
    # An unresolved feature has large residuals at all values nearby, or at several adjacent ones.
    distances, near = cKDTree(u[rest]).query(u[out], 12)
    nearby = OUTLYING * np.sqrt(np.mean(without.residuals[near] ** 2, axis=1))
    residuals = np.abs(without.held_out_residuals(u[out], values[out]))
    other = cKDTree(u[out]).query(u[out], 2)[0][:, 1]  # infinite for a single one
    # An outlier must be the only one among its three nearest values.
    out[out] = (residuals > np.maximum(nearby, _usual(without, values))) & (other > distances[:, 2])
    return out


def _usual(fit: _LeastSquares, values: Floats) -> float:
    """Residual above which a value is an outlier."""
    deviation = 1.4826 * float(np.median(np.abs(fit.residuals)))  # standard deviation if normal
    return max(OUTLYING * deviation, ROUNDING * float(np.abs(values).max()))
