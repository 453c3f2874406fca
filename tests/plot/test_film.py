"""Films: which surfaces are kept on the way, and how they are put."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

import discs
import isoembed
import smooth_bodies
from isoembed import InvalidParameter, Paper, PolyhedralMetric
from isoembed.gallery import Ergosphere, triangulate
from isoembed.plot import Film, frames_of
from isoembed.plot.film import ANSWER
from isoembed.surface.alignment import aligned
from isoembed.surface.measures import edge_lengths, volume


def filmed(metric, **how):
    film = Film()
    surface = isoembed.embed(metric, progress=film, **how)
    return surface, film.frames(surface)


@pytest.fixture(scope="module")
def by_the_paper():
    vertices, faces = smooth_bodies.ellipsoid()
    return filmed(PolyhedralMetric.from_mesh(1e3 * vertices, faces), method=Paper(Tsteps=4))


def test_the_way_of_the_paper(by_the_paper):
    surface, frames = by_the_paper
    assert [frame.t for frame in frames if frame.stage == "pull back"] == pytest.approx([0.75, 0.5, 0.25])
    assert frames[0].stage == "embedding tree"
    assert frames[0].t == 1
    last = frames[-1]
    assert (last.stage, last.t, last.residual) == (ANSWER, 0, surface.residual)
    assert (last.vertices == surface.vertices).all()
    # The tree is on a sphere, of the area of the given surface or so.
    radii = np.linalg.norm(frames[0].vertices - frames[0].vertices.mean(axis=0), axis=1)
    assert radii == pytest.approx(np.sqrt(surface.area / (4 * np.pi)), rel=0.1)


def test_every_surface_is_turned_onto_the_next(by_the_paper):
    surface, frames = by_the_paper
    for frame, following in itertools.pairwise(frames):
        assert volume(surface.faces, frame.vertices) > 0
        x, y = (f.vertices - f.vertices.mean(axis=0) for f in (frame, following))
        pull = x.T @ y  # symmetric where no rotation brings them nearer
        assert np.abs(pull - pull.T).max() < 1e-9 * np.abs(pull).max()
    # No step of the pull-back is long in this position: the surfaces are not turned over.
    apart = [np.linalg.norm(a.vertices - b.vertices, axis=1).max() for a, b in itertools.pairwise(frames)]
    assert max(apart) < 0.3 * np.ptp(surface.vertices)


def test_a_surface_on_the_way_has_the_lengths_of_its_metric(by_the_paper):
    surface, frames = by_the_paper
    half = next(frame for frame in frames if frame.t == 0.5)
    lengths = edge_lengths(surface.metric.edges, half.vertices)
    u = Paper().uniformize(surface.metric.normalized, smooth_bodies.recorder()).u / 2
    a, b = surface.metric.edges.T
    expected = surface.metric.lengths * (np.exp(u[a]) + np.exp(u[b])) / 2  # Eqs. (len) and (linlink)
    assert np.abs(lengths / expected - 1).max() < 1e-9


def test_the_guided_way_ends_at_the_answer():
    metric = PolyhedralMetric.from_mesh(*triangulate(Ergosphere(epsilon=0.3), 200))
    _, frames = filmed(metric)
    times = [frame.t for frame in frames if frame.stage == "guided pull back"]
    assert times == sorted(times, reverse=True)
    assert times[0] == 1
    assert frames[-1].stage == ANSWER
    assert len({frame.vertices.tobytes() for frame in frames}) == len(frames)


def test_a_leap_leaves_the_answer_alone():
    vertices, faces = smooth_bodies.ellipsoid()
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    for method in ("aim", "alexandrov"):
        surface, frames = filmed(metric, method=method)
        assert [frame.stage for frame in frames] == [ANSWER]
        assert frames[0].vertices is surface.vertices


def test_frames_of_a_series_are_turned_onto_each_other(by_the_paper):
    last, _ = by_the_paper
    turn = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    surfaces = [
        isoembed.Embedding(last.metric, k * last.vertices @ turn + 5.0, method="given", tolerance=1.0)
        for k in (0.5, 0.8)
    ]
    frames = frames_of([*surfaces, last], ["small", "larger", "all"])
    assert [frame.stage for frame in frames] == ["small", "larger", "all"]
    assert frames[-1].vertices is last.vertices
    centered = last.vertices - last.vertices.mean(axis=0)
    for frame, k in zip(frames, (0.5, 0.8, 1.0), strict=True):
        found = frame.vertices - frame.vertices.mean(axis=0)
        np.testing.assert_allclose(found, k * centered, atol=1e-9 * np.abs(last.vertices).max())


def test_a_series_has_headings_and_one_triangulation(by_the_paper):
    last, _ = by_the_paper
    with pytest.raises(InvalidParameter, match="there are 1 surfaces, but 2 headings"):
        frames_of([last], ["a", "b"])
    other = isoembed.embed(PolyhedralMetric.from_mesh(*triangulate(Ergosphere(), 20)))
    with pytest.raises(InvalidParameter, match="surface 0 does not have the triangles of the last surface"):
        frames_of([other, last], ["a", "b"])


def test_the_way_to_a_sheet_is_not_mirrored_in_between():
    points, faces = discs.hexagonal(4)
    x = np.column_stack([points, 0.3 * (points[:, 0] ** 2 - 0.8 * points[:, 1] ** 2)])
    sheet, frames = filmed(PolyhedralMetric.from_mesh(x, faces), boundary="free")
    assert len(frames) > 3
    np.testing.assert_array_equal(frames[-1].vertices, sheet.vertices)
    for frame, after in itertools.pairwise([frame.vertices for frame in frames[1:]]):
        mirrored = aligned(frame * [1, 1, -1], after)
        assert np.linalg.norm(frame - after) < np.linalg.norm(mirrored - after)
    for boundary in (x[sheet.triangulation.boundaries[0]], 0.02 * np.arange(24) % 0.04):
        metric = PolyhedralMetric.from_mesh(discs.round_cap(points, 1.0) if boundary.ndim == 1 else x, faces)
        assert len(filmed(metric, boundary=boundary)[1]) > 3


def test_frames_of_a_sheet_are_colored_alike_to_the_boundary():
    """A round cap: H is that of its sphere at the boundary, too, where dihedral angles end."""
    points, faces = discs.hexagonal(5)
    cap = isoembed.embed(PolyhedralMetric.from_mesh(discs.round_cap(points, 1.0), faces), boundary="plane")
    before, _ = frames_of([replace(cap, vertices=cap.vertices * [1, 1, -1]), cap], ["mirrored", "cap"])
    np.testing.assert_allclose(before.vertices, cap.vertices, atol=1e-12)
    assert before.surface(cap).mean_curvature == pytest.approx(np.ones(len(points)), abs=0.15)
