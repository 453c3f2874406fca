"""Surfaces from lengths with errors, against the coordinates that the lengths came from."""

import re

import numpy as np
import pytest

import discs
import isoembed
import sharp_bodies
import solids
import zoo
from isoembed import (
    Aim,
    InvalidMetric,
    InvalidParameter,
    MeasuredSurface,
    NotEmbedded,
    PolyhedralMetric,
    embed,
)
from isoembed.aim.best_fit import BestFit
from isoembed.aim.measured_lengths import measured_surface
from isoembed.gallery import Bean, Ellipsoid, HarmonicSurface, triangulate
from isoembed.surface.alignment import distance
from johnson_solids import johnson
from rocks import ERROR, in_millimeters, rock


@pytest.mark.parametrize("seed", range(3))
def test_rocks_in_whole_millimeters(seed):
    x, faces = rock(seed, rough=1.5)
    metric = in_millimeters(x, faces)
    found = embed(metric, length_errors=ERROR)
    assert isinstance(found, MeasuredSurface)
    assert found.converged
    assert found.chi_square <= found.chi_square_limit
    assert distance(found.vertices, x) < 4.0  # a fit that is held at the true vertices: 2 to 3
    volume = np.einsum("fi,fi->", x[faces[:, 0]], np.cross(x[faces[:, 1]], x[faces[:, 2]])) / 6
    assert abs(found.volume - volume) < 3 * isoembed.Sensitivity(found).integral_deviation(ERROR).volume


def test_digits_are_seen_where_the_exact_surface_is_rough():
    """Seed 102 of these: the exact surface is crumpled, and 35 mm off."""
    x, faces = rock([102, 80])
    metric = in_millimeters(x, faces)
    exact = embed(metric, length_errors=0)
    assert not isinstance(exact, MeasuredSurface)
    assert exact.residual < 1e-10
    found = embed(metric)
    assert isinstance(found, MeasuredSurface)
    assert distance(found.vertices, x) < 4.0
    assert "last digit" in found.message
    assert [other.residual < 1e-10 for other in found.others] == [True]


def test_small_errors_leave_the_exact_surface_if_it_is_smoother():
    """The fit has a vertex on the wrong side of its neighbors, 0.3 of 150 off; both pass the test."""
    x, faces = triangulate(HarmonicSurface(degree=4, order=2, amplitude=0.15), 300, irregular=0)
    exact = PolyhedralMetric.from_mesh(150 * x, faces)
    noise = 3e-6 * np.random.default_rng(0).standard_normal(len(exact.lengths))
    found = embed(exact.with_lengths(exact.lengths + noise), length_errors=3e-6)
    assert found.chi_square < found.chi_square_limit
    assert distance(found.vertices, 150 * x) < 0.02


@pytest.mark.parametrize(
    ("edge", "off"),
    [(60, 10.0), *(pytest.param(e, off, marks=pytest.mark.slow) for e, off in ((30, 30.0), (110, -30.0)))],
)
def test_a_blunder_is_named_and_not_followed(edge, off):
    """One length of a smooth rock is typed 30 mm wrong: the crumpled surface that has it is no answer."""
    x, faces = rock(2, rough=0.5)
    metric = in_millimeters(x, faces)
    lengths = metric.lengths.copy()
    lengths[edge] += off
    named = re.escape(
        f"fitted without them: edge {edge} {metric.edges[edge].tolist()} ({'-' if off > 0 else '+'}"
    )
    with pytest.raises(NotEmbedded, match=named) as caught:
        embed(metric.with_lengths(lengths), length_errors=ERROR)
    assert "with which all other lengths agree" in str(caught.value)
    assert "as well" not in str(caught.value)
    nearest = caught.value.embedding
    assert distance(nearest.vertices, x) < 10.0
    assert abs(nearest.lengths[edge] - metric.lengths[edge]) < abs(off) / 2
    for other in nearest.others:
        assert other.converged
        assert other.surface.fine_roughness > nearest.surface.fine_roughness


