"""Hole filling: a cone over every boundary closes a surface of genus 0."""

from __future__ import annotations

import numpy as np

from isoembed.metric.polyhedral import PolyhedralMetric


def filled(metric: PolyhedralMetric) -> PolyhedralMetric:
    """Metric with a nearly flat cone in each hole; the first vertices and faces are the given ones."""
    t = metric.triangulation
    faces, edges, lengths = [t.faces], [t.edges], [metric.lengths]
    for apex, loop in enumerate(t.boundaries, t.n_vertices):
        after = np.roll(loop, -1)
        sides = metric.lengths[t.edge_indices(np.stack([loop, after], axis=1))]
        radius = float(sides.sum()) / (2 * len(loop) * np.sin(np.pi / len(loop)))
        tip = np.full(len(loop), apex)
        faces.append(np.stack([after, loop, tip], axis=1))
        edges.append(np.stack([loop, tip], axis=1))
        # Legs hardly longer than the radius of the regular polygon with the same perimeter.
        lengths.append(np.full(len(loop), max(1.01 * radius, 0.51 * float(sides.max()))))
    return PolyhedralMetric(np.concatenate(faces), np.concatenate(lengths), np.concatenate(edges))
