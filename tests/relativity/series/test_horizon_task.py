"""The task of a moment: its answer, what is in the way of it, and that nothing else has a part in it."""

import json
import pickle
from dataclasses import dataclass, replace

import numpy as np
import pytest

from horizons import check
from isoembed.errors import InvalidMetric, InvalidParameter, NotEmbedded
from isoembed.io.files import FileError
from isoembed.meshing.sphere import fibonacci_directions
from isoembed.relativity import (
    BrillLindquist,
    CoordinateShape,
    HorizonOptions,
    HorizonTask,
    KerrNewmanHorizon,
    KerrSchild,
    Moment,
    StarSurface,
    SurfaceData,
    embed_surface,
    find_horizon,
)
from isoembed.relativity.series import horizon_task
from isoembed.relativity.series.source import HeldShape, HeldSlice, MissingSlice
from isoembed.runs import Result, run
from isoembed.smooth import GridMetric
from isoembed.space import Hyperbolic

FEW = HorizonOptions(vertices=60)


def kerr(spin, position=0, series="ah1"):
    """The horizon of a Kerr-Schild slice as a surface."""
    geometry = KerrSchild(1.0, (0.0, 0.6 * spin, 0.8 * spin))
    shape = StarSurface.from_radius(geometry.spheroid(geometry.horizon))
    return Moment(series, 0.5 * position, 16 * position, HeldShape(shape, "h.gp"), HeldSlice(geometry))


def gridded(spin, position=0, series="ah1"):
    """The metric of a Kerr horizon on a grid, which takes the least time."""
    data = SurfaceData(GridMetric.sampled(KerrNewmanHorizon(1.0, spin), 24, 1), marginal=True)
    return Moment(series, 0.5 * position, 16 * position, HeldShape(data, "h.npz"))


@pytest.fixture(scope="module")
def begun():
    return HorizonTask(gridded(0.5), FEW).compute(None)


@pytest.fixture(scope="module")
def first():
    return HorizonTask(kerr(0.5), FEW).compute(None)


@dataclass(frozen=True)
class Failing:
    """A source that cannot be read."""

    error: Exception
    name: str = "h.t0.ah1.gp"

    def digest(self):
        raise self.error

    def read(self, *_):
        raise self.error


def test_an_answer(first):
    assert first.label == "ah1.t0" and first.status == "embedded" and first.answered
    check(first.report, 0.5)
    assert first.report["moment"] == {
        **{"series": "ah1", "time": 0.0, "iteration": 0},
        **{"shape": "h.gp", "slice": "KerrSchild"},
    }
    assert first.report["name"] == "h.gp" and first.report["horizon"]["marginal"]
    assert abs(first.report["spin"]["J"] - 0.5) <= first.report["spin"]["error"] < 1e-6
    assert first.arrays["vertices"].shape == (60, 3) and first.arrays["faces"].shape == (116, 3)
    for name in ("mean_curvature", "residual", "theta_plus", "angular_momentum_density"):
        assert first.arrays[f"field/{name}"].shape == (60,)
    assert first.arrays["field/slice_coordinates"].shape == (60, 3)
    mesh = horizon_task.mesh_of(first)
    assert {"vertices", "faces", "mean_curvature", "slice_coordinates"} < set(mesh)
    assert not any(name.startswith("surface") for name in mesh)


def test_the_next_one_has_the_same_bits_from_memory_and_from_a_file(begun, tmp_path):
    begun.writer(tmp_path / "first.npz")
    task = HorizonTask(gridded(0.51, 1), FEW)
    results = [task.compute(before) for before in (begun, Result.read(tmp_path / "first.npz"))]
    results.append(pickle.loads(pickle.dumps(task)).compute(begun))
    for other in results[1:]:
        assert results[0].report == other.report and set(results[0].arrays) == set(other.arrays)
        for name, array in results[0].arrays.items():
            np.testing.assert_array_equal(array, other.arrays[name])
    for name in ("faces", "directions"):
        np.testing.assert_array_equal(begun.arrays[name], results[0].arrays[name])