def test_lengths_that_are_as_likely_wrong_are_named():
    """Few lengths contradict one of a small rough rock: the wrong one is said to be as likely as another."""
    x, faces = rock(1, rough=1.0, n=40)
    exact = PolyhedralMetric.from_mesh(x, faces)
    rng = np.random.default_rng([1, 24])
    lengths = exact.lengths + rng.normal(0.0, ERROR, len(exact.lengths))
    lengths[4] -= 60 * ERROR
    with pytest.raises(NotEmbedded, match="an error of which explains them as well") as caught:
        embed(exact.with_lengths(lengths), method=Aim(effort=0), length_errors=ERROR)
    report = isoembed.report(caught.value.embedding)["measured"]
    named = [one["edge"] for one in report["suspects"]] + report["other_suspects"]
    assert exact.edges[4].tolist() in named and len(named) > 1


def measured_ellipsoid():
    """The exact metric, and its lengths with errors."""
    exact = PolyhedralMetric.from_mesh(*triangulate(Ellipsoid((6.0, 5.0, 4.5)), 162))
    return exact, exact.lengths + np.random.default_rng(0).normal(0.0, ERROR / 1000, len(exact.lengths))


def test_lengths_without_a_blunder_are_followed():
    exact, lengths = measured_ellipsoid()
    assert embed(exact.with_lengths(lengths), length_errors=ERROR / 1000).converged


@pytest.mark.parametrize("off", [0.02, pytest.param(0.1, marks=pytest.mark.slow)])
def test_a_large_blunder_is_not_followed(off):
    """The scatter of the lengths is nearly all of one: a fit that follows them is compatible with all."""
    exact, lengths = measured_ellipsoid()
    lengths[77] += off
    with pytest.raises(NotEmbedded, match=r"fitted without them: edge 77 .*with which all other") as caught:
        embed(exact.with_lengths(lengths), length_errors=ERROR / 1000)
    assert abs(caught.value.embedding.lengths[77] - exact.lengths[77]) < off / 4


@pytest.mark.parametrize("edge", [80, *(pytest.param(e, marks=pytest.mark.slow) for e in (15, 185))])
def test_no_edge_beside_a_large_blunder_is_accused(edge):
    """The start is bent by the wrong length: fits without it begin from another."""
    x, faces = triangulate(Ellipsoid((150.0, 100.0, 80.0)), 200)
    exact = PolyhedralMetric.from_mesh(x, faces)
    lengths = exact.lengths + np.random.default_rng(edge).normal(0.0, ERROR, len(exact.lengths))
    lengths[edge] -= 35 * ERROR
    with pytest.raises(
        NotEmbedded, match=rf"on a smooth surface fitted without them: edge {edge} \[\d+, \d+\] [^;]*, with"
    ):
        embed(exact.with_lengths(lengths), length_errors=ERROR)


@pytest.mark.parametrize("seed", [2, 3])
def test_a_length_that_is_followed_is_corrected_by_the_others(seed):
    """The surface that has followed it has most of its error; the length that is said has not."""
    x, faces = rock(seed, rough=0.5)
    exact = PolyhedralMetric.from_mesh(x, faces)
    lengths = exact.lengths + np.random.default_rng(4).normal(0.0, ERROR, len(exact.lengths))
    lengths[160] += 15 * ERROR
    found = embed(exact.with_lengths(lengths), length_errors=ERROR)
    said = re.search(r"probably that of edge 160 .*: from \S+ to (\S+)\)", found.message)
    assert said
    assert found.lengths[160] - exact.lengths[160] > 10 * ERROR
    assert abs(float(said[1]) - exact.lengths[160]) < 3 * ERROR


def test_the_smallest_detectable_error():
    """Of seven deviations, by the mean redundancy, and 0.84 for a probability of 80 %."""
    x, faces = triangulate(Ellipsoid((150.0, 120.0, 100.0)), 80)
    exact = PolyhedralMetric.from_mesh(x, faces)
    lengths = exact.lengths + np.random.default_rng(1).normal(0.0, ERROR, len(exact.lengths))
    report = isoembed.report(embed(exact.with_lengths(lengths), length_errors=ERROR))["measured"]
    smallest = report["smallest_detectable_error"]
    assert smallest == pytest.approx(7.84 * ERROR / np.sqrt(report["redundancy"]), rel=1e-3)
    assert 10 * ERROR < smallest < 15 * ERROR


