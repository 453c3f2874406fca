"""Polygons of rounded solids: what is read is the surface that was written, within the known rounding."""

import re
import warnings
from contextlib import nullcontext

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from isoembed import MeshNote, PolyhedralMetric, embed, glue, unfold
from isoembed.io import read_surface, write_surface
from isoembed.papercraft import write_sheets


@pytest.mark.parametrize("ending", ["obj", "ply", "off", "fold", "vtk", "stl", "npz"])
@pytest.mark.parametrize("digits", [4, 6])
def test_rounded_solids_are_read_as_they_were_written(digits, ending, tmp_path):
    """Their quadrilaterals are planar but for rounding, and diagonals of polygons are chosen by readers."""
    corners = np.array([[x, y, z] for x in (0, 2) for y in (0, 1) for z in (0, 3)], dtype=float)
    turned = np.round(corners @ Rotation.random(random_state=1).as_matrix().T, digits)
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MeshNote)  # with four digits, faces are not planar
        metric = PolyhedralMetric.from_mesh(turned, quads)
    solid = embed(metric, method="alexandrov")
    write_surface(tmp_path / f"box.{ending}", solid)
    again = read_surface(tmp_path / f"box.{ending}")
    moved = {"npz": 0.0, "stl": 1e-7}.get(ending, 4 * solid.surface.vertex_error)  # of a face
    assert abs(again.volume - solid.volume) <= moved * solid.area + 1e-12
    assert not again.surface.concave_edges.any()
    assert len(again.polygons) == 6


@pytest.mark.parametrize("digits", [2, 4, 6])
def test_a_solid_from_a_drawn_net_is_written_with_its_faces(digits, tmp_path):
    """The faces of the file are those of the solid: what the digits of a drawing leave is no edge."""
    write_sheets(tmp_path / "net.svg", unfold(read_surface(cut_cube(tmp_path / "cut.obj"))), scale=1.0)
    text = (tmp_path / "net.svg").read_text()
    drawing = tmp_path / "rounded.svg"
    drawing.write_text(re.sub(r"\d+\.\d{6}", lambda found: f"{float(found[0]):.{digits}f}", text))
    noted = pytest.warns(MeshNote, match="the sheets are corrected") if digits == 2 else nullcontext()
    with noted:
        net = glue(drawing)
    solid = embed(net)
    assert len(solid.polygons) == 7
    write_surface(tmp_path / "solid.obj", solid)
    assert (tmp_path / "solid.obj").read_text().count("\nf ") == 7
    again = read_surface(tmp_path / "solid.obj")  # no note: the file says how far its faces are off planes
    assert len(again.polygons) == 7
    assert abs(again.volume - solid.volume) <= 4 * solid.surface.vertex_error * solid.area


def cut_cube(path):
    """A cube of 50 without a corner."""
    corners = [[0, 0, 0], [50, 0, 0], [50, 50, 0], [0, 50, 0], [0, 0, 50], [50, 0, 50], [0, 50, 50]]
    corners += [[50, 20, 50], [50, 50, 25], [30, 50, 50]]
    faces = [[1, 4, 3, 2], [1, 2, 6, 5], [1, 5, 7, 4], [2, 3, 9, 8, 6], [3, 4, 7, 10, 9]]
    faces += [[5, 6, 8, 10, 7], [8, 9, 10]]
    lines = [
        f"{kind} {' '.join(map(str, row))}" for kind, rows in (("v", corners), ("f", faces)) for row in rows
    ]
    path.write_text("\n".join(lines))
    return path
