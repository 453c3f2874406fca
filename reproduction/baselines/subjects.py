"""What the methods are compared on: smooth metrics with known surfaces, and one mesh of each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial.distance import pdist

from isoembed import Embedding, PolyhedralMetric
from isoembed.gallery import Drum, Ellipsoid, Ergosphere, HarmonicSurface, KerrHorizon, Surface
from isoembed.relativity import KerrNewmanErgosphere, KerrNewmanHorizon
from isoembed.smooth import PulledBack, TwoMetric, triangulate_metric
from isoembed.surface.alignment import aligned
from reproduction.arrays import Floats

ARRIVED = 1e-6  # diameters: a surface so near to the true one is that one


@dataclass(frozen=True, eq=False)
class Subject:
    """A smooth metric on the sphere of directions and the surface that it was taken from.

    Attributes
    ----------
    name : str
    metric : TwoMetric
    point : callable
        Takes unit vectors (n, 3) and returns the points (n, 3) of the surface that they name.
    """

    name: str
    metric: TwoMetric
    point: Callable[[Floats], Floats]


@dataclass(frozen=True, eq=False)
class Problem:
    """A subject on a mesh, for methods that work on triangles.

    Attributes
    ----------
    subject : Subject
    directions : ndarray, shape (V, 3)
        Unit vectors that name the vertices.
    vertices : ndarray, shape (V, 3)
        The vertices on the true surface.
    metric : PolyhedralMetric
        The lengths of the edges between them.
    """

    subject: Subject
    directions: Floats
    vertices: Floats
    metric: PolyhedralMetric

    @classmethod
    def of(cls, subject: Subject, vertices: int) -> Problem:
        """Triangulate a subject with so many vertices."""
        mesh = triangulate_metric(subject.metric, vertices)
        points = subject.point(mesh.directions)
        return cls(subject, mesh.directions, points, PolyhedralMetric.from_mesh(points, mesh.faces))

    def realized(self, vertices: Floats) -> Embedding:
        """Vertices on the triangles of the problem, measured against its lengths."""
        return Embedding(self.metric, vertices, method="baseline", tolerance=ARRIVED)

    def distance(self, found: Embedding) -> float:
        """Largest distance of a vertex from its place on the true surface, over the diameter of that.

        After the best rigid motion or reflection.
        """
        both = (found.vertices, found.vertices * [1.0, 1.0, -1.0])
        away = (aligned(x, self.vertices) - self.vertices for x in both)
        apart = min(float(np.linalg.norm(each, axis=1).max()) for each in away)
        return apart / float(pdist(self.vertices).max())


def star_shaped(name: str, surface: Surface, axes: tuple[float, float, float] = (1.0, 1.0, 1.0)) -> Subject:
    """A surface about the origin in star-shaped coordinates: a direction names the point that lies in it.

    Horizon finders use them.  The gallery's directions are ``u / axes``: in these the ellipsoid's X itself is
    linear, and harmonics of degree 1 would be enough.
    """

    def point(u: Floats) -> Floats:
        return surface.point(u / np.array(axes))

    def differential(u: Floats) -> Floats:
        # X = r u, and dX is tangent to the surface: dX v = r (v - u (n . v) / (n . u)).
        n = surface.normal(u / np.array(axes))
        n /= np.einsum("ij,ij->i", n, u)[:, None]
        r = np.linalg.norm(point(u), axis=1)
        return np.asarray(r[:, None, None] * (np.eye(3) - u[:, :, None] * n[:, None, :]))

    return Subject(name, PulledBack(differential), point)


def saddled() -> Subject:
    """A body with K < 0 in places and no axis of symmetry, in star-shaped coordinates."""
    surface = HarmonicSurface(degree=2, order=2, amplitude=0.35)
    return star_shaped("harmonic body (2, 2, 0.35)", surface)


def paper_subjects() -> tuple[Subject, ...]:
    """The paper's ellipsoid, drum and ergosphere, and a Kerr horizon with K > 0.

    The last two are in Boyer-Lindquist angles, and K < 0 about the poles of the last one.
    """
    return (
        star_shaped("ellipsoid (3, 2, 1)", Ellipsoid((3.0, 2.0, 1.0)), (3.0, 2.0, 1.0)),
        star_shaped("drum", Drum(), Drum().axes),
        Subject("Kerr horizon, a = 0.8", KerrNewmanHorizon(mass=1.0, spin=0.8), KerrHorizon(spin=0.8).point),
        Subject(
            "ergosphere, epsilon = 0.3",
            KerrNewmanErgosphere(epsilon=0.3, mass=1.0, spin=0.975),
            Ergosphere(epsilon=0.3, spin=0.975).point,
        ),
    )
