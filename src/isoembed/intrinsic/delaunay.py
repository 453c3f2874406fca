"""The Delaunay loop, compiled: edges on a stack are flipped, and those around them put on it.

What an edge is flipped for, and what else there is to a flip, is a rule: a named tuple of arrays whose type
chooses, when the loop is compiled, the function that was made its `attempt`.  That costs nothing, and unlike
a loop that takes a function, or a closure over one, the next process finds it in numba's cache, where rules
are known by their modules.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.intrinsic.flips import Tracked, flip, flip_tracked
from isoembed.intrinsic.halfedges import HalfEdges, following, preceding
from isoembed.kernel import kernel, with_numba
from isoembed.space.trigonometry import amplitude, apex, chord, cs, sn, twice_area

SLACK = 1e-12  # relative: an edge that is Delaunay to this is left alone
ROUNDING = 4e-16  # of a difference of squared lengths, relative to their sum
THINNEST = 1e-15  # height over longest side: thinner triangles are lost in rounding
THIN = 1e-8  # height over longest side: the sides of a thinner triangle add up in floats

END, FREE = -1, -2  # on the stack: nothing below, and not on it
BLOCKED, LEFT, FLIPPED = -1, 0, 1


_ATTEMPTS: dict[type | None, Callable] = {}  # by the kind of their rules


def attempt(h: int, mesh: NamedTuple, rule: NamedTuple) -> int:
    """Flip the edge of a half-edge if a rule demands it; for kernels.

    Returns
    -------
    int
        `FLIPPED`; `LEFT` if it is not to be flipped; `BLOCKED` if it is, but cannot be.
    """
    return int(_ATTEMPTS[type(rule)](h, mesh, rule))


@with_numba
def _compile_attempt() -> None:
    from numba.extending import overload

    @overload(attempt, strict=False)  # it would compare annotations
    def choose(h: Any, mesh: Any, rule: Any) -> Callable | None:
        return _ATTEMPTS.get(getattr(rule, "instance_class", None))


def attempts(kind: type) -> Callable[[Callable], Callable]:
    """Decorator that makes a function of ``(h, mesh, rule)`` the `attempt` of a kind of rules."""

    def register(function: Callable) -> Callable:
        _ATTEMPTS[kind] = function
        return function

    return register


@kernel
def empty_stack(n: int) -> Indices:
    """A stack for edges of n half-edges: for each the next below it, or `FREE`; last, the top one."""
    stack = np.full(n + 1, FREE)
    stack[n] = END
    return stack


@kernel
def push(h: int, stack: Indices, twins: Indices) -> None:
    """Put the edge of a half-edge, as the lower one, on a stack, unless it is there."""
    name = min(h, twins[h])
    if stack[name] == FREE:
        stack[name] = stack[-1]
        stack[-1] = name


@kernel
def restore_delaunay(stack: Indices, mesh: Any, rule: Any) -> tuple[int, int]:
    """Flip the edges on a stack, and around those that are flipped, as a rule demands; the stack is emptied.

    Returns
    -------
    int, int
        Flips made, and edges that were to be flipped when that could not be done.
    """
    twins = mesh.twins
    limit = 100 * twins.size + 1000  # far beyond what terminates: rounding could go in circles
    flips = blocked = 0
    while stack[-1] != END:
        h = stack[-1]
        stack[-1] = stack[h]
        stack[h] = FREE
        t = twins[h]
        outcome = attempt(h, mesh, rule) if flips < limit else BLOCKED
        if outcome == FLIPPED:
            flips += 1
            for side in (h, preceding(h), t, preceding(t)):
                push(side, stack, twins)
        elif outcome == BLOCKED:
            blocked += 1
    return flips, blocked


@kernel
def flip_edges(edges: Indices, mesh: Any, rule: Any) -> tuple[int, int]:
    """Do what `restore_delaunay` does, beginning with the edges of these half-edges."""
    stack = empty_stack(mesh.twins.size)
    for h in edges:
        push(h, stack, mesh.twins)
    return restore_delaunay(stack, mesh, rule)


class Weighted(NamedTuple):
    """The rule of a weighted Delaunay triangulation; with equal weights, of the Delaunay triangulation.

    Attributes
    ----------
    weights : ndarray, shape (V,)
        Squared radii, less any constant; in curved space squared `chord` of the radii.
    """

    weights: Floats


@attempts(Weighted)
def _attempt_weighted(h: int, mesh: HalfEdges, rule: Weighted) -> int:
    if is_delaunay(h, mesh, rule.weights):
        return LEFT
    return FLIPPED if flip(h, mesh, THINNEST) else BLOCKED


@attempts(Tracked)
def _attempt_tracked(h: int, mesh: HalfEdges, rule: Tracked) -> int:
    if rule.kept[h] or is_delaunay(h, mesh, rule.weights):
        return LEFT
    return FLIPPED if flip_tracked(h, mesh, rule, THIN) else BLOCKED


def make_delaunay(mesh: HalfEdges, weights: Floats, edges: Indices | None = None) -> tuple[int, int]:
    """Flip to the weighted Delaunay triangulation, in place.

    Parameters
    ----------
    mesh : HalfEdges
    weights : ndarray, shape (V,)
        Squared radii, less any constant, so that equal ones make the Delaunay triangulation; in curved space
        the squares of the `chord` of the radii, of which only zeros do.
    edges : ndarray of int, optional
        What `non_delaunay_edges` says, where it is known already.

    Returns
    -------
    int, int
        Flips made, and edges that are not Delaunay but cannot be flipped: a vertex is hidden, and the
        weights have no Delaunay triangulation that uses them all.
    """
    edges = non_delaunay_edges(mesh, weights) if edges is None else edges
    flips, blocked = flip_edges(edges, mesh, Weighted(weights))
    # Some that were blocked may have come free by other flips.
    return flips, non_delaunay_edges(mesh, weights).size if blocked else 0


# A call would copy all of the named tuple: compiled into its callers, though the formulas of curved space
# make it longer than what is by itself.
@kernel(forceinline=True)
def tilt(h: int, mesh: HalfEdges, weights: Floats) -> tuple[float, float]:
    """Signed distance of the power center of h's triangle from h, positive inside, and its rounding error.

    It is d = ((|ik|^2 + q_i - q_k) / 2 - p x) / y with p = (l^2 + q_i - q_j) / (2 l).  In curved space it is
    the sine of the distance of the apex from the line of h, times the cosine of the angle between triangle
    and apex there: on hyperboloid and sphere, where the cosines of the radii at the corners are those of a
    linear function, the slope of that across h, over the curvature.
    """
    corners, lengths, k = mesh.corners, mesh.lengths, mesh.curvature
    after, before = following(h), preceding(h)
    l, second, third = lengths[h], lengths[after], lengths[before]
    a, b, c = weights[corners[h]], weights[corners[after]], weights[corners[before]]
    if k != 0:
        return _curved_tilt(l, second, third, a, b, c, k)
    x, y = apex(l, second, third, k)
    p = (l + (a - b) / l) / 2
    if y <= 0:
        return -np.inf, 0.0
    size = abs(a) + abs(b) + abs(c) + l * l + third * third
    return ((third * third + a - c) / 2 - p * x) / y, ROUNDING * size / y


@kernel
def _curved_tilt(
    l: float, second: float, third: float, a: float, b: float, c: float, k: float
) -> tuple[float, float]:
    x, y = apex(l, second, third, k)
    if y <= 0:
        return -np.inf, 0.0
    along, up, flat = chord(l, k), chord(third, k), 1 - k * a / 2
    along, up = along * along, up * up
    p = (along * flat + (a - b)) / (2 * np.float64(sn(l, k)))
    size = abs(a) + abs(b) + abs(c) + along + up
    return ((up * flat + (a - c)) / 2 - p * x) / y, ROUNDING * size / y


@kernel
def tilts(mesh: HalfEdges, weights: Floats) -> tuple[Floats, Floats]:
    """The tilts of all half-edges and their rounding errors, shape (3F,)."""
    if mesh.curvature != 0:
        return _curved_tilts(mesh, weights)
    corners, lengths = mesh.corners, mesh.lengths
    values, errors = np.empty(corners.size), np.empty(corners.size)
    for f in range(0, corners.size, 3):
        i, j, k = weights[corners[f]], weights[corners[f + 1]], weights[corners[f + 2]]
        a, b, c = lengths[f], lengths[f + 1], lengths[f + 2]  # ij, jk, ki
        area = twice_area(a, b, c)
        if area <= 0:
            values[f : f + 3] = -np.inf
            errors[f : f + 3] = 0.0
            continue
        at_i = (a * a + (c - b) * (c + b)) / 2  # products of the two sides at a corner
        at_j = (b * b + (a - c) * (a + c)) / 2
        at_k = (c * c + (b - a) * (b + a)) / 2
        values[f] = (a * (c * c + i - k) - (a * a + i - j) * at_i / a) / (2 * area)
        values[f + 1] = (b * (a * a + j - i) - (b * b + j - k) * at_j / b) / (2 * area)
        values[f + 2] = (c * (b * b + k - j) - (c * c + k - i) * at_k / c) / (2 * area)
        size = (abs(i) + abs(j) + abs(k) + a * a + b * b + c * c) * ROUNDING / area
        errors[f], errors[f + 1], errors[f + 2] = a * size, b * size, c * size
    return values, errors


@kernel
def _curved_tilts(mesh: HalfEdges, weights: Floats) -> tuple[Floats, Floats]:
    corners, lengths, curvature = mesh.corners, mesh.lengths, mesh.curvature
    values, errors = np.empty(corners.size), np.empty(corners.size)
    q, sine, cosine, square = np.empty((4, 3))
    for f in range(0, corners.size, 3):
        area = amplitude(lengths[f], lengths[f + 1], lengths[f + 2], curvature)
        if area <= 0:
            values[f : f + 3] = -np.inf
            errors[f : f + 3] = 0.0
            continue
        for c in range(3):
            l = lengths[f + c]
            half, other = sn(l / 2, curvature), cs(l / 2, curvature)
            sine[c], square[c] = 2 * half * other, 4 * half * half
            cosine[c] = 1 - 2 * curvature * half * half
            q[c] = weights[corners[f + c]]
        total = abs(q[0]) + abs(q[1]) + abs(q[2]) + square[0] + square[1] + square[2]
        for c in range(3):
            after, before = (c + 1) % 3, (c + 2) % 3  # sides ij, jk, ki
            jk, ki = lengths[f + after], lengths[f + before]
            product = square[c] * cosine[before] / 2
            product += 2 * sn((ki - jk) / 2, curvature) * sn((ki + jk) / 2, curvature)
            flat = 1 - curvature * q[c] / 2
            third = square[before] * flat + (q[c] - q[before])
            along = square[c] * flat + (q[c] - q[after])
            values[f + c] = (sine[c] * third - along * product / sine[c]) / (2 * area)
            errors[f + c] = ROUNDING * sine[c] * total / area
    return values, errors


@kernel
def non_delaunay_edges(mesh: HalfEdges, weights: Floats) -> Indices:
    """The edges that are not weighted Delaunay, as their lower half-edges."""
    d, error = tilts(mesh, weights)
    found = np.empty(d.size // 2, dtype=np.int64)
    count = 0
    for h in range(d.size):
        t = mesh.twins[h]
        if h < t and d[h] + d[t] < -(SLACK * (abs(d[h]) + abs(d[t])) + error[h] + error[t]):
            found[count] = h
            count += 1
    return found[:count].copy()


@kernel(forceinline=True)
def is_delaunay(h: int, mesh: HalfEdges, weights: Floats) -> bool:
    """Whether the dihedral angle at the edge of h is convex: the centers lie in order, d + d' >= 0."""
    here, error = tilt(h, mesh, weights)
    there, other_error = tilt(mesh.twins[h], mesh, weights)
    return here + there >= -(SLACK * (abs(here) + abs(there)) + error + other_error)
