"""The one verb: what it returns and raises, progress, stages, the report, whatever the method."""

import json
import pickle
from importlib.metadata import EntryPoint
from types import SimpleNamespace

import numpy as np
import pytest

import isoembed
import smooth_bodies
import zoo
from isoembed import InvalidParameter, embed
from isoembed.aim.adaptive import Aim
from isoembed.aim.paper import Paper
from isoembed.embedding.embedding import Embedding
from isoembed.errors import NotEmbedded
from isoembed.io import FileError
from isoembed.methods import as_method, method_names
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.progress.stages import Log
from isoembed.surface.alignment import distance

METHODS = {"aim": Aim(), "paper": Paper(Tsteps=2, max_iterations=10)}


def metric(noise=0.0):
    exact = PolyhedralMetric.from_mesh(*smooth_bodies.ellipsoid(100))
    factors = 1 + noise * np.random.default_rng(0).normal(size=len(exact.lengths))
    return exact.with_lengths(exact.lengths * factors)


@pytest.mark.parametrize("method", METHODS)
def test_by_name_or_configured(method):
    by_name = isoembed.embed(metric(), method=method)
    configuration = {"aim": Aim(), "paper": Paper()}[method]
    assert (isoembed.embed(metric(), method=configuration).vertices == by_name.vertices).all()
    assert by_name.method == method
    assert by_name.converged
    assert as_method(configuration) is configuration


def test_meshes_are_taken_by_their_lengths():
    x, faces = zoo.icosphere(1)
    trimesh = SimpleNamespace(vertices=x, faces=faces)
    pyvista = SimpleNamespace(points=x, faces=np.insert(faces, 0, 3, axis=1).ravel())
    for mesh in ((x, faces), trimesh, pyvista, embed((x, faces))):
        assert distance(embed(mesh).vertices, x) < 1e-10
    with pytest.raises(InvalidParameter, match=r"the metric is a dict: give PolyhedralMetric\(faces, "):
        embed({})


def test_files_are_taken(tmp_path):
    x, faces = zoo.icosphere(1)
    path = tmp_path / "mesh.obj"
    embed((x, faces)).save(path)
    for given in (str(path), path):
        assert distance(embed(given).vertices, x) < 1e-10
    with pytest.raises(FileError, match="there is no file"):
        embed(tmp_path / "none.obj")


def test_a_net_is_folded_without_a_method(tmp_path):
    cube = hexahedron()
    isoembed.unfold(cube).save(tmp_path / "net.json")
    for given in (isoembed.glue(tmp_path / "net.json"), str(tmp_path / "net.json")):
        assert embed(given).volume == pytest.approx(1, rel=1e-12)
    glued = isoembed.GluedMetric.of(cube.metric)
    assert embed(glued).method == "alexandrov"
    with pytest.raises(InvalidParameter, match="the method 'aim' keeps the given triangles"):
        embed(glued, method="aim")


