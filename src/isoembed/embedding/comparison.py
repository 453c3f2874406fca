"""`isoembed.compare`: congruence, distance and curvature differences of surfaces on one triangulation.

If both are proven to be near exact surfaces of the same lengths, within D_a at vertex a, the comparison holds
for these, with proven errors.  Quantities that depend on a motion of one of them use the best motion in least
squares.  With p and q the vertices of both about their means, after such a motion of the floats, and

    tau = sum of q_a x p_a,    m = the least eigenvalue of sum of (p_a . q_a) 1 - sym(p_a q_a^T),

the angle of the best rotation for p and q is at most ``atan2(|tau|, m)``: a rotation by phi about a unit
vector u increases the sum of ``p_a . q_a`` by ``sin(phi) u . tau``, and decreases it by ``1 - cos(phi)``
times the sum of ``p_a . q_a - (u . p_a)(u . q_a)``.  The changes of tau and m for the exact vertices are
bounded by D.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from isoembed.arrays import Floats
from isoembed.embedding.embedding import Embedding, checked_embedding
from isoembed.embedding.sensitivity import Sensitivity
from isoembed.errors import InvalidParameter
from isoembed.mesh.triangulation import Triangulation
from isoembed.proof.deviation_bound import DeviationBound
from isoembed.proof.rounding import GUARD, gamma
from isoembed.reprs import short_repr
from isoembed.surface.alignment import aligned, aligned_image
from isoembed.surface.changes import Changes
from isoembed.surface.curvature import (
    ROUNDING,
    dihedral_angles,
    integrated_mean_curvature,
    turning_errors,
    vertex_mean_curvature,
)
from isoembed.surface.estimate import Estimate
from isoembed.surface.measures import area, face_normals, volume


@short_repr
@dataclass(frozen=True, eq=False)
class Comparison:
    """Differences of a second surface from a first one with the same triangles.

    Attributes
    ----------
    difference : Changes
        Dihedral angles, H, area, volume and int H dA of the second minus those of the first.  For vertices
        and normals, distances and angles after the best rigid motion of the second in least squares.  The
        volume of surfaces with boundary is NaN.
    error : Changes
        Proven bounds on the error of `difference` for the exact surfaces; infinite if not `certified`.
    distance, distance_error : float
        Largest distance of corresponding vertices and its proven error bound, in mean edge lengths.
    certified : bool
        Whether both are proven to be near exact surfaces with the same lengths.
    same : bool or None
        Whether the exact surfaces are proven to be identical (True) or different (False); None if undecided.
    isolation : float or None
        Lower bound on the distance of the exact surfaces if they differ: the larger isolation of both.
    fine_roughness : tuple of float
        `Surface.fine_roughness` of the first and of the second: smaller for the smoother one.
    reason : str
        Statement proven, or reason why nothing is.
    """

    difference: Changes
    error: Changes
    distance: float
    distance_error: float
    certified: bool
    same: bool | None
    isolation: float | None
    fine_roughness: tuple[float, float]
    reason: str

    @property
    def report(self) -> dict[str, Any]:
        """Report of all fields, with root mean square and maximum of arrays."""
        return {
            "certified": self.certified,
            "reason": self.reason,
            "same": self.same,
            "distance": self.distance,
            "distance_error": self.distance_error,
            "isolation": self.isolation,
            "fine_roughness": list(self.fine_roughness),
            "difference": self.difference.report,
            "error": self.error.report,
        }


def compare(first: Embedding, second: Embedding) -> Comparison:
    """Compare two surfaces in R^3 with the same triangles.

    If both have the same lengths and a certificate (`certify`), the exact surfaces are compared, with proven
    error bounds.  This takes three additional factorizations for each.  As an `Embedding` is mirrored if its
    volume is negative, mirror images are identical.  For surfaces with boundary, the second is mirrored if
    this brings it nearer.  Nothing is proven for surfaces with boundary or handles.

    Parameters
    ----------
    first, second : Embedding
        Surfaces with the same triangles, such as an embedding and one of its `others`.

    Raises
    ------
    InvalidParameter
        An argument is not an embedding, the triangles differ, or space is curved.
    """
    checked_embedding(first)
    if isinstance(second, np.ndarray):
        raise InvalidParameter(
            "the second surface is an array, not an embedding: embedding.distance(vertices) compares with "
            "vertices alone"
        )
    checked_embedding(second)
    for each in (first, second):
        if not each.space.is_euclidean:
            raise InvalidParameter(f"comparisons need surfaces in R^3, not in {each.space!r}")
    if not np.array_equal(first.faces, second.faces):
        raise InvalidParameter("the surfaces do not have the same triangles in the same order")
    t, unit, mean_length = first.triangulation, first.metric.unit, first.metric.normalized.mean_length
    if not t.is_closed:
        x, own = first.vertices / first.metric.unit, second.vertices / first.metric.unit
        second = replace(second, vertices=first.metric.unit * aligned_image(own, x))
    obstacle = _obstacle(first, second)
    one, other = (
        DeviationBound.unproven(t, obstacle) if obstacle else Sensitivity(each).deviation_bound(0.0)
        for each in (first, second)
    )
    x, own = first.vertices / unit, second.vertices / unit
    y = aligned(own, x)
    rounding = ROUNDING * float(max(np.abs(x).max(), np.abs(own).max()))  # error of y as a rigid image
    turned, moved = _misaligned(x, y, one.vertices / unit, other.vertices / unit + rounding)
    rotated = turned + turning_errors(t, x) + turning_errors(t, y)
    difference = differences(t, x, own)
    if not obstacle:
        difference = replace(difference, area=0.0)  # determined by the lengths
    error = Changes(
        vertices=unit * moved,
        normals=one.normals + other.normals + rotated,
        dihedral_angles=one.dihedral_angles + other.dihedral_angles,
        mean_curvature=one.mean_curvature + other.mean_curvature,
        area=np.inf if obstacle else 0.0,
        volume=one.volume + other.volume,
        integrated_mean_curvature=one.integrated_mean_curvature + other.integrated_mean_curvature,
    )
    distance, uncertain = (
        float(difference.vertices.max()) / mean_length,
        GUARD * float(moved.max()) / mean_length,
    )
    isolation = None if obstacle else max(_isolation(first), _isolation(second))
    same = None if isolation is None else _same(first, distance, uncertain, isolation)
    rough = first.surface.fine_roughness, second.surface.fine_roughness
    difference = difference.scaled(unit)
    if not t.is_sphere:
        difference = replace(
            difference,
            mean_curvature=second.mean_curvature - first.mean_curvature,
            volume=difference.volume if t.is_closed else np.nan,
            integrated_mean_curvature=second.integrated_mean_curvature - first.integrated_mean_curvature,
        )
    bounds = [
        float(np.max(np.abs(getattr(difference, name)) + getattr(error, name)))
        for name in ("dihedral_angles", "integrated_mean_curvature")
    ]
    return Comparison(
        difference=difference,
        error=error,
        distance=distance,
        distance_error=uncertain,
        certified=not obstacle,
        same=same,
        isolation=isolation,
        fine_roughness=rough,
        reason=_sentence(obstacle, same, f"{stated(distance, uncertain)} mean edge lengths apart", bounds)
        + ("" if same else _smoother(*rough)),
    )


def stated(value: float, error: float) -> str:
    """Number with its proven error bound, to significant digits; the number alone if there is no bound."""
    if not np.isfinite(error):
        return f"{value:.6g}"
    # Two digits of the error may be 5 % low, and the number is rounded: the printed bound must hold, too.
    printed = Estimate(value, error).rounded
    return f"{printed} +- {1.06 * (error + abs(float(printed) - value)):.1e}"


def differences(triangulation: Triangulation, x: Floats, y: Floats) -> Changes:
    """Return the `Comparison.difference` of surfaces in R^3 with vertices x and y, each (V, 3)."""
    t, moved = triangulation, aligned(y, x)
    return Changes(
        vertices=np.linalg.norm(moved - x, axis=1),
        normals=_angles(face_normals(t.faces, x), face_normals(t.faces, moved)),
        dihedral_angles=dihedral_angles(t, y) - dihedral_angles(t, x),
        mean_curvature=vertex_mean_curvature(t, y) - vertex_mean_curvature(t, x),
        area=area(t.faces, y) - area(t.faces, x),
        volume=volume(t.faces, y) - volume(t.faces, x),
        integrated_mean_curvature=integrated_mean_curvature(t, y) - integrated_mean_curvature(t, x),
    )


def _obstacle(first: Embedding, second: Embedding) -> str:
    """Reason why nothing is proven for two surfaces; empty if there is none."""
    if not first.triangulation.is_sphere:
        kind = "with handles" if first.triangulation.is_closed else "with boundary"
        return f"no proof is made for surfaces {kind}"
    lengths, others = first.metric.lengths, second.metric.lengths
    if not np.array_equal(lengths, others):
        e = int(np.argmax(lengths != others))
        return (
            f"edge {e} {first.metric.edges[e].tolist()} has the length {lengths[e]} in the metric of the "
            f"first and {others[e]} in that of the second"
        )
    for name, each in (("first", first), ("second", second)):
        if not each._certificate.certified:
            return f"the {name} is {each._certificate.reason}"
    return ""


def _isolation(surface: Embedding) -> float:
    return surface._certificate.isolation or 0.0


def _same(first: Embedding, distance: float, error: float, isolation: float) -> bool | None:
    """Whether exact surfaces at this distance are proven to be identical or different; None if undecided."""
    if distance > error:
        return False
    # Isolation refers to weighted least squares, which may increase vertex distances by at most this factor.
    lengths = first.metric.normalized.lengths
    squares = np.bincount(first.metric.edges.ravel(), np.repeat(lengths**-2.0, 2))
    factor = GUARD * float(np.sqrt(squares.sum() / squares.min()))
    return True if factor * (distance + error) < isolation else None


def _smoother(first: float, second: float) -> str:
    if abs(first - second) <= 1e-6 * max(first, second):  # above the rounding errors of equal surfaces
        return "; both are equally smooth"
    return f"; the {'second' if second < first else 'first'} is the smoother"


def _sentence(obstacle: str, same: bool | None, apart: str, bounds: list[float]) -> str:
    if obstacle:
        return f"{apart}, but not proven to be near exact surfaces with the same lengths, because {obstacle}"
    if same:
        return "proven to be the same exact surface"
    relation = "two exact surfaces with these lengths" if same is False else "exact surfaces, one or two"
    angle, integral = (f"{1.005 * bound:.3g}" for bound in bounds)  # not rounded down
    return (
        f"proven to be {relation}, {apart}, whose dihedral angles differ by at most {angle} radians, and "
        f"int H dA by at most {integral}"
    )


def _misaligned(x: Floats, y: Floats, first: Floats, second: Floats) -> tuple[float, Floats]:
    """Distance from the identity of the best motion of y in least squares, for exact vertices.

    Parameters
    ----------
    x, y : ndarray, shape (V, 3)
    first, second : ndarray, shape (V,)
        Bounds on the distances of the exact vertices from these.

    Returns
    -------
    turned : float
        Bound on its rotation angle.
    moved : ndarray, shape (V,)
        Bounds on the differences between the distances of exact vertices and those of x and y.
    """
    rounding = gamma(len(x) + 16)
    mean = 4 * rounding * float(max(np.abs(x).max(), np.abs(y).max()))  # error bound of the means
    p, q = x - x.mean(axis=0), y - y.mean(axis=0)
    size_p, size_q = (np.linalg.norm(z, axis=1) + mean for z in (p, q))
    off_p, off_q = (off + off.mean() + mean for off in (first, second))
    change = float((size_p * off_q + size_q * off_p + off_p * off_q + rounding * size_p * size_q).sum())
    torque = float(np.linalg.norm(np.cross(q, p).sum(axis=0))) + 2 * change
    products = q.T @ p
    sums = np.trace(products) * np.eye(3) - (products + products.T) / 2
    lower = float(np.linalg.eigvalsh(sums)[0]) - 2 * change
    turned = GUARD * float(np.arctan2(torque, lower)) if lower > 0 else np.pi
    shift = float(np.linalg.norm(x.mean(axis=0) - y.mean(axis=0))) + 2 * mean + first.mean() + second.mean()
    return turned, GUARD * (first + second + shift + turned * (size_q + off_q))


def _angles(normals: Floats, others: Floats) -> Floats:
    """Angles between vectors, (F,)."""
    across = np.linalg.norm(np.cross(normals, others), axis=1)
    return np.arctan2(across, np.einsum("ij,ij->i", normals, others))