def test_a_redundancy_that_is_not_resolved_is_not_reported():
    """One degree of freedom is the least that the estimate gives."""
    x, faces = triangulate(Ellipsoid((150.0, 120.0, 100.0)), 80)
    metric = PolyhedralMetric.from_mesh(x, faces).with_length_errors(ERROR)
    for free, redundancy in ((1.0, 0.0), (25.0, 25 / len(metric.lengths))):
        found = measured_surface(metric, BestFit(x, 1.0, 0.01, free), "aim", 1e-10)
        assert found.redundancy == pytest.approx(redundancy)
        assert (isoembed.report(found)["measured"]["smallest_detectable_error"] is None) == (not redundancy)


def test_a_blunder_among_rounded_lengths_is_named():
    """The surface that has these lengths is exact, and crumpled; the message says which length to check."""
    x, faces = rock(2, rough=0.5)
    metric = in_millimeters(x, faces)
    lengths = metric.lengths.copy()
    lengths[30] += 30.0
    found = embed(metric.with_lengths(lengths))
    assert found.converged and not isinstance(found, MeasuredSurface)
    doubt = found.message.splitlines()[-1]
    assert "errors of their last digit" in doubt
    assert f"edge 30 {metric.edges[30].tolist()} (-3" in doubt  # 30 mm of 86
    with pytest.raises(NotEmbedded, match="check these lengths first") as caught:  # none is found so quickly
        embed(metric.with_lengths(lengths), method=Aim(effort=0))
    assert "the nearest misses edge" in str(caught.value)


@pytest.mark.parametrize("seed", [0, 3])
def test_no_right_length_is_suspected(seed):
    x, faces = triangulate(HarmonicSurface(degree=4, order=2, amplitude=0.15), 120, irregular=seed)
    exact = PolyhedralMetric.from_mesh(x, faces)
    error = 10.0 ** -(2 + seed / 2) * exact.mean_length
    lengths = exact.lengths + error * np.random.default_rng(seed).standard_normal(len(exact.lengths))
    assert embed(exact.with_lengths(lengths), method=Aim(effort=0), length_errors=error).converged


@pytest.mark.parametrize(("seed", "error"), [(0, 1e-3), (1, 1e-2 / 3)])
def test_what_is_smoothed_is_no_blunder(seed, error):
    """Residuals of smoothing decrease with mu, and those nearby are as large."""
    exact = PolyhedralMetric.from_mesh(*triangulate(Bean(), 300))
    sigma = error * exact.mean_length
    noise = sigma * np.random.default_rng([seed, 7]).standard_normal(len(exact.lengths))
    found = embed(exact.with_lengths(exact.lengths + noise), length_errors=sigma)
    assert found.converged
    assert "if one length is wrong" not in found.message


def test_errors_that_are_larger_than_stated():
    x, faces = triangulate(HarmonicSurface(degree=4, order=2, amplitude=0.15), 120, irregular=0)
    exact = PolyhedralMetric.from_mesh(150 * x, faces)
    noise = 3.0 * np.random.default_rng(0).standard_normal(len(exact.lengths))
    with pytest.raises(NotEmbedded, match="no smooth surface was found whose lengths agree"):
        embed(exact.with_lengths(exact.lengths + noise), method=Aim(effort=0), length_errors=0.1)


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_vertices_in_flat_faces(seed):
    """A box of squares: the fit stops at a fold of nearly flat vertices, within the errors of each length."""
    x, faces = zoo.subdivided(*zoo.subdivided(*zoo.cube()))
    exact = PolyhedralMetric.from_mesh(x * [3.0, 2.0, 1.5], faces)
    error = 3e-4 * exact.mean_length
    noise = error * np.random.default_rng(seed).standard_normal(len(exact.lengths))
    assert embed(
        exact.with_lengths(exact.lengths + noise), method=Aim(effort=0), length_errors=error
    ).converged


def test_errors_in_any_unit():
    x, faces = rock(1, rough=1.5)
    metric = in_millimeters(x, faces)
    found = embed(metric, length_errors=ERROR)
    inches = embed(metric.scaled(1 / 25.4), length_errors=ERROR / 25.4)
    assert distance(25.4 * inches.vertices, found.vertices) < 1e-6
    assert inches.chi_square == pytest.approx(found.chi_square, rel=1e-6)


