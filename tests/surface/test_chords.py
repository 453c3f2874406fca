"""Chords of geodesics: circles, higher order, and polyhedra that are inscribed again, with K < 0 too."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import zoo
from isoembed.gallery import CassiniPeanut, HarmonicSurface, Sphere, triangulate
from isoembed.mesh.triangulation import Triangulation
from isoembed.smooth.geodesics import geodesic_lengths
from isoembed.smooth.two_metric import PulledBack
from isoembed.surface import alignment, measures
from isoembed.surface.chords import chord_lengths
from isoembed.surface.rigidity import LengthSystem, length_residuals
from isoembed.surface.shape_operator import shape_operators

STEP = 1e-3


def differential(surface):
    """Of the surface's points by their directions, by differences of sixth order."""

    def dX(u):
        columns = []
        for e in np.eye(3):
            ahead = [surface.point(u + k * STEP * e) - surface.point(u - k * STEP * e) for k in (1, 2, 3)]
            columns.append((45 * ahead[0] - 9 * ahead[1] + ahead[2]) / (60 * STEP))
        return np.stack(columns, axis=2)

    return dX


def measured(surface, n):
    """A triangulation, its vertices, the lengths of the geodesics and of the chords."""
    x, faces = triangulate(surface, n)
    t = Triangulation(faces)
    u = x / getattr(surface, "axes", (1.0, 1.0, 1.0))
    u /= np.linalg.norm(u, axis=1)[:, None]
    lengths = geodesic_lengths(PulledBack(differential(surface)), *u[t.edges.T])
    return t, x, lengths, measures.edge_lengths(t.edges, x)


def newton(triangulation, vertices, lengths):
    system, x = LengthSystem(triangulation), vertices
    for _ in range(8):
        x = x - system.step(x, lengths, length_residuals(triangulation, x, lengths))
    return x


def test_chords_of_a_sphere_are_those_of_circles():
    x, faces = zoo.icosphere(3)
    t = Triangulation(faces)
    chords = measures.edge_lengths(t.edges, x)
    arcs = 2 * np.arcsin(chords / 2)
    # As exact as the fitted curvature, of which the error is of higher order.
    assert np.abs(chord_lengths(t, x, arcs) / chords - 1).max() < 1e-2 * np.abs(arcs / chords - 1).max()
    normals = np.eye(3) - x[:, :, None] * x[:, None, :]
    assert np.allclose(chord_lengths(t, x, arcs, normals), chords, rtol=1e-6)


@pytest.mark.parametrize(
    "surface",
    [CassiniPeanut(a=0.8), HarmonicSurface(amplitude=0.2)],
    ids=lambda surface: surface.name,
)
def test_chords_are_right_to_fourth_order(surface):
    errors = []
    for n in (400, 1600):
        t, x, lengths, chords = measured(surface, n)
        errors.append(
            [np.sqrt(np.mean((l / chords - 1) ** 2)) for l in (lengths, chord_lengths(t, x, lengths))]
        )
    (geodesic, coarse), (_, fine) = errors
    assert coarse < geodesic / 5
    assert fine < coarse / 8


def test_polyhedra_with_corrected_lengths_are_inscribed():
    """Where K < 0 they would not be near the surface without: by more than it bulges out of their faces."""
    t, x, lengths, _ = measured(CassiniPeanut(a=0.8), 600)
    moved = alignment.distance(newton(t, x, lengths), x)
    assert alignment.distance(newton(t, x, chord_lengths(t, x, lengths)), x) < moved / 10


def test_a_first_solution_is_enough():
    """The chords from the embedding of the geodesic lengths themselves."""
    x, faces = triangulate(Sphere(), 600)
    t = Triangulation(faces)
    chords = measures.edge_lengths(t.edges, x)
    arcs = 2 * np.arcsin(chords / 2)
    found = chord_lengths(t, newton(t, x, arcs), arcs)
    assert np.sqrt(np.mean((found - chords) ** 2)) < np.sqrt(np.mean((arcs - chords) ** 2)) / 20


@settings(max_examples=8)
@given(size=st.sampled_from([1e-100, 0.3, 1e12, 1e100]), seed=st.integers(0, 1000))
def test_scales_and_motions(size, seed):
    x, faces = zoo.icosphere(2)
    t, x = Triangulation(faces), x * [1.0, 0.8, 0.6]
    l = 1.01 * measures.edge_lengths(t.edges, x)
    moved = size * (x @ zoo.rotation(seed).T + [1.0, 2.0, 3.0])
    assert np.allclose(chord_lengths(t, moved, size * l), size * chord_lengths(t, x, l), rtol=1e-9, atol=0)


def test_no_chord_is_longer_than_half_a_circle_allows():
    x, faces = zoo.icosahedron()
    t = Triangulation(faces)
    B = 100 * shape_operators(t, x) + 100 * np.eye(3)
    found = chord_lengths(t, x, np.ones(t.n_edges), B)
    assert np.allclose(found, 2 / np.pi)
