"""Polygons of the hyperbolic plane and of the sphere, and what is glued from them."""

import re

import numpy as np
import pytest

from isoembed import InvalidMetric, InvalidParameter, Space, embed
from isoembed.embedding.embedding import Embedding
from isoembed.gluing import edge_gluings, from_sides, glue, regular_polygon, triangle, unfold, zipped
from isoembed.gluing.polygon import Polygon
from isoembed.metric.curvature import deficits
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.space.models import MODELS, to_model
from regular_in_space import CELLS, SOLIDS, regular_solid

CURVATURES = [-1.0, -0.3, -1e-13, 0.7]


def area(net):
    return net.triangles.areas.sum() * net.triangles.unit**2


@pytest.mark.parametrize("which", SOLIDS, ids=str)
def test_regular_solids_from_their_faces(which):
    solid, k = regular_solid(*which), which[1]
    faces = [regular_polygon(len(face), solid.edge, curvature=k) for face in solid.faces]
    net = glue(faces, corners=solid.faces, curvature=k)
    assert net.n_vertices == len(solid.points)
    assert net.deficits == pytest.approx(solid.deficit, rel=1e-11)
    assert area(net) == pytest.approx(solid.area, rel=1e-11)
    assert Polygon.of(faces[0], 0, Space(k)).angles == pytest.approx(solid.face_angle, rel=1e-13)


@pytest.mark.parametrize("which", CELLS, ids=str)
def test_cells_of_tessellations_from_their_faces(which):
    *shape, volume = which
    solid, space = regular_solid(*shape), Space(which[1])
    faces = [regular_polygon(len(face), solid.edge, curvature=space.curvature) for face in solid.faces]
    net = glue(faces, corners=solid.faces, curvature=space.curvature)
    found = embed(net, method="alexandrov")
    assert found.converged and found.space == space
    assert np.linalg.norm(space.centered(found.vertices), axis=1) == pytest.approx(
        float(space.sn(np.array(solid.radius))), rel=1e-12
    )
    assert found.volume == pytest.approx(volume * space.radius**3, rel=1e-8)


@pytest.mark.parametrize("k", CURVATURES)
def test_polygons_by_their_sides(k):
    space = Space(k)
    sheet = Polygon.of(triangle(1.0, 1.1, 0.7, curvature=k), 0, space)
    assert sheet.sides == pytest.approx([1.0, 1.1, 0.7], rel=1e-13)
    sides, angles = [0.5, 0.4, 0.7, 0.3], [2.0, 1.8, 2.5]
    sheet = Polygon.of(from_sides(sides, angles, curvature=k), 0, space)
    assert sheet.sides[:4] == pytest.approx(sides, rel=1e-12)
    assert sheet.angles[1:4] == pytest.approx(angles, rel=1e-12)
    flat = from_sides(sides, angles)
    assert flat[:2].tolist() == [[0.0, 0.0], [0.5, 0.0]]


@pytest.mark.parametrize("k", CURVATURES)
def test_all_models_make_the_same_metric(k):
    octagon = regular_polygon(8, 0.6, curvature=k)
    sides = [((0, m), (0, m + 1)) for m in range(0, 8, 2)]
    nets = [glue([to_model(Space(k), octagon, model)], sides, curvature=k, model=model) for model in MODELS]
    for net in nets:
        assert net.face_lengths == pytest.approx(nets[0].face_lengths, rel=1e-12)
        assert net.deficits.sum() == pytest.approx(4 * np.pi - k * area(net), rel=1e-13)
    assert sides in edge_gluings(octagon, convex=False, curvature=k)


@pytest.mark.parametrize("k", CURVATURES)
def test_corners_that_meet_sides_of_others(k):
    """A sheet twice, one copy as a mirror image: zipped from anywhere it is folded along equal lengths."""
    sheet = triangle(1.0, 1.1, 0.7, curvature=k)
    net = zipped(sheet, 0.3, curvature=k)
    angles = Polygon.of(sheet, 0, Space(k)).angles
    # Both ends of the zip are within sides, the three corners are glued into others.
    assert np.sort(2 * np.pi - net.deficits) == pytest.approx(
        np.sort([np.pi, np.pi, *(np.pi + angles)]), rel=1e-12
    )
    rim = net.polygons[0]
    steps = Space(k).distances(rim, np.roll(rim, -1, axis=0))
    assert steps.sum() == pytest.approx(2.8, rel=1e-13)
    assert 2 * net.deficits.sum() == pytest.approx(8 * np.pi - 2 * k * area(net), rel=1e-13)


@pytest.mark.parametrize("k", CURVATURES)
def test_doubly_covered_triangles(k):
    sheet = triangle(1.0, 1.1, 0.7, curvature=k)
    net = glue([sheet, sheet], corners=["abc", "abc"], curvature=k)
    assert net.n_faces == 2 and net.space == Space(k)
    assert net.deficits == pytest.approx(2 * np.pi - 2 * Polygon.of(sheet, 0, Space(k)).angles, rel=1e-12)


REFUSALS = {
    "outside": (
        lambda: glue([[[0, 0], [1, 0], [0, 1]]] * 2, [], curvature=-1.0, model="projective"),
        "polygon 0: point 1 is 1 from the center of the projective model, whose boundary is at 1",
    ),
    "model": (
        lambda: glue([[[0, 0], [1, 0], [0, 1]]], [], model="poincare"),
        "the model is 'poincare', none of conformal, projective, ambient",
    ),
    "great circle": (
        lambda: regular_polygon(4, 1.6, curvature=1.0),
        "4 sides of 1.6, at least a great circle",
    ),
    "triangle": (lambda: triangle(2.5, 2.0, 2.0, curvature=1.0), "at least a great circle"),
    "side": (
        lambda: from_sides([3.2, 1.0], [1.0], curvature=1.0),
        "side 0 of the polygon is 3.2, at least half",
    ),
    "half": (
        lambda: from_sides([1.5] * 4, [3.0] * 3, curvature=1.0),
        "corner 1 of the polygon does not lie in a common hemisphere with the others",
    ),
    "angle": (
        lambda: from_sides([1.0] * 3, [1.0, 7.0]),
        "angle 1 of the polygon is 7.0, not between 0 and 2 pi",
    ),
    "words": (lambda: from_sides(["a"] * 3, [1.0]), "the sides and the angles are not lists of numbers"),
    "curvature": (lambda: triangle(1, 1, 1, curvature="x"), "the curvature of space is 'x', not a finite"),
    "count": (
        lambda: from_sides([1.0] * 3, [1.0] * 3),
        "there are sides of shape (3,) and angles of shape (3,): a polygon with n sides takes n - 1 sides",
    ),
}


@pytest.mark.parametrize(("make", "sentence"), REFUSALS.values(), ids=REFUSALS.keys())
def test_refusals(make, sentence):
    with pytest.raises((InvalidMetric, InvalidParameter), match=re.escape(sentence)):
        make()


def test_paper_is_flat():
    solid = regular_solid("cube", -1.0, np.radians(80.0))
    metric = PolyhedralMetric.from_mesh(solid.points, solid.faces, curvature=-1.0)
    assert deficits(metric).min() > 0
    surface = Embedding(metric, solid.points, method="given", tolerance=1e-10)
    with pytest.raises(InvalidMetric, match="the surface is in hyperbolic space: paper is flat"):
        unfold(surface)
