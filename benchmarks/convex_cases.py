"""What a case of the convex sweep is, and how bodies become one."""

from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from alexandrov import scrambled

THINNEST = 1e-3  # height over longest side of the triangles that random flips leave


@dataclass(frozen=True, eq=False)
class Case:
    """A metric, and what is known of its polyhedron.

    Attributes
    ----------
    faces : ndarray, shape (F, 3)
    twins : ndarray, shape (3F,), or None
        None if the faces are a simplicial complex, to be given as a `PolyhedralMetric`.
    lengths : ndarray, shape (F, 3)
        Of the side from each corner to the next.
    points : ndarray, shape (V, 3), or None
        The discarded coordinates; None if there are none.
    core : tuple of ndarray, or None
        Vertices (the first ones) and faces of the body without its flat vertices; None if it is flat itself.
    roundings : float
        Machine epsilons by which the lengths may be off.
    repair : float
        Radians of negative deficits to repair, if noise was added to the lengths.
    name : str
        Of the solid, if it has one.
    size : float
        What the family is about: aspect, distance, deficit.
    curvature : float
        Of the triangles, and of the space that the points are in.
    """

    faces: np.ndarray
    twins: np.ndarray | None
    lengths: np.ndarray
    points: np.ndarray | None = None
    core: tuple | None = None
    roundings: float = 4.0
    repair: float = 0.0
    name: str = ""
    size: float = 1.0
    curvature: float = 0.0


def twins_of(case):
    """The half-edge on the other side of each, (3F,)."""
    if case.twins is not None:
        return case.twins
    start, end = case.faces.ravel(), np.roll(case.faces, -1, axis=1).ravel()
    twins = np.empty(start.size, dtype=np.int64)
    twins[np.lexsort((end, start))] = np.lexsort((start, end))
    return twins


class Redo(Exception):  # noqa: N818
    """The draw made no body of the kind that is wanted."""


def rounded_lengths(points, faces):
    """Lengths of the sides, each rounded once, shape (F, 3)."""
    p = points.astype(np.longdouble)
    return np.sqrt(((p[np.roll(faces, -1, axis=1)] - p[faces]) ** 2).sum(axis=2)).astype(float)


def case(rng, points, faces, core=None, shuffled=0.5, size=1.0, name="", flat=False):
    """A body on its own triangles, or with this probability on others."""
    check_sphere(faces, len(points))
    if above(points, faces) > 1e-14:
        raise Redo
    core = None if flat else core or (points, faces)
    if rng.random() < shuffled:
        metric = scrambled(points, faces, int(rng.integers(2**31)), THINNEST)
        tables = metric.faces, metric.twins, metric.face_lengths
        return Case(*tables, points, core, roundings=256.0, size=size, name=name)
    return Case(faces, None, rounded_lengths(points, faces), points, core, size=size, name=name)


def relabeled(case, rng):
    """The same metric with other numbers, in another unit; the new numbers of vertices; and the unit."""
    new, unit = rng.permutation(case.faces.max() + 1), 10 ** rng.uniform(-8, 8)
    place, turn = rng.permutation(len(case.faces)), rng.integers(3, size=len(case.faces))
    halfedge = 3 * place[:, None] + (np.arange(3) - turn[:, None]) % 3  # of the old face and corner
    faces, lengths = np.empty(case.faces.size, dtype=np.int64), np.empty(case.faces.size)
    faces[halfedge], lengths[halfedge] = new[case.faces], case.lengths * unit
    twins = None
    if case.twins is not None:
        twins = np.empty_like(case.twins)
        twins[halfedge.ravel()] = halfedge.ravel()[case.twins]
    tables = {"faces": faces.reshape(-1, 3), "twins": twins, "lengths": lengths.reshape(-1, 3)}
    copy = replace(case, **tables, curvature=case.curvature / unit**2)
    return copy, new, unit


def check_sphere(faces, n):
    """Ask for another draw unless these are triangles of a sphere through all n vertices."""
    sides = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)
    once = len(np.unique(sides, axis=0)) == len(sides) == 6 * n - 12
    if not once or len(np.unique(np.sort(sides, axis=1), axis=0)) != 3 * n - 6:
        raise Redo


def above(points, faces):
    """How far a vertex is above the plane of a face that it is not of: volume over the cube of the size."""
    p = points.astype(np.longdouble) / np.ptp(points, axis=0).max()
    a, b, c = (p[faces[:, k]] for k in range(3))
    sides = np.einsum("fk,fvk->fv", np.cross(b - a, c - a), p[None] - a[:, None])
    np.put_along_axis(sides, faces, -1, axis=1)
    return sides.max()


def exact_hull(points):
    """Faces of the hull of few points in general position, all of them vertices, in extended precision."""
    p, triples = points.astype(np.longdouble), np.array(list(combinations(range(len(points)), 3)))
    a, b, c = (p[triples[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    sides = np.einsum("fk,fvk->fv", normals, p[None] - a[:, None])
    np.put_along_axis(sides, triples, 0, axis=1)
    below, above = (sides <= 0).all(axis=1), (sides >= 0).all(axis=1)
    faces = np.concatenate([triples[below], triples[above][:, ::-1]])
    check_sphere(faces, len(points))
    return faces
