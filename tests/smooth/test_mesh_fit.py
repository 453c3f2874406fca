"""Harmonics fitted to meshes: exact where they can be, of high order elsewhere, with errors that hold."""

import numpy as np
import pytest

import mapped_shapes
from isoembed.errors import InvalidMetric
from isoembed.meshing.sphere import hull_faces
from isoembed.smooth.mesh_fit import fit_mesh
from isoembed.smooth.two_metric import angle_frame
from mapped_shapes import mesh


def shape_at(fit, u):
    """Normals (n, 3) and the mean curvatures k1 + k2 (n,) of a fit at u (n, 3)."""
    e = np.stack(angle_frame(u), axis=1)
    _, first, second = fit.harmonics.derivatives(u, fit.coefficients)
    a, b = np.moveaxis(e @ first.transpose(0, 2, 1), 1, 0)
    aa, ab, bb = (np.einsum("ni,ncij,nj->nc", e[:, i], second, e[:, j]) for i, j in ((0, 0), (0, 1), (1, 1)))
    n = np.cross(a, b)
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    E, F, G, L, M, N = (np.sum(v * w, axis=1) for v, w in ((a, a), (a, b), (b, b), (aa, n), (ab, n), (bb, n)))
    return n, -(E * N - 2 * F * M + G * L) / (E * G - F**2)


def errors(shape, n, seed=0):
    x, faces, v = mesh(shape, n, seed)
    fit = fit_mesh(x, faces)
    normals, k = shape_at(fit, fit.directions)
    expected, expected_k = mapped_shapes.differences(shape, v)
    return np.sqrt(np.mean((normals - expected) ** 2)), np.sqrt(np.mean((k - expected_k) ** 2))


def test_an_ellipsoid_is_found_in_harmonics_of_degree_one():
    x, faces, _ = mesh(mapped_shapes.ellipsoid, 300)
    fit = fit_mesh(x, faces)
    assert fit.misfit < 1e-14
    rest = fit.coefficients[fit.harmonics.labels[0] > 1]
    assert np.abs(rest).max(initial=0.0) < 1e-9
    axes = np.linalg.svd(fit.coefficients[fit.harmonics.labels[0] == 1], compute_uv=False)
    np.testing.assert_allclose(axes * np.sqrt(3 / (4 * np.pi)), [3.0, 2.0, 1.0], rtol=1e-9)
    u = fit.directions
    np.testing.assert_allclose(fit.harmonics.values(u) @ fit.coefficients, x, atol=1e-13)


@pytest.mark.parametrize("shape", [mapped_shapes.banana, mapped_shapes.bowl])
def test_normals_and_curvatures_converge_with_high_order(shape):
    coarse, fine = errors(shape, 200), errors(shape, 800)  # half of the mesh size
    for before, after in zip(coarse, fine, strict=True):
        assert after < before / 2**6
    assert fine[0] < 1e-5
    assert fine[1] < 1e-4


def test_noise_is_averaged():
    x, faces, _ = mesh(mapped_shapes.bowl, 500)
    noisy = x + 1e-3 * np.random.default_rng(1).normal(size=x.shape)
    fit, exact = fit_mesh(noisy, faces), fit_mesh(x, faces)
    assert 0.8e-3 < fit.misfit < 1e-3  # less by what was fitted
    off = fit.harmonics.values(fit.directions) @ fit.coefficients - x
    off = np.einsum("ni,ni->n", off, shape_at(exact, exact.directions)[0])
    assert np.sqrt(np.mean(off**2)) < 0.7e-3


def test_deviations_are_as_large_as_the_errors_or_larger():
    x, faces, _ = mesh(mapped_shapes.banana, 400)
    fit = fit_mesh(x, faces)
    u = fit.directions
    harmonics = type(fit.harmonics)(fit.harmonics.degree + 2, fit.harmonics.degree + 2)
    drawn = np.einsum("ns,dsi->dni", harmonics.values(u), fit.deviations)
    assert np.sqrt(np.mean(drawn**2)) > fit.misfit
    assert np.sqrt(np.mean(drawn**2)) < 1e3 * fit.misfit


def test_refusals():
    x, faces, _ = mesh(mapped_shapes.ellipsoid, 30)
    with pytest.raises(InvalidMetric, match="edge"):
        fit_mesh(x, faces[1:])
    x[1] = x[0]
    with pytest.raises(InvalidMetric):
        fit_mesh(x, faces)


def test_few_vertices_make_a_surface_through_them_nearly():
    u = np.concatenate([np.eye(3), -np.eye(3)])
    fit = fit_mesh(u, hull_faces(u))
    np.testing.assert_allclose(fit.harmonics.values(fit.directions) @ fit.coefficients, u, atol=1e-12)
