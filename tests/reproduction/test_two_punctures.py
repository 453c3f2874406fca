"""Bowen and York's slices of two holes on their axis."""

import numpy as np
import pytest

from isoembed.meshing.sphere import gauss_rule
from isoembed.relativity import BrillLindquist, find_horizon
from reproduction.bowen_york import appearance, by_quadrature, head_on
from reproduction.two_punctures import TwoPunctures


def test_holes_at_rest_are_those_of_brill_and_lindquist():
    slice_ = TwoPunctures.solved((0.3, 0.7), (0.0, 0.0), 0.6)
    known = BrillLindquist((0.3, 0.7), ((0, 0, 0.3), (0, 0, -0.3)))
    x = np.random.default_rng(0).standard_normal((20, 3))
    assert slice_.time_symmetric and slice_.mass == 1
    assert np.allclose(slice_.metric(x), known.metric(x), rtol=1e-14)
    assert np.allclose(slice_.gradient(x), known.gradient(x), rtol=1e-12)
    assert find_horizon(slice_).area == pytest.approx(find_horizon(known).area, rel=1e-12)


def test_slow_holes_tend_to_holes_at_rest_with_the_square_of_the_momentum():
    excess = np.array([head_on(P, 1.0).mass - 1 for P in (0.02, 0.04)])
    assert excess[1] / excess[0] == pytest.approx(4, rel=2e-3)


def test_the_constraint_holds_at_points_between_the_nodes():
    holes, h = head_on(0.5, 1.0), 2e-3
    x = np.random.default_rng(1).uniform(0.2, 1.5, (30, 3))
    steps = np.array([1, 2, 3])[:, None] * np.eye(3)[:, None] * h  # (axis, step, 3)
    weights = np.array([3 / 2, -3 / 20, 1 / 90])
    laplacian = (
        sum(
            w * (holes.correction(x + s) - 2 * holes.correction(x) + holes.correction(x - s))
            for axis in steps
            for w, s in zip(weights, axis, strict=True)
        )
        / h**2
    )
    A = holes.conformal_curvature(x)
    source = (A**2).sum(axis=(1, 2)) * holes.conformal_factor(x) ** -7 / 8
    assert np.abs(laplacian + source).max() < 1e-6 * source.max()


def test_the_mass_converges_spectrally_and_is_that_of_quadrature():
    masses = [TwoPunctures.solved((0.5, 0.5), (-0.2, 0.2), 1.0, n).mass for n in (8, 12, 16, 28)]
    errors = np.abs(np.array(masses[:-1]) - masses[-1])
    assert (errors[:-1] / errors[1:] > 30).all()
    holes = head_on(0.2, 1.0)
    assert by_quadrature(holes) == pytest.approx(holes.mass, abs=1e-13)
    assert holes.mass_by_falloff == pytest.approx(holes.mass, abs=1e-8)


def test_the_extrinsic_curvature_has_the_momentum_and_no_divergence():
    hole = TwoPunctures.solved((1.0, 0.0), (0.3, 0.0), 2.0)
    u, weights = gauss_rule(16, 32)
    flux = np.einsum("n,nij,nj->i", weights, hole.conformal_curvature(np.array([0, 0, 1.0]) + 3 * u), u)
    assert np.allclose(9 * flux / (8 * np.pi), [0, 0, 0.3], atol=1e-14)
    assert np.allclose(np.trace(hole.conformal_curvature(u), axis1=1, axis2=2), 0, atol=1e-14)


def test_the_errors_that_are_stated_cover_those_of_u():
    coarse, fine = (TwoPunctures.solved((0.5, 0.5), (-0.2, 0.2), 1.0, n) for n in (12, 28))
    x = np.random.default_rng(2).uniform(0.3, 1.0, (20, 3))
    stated = np.abs(coarse.error(lambda slice_: slice_.metric(x)[:, 0]))
    assert np.abs(coarse.metric(x) - fine.metric(x)).max() < 10 * stated.max() < 1e-3


@pytest.mark.slow
def test_the_common_horizon_of_holes_at_rest_appears_where_shooting_says():
    assert appearance(0.0) == pytest.approx(0.766197428240, abs=3e-9)