@pytest.mark.slow
def test_numbers_do_not_depend_on_the_start_beyond_their_errors(first):
    task = HorizonTask(kerr(0.7, 1), FEW)
    alone, started = (task.compute(before).report for before in (None, first))
    assert alone != started
    for name, error in alone["errors"].items():
        if error is not None:
            assert abs(alone[name] - started[name]) <= error + started["errors"][name] < 1e-9


def test_another_series_is_no_start(begun, monkeypatch):
    monkeypatch.setattr(horizon_task.Start, "restored", lambda *_: pytest.fail("the other series is a start"))
    assert HorizonTask(gridded(0.51, 1, "ah2"), FEW).compute(begun).answered
    with pytest.raises(pytest.fail.Exception):
        HorizonTask(gridded(0.51, 1), FEW).compute(begun)


@pytest.mark.parametrize("error", [NotEmbedded("astray", None), InvalidParameter("the map folds")])
def test_where_the_start_leads_nowhere_a_mesh_does(begun, monkeypatch, error):
    def without_start(data, *, space, start=None, vertices=1000):
        if start is not None:
            raise error
        return embed_surface(data, space=space, vertices=vertices)

    monkeypatch.setattr(horizon_task, "embed_surface", without_start)
    assert HorizonTask(gridded(0.5), FEW).compute(begun).report == begun.report


def test_digests():
    task = HorizonTask(kerr(0.5), FEW)
    assert task.digest() == HorizonTask(kerr(0.5), FEW).digest() == pickle.loads(pickle.dumps(task)).digest()
    others = [
        HorizonTask(kerr(0.5000001), FEW),
        HorizonTask(kerr(0.5, 1), FEW),
        HorizonTask(replace(kerr(0.5), slice=HeldSlice(KerrSchild(1.0, (0.0, 0.3, 0.41)))), FEW),
        HorizonTask(kerr(0.5), replace(FEW, vertices=61)),
        HorizonTask(kerr(0.5), replace(FEW, wang_yau=True)),
        HorizonTask(kerr(0.5), replace(FEW, axis=(0.0, 0.0, 1.0))),
        HorizonTask(kerr(0.5), replace(FEW, marginal=True)),
        HorizonTask(kerr(0.5), replace(FEW, space="hyperbolic")),
        HorizonTask(kerr(0.5), replace(FEW, space=Hyperbolic(0.1))),
        HorizonTask(replace(kerr(0.5), shape=Failing(FileError("cut short"))), FEW),
    ]
    digests = {other.digest() for other in (task, *others)}
    assert len(digests) == len(others) + 1
    # Where a file is does not matter, but what is in it.
    assert (
        HorizonTask(replace(kerr(0.5), shape=replace(kerr(0.5).shape, called="x.gp")), FEW).digest()
        in digests
    )


def test_the_slice_is_read_as_far_as_the_surface_reaches_and_a_little_more():
    boxes = []

    class Seen(HeldSlice):
        def read(self, low, high):
            boxes.append((low, high))
            raise FileError("enough")

    u = np.array([*np.eye(3), *-np.eye(3)])
    octahedron = CoordinateShape.star_shaped([1.0, 2.0, 3.0] + 0.5 * u, "six", np.array([1.0, 2.0, 3.0]))
    slice_ = Seen(BrillLindquist((1.0,), ((1.0, 2.0, 3.0),)))
    for shape in (octahedron, StarSurface.sphere((1.0, 2.0, 3.0), 0.5)):
        HorizonTask(Moment("ah1", None, None, HeldShape(shape), slice_), FEW).compute(None)
    assert len(boxes) == 2
    for low, high in boxes:
        np.testing.assert_allclose([low, high], [[0.48, 1.48, 2.48], [1.52, 2.52, 3.52]], atol=3e-3)


