"""Sources: hashes of contents, files that change, and what cannot be sent to another process."""

import hashlib
import os
import pickle

import numpy as np
import pytest

from isoembed.io.digest import file_digest, unchanged
from isoembed.io.files import FileError
from isoembed.relativity import (
    AnalyticCallable,
    BrillLindquist,
    CoordinateShape,
    KerrNewmanHorizon,
    StarSurface,
    SurfaceData,
)
from isoembed.relativity.series.horizon_task import HorizonTask
from isoembed.relativity.series.moment import Moment
from isoembed.relativity.series.source import HeldShape, HeldSlice, MissingSlice
from isoembed.smooth.grid_metric import GridMetric

CORNERS = 2.0 * np.array([*np.eye(3), *-np.eye(3)])
SPHERE = StarSurface.sphere((0.0, 0.0, 0.0), 3.0)
MASS = 0.5
LOW, HIGH = -np.ones(3), np.ones(3)


def octahedron(points=CORNERS):
    return HeldShape(CoordinateShape.star_shaped(points, "six points", np.zeros(3)))


def test_the_hash_of_a_file_is_that_of_its_bytes(tmp_path):
    path = tmp_path / "a.gp"
    path.write_bytes(b"one")
    assert file_digest(path) == hashlib.sha256(b"one").hexdigest()
    path.write_bytes(b"three")
    assert file_digest(str(path)) == hashlib.sha256(b"three").hexdigest()
    with pytest.raises(FileError, match=r"there is no file .*b\.gp"):
        file_digest(tmp_path / "b.gp")


@pytest.mark.parametrize("problem", [None, FileError("cut short")])
def test_a_file_that_changes_while_it_is_read(tmp_path, problem):
    path = tmp_path / "a.gp"
    path.write_text("one")
    with pytest.raises(FileError, match=r"a\.gp has changed while it was read"), unchanged(path):
        os.utime(path, ns=(0, 1))
        if problem:
            raise problem
    with pytest.raises(FileError, match="cut short"), unchanged(path):
        raise FileError("cut short")


def test_shapes_in_memory():
    held = octahedron()
    assert held.name == "six points" and held.read() is held.shape
    assert held.digest() == octahedron(np.asfortranarray(CORNERS)).digest()
    assert held.digest() == pickle.loads(pickle.dumps(held)).digest()
    assert held.digest() != octahedron(CORNERS * (1.0 + 1e-15)).digest()


def test_what_was_computed_of_a_metric_is_no_part_of_its_hash():
    metric = GridMetric.sampled(KerrNewmanHorizon(1.0, 0.5).data().metric, 8, 16)
    before = HeldSlice(metric).digest()
    assert metric.error is not None and "error" in vars(metric)
    assert HeldSlice(metric).digest() == before


def test_slices_in_memory():
    geometry = BrillLindquist([0.5, 0.5], [[0, 0, 0.4], [0, 0, -0.4]])
    held = HeldSlice(geometry)
    assert held.read(LOW, HIGH) is geometry and held.name == "BrillLindquist"
    assert held.digest() == HeldSlice(BrillLindquist([0.5, 0.5], [[0, 0, 0.4], [0, 0, -0.4]])).digest()
    assert held.digest() != HeldSlice(BrillLindquist([0.5, 0.5], [[0, 0, 0.41], [0, 0, -0.4]])).digest()


def test_functions_of_slices_in_memory_count_by_their_values(monkeypatch):
    def digest(geometry):
        return HorizonTask(Moment("a", 0.0, None, HeldShape(SPHERE), HeldSlice(geometry))).digest()

    def gamma(x):
        return ((1.0 + MASS / np.sqrt((x**2).sum(axis=1))) ** 4)[:, None, None] * np.eye(3)

    def again(x):
        return (x.dtype.type(1.0) + MASS / np.sqrt((x**2).sum(axis=1)))[:, None, None] ** 4 * np.eye(3)

    again.__name__, again.__qualname__ = gamma.__name__, gamma.__qualname__
    still = digest(AnalyticCallable(lambda x: 0.0 * x))  # no metric, but a digest
    before = digest(AnalyticCallable(gamma))
    assert still != before == digest(AnalyticCallable(again))
    curved = AnalyticCallable(gamma, lambda x: 0.1 * gamma(x))
    assert digest(curved) != before
    monkeypatch.setitem(globals(), "MASS", 0.65)
    assert digest(AnalyticCallable(gamma)) != before
    monkeypatch.setitem(globals(), "MASS", 0.5)
    assert digest(AnalyticCallable(gamma)) == before


def test_functions_of_surfaces_in_memory_count_by_their_values():
    def digest(k):
        data = SurfaceData(KerrNewmanHorizon(1.0, 0.5).data().metric, lambda u: np.full(len(u), k))
        return HorizonTask(Moment("a", 0.0, None, HeldShape(data))).digest()

    assert digest(0.5) == digest(0.5) != digest(0.5 + 1e-6)


def test_a_function_that_fails_has_a_digest():
    def fails(x):
        raise ZeroDivisionError

    moment = Moment("a", 0.0, None, HeldShape(SPHERE), HeldSlice(AnalyticCallable(fails)))
    assert len(HorizonTask(moment).digest()) == 64


def test_a_slice_that_is_missing():
    missing = MissingSlice("there is no slice for ah1 at iteration 7")
    assert missing.digest() != MissingSlice("there is none").digest()
    with pytest.raises(FileError, match="no slice for ah1 at iteration 7"):
        missing.read(LOW, HIGH)


@pytest.mark.parametrize(
    ("series", "time", "iteration", "position", "label"),
    [
        ("ah1", 2.0, 1024, 3, "ah1.t1024"),
        ("Nested/AhB", 0.125, None, 3, "Nested_AhB.T0.125"),
        ("a", 1.0 / 3.0, None, None, "a.T0.333333333"),
        ("a", None, None, 3, "a.3"),
        ("a", None, None, None, "a"),
    ],
)
def test_labels(series, time, iteration, position, label):
    assert Moment(series, time, iteration, octahedron(), position=position).label == label
