"""The methods go on from wherever they kept something, and arrive at the same surface."""

import os
import subprocess
import sys

import numpy as np
import pytest
from scipy.spatial import ConvexHull

import curved_bodies
import isoembed
import smooth_bodies
import zoo
from isoembed import Aim, PolyhedralMetric
from isoembed.gallery import Bean, BentTube, Drum, Ellipsoid, Ergosphere, triangulate
from isoembed.io import read_checkpoint, write_checkpoint, write_metric
from isoembed.progress.stages import Log
from isoembed.space import Space

STOPPED = """
import os, signal, sys
from isoembed.cli import main
from isoembed.progress.stages import StageRecorder
keep = StageRecorder.keep
def kept(recorder, **arrays):
    keep(recorder, **arrays)
    os.kill(os.getpid(), signal.SIGINT)
StageRecorder.keep = kept
sys.exit(main())
"""


def cap(height, n=16):
    """A shallow cap over a regular polygon, closed by a flat pyramid: nearly flat everywhere."""
    angles = 2 * np.pi * np.arange(n) / n
    rings = [np.c_[r * np.cos(angles), r * np.sin(angles), np.full(n, height * (1 - r**2))] for r in (1, 0.6)]
    return hulled(np.concatenate([*rings, [[0.1, 0, height], [0, 0.1, -height]]]))


def hulled(points):
    hull = ConvexHull(points)
    x, faces = points, hull.simplices.copy()
    normals = np.cross(x[faces[:, 1]] - x[faces[:, 0]], x[faces[:, 2]] - x[faces[:, 0]])
    inward = np.einsum("ij,ij->i", normals, hull.equations[:, :3]) < 0
    faces[inward] = faces[inward, ::-1]
    return PolyhedralMetric.from_mesh(x, faces)


def every_checkpoint(metric, method):
    """The checkpoints of a run, each once; and the surface."""
    found = {}  # they stay, and their ids with them
    surface = answer(metric, method, progress=lambda p: found.setdefault(id(p.checkpoint), p.checkpoint))
    return [checkpoint for checkpoint in found.values() if checkpoint is not None], surface


def one_of_each(checkpoints):
    """The first checkpoint of each kind: by its strategy, and what that kept."""
    first = {}
    for checkpoint in checkpoints:
        first.setdefault((checkpoint.key, *checkpoint.arrays), checkpoint)
    return list(first.values())


def answer(metric, method, **options):
    """The surface, or the nearest attempt."""
    try:
        return isoembed.embed(metric, method=method, **options)
    except isoembed.NotEmbedded as failure:
        return failure.embedding


def goes_on_to(surface, metric, method, checkpoint, folder):
    write_checkpoint(folder / "c.npz", checkpoint)
    rest = answer(metric, method, resume=read_checkpoint(folder / "c.npz"))
    assert (rest.metric.faces == surface.metric.faces).all()
    assert (rest.vertices == surface.vertices).all()
    assert rest.message == surface.message
    assert len(rest.others) == len(surface.others)


