"""Energies of surfaces that are given as triangles and lengths: fourth order, honest errors, refusals."""

from functools import cache

import numpy as np
import pytest

from isoembed import embed
from isoembed.errors import InvalidParameter
from isoembed.relativity import KerrNewmanSphere, mesh_energies
from isoembed.smooth import triangulate_metric

SCHWARZSCHILD, KERR = KerrNewmanSphere(3.0), KerrNewmanSphere(3.0, 1.0, 0.8)
AREA = {SCHWARZSCHILD: 36.0 * np.pi, KERR: 120.12242026143980}
CURVATURE = {SCHWARZSCHILD: 12.0 * np.pi, KERR: 38.873468325120506}
BROWN_YORK = {SCHWARZSCHILD: 3.0 - np.sqrt(3.0), KERR: 1.2196541460073282}
BOTH = pytest.mark.parametrize("surface", [SCHWARZSCHILD, KERR], ids=["Schwarzschild", "Kerr"])


@cache
def embedded(surface, vertices):
    mesh = triangulate_metric(surface, vertices)
    return mesh.directions, embed(mesh.metric)


def energies(surface, vertices, **options):
    u, embedding = embedded(surface, vertices)
    return mesh_energies(embedding, surface.mean_curvature(u), lengths="geodesic", **options)


@BOTH
def test_energies_are_of_fourth_order_and_within_their_errors(surface):
    sizes = (400, 1600)
    misses = {"area": [], "integrated_mean_curvature": [], "brown_york": []}
    for n in sizes:
        found = energies(surface, n)
        for name, exact in zip(misses, (AREA, CURVATURE, BROWN_YORK), strict=True):
            estimate = getattr(found, name)
            miss = abs(estimate.value - exact[surface])
            assert miss <= estimate.error <= 1e-2 * exact[surface]
            misses[name].append(miss / exact[surface])
        assert found.liu_yau.value == pytest.approx(found.brown_york.value, rel=1e-12)  # p = 0
        assert found.error_estimate >= found.brown_york.error
    for coarse, fine in misses.values():
        assert fine < 1e-4
        # A quarter of the area of a triangle is half an edge: at fourth order a sixteenth of the error.
        assert np.log(coarse / fine) / np.log(2.0) > 3.3


def test_hawking_and_christodoulou():
    found = energies(SCHWARZSCHILD, 400, angular_momentum=0.0)
    assert abs(found.hawking.value - 1.0) <= found.hawking.error < 1e-2
    assert abs(found.irreducible_mass.value - 1.5) <= found.irreducible_mass.error < 1e-3
    assert found.christodoulou_mass.value == pytest.approx(found.irreducible_mass.value, rel=1e-14)
    charged = energies(SCHWARZSCHILD, 400, angular_momentum=2.0, charge=0.5)
    m = charged.irreducible_mass.value
    assert charged.christodoulou_mass.value == pytest.approx(np.hypot(m + 0.0625 / m, 1.0 / m), rel=1e-14)


@pytest.mark.parametrize("unit", [1e-60, 1e60])
def test_the_unit_of_length_does_not_count(unit):
    u, embedding = embedded(KERR, 400)
    scaled = embed(embedding.metric.with_lengths(unit * embedding.metric.lengths))
    found = mesh_energies(scaled, KERR.mean_curvature(u) / unit, lengths="geodesic")
    for name in ("hawking", "brown_york", "liu_yau", "irreducible_mass"):
        ours, theirs = getattr(found, name), getattr(energies(KERR, 400), name)
        assert ours.value / unit == pytest.approx(theirs.value, rel=1e-7)
        assert ours.error / unit == pytest.approx(theirs.error, rel=1e-3)


def test_the_momentum_counts_by_its_square():
    """Schwarzschild in a flat slice: k = 2 / r, and only the Kijowski-Liu-Yau energy sees p."""
    u, embedding = embedded(SCHWARZSCHILD, 400)
    k, p = np.full(len(u), 2.0 / 3.0), np.full(len(u), 2.0 * np.sqrt(2.0 / 3.0) / 3.0)
    found, other = (mesh_energies(embedding, k, q, lengths="geodesic") for q in (p, -p))
    assert abs(found.brown_york.value) <= found.brown_york.error
    assert abs(found.liu_yau.value - BROWN_YORK[SCHWARZSCHILD]) <= found.liu_yau.error
    assert abs(found.hawking.value - 1.0) <= found.hawking.error
    assert found.liu_yau == other.liu_yau and found.notes == ()


def test_chords_are_other_lengths_than_geodesics():
    u, embedding = embedded(SCHWARZSCHILD, 400)
    chords = mesh_energies(embed(embedding.metric.with_lengths(chord_lengths(u, embedding))), lengths="chord")
    assert abs(chords.area.value - AREA[SCHWARZSCHILD]) <= chords.area.error
    wrong = mesh_energies(embedding, lengths="chord")
    assert abs(wrong.area.value - AREA[SCHWARZSCHILD]) > 10.0 * abs(chords.area.value - AREA[SCHWARZSCHILD])


def test_lengths_of_which_it_is_not_said_what_they_are():
    u, embedding = embedded(SCHWARZSCHILD, 400)
    chords = embed(embedding.metric.with_lengths(chord_lengths(u, embedding)))
    for given in (embedding, chords):
        found = mesh_energies(given)
        assert abs(found.area.value - AREA[SCHWARZSCHILD]) <= found.area.error
        assert (
            abs(found.integrated_mean_curvature.value - CURVATURE[SCHWARZSCHILD])
            <= found.integrated_mean_curvature.error
        )


