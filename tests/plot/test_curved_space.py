"""Pictures and films in hyperbolic and spherical space."""

import numpy as np
import pytest

import zoo
from isoembed import Embedding, PolyhedralMetric, Space
from isoembed.embedding.polyhedron import Polyhedron
from isoembed.plot import Film, animation, figure, quantity, write_animation
from isoembed.plot.curved_space import MAX_BEND, MAX_PIECES, Drawn
from isoembed.plot.infinity import ball
from isoembed.plot.lines import Shapes, among_faces
from isoembed.plot.view import Pose, View
from isoembed.progress.stages import Progress
from isoembed.surface.segments import Segments
from isoembed.surface.surface import Surface
from regular_in_space import regular_solid

pytest.importorskip("matplotlib")


def solid(curvature, dihedral, name="cube", kind=Polyhedron, move=None):
    found = regular_solid(name, curvature, dihedral)
    points = found.points if move is None else Space(curvature).translated(found.points, np.array(move))
    metric = PolyhedralMetric.from_mesh(points, found.faces, curvature=curvature)
    return kind(metric, points, method="exact", tolerance=1e-9)


def reached(vertices):
    return Progress("start", 0, None, None, None, None, 0.0, vertices=vertices)


@pytest.fixture(scope="module")
def cube():
    """With edges of 2.4 radii of curvature."""
    return solid(-1.0, 1.1)


def test_surfaces_of_r3_are_drawn_as_they_are():
    points, faces = zoo.icosphere(1)
    surface = Embedding(PolyhedralMetric.from_mesh(points, faces), points, method="exact", tolerance=1e-10)
    drawn = Drawn.of(surface)
    assert drawn.pieces.cuts == 0 and drawn.infinity == np.inf and drawn.outlines(points) is None
    np.testing.assert_array_equal(drawn.put(surface.vertices), points)
    assert drawn.faces is surface.polygons


def test_edges_are_arcs_that_meet_infinity_at_right_angles(cube):
    """A circle about c of radius r meets the sphere of radius 2 at right angles where |c|^2 = r^2 + 4."""
    drawn = Drawn.of(cube)
    placed = drawn.put(cube.vertices)
    assert drawn.pieces.cuts > 2
    for e in range(3):
        arc = placed[drawn.pieces.edges[drawn.pieces.owners == e]].reshape(-1, 3)
        # 2 c . p = |p|^2 + 4 on the whole arc: one c for all of its points
        c, *_ = np.linalg.lstsq(2 * arc, (arc**2).sum(axis=1) + 4, rcond=None)
        np.testing.assert_allclose(2 * arc @ c, (arc**2).sum(axis=1) + 4, rtol=1e-12)


def test_the_pose_does_not_depend_on_diagonals(cube):
    """Which diagonals divide the faces of a symmetric body is a matter of rounding."""
    x, quads = cube.vertices, np.array(cube.polygons)
    poses = []
    for turned in range(3):  # one, two and three faces with the other diagonal
        quads = np.where(np.arange(6)[:, None] == turned, np.roll(quads, 1, axis=1), quads)
        faces = quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
        metric = PolyhedralMetric.from_mesh(x, faces, curvature=-1.0)
        drawn = Drawn.of(Polyhedron(metric, x, method="exact", tolerance=1e-9))
        assert drawn.pieces.cuts > 2
        poses.append(drawn.pose(x))
        np.testing.assert_allclose(poses[-1].axes, poses[0].axes, atol=1e-12)
        placed = poses[-1].put(drawn.put(x))
        assert np.linalg.norm(placed, axis=1).max() == pytest.approx(1.0)
        view = View.of(drawn.put(x), drawn.faces)
        assert np.abs(view.pose.axes - poses[0].axes).max() > 1e-3  # of all pieces


def test_large_faces_are_cut_and_small_ones_are_not(cube):
    assert Drawn.of(solid(-1.0, np.pi / 2 - 1e-4)).pieces.cuts == 0
    assert Drawn.of(cube)._bend <= MAX_BEND
    assert Drawn.of(solid(0.5, 2.0)).pieces.cuts > 0
    assert len(Drawn.of(cube).pieces.faces) <= MAX_PIECES


@pytest.mark.parametrize("curvature", [-1.0, 0.5])
def test_where_a_surface_is_does_not_show(curvature):
    dihedral = 1.2 if curvature < 0 else 1.8
    here = Drawn.of(solid(curvature, dihedral))
    there = Drawn.of(solid(curvature, dihedral, move=(0.3, -0.2, 0.4)))
    sizes = [np.sort(np.linalg.norm(drawn.put(drawn.surface.vertices), axis=1)) for drawn in (here, there)]
    np.testing.assert_allclose(*sizes, rtol=1e-12)


