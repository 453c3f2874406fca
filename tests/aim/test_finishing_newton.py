"""From surfaces at which J is singular to those that have the lengths."""

import numpy as np
import pytest

import smooth_bodies
import zoo
from isoembed.aim.anneal import anneal
from isoembed.aim.finishing_newton import finish
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.surface.rigidity import LengthSystem, length_residuals


def with_a_vertex_on_some_faces(height):
    """A polyhedron of 12 vertices, three of its faces with one more at this height above their middles."""
    points = np.random.default_rng(3).standard_normal((12, 3))
    vertices, faces = zoo.outward_hull(points / np.linalg.norm(points, axis=1)[:, None])
    faces, added = faces.tolist(), []
    for a, b, c in faces[:3]:
        normal = np.cross(vertices[b] - vertices[a], vertices[c] - vertices[a])
        middle = vertices[[a, b, c]].mean(axis=0)
        added.append(middle + height * normal / np.linalg.norm(normal))
        new = len(vertices) + len(added) - 1
        faces += [[a, b, new], [b, c, new], [c, a, new]]
    return np.concatenate([vertices, added]), np.array(faces[3:])


@pytest.mark.parametrize("height", [0.003, 0.03])
def test_flat_vertices_come_out_of_their_faces(height):
    vertices, faces = with_a_vertex_on_some_faces(height)
    metric, (flat, _) = PolyhedralMetric.from_mesh(vertices, faces), with_a_vertex_on_some_faces(0.0)
    system = LengthSystem(metric.triangulation)
    recorder = smooth_bodies.recorder()
    assert anneal(system, flat, metric.lengths, recorder).residual > 1e-8  # J is singular there
    found = finish(system, flat, metric.lengths, recorder, lambda _: False)
    errors = length_residuals(metric.triangulation, found, metric.lengths)
    assert np.abs(errors).max() < 1e-11 * metric.mean_length
    assert np.abs(found[-3:] - flat[-3:]).max() > height / 3


def test_nothing_is_tried_when_no_more_may_be_spent():
    vertices, faces = with_a_vertex_on_some_faces(0.03)
    metric, (flat, _) = PolyhedralMetric.from_mesh(vertices, faces), with_a_vertex_on_some_faces(0.0)
    recorder = smooth_bodies.recorder()
    found = finish(
        LengthSystem(metric.triangulation, work=recorder.work), flat, metric.lengths, recorder, lambda _: True
    )
    assert found is flat
    assert recorder.factorizations == 0
