"""Warnings of inspections, in words."""

import numpy as np

import zoo
from isoembed import PolyhedralMetric
from isoembed.metric.inspection import inspect


def test_a_flat_vertex_and_wide_triangles():
    """A cube with the middle of a side of one face, moved toward an edge."""
    vertices, faces = zoo.cube()
    v = len(vertices)
    a, b, c = faces[0]
    middle = np.array(vertices, dtype=float)[[a, b, c]].T @ [0.4, 0.4, 0.2]
    faces = [*faces[1:], [a, b, v], [b, c, v], [c, a, v]]
    found = {
        one.kind: one for one in inspect(PolyhedralMetric.from_mesh([*vertices, middle], faces)).warnings
    }
    assert found["flat_vertices"].count == 1
    assert found["flat_vertices"].text.startswith(
        f"flat vertices: 1; the worst: the triangles around vertex {v} lie in one plane when unfolded: "
    )
    assert "make other surfaces with the same lengths more likely" in found["angles"].text
    assert "degree" in found["angles"].text and "e-16" not in found["flat_vertices"].text
