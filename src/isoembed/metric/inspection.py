"""Inspection of a metric: measures relevant to its embedding, and warnings."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from isoembed.arrays import Floats
from isoembed.metric.convexity import DEVIATIONS, deficit_spread
from isoembed.metric.curvature import (
    area,
    corner_angles,
    deficits,
    dual_areas,
    face_areas,
    gaussian_curvature,
)
from isoembed.metric.polyhedral import ANGLE_ROUNDING, PolyhedralMetric
from isoembed.metric.vertex_links import link_gaps, without_link
from isoembed.strict_json import plain

NEEDLE = 5.0  # degrees: triangles with a smaller angle are needles
NARROW = 30.0  # degrees: smallest angle for which the paper expects convexity to work
WHERE = {"plane": "in a plane", "heights": "at given heights", "curve": "along a given curve"}
WIDE = 120.0  # degrees: largest angle for which the paper expects convexity to work


@dataclass(frozen=True)
class Measure:
    """Measure of a metric: name, human-readable text, and values for programs."""

    name: str
    text: str
    values: Mapping[str, Any]


@dataclass(frozen=True)
class Caution:
    """Warning: kind, number of occurrences, and text on the worst one and its effect on an embedding."""

    kind: str
    count: int
    text: str


@dataclass(frozen=True)
class Inspection:
    """Measures and warnings of a metric; the string representation has one line for each.

    Attributes
    ----------
    measures : tuple of Measure
    warnings : tuple of Caution
    """

    measures: tuple[Measure, ...]
    warnings: tuple[Caution, ...]

    @property
    def report(self) -> dict[str, Any]:
        """Plain numbers for JSON: one entry per measure, and the warnings; None for nonfinite numbers."""
        document: dict[str, Any] = {
            measure.name.replace(" ", "_"): plain(measure.values) for measure in self.measures
        }
        document["warnings"] = [
            {"kind": warning.kind, "count": warning.count, "message": warning.text}
            for warning in self.warnings
        ]
        return document

    def __str__(self) -> str:
        width = max(len(measure.name) for measure in self.measures)
        lines = [f"{measure.name:{width}}  {measure.text}" for measure in self.measures]
        lines += ["", *(f"warning: {warning.text}" for warning in self.warnings)]
        return "\n".join(lines if self.warnings else [*lines, "None of these rules out an embedding."])


def inspect(metric: PolyhedralMetric) -> Inspection:
    """Measure a metric, and warn of properties that affect its embedding.

    Parameters
    ----------
    metric : PolyhedralMetric

    Returns
    -------
    Inspection

    Examples
    --------
    >>> tetrahedron = PolyhedralMetric([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]], [1.0] * 6)
    >>> inspect(tetrahedron).report["counts"]
    {'vertices': 4, 'edges': 6, 'faces': 4}
    """
    unit = metric.normalized
    angles, epsilon, duals = corner_angles(unit), deficits(unit), dual_areas(unit)
    t = metric.triangulation
    face, corner = np.divmod(t.edge_sides[~t.boundary_edges], 3)
    # Sum of the opposite angles at each edge, minus half that of all: positive if it is not Delaunay.
    excess = np.full(t.n_edges, -np.inf)
    inner = angles[face, (corner + 2) % 3].sum(axis=1) - np.pi
    excess[~t.boundary_edges] = inner - unit.curvature * face_areas(unit)[face].sum(axis=1) / 2
    found = metric, angles, epsilon, duals, excess
    return Inspection(tuple(_measures(*found)), tuple(_warnings(*found)))


def _measures(
    metric: PolyhedralMetric, angles: Floats, epsilon: Floats, duals: Floats, excess: Floats
) -> Iterator[Measure]:
    t, lengths = metric.triangulation, metric.lengths
    with np.errstate(all="ignore"):
        curvature = gaussian_curvature(metric)[(duals > 0) & ~t.boundary_vertices]
        surface = area(metric)
        dual = {key: x * metric.unit * metric.unit for key, x in _range(duals).items()}
    if metric.precision is not None:
        error = metric.precision.length_error
        noise = (
            DEVIATIONS
            * error
            * deficit_spread(metric.faces, metric.face_lengths, t.sides_across, metric.curvature).max()
        )
        text = f"{metric.precision.origin}: that puts deficits off by up to {noise:.1g} radians"
        yield Measure("coordinates", text, {"length_error": error, "deficit_noise": noise})
    if not metric.space.is_euclidean:
        radius = metric.space.radius
        text = f"{metric.space.name}, of curvature {metric.curvature:.6g}, radius of curvature {radius:.6g}"
        yield Measure("space", text, {"curvature": metric.curvature, "radius": radius})
    counts = {"vertices": t.n_vertices, "edges": t.n_edges, "faces": t.n_faces}
    yield Measure("counts", ", ".join(f"{count} {name}" for name, count in counts.items()), counts)
    if not t.is_sphere:
        yield _surface(metric, epsilon)
    degrees = {"min": int(t.degrees.min()), "max": int(t.degrees.max())}
    yield Measure("degrees", f"{degrees['min']} to {degrees['max']} edges at a vertex", degrees)
    mean = metric.mean_length
    text = f"{lengths.min():.6g} to {lengths.max():.6g}, mean {mean:.6g}"
    yield Measure("lengths", text, {**_range(lengths), "mean": mean})
    low, high = np.degrees([angles.min(), angles.max()])
    yield Measure("angles", f"{low:.4g} to {high:.4g} degrees", {"min_degrees": low, "max_degrees": high})
    turns, unit = 2 * t.euler_characteristic, metric.normalized
    gauss_bonnet = float(epsilon.sum() + unit.curvature * unit.area - turns * np.pi)
    whole = f"sum{'' if metric.space.is_euclidean else ' + curvature area'}"
    total = f"{whole} = {f'{turns} pi' if turns else '0'} to {abs(gauss_bonnet):.1e}"
    for name, some in (("deficits", ~t.boundary_vertices), ("exterior angles", t.boundary_vertices)):
        if not some.any():
            continue
        here = epsilon[some]
        negative = int((here < -ANGLE_ROUNDING).sum())
        text = f"{here.min():.4g} to {here.max():.4g} radians, {negative} negative"
        values = {**_range(here), "negative": negative}
        if name == "deficits":
            where = "" if t.is_closed else " with the exterior angles of the boundary"
            text, values = f"{text}, {total}{where}", values | {f"sum_minus_{turns}_pi": gauss_bonnet}
        yield Measure(name, text, values)
    undefined = int((duals <= 0).sum())
    text = f"{dual['min']:.4g} to {dual['max']:.4g}, {undefined} not positive"
    yield Measure("dual areas", text, {**dual, "not_positive": undefined})
    if curvature.size:
        k = _range(curvature)
        yield Measure("gaussian curvature", f"{k['min']:.4g} to {k['max']:.4g}", k)
    violations = int((excess > ANGLE_ROUNDING).sum())
    limit = "180 degrees" if metric.space.is_euclidean else "the other four angles beside them"
    text = f"{violations} edges with opposite angles of more than {limit} together"
    yield Measure("delaunay", text, {"violations": violations})
    yield Measure("area", f"{surface:.12g}", {"total": surface})


def _surface(metric: PolyhedralMetric, epsilon: Floats) -> Measure:
    """Topology of a surface that is not a sphere, its motions, and boundary conditions that may fix these."""
    t = metric.triangulation
    sizes = [len(loop) for loop in t.boundaries]
    free = 3 * t.n_vertices - 6 - t.n_edges
    text = f"genus {t.genus}, {len(sizes)} {'boundary' if len(sizes) == 1 else 'boundaries'}"
    if sizes:
        text += f" of {', '.join(map(str, sizes))} edges"
    fixing = [] if t.is_closed else _conditions(metric, epsilon)
    if free > 0:
        several = "s keep" if free > 1 else " keeps"
        *others, last = (WHERE[name] for name in fixing if name != "free")
        where = f"{', '.join(others)} or {last}" if others else last
        text += f"; {free} motion{several} the lengths: a boundary {where} fixes them, or least bending"
    elif free < 0:
        more = f"{-free} more lengths than unknowns" if free < -1 else "one more length than unknowns"
        text += f"; {more}: they must be those of a surface"
    values = {"genus": t.genus, "boundaries": len(sizes), "free_motions": free, "fixed_by": fixing}
    return Measure("surface", text, values)


def _conditions(metric: PolyhedralMetric, epsilon: Floats) -> list[str]:
    """Boundary conditions suitable for a metric."""
    t = metric.triangulation
    is_cap = t.genus == 0 and len(t.boundaries) == 1 and (epsilon >= -ANGLE_ROUNDING).all()
    is_curved = (epsilon[~t.boundary_vertices] > ANGLE_ROUNDING).all()
    return ["plane"] * bool(is_cap) + ["heights"] * bool(is_cap and is_curved) + ["curve", "free"]


def _range(values: Floats) -> dict[str, float]:
    return {"min": float(values.min()), "max": float(values.max())}


def _warnings(
    metric: PolyhedralMetric, angles: Floats, epsilon: Floats, duals: Floats, excess: Floats
) -> Iterator[Caution]:
    t = metric.triangulation
    smallest, largest = angles.min(axis=1), angles.max(axis=1)
    needle = smallest < np.radians(NEEDLE)
    beyond = (smallest < np.radians(NARROW)) | (largest > np.radians(WIDE))
    inside, gaps = ~t.boundary_vertices, link_gaps(metric)
    found = (
        (
            *("negative_deficits", (epsilon < -ANGLE_ROUNDING) & inside, -epsilon, "negative deficits"),
            lambda v: (
                f"vertex {v} has {epsilon[v]:.4g} rad: the metric is not convex there, Alexandrov's "
                "theorem does not apply, and an embedding, if it exists, need not be unique"
            ),
        ),
        (
            *("exterior_angles", (epsilon < -ANGLE_ROUNDING) & ~inside, -epsilon),
            "negative exterior angles of the boundary",
            lambda v: f"vertex {v} has {epsilon[v]:.4g} rad: the boundary is not convex there",
        ),
        (
            *("flat_vertices", (np.abs(epsilon) <= 1e-6) & inside, -np.abs(epsilon), "flat vertices"),
            lambda v: (
                f"the triangles around vertex {v} lie in one plane when unfolded: it can move off that plane "
                "at second order, so coordinates are only as good as the square root of the length error"
            ),
        ),
        (
            *("impossible_angles", gaps > 0, gaps, "vertices whose angles no surface has"),
            lambda v: without_link(metric, v),
        ),
        (
            *("degree_three", (t.degrees == 3) & inside & (gaps <= 0), epsilon, "vertices of degree 3"),
            lambda v: (
                f"vertex {v} has only 3 edges: it can be mirrored in the plane of its neighbors "
                "without changing a length, so realizations occur in pairs"
            ),
        ),
        (
            *("dual_areas", duals <= 0, -duals, "dual areas that are not positive"),
            lambda v: (
                f"vertex {v}: obtuse triangles make its dual area negative or zero, so that the curvature "
                'k = deficit / dual area is undefined there; of the methods, only "paper" needs it'
            ),
        ),
        (
            *("needles", needle, -smallest, f"triangles with an angle below {NEEDLE:g} degrees"),
            lambda f: (
                f"face {f} {t.faces[f].tolist()} has an angle of {np.degrees(smallest[f]):.2g} degrees: "
                "needle triangles are ill-conditioned and may keep the residual above the rounding "
                "error"
            ),
        ),
        (
            *("angles", beyond & ~needle, largest - smallest),
            f"triangles with angles outside {NARROW:g} to {WIDE:g} degrees",
            lambda f: (
                f"face {f} has angles of {np.degrees(smallest[f]):.3g} to {np.degrees(largest[f]):.3g} "
                "degrees: such triangles make other surfaces with the same lengths more likely"
            ),
        ),
        (
            *("not_delaunay", excess > ANGLE_ROUNDING, excess, "edges that are not Delaunay"),
            lambda e: (
                f"edge {t.edges[e].tolist()}: cotangent weights are negative there, and a convex "
                "surface has a concave edge in such triangles more often than in Delaunay ones"
            ),
        ),
    )
    for kind, where, severity, noun, text in found:
        if where.any():
            worst = int(np.argmax(np.where(where, severity, -np.inf)))
            yield Caution(kind, int(where.sum()), f"{noun}: {where.sum()}; the worst: {text(worst)}")
    ratio = float(metric.lengths.max() / metric.lengths.min())
    if ratio > 1000.0:  # edges so uneven get a warning
        yield Caution(
            "length_ratio",
            1,
            f"the longest edge is {ratio:.3g} times the shortest: the residual is measured in mean "
            "edge lengths, so the relative errors of short edges are larger",
        )