@pytest.mark.parametrize(("unit", "error"), [(1e-300, 1e-3), (3e306, 1e-3), (3e306, 1e-290)])
def test_errors_in_units_near_the_ends_of_the_range(unit, error):
    """No square of an error over- or underflows, and an error below the rounding of doubles is one of it."""
    exact = PolyhedralMetric.from_mesh(*triangulate(Ellipsoid((3.0, 2.0, 1.0)), 40))
    noise = error * np.random.default_rng(0).standard_normal(len(exact.lengths))
    metric = PolyhedralMetric(exact.faces, unit * (exact.lengths + noise), exact.edges)
    found = embed(metric, length_errors=unit * error)
    assert found.converged
    assert isoembed.report(found)["deviation"]["length_error_rms"] == pytest.approx(unit * error, abs=0)


def test_large_errors_have_no_weight():
    """One length that is off by 5 mm, and known to be bad, changes little."""
    x, faces = rock(1, rough=1.5)
    metric = in_millimeters(x, faces)
    lengths, errors = metric.lengths.copy(), np.full(len(metric.lengths), ERROR)
    lengths[10] += 5.0
    errors[10] = 10.0
    found = embed(metric.with_lengths(lengths), length_errors=errors)
    assert distance(found.vertices, embed(metric, length_errors=ERROR).vertices) < 1.5
    assert found.chi_square < found.chi_square_limit


def test_whole_numbers_of_a_design_are_exact():
    tetrahedron = PolyhedralMetric([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]], [3, 4, 5, 5, 4, 3])
    assert tetrahedron.rounding is None
    x, faces = rock(0)
    assert in_millimeters(x, faces).rounding == pytest.approx(
        ERROR / in_millimeters(x, faces).mean_length, rel=1e-9
    )
    assert PolyhedralMetric.from_mesh(x, faces).rounding is None


def test_refusals():
    x, faces = rock(0)
    metric = in_millimeters(x, faces)
    with pytest.raises(InvalidMetric, match=r"length error of edge 0 .* is -1"):
        embed(metric, length_errors=-1)
    with pytest.raises(InvalidMetric, match=r"shape \(3,\)"):
        embed(metric, length_errors=[1, 2, 3])
    some = np.ones(len(metric.lengths))
    some[7] = 0
    with pytest.raises(InvalidMetric, match=r"edge 7 .* is 0"):
        embed(metric, length_errors=some)
    with pytest.raises(InvalidParameter, match="takes lengths as exact"):
        embed(metric, method="paper", length_errors=0.1)
    best = embed(metric, method=Aim(best_fit=True), length_errors=0)
    assert not isinstance(best, MeasuredSurface)


@pytest.mark.parametrize("k", [2, 8, 10, 26, 49, 51])
def test_corners_are_not_smoothed_to_another_body(k):
    """Johnson solids from lengths with errors of 1e-4: no fit on the way collapses."""
    x = johnson(k)
    exact = PolyhedralMetric.from_mesh(x, solids.triangles(solids.polygons(x)))
    error = 1e-4 * exact.mean_length
    lengths = exact.lengths + error * np.random.default_rng(k).standard_normal(len(exact.lengths))
    found = embed(exact.with_lengths(lengths), length_errors=error)
    assert found.converged
    assert distance(found.vertices, x) < 0.05 * exact.mean_length  # flat vertices move by the root of it


def test_volumes_are_not_determined_where_a_vertex_is_flat():
    """Its height goes as the root of its deficit: to first order, errors of the lengths have no bound."""
    x, faces = zoo.tetrahedron()
    a, b, c = faces[0]
    split = np.vstack([faces[1:], [[a, b, 4], [b, c, 4], [c, a, 4]]])
    exact = PolyhedralMetric.from_mesh(np.vstack([x, x[faces[0]].mean(axis=0)]), split)
    for seed in range(4):
        noise = 1e-4 * np.random.default_rng(seed).standard_normal(len(exact.lengths))
        found = embed(exact.with_lengths(exact.lengths + noise), length_errors=1e-4)
        sigma = isoembed.Sensitivity(found).integral_deviation(1e-4)
        assert sigma.volume_nonlinearity > 0.1
        assert not sigma.volume_is_determined
        assert isoembed.report(found)["deviation"]["volume"] is None


