"""Metrics and surfaces that the methods are compared on."""

import numpy as np
import pytest

from isoembed.meshing.sphere import fibonacci_directions
from reproduction.baselines.subjects import paper_subjects, saddled


@pytest.mark.parametrize("subject", [*paper_subjects(), saddled()], ids=lambda s: s.name)
def test_subjects_have_the_metrics_of_their_surfaces(subject):
    u, h = fibonacci_directions(40), 1e-4
    q = subject.metric.tensor(u)
    t = np.cross(u, [0.3, -0.5, 0.8])
    t /= np.linalg.norm(t, axis=1)[:, None]
    there, back = (subject.point(np.cos(h) * u + np.sin(s) * t) for s in (h, -h))
    squares = ((there - back) ** 2).sum(axis=1) / (2 * h) ** 2
    np.testing.assert_allclose(squares, np.einsum("ni,nij,nj->n", t, q, t), rtol=1e-5)
