"""Convexity check of a metric: nonnegative angle deficits, up to rounding or an estimated noise level."""

from functools import reduce
from typing import cast

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.errors import InvalidMetric
from isoembed.metric.triangle_metric import TriangleMetric
from isoembed.metric.triangles import Triangles
from isoembed.reprs import rounded_up

ROUNDINGS = 64  # error of a length from preceding computations, in machine epsilons
MIN_NOISE = 1e-12  # radians: rounding by flips may exceed the estimate from the triangles
MAX_NOISE = 1e-6  # radians: upper limit for slivers
HARDLY_NOISE = 0.1  # radians: more negative deficits are unlikely to be noise
DEVIATIONS = 6.0  # bound on errors of coordinates, in standard deviations
GAP = 30.0  # deficits larger than the noise by this factor are significant


def deficit_rounding(metric: TriangleMetric) -> Floats:
    """Bounds on the effect of rounded lengths on the deficits, shape (V,), radians.

    With longest side l, a change dl of one side of a triangle changes its angles by at most ``l dl / (2 A)``;
    on the sphere and in the hyperbolic plane by ``sn l dl`` over the amplitude.
    """
    triangles = metric.triangles
    # Columns are compared five times faster than rows of three.
    longest, sine = (reduce(np.maximum, sides.T) for sides in (triangles.opposite, triangles.sines))
    slenderness = longest * sine / triangles.amplitudes
    at_corners = np.repeat(ROUNDINGS * np.finfo(np.float64).eps * slenderness, 3)
    return np.clip(cast(Floats, np.bincount(metric.faces.ravel(), at_corners)), MIN_NOISE, MAX_NOISE)


def deficit_spread(faces: Indices, face_lengths: Floats, twins: Indices, curvature: float = 0.0) -> Floats:
    """Effect of errors of the lengths on the deficits, shape (V,), radians.

    First-order standard deviations for independent errors of one mean edge length, to be scaled for smaller
    ones.  Errors due to rounded coordinates are correlated and have a smaller effect on most deficits.

    Parameters
    ----------
    faces : ndarray of int, shape (F, 3)
    face_lengths : ndarray, shape (F, 3)
        Length of each half-edge.
    twins : ndarray of int, shape (3F,)
        Twin of each half-edge, -1 on a boundary.
    curvature : float
        Gaussian curvature of the triangles.
    """
    triangles = Triangles.of(face_lengths, curvature)
    lengths, sines = np.roll(triangles.opposite, 1, axis=1), np.roll(triangles.sines, 1, axis=1)
    cotangents = triangles.cotangents
    # The angle between b and c, opposite to a, grows by da a / (2 A) - db cot(a, b) / b - dc cot(a, c) / c,
    # with sines of the sides instead of the sides, and the amplitude instead of 2 A.
    across = triangles.sines / triangles.amplitudes[:, None]
    at_start, at_end = np.roll(cotangents, -1, axis=1) / sines, cotangents / sines
    bounded = twins < 0
    along = at_start.ravel() + np.where(bounded, 0.0, at_end.ravel()[twins])
    squares = np.bincount(faces.ravel(), across.ravel() ** 2 + along**2)
    ends, alone = np.roll(faces, -1, axis=1).ravel()[bounded], at_end.ravel()[bounded]
    squares += np.bincount(ends, alone**2, minlength=len(squares))
    return cast(Floats, np.sqrt(squares) * np.average(lengths.ravel(), weights=1 + bounded))


def check_convex(deficits: Floats, rounding: Floats | float, doubt: tuple[str, Floats] | None = None) -> None:
    """Refuse a metric with a negative deficit, to which Alexandrov's theorem does not apply.

    Parameters
    ----------
    deficits : ndarray, shape (V,)
    rounding : ndarray, shape (V,), or float
        Tolerance of negative deficits, in radians.
    doubt : str and ndarray, shape (V,), optional
        Precision of rounded coordinates, and its root mean square effect on the deficits; the message states
        whether it explains negative ones.

    Raises
    ------
    InvalidMetric
        A deficit is negative; the message names the vertex with the most negative one.
    """
    negative = deficits < -rounding
    if negative.any():
        v = int(np.argmin(np.where(negative, deficits, 0.0)))
        others = int(negative.sum()) - 1
        raise InvalidMetric(
            f"vertex {v} has total angle {2 * np.pi - deficits[v]:.10g} > 2 pi (deficit {deficits[v]:.3g})"
            + (
                f", and {others} other {'vertices have' if others > 1 else 'vertex has'} more than 2 pi"
                if others
                else ""
            )
            + ": the metric is not convex, and no convex polyhedron has it"
            + _explanation(deficits, doubt)
        )


def largest_noise(deficits: Floats) -> float:
    """Largest deficit, in radians, attributable to noise, estimated from the most negative one.

    Errors of lengths move curvature between neighbors, causing deficits of both signs at flat vertices.  In
    uniform Gaussian noise the largest of a thousand deficits is seldom twice the size of the most negative;
    vertices of slender triangles have larger errors: hence a factor of 10.
    """
    return 10.0 * max(-float(deficits.min()), 0.0)


def noise_level(deficits: Floats) -> float:
    """Noise level of the deficits, estimated from the deficits alone.

    Parameters
    ----------
    deficits : ndarray, shape (V,)

    Returns
    -------
    float
        Radians.  The absolute deficit below the widest relative gap in their sorted values, if it may be
        noise by `largest_noise`; if there is no gap, that of the most negative one, or 0 if none is negative.
    """
    lowest, upper = max(-float(deficits.min()), 0.0), largest_noise(deficits)
    sizes = np.sort(np.abs(deficits[np.abs(deficits) > MIN_NOISE]))
    below = sizes[:-1]
    gaps = np.where((below >= lowest) & (below <= min(upper, HARDLY_NOISE)), sizes[1:] / below, 0.0)
    if gaps.max(initial=0.0) < GAP:
        return lowest
    return float(below[np.argmax(gaps)])


def repair_level(deficits: Floats, lower: Floats | float) -> float | None:
    """Noise, in radians, that a repair may remove if no polyhedron was found; None if there is none.

    Parameters
    ----------
    deficits : ndarray, shape (V,)
    lower : ndarray, shape (V,), or float
        Smaller deficits were already treated as zero.
    """
    level = noise_level(deficits)
    small = (np.abs(deficits) > lower) & (np.abs(deficits) <= level)
    return float(rounded_up(level)) if small.any() and level <= HARDLY_NOISE else None


def _explanation(deficits: Floats, doubt: tuple[str, Floats] | None) -> str:
    """Clause stating whether the precision of the coordinates explains negative deficits."""
    if doubt is None:
        return ""
    name, spread = doubt
    bounds = DEVIATIONS * spread
    explained = f"{bounds[np.argmin(deficits)]:.1g}"
    if (deficits >= -bounds).all():
        return f"; the coordinates have {name}, which puts deficits off by up to {explained}"
    return f"; the coordinates have {name}, which explains only {explained}"
