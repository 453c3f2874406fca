"""Minimization of the Wang-Yau functional over time functions, in harmonics of increasing degree."""

from __future__ import annotations

import numpy as np

from isoembed.arrays import Floats
from isoembed.errors import NoMinimum, NotEmbedded
from isoembed.relativity.energies.energies import ROUNDING
from isoembed.relativity.energies.second_variation import SecondVariation
from isoembed.relativity.energies.time_function import TimeFunction, TimeRaisedMetric
from isoembed.relativity.energies.wang_yau_functional import EmbeddedTime, Functional
from isoembed.relativity.energies.wang_yau_result import WangYau, inadmissible
from isoembed.relativity.spacetimes.surface_data import SurfaceData, error_of
from isoembed.smooth.embedding import SmoothEmbedding
from isoembed.smooth.grid_metric import GridMetric
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.orientation import oriented
from isoembed.smooth.transforms import resized
from isoembed.surface.estimate import Estimate

DEGREES = (16, 96)  # of X: a time function adds harmonics to those of the surface; the cost limits them
MAX_ITERATIONS = 30  # of Newton's method
SHORTEST_STEP = 1e-3  # fraction of the Newton step below which the line search gives up
FLAT = 1e-9  # largest relative second derivative that counts as zero (boosts, in Minkowski space)
STATIONARY = 1e-9  # largest predicted decrease at a minimum, in irreducible masses


