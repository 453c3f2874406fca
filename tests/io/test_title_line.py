"""What files say of a surface or a metric as a whole: its space, the precision of its coordinates, errors."""

import json
import re

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import solids
import zoo
from isoembed import Embedding, Hyperbolic, InvalidMetric, PolyhedralMetric, Space, Spherical, embed
from isoembed.embedding.polyhedron import Polyhedron
from isoembed.errors import MeshNote
from isoembed.gluing import unfold
from isoembed.io import (
    METRIC_ENDINGS,
    SURFACE_ENDINGS,
    FileError,
    mesh_writer,
    read_metric,
    read_surface,
    write_metric,
    write_surface,
)
from isoembed.io.title_line import title_data, title_line
from isoembed.space.models import MODELS, to_model
from regular_in_space import regular_solid

VERTICES, FACES = zoo.random_hull(40, seed=5)
CURVATURES = (-1.0, 0.7, -1e-9)
TETRAHEDRON = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]


def body(curvature, kind=Embedding):
    metric = PolyhedralMetric.from_mesh(0.6 * VERTICES, FACES, curvature=curvature)
    return kind(metric, 0.6 * VERTICES, method="exact", tolerance=1e-10)


def cube():
    """A cube of hyperbolic space, some radii of curvature wide, with its six faces."""
    solid = regular_solid("cube", -1.0, 1.2)
    metric = PolyhedralMetric.from_mesh(solid.points, solid.faces, curvature=-1.0)
    return Polyhedron(metric, solid.points, method="exact", tolerance=1e-10)


@pytest.mark.parametrize("curvature", CURVATURES)
@pytest.mark.parametrize("ending", METRIC_ENDINGS)
def test_metrics_say_their_curvature(curvature, ending, tmp_path):
    metric = body(curvature).metric
    write_metric(tmp_path / f"m{ending}", metric)
    again = read_metric(tmp_path / f"m{ending}")
    assert again.space == Space(curvature)
    np.testing.assert_array_equal(again.lengths, metric.lengths)


@pytest.mark.parametrize("curvature", CURVATURES)
@pytest.mark.parametrize("ending", SURFACE_ENDINGS)
def test_surfaces_come_back_in_their_space(curvature, ending, tmp_path):
    given, path = body(curvature), tmp_path / f"s{ending}"
    write_surface(path, given)
    again = read_surface(path)
    assert again.space == given.space
    np.testing.assert_allclose(np.sort(again.metric.lengths), np.sort(given.metric.lengths), rtol=1e-13)
    assert again.area == pytest.approx(given.area, rel=1e-13)
    assert again.volume == pytest.approx(given.volume, rel=1e-11)
    if ending != ".stl":  # whose vertices are numbered anew
        np.testing.assert_allclose(again.vertices, given.vertices, rtol=1e-14, atol=1e-15)


def test_files_hold_the_points_of_poincares_ball(tmp_path):
    given = body(-1.0)
    write_surface(tmp_path / "s.npz", given)
    write_surface(tmp_path / "s.json", given)
    document = json.loads((tmp_path / "s.json").read_text())
    heights = np.sqrt(1 + (given.vertices**2).sum(axis=1))
    with np.load(tmp_path / "s.npz") as archive:
        assert float(archive["curvature"]) == document["curvature"] == -1.0
        assert str(archive["model"]) == document["model"] == "conformal"
        np.testing.assert_allclose(
            archive["vertices"], 2 * given.vertices / (1 + heights)[:, None], rtol=1e-15
        )
        np.testing.assert_array_equal(archive["vertices"], document["vertices"])


def test_euclidean_files_are_as_they_were(tmp_path):
    given = body(0.0)
    for ending in SURFACE_ENDINGS:
        write_surface(tmp_path / f"s{ending}", given)
        assert b"curvature of space" not in (tmp_path / f"s{ending}").read_bytes()
    with np.load(tmp_path / "s.npz") as archive:
        assert set(archive) == {"vertices", "faces", "mean_curvature", "residual"}


@pytest.mark.parametrize("ending", [".ply", ".obj", ".off", ".stl", ".vtk", ".vtu", ".vtp"])
def test_meshes_say_the_space_to_people(ending, tmp_path):
    write_surface(tmp_path / f"s{ending}", body(-1.0))
    assert (
        b"isoembed: curvature of space -1.0, conformal coordinates" in (tmp_path / f"s{ending}").read_bytes()
    )


