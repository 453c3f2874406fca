"""``isoembed certify``: certificates of files, and files that do not go together."""

from pathlib import Path

import numpy as np
import pytest

import zoo
from isoembed import PolyhedralMetric
from isoembed.gallery import CassiniPeanut, triangulate
from isoembed.io import write_metric
from strict_json import strict

VERTICES, FACES = triangulate(CassiniPeanut(), 100)


@pytest.fixture
def files(call):
    """A metric, m.npz, and its surface, s.ply."""
    metric = PolyhedralMetric.from_mesh(VERTICES, FACES)
    write_metric("m.npz", metric)
    assert call("embed", "m.npz", "-o", "s.ply", "--report", "r.json")[0] == 0
    return metric


def test_what_was_embedded_is_certified(call, files):
    status, out, err = call("certify", "s.ply", "m.npz")
    assert (status, err) == (0, "")
    assert out.startswith("certified: a realization of these lengths is within ")
    found = strict(call("certify", "s.ply", "m.npz", "--json")[1])
    reported = strict(Path("r.json").read_text())["certificate"]
    assert found["certified"] is reported["certified"] is True
    assert found["embedded"] is True
    assert found["isolation"] == pytest.approx(reported["isolation"], rel=1e-3)
    assert found["isolation"] > 1e4 * found["radius"]
    status, out, _ = call("certify", "s.ply")  # by the distances of its vertices
    assert status == 0 and out.startswith("certified: ")


def test_lengths_that_are_missed(call, files):
    lengths = files.lengths * np.where(np.arange(len(files.lengths)) == 7, 1 + 1e-6, 1)
    write_metric("other.npz", files.with_lengths(lengths))
    status, out, _ = call("certify", "s.ply", "other.npz")
    assert status == 3
    assert out.startswith(f"not certified, because edge 7 {files.edges[7].tolist()} misses its length by ")


def test_files_that_do_not_go_together(call, files):
    write_metric("small.npz", PolyhedralMetric.from_mesh(*zoo.icosahedron()))
    status, _, err = call("certify", "s.ply", "small.npz")
    assert (status, err) == (
        2,
        "isoembed: error: s.ply has 100 vertices, small.npz has 12: a certificate is for the same triangles, "
        "with the same numbers of vertices\n",
    )
    turned = np.roll(np.arange(100), 1)
    write_metric("turned.npz", PolyhedralMetric.from_mesh(VERTICES[turned], np.argsort(turned)[FACES]))
    status, _, err = call("certify", "s.ply", "turned.npz")
    assert status == 2 and "of turned.npz is not in s.ply: a certificate is for the same triangles" in err
    write_metric("curved.npz", PolyhedralMetric.from_mesh(*zoo.icosahedron(), curvature=-0.1))
    status, _, err = call("certify", "s.ply", "curved.npz")
    assert status == 2 and "the triangles of curved.npz have the curvature -0.1" in err


def test_lengths_take_the_curvature_of_the_surface_where_they_say_none(call, files):
    vertices, faces = zoo.icosahedron()
    flat = PolyhedralMetric.from_mesh(vertices, faces)
    write_metric("flat.npz", flat)
    for k in ("-0.1", "-0.2"):
        assert call("embed", "flat.npz", "--space", f"hyperbolic={k}", "-o", f"h{k}.ply")[0] == 0
    assert call("certify", "h-0.1.ply", "flat.npz")[0] == 0
    write_metric("curved.npz", PolyhedralMetric(faces, flat.lengths, flat.edges, curvature=-0.1))
    assert call("certify", "h-0.1.ply", "curved.npz")[0] == 0
    status, _, err = call("certify", "h-0.2.ply", "curved.npz")
    assert status == 2 and "curved.npz is in hyperbolic space of curvature -0.1, not in that of cur" in err
