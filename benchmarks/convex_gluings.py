"""Random metrics that are glued from plane convex polygons."""

import numpy as np
from scipy.spatial import ConvexHull

from convex_bodies import log_uniform, with_flat_vertices
from convex_cases import Case, Redo, case, rounded_lengths


def outline(rng, most=30):
    """A convex polygon in the plane z = 0."""
    n = int(rng.integers(3, most))
    if rng.random() < 0.5:
        angle = 2 * np.pi * np.sort(rng.random(n))
        points = np.column_stack([np.cos(angle), np.sin(angle)])
    else:
        points = rng.normal(size=(2 * n, 2))
        points = points[ConvexHull(points).vertices]
    return np.column_stack([points * [log_uniform(rng, 1, 10), 1], np.zeros(len(points))])


def two_sheets(points):
    """Fans over a polygon: from the first vertex on the front and from the second on the back."""
    n = len(points)
    i = np.arange(1, n - 1)
    front = np.stack([np.zeros_like(i), i, i + 1], axis=1)
    back = np.stack([np.ones_like(i), (i + 2) % n, i + 1], axis=1)
    return np.concatenate([front, back])


def polygons(rng):
    points = outline(rng)
    faces = two_sheets(points)
    if len(points) == 3:
        return Case(faces, None, rounded_lengths(points, faces), points)
    return case(rng, points, faces, flat=True)


def polygons_with_flat_vertices(rng):
    points = outline(rng, 15)
    points, faces = with_flat_vertices(rng, points, two_sheets(points), int(rng.integers(1, 25)))
    return case(rng, points, faces, flat=True)


def disk(outline_points, start):
    """A fan from inside over an outline, numbered from `start`, the inner vertex last: (faces, lengths)."""
    n = len(outline_points)
    i = np.arange(n)
    center = np.full(n, start + n)
    points = np.vstack([outline_points, outline_points.mean(axis=0)])
    faces = np.stack([i, (i + 1) % n, np.full(n, n)], axis=1)
    return np.stack([start + i, start + (i + 1) % n, center], axis=1), rounded_lengths(points, faces)


def along(points, distances):
    """Points at these distances along an outline, counted from its first point."""
    steps = np.linalg.norm(points - np.roll(points, -1, axis=0), axis=1)
    at = np.concatenate([[0.0], np.cumsum(steps)])
    k = np.clip(np.searchsorted(at, distances, side="right") - 1, 0, len(points) - 1)
    s = ((distances - at[k]) / steps[k])[:, None]
    return (1 - s) * points[k] + s * points[(k + 1) % len(points)]


def perimeter(points):
    return np.linalg.norm(points - np.roll(points, -1, axis=0), axis=1).sum()


def nets(rng):
    """Convex polygons, one glued to itself or two to one another, with every total angle at most 2 pi."""
    first = outline(rng, 12)
    steps = np.linalg.norm(first - np.roll(first, -1, axis=0), axis=1)
    at = (np.cumsum(steps) - steps) / steps.sum()
    if rng.random() < 0.5:  # one, folded where its outline is halved
        at = (at + rng.random()) % 1
        shift = at[0]
        stops = np.unique(np.concatenate([[0.0, 0.5], at, (1 - at) % 1]))
        apart(stops)
        points = along(first, ((stops - shift) % 1) * steps.sum())
        n = len(stops)
        faces, lengths = disk(points, 0)
        partner = (-np.arange(n)) % n
        names = np.append(np.minimum(np.arange(n), partner), n)
        glued = (-1 - np.arange(n)) % n  # side i runs from stop i to the next
        twins = fan_twins(n, 0)
        twins[3 * np.arange(n)] = 3 * glued
        faces, lengths[:, 0] = names[faces], (lengths[:, 0] + lengths[glued, 0]) / 2
    else:  # two of one perimeter, the second turned over
        second = outline(rng, 12)
        second *= perimeter(first) / perimeter(second)
        sides = np.linalg.norm(second - np.roll(second, -1, axis=0), axis=1)
        other = (np.cumsum(sides) - sides) / sides.sum()
        turn = rng.random()
        other = (1 - other - turn) % 1  # seen from the first one
        stops = np.unique(np.concatenate([at, other]))
        apart(stops)
        n = len(stops)
        faces, lengths = disk(along(first, stops * steps.sum()), 0)
        back = (1 - stops - turn) % 1
        reversed_order = np.argsort(back)
        below, below_lengths = disk(along(second, back[reversed_order] * sides.sum()), n + 1)
        # Corner i of the second outline is stop reversed_order[i]; its side i runs to the stop before.
        glued = (reversed_order - 1) % n
        twins = np.concatenate([fan_twins(n, 0), fan_twins(n, 3 * n)])
        twins[3 * n + 3 * np.arange(n)] = 3 * glued
        twins[3 * glued] = 3 * n + 3 * np.arange(n)
        common = (lengths[glued, 0] + below_lengths[:, 0]) / 2
        below_lengths[:, 0] = lengths[glued, 0] = common
        names = np.concatenate([np.arange(n + 1), reversed_order, [n + 1]])
        faces, lengths = names[np.concatenate([faces, below])], np.concatenate([lengths, below_lengths])
    faces = np.unique(faces, return_inverse=True)[1]
    return Case(faces.reshape(-1, 3), twins, lengths, roundings=64.0)


def apart(stops):
    """Ask for another draw if two stops nearly coincide, around the outline."""
    if np.diff(np.append(stops, 1 + stops[0])).min() < 1e-4:
        raise Redo


def fan_twins(n, start):
    """Twins of the inner sides of a fan of n triangles whose half-edges begin at `start`; -1 outside."""
    twins = np.full(3 * n, -1)
    i = np.arange(n)
    twins[3 * i + 1], twins[3 * ((i + 1) % n) + 2] = start + 3 * ((i + 1) % n) + 2, start + 3 * i + 1
    return twins
