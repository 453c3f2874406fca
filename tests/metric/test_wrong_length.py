"""The length that is wrong where a triangle inequality is broken."""

from functools import cache

import numpy as np
import pytest

import zoo
from domes import dome
from isoembed import InvalidMetric, PolyhedralMetric
from isoembed.gallery import Cap, Ellipsoid, triangulate
from isoembed.metric.conformal import rescaled
from isoembed.metric.wrong_length import wrong_length


def metric_of(points, faces, size=1.0, curvature=0.0):
    metric = PolyhedralMetric.from_mesh(points, faces)
    metric = metric.scaled(size / metric.mean_length)
    return PolyhedralMetric(metric.faces, metric.lengths, metric.edges, curvature=curvature)


def typed(metric, edge, length, decimals=None):
    """Lengths with a wrong one, rounded."""
    lengths = np.array(metric.lengths if decimals is None else np.round(metric.lengths, decimals))
    lengths[edge] = length
    return lengths


def refusal(metric, lengths):
    with pytest.raises(InvalidMetric, match="breaks the triangle inequality") as caught:
        metric.with_lengths(lengths)
    with pytest.raises(InvalidMetric) as again:
        PolyhedralMetric(metric.faces, lengths, metric.edges, curvature=metric.curvature)
    assert str(again.value) == str(caught.value)
    return str(caught.value)


def sought(metric, lengths):
    return wrong_length(metric.faces, metric.triangulation.face_edges, lengths, metric.space)


def blunders(metric, rng, count):
    """Edges with wrong lengths that break a triangle inequality."""
    while count:
        e, factor = int(rng.integers(len(metric.lengths))), float(np.exp(rng.uniform(-3, 3)))
        lengths = typed(metric, e, factor * metric.lengths[e])
        try:
            metric.on(metric.triangulation, lengths, metric.space)
        except InvalidMetric:
            count -= 1
            yield e, lengths


@cache
def ellipsoid(curvature=0.0):
    return metric_of(*triangulate(Ellipsoid((3, 2, 1)), 120), curvature=curvature)


@cache
def cap():
    return metric_of(*triangulate(Cap(angle=1.2), 80))


BODIES = {
    "ellipsoid": ellipsoid,
    "in S^3": lambda: ellipsoid(0.3),
    "in H^3": lambda: ellipsoid(-0.3),
    "dome": lambda: metric_of(*dome(4)),
    "cap": cap,
    "hull": lambda: metric_of(*zoo.random_hull(80, 3)),
}


@pytest.mark.parametrize("body", BODIES.values(), ids=BODIES.keys())
def test_wrong_lengths_are_named_and_estimated(body):
    metric = body()
    rng = np.random.default_rng(1)
    off = []
    for e, lengths in blunders(metric, rng, 25):
        found, _ = sought(metric, lengths)
        assert found.edge == e
        low, high = found.interval
        assert low < metric.lengths[e] < high
        assert not low < lengths[e] < high
        off.append((found.estimate - metric.lengths[e]) / found.deviation)
    assert np.sqrt(np.mean(np.square(off))) < 1.5


def test_the_interval_proves_an_edge_of_two_broken_triangles():
    """Of a tetrahedron nothing is left to compare with: only the interval is said."""
    metric = metric_of(*zoo.tetrahedron())
    lengths = typed(metric, 3, 2.5)
    found, proved = sought(metric, lengths)
    assert (found.edge, found.interval, proved) == (3, (0.0, 2.0), True)
    ends = metric.edges[3].tolist()
    assert refusal(metric, lengths).endswith(
        f"; if one length is wrong, it is that of edge 3 {ends}: 2.5 where only less than 2 is possible"
    )


def test_a_regular_body_tells_the_length_exactly():
    metric = metric_of(*zoo.icosahedron())
    found, proved = sought(metric, typed(metric, 7, 3.0))
    assert proved
    assert found.estimate == pytest.approx(1.0, abs=1e-4)


def test_of_three_sides_of_one_broken_triangle_the_one_with_smooth_deficits_is_named():
    """A boundary edge is in one triangle: nothing but the deficits tells which side is wrong."""
    metric = cap()
    e = int(np.argmax(metric.triangulation.boundary_edges))
    found, proved = sought(metric, typed(metric, e, 3.0))
    assert (found.edge, proved) == (e, False)
    assert "if one length is wrong, it is probably that of edge" in refusal(metric, typed(metric, e, 3.0))


@pytest.mark.parametrize("size", [1e-150, 1e12])
def test_no_unit(size):
    metric = ellipsoid()
    lengths = typed(metric, 50, 3.0)
    one, _ = sought(metric, lengths)
    other, _ = sought(metric.scaled(size), size * lengths)
    assert other.edge == one.edge
    assert other.estimate / size == pytest.approx(one.estimate, rel=1e-6)
    assert other.deviation / size == pytest.approx(one.deviation, rel=1e-3)


DOME = metric_of(*dome(3), 27.0)
LENGTHS = np.round(DOME.lengths, 2)  # 23.81, 27.56, 28.17


@pytest.mark.parametrize("slip", ["{0[0]}{0[1]}{0[2]}.{0[3]}", "{0}", "9{0[1]}.{0[2]}{0[3]}"])
@pytest.mark.parametrize("e", [0, 20, 60, 100])
def test_slips(slip, e):
    """A decimal point that is misplaced or missing, and a wrong digit."""
    right = f"{LENGTHS[e]:.2f}"
    wrong = float(slip.format(right.replace(".", "")))
    said = refusal(DOME, typed(DOME, e, wrong, 2))
    assert f"edge {e} {DOME.edges[e].tolist()}: {wrong:.9g} where about" in said
    assert said.endswith(f"fits, probably typed for {float(right):.9g}")


def test_exchanged_digits():
    e = int(np.argmax(LENGTHS))
    assert LENGTHS[e] == 28.17
    assert refusal(DOME, typed(DOME, e, 82.17, 2)).endswith("fits, probably typed for 28.17")


def test_no_slip_explains_a_length():
    said = refusal(DOME, typed(DOME, 20, 317.0, 2))
    assert said.endswith("fits")


def test_nothing_is_said_of_two_wrong_lengths():
    metric = ellipsoid()
    lengths = typed(metric, [50, 200], [5.0, 7.0])
    assert "if one length is wrong" not in refusal(metric, lengths)


def test_nothing_is_said_of_computed_lengths():
    """A triangle without area has no wrong length, nor have conformal factors."""
    points, faces = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 1]]), zoo.tetrahedron()[1]
    with pytest.raises(InvalidMetric, match=r"its sides are 1\.0, 1\.0 and 2\.0$"):
        PolyhedralMetric.from_mesh(points, faces)
    metric = ellipsoid()
    factors = np.zeros(metric.triangulation.n_vertices)
    factors[metric.edges[50]] = 3.0
    with pytest.raises(InvalidMetric, match=r"breaks the triangle inequality: [^;]*$"):
        rescaled(metric, factors)


@pytest.mark.parametrize("curvature", [4.0, -1e6])
def test_a_wrong_length_beside_triangles_that_are_too_large(curvature):
    """Whatever other triangles do, the broken ones are refused; no single length is then wrong."""
    metric = ellipsoid()
    with pytest.raises(InvalidMetric, match=r"breaks the triangle inequality: [^;]*$"):
        PolyhedralMetric(metric.faces, typed(metric, 50, 3.0), metric.edges, curvature=curvature)
