"""Twenty families of random convex metrics, each made again from its name and a seed.

``make(family, seed)`` returns a `Case`.  All but the gluings of nets come from coordinates: lengths are taken
in extended precision and rounded once, or carried through random flips.  Bodies whose hull doubles cannot
tell (near-coincident vertices, for one) get it by brute force in extended precision; stretched ones are hulls
before they are stretched, which changes no face.
"""

from dataclasses import replace

import numpy as np
from scipy.spatial import QhullError

from alexandrov import outward_hull
from convex_bodies import fan, log_uniform, prism_like, round_body, sphere, with_flat_vertices
from convex_cases import Redo, above, case, exact_hull, twins_of
from convex_check import deficits
from convex_gluings import nets, polygons, polygons_with_flat_vertices
from convex_regular import COUNTS, regular


def make(family, seed):
    """The metric of this family and number."""
    if family in COUNTS:
        return regular(family, seed)
    for attempt in range(100):
        rng = np.random.default_rng([seed, attempt, *family.encode()])
        try:
            return FAMILIES[family](rng)
        except (Redo, QhullError):
            continue
    raise RuntimeError(f"{family} {seed} cannot be made")


def hulls(rng):
    return case(rng, *round_body(rng, 8, 120), shuffled=0)


def small(rng):
    points = (rng.normal if rng.random() < 0.5 else rng.uniform)(size=(int(rng.integers(4, 9)), 3))
    return case(rng, points, exact_hull(points), shuffled=0.3)


def flipped(rng):
    points, faces = round_body(rng, 6, 100)
    return case(rng, points * rng.uniform(1, 3, 3), faces, shuffled=1)


def flat_vertices(rng):
    body = round_body(rng, 5, 25)
    return case(rng, *with_flat_vertices(rng, *body, int(rng.integers(1, 40))), core=body)


def stretched(rng, low, high, needle):
    """A round body or a prism, made long or flat."""
    aspect = log_uniform(rng, low, high)
    points, faces = round_body(rng) if rng.random() < 0.7 else prism_like(rng, 0.5, 2)
    axes = np.array([aspect, rng.uniform(1, 2), 1.0] if needle else [rng.uniform(1, 2), 1.0, 1 / aspect])
    return case(rng, points * axes, faces, shuffled=0.3, size=aspect)


def caps(rng):
    height, n = log_uniform(rng, 1e-5, 1e-1), int(rng.integers(4, 50))
    r, a = np.sqrt(rng.random(n)), 2 * np.pi * rng.random(n)
    if rng.random() < 0.5:  # a base far below
        below = [[0, 0, -1 / height]]
    else:  # a flat base
        b = 2 * np.pi * np.sort(rng.random(int(rng.integers(4, 12))))
        below = np.column_stack([np.cos(b), np.sin(b), 0 * b])
        r *= 0.9
    points, faces = outward_hull(
        np.vstack([np.column_stack([r * np.cos(a), r * np.sin(a), 1 - r * r]), below])
    )
    return case(rng, points * [1, 1, height], faces, shuffled=0.2, size=height)


def near(rng):
    distance = log_uniform(rng, 1e-9, 1e-3)
    points = sphere(rng, int(rng.integers(6, 20)))
    pairs = int(rng.integers(1, 4))
    chosen = rng.choice(len(points), pairs, replace=False)
    beside = points[chosen] + distance * np.cross(points[chosen], sphere(rng, pairs))
    if rng.random() < 0.5:  # off the sphere: the edge between the two has any slope that keeps both
        beside += distance * rng.uniform(-1, 1, (pairs, 1)) * points[chosen]
    points = np.vstack([points, beside])
    return case(rng, points, exact_hull(points), shuffled=0.2, size=distance)


def stacked(rng):
    """Low pyramids on the faces of a body."""
    deficit = log_uniform(rng, 1e-12, 1e-3)
    points, faces = outward_hull(sphere(rng, int(rng.integers(4, 20))))
    chosen = rng.choice(len(faces), int(rng.integers(1, min(len(faces), 6) + 1)), replace=False)
    pyramids, tips = [], []
    for f in chosen:
        corners = points[faces[f]]
        foot = rng.dirichlet((3, 3, 3)) @ corners
        arms = corners - foot
        r = np.linalg.norm(arms, axis=1)
        cosine = np.einsum("ij,ij->i", arms, np.roll(arms, -1, axis=0)) / (r * np.roll(r, -1))
        # Of the deficit at a tip at height h, the factor of h^2.
        inner = 1 / (r * np.roll(r, -1)) - cosine * (1 / r**2 + 1 / np.roll(r, -1) ** 2) / 2
        height = np.sqrt(deficit / (inner / np.sqrt(1 - cosine**2)).sum())
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        tips.append(foot + height * normal / np.linalg.norm(normal))
        i, j, k = faces[f]
        new = len(points) + len(tips) - 1
        pyramids += [[i, j, new], [j, k, new], [k, i, new]]
    points = np.vstack([points, tips])
    faces = np.concatenate([np.delete(faces, chosen, axis=0), pyramids])
    if above(points, faces) >= 0:
        raise Redo
    return case(rng, points, faces, shuffled=0.3, size=deficit)


