"""What captions of surfaces from files leave out, and which surface an integral is of."""

import numpy as np
import pytest

import zoo
from isoembed.io import mesh_writer, read_surface, write_atomically
from isoembed.plot.page import page_html
from isoembed.plot.picture import _caption


def words(path):
    surface = read_surface(path)
    return _caption(surface), page_html(surface, title="a")


@pytest.mark.parametrize(("whole", "said"), [(True, "of the polyhedron"), (False, "over inner edges")])
def test_files_without_lengths(whole, said, tmp_path):
    vertices, faces = zoo.icosphere(2)
    points = 3.0 * np.asarray(vertices) + np.array([1.0, 2.0, 3.0])
    path = tmp_path / "a.ply"
    write_atomically({path: mesh_writer(path, points, faces if whole else np.asarray(faces)[5:])})
    for text in words(path):
        assert said in text and "largest length error" not in text
