"""Harmonics fitted to a closed triangle mesh whose vertices lie on a smooth surface of any shape.

Where on the sphere a vertex belongs is not known and does not matter: only distances along the normal do.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import cho_solve, cholesky, solve_triangular
from scipy.linalg.lapack import dtrcon
from scipy.sparse.linalg import LinearOperator, lsmr

from isoembed.arrays import Floats, Indices
from isoembed.meshing.sphere import hull_faces, solid_angles
from isoembed.meshing.sphere_layout import are_outward, least_distorted, orientations, sphere_layout
from isoembed.metric.curvature import area
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.scattered_fit import FIT, deviating
from isoembed.smooth.transforms import resized
from isoembed.smooth.two_metric import angle_frame
from isoembed.thresholds import threshold


@dataclass(frozen=True)
class MeshFitThresholds:
    """Thresholds of the fit of harmonics to meshes."""

    degrees: tuple[int, ...] = threshold(
        (1, 2, 3, 4, 6, 8, 12, 16, 20, 24, 32, 40, 48),
        "count",
        "Degrees that are tried, one after the other.",
    )
    fullest: float = threshold(0.6, "vertices", "Degrees of freedom, at most.")
    table: int = threshold(100_000_000, "count", "Harmonics at vertices, at most: it bounds the memory.")
    sideways: float = threshold(0.1, "relative", "Weight of a distance along the surface.")
    determined: float = threshold(1e-4, "relative", "Reciprocal condition of a fit, at least.")
    held_out: float = threshold(0.1, "relative", "Share of vertices that tell how far a fit misses others.")
    doubt: float = threshold(4.0, "relative", "Miss of others over that of the vertices, at least.")
    poor: float = threshold(1e-4, "mean radius", "Misfit above which it is begun again in higher degree.")
    later: int = threshold(6, "count", "That degree.")
    rounds: int = threshold(8, "count", "Fits of one degree, vertices being moved on the sphere, at most.")
    gain: float = threshold(
        0.8, "relative", "Misfit over that of the fit before, above which it is the last."
    )
    farthest: float = threshold(0.5, "mean spacing", "Way of a vertex on the sphere in one round, at most.")
    halvings: int = threshold(30, "count", "Of the ways around triangles that would turn over, at most.")
    solved: float = threshold(1e-4, "relative", "Error of the least squares of one round.")
    iterations: int = threshold(200, "count", "Iterations of least squares, at most.")
    rounding: float = threshold(1e-13, "mean radius", "Misfit that is rounding.")
    worse: int = threshold(2, "count", "Degrees in a row that fit no better, after which there are no more.")


MESH_FIT = MeshFitThresholds()


@dataclass(frozen=True)
class MeshFit:
    """Harmonics fitted to the vertices of a mesh.

    Attributes
    ----------
    coefficients : ndarray, shape (size, 3)
    harmonics : Harmonics
    misfit : float
        Root mean square of the distances of the vertices.
    deviations : ndarray, shape (N, size of the harmonics of two degrees more, 3)
        Possible errors, drawn at random: coefficients in the harmonics of ``deviating(harmonics)``.
    directions : ndarray, shape (V, 3)
        Unit vectors at which the surface is nearest to the vertices.
    """

    coefficients: Floats
    harmonics: Harmonics
    misfit: float
    deviations: Floats
    directions: Floats


def fit_mesh(vertices: Floats, faces: Indices) -> MeshFit:
    """Harmonics fitted to a closed triangle mesh of genus 0.

    Parameters
    ----------
    vertices : ndarray, shape (V, 3)
    faces : ndarray of int, shape (F, 3)
        Counterclockwise from outside.

    Raises
    ------
    InvalidMetric
        The faces are no triangulated sphere, or a triangle is degenerate.

    Notes
    -----
    The triangulation is laid out on the sphere with little distortion.  Then, degree by degree, harmonics are
    fitted by least squares in which distances along the surface hardly count, and each vertex is moved on the
    sphere to where the surface is nearest to it, until its distances along the normal do not decrease any
    more [1].  The surface is left free to slide along itself, and does so until the harmonics suffice best.
    The degree is the one of least generalized cross-validation.

    References
    ----------
    [1] J. Hoschek, Comput. Aided Geom. Des. 5 (1988) 27; W. Wang, H. Pottmann and Y. Liu, ACM TOG 25 (2006).
    """
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    unit = float(np.sqrt(area(metric) / (4.0 * np.pi)))
    middle = vertices.mean(axis=0)
    x = (vertices - middle) / unit
    u, faces = _laid_out(metric, x)
    start = _Fit(x, u, solid_angles(u, faces), np.ones(len(x)), Harmonics(0, 0), np.zeros((1, 3)))
    fit = _best_degree(start, MESH_FIT.degrees, faces)
    assert fit is not None
    if fit.misfit > MESH_FIT.poor:
        # Shapes that low degrees cannot follow may be left with vertices in wrong places.
        later = tuple(degree for degree in MESH_FIT.degrees if degree >= MESH_FIT.later)
        again = _best_degree(start, later, faces)
        if again is not None and again.chance * again.validation < fit.validation:
            fit = again
    coefficients = unit * fit.coefficients
    coefficients[0] += np.sqrt(4.0 * np.pi) * middle
    deviations = unit * fit.missed_elsewhere(faces) * fit.deviations()
    return MeshFit(coefficients, fit.harmonics, unit * fit.misfit, deviations, fit.u)


def _laid_out(metric: PolyhedralMetric, x: Floats) -> tuple[Floats, Indices]:
    """Directions of the vertices x (V, 3), and triangles between them that look outward."""
    u = sphere_layout(metric)
    if are_outward(metric.faces, u):
        return u, metric.faces
    # Conformal layouts of long thin bodies are those of other triangles: these are Delaunay on the sphere.
    faces = hull_faces(u)
    return least_distorted(PolyhedralMetric.from_mesh(x, faces), u), faces


def _best_degree(fit: _Fit, degrees: tuple[int, ...], faces: Indices) -> _Fit | None:
    """The fit of the degree that generalized cross-validation chooses, each begun at the one before.

    None if the vertices are too few for the first degree, which is not 1.
    """
    fits: list[_Fit] = []
    for degree in degrees:
        fit = fit.raised(degree)
        if degree > 1 and not fit.is_possible:
            break
        fit = _relaxed(fit.moved(fit.least(fit.missed)), faces)
        fits.append(fit)
        best = min(range(len(fits)), key=lambda i: fits[i].validation)
        if fit.misfit <= MESH_FIT.rounding or best < len(fits) - MESH_FIT.worse:
            break
    if not fits:
        return None
    # As good as the best of all, but for chance.
    enough = fit.chance * min(fit.validation for fit in fits)
    return next(fit for fit in fits if fit.validation <= enough)


def _relaxed(fit: _Fit, faces: Indices) -> _Fit:
    """The fit, vertices having been moved on the sphere until it gets no better."""
    for _ in range(MESH_FIT.rounds):
        better = fit.nearer().corrected(faces)
        if not (better.misfit < fit.misfit and better.is_determined):
            break
        enough = better.misfit > MESH_FIT.gain * fit.misfit
        fit = better
        if enough:
            break
    return fit


def _moved(u: Floats, step: Floats, faces: Indices) -> Floats:
    """Unit vectors moved by a step (V, 3), by less of it around triangles that would turn over."""
    share = np.ones((len(u), 1))
    for _ in range(MESH_FIT.halvings):
        v = u + share * step
        v /= np.linalg.norm(v, axis=1, keepdims=True)
        over = orientations(faces, v) <= 0.0
        if not over.any():
            return v
        share[np.unique(faces[over])] *= 0.5
    return u


@dataclass(frozen=True)
class _Fit:
    """Harmonics for vertices x (V, 3) at directions u (V, 3), their solid angles (V,), and which are used."""

    x: Floats
    u: Floats
    angles: Floats
    used: Floats
    harmonics: Harmonics
    coefficients: Floats

    @cached_property
    def table(self) -> Floats:
        """The harmonics (V, size)."""
        return self.harmonics.values(self.u)

    @cached_property
    def _tangents(self) -> tuple[Floats, Floats]:
        """Two tangent vectors of the sphere (V, 2, 3), and their images (V, 2, 3)."""
        e = np.stack(angle_frame(self.u), axis=1)
        first = self.harmonics.derivatives(self.u, self.coefficients)[1]
        return e, e @ first.transpose(0, 2, 1)

    @cached_property
    def normals(self) -> Floats:
        """Unit normals (V, 3) of the surface."""
        n = np.cross(self._tangents[1][:, 0], self._tangents[1][:, 1])
        length = np.linalg.norm(n, axis=1, keepdims=True)
        return n / np.where(length > 0.0, length, 1.0)

    @cached_property
    def missed(self) -> Floats:
        """Vectors (V, 3) from the surface to the vertices."""
        return self.x - self.table @ self.coefficients

    @cached_property
    def distances(self) -> Floats:
        """Their lengths (V,) along the normals."""
        return np.einsum("ni,ni->n", self.missed, self.normals)

    @cached_property
    def misfit(self) -> float:
        """Root mean square of the distances."""
        return float(np.sqrt(np.average(self.distances**2, weights=self.weights)))

    @property
    def weights(self) -> Floats:
        """Of the vertices (V,)."""
        return self.angles * self.used

    def missed_elsewhere(self, faces: Indices) -> float:
        """How far vertices are missed by a fit to the others, over how far they are missed by this one."""
        used = np.ones(len(self.x))
        used[np.random.default_rng(0).random(len(self.x)) < MESH_FIT.held_out] = 0.0
        without = replace(self, used=used)
        if not without.is_determined:
            return 1.0 / (1.0 - FIT.leverage)
        without = _relaxed(without.moved(without.least(without.missed)), faces)
        missed = np.average(without.distances**2, weights=self.angles * (1.0 - used))
        return max(MESH_FIT.doubt, float(np.sqrt(missed)) / max(self.misfit, MESH_FIT.rounding))

    @property
    def validation(self) -> float:
        """The score of generalized cross-validation."""
        return (self.misfit / (1.0 - self._freedom / len(self.x))) ** 2

    @property
    def chance(self) -> float:
        """Scores that differ by this factor may do so by chance."""
        return 1.0 + float(np.sqrt(8.0 / len(self.x)))

    @property
    def _freedom(self) -> int:
        """Degrees of freedom of distances along the normals, which add two degrees to the harmonics or so."""
        return deviating(self.harmonics).size

    @property
    def is_possible(self) -> bool:
        """Whether the vertices are enough to determine all coefficients, and not too many for the memory."""
        count = len(self.x)
        if self._freedom > MESH_FIT.fullest * count or self.harmonics.size * count > MESH_FIT.table:
            return False
        return self.is_determined

    def raised(self, degree: int) -> _Fit:
        """The same in harmonics of another degree."""
        harmonics = Harmonics(degree, degree)
        coefficients = resized(self.coefficients, self.harmonics, harmonics)
        return replace(self, harmonics=harmonics, coefficients=coefficients)

    def moved(self, change: Floats) -> _Fit:
        """With coefficients that differ by a change (size, 3)."""
        return replace(self, coefficients=self.coefficients + change)

    def nearer(self) -> _Fit:
        """A step of Gauss and Newton to the least distances along the normals."""
        return self.moved(self._least_along(self.missed))

    def corrected(self, faces: Indices) -> _Fit:
        """The same surface with the vertices moved to where it is nearest to them."""
        e, images = self._tangents
        q = images @ images.transpose(0, 2, 1)
        pulled = np.einsum("nai,ni->na", images, self.missed)
        step = np.einsum("na,nai->ni", np.linalg.solve(q, pulled[:, :, None])[:, :, 0], e)
        length = np.linalg.norm(step, axis=1)
        farthest = MESH_FIT.farthest * np.sqrt(4.0 * np.pi / len(self.x))
        step *= (farthest / np.maximum(length, farthest))[:, None]
        u = _moved(self.u, step, faces)
        return replace(self, u=u, angles=solid_angles(u, faces))

    def deviations(self) -> Floats:
        """See `MeshFit`."""
        random = np.random.default_rng(0)
        more = deviating(self.harmonics)
        signs = random.choice((-1.0, 1.0), (FIT.deviations, len(self.x), 1))
        signed = signs * self.distances[:, None] * self.normals
        drawn = np.array([resized(self.least(v), self.harmonics, more) for v in signed])
        higher = more.labels[0] > self.harmonics.degree
        following = self.raised(more.degree)
        size = self.misfit * np.sqrt(4.0 * np.pi / np.count_nonzero(higher))
        if following.is_determined:
            size = float(np.sqrt(np.mean(following.least(self.missed)[higher] ** 2)))
        drawn[:, higher] = size * random.normal(size=drawn[:, higher].shape)
        return drawn

    @cached_property
    def _root(self) -> Floats:
        return np.sqrt(self.weights)[:, None]

    @cached_property
    def _triangle(self) -> Floats:
        """The upper triangle R (size, size) of the weighted table, ``R^T R`` being its normal matrix."""
        rows = self._root * self.table
        return np.asarray(cholesky(rows.T @ rows))

    @property
    def is_determined(self) -> bool:
        """Whether the vertices determine all coefficients."""
        try:
            R = self._triangle
        except np.linalg.LinAlgError:
            return False
        return float(dtrcon(R)[0]) >= MESH_FIT.determined

    def least(self, vectors: Floats) -> Floats:
        """Coefficients (size, 3) of the least squares fit to vectors (V, 3)."""
        pulled = self.table.T @ (self.weights[:, None] * vectors)
        return np.asarray(cho_solve((self._triangle, False), pulled))

    def _least_along(self, vectors: Floats) -> Floats:
        """The same with a low weight of what is along the surface; iterations after a change by R."""
        R, n = self._triangle, self.normals

        def weighted(v: Floats) -> Floats:
            along = np.einsum("ni,ni->n", v, n)[:, None] * n
            return self._root * (MESH_FIT.sideways * v + (1.0 - MESH_FIT.sideways) * along)

        def forward(c: Floats) -> Floats:
            return weighted(self.table @ solve_triangular(R, c.reshape(-1, 3))).ravel()

        def backward(v: Floats) -> Floats:
            return solve_triangular(R, self.table.T @ weighted(v.reshape(-1, 3)), trans="T").ravel()

        shape = (self.x.size, 3 * self.harmonics.size)
        operator = LinearOperator(shape, matvec=forward, rmatvec=backward, dtype=np.float64)
        tolerance, most = MESH_FIT.solved, MESH_FIT.iterations
        found = lsmr(operator, weighted(vectors).ravel(), atol=tolerance, btol=tolerance, maxiter=most)
        return np.asarray(solve_triangular(R, found[0].reshape(-1, 3)))