@pytest.mark.parametrize("ending", [".ply", ".off", ".obj", ".vtk", ".vtu"])
def test_other_programs_read_them(ending, tmp_path):
    meshio = pytest.importorskip("meshio")
    given = body(-1.0)
    write_surface(tmp_path / f"s{ending}", given)
    np.testing.assert_allclose(
        meshio.read(tmp_path / f"s{ending}").points,
        to_model(given.space, given.vertices, "conformal"),
        rtol=1e-15,
    )


@pytest.mark.parametrize("ending", [".ply", ".obj", ".off", ".fold", ".vtk", ".vtu", ".vtp"])
def test_faces_of_a_polyhedron_are_planes_of_space(ending, tmp_path):
    """Squares bent in the ball are one face each: no note says that they are not planar."""
    given = cube()
    write_surface(tmp_path / f"s{ending}", given)
    again = read_surface(tmp_path / f"s{ending}")
    assert len(again.polygons) == 6
    assert again.residual <= 1e-10
    assert again.volume == pytest.approx(given.volume, rel=1e-12)


def test_a_file_written_on_by_paraview_keeps_its_space(tmp_path):
    """It keeps field data, and no comments."""
    write_surface(tmp_path / "s.vtu", body(-1.0))
    text = re.sub("<!--.*-->", "", (tmp_path / "s.vtu").read_text())
    (tmp_path / "s.vtu").write_text(text)
    assert read_metric(tmp_path / "s.vtu").curvature == -1.0


@pytest.mark.parametrize("model", MODELS)
def test_other_models_are_read(model, tmp_path):
    given = body(-1.0)
    tables = {"vertices": to_model(given.space, given.vertices, model).tolist(), "faces": FACES.tolist()}
    (tmp_path / "m.json").write_text(json.dumps({**tables, "curvature": -1.0, "model": model}))
    np.testing.assert_allclose(read_metric(tmp_path / "m.json").lengths, given.metric.lengths, rtol=1e-13)
    if model == "conformal":
        (tmp_path / "m.json").write_text(json.dumps({**tables, "curvature": -1.0}))
        np.testing.assert_allclose(read_metric(tmp_path / "m.json").lengths, given.metric.lengths, rtol=1e-13)


def test_lengths_beside_vertices_are_what_residuals_are_against(tmp_path):
    given = body(0.7)
    lengths = given.metric.lengths * 1.01
    tables = {"vertices": to_model(given.space, given.vertices, "conformal"), "faces": FACES}
    np.savez(tmp_path / "s.npz", **tables, lengths=lengths, edges=given.metric.edges, curvature=0.7)
    again = read_surface(tmp_path / "s.npz")
    assert again.residual == pytest.approx(0.01 * lengths.max() / lengths.mean(), rel=0.02)
    np.savez(tmp_path / "t.npz", vertices=tables["vertices"] * [1, 1, -1], faces=FACES, curvature=0.7)
    assert read_surface(tmp_path / "t.npz").volume == pytest.approx(given.volume)  # faces are turned over


def test_vertices_are_merged_and_left_out(tmp_path):
    given = body(-1.0)
    points = to_model(given.space, given.vertices, "conformal")
    twice = np.concatenate([points, points[:3], points[:1] * 0.5])
    faces = FACES.copy()
    faces[0] = np.where(faces[0] < 3, faces[0] + len(points), faces[0])
    mesh_writer(tmp_path / "s.obj", twice, faces, curvature=np.array(-1.0))(tmp_path / "s.obj")
    with pytest.warns(match="vert"):
        again = read_metric(tmp_path / "s.obj", merge=0.0)
    np.testing.assert_allclose(np.sort(again.lengths), np.sort(given.metric.lengths), rtol=1e-12)


def test_the_space_of_a_file_that_does_not_say_it(tmp_path):
    write_metric(tmp_path / "m.npz", body(0.0).metric)
    assert read_metric(tmp_path / "m.npz").space.is_euclidean
    assert read_metric(tmp_path / "m.npz", space=Hyperbolic(2.0)).curvature == -2.0
    sentence = "m.npz does not contain the curvature of its space: give it, as in spherical=1"
    with pytest.raises(FileError, match=sentence):
        read_metric(tmp_path / "m.npz", space="spherical")


