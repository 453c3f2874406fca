"""Residuals and angles."""

import numpy as np
import pytest

from isoembed.gallery import Ellipsoid, triangulate
from reproduction import accuracy
from sections import check_section


@pytest.fixture(scope="module")
def section():
    return accuracy.study(vertices=100)


def test_the_section_can_be_written(section):
    check_section(section)


def test_lengths_are_within_the_tolerances_and_the_drum_is_flat_on_its_equator(section):
    numbers = section.numbers
    assert numbers["curvature_on_equator"] == 0
    for name in ("ellipsoid", "drum"):
        for row, tolerance in zip(numbers[name]["settings"], (1e-6, 1e-9, 1e-10), strict=True):
            assert row["mean"] < row["max"] <= tolerance
            assert row["std"] < tolerance


def test_angles_are_those_of_the_triangles(section):
    angles = section.numbers["ellipsoid"]["angles"]
    vertices, faces = triangulate(Ellipsoid(), 100)
    found = []
    for a, b, c in (np.roll(faces, k, axis=1).T for k in range(3)):
        u, v = vertices[b] - vertices[a], vertices[c] - vertices[a]
        u, v = (w / np.linalg.norm(w, axis=1)[:, None] for w in (u, v))
        found.append(np.degrees(np.arccos((u * v).sum(axis=1))))
    found = np.array(found)
    assert angles["corners"] == found.size
    assert angles["smallest"] == pytest.approx(found.min(), rel=1e-9)
    assert angles["largest"] == pytest.approx(found.max(), rel=1e-9)
    assert angles["outside"] == [((found < 30) | (found > top)).sum() for top in (90, 120)]
