"""A hyperbolic surface of genus 2 with 10 vertices."""

import numpy as np
import pytest

from isoembed.metric.curvature import deficits
from isoembed.surface.intersection import self_intersections
from reproduction import hyperbolic_torus
from sections import check_section


@pytest.mark.slow
def test_the_section():
    section = hyperbolic_torus.study()
    check_section(section)
    assert section.numbers["closure"] < 1e-30
    assert np.abs(section.numbers["deficits"]).max() < 1e-14
    assert all(
        one["agrees"] and abs(one["ours"] - one["second"]) < 2e-15 for one in section.numbers["heights"]
    )


def test_a_vertex_that_is_moved_opens_the_angles_or_makes_faces_cross():
    klein, faces = hyperbolic_torus.coordinates(), hyperbolic_torus.triangles()
    moved = klein.copy()
    moved[9, 2] -= 1e-6
    assert np.abs(deficits(hyperbolic_torus.hyperbolic(moved, faces))).max() > 1e-7
    moved[9, 2] = -0.2
    assert len(self_intersections(faces, moved)) > 0
    assert len(self_intersections(faces, klein, 0.99 * hyperbolic_torus.reach(klein, faces))) == 0


def test_the_surface_is_closed_and_of_genus_2():
    faces = hyperbolic_torus.triangles()
    sides = {(a, b) for face in faces.tolist() for a, b in zip(face, face[1:] + face[:1], strict=True)}
    assert len(sides) == 72 and all((b, a) in sides for a, b in sides)
    assert 10 - 36 + 24 == 2 - 2 * 2
