import numpy as np

import discs
import sharp_bodies
import zoo
from isoembed.gallery import Ellipsoid, triangulate
from isoembed.mesh.triangulation import Triangulation
from isoembed.surface.curvature import dihedral_angles
from isoembed.surface.piecewise_smoothness import creases, piecewise_fit_residuals
from isoembed.surface.smoothness import fit_residuals


def lens(angle):
    """Two spherical caps with a common rim, and the mask of the rim's vertices."""
    points, faces = discs.irregular(80)
    cap = discs.round_cap(points, angle) - [0.0, 0.0, np.cos(angle)]
    rim = np.linalg.norm(points, axis=1) > 0.999
    copied = np.arange(len(cap))
    copied[~rim] = len(cap) + np.arange((~rim).sum())
    vertices = np.vstack([cap, cap[~rim] * [1, 1, -1]])
    return vertices, Triangulation(np.vstack([faces, copied[faces[:, ::-1]]])), rim


def test_the_crease_of_a_lens_is_its_rim():
    vertices, t, rim = lens(0.4)
    first = next(creases(t, vertices))
    on_rim = np.r_[rim, np.zeros(t.n_vertices - len(rim), dtype=bool)]
    assert (first == (on_rim[t.edges].all(axis=1) & (np.abs(dihedral_angles(t, vertices)) > 1))).all()
    assert first.sum() == rim.sum()


def test_smooth_bodies_have_no_creases():
    for axes in ((1, 1, 1), (3, 2, 1)):
        vertices, faces = triangulate(Ellipsoid(axes), 300)
        assert not list(creases(Triangulation(faces), vertices))


def test_the_edges_of_a_cube_are_creases_of_all_thresholds():
    vertices, faces = zoo.cube()
    t = Triangulation(faces)
    [edges] = creases(t, np.asarray(vertices, dtype=float))
    assert edges.sum() == 12


def test_a_smooth_piece_beside_a_flat_one_is_not_shattered():
    """All bends of a dome are large, compared to those of its floor."""
    vertices, faces = sharp_bodies.half_ball(0.27, 0)
    [rim] = creases(Triangulation(faces), vertices)
    assert rim.sum() == 23
    assert np.abs(vertices[Triangulation(faces).edges[rim], 2]).max() < 1e-12


def test_each_piece_is_smooth_by_itself():
    vertices, t, rim = lens(0.4)
    edges = next(creases(t, vertices))
    inside = np.ones(t.n_vertices, dtype=bool)
    inside[t.edges[edges].ravel()] = False
    apart = piecewise_fit_residuals(t, edges, vertices)
    assert not np.abs(apart[np.flatnonzero(~inside)]).sum()
    together = fit_residuals(t, vertices)
    largest = [np.abs(R @ vertices)[inside].max() for R in (apart, together)]
    assert largest[0] < 0.02 * largest[1]
    # neither half depends on the other
    half = np.arange(t.n_vertices) < len(rim)
    assert not np.abs(apart[np.flatnonzero(half & inside)][:, np.flatnonzero(~half)]).sum()


def test_without_creases_all_vertices_are_fitted_together():
    vertices, faces = triangulate(Ellipsoid((3, 2, 1)), 100)
    t = Triangulation(faces)
    R = piecewise_fit_residuals(t, np.zeros(t.n_edges, dtype=bool), vertices)
    assert np.abs(R - fit_residuals(t, vertices)).max() < 1e-12


def test_a_piece_may_meet_itself_at_a_vertex():
    """Creases about two triangles with a common vertex leave two fans of the other piece around it."""
    vertices, faces = triangulate(Ellipsoid((1, 1, 1)), 100)
    t = Triangulation(faces)
    around = t.faces[(t.faces == 0).any(axis=1)].tolist()
    first, second = around[0], next(f for f in around if not (set(f) & set(around[0])) - {0})
    sides = [{*pair} for f in (first, second) for pair in ((f[0], f[1]), (f[1], f[2]), (f[2], f[0]))]
    edges = np.array([{*pair} in sides for pair in t.edges.tolist()])
    assert edges.sum() == 6
    R = piecewise_fit_residuals(t, edges, vertices)
    assert (np.abs(R).sum(axis=1) > 0).sum() == t.n_vertices - 5
    assert np.abs(R @ np.ones(t.n_vertices)).max() < 1e-12