def noise(rng):
    body = round_body(rng, 5, 25)
    exact = case(rng, *with_flat_vertices(rng, *body, int(rng.integers(1, 40))), core=body)
    level = log_uniform(rng, 1e-14, 1e-6)
    faces, twins = exact.faces, twins_of(exact)
    lower = np.minimum(np.arange(twins.size), twins).reshape(-1, 3)
    lengths = exact.lengths * (1 + level * rng.normal(size=3 * len(faces))[lower])
    if (2 * lengths.max(axis=1) >= lengths.sum(axis=1)).any():
        raise Redo
    # What a user takes from the refusal: the deficit that is most negative.
    worst = float(-deficits(faces, lengths)[0].min())
    return replace(exact, lengths=lengths, repair=2 * max(worst, level), size=level)


def tetrahedra(rng):
    thinness = log_uniform(rng, 1e-6, 1)
    points = rng.normal(size=(4, 3))
    faces = exact_hull(points)
    points *= [1, log_uniform(rng, 1e-2, 1) if rng.random() < 0.3 else 1, thinness]
    return case(rng, points, faces, shuffled=0.3, size=thinness)


def prisms(rng):
    points, faces = prism_like(rng)
    return case(rng, points, faces, shuffled=0.3)


def cut(rng):
    """Bodies that planes cut out: three faces at every vertex."""
    normals, triangles = outward_hull(sphere(rng, int(rng.integers(6, 40))))
    points = np.linalg.solve(normals[triangles], np.ones((len(triangles), 3, 1)))[..., 0]
    faces = []
    for v, normal in enumerate(normals):
        around = np.flatnonzero((triangles == v).any(axis=1))
        arms = points[around] - normal
        x = arms[0] - (arms[0] @ normal) * normal
        order = np.argsort(np.arctan2(arms @ np.cross(normal, x), arms @ x))
        faces += fan(around[order].tolist())
    points = points * rng.uniform(1, 2, 3)
    if np.abs(points).max() > 50:
        raise Redo
    return case(rng, points, np.array(faces), shuffled=0.3)


def ellipsoids(rng):
    axes = [log_uniform(rng, 1, 300) for _ in range(3)] if rng.random() < 0.5 else (300.0, 1.0, 1.0)
    axes = np.array(axes) ** rng.choice([-1, 1])
    points, faces = outward_hull(sphere(rng, int(rng.integers(8, 120))))
    return case(rng, points * axes, faces, shuffled=0.5, size=float(axes.max() / axes.min()))


def rounded_and_scaled(rng):
    """Vertices rounded to single precision, or in a unit that is far from that of the lengths."""
    points = sphere(rng, int(rng.integers(6, 24))) * rng.uniform(1, 5, 3)
    if rng.random() < 0.5:
        points = points.astype(np.float32).astype(float)
        return case(rng, points, exact_hull(points), shuffled=0.3)
    unit = log_uniform(rng, 1e-150, 1e150)
    made = case(rng, points, exact_hull(points), shuffled=0.3)
    return replace(
        made, lengths=made.lengths * unit, points=points * unit, core=(points * unit, made.core[1]), size=unit
    )


FAMILIES = {
    "hulls": hulls,
    "small": small,
    "flipped": flipped,
    "flat vertices": flat_vertices,
    "polygons": polygons,
    "polygons, flat vertices": polygons_with_flat_vertices,
    "nets": nets,
    "needles": lambda rng: stretched(rng, 10, 1e3, needle=True),
    "longer needles": lambda rng: stretched(rng, 1e3, 1e4, needle=True),
    "slabs": lambda rng: stretched(rng, 10, 1e3, needle=False),
    "thinner slabs": lambda rng: stretched(rng, 1e3, 1e4, needle=False),
    "caps": caps,
    "near": near,
    "stacked": stacked,
    "noise": noise,
    "tetrahedra": tetrahedra,
    "prisms": prisms,
    "cut": cut,
    "ellipsoids": ellipsoids,
    "rounded and scaled": rounded_and_scaled,
}
"""What makes a case of each family from random numbers."""