def test_the_figure_has_the_sphere_at_infinity_and_the_arcs(cube):
    picture = figure(cube)
    (axes,) = picture.axes
    (circle,) = axes.patches
    drawn = Drawn.of(cube)
    pose = Pose.of(drawn.put(cube.vertices))
    assert circle.radius == pytest.approx(2 / pose.size)
    left, right = axes.get_xlim()
    assert left <= circle.center[0] - circle.radius and circle.center[0] + circle.radius <= right
    faces = axes.collections[-1]
    lines = sum(len(path.vertices) == 3 for path in faces.get_paths())  # there and back
    assert lines >= 9 * 2**drawn.pieces.cuts  # of a cube's edges three are hidden at most
    caption = picture.texts[0]
    assert "hyperbolic space of curvature -1, Poincaré ball" in caption.get_text()
    assert "8 vertices, 6 faces" in caption.get_text()


def test_infinity_is_left_out_where_it_is_far():
    small = solid(-1.0, np.pi / 2 - 1e-3)
    assert not figure(small).axes[0].patches
    on_sphere = figure(solid(0.5, 2.0))
    assert not on_sphere.axes[0].patches
    assert "spherical space of curvature 0.5, stereographic projection" in on_sphere.texts[0].get_text()
    assert ball(Pose(np.zeros(3), np.eye(3), 1.0), np.inf) is None


def test_faces_in_pieces_have_one_color(cube):
    drawn = Drawn.of(cube)
    for name in ("sides", "mean curvature"):
        values = drawn.face_values(quantity(cube, name)).reshape(12, -1)
        assert (np.ptp(values, axis=1) == 0).all()
    assert (drawn.face_values(quantity(cube, "sides")) == 4).all()


def test_seams_run_on_the_faces(cube):
    """From corner to corner of a square: a diagonal, in a plane of space."""
    ends, faces = cube.vertices[cube.faces[0][[0, 1, 1, 2]]].reshape(2, 2, 3), np.zeros((2, 2), dtype=int)
    sewn = solid(-1.0, 1.1)
    drawn = Drawn(sewn, np.zeros(3), Drawn.of(sewn).pieces)
    object.__setattr__(sewn.surface, "__class__", type("Sewn", (Surface,), {"seams": Segments(ends, faces)}))
    pieces, beside = drawn.seams()
    assert len(pieces) == 2 * 2**drawn.pieces.cuts
    assert (beside // drawn.pieces.per_face == 0).all()
    centers = drawn.put(sewn.vertices)[drawn.pieces.faces[beside[:, 0]]].mean(axis=1)
    assert np.linalg.norm(pieces.mean(axis=1) - centers, axis=1).max() < 0.1


def test_lines_are_drawn_after_the_faces_beside_them(cube):
    """In Poincare's ball a cube hides some of the edges of faces that are seen in part."""
    drawn = Drawn.of(cube)
    placed = drawn.put(cube.vertices)
    view = View.of(placed, drawn.faces)
    lines = drawn.outlines(placed)
    shades = np.random.default_rng(0).random((len(view.faces), 3))
    faces = Shapes(list(view.polygons), shades, shades, np.full(len(shades), 0.1))
    shapes = among_faces(view, faces, [(lines, shades, 1.0)])
    is_line = np.array([len(polygon) == 2 for polygon in shapes.polygons])
    np.testing.assert_array_equal(shapes.widths, np.where(is_line, 1.0, 0.1))
    assert is_line.sum() == np.isin(lines.faces, view.faces).any(axis=1).sum()
    drawn_faces = np.flatnonzero(~is_line)
    np.testing.assert_array_equal(shapes.fills[drawn_faces], shades)
    for k in np.flatnonzero(is_line)[::37]:  # in the color of the last face before it, beside which it is
        before = drawn_faces[drawn_faces < k][-1]
        np.testing.assert_array_equal(shapes.rims[k], shapes.fills[before])
        ends = {tuple(corner) for corner in shapes.polygons[k].tolist()}
        assert ends <= {tuple(corner) for corner in shapes.polygons[before].tolist()}


def test_curvature_is_beyond_that_of_space(cube):
    shown = quantity(cube, "Gaussian curvature")
    assert "$k$ + deficit / dual area" in shown.label
    assert (shown.values[np.isfinite(shown.values)] > -1).all()


def test_films(cube):
    """From a smaller cube, moved away and turned, to the cube."""
    turn = zoo.rotation(3)
    film = Film()
    for share in (0.5, 0.8):
        start = cube.space.translated(share * cube.vertices @ turn, np.array([0.1, 0.2, 0.0]))
        film(reached(start / cube.metric.unit))
    frames = film.frames(cube)
    assert len(frames) == 3
    for frame, share in zip(frames, (0.5, 0.8, 1.0), strict=True):
        np.testing.assert_allclose(frame.vertices, share * cube.vertices, atol=1e-7)
        assert frame.surface(cube).space == cube.space


def test_a_film_file(monkeypatch, tmp_path):
    monkeypatch.setattr(animation, "IMAGES_PER_SECOND", 1)
    small = solid(-1.0, 1.5)
    assert Drawn.of(small).pieces.cuts > 0
    write_animation(tmp_path / "f.gif", small, ())
    assert (tmp_path / "f.gif").read_bytes().startswith(b"GIF89a")


def test_frames_that_leave_the_half_of_the_sphere_are_left_out():
    surface = solid(0.5, 2.0)
    film = Film()
    film(reached(9 * surface.vertices / surface.metric.unit))
    assert len(film.frames(surface)) == 1
