"""Embedding of smooth metrics: a triangulation selects the branch, harmonics refine it until errors stall."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from isoembed.aim.adaptive import Aim
from isoembed.arrays import Floats
from isoembed.errors import InvalidMetric, InvalidParameter, NotEmbedded
from isoembed.evidence import Evidence
from isoembed.meshing.sphere import angles_of, gauss_rule
from isoembed.method import solve
from isoembed.smooth.axisymmetric import AxisymmetricEmbedding
from isoembed.smooth.coordinates import fitting_coordinates
from isoembed.smooth.embedding import ROUNDING, SmoothEmbedding
from isoembed.smooth.gauss_newton import gauss_newton, is_direct
from isoembed.smooth.gaussian_curvature import gaussian_curvature
from isoembed.smooth.grid_metric import GridMetric
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.isometry import SYMMETRIC_ANGLES
from isoembed.smooth.orientation import oriented
from isoembed.smooth.pole_checks import check_rings, check_within
from isoembed.smooth.sphere_map import SphereMap, metric_in
from isoembed.smooth.start import Start
from isoembed.smooth.symmetry import axis_of_symmetry
from isoembed.smooth.transforms import resized
from isoembed.smooth.triangulation import SphereMesh, graded_mesh
from isoembed.smooth.two_metric import TwoMetric
from isoembed.smooth.uncertain import EXACT
from isoembed.space import EUCLIDEAN, Space

DEGREES = (8, 12, 16, 24, 32, 48, 64, 96, 128, 192)  # degrees of the harmonics, in order of refinement
ACCURATE = 1e-6  # residual below which slow convergence is not a failure
FALLING = 0.6  # largest ratio of successive residuals that counts as a decrease
HINDERED_DEGREE = 32  # largest degree if no surface of revolution has the metric
PATIENCE = 3  # number of successive degrees without progress that ends the search
PER_HARMONIC = 3  # vertices per fitted harmonic
NO_REVOLUTION = Evidence(
    "searched",
    "only surfaces of revolution were considered, and it is proved that none has the metric: the "
    "circumference changes faster than the meridian allows, by more than the error of the metric",
)


def embed_smooth(
    metric: TwoMetric,
    *,
    space: Space = EUCLIDEAN,
    start: SmoothEmbedding | Start | None = None,
    shape: Callable[[Floats], Floats] | None = None,
    vertices: int = 1000,
    tolerance: float = 1e-4,
    accuracy: float = 1e-12,
    best_fit: bool = False,
    lengths_error: float | None = None,
) -> SmoothEmbedding:
    """Find the smooth surface in R^3, or in another space, that realizes a smooth metric on the sphere.

    A triangulation of the metric is embedded (`isoembed.embed`), spherical harmonics are fitted to its
    vertices, and the isometry equations are solved by the Gauss-Newton method in increasing degree until
    int H dA converges.  Axisymmetric metrics need few harmonics and are fast.

    Parameters
    ----------
    metric : TwoMetric
    space : Space
        Euclidean space, or `isoembed.Hyperbolic` or `isoembed.Spherical` of some curvature.
    start : SmoothEmbedding or Start, optional
        Surface of a nearby metric, in the same directions, as initial guess instead of a mesh.
    shape : callable, optional
        Takes directions u (n, 3) and returns points (n, 3), with which the surface is aligned by a rotation;
        by default the directions themselves.
    vertices : int
        Number of vertices of the mesh; surfaces of revolution need none.
    tolerance : float
        Largest relative error of a length that counts as an embedding.  The error of int H dA is about its
        square.
    accuracy : float
        Relative accuracy of int H dA at which the degree is not raised further; at most 1e-10 is attempted
        where K < 0 and the metric has no symmetry.
    best_fit : bool
        Return the surface of least mean-square strain even if it misses the tolerance.
    lengths_error : float, optional
        Relative error of the lengths beyond which an obstruction counts; by default the error estimate of a
        metric on a grid or of a surface in a slice, and 0 for others.

    Returns
    -------
    SmoothEmbedding

    Raises
    ------
    InvalidParameter
        A parameter has a type or a value that it cannot have.
    InvalidMetric
        The metric is not positive definite somewhere, or so far from smooth at the poles that no surface is
        within the tolerance; the message describes the behavior there.
    NotEmbedded
        The tolerance was missed, or the metric is axisymmetric but not that of a surface of revolution.  The
        message names the obstruction, if known, or says whether more harmonics would help; the exception
        holds the best attempt, or a rough one if no surface of revolution has the metric, as other surfaces
        are then sought only with ``best_fit``.

    Notes
    -----
    The centroid of the surface is the origin.  Its orientation depends only on the metric and the shape,
    continuously; it is independent of the mesh and the start, and common axes or planes of symmetry of metric
    and shape are preserved.

    For K > 0 the surface exists and is unique (Nirenberg 1953, Pogorelov 1952), and in a space of curvature k
    for K > k (Pogorelov 1964).  With K < k somewhere it is the surface of revolution if there is one, by the
    quadrature of `AxisymmetricEmbedding`, and otherwise the branch selected by the mesh.
    """
    for name, value in (("tolerance", tolerance), ("accuracy", accuracy)):
        if not 0 < value < np.inf:
            raise InvalidParameter(f"the {name} is {value!r}, not a positive finite number")
    if not (start is None or isinstance(start, SmoothEmbedding | Start)):
        raise InvalidParameter(f"start is a {type(start).__name__}, not a SmoothEmbedding or a Start")
    if not (shape is None or callable(shape)):
        raise InvalidParameter(f"shape is a {type(shape).__name__}, not a function of directions (n, 3)")
    if start is None:
        sight = metric.at_poles() if isinstance(metric, GridMetric) else check_rings(metric)
        if not best_fit:
            check_within(sight, tolerance)
    turn = axis_of_symmetry(metric)
    symmetric = turn is not None
    coordinates = None if turn is None or np.array_equal(turn, np.eye(3)) else SphereMap.linear(turn)
    ladder = [Harmonics(L, 1 if symmetric else L) for L in DEGREES]
    profile = _profile(metric_in(metric, coordinates), space) if symmetric else None
    if lengths_error is None:
        lengths_error = float(getattr(metric, "error", EXACT).pointwise)
    if not 0.0 <= lengths_error < np.inf:
        raise InvalidParameter(f"the lengths_error is {lengths_error!r}, not a finite number of at least 0")
    obstructed = (
        profile is not None
        and not profile.embeds
        and (lengths_error == 0.0 or profile.is_obstructed_beyond(lengths_error))
    )
    hindrance = _about(coordinates) + profile.explanation if profile is not None and obstructed else ""
    goal = _Goal(metric, space, coordinates, shape, tolerance, accuracy, hindrance, lengths_error)
    if profile is not None and hindrance:
        ladder = [h for h in ladder if h.degree <= HINDERED_DEGREE]
        if not best_fit:
            raise _not_of_revolution(profile, goal.approached(ladder[:1], _round(profile))[0])
    if start is None and profile is not None and profile.embeds:
        origin, first = _from_profile(profile), 0
    elif start is None:
        mesh = graded_mesh(metric, max(vertices, PER_HARMONIC * ladder[0].size), space)
        points = _embedded(mesh)
        if not symmetric:
            coordinates = fitting_coordinates(mesh.directions, mesh.faces, points)
        goal = replace(goal, coordinates=coordinates, mesh=mesh)
        v = mesh.directions if coordinates is None else coordinates.inverse(mesh.directions)
        origin, first = _from_points(v, points), 0
    else:
        start = Start.of(start)
        if not symmetric:
            goal = replace(goal, coordinates=start.coordinates)
        origin = partial(start.in_directions_of, goal.coordinates)
        first = max(0, sum(h.degree < start.harmonics.degree for h in ladder) - 1)
    best, residuals = goal.approached(ladder[first:], origin)
    if not best.converged and profile is not None and profile.embeds:
        # Restart from the surface of revolution in high degrees.
        high = [h for h in ladder if h.degree >= 48] or ladder[-1:]
        best, residuals = goal.approached(high, _from_profile(profile))
    if best.converged or best_fit:
        return best
    raise NotEmbedded(_diagnosis(best, residuals, profile), best, _search(best))


@dataclass(frozen=True)
class _Goal:
    """Specification of an embedding: metric, tolerances, and the shape with which it is aligned.

    The harmonics are functions of the directions v of the coordinates u = F(v).
    """

    metric: TwoMetric
    space: Space
    coordinates: SphereMap | None
    shape: Callable[[Floats], Floats] | None
    tolerance: float
    accuracy: float
    hindrance: str
    lengths_error: float
    mesh: SphereMesh | None = None

    def approached(
        self, ladder: list[Harmonics], origin: Callable[[Harmonics], Floats]
    ) -> tuple[SmoothEmbedding, list[float]]:
        """Best embedding in harmonics of increasing degree, and the residuals of all degrees.

        Each degree starts from the previous one or, if that is inaccurate, from ``origin``.
        """
        metric, shape = metric_in(self.metric, self.coordinates), _composed(self.shape, self.coordinates)
        residuals: list[float] = []
        last, C, old, carried, accuracy = np.inf, None, ladder[0], False, self.accuracy
        for harmonics in ladder:
            if C is None or not carried:
                C, old = origin(harmonics), harmonics
            target = 1e-4 * np.sqrt(accuracy)  # int H dA is of second order in strains
            C = gauss_newton(metric, harmonics, resized(C, old, harmonics), target, self.space)
            C, old = oriented(metric, harmonics, C, shape, self.space), harmonics
            surface = SmoothEmbedding(
                self.metric,
                harmonics,
                C,
                self.tolerance,
                last,
                self.hindrance,
                self.coordinates,
                self.mesh,
                self.space,
            )
            last = surface.integrated_mean_curvature
            residuals.append(surface.residual)
            if not is_direct(harmonics):
                accuracy = max(self.accuracy, self._attainable(surface))
            settled = surface.unsettled <= accuracy * abs(last) or surface.residual <= ROUNDING
            if surface.converged and settled:
                break
            if harmonics.degree >= HINDERED_DEGREE and self._is_in_vain(surface, residuals):
                return self._judged(surface, residuals), residuals
            # With K < k on the surface but not in the metric, few harmonics may favor another surface.
            carried = surface.residual <= 1e-3 and not (
                surface.least_curvature < self.space.curvature < self._least_curvature
            )
        return surface, residuals

    def _attainable(self, surface: SmoothEmbedding) -> float:
        """Relative accuracy of int H dA attainable in less than minutes; 0 for no limit."""
        excess = surface.least_curvature - self.space.curvature
        # The surface is not smooth where K - k vanishes.
        if not self.space.is_euclidean and abs(excess) * surface.area < 4.0 * np.pi * 0.01:
            return 1e-8
        return 1e-10 if excess < 0.0 else 0.0  # more takes minutes where K < 0

    def _is_in_vain(self, surface: SmoothEmbedding, residuals: list[float]) -> bool:
        """Whether more harmonics hardly reduce the residual; one degree decides if a surface is found."""
        if surface.converged and surface.residual <= ACCURATE:
            return len(residuals) > 1 and residuals[-1] >= FALLING * residuals[-2]
        before = residuals[: 1 - PATIENCE]
        return bool(before) and residuals[-1] >= 0.5 * before[-1]

    def _judged(self, surface: SmoothEmbedding, residuals: list[float]) -> SmoothEmbedding:
        """Surface with stagnating residual, with a `hindrance` where K < k, as no embedding need exist."""
        enough = max(ACCURATE, 10.0 * self.lengths_error)
        if surface.residual <= enough or surface.hindrance or self._least_curvature >= self.space.curvature:
            return surface
        stays = ", ".join(f"{r:.1e}" for r in residuals[-PATIENCE:])
        return replace(
            surface,
            hindrance=(
                f"no surface was found: with more and more harmonics the length errors remain {stays}; "
                f"{_sign_of_curvature(self.metric, self.space)}"
            ),
        )

    @cached_property
    def _least_curvature(self) -> float:
        u, _ = gauss_rule(48, 96)
        return float(gaussian_curvature(self.metric, u).min())


def _about(coordinates: SphereMap | None) -> str:
    """Clause that defines theta in sentences about a surface of revolution about another axis than z."""
    if coordinates is None:
        return ""
    axis = coordinates.forward(np.array([[0.0, 0.0, 1.0]]))[0]
    written = ", ".join(f"{x:.6g}" for x in np.round(axis, 12) + 0.0)
    return f"with theta from the axis of symmetry ({written}), "


def _composed(
    shape: Callable[[Floats], Floats] | None, coordinates: SphereMap | None
) -> Callable[[Floats], Floats] | None:
    """Shape as a function of the directions of the coordinates; by default the original directions."""
    if coordinates is None:
        return shape
    if shape is None:
        return coordinates.forward
    return lambda v: shape(coordinates.forward(v))


def _embedded(mesh: SphereMesh) -> Floats:
    """Vertices (V, 3) of the embedded triangulation, or of the best fit, as an initial guess."""
    try:
        # Accurate enough to select a branch.
        points = solve(mesh.metric, Aim(best_fit=True), tolerance=1e-4).vertices
    except NotEmbedded as error:
        points = error.embedding.vertices
    space = mesh.metric.space
    return points if space.is_euclidean else space.centered(points)


def _from_points(directions: Floats, vertices: Floats) -> Callable[[Harmonics], Floats]:
    """Function that fits harmonics to points in given directions, in the degrees these determine."""
    degree = int(np.sqrt(len(directions) / PER_HARMONIC)) - 1

    def fitted(harmonics: Harmonics) -> Floats:
        fewer = Harmonics(min(degree, harmonics.degree), min(degree, harmonics.order))
        # Regularization of high degrees, which are undetermined in gaps between directions.
        # The last degree has a weight of 0.05 relative to points, lower ones less.
        weights = (fewer.labels[0] / degree) ** 3.0 * 0.05
        weights *= np.sqrt(len(directions) / (4.0 * np.pi))
        rows = np.concatenate([fewer.values(directions), np.diag(weights)])
        points = np.concatenate([vertices, np.zeros((fewer.size, 3))])
        return resized(np.linalg.lstsq(rows, points, rcond=None)[0], fewer, harmonics)

    return fitted


def _from_profile(profile: AxisymmetricEmbedding) -> Callable[[Harmonics], Floats]:
    """Function that projects a surface of revolution onto harmonics."""

    def projected(harmonics: Harmonics) -> Floats:
        u, weights = gauss_rule(2 * harmonics.degree, SYMMETRIC_ANGLES)
        return harmonics.values(u).T @ (weights[:, None] * profile.points(u))

    return projected


def _round(profile: AxisymmetricEmbedding) -> Callable[[Harmonics], Floats]:
    """Function that projects a round sphere of the same area, of limited radius in spherical space."""
    radius = float(np.sqrt(profile.area / (4.0 * np.pi)))
    if profile.space.curvature > 0.0:
        radius = min(radius, 0.5 / float(np.sqrt(profile.space.curvature)))

    def projected(harmonics: Harmonics) -> Floats:
        u, weights = gauss_rule(2 * harmonics.degree, SYMMETRIC_ANGLES)
        return harmonics.values(u).T @ (weights[:, None] * radius * u)

    return projected


def _not_of_revolution(profile: AxisymmetricEmbedding, rough: SmoothEmbedding) -> NotEmbedded:
    """Exception for an axisymmetric metric without a surface of revolution."""
    sentence = f"{rough.hindrance}; other surfaces were not searched for"
    error = NotEmbedded(sentence, rough, NO_REVOLUTION)
    instead = "best_fit=True finds the nearest surface"
    if profile.greatest_curvature < 0.0:
        enough = -profile.greatest_curvature * (1.0 + 1e-6)  # margin above the rounding to nine digits
        instead = (
            f'space=isoembed.Hyperbolic({enough:.9g}) admits the whole surface, as does space="hyperbolic" '
            "in isoembed.relativity.embed_surface; AxisymmetricEmbedding has the bands that embed; " + instead
        )
    error.add_note(instead)
    return error


def _profile(metric: TwoMetric, space: Space) -> AxisymmetricEmbedding | None:
    """Surface of revolution of a metric symmetric about z; None if the metric is not smooth enough."""
    try:
        return AxisymmetricEmbedding.of(metric, space=space)
    except InvalidMetric:
        return None


def _search(best: SmoothEmbedding) -> Evidence:
    """Evidence of the search for the surface."""
    return Evidence(
        "searched",
        f"maps in spherical harmonics up to degree {best.harmonics.degree}, from one start; that none was "
        "found proves nothing",
    )


def _diagnosis(best: SmoothEmbedding, residuals: list[float], profile: AxisymmetricEmbedding | None) -> str:
    trend = ", ".join(f"{r:.1e}" for r in residuals[-3:])
    reason = (
        f"with more and more harmonics the length errors are {trend}, and the tolerance is "
        f"{best.tolerance:.0e}"
    )
    if best.hindrance:
        return best.hindrance if profile is None else f"{best.hindrance}; {reason}"
    if len(residuals) > 1 and residuals[-1] < FALLING * residuals[-2]:
        reason += ": the metric has details that are too fine for so few"
    if profile is not None and profile.embeds:
        return f"{reason}; the surface of revolution exists, and isoembed.smooth.AxisymmetricEmbedding has it"
    return f"{reason}; {_sign_of_curvature(best.metric, best.space)}"


def _sign_of_curvature(metric: TwoMetric, space: Space) -> str:
    """Clause on the existence of an embedding, by the sign of the Gaussian curvature minus that of space."""
    u, _ = gauss_rule(48, 96)
    K = gaussian_curvature(metric, u)
    k = int(np.argmin(K))
    sign = ("positive", "negative")
    if not space.is_euclidean:
        sign = (
            f"more than that of space, {space.curvature:.6g},",
            f"less than that of space, {space.curvature:.6g},",
        )
    if K[k] > space.curvature:
        return (
            f"the Gaussian curvature is {sign[0]} at the {len(K)} sampled directions: if it is so "
            "everywhere, an embedding exists (Nirenberg, Pogorelov)"
        )
    theta, phi = angles_of(u)
    return (
        f"the Gaussian curvature is {sign[1]} in places, least {K[k]:.4g} at theta = {theta[k]:.3f}, "
        f"phi = {phi[k]:.3f}: whether the metric embeds is not known"
    )
