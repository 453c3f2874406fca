"""Sentences on surfaces fitted to measured lengths, of fits that are made up."""

import numpy as np
import pytest

import isoembed
from isoembed import MeasuredSurface, MeshNote, PolyhedralMetric
from isoembed.gallery import Ellipsoid, triangulate

X, FACES = triangulate(Ellipsoid((1500.0, 1000.0, 800.0)), 100)
TRUE = PolyhedralMetric.from_mesh(X, FACES)


def fitted(noise, errors, *, weight=1.0, scatter=0.0, whole=True):
    """The true surface, as if it had been fitted to lengths with this noise."""
    lengths = np.round(TRUE.lengths + noise) if whole else TRUE.lengths + noise
    metric = TRUE.with_lengths(lengths).with_length_errors(errors)
    return MeasuredSurface(metric, X, method="aim", tolerance=1e-10, weight=weight, scatter=scatter)


def noise(sigma):
    return sigma * np.random.default_rng(0).standard_normal(len(TRUE.lengths))


def test_errors_that_are_not_understated_are_not_doubted():
    found = fitted(noise(3.0), 3.0, scatter=3.1 / TRUE.mean_length)
    assert found.converged
    assert found.message.endswith("(significance 0.001)")


def test_lengths_that_are_followed_do_not_test_their_errors():
    """Chi-square is then far below the number of edges: of a rough surface, or of errors that are larger."""
    sentence = "so closely that they do not tell whether the errors are right"
    smooth = "it is rough, or the errors are larger, about 1.4 if it is smooth, which length_errors=1.4 takes"
    found = fitted(noise(0.1), 0.5, scatter=1.4 / TRUE.mean_length, whole=False)
    assert sentence in found.message and smooth in found.message
    assert found._reported["measured"]["scatter"] == pytest.approx(1.4 / TRUE.mean_length)
    unknown = fitted(noise(0.1), 0.5, whole=False)
    assert sentence in unknown.message and "if it is smooth" not in unknown.message
    assert unknown._reported["measured"]["scatter"] is None
    assert sentence not in fitted(noise(0.5), 0.5, scatter=1.4 / TRUE.mean_length, whole=False).message


def test_errors_that_are_those_of_the_digits_are_said():
    sentence = "the errors, 0.29, are those of the last digit"
    for typed in (1 / np.sqrt(12), 0.289, 0.29):
        assert sentence in fitted(noise(0.1), typed).message
    assert "last digit" not in fitted(noise(0.1), 0.5).message
    few = TRUE.with_lengths(np.full(len(TRUE.lengths), 150.0)).with_length_errors(
        0.29
    )  # of one type of strut
    assert sentence in MeasuredSurface(few, X, method="aim", tolerance=1e-10, weight=1.0).message
    assert "last digit" not in fitted(noise(0.1), 0.29, whole=False).message


@pytest.mark.parametrize("unit", [1.0, 1e-3])
def test_a_length_that_stands_out_below_the_limit_is_named(unit):
    """What a fit leaves of a blunder that it has followed: four deviations, ten times the others."""
    off = noise(1.0)
    off[40] = 12.0
    found = fitted(off, 3.0, whole=False)
    metric = found.metric.scaled(unit)
    found = MeasuredSurface(metric, unit * X, method="aim", tolerance=1e-10, weight=1.0)
    assert found.converged
    given, fits = unit * (TRUE.lengths[40] + 12.0), unit * TRUE.lengths[40]
    edge, change = TRUE.edges[40].tolist(), f"{100 * (fits / given - 1):+.2g} %"
    named = f"if one length is wrong, it is probably that of edge 40 {edge} ({change}: from {given:.10g} to "
    assert named in found.message
    assert float(found.message.split(named)[1].split(")")[0]) == pytest.approx(fits, abs=unit)
    off[40] = 0.0
    assert "if one length is wrong" not in fitted(off, 3.0).message


def test_a_length_that_breaks_the_triangle_inequality_is_named_as_it_was_given():
    """It is changed within its error, which the metric says; the message has the length that was typed."""
    lengths, triangles = TRUE.lengths.copy(), TRUE.triangulation.face_edges
    three = triangles[0]
    lengths[three[0]] = lengths[three[1:]].sum() + 2.0
    with pytest.warns(MeshNote, match="changed within their errors"):
        metric = PolyhedralMetric(FACES, lengths, TRUE.edges, length_errors=3.0).scaled(2.0)
    assert metric.lengths[three[0]] < metric.given_lengths[three[0]] == 2.0 * lengths[three[0]]
    assert np.array_equal(metric.exact.given_lengths, metric.lengths)
    found = MeasuredSurface(metric, 2.0 * X, method="aim", tolerance=1e-10, weight=1.0)
    named = f"edge {three[0]} {TRUE.edges[three[0]].tolist()} ("
    assert f": from {2.0 * lengths[three[0]]:.10g} to " in found.message.split("check these lengths first")[1]
    assert named in found.message
    report = isoembed.report(found)
    assert report["residual"]["given_length"] == 2.0 * lengths[three[0]]
    [suspect] = report["measured"]["suspects"]
    assert suspect["predicted_length"] == pytest.approx(2.0 * TRUE.lengths[three[0]])


def test_exact_lengths_are_not_called_agreement():
    """A surface that has all lengths, where no fit agrees with them, has passed no test."""
    found = fitted(np.zeros(len(TRUE.lengths)), 3.0, weight=0.0, whole=False)
    assert found.converged
    assert found.message.startswith("the surface reproduces the given lengths together with their errors")
    assert "no smoother one was found that agrees with them" in found.message


def test_a_report_has_the_unit_and_the_largest_residual():
    off = noise(1.0)
    off[40] = 12.0
    found = fitted(off, 3.0, whole=False)
    report = isoembed.report(found)
    assert report["input"]["mean_length"] == pytest.approx(found.metric.mean_length)
    residual = report["residual"]
    assert residual["edge"] == TRUE.edges[40].tolist()
    assert residual["given_length"] - residual["length"] == pytest.approx(12.0)
    assert residual["max"] * report["input"]["mean_length"] == pytest.approx(12.0)


def test_exact_surfaces_of_rounded_lengths_say_how_to_have_error_bars():
    metric = TRUE.with_lengths(np.round(TRUE.lengths))
    hint = "; the lengths look rounded: length_errors=0.29 gives error bars"
    found = isoembed.embed(metric)
    assert not isinstance(found, MeasuredSurface)
    assert found.message.endswith(hint)
    assert "deviation" in isoembed.report(isoembed.embed(metric, length_errors=0.29))
    assert "look rounded" not in isoembed.embed(metric, length_errors=0).message
    assert "look rounded" not in isoembed.embed(TRUE).message


def test_the_scatter_of_a_rough_body_is_not_taken_for_errors():
    x, faces = triangulate(Ellipsoid((150.0, 120.0, 100.0)), 80)
    rough = PolyhedralMetric.from_mesh(x + 3 * np.random.default_rng(0).standard_normal(x.shape), faces)
    found = isoembed.embed(rough.with_lengths(np.round(rough.lengths, 3)), length_errors=0.001 / np.sqrt(12))
    assert found.scatter > 0.005
    assert "if it is smooth" not in found.message
    assert found.length_errors == pytest.approx(0.001 / np.sqrt(12))
