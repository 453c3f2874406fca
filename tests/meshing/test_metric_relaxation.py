"""Lengths of edges between directions, from a metric at their ends."""

from types import SimpleNamespace

import numpy as np
import pytest

import zoo
from isoembed.mesh.triangulation import Triangulation
from isoembed.meshing.metric_relaxation import end_lengths


def test_lengths_on_the_round_sphere_are_arcs():
    vertices, faces = zoo.icosphere(1)
    u = vertices / np.linalg.norm(vertices, axis=1)[:, None]
    t = Triangulation(faces)
    mesh = SimpleNamespace(corners=t.faces.ravel(), twins=t.twins, lengths=np.full(t.faces.size, np.nan))
    end_lengths(u, 9.0 * (np.eye(3) - u[:, :, None] * u[:, None, :]), mesh)
    ends = u[mesh.corners], u[mesh.corners[t.twins]]
    assert mesh.lengths == pytest.approx(3.0 * np.arccos((ends[0] * ends[1]).sum(axis=1)), rel=1e-12)


def test_metrics_of_both_ends_count_alike():
    u = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, -1.0, -1.0] / np.sqrt(3.0)])
    t = Triangulation([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
    mesh = SimpleNamespace(corners=t.faces.ravel(), twins=t.twins, lengths=np.empty(12))
    q = np.arange(1.0, 5.0)[:, None, None] * np.array([[2.0, 0.3, 0.1], [0.3, 1.0, 0.2], [0.1, 0.2, 3.0]])
    end_lengths(u, q, mesh)
    for h in range(12):
        i, j = mesh.corners[h], mesh.corners[t.twins[h]]
        chord = u[j] - u[i]
        half = np.sqrt(chord @ chord) / 2
        length = np.sqrt(chord @ (q[i] + q[j]) @ chord / 2) * np.arcsin(half) / half / np.sqrt(1 - half**2)
        assert mesh.lengths[h] == pytest.approx(length, rel=1e-13)
