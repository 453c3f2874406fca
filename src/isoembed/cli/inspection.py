"""The measures of a metric that matter to its embedding, and the warnings that follow from them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from isoembed.metric.curvature import (
    ROUNDING,
    area,
    corner_angles,
    deficits,
    dual_areas,
    gaussian_curvature,
)
from isoembed.metric.polyhedral import PolyhedralMetric

Floats = NDArray[np.float64]

FLAT = 1e-6  # radians: a deficit below this bends the surface less than the square root of rounding
NEEDLE = np.radians(5.0)
GOOD_ANGLES = np.radians([30.0, 120.0])  # within which the paper expects its convexity routine to work
STEEP = 1000.0  # longest over shortest edge


@dataclass(frozen=True)
class Measure:
    """One line: a name, a sentence for the eye, and values for programs."""

    name: str
    text: str
    values: dict[str, float | int]


@dataclass(frozen=True)
class Caution:
    """Something that an embedding will feel: how often, where first, and what it means."""

    kind: str
    count: int
    text: str


@dataclass(frozen=True)
class Inspection:
    """All measures and warnings of a metric."""

    measures: tuple[Measure, ...]
    warnings: tuple[Caution, ...]

    def as_json(self) -> dict[str, Any]:
        """One object with an entry a measure, and the list of warnings; what is not finite is null."""
        document: dict[str, Any] = {
            measure.name.replace(" ", "_"): {key: _finite(x) for key, x in measure.values.items()}
            for measure in self.measures
        }
        document["warnings"] = [
            {"kind": warning.kind, "count": warning.count, "message": warning.text}
            for warning in self.warnings
        ]
        return document


def inspect(metric: PolyhedralMetric) -> Inspection:
    """Measure a metric.

    Parameters
    ----------
    metric : PolyhedralMetric

    Returns
    -------
    Inspection
    """
    unit = metric.normalized
    angles, epsilon, duals = corner_angles(unit), deficits(unit), dual_areas(unit)
    excess = delaunay_excess(metric, angles)
    return Inspection(
        _measures(metric, angles, epsilon, duals, excess), _warnings(metric, angles, epsilon, duals, excess)
    )


def delaunay_excess(metric: PolyhedralMetric, angles: Floats) -> Floats:
    """Angles across each edge, their sum minus pi, shape (E,): positive where the edge is not Delaunay."""
    face, corner = np.divmod(metric.triangulation.edge_halfedges, 3)
    return angles[face, (corner + 2) % 3].sum(axis=1) - np.pi


def _measures(
    metric: PolyhedralMetric, angles: Floats, epsilon: Floats, duals: Floats, excess: Floats
) -> tuple[Measure, ...]:
    t = metric.triangulation
    lengths, degrees = metric.lengths, t.degrees
    with np.errstate(all="ignore"):
        curvature = gaussian_curvature(metric)[duals > 0]
        surface = area(metric)
        smallest_dual, largest_dual = (
            float(x) * metric.unit * metric.unit for x in (duals.min(), duals.max())
        )
    low, high = np.degrees([angles.min(), angles.max()])
    negative = int((epsilon < -ROUNDING).sum())
    gauss_bonnet = float(epsilon.sum() - 4 * np.pi)
    not_delaunay, without_dual = int((excess > ROUNDING).sum()), int((duals <= 0).sum())
    # Dual areas sum to the area, so some are positive.
    k_low, k_high = float(curvature.min()), float(curvature.max())
    return (
        Measure(
            "counts",
            f"{t.n_vertices} vertices, {t.n_edges} edges, {t.n_faces} faces",
            {"vertices": t.n_vertices, "edges": t.n_edges, "faces": t.n_faces},
        ),
        Measure(
            "degrees",
            f"{degrees.min()} to {degrees.max()} edges at a vertex",
            {"min": int(degrees.min()), "max": int(degrees.max())},
        ),
        Measure(
            "lengths",
            f"{lengths.min():.6g} to {lengths.max():.6g}, mean {metric.mean_length:.6g}",
            {"min": float(lengths.min()), "max": float(lengths.max()), "mean": metric.mean_length},
        ),
        Measure("angles", f"{low:.4g} to {high:.4g} degrees", {"min_degrees": low, "max_degrees": high}),
        Measure(
            "deficits",
            f"{epsilon.min():.4g} to {epsilon.max():.4g} radians, {negative} negative, "
            f"sum - 4 pi = {gauss_bonnet:.1e}",
            {
                "min": float(epsilon.min()),
                "max": float(epsilon.max()),
                "negative": negative,
                "sum_minus_4_pi": gauss_bonnet,
            },
        ),
        Measure(
            "dual areas",
            f"{smallest_dual:.4g} to {largest_dual:.4g}, {without_dual} not positive",
            {"min": smallest_dual, "max": largest_dual, "not_positive": without_dual},
        ),
        Measure("gaussian curvature", f"{k_low:.4g} to {k_high:.4g}", {"min": k_low, "max": k_high}),
        Measure(
            "delaunay",
            f"{not_delaunay} edges with opposite angles of more than 180 degrees together",
            {"violations": not_delaunay},
        ),
        Measure("area", f"{surface:.12g}", {"total": surface}),
    )


def _warnings(
    metric: PolyhedralMetric, angles: Floats, epsilon: Floats, duals: Floats, excess: Floats
) -> tuple[Caution, ...]:
    t = metric.triangulation
    narrow, corner_low = angles.min(axis=1) < NEEDLE, angles.min(axis=1) < GOOD_ANGLES[0]
    corner_high = angles.max(axis=1) > GOOD_ANGLES[1]
    ratio = float(metric.lengths.max() / metric.lengths.min())
    found = (
        (
            "negative_deficits",
            epsilon < -ROUNDING,
            lambda v: (
                f"vertex {v} has {epsilon[v]:.4g} rad: the metric is not convex there, Alexandrov's theorem "
                "does not apply, and an embedding, if there is one, need not be the only one"
            ),
            "negative deficits",
        ),
        (
            "flat_vertices",
            np.abs(epsilon) <= FLAT,
            lambda v: (
                f"vertex {v} has deficit {epsilon[v]:.1e}: a flat vertex can move off its plane at "
                "second order, so coordinates are only as good as the square root of the length error"
            ),
            "flat vertices",
        ),
        (
            "degree_three",
            t.degrees == 3,
            lambda v: (
                f"vertex {v} has only 3 edges: it can be mirrored in the plane of its neighbors without "
                "changing a length, so there are two embeddings for each"
            ),
            "vertices of degree 3",
        ),
        (
            "dual_areas",
            duals <= 0,
            lambda v: (
                f"vertex {v}: the curvature k = deficit / dual area is undefined there, and methods that "
                "flow by it (--method paper) may fail"
            ),
            "dual areas that are not positive",
        ),
        (
            "needles",
            narrow,
            lambda f: (
                f"face {f} {t.faces[f].tolist()} has an angle of {np.degrees(angles[f].min()):.2g} degrees: "
                "needles are badly conditioned and may keep the residual from falling to rounding"
            ),
            "triangles with an angle below 5 degrees",
        ),
        (
            "angles",
            (corner_low | corner_high) & ~narrow,
            lambda f: (
                f"face {f} has {np.degrees(angles[f].min()):.3g} to {np.degrees(angles[f].max()):.3g} "
                "degrees: the paper's triangulations keep within, and other realizations are likelier"
            ),
            "triangles with angles outside 30 to 120 degrees",
        ),
        (
            "not_delaunay",
            excess > ROUNDING,
            lambda e: (
                f"edge {t.edges[e].tolist()}: cotangent weights are negative there, and a convex surface "
                "has a concave edge in such triangles more often than in Delaunay ones"
            ),
            "edges that are not Delaunay",
        ),
    )
    warnings = [
        Caution(kind, int(where.sum()), f"{where.sum()} {what}; the first: {text(int(np.argmax(where)))}")
        for kind, where, text, what in found
        if where.any()
    ]
    if ratio > STEEP:
        warnings.append(
            Caution(
                "length_ratio",
                1,
                f"the longest edge is {ratio:.3g} times the shortest: the residual is measured in mean edge "
                "lengths, so short edges are held less exactly relative to themselves",
            )
        )
    return tuple(warnings)


def _finite(value: float | int) -> float | int | None:
    return value if isinstance(value, int) or math.isfinite(value) else None
