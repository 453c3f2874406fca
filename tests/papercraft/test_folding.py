"""Nets folded by a share of their angles: flat, rigid, shut; and the page that shows it."""

import base64
import json
import re
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from scipy.spatial.distance import pdist

import solids
import zoo
from isoembed import Embedding, InvalidParameter, PolyhedralMetric, unfold
from isoembed.papercraft import partly_folded
from isoembed.papercraft.folding_page import FRAMES

L_PRISM = (
    [[x, y, z] for z in (0, 1) for x, y in ((0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2))],
    [[5, 4, 3, 2, 1, 0], [6, 7, 8, 9, 10, 11], *([k, (k + 1) % 6, 6 + (k + 1) % 6, 6 + k] for k in range(6))],
)
BODIES = {
    "cube": zoo.cube(),
    "icosahedron": (solids.uniform("icosahedron"), solids.polygons(solids.uniform("icosahedron"))),
    "hull": zoo.random_hull(15, 4),
    "L": L_PRISM,
}


@pytest.fixture(params=BODIES.values(), ids=BODIES)
def body(request):
    return request.param


def test_flat_rigid_and_shut(body):
    net = unfold(body)
    flat, faces = partly_folded(net, 0.0)
    np.testing.assert_array_equal(flat[:, 2], 0.0)
    np.testing.assert_allclose(flat[:, :2], np.concatenate(net.sheets), atol=1e-12)
    for share in (0.3, 0.8, 1.0):
        vertices, same = partly_folded(net, share)
        for face, other in zip(faces, same, strict=True):
            np.testing.assert_array_equal(face, other)
            np.testing.assert_allclose(pdist(vertices[face]), pdist(flat[face]), atol=1e-12)
    of_solid = np.concatenate(net.corners)
    points = np.array(body[0], dtype=float)
    np.testing.assert_allclose(pdist(vertices), pdist(points[of_solid]), atol=1e-12)  # all of it is shut


def test_angles_grow_with_the_share():
    net = unfold(zoo.cube())
    vertices, faces = partly_folded(net, 0.5)
    a, b = faces[0], next(face for face in faces[1:] if len(set(face) & set(faces[0])) == 2)
    one, other = (np.cross(vertices[f[1]] - vertices[f[0]], vertices[f[2]] - vertices[f[1]]) for f in (a, b))
    assert one @ other / np.linalg.norm(one) / np.linalg.norm(other) == pytest.approx(np.cos(np.pi / 4))
    assert (vertices[:, 2] <= 1e-12).all()  # the outside is up, so that the cube hangs down


def test_the_page_has_the_film_and_the_net(body, tmp_path):
    path = tmp_path / "net.html"
    net = unfold(body)
    net.save(path, paper="A3")
    text = path.read_text(encoding="utf-8")
    assert text.count('"stage": "folding"') == FRAMES - 1 and '"stage": "answer"' in text
    [picture] = re.findall(r'src="data:image/svg\+xml;base64,([^"]+)"', text)
    assert ElementTree.fromstring(base64.b64decode(picture)).get("width") == "297mm"
    assert str(net) in text
    [data] = re.findall(r'href="data:application/json;base64,([^"]+)"', text)
    told = json.loads(base64.b64decode(data))
    surface = embed_given(body)
    assert told["net"] == {"sheets": 1, "pairs_of_sides": len(net.sides), "folds": len(net.folds[0])}
    assert told["solid"]["vertices"] - told["solid"]["edges"] + told["solid"]["faces"] == 2
    assert told["solid"]["vertices"] == len(body[0])
    assert told["solid"]["area"] == pytest.approx(surface.area, rel=1e-12)
    assert told["solid"]["volume"] == pytest.approx(surface.volume, rel=1e-12)
    assert "ertificate" not in text and "deficit" not in text.partition("<script")[0]  # those of a net


def embed_given(body):
    """The surface with the vertices of a body."""
    return Embedding(PolyhedralMetric.from_mesh(*body), body[0], method="given", tolerance=1e-10)


def test_the_page_of_a_net_with_a_narrow_slit(tmp_path):
    """Corners at its mouth are no seam."""
    ring = [[np.cos(t), np.sin(t), 0.0] for t in np.linspace(0, 2 * np.pi, 6, endpoint=False)]
    flat = [*ring, [0.0, 0.0, 1e-3], [0.0, 0.0, -1.0]]
    faces = [[k, (k + 1) % 6, 6] for k in range(6)] + [[(k + 1) % 6, k, 7] for k in range(6)]
    net = unfold((flat, faces), keep=[(k, 6) for k in range(1, 6)])  # cut from vertex 6 to vertex 0 alone
    assert 0 < pdist(np.concatenate(net.sheets)).min() < 1e-5
    net.save(tmp_path / "net.html")


def test_a_share_that_is_no_number():
    with pytest.raises(InvalidParameter, match="the fraction of the fold angles is nan, not a finite number"):
        partly_folded(unfold(zoo.cube()), np.nan)


def test_a_net_of_several_sheets_has_no_page(tmp_path):
    with pytest.raises(
        InvalidParameter, match="the net has 6 sheets: a page shows the folding of a single sheet"
    ):
        unfold(zoo.cube(), objective="faces").save(tmp_path / "net.html")
