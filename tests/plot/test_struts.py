"""Pictures of frames: one color for each type, a legend, numbered hubs."""

import numpy as np
import pytest

from domes import dome
from isoembed.io.surface import surface_of
from isoembed.struts import strut_table

pytest.importorskip("matplotlib")

from isoembed.plot import strut_figure, write_struts_picture


def framed(*shape):
    vertices, faces = dome(*shape)
    surface = surface_of({"vertices": vertices, "faces": faces}, "test")
    return surface, strut_table(surface)


def test_struts_have_the_colors_of_their_types():
    surface, table = framed(3, -0.21)
    drawn = strut_figure(surface, table)
    axes, _ = drawn.axes
    [shapes] = axes.collections
    lengths = [len(path.vertices) for path in shapes.get_paths()]
    lines = np.array([n <= 3 for n in lengths])  # two ends, closed
    [legend] = drawn.legends
    assert [text.get_text().split()[:2] for text in legend.get_texts()] == [
        [one.name, str(one.count)] for one in table.struts
    ]
    colors = shapes.get_edgecolors()[lines, :3]
    for k, handle in enumerate(legend.get_lines()):
        from matplotlib.colors import to_rgb

        same = np.isclose(colors, to_rgb(handle.get_color())).all(axis=1)
        assert same.sum() == table.struts[k].count  # an open dome shows all
    assert {text.get_text() for text in axes.texts} <= set(map(str, range(61)))
    assert len(axes.texts) > 20


@pytest.mark.parametrize(("shape", "views"), [((2,), 2), ((3, -0.21), 2), ((2, 0.7), 1)])
def test_each_hub_has_its_number_in_one_of_two_opposite_views(shape, views):
    """A flat cap shows all in one."""
    surface, table = framed(*shape)
    drawn = strut_figure(surface, table)
    assert len(drawn.axes) == views
    every = {text.get_text() for axes in drawn.axes for text in axes.texts}
    assert every == set(map(str, range(len(surface.vertices))))
    if surface.triangulation.is_closed:  # and in both where it is in sight from neither side alone
        assert all(len(axes.texts) < len(every) for axes in drawn.axes)


def test_many_types_and_hubs(tmp_path):
    surface, table = framed(6)
    drawn = strut_figure(surface, table)
    axes, _ = drawn.axes
    assert len(drawn.legends[0].get_texts()) == 9 and not axes.texts
    write_struts_picture(tmp_path / "a.svg", surface, table)
    assert b"<svg" in (tmp_path / "a.svg").read_bytes()
