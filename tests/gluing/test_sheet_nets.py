"""Nets of surfaces with boundary and of tori: unfolded, written, glued and folded again."""

import json

import numpy as np
import pytest
from scipy.spatial.distance import pdist

import discs
import isoembed
from exact import is_simple
from gluing_polygons import shoelace
from isoembed import InvalidMetric, InvalidParameter, PolyhedralMetric, SheetEmbedding, embed, glue, unfold
from isoembed.errors import MeshNote
from isoembed.gluing import regular_polygon
from isoembed.io.files import FileError
from isoembed.papercraft import Material
from isoembed.papercraft.drawing import drawn

PYRAMID = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]  # open below


def dome():
    points, faces = discs.hexagonal(2)
    return discs.round_cap(points, 1.0), faces


def saddle():
    points, faces = discs.hexagonal(2)
    return np.column_stack([points, points[:, 0] ** 2 - points[:, 1] ** 2]), faces


def band():
    return discs.band(9, 3, lambda t: (np.cosh(t - 0.5), t - 0.5))


SURFACES = {"dome": dome(), "saddle": saddle(), "band": band(), "torus": discs.torus(8, 6)}


@pytest.fixture(params=SURFACES)
def surface(request):
    return SURFACES[request.param]


def rim(metric):
    return metric.lengths[metric.triangulation.boundary_edges].sum()


@pytest.mark.parametrize("objective", ["sheets", "length", "strips", "faces"])
def test_sheets_do_not_overlap_and_only_the_boundary_is_glued_to_nothing(surface, objective):
    metric = PolyhedralMetric.from_mesh(*surface)
    net = unfold(surface, objective=objective)
    assert all(map(is_simple, net.sheets))
    areas = [shoelace(sheet) for sheet in net.sheets]
    assert min(areas) > 0
    assert sum(areas) == pytest.approx(isoembed.metric.curvature.area(metric), rel=1e-12)
    sides = [np.linalg.norm(np.roll(sheet, -1, axis=0) - sheet, axis=1) for sheet in net.sheets]
    glued = sum(sides[p][k] for pair in net.sides for p, k in pair)
    assert sum(map(np.sum, sides)) - glued == pytest.approx(rim(metric), abs=1e-10)


def test_one_sheet_of_a_band_and_of_a_torus():
    assert [len(unfold(SURFACES[name]).sheets) for name in ("dome", "band", "torus")] == [1, 1, 1]


def test_the_net_is_folded_to_the_surface(surface):
    net = unfold(surface).net
    assert not net.is_sphere
    assert net.deficits.sum() == pytest.approx(
        2 * np.pi * PolyhedralMetric.from_mesh(*surface).triangulation.euler_characteristic, abs=1e-9
    )
    found = embed(net)
    assert isinstance(found, SheetEmbedding)
    assert found.residual < 1e-14
    assert np.sort(pdist(found.vertices)) == pytest.approx(np.sort(pdist(surface[0])), rel=1e-12)


@pytest.mark.parametrize("name", ["net.json", "net.fold", "net.svg", "net.dxf"])
def test_files(surface, name, tmp_path):
    if name == "net.dxf":
        pytest.importorskip("ezdxf")
    unfold(surface).save(tmp_path / name)
    found = embed(glue(tmp_path / name))
    own, given = np.sort(pdist(found.vertices)), np.sort(pdist(surface[0]))
    rounded = name in ("net.svg", "net.dxf")  # in mm
    assert own / own.mean() == pytest.approx(given / given.mean(), rel=1e-5 if rounded else 1e-12)


@pytest.mark.parametrize("name", ["net.json", "net.fold", "net.svg"])
def test_a_file_that_does_not_say_that_it_has_a_boundary_is_refused(name, tmp_path):
    unfold(dome()).save(tmp_path / name)
    text = (tmp_path / name).read_text()
    for entry in ('"any_surface": true', '"file_isoembed:any_surface": true'):
        text = text.replace(entry, entry.replace("true", "false"))
    (tmp_path / name).write_text(text.replace('data-any-surface="1" ', ""))
    with pytest.raises(
        (InvalidMetric, InvalidParameter), match=r"is glued to nothing|has no mate that is certain"
    ):
        glue(tmp_path / name)