def test_error_bars_hold_what_is_smoothed():
    """Errors of 3 mm: the integral of H of the smooth fit is too small by twice the bar of first order."""
    pulls = []
    for seed in range(16):
        x, faces = rock(seed, rough=3.0)
        exact = PolyhedralMetric.from_mesh(x, faces)
        noise = 3.0 * np.random.default_rng(seed).standard_normal(len(exact.lengths))
        found = embed(exact.with_lengths(exact.lengths + noise), length_errors=3.0)
        sigma = isoembed.Sensitivity(found).integral_deviation(3.0)
        true = isoembed.Embedding(exact, x, method="aim", tolerance=1.0)
        of_volume = (found.volume - true.volume) / sigma.volume
        of_h = (
            found.integrated_mean_curvature - true.integrated_mean_curvature
        ) / sigma.integrated_mean_curvature
        pulls.append([of_volume, of_h])
    assert np.mean(np.abs(pulls) < 2.0) > 0.8
    assert np.mean(np.abs(pulls) < 1.0) < 0.95


def test_error_bars_of_rigid_surfaces_are_determined():
    found = embed(in_millimeters(*rock(1, rough=1.5)), length_errors=ERROR)
    assert isoembed.Sensitivity(found).integral_deviation(ERROR).volume_nonlinearity < 0.1


def divided_box(seed):
    """A box of 10 by 6 2/3 by 3 1/3, turned, with four vertices inside each face."""
    number, triangles = {}, []
    for axis, end in np.ndindex(3, 2):
        corners = np.insert(np.argwhere(np.ones((4, 4))), axis, 3 * end, axis=1)
        at = np.array([number.setdefault(tuple(each), len(number)) for each in corners.tolist()]).reshape(
            4, 4
        )
        squares = np.stack([at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]], axis=-1).reshape(-1, 4)
        squares = squares if (end + axis) % 2 else squares[:, ::-1]
        triangles += [square[each] for square in squares for each in ([0, 1, 2], [0, 2, 3])]
    return np.array(list(number)) * (10.0, 20.0 / 3, 10.0 / 3) @ zoo.rotation(seed), np.array(triangles)


def test_a_box_with_rounded_coordinates_is_not_crumpled():
    """The exact surface that is found is off by half an edge."""
    x, triangles = divided_box(5)
    metric = PolyhedralMetric.from_mesh(np.round(x, 3), triangles)
    found = embed(metric)
    assert isinstance(found, MeasuredSurface)
    assert found.converged
    assert found.distance(x) < 0.02
    assert "coordinates rounded to 5 digits: length_errors=0 takes the lengths as exact" in found.message
    exact = embed(metric, length_errors=0)
    assert not isinstance(exact, MeasuredSurface)


def test_an_exact_surface_near_the_fit_is_taken_where_it_is_smoother():
    x, faces = zoo.icosahedron()
    found = embed(PolyhedralMetric.from_mesh(x, faces), length_errors=1e-6)
    assert found.residual < 1e-12
    assert found.distance(x) < 1e-12


def lens(angle):
    points, faces = discs.irregular(50)
    cap = discs.round_cap(points, angle) - [0.0, 0.0, np.cos(angle)]
    inside = np.flatnonzero(np.linalg.norm(points, axis=1) < 0.999)
    copied = np.arange(len(cap))
    copied[inside] = len(cap) + np.arange(len(inside))
    return np.vstack([cap, cap[inside] * [1, 1, -1]]), np.vstack([faces, copied[faces[:, ::-1]]])


def notched_prism():
    """Prism over an L, which is not convex."""
    outline = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
    bottom = [(2, 1, 0), (3, 2, 0), (5, 3, 0), (5, 4, 3)]
    top = [(6 + a, 6 + b, 6 + c) for c, b, a in bottom]
    sides = [(i, (i + 1) % 6, (i + 1) % 6 + 6) for i in range(6)] + [
        (i, (i + 1) % 6 + 6, i + 6) for i in range(6)
    ]
    return np.array([(x, y, z) for z in (0.0, 1.0) for x, y in outline]), np.array(bottom + top + sides)


