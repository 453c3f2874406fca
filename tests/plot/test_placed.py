"""Pictures of surfaces in space: in one scale, from one side, with what is needed to read them."""

import numpy as np
import pytest

from isoembed.errors import InvalidParameter
from isoembed.gallery import Ellipsoid, triangulate

pytest.importorskip("matplotlib")

from isoembed.plot.panel import Panel
from isoembed.plot.placed import SIZE, Scale, placed_figure
from isoembed.plot.view import camera

VERTICES, FACES = triangulate(Ellipsoid((2.0, 1.5, 1.0)), 200)
PANEL = Panel(VERTICES, FACES, VERTICES[:, 2])


def texts(picture):
    return {text.get_text() for axes in picture.axes for text in axes.texts}


def extents(picture):
    """Of what is drawn of the surface, right and up."""
    (surface,) = picture.axes[0].collections
    points = np.concatenate([path.vertices for path in surface.get_paths()])
    return np.ptp(points, axis=0)


def arrow(picture):
    """Begin, end and layer of the arrow through the surface: of the three axes and it, the last."""
    *_, drawn = (text for text in picture.axes[0].texts if getattr(text, "arrow_patch", None))
    return np.array(drawn.xyann), np.array(drawn.xy), drawn.zorder


def test_lengths_axes_and_values_can_be_read_off():
    picture = placed_figure(
        PANEL, label="height", caption="a.gp     time 2", scale=Scale(2.0, (-1.0, 1.0), (-2.0, 1.0))
    )
    assert {"$x$", "$y$", "$z$", "1"} <= texts(picture)
    bar = picture.axes[0].lines[0].get_xydata()
    assert bar[1, 0] - bar[0, 0] == pytest.approx(1.0 / 2.0)  # the length 1, of a reach of 2
    assert picture.axes[1].get_ylabel() == "height"
    assert picture.texts[0].get_text() == "a.gp     time 2"
    assert tuple(picture.get_size_inches()) == SIZE


@pytest.mark.parametrize(
    ("unit", "length"),
    [(1.1e-4, "0.0001"), (1.1, "1"), (2.4, "2"), (1.1e6, "1e+06"), (1.1e-150, "1e-150"), (1.1e12, "1e+12")],
)
def test_the_bar_is_of_a_round_length_in_any_unit(unit, length):
    picture = placed_figure(Panel(unit * VERTICES, FACES, VERTICES[:, 2]), label="")
    assert length in texts(picture)


def test_a_bar_just_below_a_power_of_ten():
    half = np.nextafter(1000.0, 0.0)
    assert np.log10(half) == 3.0
    picture = placed_figure(PANEL, label="", scale=Scale(2.0 * half, (-1.0, 1.0), (-1.0, 1.0)))
    assert "500" in texts(picture)


def test_a_sequence_has_one_scale():
    half = Panel(0.5 * VERTICES, FACES, VERTICES[:, 2] + 3.0)
    scale = Scale.of([PANEL, half])
    assert scale.reach == np.linalg.norm(VERTICES, axis=1).max()
    assert scale.bounds[0] < -0.9 and scale.bounds[1] > 3.9
    first, second = (placed_figure(panel, label="", scale=scale) for panel in (PANEL, half))
    np.testing.assert_allclose(extents(second), 0.5 * extents(first), rtol=1e-12)
    assert first.axes[0].get_xlim() == second.axes[0].get_xlim()
    for picture in (first, second):
        picture.canvas.draw()
    bars = [np.array(picture.canvas.buffer_rgba())[:, 530:] for picture in (first, second)]
    np.testing.assert_array_equal(*bars)
    assert np.ptp(bars[0]) > 100


def test_z_is_up_whatever_the_shape():
    picture = placed_figure(Panel(VERTICES[:, ::-1], FACES[:, ::-1], VERTICES[:, 2]), label="")
    across, up = extents(picture)
    assert up > across  # the long axis is along z


@pytest.mark.parametrize(("direction", "before"), [((0.0, 0.0, 3.0), True), ((0.0, 1.0, 0.0), False)])
def test_the_arrow_points_along_the_direction_and_the_surface_hides_what_is_behind(direction, before):
    picture = placed_figure(PANEL, label="", arrow=direction, name="spin")
    begin, end, order = arrow(picture)
    seen = camera()[:2] @ direction / np.linalg.norm(camera()[:2] @ direction)
    np.testing.assert_allclose((end - begin) / np.linalg.norm(end - begin), seen, atol=1e-14)
    np.testing.assert_allclose(end / np.linalg.norm(end), seen, atol=1e-14)
    (surface,) = picture.axes[0].collections
    assert (order > surface.zorder) is before
    assert any("spin" in text for text in texts(picture))


def test_without_a_direction_there_is_no_arrow():
    assert not any("rightarrow" in text for text in texts(placed_figure(PANEL, label="")))


def test_nothing_overlaps():
    """Neither surface nor arrow, however it is turned, reach the axes, the bar or the key."""
    picture = placed_figure(
        PANEL, label="long label of the values", caption="two\nlines", arrow=(-1.0, 0.0, -0.6)
    )
    picture.canvas.draw()
    renderer = picture.canvas.get_renderer()
    axes = picture.axes[0]
    apart = [text.get_window_extent(renderer) for text in (*axes.texts, *picture.texts) if text.get_text()]
    inverse = axes.transData.inverted()
    for box in apart:
        (left, bottom), (right, top) = inverse.transform(box.get_points())
        nearest = np.hypot(np.clip(0.0, left, right), np.clip(0.0, bottom, top))
        assert nearest > 1.3
    for i, box in enumerate(apart):
        assert not any(box.overlaps(other) for other in apart[:i])


def test_an_arrow_of_no_length_is_refused():
    with pytest.raises(InvalidParameter, match="has no direction"):
        placed_figure(PANEL, label="", arrow=(0.0, 0.0, 0.0))
