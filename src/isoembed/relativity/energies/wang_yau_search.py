"""Search for the time function of least Wang-Yau energy, and the way to a given one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats
from isoembed.errors import NoMinimum, NotEmbedded
from isoembed.relativity.energies.energies import ENERGY
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
from isoembed.thresholds import threshold


@dataclass(frozen=True)
class WangYauThresholds:
    """Thresholds of the Wang-Yau energy."""

    least_degree: int = threshold(
        16, "count", "Least degree of X: what a time function adds needs some harmonics."
    )
    highest_degree: int = threshold(96, "count", "Highest degree of X: many harmonics cost much.")
    second_degree: int = threshold(12, "count", "Highest degree of X for second derivatives.")
    coarser: float = threshold(0.75, "relative", "Degree of the X that tells the error, over that of X.")
    strained: float = threshold(1e-3, "relative", "Error of a length above which X has lost its surface.")
    rougher: float = threshold(2.0, "relative", "The same over the surface's own, where data are rough.")
    steps: int = threshold(30, "count", "Newton steps after which the search ends.")
    decrease: float = threshold(
        1e-4, "foretold decrease", "Decrease of the energy for which a step is taken."
    )
    shortest: float = threshold(1e-3, "Newton steps", "Length below which a step is not halved further.")
    flat: float = threshold(
        1e-9, "largest second derivative", "Second derivative that is none (boosts, in Minkowski space)."
    )
    found: float = threshold(1e-18, "irreducible mass", "Foretold decrease at which a minimum is found.")
    flatter: float = threshold(0.3, "relative", "Gradient over the one before, where energies are rounded.")
    stationary: float = threshold(
        1e-9, "irreducible mass", "Decrease that Newton's step may still foretell at a minimum."
    )


WANG_YAU = WangYauThresholds()


class Search:
    """Energies of one surface for time functions, with a count of the embeddings."""

    def __init__(self, data: SurfaceData, base: SmoothEmbedding, at: TimeFunction) -> None:
        degree = int(np.clip(base.harmonics.degree, WANG_YAU.least_degree, WANG_YAU.highest_degree))
        self.data, self.base, self.at = data, base, at  # base is the X of this tau
        self.harmonics = Harmonics(degree, degree)  # of X
        self.embeddings = 1
        self.scale = float(np.sqrt(base.area / (16.0 * np.pi)))
        self.strained = max(WANG_YAU.strained, WANG_YAU.rougher * base.residual)

    @property
    def start(self) -> Floats:
        """Coefficients of the base in the harmonics of X."""
        return resized(self.base.coefficients, self.base.harmonics, self.harmonics)

    def functional(self, harmonics: Harmonics, time: Harmonics) -> Functional:
        """The functional for X and tau in these harmonics."""
        return Functional.of(self.data, self.base, self.at, harmonics, time)

    def given(self, tau: TimeFunction) -> WangYau:
        """The energy of a given time function, reached from that of the base."""
        t = tau.coefficients[1:]
        if tau is self.at or not np.any(t):
            if self.base.harmonics.order < self.base.harmonics.degree:  # symmetric about the z-axis
                self.harmonics = Harmonics(self.harmonics.degree, self.base.harmonics.order)
            return self._result(EmbeddedTime(self.functional(self.harmonics, tau.harmonics), t, self.start))
        return self._result(self._continued(self.functional(self.harmonics, tau.harmonics), t))

    def minimum(self, degrees: tuple[int, ...], accuracy: float) -> WangYau:
        """The least energy, in more and more harmonics."""
        highest = Harmonics(max(degrees), max(degrees))
        functional = self.functional(self.harmonics, highest)
        few = min(self.harmonics.degree, WANG_YAU.second_degree)
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
        least = float(eigenvalues.min())
        if abs(least) <= WANG_YAU.flat * eigenvalues.max():
            least = 0.0  # a boost, in Minkowski space
        return self._result(at, change, least)

    def _newton(self, at: EmbeddedTime, second: SecondVariation) -> tuple[EmbeddedTime, Floats]:
        """Newton's method, downhill also where the second derivatives are negative; and their eigenvalues."""
        fewer = second.functional.X.harmonics
        for _ in range(WANG_YAU.steps):
            eigenvalues, modes = np.linalg.eigh(second.at(at.tau, resized(at.X, self.harmonics, fewer)))
            sizes = np.maximum(np.abs(eigenvalues), WANG_YAU.flat * np.abs(eigenvalues).max())
            step = -modes @ ((modes.T @ at.gradient) / sizes)
            foretold = -float(at.gradient @ step)
            if foretold <= WANG_YAU.found * self.scale:
                break
            lower = self._line_search(at, step, foretold)
            if lower is None:
                break
            at = lower
        if foretold > WANG_YAU.stationary * self.scale:
            raise NoMinimum(
                f"the search ended at E = {at.energy:.6g}, from where Newton's step was to gain "
                f"{foretold:.1e}: the time functions beyond are not admissible or not embedded, or the steps "
                "did not suffice"
            )
        return at, eigenvalues

    def _line_search(self, at: EmbeddedTime, step: Floats, foretold: float) -> EmbeddedTime | None:
        """A time function along a step, as admissible, that embeds and has so much less energy, if any."""
        length = 1.0
        convex = at.admissible > 0.0
        while length >= WANG_YAU.shortest:
            self.embeddings += 1
            there = at.functional.embedded(at.tau + length * step, at.X)
            enough = at.energy - WANG_YAU.decrease * length * foretold
            followed = there.misfit <= self.strained and not (convex and there.admissible <= 0.0)
            if followed and there.energy <= enough:
                return there
            if foretold <= WANG_YAU.stationary * self.scale:
                # Of the energy rounding is left; tau still has digits to gain.
                flatter = np.linalg.norm(there.gradient) <= WANG_YAU.flatter * np.linalg.norm(at.gradient)
                return there if followed and flatter else None
            length *= 0.5
        return None

    def _continued(self, functional: Functional, t: Floats) -> EmbeddedTime:
        """The embedding for a given tau, step by step from 0."""
        done, step, X = 0.0, 1.0, self.start
        while done < 1.0:
            self.embeddings += 1
            there = functional.embedded(min(1.0, done + step) * t, X)
            if there.misfit <= self.strained:
                X, done = there.X, min(1.0, done + step)
            elif step > WANG_YAU.shortest:
                step *= 0.5
            else:
                least = EmbeddedTime(functional, done * t, X).admissible
                raise NotEmbedded(
                    f"the metric q + d tau d tau is not embedded beyond {done:.3g} times the given tau: "
                    f"there K + det D^2 tau / W^2 is at least {least:.3g}",
                    self.base,
                )
        return there

    def _result(self, found: EmbeddedTime, change: float = 0.0, least: float | None = None) -> WangYau:
        """The energy with its error: `change` is that from the tau of lower degree."""
        found = found.refined()
        if found.misfit > self.strained:
            raise NotEmbedded(
                f"q + d tau d tau is missed by {found.misfit:.1e} by harmonics up to degree "
                f"{self.harmonics.degree}",
                self.base,
            )
        degree = int(WANG_YAU.coarser * self.harmonics.degree)
        lower = Harmonics(degree, min(degree, self.harmonics.order))
        self.embeddings += 1
        fewer = self.functional(lower, found.functional.tau.harmonics)
        coarse = fewer.embedded(found.tau, resized(found.X, self.harmonics, lower)).refined()
        error = abs(coarse.energy - found.energy) + change
        error += (ENERGY.rounding + self.data.lengths_error.mean) * (abs(found.energy) + found.reference)
        error += found.error(
            error_of(self.data.mean_curvature),
            error_of(self.data.momentum),
            error_of(self.data.normal_momentum),
        )
        notes = []
        if found.admissible <= 0.0:
            notes.append(inadmissible(found.admissible))
        if least is not None and least < 0.0:
            notes.append("the second derivatives are not all positive: this may be no minimum")
        if self.data.normal_momentum is None and isinstance(self.data.metric, GridMetric):
            notes.append(
                "neither p nor K(., n) is given: they are taken to be 0, as in a time-symmetric slice"
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
            least_second_derivative=least,
            embeddings=self.embeddings,
            notes=tuple(notes),
        )
