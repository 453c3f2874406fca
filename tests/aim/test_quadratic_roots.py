"""All roots of quadratic equations: counted, compared with known ones and with a search of a grid."""

import itertools

import numpy as np
import pytest

from isoembed.aim.quadratic_roots import quadratic_roots


def random_system(k, seed):
    rng = np.random.default_rng(seed)
    Q = rng.normal(size=(k, k, k))
    return rng.normal(size=k), rng.normal(size=(k, k)), Q + Q.transpose(0, 2, 1)


def values(constant, slope, Q, s):
    return constant + s @ slope.T + np.einsum("ijk,...j,...k->...i", Q, s, s) / 2


@pytest.mark.parametrize("k", [1, 2, 3, 6, pytest.param(8, marks=pytest.mark.slow)])
def test_a_general_system_has_two_to_the_k_roots(k):
    system = random_system(k, 0)
    found = quadratic_roots(*system)
    assert found.complete
    assert found.at_infinity == 0
    assert found.roots.shape == (2**k, k)
    assert np.abs(values(*system, found.roots)).max() < 1e-9
    apart = np.linalg.norm(found.roots[:, None] - found.roots, axis=2) + np.eye(2**k)
    assert apart.min() > 1e-6
    # The coefficients are real: with each root comes its conjugate.
    conjugates = np.linalg.norm(found.roots[:, None] - found.roots.conj(), axis=2)
    assert conjugates.min(axis=1).max() < 1e-8


@pytest.mark.parametrize("seed", range(6))
def test_two_equations_against_their_resultant(seed):
    """Of ``f_i = A_i x^2 + B_i(y) x + C_i(y)``, the resultant by x vanishes at the y of the roots."""
    constant, slope, Q = random_system(2, seed)
    A = [np.poly1d([Q[i, 0, 0] / 2]) for i in (0, 1)]
    B = [np.poly1d([Q[i, 0, 1], slope[i, 0]]) for i in (0, 1)]
    C = [np.poly1d([Q[i, 1, 1] / 2, slope[i, 1], constant[i]]) for i in (0, 1)]
    ac, ab, bc = (p[0] * q[1] - q[0] * p[1] for p, q in ((A, C), (A, B), (B, C)))
    expected, found = (ac * ac - ab * bc).roots, quadratic_roots(constant, slope, Q).roots[:, 1]
    apart = np.abs(expected[:, None] - found)
    assert len(expected) == len(found) == 4
    assert max(apart.min(axis=0).max(), apart.min(axis=1).max()) < 1e-8


@pytest.mark.parametrize("seed", range(4))
def test_real_roots_against_a_search_of_a_grid(seed):
    """Newton's method from every point of a grid meets no real root that is not among those found."""
    rng = np.random.default_rng(seed)
    Q = rng.normal(size=(3, 3, 3))
    constant, slope, Q = 0.1 * rng.normal(size=3), np.eye(3), Q + Q.transpose(0, 2, 1)
    found = np.array(quadratic_roots(constant, slope, Q).near_real(1e-8))
    s = np.array(list(itertools.product(np.linspace(-3, 3, 13), repeat=3)))
    for _ in range(60):
        f = values(constant, slope, Q, s)
        s = s - np.linalg.solve(slope + np.einsum("ijk,nk->nij", Q, s), f[..., None])[..., 0]
    met = s[np.abs(values(constant, slope, Q, s)).max(axis=1) < 1e-10]
    assert len(met) > 100
    nearest = np.linalg.norm(met[:, None] - found, axis=2).argmin(axis=1)
    assert met == pytest.approx(found[nearest], abs=1e-6)
    assert len(np.unique(nearest)) == len(found)  # and it meets all of them


def test_known_roots():
    """``s_i^2 = i``: decoupled, all corners of a box."""
    Q = np.zeros((3, 3, 3))
    Q[range(3), range(3), range(3)] = 2
    found = quadratic_roots(-np.array([1.0, 2.0, 3.0]), np.zeros((3, 3)), Q).near_real(1e-8)
    corners = np.array(list(itertools.product((-1, 1), repeat=3))) * np.sqrt([1, 2, 3])
    assert np.sort(np.array(found), axis=0) == pytest.approx(np.sort(corners, axis=0))


def test_roots_at_infinity_and_multiple_roots_are_told():
    Q = np.zeros((2, 2, 2))
    Q[0, 0, 0] = 2
    lines = quadratic_roots(np.array([-1.0, 0.0]), np.array([[0, 0], [0, 1.0]]), Q)  # x^2 = 1, y = 0
    assert lines.at_infinity == 2
    assert np.sort(lines.roots.real, axis=0) == pytest.approx(np.array([[-1, 0], [1, 0]]), abs=1e-9)
    double = quadratic_roots(np.array([1.0]), np.array([[-2.0]]), np.array([[[2.0]]]))  # (x - 1)^2
    assert double.complete
    assert double.roots == pytest.approx(np.ones((2, 1)), abs=1e-3)
    (only,) = quadratic_roots(np.array([0.0]), np.array([[1.0]]), np.array([[[0.0]]])).near_real(1e-8)
    assert only == pytest.approx([0.0], abs=1e-12)


def test_a_pair_that_just_misses_being_real():
    nearly = quadratic_roots(np.array([1.01]), np.array([[-2.0]]), np.array([[[2.0]]]))  # (x - 1)^2 = -.01
    assert nearly.near_real(1e-8) == []
    (pair,) = nearly.near_real(0.3)
    assert pair == pytest.approx([1.0])
