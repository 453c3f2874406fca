"""Smooth caps fitted to edge lengths with known standard deviations, their boundaries in a plane.

Two copies glued along the boundary are a closed surface, to which `isoembed.aim.measured_lengths` fits one
whose halves are smooth within the errors.  Between them is a crease, unless the cap is vertical along its
boundary: then the double may be smooth there, too, and is taken as smooth if that predicts each length better
from the others.  Few vertices do not show whether they are dented: if the surface misses the lengths, or is
farther from the convex one than errors explain, the smooth double or the convex surface itself is taken.  The
cap is the mean of one half and of the mirror image of the other.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from isoembed.aim.acceptance import is_exact
from isoembed.aim.adaptive import Aim
from isoembed.aim.choice import NEAR_FIT
from isoembed.aim.creased_fit import convex_start
from isoembed.aim.levels import smooth_start
from isoembed.aim.measured_lengths import fit_within_errors, measured_surface, other_edges, root_mean_square
from isoembed.aim.pipeline import Pipeline
from isoembed.arrays import Floats
from isoembed.embedding.measured import MeasuredSurface, standing_out
from isoembed.errors import InvalidMetric
from isoembed.mesh.triangulation import frozen
from isoembed.metric.curvature import deficits
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.progress.stages import Log
from isoembed.sheets.convex_cap import ANY_CURVATURE, check_disc, copied_vertices, doubled, upright
from isoembed.sheets.surface import SheetEmbedding
from isoembed.surface.curvature import dihedral_angles
from isoembed.surface.piecewise_smoothness import piecewise_fit_residuals
from isoembed.surface.placement import turned_about_vertical

if TYPE_CHECKING:
    from isoembed.sheets.derivatives import SheetDerivatives


@dataclass(frozen=True, eq=False, repr=False)
class MeasuredCap(MeasuredSurface, SheetEmbedding):
    """Smooth surface whose boundary is in a plane, fitted to edge lengths with known standard deviations.

    Its residuals are judged as those of a `MeasuredSurface`.  Derivatives and deviations are those of the cap
    with exactly the lengths that it has.
    """

    def _length_derivatives(self) -> SheetDerivatives:
        """Derivatives of the cap with these lengths by them, its boundary in a plane."""
        own = self.metric.with_lengths(self.surface.lengths)
        heights = np.zeros(sum(map(len, self.triangulation.boundaries)))
        exact = SheetEmbedding(
            own,
            self.vertices,
            method=self.method,
            tolerance=self.tolerance,
            condition="plane",
            heights=heights,
        )
        return exact._length_derivatives()

    @property
    def _reported(self) -> Mapping[str, Any]:
        """Passed test, and the condition at the boundary."""
        return {**super()._reported, **super(MeasuredSurface, self)._reported}


def explained_angles(metric: PolyhedralMetric) -> Floats:
    """Angles about each vertex that the errors of the lengths explain, shape (V,).

    An angle of a triangle depends on a length by one over a height, and no height is much less than a side.
    """
    sigma = np.asarray(metric.length_errors, dtype=np.float64)
    return np.asarray(2 * metric.triangulation.degrees * sigma.max() / metric.lengths.min())


def measured_cap(metric: PolyhedralMetric, name: str, tolerance: float, log: Log) -> MeasuredCap:
    """Fit a cap, by the method of this name, to a normalized metric with `length_errors`.

    Raises
    ------
    InvalidMetric
        The surface is no disc or a single triangle, an exterior angle of its boundary is more negative than
        the errors explain, or two vertices of its boundary are joined by an edge inside.
    """
    check_disc(metric)
    t, n = metric.triangulation, metric.triangulation.n_vertices
    sigma, explained = np.asarray(metric.length_errors, dtype=np.float64), explained_angles(metric)
    beyond = np.where(t.boundary_vertices, deficits(metric) + explained, 0.0)
    if (beyond < 0).any():
        v = int(np.argmin(beyond))
        raise InvalidMetric(
            f"the exterior angle of the boundary at vertex {v} is {deficits(metric)[v]:.4g} radians, and "
            f"errors of the lengths explain {explained[v]:.1g}: of a convex cap none is negative; is a "
            f"length near it wrong? Without errors, {ANY_CURVATURE}"
        )
    chords = t.boundary_vertices[t.edges].all(axis=1) & ~t.boundary_edges
    if chords.any():
        e = int(np.argmax(chords))
        raise InvalidMetric(
            f"edge {e} {t.edges[e].tolist()} joins two vertices of the boundary inside: such a cap is not "
            "fitted to lengths with errors"
        )
    inside = np.flatnonzero(~t.boundary_vertices)
    if not len(inside):
        raise InvalidMetric(
            "a triangle has no vertices inside: its lengths determine it without a fit; length_errors=0 "
            "takes them as exact"
        )
    copied = copied_vertices(t)
    own = np.concatenate([np.arange(n), inside])
    closed = doubled(metric).simplicial()
    # Edges inside count twice there, and those of the boundary are to count as much.
    once = np.where(t.boundary_edges, np.sqrt(0.5), 1.0)
    copies = t.edge_indices(own[closed.edges])
    [loop] = t.boundaries
    rim = t.boundary_edges[copies]
    one_sided = partial(piecewise_fit_residuals, closed.triangulation, rim)

    def fitted(errors: Floats) -> MeasuredCap:
        measured = closed.with_length_errors((once * errors)[copies])
        unit = measured.normalized
        pipeline, known = Pipeline(unit, Aim(), tolerance, log), np.asarray(unit.length_errors)
        start = convex_start(unit, pipeline)
        convex = pipeline.problem.surface(start)

        def is_off(one: MeasuredSurface) -> bool:
            """Whether a surface is too far from the lengths or the convex one, without a length suspected."""
            reach = NEAR_FIT * np.sqrt(max(known.max(), convex.residual))
            # Of a metric that is not convex, the convex surface is not near.
            is_near = not pipeline.problem.is_convex or convex.distance(one) <= reach
            return one.predicted is None and not (one.converged and is_near)

        with log.stage("fit within errors") as recorder:
            near = smooth_start(unit, start, recorder)
            fit = fit_within_errors(unit, known, near, recorder, one_sided)
            found = measured_surface(unit, fit, name, tolerance)
            bends = np.abs(dihedral_angles(unit.triangulation, fit.vertices))
            # Sharper bends along the boundary are no part of a smooth surface.
            is_smooth = np.median(bends[rim]) < 5.0 * np.median(bends[~rim])
            if is_smooth or is_off(found) or not found.converged:
                other, error = fit_within_errors(unit, known, near, recorder), root_mean_square(known)
                whole = measured_surface(unit, other, name, tolerance)
                ranks = [
                    (is_off(one), of.prediction_error(error / unit.mean_length))
                    for of, one in ((fit, found), (other, whole))
                ]
                found = found if ranks[0] <= ranks[1] else whole
        if is_exact(convex) and is_off(found):
            found = MeasuredSurface(unit, convex.vertices, method=name, tolerance=tolerance, weight=0.0)
        x = measured.unit * found.vertices
        middle = x[loop].mean(axis=0)
        axes = np.linalg.svd(x[loop] - middle, full_matrices=False)[2]
        half, other = ((x[some] - middle) @ axes.T for some in (np.arange(n), copied))
        cap = (half + other * [1.0, 1.0, -1.0]) / 2
        predicted = alike = None
        suspected = copies[[np.argmax(found._standardized)]]
        if found.predicted is not None:  # of one of two copies at least
            predicted = np.full(t.n_edges, np.nan)
            left_out = np.flatnonzero(np.isfinite(found.predicted))
            left_out = left_out[np.argsort(found._standardized[left_out])]  # of two, the worse one counts
            predicted[copies[left_out]] = (
                found.predicted[left_out] * measured.mean_length / metric.mean_length
            )
            suspected = copies[left_out] if left_out.size else suspected
        if found.alike is not None:  # of either copy, whose twin is no other edge
            alike = other_edges(copies[found.alike], suspected)
        return MeasuredCap(
            metric,
            frozen(turned_about_vertical(upright(cap @ axes, cap[loop] @ axes), loop)),
            method=name,
            tolerance=tolerance,
            stages=log.stages,
            weight=found.weight,
            scatter=found.scatter,
            redundancy=found.redundancy,
            predicted=predicted,
            alike=alike,
            condition="plane",
        )

    cap = fitted(sigma)
    doubt = standing_out(cap._standardized)
    if doubt is None or cap.predicted is not None:
        return cap
    # The two copies of a length hide one another on the closed surface.
    without = fitted(np.where(np.arange(t.n_edges) == doubt, metric.mean_length, sigma))
    predicted = np.full(t.n_edges, np.nan)
    predicted[doubt] = without.lengths[doubt] / metric.mean_length
    return replace(cap, predicted=predicted)
