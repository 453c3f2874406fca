"""The studies of the paper's method: each at a small size, and what its text says holds in its numbers."""

import io
import json

import numpy as np
import pytest

from isoembed import PolyhedralMetric
from isoembed.gallery import Ellipsoid, triangulate

pytest.importorskip("matplotlib")

from isoembed.studies import (
    accuracy,
    embedding_tree,
    inverted_vertex,
    regularized_continuation,
    scaling,
    three_steps,
)
from isoembed.studies.bodies import STUDY

SIZES = {
    three_steps: {"vertices": 60},
    embedding_tree: {"shown": 100, "sizes": (60, 120, 240)},
    inverted_vertex: {"vertices": 30},
    regularized_continuation: {"cases": (("drum", 200, 5),), "path_vertices": 60},
    scaling: {"sizes": (60, 120), "flow_sizes": (50, 100), "step_sizes": (60, 400)},
    accuracy: {"vertices": 100},
}


@pytest.fixture(scope="module")
def sections():
    return {study: study.study(**sizes) for study, sizes in SIZES.items()}


@pytest.mark.parametrize("study", SIZES, ids=lambda study: study.__name__.rpartition(".")[2])
def test_a_section_can_be_written(sections, study):
    section = sections[study]
    json.dumps(section.numbers, allow_nan=False)
    assert section.title
    assert section.text
    assert section.comparisons
    for illustration in section.figures:
        page = io.BytesIO()
        illustration.figure.savefig(page, format="svg")
        assert b"<path" in page.getvalue()
    for table in section.tables:
        assert all(len(row) == len(table.header) for row in table.rows)
    names = [illustration.name for illustration in section.figures]
    assert len(set(names)) == len(names)


def test_the_nets_are_the_metrics(sections):
    section = sections[three_steps]
    metric = PolyhedralMetric.from_mesh(*triangulate(Ellipsoid(), 60))
    (illustration,) = section.figures
    before, after, *_ = illustration.figure.axes
    corners = np.array([path.vertices[:3] for path in before.collections[0].get_paths()])
    sides = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    np.testing.assert_allclose(sides, metric.face_lengths, rtol=1e-12)
    (a, b), (c, d) = (corners[:, 1] - corners[:, 0]).T, (corners[:, 2] - corners[:, 0]).T
    assert (a * d - b * c > 0).all()  # none is turned over
    # A spanning tree joins the triangles: at least as many sides of it lie on each other.
    middles = (corners + np.roll(corners, -1, axis=1)) / 2
    twins = metric.triangulation.twins
    apart = np.linalg.norm(middles.reshape(-1, 2) - middles.reshape(-1, 2)[twins], axis=1)
    assert (apart < 1e-10).sum() >= 2 * (metric.triangulation.n_faces - 1)
    assert len(after.collections[0].get_paths()) == metric.triangulation.n_faces
    low, high = section.numbers["curvature_after"]
    assert 1 - low < 1e-2
    assert high - 1 < 1e-2
    assert section.numbers["curvature_before"][1] > 5
    assert section.numbers["residual"] < 1e-10


def test_only_the_edges_that_the_tree_does_not_use_are_wrong(sections):
    numbers = sections[embedding_tree].numbers
    for row in numbers["ellipsoid"]:
        assert row["determined"] == row["vertices"] - 3
        assert row["used"] < 1e-10
        assert 1e-4 < row["median"] < row["worst"]
    assert numbers["exponents"]["median"] < -1 < numbers["exponents"]["worst"]
    assert numbers["growth_per_layer"] > 1
    assert max(numbers["first_edge"].values()) < 1e-14
    assert numbers["two_solutions"]["far"] > numbers["two_solutions"]["near"]
    assert numbers["two_solutions"]["apart"] < 1e-15


def test_the_tree_has_two_used_edges_for_every_vertex_that_it_shows(sections):
    figure = sections[embedding_tree].figures[0].figure
    lines = {line.get_label(): len(line.get_segments()) for line in figure.axes[0].collections[1:]}
    (dots,) = figure.axes[0].lines
    assert lines["used for the next"] == 2 * len(dots.get_xdata()) > 0
    assert lines["determined"] > 0


def test_two_surfaces_have_the_same_lengths(sections):
    pair = sections[inverted_vertex].numbers["pair"]
    assert pair["lengths"] < 1e-12
    assert pair["deficits"] < 1e-12
    assert pair["dihedral"] > 0.5
    assert pair["integral_convex"] > pair["integral_inverted"]
    assert pair["others_moved"] < pair["vertex_moved"] / 4