def hexahedron():
    """The unit cube, as `isoembed.embed` returns it."""
    corners = [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return embed(PolyhedralMetric.from_mesh(corners, faces))


@pytest.mark.parametrize("ending", [".json", ".fold"])
def test_what_is_unfolded_is_glued(tmp_path, ending):
    cube = hexahedron()
    unfolding = isoembed.unfold(cube)
    assert isoembed.glue(unfolding).n_vertices == 8
    path = tmp_path / f"net{ending}"
    unfolding.save(path)
    assert isoembed.glue(path).n_vertices == 8
    with pytest.raises(InvalidParameter, match="corners can be given only with arrays"):
        isoembed.glue(path, corners=["abc"])


def test_files_and_meshes_are_unfolded(tmp_path):
    cube = hexahedron()
    cube.save(tmp_path / "cube.ply")
    for given in (tmp_path / "cube.ply", (cube.vertices, cube.faces)):
        assert len(isoembed.unfold(given).sheets) == 1
    with pytest.raises(InvalidParameter, match="the surface is a dict: give the path of a file, or a mesh"):
        isoembed.unfold({})


def test_a_file_is_read_as_what_it_holds(tmp_path):
    cube = hexahedron()
    cube.save(tmp_path / "cube.fold")
    isoembed.io.write_metric(tmp_path / "metric.json", cube.metric)
    isoembed.unfold(cube).save(tmp_path / "net.json")
    isoembed.unfold(cube).save(tmp_path / "net.fold")
    assert isoembed.read(tmp_path / "cube.fold").volume == pytest.approx(1)
    assert isinstance(isoembed.read(tmp_path / "metric.json"), PolyhedralMetric)
    for net in ("net.json", "net.fold"):
        assert isoembed.read(tmp_path / net).n_vertices == 8


@pytest.mark.parametrize("ending", [".ply", ".npz", ".html"])
def test_a_surface_is_saved_by_the_ending(tmp_path, ending):
    path = tmp_path / f"cube{ending}"
    hexahedron().save(path)
    assert path.stat().st_size > 500


def test_what_is_not_saved(tmp_path):
    cube = hexahedron()
    with pytest.raises(InvalidParameter, match=r"color is for pictures \(.png, .svg, .pdf\)"):
        cube.save(tmp_path / "cube.obj", color="residual")
    with pytest.raises(FileError, match="jpg"):
        cube.save(tmp_path / "cube.jpg")
    with pytest.raises(FileError, match="ply"):
        isoembed.unfold(cube).save(tmp_path / "net.ply")


def test_the_default_is_aim():
    assert isoembed.embed(metric()).method == "aim"
    assert isoembed.embed(metric()).tolerance == 1e-10


@pytest.mark.parametrize("tolerance", [0.0, -1e-9, float("nan")])
def test_a_tolerance_that_is_none(tolerance):
    with pytest.raises(ValueError, match=r"the tolerance is .*, not a positive finite number"):
        isoembed.embed(metric(), tolerance=tolerance)


def test_an_unknown_method():
    with pytest.raises(ValueError, match="there is no method 'weyl'; there are aim, paper"):
        isoembed.embed(metric(), method="weyl")


class Lying(isoembed.Method):
    """A method that is content with any vertices."""

    name = "lying"

    def run(self, metric, tolerance, log):
        with log.stage("guess"):
            vertices = np.random.default_rng(0).normal(size=(metric.triangulation.n_vertices, 3))
        return Embedding(metric, vertices, method=self.name, tolerance=tolerance, stages=log.stages)


def test_no_method_is_taken_at_its_word():
    with pytest.raises(NotEmbedded, match="the lengths miss the tolerance 1e-10") as caught:
        isoembed.embed(metric(), method=Lying())
    assert caught.value.embedding.method == "lying"
    assert [stage.name for stage in caught.value.embedding.stages] == ["guess"]
    assert isoembed.embed(metric(), method=Lying(), tolerance=100.0).converged


@pytest.mark.parametrize("method", METHODS)
def test_a_tolerance_beyond_rounding_is_not_met_and_the_best_attempt_says_how_near_it_came(method):
    with pytest.raises(NotEmbedded) as caught:
        isoembed.embed(metric(), method=METHODS[method], tolerance=1e-18)
    assert caught.value.embedding.residual < 1e-12


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("noise", [0.0, 0.05], ids=["converged", "not converged"])
def test_the_report(method, noise):
    try:
        surface = isoembed.embed(metric(noise), method=METHODS[method])
    except NotEmbedded as error:
        surface = error.embedding
        assert str(error) == surface.message
        assert isinstance(error, RuntimeError)
    report = json.loads(json.dumps(isoembed.report(surface), allow_nan=False))
    assert report["status"] == ("not converged" if noise else "converged")
    assert report["method"] == method
    assert report["message"] == surface.message
    assert (report["residual"]["max"] > 1e-10) == bool(noise)
    assert report["input"]["vertices"] == 100
    assert all(stage["seconds"] >= 0 for stage in report["stages"])
    assert sum(stage["factorizations"] for stage in report["stages"]) >= 3


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("noise", [0.0, 0.05], ids=["converged", "not converged"])
def test_progress_comes_in_order(method, noise):
    seen = []
    try:
        surface = isoembed.embed(metric(noise), method=METHODS[method], progress=seen.append)
    except NotEmbedded as error:
        surface = error.embedding
    stages = [stage.name for stage in surface.stages]
    assert list(dict.fromkeys(snapshot.stage for snapshot in seen)) == stages
    assert [stages.index(snapshot.stage) for snapshot in seen] == sorted(
        stages.index(snapshot.stage) for snapshot in seen
    )
    seconds = [snapshot.seconds for snapshot in seen]
    assert seconds == sorted(seconds)
    for stage in surface.stages:
        iterations = [snapshot.iteration for snapshot in seen if snapshot.stage == stage.name]
        assert iterations == sorted(iterations)
        assert iterations[0] == 0
        assert iterations[-1] <= stage.iterations
    for stage in stages:  # a stage may begin the way back anew
        times = [snapshot.t for snapshot in seen if snapshot.stage == stage and snapshot.t is not None]
        assert times == sorted(times, reverse=True)
    if not noise:
        assert next(snapshot.t for snapshot in reversed(seen) if snapshot.t is not None) == 0


def test_watching_changes_nothing():
    assert (isoembed.embed(metric(), progress=[].append).vertices == isoembed.embed(metric()).vertices).all()


def test_an_interrupted_stage_is_recorded():
    log = Log()
    with pytest.raises(KeyboardInterrupt), log.stage("uniformize") as recorder:
        recorder.iterations += 3
        recorder.factorizations += 2
        raise KeyboardInterrupt
    (stage,) = log.stages
    assert (stage.name, stage.iterations, stage.factorizations) == ("uniformize", 3, 2)
    assert stage.seconds >= 0


def test_a_listener_that_raises_ends_the_computation():
    class Stopped(Exception):  # noqa: N818
        pass

    def stop(snapshot):
        if snapshot.stage == "radii":
            raise Stopped

    with pytest.raises(Stopped):
        isoembed.embed(metric(), progress=stop)


def test_the_lengths_are_not_touched():
    given = metric()
    before = given.lengths.copy()
    isoembed.embed(given)
    assert (given.lengths == before).all()


def test_the_same_input_gives_the_same_output():
    vertices, faces = zoo.random_hull(40, 3)
    surfaces = [isoembed.embed(PolyhedralMetric.from_mesh(vertices, faces)) for _ in range(2)]
    assert (surfaces[0].vertices == surfaces[1].vertices).all()


def test_what_is_no_metric_or_method_is_refused_in_words():
    metric = PolyhedralMetric([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]], [1.0] * 6)
    with pytest.raises(isoembed.InvalidParameter, match="the metric is a ndarray"):
        isoembed.embed(np.ones(6))
    with pytest.raises(isoembed.InvalidParameter, match=r"the class Paper: make one, Paper\(\)"):
        isoembed.embed(metric, method=Paper)


