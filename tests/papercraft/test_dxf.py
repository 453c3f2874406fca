"""DXF of nets: what ezdxf reads of it."""

import numpy as np
import pytest

import zoo
from drawings import lines_of
from isoembed import Embedding, PolyhedralMetric
from isoembed.gluing import unfold
from isoembed.papercraft import write_sheets
from isoembed.papercraft.drawing import drawn

ezdxf = pytest.importorskip("ezdxf")


def net_of(vertices, faces):
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    return unfold(Embedding(metric, vertices, method="given", tolerance=1e-10))


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    path = tmp_path_factory.mktemp("dxf") / "net.dxf"
    net = net_of(*zoo.random_hull(12, 3))
    write_sheets(path, net)
    return path, drawn(net)


def test_ezdxf_finds_no_errors(written):
    audit = ezdxf.readfile(written[0]).audit()
    assert not audit.errors and not audit.fixes


def test_lines_by_layer(written):
    path, drawing = written
    document = ezdxf.readfile(path)
    assert document.header["$INSUNITS"] == 4  # millimeters
    space = document.modelspace()
    cuts = space.query('LWPOLYLINE[layer=="cut"]')
    assert all(cut.closed for cut in cuts)
    up = [0, drawing.pages * drawing.height]
    for cut, right in zip(cuts, drawing.cuts, strict=True):
        assert np.array(cut.get_points("xy")) == pytest.approx(right + up, abs=1e-4)
    folds = space.query('LINE[layer=="mountain"]')
    assert len(folds) == len(lines_of(drawing, "mountain"))
    texts = space.query('TEXT[layer=="numbers"]')
    assert [text.dxf.text for text in texts] == [label.text for label in drawing.labels]
    for text, label in zip(texts, drawing.labels, strict=True):
        assert np.array(text.dxf.align_point.vec2) == pytest.approx(
            np.array([label.x, label.y]) + up, abs=1e-4
        )
    colors = {layer.dxf.name: layer.dxf.color for layer in document.layers}
    assert (colors["cut"], colors["mountain"], colors["valley"]) == (1, 5, 3)


def test_the_same_net_is_the_same_file(written, tmp_path):
    write_sheets(tmp_path / "again.dxf", net_of(*zoo.random_hull(12, 3)))
    assert (tmp_path / "again.dxf").read_bytes() == written[0].read_bytes()
    assert not ezdxf.options.write_fixed_meta_data_for_testing


def test_no_line_is_drawn_twice(written):
    """No two lines have more than a point in common where they have one direction."""
    _, drawing = written
    lines = [np.stack([cut, np.roll(cut, -1, axis=0)], axis=1) for cut in drawing.cuts + drawing.glue]
    lines += [np.array(lines_of(drawing, "mountain")), np.array(drawing.ruler + drawing.underlines)]
    ends = np.concatenate(lines)
    steps = ends[:, 1] - ends[:, 0]
    lengths = np.hypot(*steps.T)
    for k, (start, step) in enumerate(zip(ends[:, 0], steps, strict=True)):
        x, y = np.moveaxis(ends - start, 2, 0)
        off = np.abs(step[0] * y - step[1] * x).max(axis=1) / lengths[k]
        part = (step[0] * x + step[1] * y) / lengths[k]
        common = np.minimum(part.max(axis=1), lengths[k]) - np.maximum(part.min(axis=1), 0)
        assert np.flatnonzero((off < 1e-3) & (common > 1e-3)).tolist() == [k]
