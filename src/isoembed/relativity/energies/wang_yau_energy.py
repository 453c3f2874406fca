"""The Wang-Yau quasi-local energy: for a time function, or for the one that makes it least."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from isoembed.errors import InvalidParameter, NoMinimum, NotEmbedded
from isoembed.relativity.energies.time_function import TimeFunction, TimeRaisedMetric
from isoembed.relativity.energies.wang_yau_functional import Functional
from isoembed.relativity.spacetimes.surface_data import SurfaceData
from isoembed.smooth.embedding import SmoothEmbedding
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.solve import embed_smooth
from isoembed.smooth.transforms import resized
from isoembed.surface.estimate import Estimate

Floats = NDArray[np.float64]

LEAST, MOST = 16, 24  # degree of X: what time functions add needs some harmonics, and many cost much
COARSER = 0.75  # of the degree of X: what tells the error
STRAINED = 1e-3  # of a length: an X that is worse has lost its surface
MOST_STEPS = 30
SUFFICIENT = 1e-4  # of the foretold decrease, for a step to be taken
SHORTEST = 1e-3  # of Newton's step
FLAT = 1e-9  # of the largest second derivative: smaller ones are none (boosts, in Minkowski space)
ROUNDING = 1e-14
STATIONARY = 1e-9  # of the irreducible mass: what a minimum may still have to fall


@dataclass(frozen=True)
class WangYau:
    """The Wang-Yau energy of a surface.

    Attributes
    ----------
    energy : Estimate
        E(tau), in the unit of length.
    tau : TimeFunction
    embedding : SmoothEmbedding
        Of ``q + d tau d tau``: with tau it is the surface in Minkowski space, (tau, X).
    admissible : float
        The least ``K + det D^2 tau / (1 + |grad tau|^2)``; tau is admissible where it is positive.
    gradient : float
        The norm of the derivatives of E by tau's coefficients, which are lengths; 0 at a critical tau.
    least_second_derivative : float or None
        The least eigenvalue of the second derivatives: positive at a minimum, 0 where E does not change to
        second order (boosts, in Minkowski space); None if tau was given.
    embeddings : int
        How many embeddings it took.
    notes : tuple of str
        What must be known to read the number.
    """

    energy: Estimate
    tau: TimeFunction
    embedding: SmoothEmbedding
    admissible: float
    gradient: float
    least_second_derivative: float | None
    embeddings: int
    notes: tuple[str, ...] = ()

    def mesh(self, vertices: int) -> dict[str, NDArray[Any]]:
        """A triangulation of the surface in Minkowski space, nearly equilateral in its projection.

        Returns
        -------
        dict of str to ndarray
            ``vertices`` (V, 3), the projection X, and ``faces`` (F, 3); at the vertices (V,) ``tau`` and the
            ``mean_curvature`` H0 of the projection.
        """
        triangulation = self.embedding.triangulated(vertices)
        u = triangulation.directions
        return {
            "vertices": self.embedding.points(u),
            "faces": triangulation.faces,
            "tau": self.tau.values(u),
            "mean_curvature": self.embedding.mean_curvature(u),
        }

    @property
    def report(self) -> dict[str, Any]:
        """Plain numbers, for JSON."""
        degrees, orders = self.tau.harmonics.labels
        return {
            "wang_yau": self.energy.value,
            "error": self.energy.error,
            "admissible": self.admissible,
            "gradient": self.gradient,
            "least_second_derivative": self.least_second_derivative,
            "embeddings": self.embeddings,
            "tau": [
                {"degree": int(l), "order": int(m), "coefficient": float(c)}
                for l, m, c in zip(degrees, orders, self.tau.coefficients, strict=True)
                if l > 0
            ],
            "notes": list(self.notes),
        }


def wang_yau(
    data: SurfaceData,
    tau: TimeFunction | Floats | Callable[[Floats], ArrayLike] | Literal["optimal"] | None = None,
    *,
    embedding: SmoothEmbedding | None = None,
    degrees: tuple[int, ...] = (2, 4, 6, 8),
    accuracy: float = 1e-9,
) -> WangYau:
    """Compute the Wang-Yau energy E(tau) of a surface, or the least one.

    Parameters
    ----------
    data : SurfaceData
        With k, and with p and K(., n) where they do not vanish.  Where the norm of the mean curvature vector
        and the connection alpha of the normal bundle are known instead, they are ``mean_curvature`` and
        ``normal_momentum``.
    tau : TimeFunction, ndarray, callable, "optimal" or None
        The time function; an array (size,) holds its coefficients in all harmonics up to some degree, as
        `Harmonics` sorts them; a callable takes directions u (n, 3) and returns tau (n,).  None is tau = 0.
        "optimal" looks for the least energy by Newton's method from tau = 0, in spherical harmonics.
    embedding : SmoothEmbedding, optional
        Of ``data.metric``, if it is at hand.  Where that does not embed, a given tau will do for which
        ``q + d tau d tau`` does.
    degrees : tuple of int
        Those of tau, one after the other, until the energy settles.
    accuracy : float
        Relative change of the energy (over that of the radius of areas) at which it has settled.

    Returns
    -------
    WangYau

    Raises
    ------
    InvalidParameter
        The mean curvature vector is not spacelike and outward somewhere: the energy is not real there.
    NotEmbedded
        The surface, or the one that a given tau makes, does not embed, or harmonics of degree 24 miss it.
    NoMinimum
        The search ended where the energy still falls.

    Notes
    -----
    Signature - + + +, H the trace of the second fundamental form.  The error is the change when X is embedded
    in 3/4 of its harmonics, and that from the next lower degree of tau.

    References
    ----------
    M.-T. Wang and S.-T. Yau, Phys. Rev. Lett. 102 (2009) 021101; Commun. Math. Phys. 288 (2009) 919.
    """
    if not degrees or min(degrees) < 1:
        raise InvalidParameter(f"the degrees of tau are {degrees}: there must be some, and all at least 1")
    time = None if isinstance(tau, str) and tau == "optimal" else _time_function(tau)
    at = TimeFunction.zero()
    if embedding is None:
        try:
            embedding = embed_smooth(data.metric)
        except NotEmbedded:
            if time is None or not np.any(time.coefficients[1:]):
                raise
            at, embedding = time, embed_smooth(TimeRaisedMetric(data.metric, time))
    search = _Search(data, embedding, at)
    return search.least(degrees, accuracy) if time is None else search.reached(time)


def _time_function(tau: TimeFunction | Floats | Callable[[Floats], ArrayLike] | str | None) -> TimeFunction:
    if tau is None:
        return TimeFunction.zero()
    if isinstance(tau, TimeFunction):
        return tau
    if isinstance(tau, np.ndarray):
        return TimeFunction.from_array(tau)
    if not callable(tau):
        raise InvalidParameter(f'tau is {tau!r}, not a TimeFunction, an array, a function, "optimal" or None')
    return TimeFunction.of(tau)


class _Search:
    """The energies of one surface, counting the embeddings."""

    def __init__(self, data: SurfaceData, base: SmoothEmbedding, at: TimeFunction) -> None:
        degree = int(np.clip(base.harmonics.degree, LEAST, MOST))
        self.data, self.base, self.at = data, base, at  # base is the X of this tau
        self.X = Harmonics(degree, degree)
        self.embeddings = 1
        self.scale = float(np.sqrt(base.area / (16.0 * np.pi)))

    def reached(self, tau: TimeFunction) -> WangYau:
        """E of a given time function, reached from that of the base."""
        functional = self._functional(self.X, tau.harmonics)
        X = resized(self.base.coefficients, self.base.harmonics, self.X)
        if tau is self.at or not np.any(tau.coefficients[1:]):
            X = functional.embedded(tau.coefficients[1:], X)
        else:
            X = self._reached(functional, tau.coefficients[1:], X)
        return self._answer(functional, tau.harmonics, tau.coefficients[1:], X, 0.0, None)

    def _functional(self, X: Harmonics, tau: Harmonics) -> Functional:
        return Functional.of(self.data, self.base, self.at, X, tau)

    def least(self, degrees: tuple[int, ...], accuracy: float) -> WangYau:
        """The least E, in more and more harmonics."""
        X = resized(self.base.coefficients, self.base.harmonics, self.X)
        tau, energy, change = self.at, self.reached(self.at).energy.value, np.inf
        for degree in degrees:
            harmonics = Harmonics(degree, degree)
            functional = self._functional(self.X, harmonics)
            t = resized(tau.coefficients[:, None], tau.harmonics, harmonics)[1:, 0]
            t, X, found, eigenvalues = self._minimized(functional, t, X)
            tau = TimeFunction(harmonics, np.concatenate([[0.0], t]))
            change, energy = abs(found - energy), found
            if change <= accuracy * self.scale:
                break
        least = float(eigenvalues.min())
        if abs(least) <= FLAT * eigenvalues.max():
            least = 0.0  # a boost, in Minkowski space
        return self._answer(functional, harmonics, t, X, change, least)

    def _minimized(
        self, functional: Functional, t: Floats, X: Floats
    ) -> tuple[Floats, Floats, float, Floats]:
        """Newton's method, downhill also where the second derivatives are negative."""
        energy = functional.value(t, X)
        for _ in range(MOST_STEPS):
            gradient = functional.gradient(t, X)
            eigenvalues, modes = np.linalg.eigh(functional.hessian(t, X))
            sizes = np.maximum(np.abs(eigenvalues), FLAT * np.abs(eigenvalues).max())
            step = -modes @ ((modes.T @ gradient) / sizes)
            foretold = -float(gradient @ step)
            if foretold <= ROUNDING * self.scale:
                break
            found = self._lower(functional, t, X, step, energy, foretold)
            if found is None:
                break
            t, X, energy = found
        if foretold > STATIONARY * self.scale:
            raise NoMinimum(
                f"the search ended at E = {energy:.6g}, from where Newton's step was to gain {foretold:.1e}: "
                "the time functions beyond are not admissible or not embedded, or the steps did not suffice"
            )
        return t, X, energy, eigenvalues

    def _lower(
        self, functional: Functional, t: Floats, X: Floats, step: Floats, energy: float, foretold: float
    ) -> tuple[Floats, Floats, float] | None:
        """Go along a step until E falls by enough: tau, X and E there, or None."""
        length = 1.0
        while length >= SHORTEST:
            there = t + length * step
            followed = self._embedded(functional, there, X)
            if followed is not None:
                attained = functional.value(there, followed)
                if attained <= energy - SUFFICIENT * length * foretold:
                    return there, followed, attained
            length *= 0.5
        return None

    def _embedded(self, functional: Functional, t: Floats, X: Floats) -> Floats | None:
        """X for another tau, if it is admissible and X follows."""
        self.embeddings += 1
        found = functional.embedded(t, X)
        kept = functional.misfit(t, found) <= STRAINED and functional.least_admissible(t, found) > 0.0
        return found if kept else None

    def _reached(self, functional: Functional, t: Floats, X: Floats) -> Floats:
        """X for a given tau, step by step from 0."""
        done, step = 0.0, 1.0
        while done < 1.0:
            self.embeddings += 1
            found = functional.embedded(min(1.0, done + step) * t, X)
            if functional.misfit(min(1.0, done + step) * t, found) <= STRAINED:
                X, done = found, min(1.0, done + step)
            elif step > SHORTEST:
                step *= 0.5
            else:
                raise NotEmbedded(
                    f"the metric q + d tau d tau is not embedded beyond {done:.3g} times the given tau: "
                    f"there K + det D^2 tau / W^2 is at least {functional.least_admissible(done * t, X):.3g}",
                    self.base,
                )
        return X

    def _answer(
        self,
        functional: Functional,
        harmonics: Harmonics,
        t: Floats,
        X: Floats,
        change: float,
        least: float | None,
    ) -> WangYau:
        tau = TimeFunction(harmonics, np.concatenate([[0.0], t]))
        misfit = functional.misfit(t, X)
        if misfit > STRAINED:
            raise NotEmbedded(
                f"q + d tau d tau is missed by {misfit:.1e} by harmonics up to degree {self.X.degree}",
                self.base,
            )
        energy = functional.value(t, X)
        lower = Harmonics(*(2 * (int(COARSER * self.X.degree),)))
        coarse = self._functional(lower, harmonics)
        self.embeddings += 1
        there = coarse.embedded(t, resized(X, self.X, lower))
        error = abs(coarse.value(t, there) - energy) + change
        error += (ROUNDING + self.data.relative_error) * (abs(energy) + functional.reference(X))
        admissible = functional.least_admissible(t, X)
        notes = []
        if admissible <= 0.0:
            notes.append(f"tau is not admissible: K + det D^2 tau / W^2 is {admissible:.3g} somewhere")
        if least is not None and least < 0.0:
            notes.append("the second derivatives are not all positive: this may be no minimum")
        metric = TimeRaisedMetric(self.data.metric, tau)
        return WangYau(
            energy=Estimate(energy, error),
            tau=tau,
            embedding=SmoothEmbedding(metric, self.X, X, self.base.tolerance, np.inf),
            admissible=admissible,
            gradient=float(np.linalg.norm(functional.gradient(t, X))),
            least_second_derivative=least,
            embeddings=self.embeddings,
            notes=tuple(notes),
        )