def test_the_space_of_a_file_that_says_it(tmp_path):
    write_metric(tmp_path / "m.json", body(-1.0).metric)
    for same in ("hyperbolic", Hyperbolic(1.0)):
        assert read_metric(tmp_path / "m.json", space=same).curvature == -1.0
    for other, said in [("spherical", "spherical space"), (Hyperbolic(2.0), "that of curvature -2.0")]:
        with pytest.raises(
            FileError, match=f"m.json is in hyperbolic space of curvature -1.0, not in {said}"
        ):
            read_metric(tmp_path / "m.json", space=other)


@pytest.mark.parametrize(
    ("said", "sentence"),
    [
        ({"curvature": "flat"}, "the curvature of space is 'flat', not a finite number"),
        ({"curvature": [1.0]}, "the curvature of space is '\\[1.0\\]', not a finite number"),
        (
            {"curvature": -1.0, "model": "poincare"},
            "the model is 'poincare', none of conformal, projective, ambient",
        ),
        (
            {"curvature": -9.0},
            "point 0 is 1 from the center of the conformal model, whose boundary is at 0.666",
        ),
        ({"curvature": 1.0, "model": "ambient"}, "point 0 is 1 from the center of the ambient model"),
    ],
)
def test_what_is_refused(said, sentence, tmp_path):
    tables = {"vertices": np.eye(4)[:, :3].tolist(), "faces": [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]}
    (tmp_path / "m.json").write_text(json.dumps(tables | said))
    with pytest.raises(FileError, match=f"m.json: {sentence}"):
        read_metric(tmp_path / "m.json")


def test_the_line_says_what_it_was_given():
    tables = {"curvature": np.array(Spherical(0.1).curvature), "model": "conformal"}
    assert float(title_data(f"# {title_line(tables)}\n")["curvature"]) == 0.1
    assert title_line({}) == "" and title_data("# curvature of space") == {}


@pytest.mark.parametrize("ending", SURFACE_ENDINGS)
def test_surfaces_keep_the_precision_of_their_coordinates(ending, tmp_path):
    points = solids.uniform("dodecahedron")
    polygons = solids.polygons(points)
    rounded = np.round(points @ Rotation.random(random_state=1).as_matrix().T, 6)
    found = embed(PolyhedralMetric.from_mesh(rounded, polygons))
    write_surface(tmp_path / f"s{ending}", found)
    again = read_surface(tmp_path / f"s{ending}")
    given, kept = found.metric, again.metric
    assert kept.precision.name == given.precision.name
    assert kept.precision.length_error == pytest.approx(given.precision.length_error, rel=1e-12)
    net = unfold(again)
    assert sum(map(len, net.folds)) == 11 and len(net.sides) == 19  # of 30 edges; else each face has 3 parts


def test_a_rounding_error_that_is_none(tmp_path):
    tables = {"vertices": np.eye(4)[:, :3].tolist(), "faces": [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]}
    (tmp_path / "m.json").write_text(json.dumps(tables | {"rounding_error": [1]}))
    with pytest.raises(FileError, match=r"m\.json: the rounding error is '\[1\]', not a positive finite"):
        read_metric(tmp_path / "m.json")


@pytest.mark.parametrize("ending", METRIC_ENDINGS)
def test_length_errors_of_metrics(ending, tmp_path):
    metric = body(0.0).metric
    rng = np.random.default_rng(0)
    errors = rng.uniform(1e-3, 2e-3, len(metric.lengths))
    order = rng.permutation(len(errors))
    given = metric.faces, metric.lengths[order], metric.edges[order]
    measured = PolyhedralMetric(*given, length_errors=errors[order])
    np.testing.assert_array_equal(measured.length_errors, errors)
    write_metric(tmp_path / f"m{ending}", measured)
    again = read_metric(tmp_path / f"m{ending}")
    np.testing.assert_array_equal(again.length_errors, errors)
    np.testing.assert_array_equal(again.lengths, metric.lengths)