class Search:
    """Energies of a surface for time functions, with a count of the embeddings."""

    def __init__(self, data: SurfaceData, base: SmoothEmbedding, at: TimeFunction) -> None:
        degree = int(np.clip(base.harmonics.degree, *DEGREES))
        self.data, self.base, self.at = data, base, at  # base is the X of this tau
        self.harmonics = Harmonics(degree, degree)  # of X
        self.embeddings = 1
        self.scale = float(np.sqrt(base.area / (16.0 * np.pi)))
        # Largest relative error of a length of X.
        self.strained = max(1e-3, 2.0 * base.residual)

    @property
    def start(self) -> Floats:
        """Coefficients of the base embedding in the harmonics of X."""
        return resized(self.base.coefficients, self.base.harmonics, self.harmonics)

    def functional(self, harmonics: Harmonics, time: Harmonics) -> Functional:
        """Functional for X and tau in given harmonics."""
        return Functional.of(self.data, self.base, self.at, harmonics, time)

    def result_at(self, tau: TimeFunction) -> WangYau:
        """Energy of a given time function, by continuation from that of the base."""
        t = tau.coefficients[1:]
        if tau is self.at or not np.any(t):
            if self.base.harmonics.order < self.base.harmonics.degree:  # symmetric about the z-axis
                self.harmonics = Harmonics(self.harmonics.degree, self.base.harmonics.order)
            return self._result(EmbeddedTime(self.functional(self.harmonics, tau.harmonics), t, self.start))
        return self._result(self._continued(self.functional(self.harmonics, tau.harmonics), t))

    def minimum(self, degrees: tuple[int, ...], accuracy: float) -> WangYau:
        """Least energy, in harmonics of increasing degree."""
        highest = Harmonics(max(degrees), max(degrees))
        functional = self.functional(self.harmonics, highest)
        few = min(self.harmonics.degree, 12)  # degree of X for second derivatives
        coarse = self.functional(Harmonics(few, few), highest)
        at = EmbeddedTime(functional.with_time(self.at.harmonics), self.at.coefficients[1:], self.start)
        for degree in degrees:
            time = Harmonics(degree, degree)
            t = resized(at.time_function.coefficients[:, None], at.functional.tau.harmonics, time)[1:, 0]
            start = EmbeddedTime(functional.with_time(time), t, at.X)
            found, eigenvalues = self._newton(start, SecondVariation.of(coarse.with_time(time)))
            change, at = abs(found.energy - at.energy), found
            if change <= accuracy * self.scale:
                break
        smallest = float(eigenvalues.min())
        if abs(smallest) <= FLAT * eigenvalues.max():
            smallest = 0.0  # a boost, in Minkowski space
        return self._result(at, change, smallest)

    def _newton(self, at: EmbeddedTime, second: SecondVariation) -> tuple[EmbeddedTime, Floats]:
        """Minimum by Newton's method, with descent for negative second derivatives, and their eigenvalues."""
        fewer = second.functional.X.harmonics
        for _ in range(MAX_ITERATIONS):
            eigenvalues, modes = np.linalg.eigh(second.at(at.tau, resized(at.X, self.harmonics, fewer)))
            sizes = np.maximum(np.abs(eigenvalues), FLAT * np.abs(eigenvalues).max())
            step = -modes @ ((modes.T @ at.gradient) / sizes)
            foretold = -float(at.gradient @ step)
            if foretold <= 1e-18 * self.scale:  # irreducible masses: a smaller predicted decrease is rounding
                break
            lower = self._line_search(at, step, foretold)
            if lower is None:
                break
            at = lower
        if foretold > STATIONARY * self.scale:
            raise NoMinimum(
                f"the search ended at E = {at.energy:.6g}, where the predicted decrease is {foretold:.1e}: "
                "further time functions are not admissible or not embedded, or the steps did not suffice"
            )
        return at, eigenvalues

    def _line_search(self, at: EmbeddedTime, step: Floats, foretold: float) -> EmbeddedTime | None:
        """Time function along a step with an embedding and a sufficient decrease of E; None if none is found.

        It must be admissible only if the initial one is.  At rounding level of E a smaller gradient suffices.
        """
        length = 1.0
        convex = at.admissible > 0.0
        while length >= SHORTEST_STEP:
            self.embeddings += 1
            there = at.functional.embedded(at.tau + length * step, at.X)
            # Armijo's condition.
            enough = at.energy - 1e-4 * length * foretold
            followed = there.misfit <= self.strained and not (convex and there.admissible <= 0.0)
            if followed and there.energy <= enough:
                return there
            if foretold <= STATIONARY * self.scale:
                # The energy is converged to rounding while tau is not: the gradient decides.
                flatter = np.linalg.norm(there.gradient) <= 0.3 * np.linalg.norm(at.gradient)
                return there if followed and flatter else None
            length *= 0.5
        return None

    def _continued(self, functional: Functional, t: Floats) -> EmbeddedTime:
        """Embedding for a given tau, by continuation from 0."""
        fraction, step, X = 0.0, 1.0, self.start
        while fraction < 1.0:
            self.embeddings += 1
            there = functional.embedded(min(1.0, fraction + step) * t, X)
            if there.misfit <= self.strained:
                X, fraction = there.X, min(1.0, fraction + step)
            elif step > SHORTEST_STEP:
                step *= 0.5
            else:
                lower = EmbeddedTime(functional, fraction * t, X).admissible
                raise NotEmbedded(
                    f"the metric q + d tau d tau is not embedded beyond {fraction:.3g} times the given tau: "
                    f"there K + det D^2 tau / W^2 is at least {lower:.3g}",
                    self.base,
                )
        return there

    def _result(
        self, found: EmbeddedTime, change: float = 0.0, second_derivative: float | None = None
    ) -> WangYau:
        """Energy with its error, where `change` is that from the lower degree of tau."""
        found = found.refined()
        if found.misfit > self.strained:
            raise NotEmbedded(
                f"harmonics up to degree {self.harmonics.degree} have an error of {found.misfit:.1e} for q "
                "+ d tau d tau",
                self.base,
            )
        # Error estimate from X in three quarters of the degree.
        degree = int(0.75 * self.harmonics.degree)
        lower = Harmonics(degree, min(degree, self.harmonics.order))
        self.embeddings += 1
        fewer = self.functional(lower, found.functional.tau.harmonics)
        coarse = fewer.embedded(found.tau, resized(found.X, self.harmonics, lower)).refined()
        error = abs(coarse.energy - found.energy) + change
        error += (ROUNDING + self.data.lengths_error.mean) * (abs(found.energy) + found.reference)
        error += found.error(
            error_of(self.data.mean_curvature),
            error_of(self.data.momentum),
            error_of(self.data.normal_momentum),
        )
        notes = []
        if found.admissible <= 0.0:
            notes.append(inadmissible(found.admissible))
        if second_derivative is not None and second_derivative < 0.0:
            notes.append("the second derivatives are not all positive: this may be no minimum")
        if self.data.normal_momentum is None and isinstance(self.data.metric, GridMetric):
            notes.append(
                "neither p nor K(., n) is given: both are assumed to be 0, as in a time-symmetric slice"
            )
        tau = found.time_function
        metric = TimeRaisedMetric(self.data.metric, tau)
        X = oriented(metric, self.harmonics, found.X, self.data.shape)
        return WangYau(
            energy=Estimate(found.energy, error),
            tau=tau,
            embedding=SmoothEmbedding(metric, self.harmonics, X, self.base.tolerance, np.inf),
            admissible=found.admissible,
            gradient=float(np.linalg.norm(found.gradient)),
            least_second_derivative=second_derivative,
            embeddings=self.embeddings,
            notes=tuple(notes),
        )