def test_a_failure_cannot_be_made_a_success_and_survives_pickling():
    vertices, faces = zoo.icosphere(1)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    attempt = isoembed.Embedding(metric, 1.1 * vertices, method="aim", tolerance=1e-10)
    with pytest.raises(ValueError, match="read-only"):
        attempt.residuals[:] = 0
    isoembed.report(attempt)["status"] = "converged"
    assert isoembed.report(attempt)["status"] == "not converged"
    error = pickle.loads(pickle.dumps(isoembed.NotEmbedded("no", attempt)))
    assert str(error) == "no"
    assert error.embedding.residual == attempt.residual
    assert error.evidence.kind == "searched"


def test_a_failure_says_whether_absence_is_proved():
    proof = isoembed.Evidence("proved", "Gauss-Bonnet")
    error = pickle.loads(pickle.dumps(isoembed.NoHorizon("no", 0.5, proof)))
    assert (str(error), error.least, error.evidence) == ("no", 0.5, proof)
    assert isoembed.NoHorizon("no").evidence.report["evidence"] == "searched"


@pytest.mark.parametrize("flow", ["BDF", "RK45"])
def test_a_flow_that_leaves_the_metrics_is_a_failure_of_the_method(flow):
    # Stacked vertices: the flow breaks triangles, which must not be blamed on the input.
    faces, rng = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]], np.random.default_rng(0)
    points = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1.0]])
    for _ in range(20):
        a, b, c = faces.pop(rng.integers(len(faces)))
        points = np.vstack([points, 1.02 * points[[a, b, c]].mean(axis=0)])
        v = len(points) - 1
        faces += [[a, b, v], [b, c, v], [c, a, v]]
    metric = PolyhedralMetric.from_mesh(points, faces)
    method = Paper(flow=flow, t_f=1.0, Tsteps=2, max_iterations=5)
    try:
        surface = isoembed.embed(metric, method=method)
    except isoembed.NotEmbedded as error:
        surface = error.embedding
    assert np.isfinite(surface.vertices).all()


class Scaled(isoembed.Method):
    """Knows the surface, in the unit in which it is asked for it, and another one."""

    name = "scaled"

    def __init__(self, vertices):
        self.vertices = vertices

    def run(self, metric, tolerance, log):
        assert 1 <= metric.mean_length < 2
        vertices = self.vertices / PolyhedralMetric.from_mesh(self.vertices, metric.faces).unit
        found = Embedding(metric, vertices, method=self.name, tolerance=tolerance)
        other = Embedding(metric, vertices @ np.diag([1, 1, -1]), method=self.name, tolerance=tolerance)
        assert found.mean_curvature.size == metric.triangulation.n_vertices
        return found._with_others([other])