@pytest.mark.parametrize("ending", METRIC_ENDINGS)
def test_lengths_in_files_are_those_given(ending, tmp_path):
    """Also where a triangle inequality changed them within their errors: it changes them again."""
    given = np.array([2.1, 1.0, 1.5, 1.0, 1.5, 1.5])
    with pytest.warns(MeshNote, match="3 lengths are changed"):
        metric = PolyhedralMetric(TETRAHEDRON, given, length_errors=0.1)
    assert (metric.lengths != given).any()
    write_metric(tmp_path / f"m{ending}", metric)
    with pytest.warns(MeshNote, match="lengths are changed"):
        again = read_metric(tmp_path / f"m{ending}")
    np.testing.assert_array_equal(again.given_lengths, given)
    for one, other in zip(again.tables, metric.tables, strict=True):
        np.testing.assert_array_equal(one, other)
    with pytest.warns(MeshNote, match="lengths are changed"):
        wider = metric.with_length_errors(0.2)
    with pytest.warns(MeshNote, match="lengths are changed"):
        directly = PolyhedralMetric(TETRAHEDRON, given, length_errors=0.2)
    np.testing.assert_array_equal(wider.given_lengths, given)
    np.testing.assert_array_equal(wider.lengths, directly.lengths)
    with pytest.raises(InvalidMetric, match=r"face 0 .* breaks the triangle inequality"):
        metric.with_length_errors(1e-3)


@pytest.mark.parametrize("ending", METRIC_ENDINGS)
def test_lengths_stated_to_be_exact_stay_so_in_files(ending, tmp_path):
    vertices, faces = zoo.icosphere(2)
    lengths = PolyhedralMetric.from_mesh(vertices * [1.0, 1.1, 1.3], faces).lengths
    rounded = PolyhedralMetric(faces, np.round(lengths, 4))
    for metric, found in ((rounded, rounded.rounding), (rounded.with_length_errors(0.0), None)):
        write_metric(tmp_path / f"m{ending}", metric)
        assert read_metric(tmp_path / f"m{ending}").rounding == found
    assert rounded.rounding > 0


def test_a_mirrored_file_keeps_all_of_its_metric(tmp_path):
    """The metric of a surface that is inside out in its file has its faces turned over, and nothing else."""
    solid = body(0.0)
    metric, vertices = solid.metric, solid.vertices
    for stated in (metric.with_length_errors(0.01), metric.with_length_errors(0.0)):
        tables = {"faces": metric.faces, "lengths": metric.lengths, "edges": metric.edges}
        tables |= {"diagonals": metric.edges[:3], "precision": "7 digits", "rounding_error": 1e-7}
        errors = {"length_errors": 0.0 if stated.length_errors is None else stated.length_errors}
        np.savez(tmp_path / "s.npz", vertices=vertices * [1, 1, -1], **tables, **errors)
        again = read_surface(tmp_path / "s.npz").metric
        assert again.faces.tolist() == metric.faces[:, ::-1].tolist()
        assert again.diagonals.tolist() == [0, 1, 2] and again.precision.name == "7 digits"
        expected = stated.with_diagonals(metric.edges[:3])._turned_over
        for one, other in zip(again.tables, expected.tables, strict=True):
            np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize(
    ("errors", "sentence"),
    [
        ([0.1] * 5, r"the length errors have the shape \(5,\), not \(6,\)"),
        ([0.1] * 5 + [-1], r"the length error of edge 5 \[2, 3\] is -1.0, not a positive"),
        ([0.1] * 5 + ["x"], 'length error 5 is "x", not a number'),
        ("x", 'length_errors is "x", not a list'),
    ],
)
def test_length_errors_that_are_none(errors, sentence, tmp_path):
    tables = {"faces": [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]], "lengths": [1.0] * 6}
    (tmp_path / "m.json").write_text(json.dumps(tables | {"length_errors": errors}))
    with pytest.raises(InvalidMetric, match=sentence):
        read_metric(tmp_path / "m.json")


def test_one_length_error_for_all_edges(tmp_path):
    tables = {"faces": [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]], "lengths": [1.0] * 6}
    (tmp_path / "m.json").write_text(json.dumps(tables | {"length_errors": 0.01}))
    assert read_metric(tmp_path / "m.json").length_errors.tolist() == [0.01] * 6
    np.savez(tmp_path / "m.npz", length_errors=0.01, **tables)
    assert embed(read_metric(tmp_path / "m.npz")).length_errors.tolist() == [0.01] * 6
