"""Polygons of rounded solids: what is read is the surface that was written."""

import warnings

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from isoembed import MeshNote, PolyhedralMetric, embed
from isoembed.io import read_surface, write_surface


@pytest.mark.parametrize("ending", ["obj", "ply", "off", "fold", "vtk", "stl", "npz"])
@pytest.mark.parametrize("digits", [4, 6])
def test_rounded_solids_are_read_as_they_were_written(digits, ending, tmp_path):
    """Their quadrilaterals are planar but for rounding: another diagonal is another surface."""
    corners = np.array([[x, y, z] for x in (0, 2) for y in (0, 1) for z in (0, 3)], dtype=float)
    turned = np.round(corners @ Rotation.random(random_state=1).as_matrix().T, digits)
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MeshNote)  # with four digits, faces are not planar
        metric = PolyhedralMetric.from_mesh(turned, quads)
    solid = embed(metric, method="alexandrov")
    write_surface(tmp_path / f"box.{ending}", solid)
    again = read_surface(tmp_path / f"box.{ending}")
    assert again.volume == pytest.approx(solid.volume, rel=1e-7 if ending == "stl" else 1e-13)
    assert not again.surface.concave_edges.any()
    assert len(again.polygons) == 6
