"""Compiled parts of the relaxation of a metric: steps of triangles on the sphere, by lengths alone.

The tables over half-edges are those of `isoembed.intrinsic.halfedges`.  Vertices also have directions u
(V, 3) on the unit sphere, in which every triangle looks outward.
"""

import math

import numpy as np

from isoembed.arrays import Floats, Mask
from isoembed.intrinsic.halfedges import HalfEdges, corner_angle, following, preceding
from isoembed.intrinsic.outward import looks_outward
from isoembed.kernel import kernel
from isoembed.meshing.lloyd import LONGEST_STEP


def angles_from_lengths(lengths: Floats) -> Floats:
    """Angles (F, 3), in radians, 0 and pi where the lengths make no triangle: `angle_between` of arrays."""
    sides = lengths.reshape(-1, 3)
    third, s = np.roll(sides, 1, axis=1), np.roll(sides, -1, axis=1)
    a, b = np.maximum(sides, third), np.minimum(sides, third)
    mu = np.where(b >= s, s - (a - b), b - (a - s))
    sine, cosine = (a - b + s) * mu, (a + (b + s)) * np.maximum(a - s + b, 0.0)
    return np.asarray(2 * np.arctan2(np.sqrt(np.maximum(sine, 0.0)), np.sqrt(cosine)))


def end_lengths(u: Floats, q: Floats, mesh: HalfEdges) -> None:
    """Measure all half-edges by the mean of the metric's tensors q (V, 3, 3) at their ends, in place.

    That is of second order in the length, and exact on round spheres.
    """
    corners, twins, lengths = mesh.corners, mesh.twins, mesh.lengths
    lower = np.flatnonzero(np.arange(twins.size) < twins)
    upper = twins[lower]
    i, j = corners[lower], corners[upper]
    chords = u[j] - u[i]
    half = 0.5 * np.sqrt((chords**2).sum(axis=1))
    squares = 0.5 * np.einsum("ha,hab,hb->h", chords, q[i] + q[j], chords)
    # The tangent part of the chord is the sine of the arc.
    with np.errstate(divide="ignore", invalid="ignore"):  # of vertices that coincide, or are antipodes
        lengths[lower] = np.sqrt(squares) * np.arcsin(half) / (half * np.sqrt(1.0 - half**2))
    lengths[upper] = lengths[lower]


@kernel
def _length(v: Floats) -> float:
    return np.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])


@kernel
def relaxed(
    u: Floats, mesh: HalfEdges, density: Floats, moving: Mask, optimal: bool, factor: float
) -> Floats:
    """Directions (V, 3) after some vertices have moved within their stars, unfolded into the plane.

    Parameters
    ----------
    u : ndarray, shape (V, 3)
    mesh : HalfEdges
        A Delaunay triangulation.
    density : ndarray, shape (V,)
        Wanted vertices per area, up to a factor.
    moving : ndarray of bool, shape (V,)
    optimal : bool
        Towards the mean circumcenter of the triangles (an optimal Delaunay triangulation: Chen and Holst,
        2011), which repairs quickly; or towards the centroid of the Voronoi cell (Du, Faber and Gunzburger,
        1999), which evens out.  Both have the given density where the mass is its square.
    factor : float
        Over-relaxation.

    Notes
    -----
    The angles of a star are scaled to 2 pi.  A step in the plane becomes one on the sphere by the linear map
    that best takes the neighbors' unfolded positions to their directions.  Steps that would turn a triangle
    over are shortened.
    """
    corners = mesh.corners
    moved = u.copy()
    done = ~moving
    for first in range(corners.size):
        v = corners[first]
        if not done[v]:
            done[v] = True
            moved[v] += _step(first, u, mesh, density, optimal, factor)
            moved[v] /= _length(moved[v])
    keep = 0.5
    for attempt in range(9):
        turned = False
        for f in range(0, corners.size, 3):
            if not looks_outward(moved, corners[f], corners[f + 1], corners[f + 2]):
                turned = True
                for v in corners[f : f + 3]:
                    moved[v] = u[v] + keep * (moved[v] - u[v])
                    moved[v] /= _length(moved[v])
        if not turned:
            return moved
        if attempt == 7:
            keep = 0.0
    return u.copy()


@kernel
def _step(first: int, u: Floats, mesh: HalfEdges, density: Floats, optimal: bool, factor: float) -> Floats:
    """The tangent displacement (3,) of the vertex that half-edge `first` leaves."""
    corners, twins, lengths = mesh.corners, mesh.twins, mesh.lengths
    v = corners[first]
    total, shortest = 0.0, np.inf
    h = first
    while True:
        total += corner_angle(h, mesh)
        shortest = min(shortest, lengths[h])
        h = twins[preceding(h)]
        if h == first:
            break

    step = np.zeros(3)
    if not (total > 0.0 and shortest > 0.0):
        return step  # lengths that make no triangles
    scale = 2.0 * np.pi / total
    weight, x, y = 0.0, 0.0, 0.0
    xx, xy, yy = 0.0, 0.0, 0.0
    along_x, along_y = np.zeros(3), np.zeros(3)
    direction = 0.0
    px, py = lengths[first], 0.0
    while True:
        into = preceding(h)
        j, k = corners[following(h)], corners[into]
        direction += scale * corner_angle(h, mesh)
        qx, qy = lengths[into] * math.cos(direction), lengths[into] * math.sin(direction)
        xx += px * px
        xy += px * py
        yy += py * py
        height = u[j, 0] * u[v, 0] + u[j, 1] * u[v, 1] + u[j, 2] * u[v, 2]
        for a in range(3):
            tangent = u[j, a] - height * u[v, a]
            along_x[a] += tangent * px
            along_y[a] += tangent * py
        double = px * qy - py * qx
        if double > 0.0:
            p2, q2 = px * px + py * py, qx * qx + qy * qy
            cx, cy = 0.5 * (qy * p2 - py * q2) / double, 0.5 * (px * q2 - qx * p2) / double
            mean = (density[v] + density[j] + density[k]) / 3.0
            if optimal:
                mass = double * mean * mean
                weight += mass
                x += mass * cx
                y += mass * cy
            else:
                for mx, my, side, neighbor in ((0.5 * px, 0.5 * py, 1.0, j), (0.5 * qx, 0.5 * qy, -1.0, k)):
                    # Signed: the circumcenter of an obtuse triangle lies outside.
                    area = side * (mx * cy - my * cx)
                    middle = 0.5 * (density[v] + density[neighbor])
                    share = (density[v] + middle + mean) / 3.0
                    mass = area * (share * share)
                    weight += mass
                    x += mass * (mx + cx) / 3.0
                    y += mass * (my + cy) / 3.0
        px, py = qx, qy
        h = twins[into]
        if h == first:
            break

    determinant = xx * yy - xy * xy
    if not (weight > 0.0 and determinant > 0.0):
        return step
    x, y = factor * x / weight, factor * y / weight
    bound = LONGEST_STEP * shortest
    cut = bound / max(bound, np.hypot(x, y))
    a, b = cut * (yy * x - xy * y) / determinant, cut * (xx * y - xy * x) / determinant
    for c in range(3):
        step[c] = a * along_x[c] + b * along_y[c]
    return step
