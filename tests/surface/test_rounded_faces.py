"""Faces and certificates of solids whose coordinates were rounded."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import isoembed
import solids
from isoembed.embedding.polyhedron import Polyhedron
from isoembed.gluing import unfold
from isoembed.metric.precision import Precision
from isoembed.surface.curvature import bend_errors, dihedral_angles


def rounded(points, decimals, seed=0):
    """The metric of a solid, turned at random, with rounded coordinates; and these."""
    turned = np.round(points @ Rotation.random(random_state=seed).as_matrix().T, decimals)
    return isoembed.PolyhedralMetric.from_mesh(turned, solids.polygons(points)), turned


@pytest.mark.parametrize("decimals", [6, 7, 9, 12])
@pytest.mark.parametrize(("name", "sizes"), [("cube", [4] * 6), ("dodecahedron", [5] * 12)])
def test_polygons_that_rounding_bent_are_faces(name, sizes, decimals):
    metric, _ = rounded(solids.uniform(name), decimals)
    solid = isoembed.embed(metric, method="alexandrov")
    assert solid.surface.flat_faces.sides.tolist() == sizes
    assert isoembed.certify(solid).certified
    net = unfold(solid)
    assert len(net.sheets) == 1
    assert len(net.folds[0]) == len(sizes) - 1


def test_bends_of_a_rounded_solid_are_within_their_bounds():
    metric, points = rounded(solids.uniform("dodecahedron"), 6)
    triangulation = metric.triangulation
    error = Precision.of(points, metric.mean_length).vertex_error * metric.mean_length
    angles = np.abs(dihedral_angles(triangulation, points))
    bounds = bend_errors(triangulation, points, error=error)
    inside = angles < 0.1
    assert inside.sum() == 12 * 2
    assert (angles[inside] <= bounds[inside]).all()
    assert angles[inside].max() > 1e-7  # without the digits these are bends
    assert bounds.max() < 1e-4


def test_errors_of_bends_are_the_sum_of_the_derivatives():
    metric, points = rounded(solids.uniform("icosahedron"), 12)
    triangulation, step = metric.triangulation, 1e-6
    base = dihedral_angles(triangulation, points)
    sums = np.zeros(len(base))
    for v in range(len(points)):
        gradients = np.empty((len(base), 3))
        for k in range(3):
            moved = points.copy()
            moved[v, k] += step
            gradients[:, k] = (dihedral_angles(triangulation, moved) - base) / step
        sums += np.linalg.norm(gradients, axis=1)
    bounds = bend_errors(triangulation, points, error=1.0e-3) / 1.0e-3
    assert (sums <= bounds * (1 + 1e-4)).all()
    assert bounds.max() < 2 * sums.min()


def test_a_smooth_surface_of_small_bends_is_no_face():
    angle = np.linspace(0, 2 * np.pi, 2000, endpoint=False)
    ring = np.column_stack([np.cos(angle), np.sin(angle)])
    n = len(ring)
    points = np.concatenate([np.column_stack([ring, np.full(n, z)]) for z in (0.0, 1.0)])
    sides = [[k, (k + 1) % n, n + (k + 1) % n, n + k] for k in range(n)]
    lids = [list(range(n))[::-1], list(range(n, 2 * n))]
    metric = isoembed.PolyhedralMetric.from_mesh(np.round(points, 5), [*sides, *lids])
    surface = Polyhedron(metric, np.round(points, 5), method="given", tolerance=1e-10)
    sizes = np.bincount(surface.surface.flat_faces.of_triangles)
    assert np.sort(sizes)[-2:].tolist() == [n - 2, n - 2]  # the lids, and no side in one with many others
    assert np.sort(sizes)[-3] < n