def test_the_flag_is_true_or_false(tmp_path):
    path = tmp_path / "net.json"
    unfold(dome()).save(path)
    path.write_text(json.dumps(json.loads(path.read_text()) | {"any_surface": "perhaps"}))
    with pytest.raises(FileError, match="any_surface is perhaps, not true or false"):
        glue(path)


def test_tabs_and_numbers_are_where_sides_are_glued():
    net = unfold(dome())
    with pytest.warns(MeshNote, match="faces without a number, of 24: 2 in the drawing of the solid"):
        drawing = drawn(net, numbers=True)
    assert len(drawing.labels) == 2 * len(net.sides)
    assert len(drawing.glue) <= len(net.sides)
    for joints in ("stitches", "none"):
        thin = drawn(net, size=300, paper="A3", material=Material(joints=joints))
        assert not thin.glue
    thick = drawn(
        net, size=300, paper="A0", material=Material(joints="none", thickness=1.0, bends="perforate")
    )
    assert len(thick.labels) == 2 * len(net.sides)


def test_a_flat_disc_is_one_polygon():
    points, faces = discs.hexagonal(2)
    net = unfold((np.column_stack([points, 0 * points[:, 0]]), faces))
    assert str(net) == "1 sheet, 0 pairs of sides, 0 folds"
    assert len(net.sheets[0]) == 12
    assert drawn(net, numbers=True).labels == []


def test_islands_of_a_dome_are_glued_again(tmp_path):
    unfold(dome()).save(tmp_path / "net.svg", size=400)
    net = glue(tmp_path / "net.svg")
    assert len(net.polygons) == 24
    assert embed(net, boundary="plane").converged


def test_glued_polygons_are_embedded_with_a_condition():
    triangles = [regular_polygon(3)] * 4
    net = glue(triangles, corners=["abe", "bce", "cde", "dae"], any_surface=True)
    assert (net.n_vertices, net.n_edges, net.n_faces) == (5, 8, 4)
    assert net.mean_length == pytest.approx(1.0)
    assert np.ptp(embed(net, boundary="plane").vertices[:, 2]) == pytest.approx(0.5**0.5, abs=1e-12)
    with pytest.raises(InvalidMetric, match="no fold angles, and lengths alone do not"):
        embed(net)
    with pytest.raises(InvalidMetric, match=r"is glued to none \(4 such sides\): the surface is not closed"):
        embed(net, method="alexandrov")
    with pytest.raises(InvalidMetric, match="side 0 of polygon 0 is glued to nothing"):
        glue(triangles, corners=["abe", "bce", "cde", "dae"])


def test_files_of_regular_polygons_permit_a_boundary_as_their_error_says(tmp_path):
    path, document = tmp_path / "net.json", {"regular": ["abe", "bce", "cde", "dae"]}
    path.write_text(json.dumps(document))
    with pytest.raises(InvalidMetric, match="only any_surface permits a boundary"):
        glue(path)
    path.write_text(json.dumps(document | {"any_surface": True}))
    assert np.ptp(embed(glue(path), boundary="plane").vertices[:, 2]) == pytest.approx(0.5**0.5, abs=1e-12)


def test_one_square_with_a_boundary_and_without():
    square = [[0, 0], [1, 0], [1, 1], [0, 1]]
    cone = glue([square], [((0, 0), (0, 1))], any_surface=True)
    assert cone.deficits == pytest.approx([0.0, 1.5 * np.pi, np.pi / 2], abs=1e-12)
    assert cone.simplicial().triangulation.euler_characteristic == 1
    torus = glue([square], [((0, 0), (0, 2)), ((0, 1), (0, 3))], any_surface=True)
    assert not torus.is_sphere
    assert torus.simplicial().triangulation.genus == 1
    with pytest.raises(InvalidMetric, match=r"Euler characteristic 0 \(genus 1\), not 2"):
        embed(torus, method="alexandrov")


def test_a_boundary_is_no_edge_to_cut_or_keep():
    vertices = np.array([[1.0, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0], [0, 0, 1]])
    assert len(unfold((vertices, PYRAMID), cut=[(0, 4)]).sides) == 1
    for chosen in ({"cut": [(0, 1)]}, {"keep": [(0, 1)]}):
        with pytest.raises(InvalidParameter, match=r"\[0\] \(0, 1\) is not an edge between two faces"):
            unfold((vertices, PYRAMID), **chosen)