def test_the_unit_is_restored_and_nothing_is_measured_again(monkeypatch):
    vertices, faces = zoo.icosphere(1)
    vertices = 2.0**-500 * vertices
    given = PolyhedralMetric.from_mesh(vertices, faces)
    calls = []
    measure = isoembed.surface.measures.edge_lengths
    monkeypatch.setattr(
        "isoembed.surface.measures.edge_lengths", lambda *args: calls.append(0) or measure(*args)
    )
    surface = isoembed.embed(given, method=Scaled(vertices))
    assert surface.metric is given
    assert surface.residual == surface.others[0].residual == 0
    assert len(calls) == 2  # once for each surface
    assert (surface.vertices == vertices).all()
    assert surface.others[0].metric is given
    again = Embedding(given, vertices, method="scaled", tolerance=1e-10)
    assert (surface.mean_curvature == again.mean_curvature).all()
    assert (surface.volume, surface.area) == (again.volume, again.area)


class EntryPoints(dict):
    """What `importlib.metadata.entry_points` finds where a package brings methods."""

    names = property(dict.keys)

    def __call__(self, *, group, name=None):
        assert group == "isoembed.methods"
        found = [EntryPoint(key, value, group) for key, value in self.items()]
        return self if name is None else [point for point in found if point.name == name]


def test_methods_of_installed_packages(monkeypatch):
    installed = EntryPoints(
        counting="counting:Counting",
        gone="no_such_module:Method",
        what="counting:STAGE",
        aim="counting:Counting",
    )
    monkeypatch.setattr("isoembed.methods.entry_points", installed)
    vertices, faces = zoo.icosphere(1)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    assert isoembed.embed(metric, method="counting").method == "counting"
    assert isoembed.embed(metric, method="aim").method == "aim"
    assert method_names() == ("aim", "paper", "alexandrov", "sheet", "counting", "gone", "what")
    for name, said in (
        ("gone", "'gone' cannot be loaded from no_such_module:Method: ModuleNotFoundError"),
        ("what", "'what' is counting:STAGE, which is not derived from isoembed.Method"),
        ("else", "there is no method 'else'; there are aim, paper, alexandrov, sheet, counting"),
    ):
        with pytest.raises(isoembed.InvalidParameter, match=said):
            isoembed.embed(metric, method=name)


def test_what_a_method_takes_is_asked_of_it():
    class Gluing(Lying):
        takes_glued = takes_doubly_covered = True

    assert not Lying.takes_glued
    two = PolyhedralMetric([[0, 1, 2], [0, 2, 1]], [1.0] * 3)
    for given in (two, isoembed.GluedMetric.of(two)):
        with pytest.raises(isoembed.InvalidParameter, match="the method 'lying'"):
            isoembed.embed(given, method=Lying())
    assert isoembed.embed(two, method=Gluing(), tolerance=100.0).converged


def test_what_is_not_derived_from_method_is_refused():
    with pytest.raises(isoembed.InvalidParameter, match=r"is a Recorder: derive it from isoembed\.Method"):
        isoembed.embed(metric(), method=type("Recorder", (), {})())


@pytest.mark.parametrize("method", ["aim", "alexandrov"])
def test_lengths_that_floats_hardly_hold_are_measured_where_they_end(method):
    vertices, faces = zoo.random_hull(12, seed=1)
    with pytest.raises(NotEmbedded, match="miss the tolerance") as caught:
        isoembed.embed(PolyhedralMetric.from_mesh(1e-319 * vertices, faces), method=method)
    assert caught.value.embedding.residual > 1e-6


@pytest.mark.parametrize("mean", [1.999, 2 - 1e-12, 2.0, 2.001])
def test_a_certificate_does_not_depend_on_the_unit(mean):
    vertices, faces = zoo.random_hull(12, seed=1)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    surface = isoembed.embed(metric.scaled(mean / metric.mean_length), method="alexandrov")
    tables, core = surface.core
    off = np.linalg.norm(core[tables.faces] - np.roll(core[tables.faces], -1, axis=1), axis=2)
    assert np.abs(off - tables.face_lengths).max() < 1e-13
    assert np.allclose(core, surface.vertices, atol=1e-13)
    assert isoembed.certify(surface).certified and isoembed.certify(surface).distance < 3e-14