def test_only_the_corrected_routine_pops(sections):
    numbers = sections[inverted_vertex].numbers
    pair, printed, corrected = numbers["pair"], numbers["routine"]["printed"], numbers["routine"]["corrected"]
    assert pair["height_inverted"] < 0 < pair["height_convex"]
    # The vertex normal turns a little with the vertex, so the height is not quite linear in the move.
    assert printed["moved"] == pytest.approx(3 * pair["height_inverted"], rel=0.02)
    assert corrected["moved"] == pytest.approx(-pair["height_inverted"], rel=0.02)
    assert corrected["annealed"] == pytest.approx(pair["height_convex"], rel=1e-9)
    assert printed["annealed"] < 0
    assert corrected["annealed_concave"] == 0 < printed["annealed_concave"]
    everywhere = numbers["every_vertex"]
    assert everywhere["inverted"] > everywhere["vertices"] / 3
    assert everywhere["corrected"] == everywhere["inverted"]
    assert everywhere["printed"] == 0


def test_only_the_corrected_routine_leads_to_the_given_surface(sections):
    (case,) = sections[regularized_continuation].numbers["pull_backs"]
    ways = case["routines"]
    assert all(len(way["t"]) == 2 + case["steps"] for way in ways.values())
    assert ways["corrected"]["crumpled"][0] > ways["corrected"]["crumpled"][-1] == 0
    assert ways["corrected"]["concave"][-1] == case["concave_given"]
    assert ways["corrected"]["off"] < STUDY.same
    for routine in ("printed", "none"):
        assert ways[routine]["crumpled"][-1] >= ways[routine]["crumpled"][0]
        assert ways[routine]["residual"] <= 1e-6  # the lengths do not tell
        assert ways[routine]["off"] > 100 * STUDY.same


def test_extrapolation_helps_and_the_flows_path_does_not(sections):
    for found in sections[regularized_continuation].numbers["paths"].values():
        linear, *_, flow = found["paths"]
        assert len(linear["arrived"]) > len(flow["arrived"])
        assert linear["iterations"] < flow["iterations"]
        assert linear["longest"] < flow["longest"]
        assert found["extrapolation"]["factor"] > 10
        assert found["extrapolation"]["iterations"] < found["extrapolation"]["without"]
        guesses = np.array(found["extrapolation"]["guesses"])
        np.testing.assert_array_equal(guesses[:3, 0], guesses[:3, 1])  # j = 1, 2, 3 start from before


def test_costs_add_up_and_only_the_explicit_flow_takes_ever_more_evaluations(sections):
    numbers = sections[scaling].numbers
    for name, rows in numbers["timed"].items():
        for row in rows:
            for costs in row.values():
                parts = [costs[key] for key in costs if key not in (scaling.TOTAL, scaling.DEFAULT)]
                assert len(parts) == 5
                assert sum(parts) == pytest.approx(costs[scaling.TOTAL])
        assert abs(numbers["exponents"]["factorizations"][name][scaling.TOTAL]) < 0.5
        # An explicit integrator's steps shorten with the triangles.
        evaluations = numbers["flow_exponents"]["evaluations"][name]
        assert evaluations["RK45"] > evaluations["BDF"] + 0.3
    assert numbers["fewest_steps"]["drum"][1] >= numbers["fewest_steps"]["drum"][0] >= 1


def test_lengths_are_within_the_tolerances_and_the_drum_is_flat_on_its_equator(sections):
    numbers = sections[accuracy].numbers
    assert numbers["curvature_on_equator"] == 0
    for name in ("ellipsoid", "drum"):
        for row, tolerance in zip(numbers[name]["settings"], (1e-6, 1e-9, 1e-10), strict=True):
            assert row["mean"] < row["max"] <= tolerance
            assert row["std"] < tolerance


def test_angles_are_those_of_the_triangles(sections):
    angles = sections[accuracy].numbers["ellipsoid"]["angles"]
    vertices, faces = triangulate(Ellipsoid(), 100)
    found = []
    for a, b, c in (np.roll(faces, k, axis=1).T for k in range(3)):
        u, v = vertices[b] - vertices[a], vertices[c] - vertices[a]
        u, v = (w / np.linalg.norm(w, axis=1)[:, None] for w in (u, v))
        found.append(np.degrees(np.arccos((u * v).sum(axis=1))))
    found = np.array(found)
    assert angles["corners"] == found.size
    assert angles["smallest"] == pytest.approx(found.min(), rel=1e-9)
    assert angles["largest"] == pytest.approx(found.max(), rel=1e-9)
    assert angles["outside"] == [((found < 30) | (found > top)).sum() for top in (90, 120)]


def test_deficits_change_evenly_on_the_linear_path(sections):
    for found in sections[regularized_continuation].numbers["paths"].values():
        assert found["rates"]["deficits"] == pytest.approx(1, abs=0.1)
        assert found["rates"]["curvature"] > 1.5