REFUSED = [
    ({"shape": Failing(FileError("h.gp, line 7: cut short"))}, "h.gp, line 7: cut short"),
    ({"shape": Failing(InvalidMetric("no metric"))}, "no metric"),
    ({"slice": None}, "h.gp is a surface in coordinates: name its geometry"),
    ({"slice": MissingSlice("no slice has t = 0.5")}, "no slice has t = 0.5"),
    ({"slice": Failing(InvalidParameter("too small"))}, "too small"),
    (
        {"shape": HeldShape(KerrNewmanHorizon(1.0, 0.5).data())},
        "has a metric of its own: leave out the geometry",
    ),
]


@pytest.mark.parametrize(("part", "sentence"), REFUSED)
def test_refusals(part, sentence, monkeypatch):
    monkeypatch.setattr(horizon_task, "embed_surface", lambda *_, **__: pytest.fail("it computed"))
    moment = replace(kerr(0.5, 3), **part)
    found = HorizonTask(moment, FEW).compute(None)
    assert found.status == "refused" and not found.answered and sentence in found.message
    assert found.report["name"] == moment.shape.name
    assert [found.report["moment"][key] for key in ("series", "time", "iteration")] == ["ah1", 1.5, 48]


def test_a_lack_of_memory_is_a_result():
    task = HorizonTask(replace(kerr(0.5), shape=Failing(MemoryError())), FEW)
    [found] = [outcome.result for outcome in run([task])]
    assert (found.status, found.message) == ("failed", "not enough memory")
    assert found.report["moment"]["series"] == "ah1"


def test_what_does_not_embed_is_reported_without_arrays():
    grid = KerrNewmanHorizon(1.0, 0.9).data()
    found = HorizonTask(Moment("ah1", 2.0, None, HeldShape(grid)), FEW).compute(None)
    assert found.status == "not embedded" and not found.answered
    assert "no surface of revolution" in found.message
    assert found.report["irreducible_mass"] > 0.0 and found.report["brown_york"] is None
    assert found.report["moment"]["time"] == 2.0


@pytest.mark.slow
def test_a_horizon_that_was_found_brings_its_slice(first):
    geometry = KerrSchild(1.0, (0.0, 0.3, 0.4))
    surface = StarSurface.from_radius(geometry.spheroid(geometry.horizon))
    found = HorizonTask(Moment("ah1", 0.0, 0, HeldShape(find_horizon(geometry, surface))), FEW).compute(None)
    assert found.report["moment"]["slice"] is None
    assert abs(found.report["liu_yau"] - first.report["liu_yau"]) < 1e-9
    assert found.report["horizon"]["outer"]


def test_the_time_of_a_moment_and_of_its_file():
    slice_ = HeldSlice(BrillLindquist((1.0,), ((0.0, 0.0, 0.0),)))
    points = 0.5 * fibonacci_directions(100)
    shape = CoordinateShape.star_shaped(points, "points", np.zeros(3), time=0.25)
    found = None
    for said, time in ((None, 0.25), (0.75, 0.75)):
        found = HorizonTask(Moment("ah1", said, 8, HeldShape(shape), slice_), FEW).compute(found)
        assert found.report["moment"]["time"] == found.report["horizon"]["time"] == time
        assert found.report["horizon"]["iteration"] == 8 and found.report["horizon"]["points"] == 100
    json.dumps(found.report, allow_nan=False)


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"vertices": 11}, "the number of vertices must be at least 12, not 11"),
        ({"axis": (0.0, 0.0, 0.0)}, "the axis must not be zero"),
        ({"axis": (0.0, np.nan, 1.0)}, "three finite numbers"),
    ],
)
def test_wrong_options(given, sentence):
    with pytest.raises(InvalidParameter, match=sentence):
        HorizonOptions(**given)


def test_a_metric_on_a_grid_needs_no_slice(begun):
    assert begun.label == "ah1.t0" and begun.report["moment"]["slice"] is None
    assert abs(begun.report["integrated_mean_curvature"] - 24.300446945608874) < 1e-6
