"""Weyl's problem along paths of metrics, and the embedding of a Ricci flow."""

import numpy as np
import pytest

from isoembed.meshing.sphere import fibonacci_directions, hull_faces
from reproduction import weyl_path
from sections import check_section


def test_errors_of_linear_elements_fall_with_their_order():
    def errors(n):
        u = fibonacci_directions(n)
        return np.array(_errors(u, u))

    # The metric of elements of order 1 is of first order in h but for inscribed ones of a sphere.
    assert errors(500) / errors(2000) == pytest.approx(np.array([4, 4]), rel=0.1)
    assert errors(1407)[1] == pytest.approx(1.309e-2, rel=0.1)  # the authors', with as many vertices


def _errors(u, vertices):
    identity = weyl_path._identity
    return weyl_path.errors_of_elements(u, hull_faces(u), vertices, lambda p: p, identity)


def test_a_scaled_sphere_has_the_errors_of_its_scale():
    u = fibonacci_directions(3000)
    expected = 0.1 * np.sqrt(4 * np.pi), 0.21 * np.sqrt(8 * np.pi)
    assert _errors(u, 1.1 * u) == pytest.approx(expected, rel=0.02)


def test_the_area_of_the_ricci_flow_falls_by_8_pi():
    flow = weyl_path.RicciFlow.solved()
    for share in (0.2, 0.7, 0.95):
        assert flow.profile(share).area == pytest.approx(8 * np.pi * flow.end * (1 - share), rel=1e-8)
    assert flow.profile(0.0).negative_curvature and not flow.profile(0.5).negative_curvature


@pytest.mark.slow
def test_the_section():
    section = weyl_path.study(sizes=(0.7, 0.5), vertices=300, images=3)
    check_section(section)
    assert max(one["error"] for one in section.numbers["path"]) < 1e-12
    assert section.numbers["order"] == pytest.approx(2, abs=0.3)
    assert section.numbers["rate"] == pytest.approx(2, abs=0.01)
    assert section.numbers["revolution"]["harmonics"] < 1e-12
