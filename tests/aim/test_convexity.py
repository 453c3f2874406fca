"""The convexity routine: a dent is popped to its mirror image, the printed sign deepens it, and the guard."""

import numpy as np
import pytest

import zoo
from isoembed.aim.anneal import Annealed
from isoembed.aim.convexity import PRINTED, crumpled_vertices, reflect_and_anneal, reflected
from isoembed.mesh.triangulation import Triangulation


def dented(n, height):
    """A regular bipyramid whose upper apex stands at this height above (below, if negative) its rim."""
    angle = 2 * np.pi * np.arange(n) / n
    rim = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    vertices = np.vstack([rim, [[0, 0, height], [0, 0, -3]]])
    faces = [[k, (k + 1) % n, n] for k in range(n)] + [[(k + 1) % n, k, n + 1] for k in range(n)]
    return Triangulation(faces), vertices


@pytest.mark.parametrize("n", [3, 5, 6, 9])
def test_a_dent_is_inverted_and_popped_to_its_mirror_image(n):
    triangulation, vertices = dented(n, -0.3)
    inverted, partial = crumpled_vertices(triangulation, vertices)
    assert np.flatnonzero(inverted).tolist() == [n]
    assert not partial.any()
    after = reflected(triangulation, vertices, inverted)
    assert after == pytest.approx(dented(n, 0.3)[1], abs=1e-15)
    assert not crumpled_vertices(triangulation, after)[0].any()


def test_the_printed_sign_pushes_it_further_in():
    triangulation, vertices = dented(6, -0.3)
    inverted, _ = crumpled_vertices(triangulation, vertices)
    after = reflected(triangulation, vertices, inverted, PRINTED)
    assert after == pytest.approx(dented(6, -0.9)[1], abs=1e-15)
    assert crumpled_vertices(triangulation, after)[0][6]


def test_only_the_chosen_vertices_move_across_the_mean_of_their_neighbors():
    vertices, faces = zoo.random_hull(20, 0)
    triangulation = Triangulation(faces)
    which = np.arange(20) == 7
    after = reflected(triangulation, vertices, which)
    assert (after[~which] == vertices[~which]).all()
    neighbors = sorted(set(faces[(faces == 7).any(axis=1)].ravel()) - {7})
    assert (after[7] + vertices[7]) / 2 == pytest.approx(vertices[neighbors].mean(axis=0), abs=1e-15)


def test_partially_inverted_vertices_are_popped_too():
    # One rim vertex of a dent pulled down until its spoke is a ridge; most of the others stay valleys.
    triangulation, vertices = dented(9, -0.3)
    vertices[0, 2] = -0.4
    inverted, partial = crumpled_vertices(triangulation, vertices)
    assert not inverted.any()
    assert np.flatnonzero(partial).tolist() == [9]
    guesses = []

    def relax(guess):
        guesses.append(guess)
        return Annealed(guess, 0.0, True)

    after = reflect_and_anneal(triangulation, Annealed(vertices, 0.0, True), relax)
    assert (after.vertices == reflected(triangulation, vertices, partial)).all()
    assert (after.vertices[9] != vertices[9]).any()


def guarded(height, candidate, residual, converged, before=1e-3):
    """What the routine keeps when annealing the popped surface ends so."""
    triangulation, vertices = dented(6, height)
    start = Annealed(vertices, before, False)
    seen = []

    def relax(guess):
        seen.append(guess)
        return Annealed(dented(6, candidate)[1], residual, converged)

    return reflect_and_anneal(triangulation, start, relax) is not start, seen


def test_the_guard():
    kept, seen = guarded(-0.3, 0.3, 1e-9, True)
    assert kept
    assert len(seen) == 1
    assert seen[0] == pytest.approx(dented(6, 0.3)[1], abs=1e-15)
    assert guarded(-0.3, 0.3, 1e-2, True)[0]  # converged by its own criterion
    assert guarded(-0.3, 0.3, 1e-3, False)[0]  # no worse than before
    assert not guarded(-0.3, 0.3, 2e-3, False)[0]  # worse than before
    assert not guarded(-0.3, -0.3, 1e-9, True)[0]  # no better for it


def test_a_convex_surface_is_not_annealed_again():
    kept, seen = guarded(0.3, 0.3, 1e-9, True)
    assert not kept
    assert not seen