@pytest.mark.parametrize("method", ["alexandrov", "aim"])
@pytest.mark.parametrize("height", [1e-2, pytest.param(1e-3, marks=pytest.mark.slow)])
def test_from_every_checkpoint_of_a_nearly_flat_body_the_same_bits_come(method, height, tmp_path):
    metric = cap(height)
    found, whole = every_checkpoint(metric, method)
    assert len(found) > 2
    assert ("" if method == "alexandrov" else "nearest polytope") in {checkpoint.key for checkpoint in found}
    for checkpoint in found[:: max(1, len(found) // 3)]:
        goes_on_to(whole, metric, method, checkpoint, tmp_path)


def test_what_was_in_vain_is_not_tried_again():
    vertices, faces = zoo.random_hull(200, 1)
    metric = PolyhedralMetric.from_mesh(vertices * [20, 1, 1], faces)
    found, _ = every_checkpoint(metric, "aim")
    keys = [checkpoint.key for checkpoint in found]
    assert list(dict.fromkeys(keys)) == ["newton on radii", "nearest polytope", "newton from polytope"]
    for checkpoint in found[:: max(1, len(found) // 5)]:
        seen: list = []
        isoembed.embed(metric, resume=checkpoint, progress=seen.append)
        later = {progress.checkpoint.key for progress in seen if progress.checkpoint is not None}
        assert later <= set(keys[keys.index(checkpoint.key) :])


@pytest.mark.slow
@pytest.mark.parametrize("body", [Ellipsoid((3, 2, 1)), Ergosphere(epsilon=0.3)], ids=["convex", "K < 0"])
def test_from_every_checkpoint_the_same_surface_comes(body, tmp_path):
    metric = PolyhedralMetric.from_mesh(*triangulate(body, 400))
    found, whole = every_checkpoint(metric, "aim")
    assert found
    for checkpoint in found:
        goes_on_to(whole, metric, "aim", checkpoint, tmp_path)


@pytest.mark.parametrize("curvature", [-1.0, 1.0])
def test_from_checkpoints_in_curved_space_the_same_surface_comes(curvature, tmp_path):
    space = Space(curvature)
    metric = curved_bodies.metric_of(space, *curved_bodies.smooth(space, BentTube(), 60, 0.8))
    found, whole = every_checkpoint(metric, "aim")
    keys = {checkpoint.key for checkpoint in found}
    assert keys >= {"nearest polyhedron", "newton on lengths", "guided path"}
    for checkpoint in found[:: max(1, len(found) // 4)]:
        goes_on_to(whole, metric, "aim", checkpoint, tmp_path)


def test_the_time_left_of_a_run_that_goes_on_is_estimated():
    metric = PolyhedralMetric.from_mesh(*triangulate(Ergosphere(epsilon=0.3), 100))
    found, _ = every_checkpoint(metric, "aim")
    first = next(checkpoint for checkpoint in found if checkpoint.key == "guided path")
    left: list = []
    isoembed.embed(metric, resume=first, progress=lambda p: left.append((p.stage, p.remaining)))
    assert any(stage == "guided pull back" and seconds is not None for stage, seconds in left)


def noisy():
    """Lengths of no surface, for which all is tried."""
    vertices, faces = smooth_bodies.ellipsoid(80)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    errors = np.random.default_rng(0).normal(size=len(metric.lengths))
    return metric.with_lengths(metric.lengths * (1 + 0.05 * errors))


@pytest.mark.slow
def test_one_checkpoint_of_each_strategy_leads_to_the_same_failure(tmp_path):
    metric, method = noisy(), Aim(effort=1.5)
    found, whole = every_checkpoint(metric, method)
    assert not whole.converged
    tried = {"newton on lengths", "guided path", "local search", "best fit", "vertex reflections"}
    assert {checkpoint.key for checkpoint in found} >= tried
    for checkpoint in one_of_each(found):
        goes_on_to(whole, metric, method, checkpoint, tmp_path)


def within_errors():
    metric = PolyhedralMetric.from_mesh(*triangulate(Bean(), 100))
    return metric.with_length_errors(1e-6 * metric.mean_length)


def rounded():
    metric = PolyhedralMetric.from_mesh(*triangulate(Bean(), 200))
    return metric.with_lengths(np.round(metric.lengths, 3))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("made", "key"), [(within_errors, "fit within errors"), (rounded, "fit within digits")]
)
def test_one_checkpoint_of_each_strategy_leads_to_the_same_fit(made, key, tmp_path):
    metric = made()
    found, whole = every_checkpoint(metric, "aim")
    assert key in {checkpoint.key for checkpoint in found}
    for checkpoint in one_of_each(found):
        goes_on_to(whole, metric, "aim", checkpoint, tmp_path)


@pytest.mark.parametrize(
    "made",
    [
        noisy,
        lambda: PolyhedralMetric.from_mesh(*smooth_bodies.dimpled(200)),
        lambda: cap(1e-2),
        lambda: PolyhedralMetric.from_mesh(*triangulate(BentTube(), 100)),
    ],
    ids=["noisy", "dimpled", "cap", "tube"],
)
def test_what_stages_are_called_changes_nothing(made, monkeypatch):
    metric = made()
    found, plain = every_checkpoint(metric, "aim")
    stage = Log.stage
    monkeypatch.setattr(Log, "stage", lambda log, name: stage(log, "again"))
    others, renamed = every_checkpoint(metric, "aim")
    assert {each.name for each in renamed.stages} == {"again"}
    assert (renamed.vertices == plain.vertices).all()
    assert renamed.message == plain.message
    assert [s.factorizations for s in renamed.stages] == [s.factorizations for s in plain.stages]
    assert [each.key for each in others] == [each.key for each in found]
    middle = others[len(others) // 2]
    assert (answer(metric, "aim", resume=middle).vertices == plain.vertices).all()


def test_control_c_leaves_a_checkpoint_in_a_real_process(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_metric("m.npz", PolyhedralMetric.from_mesh(*triangulate(Drum(), 1000)))
    arguments = ["embed", "m.npz", "-o", "a.npz"]
    done = subprocess.run([sys.executable, "-c", STOPPED, *arguments], capture_output=True, text=True)
    assert done.returncode == 130
    assert "the stage 'radii'; the checkpoint is in a.npz.checkpoint.npz" in done.stderr
    assert sorted(os.listdir()) == ["a.npz.checkpoint.npz", "m.npz"]
    again = "import sys; from isoembed.cli import main; sys.exit(main())"
    command = [sys.executable, "-c", again, *arguments, "--resume", "a.npz.checkpoint.npz"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
