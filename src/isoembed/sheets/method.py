"""The method for surfaces with boundary or of higher genus: starts, ranking of the solutions, uniqueness."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar, cast

import numpy as np
from numpy.typing import ArrayLike

from isoembed.aim.adaptive import Aim
from isoembed.aim.measured_lengths import with_errors_of_digits, within_digits
from isoembed.alexandrov.method import convex_polyhedron
from isoembed.arrays import Floats
from isoembed.errors import InvalidMetric, InvalidParameter, NotEmbedded
from isoembed.evidence import Evidence
from isoembed.mesh.checks import real_array
from isoembed.mesh.triangulation import frozen
from isoembed.method import Method
from isoembed.metric.convexity import largest_noise
from isoembed.metric.curvature import deficits
from isoembed.metric.polyhedral import ANGLE_ROUNDING, PolyhedralMetric
from isoembed.progress.stages import Log, StageRecorder
from isoembed.sheets.bending import BendingEnergy
from isoembed.sheets.boundary_curve import through_curve
from isoembed.sheets.buckling import buckled
from isoembed.sheets.convex_cap import check_cap, doubled, upright, with_heights
from isoembed.sheets.hole_filling import filled
from isoembed.sheets.least_bending import (
    STIFFNESSES,
    THINNER,
    LeastBending,
    balanced,
    most_promising,
    thinned,
)
from isoembed.sheets.length_constraints import LengthConstraints
from isoembed.sheets.measured_cap import explained_angles, measured_cap
from isoembed.sheets.multidimensional_scaling import scaled_distances
from isoembed.sheets.newton_on_lengths import nearest_with_lengths
from isoembed.sheets.surface import BALANCED, SheetEmbedding
from isoembed.surface.alignment import aligned, aligned_image
from isoembed.surface.measures import face_areas
from isoembed.surface.placement import standard_sheet, turned_about_vertical

CONDITIONS = "free", "plane"
EXACT = 1e-12  # residual of least bending, in mean edge lengths, that needs no refinement
FLAT = 1e-15  # area over squared size of the start below which a triangle has no area
SAME = 1e-6  # relative difference of energies below which surfaces are identical or mirror images
STALLED = 1.01  # factor of the energy of an unbalanced surface in comparisons
NOISE = 0.05  # mean edge lengths by which a measured boundary may deviate from the lengths
CAP = Evidence(
    "proved",
    "convex cap theorem: the deficits and the exterior angles of the boundary are not negative, and a convex "
    "cap is determined by its metric",
)


@dataclass(frozen=True)
class Sheet(Method):
    """Realization of a surface with boundary, or of higher genus, in R^3.

    Parameters
    ----------
    boundary : {"free", "plane"} or array_like
        ``"free"``: a surface of least bending energy among those with the lengths, the limit of thin elastic
        sheets.  ``"plane"``: the convex cap, with its boundary in a plane; the metric must be convex.  If
        the metric has `length_errors`, a smooth cap that agrees with the lengths within these.  An
        array (B,) of heights of the boundary's vertices over a plane, for positive curvature; or an
        array (B, 3) of their positions, for any curvature.  Vertices of the boundary are in the order of
        `Triangulation.boundaries`, one boundary after the other.
    start : array_like, shape (V, 3), optional
        Initial surface, in the unit of the lengths; by default the convex cap, a closed surface with filled
        holes, or multidimensional scaling.
    """

    boundary: Any = "free"
    start: Any = None

    name: ClassVar[str] = "sheet"
    takes_boundary: ClassVar[bool] = True

    @property
    def takes_length_errors(self) -> bool:  # type: ignore[override]
        """Whether lengths with errors can be fitted, as for caps."""
        return bool(self.boundary == "plane")

    def __post_init__(self) -> None:
        if isinstance(self.boundary, str):
            if self.boundary not in CONDITIONS:
                raise InvalidParameter(
                    f"the boundary is {self.boundary!r}, none of {', '.join(map(repr, CONDITIONS))}, "
                    "heights (B,) or positions (B, 3)"
                )
        else:
            object.__setattr__(self, "boundary", _nested(self.boundary, "boundary"))
        if self.start is not None:
            object.__setattr__(self, "start", _nested(self.start, "start"))

    def run(self, metric: PolyhedralMetric, tolerance: float, log: Log) -> SheetEmbedding:
        """Embed a metric; see `isoembed.Method`.

        Raises
        ------
        InvalidMetric
            The curvature is not suitable for the boundary condition.
        InvalidParameter
            The boundary or the start does not fit the metric.
        """
        found = self._found(metric, tolerance, log)
        if found.converged or self.start is None:
            return found
        return found._with_message(f"{found.message}; without start= others are tried")

    def scaled(self, factor: float) -> Sheet:
        """See `isoembed.Method`."""
        arrays = {
            name: factor * np.array(value)
            for name, value in (("boundary", self.boundary), ("start", self.start))
            if value is not None and not isinstance(value, str)
        }
        return replace(self, **arrays)

    def _found(self, metric: PolyhedralMetric, tolerance: float, log: Log) -> SheetEmbedding:
        if not metric.space.is_euclidean:
            raise InvalidParameter("surfaces with boundary are embedded in R^3, with flat triangles")
        start = None if self.start is None else np.array(self.start)
        if start is not None and start.shape != (metric.triangulation.n_vertices, 3):
            raise InvalidParameter(
                f"the start has the shape {start.shape}, not ({metric.triangulation.n_vertices}, 3)"
            )
        if start is not None:
            flat = face_areas(metric.faces, start) <= FLAT * np.abs(start).max() ** 2
            if flat.any():
                f = int(np.argmax(flat))
                raise InvalidParameter(f"face {f} {metric.faces[f].tolist()} has no area in the start")
        if isinstance(self.boundary, str):
            named = _cap if self.boundary == "plane" else _least_bending
            return named(metric, start, tolerance, log)
        prescribed = np.array(self.boundary)
        count = int(metric.triangulation.boundary_vertices.sum())
        if not count:
            raise InvalidParameter("the metric has no boundary: take boundary='free'")
        if prescribed.shape not in ((count,), (count, 3)):
            raise InvalidParameter(
                f"the boundary has the shape {prescribed.shape}: the metric has {count} vertices there, "
                f"so it must be ({count},) or ({count}, 3)"
            )
        solve = _over_heights if prescribed.ndim == 1 else _through
        return solve(metric, prescribed, start, tolerance, log)


def _cap(metric: PolyhedralMetric, start: Floats | None, tolerance: float, log: Log) -> SheetEmbedding:
    """Convex cap."""
    if start is not None:
        raise InvalidParameter("boundary='plane' takes no start: the convex cap is unique")
    if metric.length_errors is not None:
        return measured_cap(metric, Sheet.name, tolerance, log)
    heights = np.zeros(int(metric.triangulation.boundary_vertices.sum()))
    try:
        check_cap(metric, tolerance)
        found = _raised(metric, heights, tolerance, log, "plane")
        if not found.converged:
            check_cap(metric)
    except InvalidMetric as error:
        if metric.rounding is None or metric.triangulation.is_closed:
            raise
        measured = with_errors_of_digits(metric)
        if (deficits(measured) < -explained_angles(measured)).any():
            raise InvalidMetric(f"{error}; with length_errors=E a smooth cap is fitted") from None
        return measured_cap(measured, Sheet.name, tolerance, log)
    concave = int(found.surface.concave_edges.sum())
    rough = concave or found.surface.rough_edges.any() or not found.converged
    if rough and metric.rounding is not None:
        smooth = measured_cap(with_errors_of_digits(metric), Sheet.name, tolerance, log)
        return cast(SheetEmbedding, within_digits(found, smooth))
    if found.converged and not concave:
        return found._with(uniqueness=CAP)
    if not concave:
        return found
    return found._with_message(
        f"{concave} edge{'s are' if concave > 1 else ' is'} concave: on these triangles it is not the "
        "convex cap, and other surfaces with a planar boundary may have the same lengths"
    )


def _over_heights(
    metric: PolyhedralMetric, heights: Floats, start: Floats | None, tolerance: float, log: Log
) -> SheetEmbedding:
    """Surface with given heights of the boundary, by continuation from the convex cap."""
    if start is not None:
        raise InvalidParameter(
            "solutions for boundary heights are continued from the convex cap: they take no start"
        )
    inside = ~metric.triangulation.boundary_vertices
    curved = deficits(metric)
    if (curved[inside] <= ANGLE_ROUNDING).any():
        v = int(np.argmax(inside & (curved <= ANGLE_ROUNDING)))
        raise InvalidMetric(
            f"vertex {v} has the deficit {curved[v]:.4g}: with heights of the boundary the problem is ill "
            "posed where the curvature is not positive; give positions (B, 3)"
        )
    check_cap(metric, tolerance)
    t = metric.triangulation
    z = np.zeros(t.n_vertices)
    z[t.boundaries[0]] = heights
    a, b = t.edges.T
    between = t.boundary_vertices[a] & t.boundary_vertices[b]
    steep = np.where(between, np.abs(z[a] - z[b]) / metric.lengths, 0.0)
    if steep.max() > 1 + tolerance:
        e = int(np.argmax(steep > 1 + tolerance))
        raise InvalidParameter(
            f"the heights at the ends of edge {e} {t.edges[e].tolist()} differ by {steep[e]:.4g} times its "
            "length: no surface has both; are they in the order of Triangulation.boundaries?"
        )
    found = _raised(metric, heights, tolerance, log, "heights")
    if found.converged:
        return found
    check_cap(metric)
    return found._with_message(f"{found.message}; are the heights in the order of Triangulation.boundaries?")


def _raised(
    metric: PolyhedralMetric, heights: Floats, tolerance: float, log: Log, condition: str
) -> SheetEmbedding:
    [loop] = metric.triangulation.boundaries
    level = heights.mean()
    rise = heights - level
    double = doubled(metric)
    try:
        vertices = convex_polyhedron(double, tolerance, log, largest_noise(double.deficits)).vertices
    except NotEmbedded as failure:  # Newton's method may still converge, as shown by its residual
        vertices = failure.embedding.vertices
    half = vertices[: metric.triangulation.n_vertices]
    x = upright(half, half[loop])
    with log.stage("Newton with heights") as recorder:
        for part in np.arange(6) / 5 if rise.any() else (0,):  # raises the boundary in five steps
            x = with_heights(metric, x, part * rise, recorder)
            recorder.show(vertices=x)
    x = turned_about_vertical(x, loop) + np.array([0.0, 0.0, level])
    return _embedding(metric, x, tolerance, log, condition, heights=frozen(heights))


def _through(
    metric: PolyhedralMetric, curve: Floats, start: Floats | None, tolerance: float, log: Log
) -> SheetEmbedding:
    """Surface with given boundary."""
    t = metric.triangulation
    x = np.zeros((t.n_vertices, 3))
    x[np.concatenate(t.boundaries)] = curve
    a, b = t.edges.T
    missing = t.boundary_edges & (x[a] == x[b]).all(axis=1)
    if missing.any():
        e = int(np.argmax(missing))
        raise InvalidParameter(f"the ends of edge {e} {t.edges[e].tolist()} coincide in the boundary")
    with log.stage("given boundary") as recorder:
        x = through_curve(BendingEnergy(metric), LengthConstraints(metric), x, start, recorder)
    found = _embedding(metric, x, tolerance, log, "curve")
    boundary_residuals = np.where(t.boundary_vertices[t.edges].all(axis=1), found.residuals, 0.0)
    e = int(np.argmax(boundary_residuals))
    if boundary_residuals[e] <= tolerance:
        return found
    off = np.linalg.norm(x[a[e]] - x[b[e]]) / metric.lengths[e] - 1
    why = (
        "are they in the order of Triangulation.boundaries?"
        if boundary_residuals[e] > NOISE
        else f"for measured positions, a least-squares surface needs tolerance={1.5 * found.residual:.0e}"
    )
    return found._with_message(
        f"the boundary does not fit the lengths: the distance of its vertices {a[e]} and {b[e]} differs from "
        f"the length of their edge by {off:.2g} of it; {why}"
    )


def _least_bending(
    metric: PolyhedralMetric, start: Floats | None, tolerance: float, log: Log
) -> SheetEmbedding:
    """Surface of least bending, with one from another start that bends more, if found."""
    energy, lengths = BendingEnergy(metric), LengthConstraints(metric)
    t, near, stiffnesses = metric.triangulation, None, STIFFNESSES
    starts: list[Floats] = []
    is_flexible = t.n_edges <= 3 * t.n_vertices - 6
    is_placed = start is not None
    if start is None:
        start, near = _start(metric, tolerance, log)
        if near is None and is_flexible:
            with log.stage("buckling") as recorder:
                starts, stiffnesses = buckled(energy, lengths, recorder)
    if near is None and not is_flexible:  # a close start leads to the lengths without bending
        with log.stage("Newton on lengths") as recorder:
            x = nearest_with_lengths(lengths, start, recorder)
        if _residual(lengths, x) <= EXACT:
            near = LeastBending(x, np.zeros(t.n_edges), np.inf)
    sheets = [near] if near is not None else []
    if near is None:
        with log.stage("elastic sheets") as recorder:
            best = [start]
            if starts:
                best = most_promising(energy, lengths, [start, *starts], stiffnesses, recorder)
            sheets = [thinned(energy, lengths, x, recorder, stiffnesses) for x in best]
    if is_flexible:
        with log.stage("least bending") as recorder:
            sheets = _balanced(energy, lengths, sheets, recorder)
    tried = f"{1 + len(starts)} starts" if starts else "one start"
    surfaces = []
    for found in sheets:
        if _residual(lengths, found.vertices) > EXACT:
            with log.stage("Newton on lengths") as recorder:
                found = replace(found, vertices=nearest_with_lengths(lengths, found.vertices, recorder))
        properties: dict[str, Any] = {}
        if is_flexible:
            properties = {
                "tensions": frozen(found.multipliers),
                "imbalance": found.imbalance,
                "uniqueness": Evidence("searched", f"found from {tried}: other surfaces may bend less"),
            }
        x = aligned(found.vertices, start) if is_placed else standard_sheet(t, found.vertices)
        surfaces.append(_embedding(metric, x, tolerance, log, "free", **properties))
    surfaces.sort(key=_rank)
    return _beside(surfaces[0], surfaces[1:])._with_stages(log.stages)


def _beside(best: SheetEmbedding, rest: list[SheetEmbedding]) -> SheetEmbedding:
    """Best surface, with distinct others aligned to it as other realizations."""
    energy = best.second_form_energy
    others = [
        replace(other, vertices=aligned_image(other.vertices, best.vertices))
        for other in rest
        if other.converged and abs(other.second_form_energy - energy) > SAME * energy
    ]
    return best._with_others(others, best.uniqueness)


def _balanced(
    energy: BendingEnergy, lengths: LengthConstraints, sheets: list[LeastBending], recorder: StageRecorder
) -> list[LeastBending]:
    """Surfaces of least bending near elastic sheets; the best sheet is made thinner if necessary."""
    pairs = [(balanced(energy, lengths, sheet, recorder), sheet) for sheet in sheets]
    (best, sheet), *rest = sorted(pairs, key=lambda pair: energy.value(pair[0].vertices))
    for stiffness in THINNER:
        if best.imbalance < BALANCED:
            break
        sheet = thinned(energy, lengths, sheet.vertices, recorder, (stiffness,))
        best = min(best, balanced(energy, lengths, sheet, recorder), key=lambda s: s.imbalance)
    return [best, *(found for found, _ in rest)]


def _rank(found: SheetEmbedding) -> tuple[bool, float]:
    """Sort key of surfaces: converged ones first, then by bending energy."""
    stalled = found.imbalance is not None and found.imbalance > BALANCED
    return not found.converged, (STALLED if stalled else 1.0) * found.second_form_energy


def _residual(lengths: LengthConstraints, x: Floats) -> float:
    """Largest residual in mean edge lengths."""
    return float(np.abs(lengths.residuals(x)).max()) / lengths.metric.mean_length


def _start(metric: PolyhedralMetric, tolerance: float, log: Log) -> tuple[Floats, LeastBending | None]:
    """Initial surface and, if it has the lengths, the start of Newton's method."""
    t = metric.triangulation
    none, curved, several = np.zeros(t.n_edges), deficits(metric), len(t.boundaries) > 1
    is_disc = t.genus == 0 and len(t.boundaries) == 1
    is_convex = (curved >= -ANGLE_ROUNDING).all() and (curved[~t.boundary_vertices] > ANGLE_ROUNDING).any()
    if is_disc and is_convex:
        x = _raised(metric, np.zeros(len(t.boundaries[0])), tolerance, log, "plane").vertices
        return x, LeastBending(x, none, np.inf)
    if t.genus == 0 and several:
        closed = filled(metric)
        try:
            found = Aim(effort=0).run(closed.normalized, tolerance, log)
        except (InvalidMetric, NotEmbedded):  # the surface may exist without the filled one
            return scaled_distances(metric), None
        if found.converged:
            x = found._in_unit_of(closed).vertices[: t.n_vertices]
            return x, LeastBending(x, none, np.inf)
    return scaled_distances(metric), None


def _embedding(
    metric: PolyhedralMetric, x: Floats, tolerance: float, log: Log, condition: str, **properties: Any
) -> SheetEmbedding:
    return SheetEmbedding(
        metric,
        x,
        method=Sheet.name,
        tolerance=tolerance,
        stages=log.stages,
        condition=condition,
        **properties,
    )


def _nested(values: ArrayLike, name: str) -> tuple[Any, ...]:
    """Array as nested tuples, which are compared and printed completely."""
    array = real_array(values, f"{name} row", "coordinate")
    if array.ndim not in (1, 2):
        raise InvalidParameter(f"the {name} has the shape {array.shape}, not one of one or two axes")
    finite = np.isfinite(array)
    if not finite.all():
        at = np.argwhere(~finite)[0].tolist()
        raise InvalidParameter(f"the {name} at {at} is {array[tuple(at)]}, which is not finite")
    return tuple(map(tuple, array.tolist())) if array.ndim == 2 else tuple(array.tolist())
