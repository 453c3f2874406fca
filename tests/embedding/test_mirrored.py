"""Dents of one surface that are bumps of another."""

import numpy as np

import smooth_bodies
from isoembed.embedding.mirrored import mirrored_caps
from isoembed.mesh.triangulation import Triangulation
from isoembed.metric.curvature import deficits
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.surface.curvature import vertex_mean_curvature


def test_the_caps_of_reflected_dimples_are_found():
    centers = ((0.0, 0.0, 1.0), (0.0, 0.0, -1.0))
    vertices, faces = smooth_bodies.dimpled(800, centers)
    t, curved = Triangulation(faces), deficits(PolyhedralMetric.from_mesh(vertices, faces))
    theta = np.linspace(0, 1.5, 10_000)
    rim = np.max(np.cos(theta) * (1 - 0.4 * np.exp((np.cos(theta) - 1) / 0.4**2)))
    inside = (vertices[:, 2] > 0) & (np.hypot(vertices[:, 0], vertices[:, 1]) < 0.3)
    reflected = np.where(inside[:, None], vertices * [1, 1, -1] + [0, 0, 2 * rim], vertices)
    first, second = (vertex_mean_curvature(t, x) for x in (vertices, reflected))
    (cap,) = mirrored_caps(t, curved, first, second)
    assert inside[cap].all()
    assert mirrored_caps(t, curved, first, first) == []
    assert len(mirrored_caps(t, curved, first, np.abs(second))) == 2
