"""Coordinates that were rounded: by what they are recognized, and what it does to deficits."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import zoo
from isoembed import Alexandrov, PolyhedralMetric, embed
from isoembed.errors import InvalidMetric
from isoembed.metric.convexity import DEVIATIONS, check_convex, deficit_spread
from isoembed.metric.curvature import deficits
from isoembed.metric.inspection import inspect
from isoembed.metric.precision import Precision, rounding_error, shared_errors

POINTS = 3 * np.random.default_rng(0).normal(size=(500, 3))
SINGLE = POINTS.astype("f4").astype(float)
BODIES = {
    "sphere": zoo.icosphere(3),
    "hull": zoo.random_hull(300, 1),
    "cut hull": zoo.subdivided(*zoo.subdivided(*zoo.random_hull(30, 1))),
    "cut cube": zoo.subdivided(*zoo.subdivided(*zoo.cube())),
    "needle": (zoo.icosphere(2)[0] * [1, 0.02, 0.01], zoo.icosphere(2)[1]),
    "far away": (zoo.icosphere(2)[0] + 100, zoo.icosphere(2)[1]),
}


def printed(points, form):
    return np.array([[float(form % x) for x in row] for row in points])


def turned(body):
    vertices, faces = BODIES[body]
    return vertices @ Rotation.random(random_state=1).as_matrix().T + 0.3, faces


@pytest.mark.parametrize(
    ("points", "name"),
    [
        (POINTS, None),
        (printed(POINTS, "%.10g"), None),
        (printed(POINTS, "%.9g"), "9 digits"),
        (printed(POINTS, "%.6g"), "6 digits"),
        (printed(POINTS, "%.4g"), None),
        (printed(POINTS, "%.6f"), "8 digits"),
        (printed(POINTS, "%.8f"), None),
        (np.round(100 * POINTS), None),
        (SINGLE, "single precision"),
        (np.round(8 * POINTS) / 8, None),
        (printed(SINGLE, "%.9g"), "single precision"),
        (printed(SINGLE, "%.8f"), "single precision"),
        (printed(SINGLE, "%.6g"), "6 digits"),
        (printed(1e-150 * POINTS, "%.7g"), "7 digits"),
        (np.zeros((4, 3)), None),
    ],
)
def test_what_coordinates_were_rounded_to(points, name):
    found = Precision.of(points, 1.0)
    assert (None if found is None else found.name) == name


@pytest.mark.parametrize("unit", [1e-150, 1.0, 1e12])
@pytest.mark.parametrize("form", ["%.6e", "%.5f"])
def test_the_error_of_lengths_is_that_of_the_rounding(unit, form):
    vertices, faces = turned("hull")
    exact = PolyhedralMetric.from_mesh(vertices, faces)
    metric = PolyhedralMetric.from_mesh(unit * printed(vertices, form), faces)
    if form == "%.5f" and unit != 1:
        metric = PolyhedralMetric.from_mesh(printed(vertices, form), faces).scaled(unit)
    errors = (metric.lengths / unit - exact.lengths) / exact.mean_length
    assert metric.precision.length_error == pytest.approx(np.sqrt(np.mean(errors**2)), rel=0.5)
    assert metric.normalized.precision is metric.scaled(3.0).precision is metric.precision
    assert metric.with_lengths(metric.lengths).precision is None


def test_few_digits_are_rounding_where_that_is_asked_for():
    points = zoo.random_hull(20, 1)[0].round(3)
    assert Precision.of(points, 1.0) is None
    found = Precision.of(points, 1.0, fewest=3)
    assert found is not None and found.vertex_error == pytest.approx(3**0.5 * 5e-4)
    assert Precision.of(points.round(1), 1.0, fewest=3) is None


def test_the_spread_of_deficits_is_that_of_random_errors():
    metric = PolyhedralMetric.from_mesh(*turned("hull"))
    rng, before, size = np.random.default_rng(2), deficits(metric), 1e-8
    off = [
        deficits(metric.with_lengths(metric.lengths + size * metric.mean_length * errors)) - before
        for errors in rng.normal(size=(400, len(metric.lengths)))
    ]
    spread = deficit_spread(metric.faces, metric.face_lengths, metric.triangulation.twins)
    np.testing.assert_allclose(np.sqrt(np.mean(np.square(off), axis=0)), size * spread, rtol=0.2)


@pytest.mark.parametrize("form", ["single", "%.6f", "%.6g"])
@pytest.mark.parametrize("body", BODIES)
def test_no_deficit_is_farther_off(body, form):
    vertices, faces = turned(body)
    rounded = vertices.astype("f4").astype(float) if form == "single" else printed(vertices, form)
    metric = PolyhedralMetric.from_mesh(rounded, faces)
    off = np.abs(deficits(metric) - deficits(PolyhedralMetric.from_mesh(vertices, faces)))
    spread = deficit_spread(metric.faces, metric.face_lengths, metric.triangulation.twins)
    noise = DEVIATIONS * metric.precision.length_error * spread
    assert (off <= noise).all() and off.max() > noise.max() / 300


def test_the_refusal_names_the_precision_and_the_repair():
    vertices, faces = turned("cut cube")
    metric = PolyhedralMetric.from_mesh(vertices.astype("f4"), faces)
    sentence = (
        r"the coordinates have single precision, which puts deficits off by up to \de-06; if deficits of .* "
        r"are noise, method=Alexandrov\(repair=(\S+)\) finds a polyhedron, with relative "
        r"length changes of at most \de-07"
    )
    with pytest.raises(InvalidMetric, match=sentence) as caught:
        embed(metric, method="alexandrov")
    level = float(str(caught.value).split("repair=")[1].split(")")[0])
    solid = embed(metric, method=Alexandrov(repair=level))
    assert solid.volume == pytest.approx(1, rel=1e-5)


def test_the_refusal_says_what_the_precision_does_not_explain():
    wrong = np.array([1.0, -1e-3, 1.0])
    spread = np.full(3, 1e-6)
    with pytest.raises(InvalidMetric, match=r"7 digits, which explains only 6e-06$"):
        check_convex(wrong, 1e-9, ("7 digits", spread))


def test_inspection_says_the_precision():
    metric = PolyhedralMetric.from_mesh(BODIES["sphere"][0].astype("f4"), BODIES["sphere"][1])
    assert "coordinates         rounded to single precision: that puts deficits off by up to" in str(
        inspect(metric)
    )
    assert 1e-8 < inspect(metric).report["coordinates"]["deficit_noise"] < 1e-5
    assert "coordinates" not in inspect(PolyhedralMetric.from_mesh(*BODIES["sphere"])).report


def test_equal_lengths_have_one_error_in_a_design_only():
    rng = np.random.default_rng(0)
    rounded = np.full(234, 0.01 / np.sqrt(12))
    few = rng.choice([1.23, 1.52, 2.01], 234)
    assert len(np.unique(shared_errors(few, rounded))) == 3
    assert len(np.unique(shared_errors(few, np.full(234, 0.0029)))) == 3  # as it is typed
    assert len(np.unique(shared_errors(few, np.full(234, 0.003)))) == 234  # an error of its own
    for errors in (2 * rounded, rounded * rng.uniform(0.9, 1.1, 234), 0 * rounded):
        assert len(np.unique(shared_errors(few, errors))) == 234
    measured = np.round(rng.uniform(0.8, 1.6, 234), 2)  # 81 places, so many are equal
    assert len(np.unique(measured)) <= 81
    assert len(np.unique(shared_errors(measured, rounded))) == 234
    assert len(np.unique(shared_errors(few + 1e-4, rounded))) == 234


@pytest.mark.parametrize("typed", [[], [0.5], [0.5, 0.25], [0.3, 0.4]])
def test_a_few_lengths_with_another_decimal_do_not_tell_the_digits_of_all(typed):
    lengths = np.round(np.random.default_rng(0).uniform(30, 90, 120))
    lengths[: len(typed)] += typed
    assert rounding_error(lengths) == pytest.approx(1 / np.sqrt(12) / lengths.mean(), rel=1e-12)


@pytest.mark.parametrize("decimals", [2, 3, 4, 9])
@pytest.mark.parametrize("step", [5, 2, 1, 0.5, 0.25, 0.2, 0.1, 1 / 8, 1 / 16])
def test_unit_of_lengths_in_any_fraction_typed_with_any_decimals(step, decimals):
    exact = np.random.default_rng(0).uniform(60 * step, 200 * step, 120)
    lengths = np.round(np.round(exact / step) * step, decimals)
    assert rounding_error(lengths) == pytest.approx(step / np.sqrt(12) / lengths.mean(), rel=1e-12)
    errors = np.full(len(lengths), step / np.sqrt(12))
    assert len(np.unique(shared_errors(lengths, errors))) == len(lengths)


def test_few_whole_lengths_are_measured_if_they_fill_their_range():
    measured = np.repeat(np.arange(36.0, 60.0), 4)  # a rock in millimeters
    assert rounding_error(measured) == pytest.approx(1 / np.sqrt(12) / measured.mean())
    mistyped = np.append(measured, 90.0)
    assert rounding_error(mistyped) == pytest.approx(1 / np.sqrt(12) / mistyped.mean())
    assert rounding_error(np.repeat(np.arange(36.0, 47.0), 10)) is None  # eleven different ones
    assert rounding_error(np.repeat(np.arange(30.0, 90.0, 3.0), 4)) is None  # a third of the range
    assert rounding_error(measured[::2]) is None  # 48 edges


def test_digits_of_points_count_unless_errors_are_given_or_the_points_come_from_lengths():
    x, faces = zoo.icosphere(1)
    metric = PolyhedralMetric.from_mesh(np.round(x, 5), faces)
    assert metric.point_rounding == metric.precision.length_error
    assert metric.scaled(3.0).point_rounding == pytest.approx(metric.point_rounding)
    for errors in (0.0, 1e-4):
        given = metric.with_length_errors(errors)
        assert given.precision == metric.precision  # which the faces of polyhedra need
        assert given.point_rounding is given.scaled(3.0).point_rounding is None
    assert len(metric.with_length_errors(0.0).tables) == len(metric.tables) + 1  # no checkpoint fits both
    computed = metric._knowing(precision=Precision.of_lengths(1e-3))
    assert computed.point_rounding is None
    assert computed.precision.origin == "computed from lengths with errors"
