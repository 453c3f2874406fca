"""What captions of surfaces from files leave out, and which surface an integral is of."""

import numpy as np
import pytest

import zoo
from isoembed import Embedding, PolyhedralMetric
from isoembed.io import mesh_writer, read_surface, write_atomically
from isoembed.plot.page import page_html
from isoembed.plot.picture import _caption


def words(path):
    surface = read_surface(path)
    return _caption(surface), page_html(surface, title="a")


@pytest.mark.parametrize("whole", [True, False])
def test_files_without_lengths(whole, tmp_path):
    vertices, faces = zoo.icosphere(2)
    points = 3.0 * np.asarray(vertices) + np.array([1.0, 2.0, 3.0])
    path = tmp_path / "a.ply"
    write_atomically({path: mesh_writer(path, points, faces if whole else np.asarray(faces)[5:])})
    for text in words(path):
        assert ("of the polyhedron" in text) == whole
        assert "largest length error" not in text


@pytest.mark.parametrize("caption", ["", "many words in a row " * 6])
def test_captions_fit_the_figure(caption):
    vertices, faces = zoo.icosphere(2)
    metric = PolyhedralMetric.from_mesh(vertices, np.asarray(faces)[5:])
    surface = Embedding(metric, 1.001 * np.asarray(vertices), method="given", tolerance=1e-10)
    figure = surface.plot(caption=caption)
    [text] = figure.texts
    box = text.get_window_extent()
    assert box.x0 > 0.01 * figure.bbox.width and box.x1 < 0.99 * figure.bbox.width
