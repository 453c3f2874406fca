"""The pose of a surface: pictures can be repeated, however the surface was turned and rounded."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import zoo
from isoembed.gallery import Ellipsoid, KerrHorizon, triangulate
from isoembed.plot.view import Pose

OCTAHEDRON = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], dtype=float)
BODIES = {
    "octahedron": OCTAHEDRON,
    "disk": OCTAHEDRON * [1, 1, 0.5],
    "rod": OCTAHEDRON * [1, 1, 2],
    "sphere": zoo.icosphere(2)[0],
    "ellipsoid": zoo.icosphere(2)[0] * [1, 3, 2],
    "flat": OCTAHEDRON * [1, 2, 0],
    "horizon": triangulate(KerrHorizon(), 100)[0],
    "irregular": triangulate(Ellipsoid((3, 2, 1)), 100, irregular=1)[0],
}


@pytest.mark.parametrize("name", BODIES)
def test_a_body_has_one_pose(name):
    vertices = BODIES[name]
    posed = Pose.of(vertices).put(vertices)
    extents = np.ptp(posed, axis=0)
    assert np.linalg.det(Pose.of(vertices).axes) == pytest.approx(1)
    if name not in ("octahedron", "sphere", "horizon"):
        assert extents[0] >= (1 - 1e-9) * extents[1] >= (1 - 1e-6) * extents[2]
    for seed in range(3):
        rng = np.random.default_rng(seed)
        turned = Rotation.random(random_state=seed).apply(vertices) * 7 + rng.normal(size=3)
        turned *= 1 + 1e-13 * rng.normal(size=turned.shape)
        np.testing.assert_allclose(Pose.of(turned).put(turned), posed, atol=1e-9)
