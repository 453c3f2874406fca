"""Certificates of discs with given boundary heights, of convex caps, and of surfaces that flex."""

import numpy as np
import pytest

import discs
import isoembed
from isoembed import InvalidMetric, PolyhedralMetric, embed
from isoembed.proof.boundary_heights import CapCertificate, certify
from isoembed.proof.certificate import certify as certify_lengths
from isoembed.surface.alignment import distance

PYRAMID = PolyhedralMetric([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]], [1.0] * 8)


def round_cap(mesh):
    x = discs.round_cap(mesh[0], 1.0)
    return x, PolyhedralMetric.from_mesh(x, mesh[1])


def test_the_exact_cap_is_within_the_radius():
    """The apex of four equilateral triangles is at the height of the root of 1/2."""
    proof = isoembed.certify(embed(PYRAMID, boundary="plane"))
    assert isinstance(proof, CapCertificate)
    assert proof.certified and proof.convex and proof.embedded
    exact = np.array([[1.0, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0], [0, 0, 1]]) / np.sqrt(2)
    for noise in (1e-15, 1e-12, 1e-10):
        moved = exact + noise * np.random.default_rng(0).normal(size=exact.shape)
        found = certify(PYRAMID, moved, np.zeros(4))
        assert distance(moved, exact) <= 2 * found.radius + 1e-15
        assert noise / 10 < found.radius < 100 * noise
    # The sine of the exterior angle between two of the triangles is the root of 8/9.
    assert 0.9 * np.sqrt(8 / 9) < proof.smallest_dihedral < np.arccos(1 / 3)


def test_no_other_realization_is_nearer_than_the_isolation():
    """A flat pyramid and the same one upside down."""
    for height in (0.02, 0.1, 0.5):
        x = np.array([[1.0, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0], [0, 0, height]])
        metric = PolyhedralMetric.from_mesh(x, PYRAMID.faces)
        found = certify(metric, x, np.zeros(4))
        assert found.certified
        assert 0.02 * 2 * height < found.isolation * metric.mean_length < 2 * height


@pytest.mark.parametrize("mesh", [discs.hexagonal(6), discs.irregular(200)], ids=["hexagonal", "irregular"])
@pytest.mark.parametrize("turned", [False, True])
def test_caps(mesh, turned):
    x, metric = round_cap(mesh)
    if turned:
        metric = PolyhedralMetric.from_mesh(x, mesh[1][:, ::-1])
    surface = embed(metric.scaled(7.3), boundary="plane")
    found = isoembed.certify(surface)
    assert found.certified and found.embedded
    assert found.radius < 1e-13 < 1e-3 < found.isolation
    # On irregular triangles it has concave edges: an exact one is near, and it is not the convex cap.
    assert found.convex == (None if surface.surface.concave_edges.any() else True)
    assert ("the convex cap, whose" in found.reason) == (found.convex is True)
    assert ("is concave: its exterior angle" in found.reason) == (found.convex is None)
    assert ("convex cap theorem" in found.evidence.basis) == (found.convex is True)
    vertices = surface.vertices.copy()
    vertices[3, 0] += 1e-6 * surface.metric.mean_length
    assert not certify(surface.metric, vertices, surface.heights).certified
    assert isoembed.report(surface)["certificate"]["certified"]


def test_given_heights():
    x, metric = round_cap(discs.hexagonal(5))
    [loop] = metric.triangulation.boundaries
    heights = 7 + 0.03 * np.cos(3 * np.arctan2(*x[loop, :2].T))
    surface = embed(metric, boundary=heights)
    found = isoembed.certify(surface)
    assert found.certified and found.convex is None
    assert "its boundary at these heights" in found.reason
    assert certify(metric, surface.vertices, heights).certified  # up to a constant
    off = heights.copy()
    off[5] += 1e-6
    reason = certify(metric, surface.vertices, off).reason
    assert reason.startswith(f"not certified, because vertex {loop[5]} of the boundary misses its height")


def test_a_chord_across_the_boundary_does_not_hide_convexity():
    """Two triangles at the boundary whose inner sides join vertices of it."""
    square = np.array([[1.0, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]])
    faces = [[0, 1, 4], [1, 2, 4], [2, 0, 4], [0, 2, 3]]
    metric = PolyhedralMetric.from_mesh(np.vstack([square, [[0.2, 0.4, 0.3]]]), faces)
    found = certify(metric, np.vstack([square, [[0.2, 0.4, 0.3]]]), np.zeros(4))
    # The chord (0, 2) is in the plane of the boundary: the surface there is flat, and the edge concave.
    assert found.certified and found.convex is None


def test_surfaces_that_flex_have_one_of_a_family_near():
    x, metric = round_cap(discs.hexagonal(4))
    found = certify_lengths(metric, x)
    assert found.certified and found.embedded and found.isolation is None
    assert f"in a family with {len(metric.triangulation.boundaries[0]) - 3} parameters" in found.reason
    assert isoembed.certify(embed(metric, boundary="free")).certified


def test_more_equations_than_unknowns_are_refused():
    x, metric = round_cap(discs.hexagonal(3))
    curve = embed(metric, boundary=x[metric.triangulation.boundaries[0]])
    torus = discs.torus(8, 6)
    for proof, more in (
        (isoembed.certify(curve), 15),
        (certify_lengths(PolyhedralMetric.from_mesh(*torus), torus[0]), 6),
    ):
        assert not proof.certified
        assert proof.reason.startswith(f"not certified: there are {more} more equations than unknowns")
    vertices, faces = discs.band(8, 2, lambda t: (1.0 + t, 0.5 * t))
    with pytest.raises(InvalidMetric, match="for discs in R"):
        certify(PolyhedralMetric.from_mesh(vertices, faces), vertices, np.zeros(16))


def test_a_flat_disc_has_no_certificate():
    points, faces = discs.hexagonal(3)
    x = np.column_stack([points, 0 * points[:, 0]])
    metric = PolyhedralMetric.from_mesh(x, faces)
    assert certify(metric, x, np.zeros(18)).reason.startswith(
        "not certified, because the lengths may not fix"
    )
