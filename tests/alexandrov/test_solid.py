"""Regular solids of hyperbolic and spherical space, found from the lengths on their triangles."""

import numpy as np
import pytest

import isoembed
from isoembed import PolyhedralMetric, embed
from isoembed.alexandrov.solid import Solid
from isoembed.surface.curvature import dihedral_angles
from regular_in_space import SYMBOLS, regular_solid

CASES = [
    (name, k, angle)
    for name, hyperbolic, spherical in (
        ("tetrahedron", 1.1, 1.5),
        ("cube", 1.3, 1.8),
        ("octahedron", 1.6, 2.0),
        ("dodecahedron", 1.6, 2.1),
        ("icosahedron", 2.0, 2.5),
    )
    for k, angle in ((-1.0, hyperbolic), (-0.1, hyperbolic), (2.0, spherical))
]


@pytest.mark.parametrize(("name", "k", "dihedral"), CASES)
def test_regular_solids(name, k, dihedral):
    solid = regular_solid(name, k, dihedral)
    metric = PolyhedralMetric.from_mesh(solid.points, solid.faces, curvature=k)
    found = embed(metric, method="alexandrov")
    named = Solid.of(found)
    assert named.name == (name if name == "cube" else f"regular {name}")
    assert len(found.polygons) == len(solid.faces)
    assert set(found.surface.flat_faces.sides) == {SYMBOLS[name][0]}
    angles = dihedral_angles(found.triangulation, found.vertices, found.space)[found.surface.flat_faces.edges]
    assert angles == pytest.approx(np.full(len(angles), np.pi - dihedral), abs=1e-11)
    assert found.area == pytest.approx(solid.area, rel=1e-12)
    assert named.distances[0] == pytest.approx(solid.edge, rel=1e-12)
    assert named.distances[-1] <= 2 * solid.radius * (1 + 1e-12)
    assert isoembed.certify(found).certified
    assert isoembed.certify(found).distance < 1e-13 * metric.mean_length
    assert isoembed.certify(found).flat_edges == (~found.surface.flat_faces.edges).sum()


def test_solids_of_different_spaces_differ():
    one, other = (
        Solid.of(embed(PolyhedralMetric.from_mesh(s.points, s.faces, curvature=k), method="alexandrov"))
        for k in (-1.0, -1.1)
        for s in [regular_solid("cube", k, 1.3)]
    )
    assert one.is_congruent(one)
    assert not one.is_congruent(other)
