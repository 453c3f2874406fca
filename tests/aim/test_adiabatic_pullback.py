"""Guided adiabatic pull-back: which guess each step gets."""

import numpy as np
import pytest

from isoembed.aim.adiabatic_pullback import pull_back
from isoembed.aim.anneal import Annealed

A, B, C = np.random.default_rng(0).normal(size=(3, 5, 3))


def quadratic(t):
    return A + B * t + C * t**2


@pytest.mark.parametrize("times", [np.linspace(1, 0, 8), np.array([1, 0.8, 0.7, 0.3, 0.29, 0.1, 0])])
def test_the_first_three_guesses_are_the_surface_before_and_then_it_extrapolates(times):
    guesses = []

    def relax(guess, t):
        guesses.append((t, guess))
        return Annealed(quadratic(t), 0.0, True)

    pulled = list(pull_back(quadratic(times[0]), times, relax))
    assert [t for t, _ in pulled] == [t for t, _ in guesses] == times[1:].tolist()
    assert all((annealed.vertices == quadratic(t)).all() for t, annealed in pulled)
    for j, (t, guess) in enumerate(guesses, start=1):
        if j <= 3:
            assert (guess == quadratic(times[j - 1])).all()
        else:
            assert guess == pytest.approx(quadratic(t), abs=1e-9)
            assert np.abs(guess - quadratic(times[j - 1])).max() > 1e-3


def test_from_the_fourth_step_it_is_the_last_three_surfaces_that_count():
    values = [1.0, 100.0, 3.0, 5.0, 4.0, 7.0]
    guesses = []

    def relax(guess, t):
        guesses.append(guess[0, 0])
        return Annealed(np.full((1, 3), values[len(guesses)]), 0.0, True)

    list(pull_back(np.full((1, 3), values[0]), [1.0, 0.8, 0.6, 0.4, 0.2, 0.0], relax))
    # Equal steps: 3 x(-1) - 3 x(-2) + x(-3).
    assert guesses == pytest.approx([1, 100, 3, 3 * 5 - 3 * 3 + 100, 3 * 4 - 3 * 5 + 3])