def moving(u):
    """k and p of Schwarzschild in a flat slice."""
    return np.full(len(u), 2.0 / 3.0), np.full(len(u), 2.0 * np.sqrt(2.0 / 3.0) / 3.0)


def misses(found, exact):
    """True errors over stated ones, by name."""
    return {
        name: abs(getattr(found, name).value - value) / getattr(found, name).error
        for name, value in exact.items()
    }


FLAT = {"hawking": 1.0, "brown_york": 0.0, "liu_yau": BROWN_YORK[SCHWARZSCHILD]}


@pytest.mark.parametrize("noise", [1e-4, 1e-2, pytest.param(0.1, marks=pytest.mark.slow)])
def test_noise_of_k_and_p_at_the_vertices(noise):
    """It averages out in int k, but not in the squares and not in their root."""
    u, embedding = embedded(SCHWARZSCHILD, 400)
    k, p = moving(u)
    worst = 0.0
    for seed in range(10):
        draw = np.random.default_rng(seed).normal(size=(2, len(u)))
        found = mesh_energies(embedding, k + noise * draw[0], p + noise * draw[1], lengths="geodesic")
        assert found.brown_york.error < max(3e-3, noise)
        worst = max(worst, *misses(found, FLAT).values())
    assert 0.1 < worst < 1.0 or (noise < 1e-3 and worst < 1.0)


@pytest.mark.parametrize("size", [0.2, 3.0])
def test_one_vertex_is_wrong(size):
    u, embedding = embedded(SCHWARZSCHILD, 400)
    k, p = moving(u)
    k[11] *= 1.0 + size
    found = mesh_energies(embedding, k, p, lengths="geodesic")
    assert max(misses(found, FLAT).values()) < 1.0


def test_noise_where_the_mean_curvature_vector_is_nearly_null():
    """k^2 - p^2 is below zero at vertices, by noise, and has a root for all that."""
    u, embedding = embedded(SCHWARZSCHILD, 400)
    rng = np.random.default_rng(2)
    k, p = np.full(len(u), 1.0), np.full(len(u), 1.0 - 1e-4)
    norm = AREA[SCHWARZSCHILD] * np.sqrt(2e-4 - 1e-8)
    exact = CURVATURE[SCHWARZSCHILD] / (4.0 * np.pi) - norm / (8.0 * np.pi)
    found = mesh_energies(embedding, k + 1e-3 * rng.normal(size=len(u)), p, lengths="geodesic")
    assert found.notes == () and abs(found.liu_yau.value - exact) <= found.liu_yau.error < 1.0


def chord_lengths(u, embedding):
    i, j = embedding.metric.edges.T
    return 3.0 * np.linalg.norm(u[i] - u[j], axis=1)


def test_without_k_the_area_remains():
    _, embedding = embedded(KERR, 400)
    found = mesh_energies(embedding, lengths="geodesic")
    assert found.hawking is found.brown_york is found.liu_yau is found.christodoulou_mass is None
    assert found.notes == ("k is not given: the irreducible mass is the only energy",)
    assert (
        abs(found.integrated_mean_curvature.value - CURVATURE[KERR]) <= found.integrated_mean_curvature.error
    )


def test_where_the_mean_curvature_vector_is_not_spacelike_there_is_no_liu_yau_energy():
    u, embedding = embedded(SCHWARZSCHILD, 400)
    k, p = np.ones(len(u)), np.zeros(len(u))
    p[7] = 2.0
    found = mesh_energies(embedding, k, p)
    assert found.liu_yau is None and found.brown_york is not None and found.hawking is not None
    assert found.notes[0].startswith("k^2 - p^2 = -3 < 0 at vertex 7: the mean curvature vector is not space")


@pytest.mark.parametrize(
    ("k", "p", "sentence"),
    [
        (np.ones(7), None, r"the mean curvature has the shape \(7,\): there are 400 vertices, so it must be"),
        (np.ones((400, 1)), None, r"the mean curvature has the shape \(400, 1\)"),
        (
            np.ones(400),
            0.0,
            r"the momentum has the shape \(\): there are 400 vertices, so it must be \(400,\)",
        ),
        (None, np.ones(400), "the momentum requires the mean curvature"),
        (np.where(np.arange(400) == 3, np.nan, 1.0), None, "at vertex 3"),
        (np.ones(400), np.where(np.arange(400) == 5, np.inf, 0.0), "at vertex 5"),
    ],
)
def test_refusals(k, p, sentence):
    _, embedding = embedded(SCHWARZSCHILD, 400)
    with pytest.raises(InvalidParameter, match=sentence):
        mesh_energies(embedding, k, p)


def test_kinds_of_lengths_that_there_are_not():
    _, embedding = embedded(SCHWARZSCHILD, 400)
    with pytest.raises(InvalidParameter, match="lengths"):
        mesh_energies(embedding, lengths="secant")


@pytest.mark.parametrize(("unit", "area"), [(1e200, "inf"), (1e-200, "0.0")])
def test_a_unit_in_which_the_area_is_no_number(unit, area):
    metric = triangulate_metric(SCHWARZSCHILD, 60).metric
    embedding = embed(metric.with_lengths(unit * metric.lengths))
    with pytest.raises(InvalidParameter, match=f"the area is {area}, beyond the range of numbers"):
        mesh_energies(embedding)