@pytest.mark.parametrize("error", [1e-4, 1e-3])
def test_a_rod_one_edge_wide_is_not_folded(error):
    """All vertices are on its edges, and nothing is smoothed: a fit encloses half of the volume."""
    corners = np.array([(y, z) for y, z in ((0, 0), (1, 0), (1, 1), (0, 1))])
    vertices = np.array([(x, *corner) for x in range(9) for corner in corners], dtype=float)
    sides = []
    for i, j in np.ndindex(8, 4):
        a, b = 4 * i + j, 4 * i + (j + 1) % 4
        sides += [(a, a + 4, b), (b, a + 4, b + 4)] if j > 1 else [(a, a + 4, b + 4), (a, b + 4, b)]
    ends = [(0, 1, 2), (0, 2, 3), (34, 33, 32), (35, 34, 32)]
    metric = PolyhedralMetric.from_mesh(vertices, sides + ends)
    sigma = error * metric.mean_length
    lengths = metric.lengths + np.random.default_rng(0).normal(0, sigma, len(metric.lengths))
    found = embed(metric.with_lengths(lengths), length_errors=sigma)
    assert found.converged
    assert found.volume == pytest.approx(8, rel=0.1)
    assert found.distance(vertices) < 100 * error


@pytest.mark.parametrize("error", [1e-4, 1e-3])
@pytest.mark.parametrize(
    "body",
    [lens(0.3), lens(0.6), divided_box(5), zoo.subdivided(*zoo.subdivided(*notched_prism()))],
    ids=["flat lens", "lens", "box", "notched prism"],
)
def test_sharp_edges_are_not_folded(body, error):
    """Fits that are smooth everywhere are off by 100 to 3,000 deviations, and agree with the lengths."""
    vertices, faces = body
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    sigma = error * metric.mean_length
    lengths = metric.lengths + np.random.default_rng(0).normal(0, sigma, len(metric.lengths))
    found = embed(metric.with_lengths(lengths), length_errors=sigma)
    assert found.converged
    assert found.distance(vertices) < 25 * error


def measured(name, seed, error):
    """A body with sharp edges, its true vertices, and its metric with errors of the lengths."""
    vertices, faces = sharp_bodies.BODIES[name](seed)
    exact = PolyhedralMetric.from_mesh(vertices @ zoo.rotation(seed), faces)
    noise = np.random.default_rng([seed, 5]).standard_normal(len(exact.lengths))
    sigma = error * exact.mean_length
    return vertices, exact.with_lengths(exact.lengths + sigma * noise), sigma


@pytest.mark.parametrize(
    ("name", "seed", "edge", "blunder"),
    [
        pytest.param("half ball", 245, 229, -35, marks=pytest.mark.slow),
        pytest.param("cylinder", 350, 168, -50, marks=pytest.mark.slow),
        ("prism 3", 140, 22, -20),
        ("pyramid 4", 140, 255, -20),
        pytest.param("lens 0.5", 140, 329, -20, marks=pytest.mark.slow),
    ],
)
def test_a_wrong_length_of_a_body_with_sharp_edges_is_named(name, seed, edge, blunder):
    """Fits without it agree with all others; before, others that followed it were returned."""
    _, metric, sigma = measured(name, seed, 1e-3)
    lengths = metric.lengths.copy()
    lengths[edge] += blunder * sigma
    with pytest.raises(NotEmbedded, match=rf": edge {edge} .*with which all other lengths agree"):
        embed(metric.with_lengths(lengths), length_errors=sigma)


@pytest.mark.parametrize("error", [1e-4, 1e-3])
def test_a_rod_with_diagonals_at_random_is_not_folded(error):
    vertices, metric, sigma = measured("rod 1 x 1 x 8", 1, error)
    found = embed(metric, length_errors=sigma)
    assert found.converged
    assert found.volume == pytest.approx(8, rel=0.01)
    assert found.distance(vertices) < 10 * sigma


@pytest.mark.slow
def test_a_cone_is_not_folded():
    """Edges between rings of different numbers of vertices are dents, far beyond the errors."""
    vertices, metric, sigma = measured("cone 0.5", 0, 1e-4)
    assert metric.deficits.min() < -0.01
    found = embed(metric, length_errors=sigma)
    assert found.converged
    assert found.distance(vertices) < 0.05 * metric.mean_length
