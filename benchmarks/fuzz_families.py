"""Families of the fuzzer: those of the convex sweep, and random metrics that are not convex, or are none.

``make(family, seed)`` returns a `Case`; ``METHODS[family]`` is the method that is asked, and
``KNOWN[family]`` what must come of it.
"""

from dataclasses import replace

import numpy as np
from scipy.spatial import QhullError

import convex_families
import isoembed.meshing.surface as surface_meshing
import space_forms
from alexandrov import outward_hull
from convex_bodies import log_uniform, round_body, sphere
from convex_cases import Case, Redo, check_sphere, rounded_lengths
from isoembed import InvalidMetric
from isoembed.gallery import Bean, BentTube, CassiniPeanut, Ergosphere, HarmonicSurface, triangulate
from isoembed.space import Space
from isoembed.space.models import from_model

REALIZABLE, UNKNOWN, NONE = "realizable", "unknown", "none"

# Meshes of at most 250 vertices: sampling a quarter of a million cells for each cost more than embedding it.
surface_meshing.CELLS = (128, 64)


def make(family, seed):
    """The metric of this family and number."""
    if family in convex_families.FAMILIES:
        return convex_families.make(family, seed)
    for attempt in range(100):
        rng = np.random.default_rng([seed, attempt, *family.encode()])
        try:
            return OTHERS[family][0](rng)
        except (Redo, QhullError, InvalidMetric):
            continue
    raise RuntimeError(f"{family} {seed} cannot be made")


def on_triangles(points, faces, size=1.0, name=""):
    """A surface on its own triangles."""
    check_sphere(faces, len(points))
    return Case(
        faces, None, rounded_lengths(points, faces), points, core=(points, faces), size=size, name=name
    )


def stars(rng):
    """Surfaces that are seen whole from a point, each vertex at a random distance."""
    directions, faces = outward_hull(sphere(rng, int(rng.integers(6, 80))))
    rough = log_uniform(rng, 1e-3, 0.7)
    return on_triangles(directions * np.exp(rough * rng.normal(size=(len(directions), 1))), faces, rough)


def dents(rng):
    """Convex bodies with some vertices pushed in."""
    points, faces = round_body(rng, 8, 60)
    depth = log_uniform(rng, 1e-6, 0.9)
    pushed = rng.choice(len(points), int(rng.integers(1, 4)), replace=False)
    points = points - points.mean(axis=0)
    points[pushed] *= 1 - depth
    return on_triangles(points, faces, depth)


def smooth(rng):
    """Smooth surfaces with K < 0 somewhere, on regular and irregular triangles."""
    degree = int(rng.integers(2, 6))
    surface = (
        Ergosphere(epsilon=log_uniform(rng, 0.02, 1)),
        CassiniPeanut(a=rng.uniform(0.75, 0.97)),
        HarmonicSurface(
            degree=degree, order=int(rng.integers(0, degree + 1)), amplitude=rng.uniform(0.05, 0.3)
        ),
        Bean(height=rng.uniform(0.3, 1.2)),
        BentTube(),
    )[rng.integers(5)]
    irregular = int(rng.integers(2**31)) if rng.random() < 0.7 else None
    points, faces = triangulate(surface, int(rng.integers(60, 250)), irregular=irregular)
    return on_triangles(points, faces, name=type(surface).__name__)


def perturbed(rng):
    """Lengths of a surface with noise, of which nobody knows whether they have one."""
    case = (stars, dents, smooth)[rng.integers(3)](rng)
    level = log_uniform(rng, 1e-14, 1e-2)
    return relengthened(case, lambda ends: 1 + level * rng.normal(size=len(ends)), size=level)


def conformal(rng):
    """Lengths of a body times factors at the vertices."""
    points, faces = round_body(rng, 8, 80)
    change = log_uniform(rng, 1e-3, 1)
    u = change * points @ rng.normal(size=3) if rng.random() < 0.5 else change * rng.normal(size=len(points))
    case = on_triangles(points, faces, change)
    return relengthened(case, lambda ends: np.exp(u[ends].sum(axis=1) / 2), size=change)


def random_lengths(rng):
    """A random triangulation with random lengths."""
    points, faces = outward_hull(sphere(rng, int(rng.integers(4, 40))))
    spread = rng.uniform(0.01, 0.9)
    case = on_triangles(points * 0 + sphere(rng, len(points)), faces, spread)
    own = {}

    def factors(ends):
        own["lengths"] = 1 + spread * rng.random(len(ends))
        return own["lengths"] / np.linalg.norm(case.points[ends[:, 0]] - case.points[ends[:, 1]], axis=1)

    return relengthened(case, factors, size=spread)


