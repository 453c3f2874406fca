"""The Wang-Yau quasi-local energy: for a time function, or for the one that makes it least."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter, NoMinimum, NotEmbedded
from isoembed.relativity.energies.energies import ENERGY
from isoembed.relativity.energies.quadrature import smooth_energies
from isoembed.relativity.energies.second_variation import SecondVariation
from isoembed.relativity.energies.time_function import TimeFunction, TimeRaisedMetric
from isoembed.relativity.energies.wang_yau_functional import EmbeddedTime, Functional
from isoembed.relativity.spacetimes.surface_data import SurfaceData, error_of
from isoembed.smooth.embedding import SmoothEmbedding
from isoembed.smooth.grid_metric import GridMetric
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.orientation import oriented
from isoembed.smooth.solve import embed_smooth
from isoembed.smooth.sphere_map import SphereMap
from isoembed.smooth.transforms import resized
from isoembed.smooth.two_metric import TwoMetric
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
    """Wang-Yau energy E(tau) of a surface, or the least one.

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
        The mean curvature vector is not spacelike and outward somewhere: the energy is not real there.  Or
        the surface is a horizon, and tau not 0.
    NotEmbedded
        The surface, or the one that a given tau makes, does not embed, or harmonics of degree 96 miss it.
    NoMinimum
        The search ended where the energy still falls.

    Notes
    -----
    Signature - + + +, H the trace of the second fundamental form.  The error is the change when X is embedded
    in 3/4 of its harmonics, and that from the next lower degree of tau.

    Of a horizon the energy is the limit ``int k0 dA / 8 pi`` of the least energies of surfaces that tend to
    it, whose tau tends to 0; another tau is refused, as its energy has no limit (Zhao, Andersson and Yau).

    References
    ----------
    M.-T. Wang and S.-T. Yau, Phys. Rev. Lett. 102 (2009) 021101; Commun. Math. Phys. 288 (2009) 919;
    B. Zhao, L. Andersson and S.-T. Yau, arXiv:2406.10751.
    """
    if not degrees or min(degrees) < 1:
        raise InvalidParameter(f"the degrees of tau are {degrees}: there must be some, and all at least 1")
    time = None if isinstance(tau, str) and tau == "optimal" else _time_function(tau)
    at = TimeFunction.zero()
    if embedding is None:
        try:
            embedding = embed_smooth(data.metric, shape=data.shape)
        except NotEmbedded:
            if time is None or not np.any(time.coefficients[1:]):
                raise
            at, embedding = time, embed_smooth(TimeRaisedMetric(data.metric, time))
    if data.marginal:
        return _limit(data, embedding, time)
    coordinates = embedding.coordinates
    own = at.in_coordinates(coordinates)
    search = _Search(_in_directions_of(embedding, data), embedding.in_own_directions, own)
    if time is None:
        found = search.minimum(degrees, accuracy)
    else:
        found = search.given(own if time is at else time.in_coordinates(coordinates))
    return found if coordinates is None else _returned(found, data.metric, coordinates)


def _in_directions_of(embedding: SmoothEmbedding, data: SurfaceData) -> SurfaceData:
    """The data as functions of the directions of an embedding's harmonics."""
    F = embedding.coordinates
    if F is None:
        return data
    moved = data.in_coordinates(F)
    return moved if data.shape is not None else replace(moved, shape=F.forward)


def _returned(found: WangYau, metric: TwoMetric, coordinates: SphereMap) -> WangYau:
    """A result in the given directions u, of one in those of a map u = F(v)."""
    R, notes = coordinates.rotation, found.notes
    if R is None:
        tau = replace(found.tau, coordinates=coordinates)
        notes += ("tau is in harmonics of the directions v of the embedding, u = F(v)",)
    else:
        tau = found.tau.in_coordinates(SphereMap.linear(R.T))
    embedding = replace(found.embedding, metric=TimeRaisedMetric(metric, tau), coordinates=coordinates)
    return replace(found, tau=tau, embedding=embedding, notes=notes)


def _limit(data: SurfaceData, embedding: SmoothEmbedding, time: TimeFunction | None) -> WangYau:
    """The energy to which that of surfaces tends that tend to a horizon: |H| = 0 there."""
    if time is not None and np.any(time.coefficients[1:]):
        raise InvalidParameter(
            "the mean curvature vector of a horizon is null: the energy of surfaces that tend to it grows "
            "without bound for every tau but 0, for which it tends to int k0 dA / 8 pi"
        )
    energy = smooth_energies(data, embedding).liu_yau
    assert energy is not None
    notes = [
        "of a horizon: the limit int k0 dA / 8 pi of the least energies of surfaces that tend to it, whose "
        "tau tends to 0 (Zhao, Andersson and Yau, arXiv:2406.10751)"
    ]
    if embedding.least_curvature <= 0.0:
        notes.append(_inadmissible(embedding.least_curvature))
    return WangYau(
        energy=energy,
        tau=TimeFunction.zero(),
        embedding=embedding,
        admissible=embedding.least_curvature,
        gradient=0.0,
        least_second_derivative=None,
        embeddings=1,
        notes=tuple(notes),
    )


def _inadmissible(least: float) -> str:
    return f"tau is not admissible: K + det D^2 tau / W^2 is {least:.3g} somewhere"


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
            notes.append(_inadmissible(found.admissible))
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
