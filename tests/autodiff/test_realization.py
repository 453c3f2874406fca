"""Vertices as a differentiable function of lengths: by NumPy, by JAX and by PyTorch."""

import numpy as np
import pytest

import discs
import isoembed
from isoembed.autodiff.realization import Realization
from isoembed.gallery import Ellipsoid, triangulate


@pytest.fixture(scope="module")
def surface():
    return isoembed.embed(isoembed.PolyhedralMetric.from_mesh(*triangulate(Ellipsoid((3.0, 2.0, 1.0)), 60)))


@pytest.fixture
def lengths(surface):
    return surface.metric.lengths * (1 + 1e-3 * np.random.default_rng(0).standard_normal(174))


def test_vertices_have_the_lengths(surface, lengths):
    x = Realization(surface)(lengths)
    a, b = surface.metric.edges.T
    assert np.allclose(np.linalg.norm(x[a] - x[b], axis=1), lengths, rtol=1e-12)
    assert np.abs(x - surface.vertices).max() < 0.1


def test_own_lengths_give_the_surface_itself(surface):
    x = Realization(surface)(surface.metric.lengths)
    assert np.abs(x - surface.vertices).max() < 1e-12


def test_derivatives_against_differences(surface, lengths):
    known, h = Realization(surface), 1e-5
    found = known.linearized(lengths)
    dl = np.random.default_rng(1).standard_normal(174)
    difference = (known(lengths + h * dl) - known(lengths - h * dl)) / (2 * h)
    velocity = found.jvp(dl)
    assert np.abs(velocity - difference).max() < 1e-6 * np.abs(velocity).max()
    g = np.random.default_rng(2).standard_normal(velocity.shape)
    assert np.isclose(np.sum(g * velocity), found.vjp(g) @ dl, rtol=1e-10)


def test_far_lengths_are_embedded_anew(surface):
    sphere = isoembed.PolyhedralMetric.from_mesh(
        triangulate(Ellipsoid((3.0, 2.0, 1.0)), 60)[0] / (3.0, 2.0, 1.0), surface.faces
    )
    x = Realization(surface)(sphere.lengths)
    a, b = sphere.edges.T
    assert np.allclose(np.linalg.norm(x[a] - x[b], axis=1), sphere.lengths, rtol=1e-9)


def test_refusals(surface):
    with pytest.raises(isoembed.InvalidParameter, match="the lengths have the shape"):
        Realization(surface)(np.ones(3))
    wrong = isoembed.Embedding(surface.metric, 2 * surface.vertices, method="given", tolerance=1e-10)
    with pytest.raises(isoembed.InvalidParameter, match="cannot start from this surface"):
        Realization(wrong)
    metric = isoembed.PolyhedralMetric(surface.faces, surface.metric.lengths, curvature=-0.1)
    with pytest.raises(isoembed.InvalidParameter, match="not in R"):
        Realization(isoembed.Embedding(metric, surface.vertices, method="given", tolerance=1e9))


def test_jax(surface, lengths):
    jax = pytest.importorskip("jax")
    jax.config.update("jax_enable_x64", True)
    from jax.test_util import check_grads

    from isoembed.autodiff.jax import realization

    vertices = realization(surface)

    def width(l):
        return (vertices(l)[:, 0] ** 2).sum()

    known = Realization(surface).linearized(lengths)
    gradient = np.asarray(jax.jit(jax.grad(width))(lengths))
    expected = known.vjp(2 * known.vertices * (1.0, 0.0, 0.0))
    assert np.allclose(gradient, expected, rtol=1e-12, atol=1e-12 * np.abs(expected).max())
    check_grads(width, (lengths,), order=1, modes=["rev"], eps=1e-5, rtol=1e-5)
    batch = np.stack([lengths, surface.metric.lengths])
    assert np.allclose(jax.vmap(jax.grad(width))(batch)[0], gradient, rtol=1e-10)


@pytest.fixture(scope="module", params=["heights", "curve"])
def sheet(request):
    points, faces = discs.hexagonal(2)
    x = discs.round_cap(points, 1.0)
    metric = isoembed.PolyhedralMetric.from_mesh(x, faces)
    [loop] = metric.triangulation.boundaries
    boundary = x[loop] if request.param == "curve" else 0.02 * np.cos(3 * np.arctan2(*x[loop, :2].T))
    return isoembed.embed(metric, boundary=boundary)


def test_jax_with_boundary(sheet):
    jax = pytest.importorskip("jax")
    jax.config.update("jax_enable_x64", True)
    from jax.test_util import check_grads

    from isoembed.autodiff.jax import realization

    vertices, known = realization(sheet), Realization(sheet)
    weights = np.random.default_rng(0).standard_normal(sheet.vertices.shape)
    lengths, boundary = sheet.metric.lengths, known.boundary
    assert np.allclose(vertices(lengths), sheet.vertices, atol=1e-9)

    def moment(l, b):
        return (weights * vertices(l, boundary=b)).sum()

    gradient = jax.jit(jax.grad(moment, argnums=1))(lengths, boundary)
    assert np.allclose(gradient, known.linearized(lengths).boundary_vjp(weights), atol=1e-9)
    check_grads(moment, (lengths, boundary), order=1, modes=["rev"], eps=1e-6, rtol=1e-5)


def test_torch_with_boundary(sheet):
    torch = pytest.importorskip("torch")
    from isoembed.autodiff.torch import realization

    vertices, known = realization(sheet), Realization(sheet)
    lengths = torch.tensor(np.stack([sheet.metric.lengths] * 2), requires_grad=True)
    boundary = torch.tensor(np.array(known.boundary), requires_grad=True)

    def moments(l, b):
        return (vertices(l, boundary=b) ** 2).sum(dim=-2)

    assert torch.autograd.gradcheck(moments, (lengths, boundary), eps=1e-6, atol=1e-5)
    assert np.allclose(vertices(lengths).detach()[0], sheet.vertices, atol=1e-9)


def test_torch(surface, lengths):
    torch = pytest.importorskip("torch")
    from isoembed.autodiff.torch import realization

    vertices = realization(surface)
    l = torch.tensor(np.stack([lengths, surface.metric.lengths]), requires_grad=True)

    def moments(l):
        return (vertices(l) ** 2).sum(dim=-2)

    assert torch.autograd.gradcheck(moments, (l,), eps=1e-5, atol=1e-5)
    with pytest.raises(TypeError, match=r"not torch\.float64"):
        vertices(l.float())