def relengthened(case, factor, size):
    """The same triangles with lengths times a factor of each edge's ends; nothing is known of a surface."""
    start, end = case.faces, np.roll(case.faces, -1, axis=1)
    ends = np.stack([np.minimum(start, end), np.maximum(start, end)], axis=2).reshape(-1, 2)
    edges, which = np.unique(ends, axis=0, return_inverse=True)
    lengths = case.lengths * factor(edges)[which.ravel()].reshape(-1, 3)
    lengths = lengths.ravel()[np.unique(which.ravel(), return_index=True)[1]][which.ravel()].reshape(-1, 3)
    if (2 * lengths.max(axis=1) >= lengths.sum(axis=1) * (1 - 1e-9)).any():
        raise Redo
    return replace(case, lengths=lengths, points=None, core=None, size=size)


def not_convex(rng):
    """Surfaces with a vertex whose total angle is clearly above 2 pi."""
    case = (stars, dents, smooth)[rng.integers(3)](rng)
    sides = case.lengths
    a, b, c = sides[:, 0], sides[:, 1], sides[:, 2]
    angles = np.stack([
        np.arccos(np.clip((p * p + q * q - r * r) / (2 * p * q), -1, 1))
        for p, q, r in ((a, c, b), (a, b, c), (b, c, a))
    ], axis=1)  # fmt: skip
    if np.bincount(case.faces.ravel(), angles.ravel()).max() < 2 * np.pi + 1e-4:
        raise Redo
    return case


def broken(rng):
    """Tables that are no metric: a triangle inequality, a length, a label or a triangle is wrong."""
    case = (stars, dents)[rng.integers(2)](rng)
    faces, lengths = case.faces.copy(), case.lengths.copy()
    f, kind = int(rng.integers(len(faces))), int(rng.integers(4))
    if kind == 0:
        edge = np.sort(faces[f, :2])
        start, end = faces, np.roll(faces, -1, axis=1)
        lengths[(np.minimum(start, end) == edge[0]) & (np.maximum(start, end) == edge[1])] *= 1000
    elif kind == 1:
        lengths[:] = rng.choice([np.nan, np.inf, -1.0, 0.0])
    elif kind == 2:
        faces[f, 0] = rng.choice([-1, faces.max() + 2, faces[f, 1]])
    else:
        faces, lengths = np.delete(faces, f, axis=0), np.delete(lengths, f, axis=0)
    return Case(faces, None, lengths, size=float(kind))


def in_space(rng, sign):
    """A convex body on triangles that random flips made."""
    seed = int(rng.integers(2**31))
    y, faces, size, _ = space_forms.body(seed, sign)
    space = Space(float(sign))
    x = from_model(space, y, "projective")
    metric = space_forms.metric_of(x, faces, space, seed)
    tables = metric.faces, metric.twins, metric.face_lengths
    return Case(*tables, x, core=(x, faces), roundings=256.0, size=size, curvature=float(sign))


def stars_in_space(rng, sign):
    """Surfaces that are seen whole from a point, each vertex at a random distance, on their own triangles."""
    space = Space(float(sign))
    directions, faces = outward_hull(sphere(rng, int(rng.integers(6, 60))))
    check_sphere(faces, len(directions))
    size, rough = log_uniform(rng, 1e-2, 1), log_uniform(rng, 1e-3, 0.4)
    radii = size * np.exp(rough * rng.uniform(-1, 1, (len(directions), 1)))
    x = directions * space.sn(radii)
    lengths = space.distances(x[faces], x[np.roll(faces, -1, axis=1)])
    edge = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    _, first, which = np.unique(edge, axis=0, return_index=True, return_inverse=True)
    lengths = lengths.ravel()[first][which.ravel()].reshape(-1, 3)
    return Case(faces, None, lengths, x, core=(x, faces), size=size, curvature=float(sign))


OTHERS = {
    "stars": (stars, "aim", REALIZABLE),
    "dents": (dents, "aim", REALIZABLE),
    "smooth, K < 0": (smooth, "aim", REALIZABLE),
    "perturbed": (perturbed, "aim", UNKNOWN),
    "conformal": (conformal, "aim", UNKNOWN),
    "random lengths": (random_lengths, "aim", UNKNOWN),
    "not convex": (not_convex, "alexandrov", NONE),
    "broken": (broken, "aim", NONE),
    "hyperbolic": (lambda rng: in_space(rng, -1), "alexandrov", REALIZABLE),
    "spherical": (lambda rng: in_space(rng, 1), "alexandrov", REALIZABLE),
    "hyperbolic stars": (lambda rng: stars_in_space(rng, -1), "aim", REALIZABLE),
    "spherical stars": (lambda rng: stars_in_space(rng, 1), "aim", REALIZABLE),
}
"""What makes a case from random numbers, the method that is asked, and what is known of the metric."""

FAMILIES = (*convex_families.FAMILIES, *OTHERS)
METHODS = dict.fromkeys(convex_families.FAMILIES, "alexandrov") | {k: v[1] for k, v in OTHERS.items()}
KNOWN = dict.fromkeys(convex_families.FAMILIES, REALIZABLE) | {k: v[2] for k, v in OTHERS.items()}
