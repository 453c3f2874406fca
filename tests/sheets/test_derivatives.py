"""Derivatives of surfaces with boundary and of tori, against differences of surfaces found anew."""

import numpy as np
import pytest

import discs
from isoembed import InvalidMetric, InvalidParameter, PolyhedralMetric, Sensitivity, embed
from isoembed.autodiff.realization import Realization
from isoembed.io.surface import surface_of
from isoembed.sheets.nearby import nearby_sheet
from isoembed.surface.alignment import aligned

POINTS, FACES = discs.irregular(60, seed=3)
CAP = 7.3 * discs.round_cap(POINTS, 1.0)
METRIC = PolyhedralMetric.from_mesh(CAP, FACES)
[LOOP] = METRIC.triangulation.boundaries
HEIGHTS = 0.05 * np.cos(3 * np.arctan2(*CAP[LOOP, :2].T))
PYRAMID = PolyhedralMetric([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]], [1.0] * 8)
STEP = 1e-7


def torus():
    vertices, faces = discs.torus(12, 8)
    return embed(PolyhedralMetric.from_mesh(vertices, faces), boundary="free", start=vertices)


@pytest.fixture(scope="module", params=["plane", "heights", "curve", "free", "torus"])
def surface(request):
    boundary = {"heights": HEIGHTS, "curve": CAP[LOOP]}.get(request.param, request.param)
    return torus() if request.param == "torus" else embed(METRIC, boundary=boundary)


def changed(surface, dl, db, step):
    """Vertices, turned and moved onto those of the surface unless the boundary holds them."""
    metric = surface.metric.with_lengths(surface.metric.lengths + step * dl)
    boundary = Realization(surface).boundary
    given = boundary + step * db if boundary.size else None
    return nearby_sheet(surface, metric, given).vertices


def difference(surface, dl, db):
    ahead, behind = (changed(surface, dl, db, sign * STEP) for sign in (1, -1))
    if surface.condition != "curve":
        ahead, behind = (aligned(x, surface.vertices) for x in (ahead, behind))
    return (ahead - behind) / (2 * STEP)


def test_by_lengths(surface):
    rng, sensitivity = np.random.default_rng(0), Sensitivity(surface)
    dl = rng.standard_normal((2, len(surface.metric.lengths)))
    velocity = sensitivity.jvp(dl)
    found = difference(surface, dl[0], 0.0)
    moved = surface.vertices + STEP * velocity[0]
    expected = (
        velocity[0]
        if surface.condition == "curve"
        else (aligned(moved, surface.vertices) - surface.vertices) / STEP
    )
    assert np.abs(found - expected).max() < 1e-5 * np.abs(found).max()
    g = rng.standard_normal((3, *surface.vertices.shape))
    by_length = sensitivity.vjp(g)
    assert np.allclose(np.einsum("gvi,lvi->gl", g, velocity), by_length @ dl.T, rtol=1e-9, atol=1e-9)


def test_by_what_is_given_at_the_boundary(surface):
    rng, sensitivity = np.random.default_rng(1), Sensitivity(surface)
    shape = Realization(surface).boundary.shape
    if shape == (0,):
        for ask in (sensitivity.boundary_jvp, sensitivity.boundary_vjp):
            with pytest.raises(InvalidParameter, match="require heights or positions on the boundary"):
                ask(np.zeros(3))
        return
    db = rng.standard_normal((2, *shape))
    velocity = sensitivity.boundary_jvp(db)
    found = difference(surface, 0.0, db[0])
    if len(shape) == 2:
        assert np.array_equal(velocity[:, LOOP], db)
        assert np.abs(found - velocity[0]).max() < 1e-5 * np.abs(found).max()
    else:
        assert np.allclose(velocity[:, LOOP, 2], db, atol=1e-9)
    g = rng.standard_normal((3, *surface.vertices.shape))
    by_boundary = sensitivity.boundary_vjp(g)
    assert by_boundary.shape == (3, *shape)
    products = np.tensordot(by_boundary.reshape(3, -1), db.reshape(2, -1), axes=(1, 1))
    assert np.allclose(np.einsum("gvi,lvi->gl", g, velocity), products, rtol=1e-9, atol=1e-9)


def test_lengths_that_grow_alike_scale_the_surface(surface):
    """Nothing is given but the lengths, or what is given grows, too."""
    sensitivity, boundary = Sensitivity(surface), Realization(surface).boundary
    velocity = sensitivity.jvp(surface.metric.lengths)
    if boundary.size:
        velocity = velocity + sensitivity.boundary_jvp(boundary)
    expected = surface.vertices
    if surface.condition != "curve":
        expected = expected - expected.mean(axis=0)
        velocity = velocity - velocity.mean(axis=0)
    assert np.abs(velocity - expected).max() < 1e-5 * np.abs(expected).max()


def test_closed_form_of_a_pyramid():
    """Sides s and legs l: the apex is l^2 - s^2 / 2 high, the root of it."""
    surface = embed(PYRAMID, boundary="plane")
    inside = ~PYRAMID.triangulation.boundary_edges
    legs, sides = (Sensitivity(surface).jvp(mask.astype(float)) for mask in (inside, ~inside))
    height = np.sqrt(0.5)
    assert legs[4, 2] == pytest.approx(1 / height, rel=1e-12)
    assert sides[4, 2] == pytest.approx(-0.5 / height, rel=1e-12)
    raised = Sensitivity(surface).boundary_jvp(np.ones(4))
    assert raised[:, 2] == pytest.approx(np.ones(5), rel=1e-12)


def test_a_curve_that_does_not_fit_is_differentiated_as_least_squares():
    surface = embed(METRIC, boundary=CAP[LOOP])
    rng = np.random.default_rng(2)
    lengths = METRIC.lengths * (1 + 1e-3 * rng.standard_normal(len(METRIC.lengths)))
    known, dl = Realization(surface), rng.standard_normal(len(lengths))
    velocity = known.linearized(lengths).jvp(dl)
    found = (known(lengths + STEP * dl) - known(lengths - STEP * dl)) / (2 * STEP)
    assert np.abs(found - velocity).max() < 1e-5 * np.abs(found).max()


def test_realizations_have_what_is_given(surface):
    known = Realization(surface)
    lengths = surface.metric.lengths
    assert np.abs(known(lengths) - surface.vertices).max() < 1e-9
    if known.boundary.ndim == 1 and known.boundary.size:
        heights = known.boundary + 0.01 * np.cos(np.arange(len(LOOP)))
        x = known(1.001 * lengths, heights)
        assert np.allclose(x[LOOP, 2], heights, atol=1e-12)
        a, b = surface.metric.edges.T
        assert np.allclose(np.linalg.norm(x[a] - x[b], axis=1), 1.001 * lengths, rtol=1e-12)
    with pytest.raises(InvalidParameter, match="the data at the boundary have the shape"):
        known(lengths, np.zeros(2))


def test_refusals():
    given = surface_of({"vertices": CAP, "faces": FACES}, "it")
    with pytest.raises(InvalidMetric, match="unknown boundary condition"):
        Sensitivity(given).jvp(METRIC.lengths)
    start = np.random.default_rng(0).normal(size=CAP.shape)
    bent = embed(METRIC, boundary="free", start=start)
    if bent.imbalance > 1e-6:
        with pytest.raises(InvalidParameter, match="are balanced only to"):
            Sensitivity(bent).jvp(METRIC.lengths)
