"""Strut tables: published chord factors, closed forms, counts, hubs, faces, cuts."""

import json
from collections import Counter
from fractions import Fraction

import numpy as np
import pytest

import solids
import zoo
from domes import dome
from isoembed import Embedding, InvalidMetric, InvalidParameter, PolyhedralMetric, Surface, Triangulation
from isoembed.gallery import Ellipsoid, triangulate
from isoembed.io import FileError
from isoembed.io.surface import surface_of
from isoembed.struts import strut_table
from isoembed.struts.cut_list import CutList

# Chord factors of icosahedral domes of class I, method 1, as builders print them.
PUBLISHED = {
    2: ".54653 .61803",
    3: ".34862 .40355 .41241",
    4: ".25318 .29453 .29524 .29859 .31287 .32492",
    5: ".19815 .22569 .23160 .23179 .24509 .24535 .24724 .25517 .26160",
    6: ".16257 .18191 .18738 .19048 .19801 .20282 .20591 .21535 .21663",
}


def surface(vertices, faces):
    return surface_of({"vertices": np.asarray(vertices, dtype=float), "faces": np.asarray(faces)}, "test")


def solid(points):
    return surface(points, solids.triangles(solids.polygons(points)))


def chord_factors(frequency):
    """By the barycentric coordinates in a face, with the cosine of an icosahedron's angle, 1 / sqrt(5)."""
    c = 5**-0.5

    def product(p, q):
        return (1 - c) * sum(x * y for x, y in zip(p, q, strict=True)) + c * sum(p) * sum(q)

    found = Counter()
    points = [(i, j, frequency - i - j) for i in range(frequency + 1) for j in range(frequency + 1 - i)]
    for p in points:
        for step in ((1, -1, 0), (0, 1, -1), (-1, 0, 1)):
            q = tuple(x + y for x, y in zip(p, step, strict=True))
            if min(q) >= 0:
                cosine = product(p, q) / np.sqrt(product(p, p) * product(q, q))
                on_side = any(x == y == 0 for x, y in zip(p, q, strict=True))  # of two faces
                found[round(float(np.sqrt(2 - 2 * cosine)), 9)] += Fraction(20, 2 if on_side else 1)
    return found


@pytest.mark.parametrize("frequency", PUBLISHED)
def test_published_chord_factors(frequency):
    table = strut_table(surface(*dome(frequency)))
    assert [f"{one.chord_factor:.5f}"[1:] for one in table.struts] == PUBLISHED[frequency].split()


@pytest.mark.parametrize("frequency", range(2, 9))
def test_chord_factors_by_barycentric_coordinates(frequency):
    vertices, faces = dome(frequency)
    table = strut_table(surface(7.5 * vertices, faces))
    assert table.radius == pytest.approx(7.5, rel=1e-12)
    expected = chord_factors(frequency)
    found = {round(one.chord_factor, 9): one.count for one in table.struts}
    assert found == dict(expected)
    assert sum(found.values()) == 30 * frequency**2
    for one in table.struts:
        assert one.central_angle == pytest.approx(2 * np.degrees(np.arcsin(one.chord_factor / 2)))


def test_three_eighths_and_halves_have_the_published_counts():
    counts = {2: (30, 35), 3: (30, 55, 80), 4: (30, 60, 30, 30, 70, 30)}
    heights = {2: -0.01, 3: -0.21, 4: -0.01}
    for frequency, expected in counts.items():
        table = strut_table(surface(*dome(frequency, heights[frequency])))
        assert tuple(one.count for one in table.struts) == expected
        assert np.isnan(table.dihedral_angles).sum() == sum(
            hub.count for hub in table.hubs if hub.is_on_boundary
        )


def test_hubs_and_bends_of_a_dome():
    table = strut_table(surface(*dome(2)))
    assert [(hub.name, hub.count, "".join(hub.struts)) for hub in table.hubs] == [
        ("5", 12, "AAAAA"),
        ("6", 30, "ABBABB"),
    ]
    # On a sphere, a strut leaves the tangent plane by half its central angle.
    half = np.array([one.central_angle for one in table.struts]) / 2
    np.testing.assert_allclose(table.bends, np.repeat(half[table.types][:, None], 2, axis=1), atol=1e-9)
    np.testing.assert_allclose(table.hubs[0].angles, 72.0)
    assert all(sum(hub.angles) == pytest.approx(360.0) for hub in table.hubs)
    assert [("".join(face.struts), face.count) for face in table.faces] == [("AAB", 60), ("BBB", 20)]


def test_the_angles_of_a_hub_go_with_its_struts():
    for vertices, faces in (dome(5), dome(4, -0.01)):
        table = strut_table(surface(vertices, faces))
        lengths = [one.length for one in table.struts]
        for kind, hub in enumerate(table.hubs):
            v = int(np.flatnonzero(table.hub_types == kind)[0])
            up = vertices[v]
            arms = []
            for name, bend in zip(hub.struts, hub.bends, strict=True):
                length, tilt = lengths["ABCDEFGHI".index(name)], np.radians(bend)
                arms.append((length * np.cos(tilt), -length * np.sin(tilt)))
            turns = np.cumsum([0.0, *np.radians(hub.angles)])
            flat = [
                np.array([r * np.cos(t), r * np.sin(t), z]) for (r, z), t in zip(arms, turns, strict=False)
            ]
            apart = sorted(np.linalg.norm(a - b) for k, a in enumerate(flat) for b in flat[:k])
            ends = [a + b - v for a, b in table.edges.tolist() if v in (a, b)]
            there = vertices[ends] - up
            real = sorted(np.linalg.norm(a - b) for k, a in enumerate(there) for b in there[:k])
            np.testing.assert_allclose(apart, real, atol=1e-9)


def test_angles_between_struts_in_space():
    """At the corner of a cube they are right, and at hubs of triangles those of the triangles."""
    assert strut_table(solid(solids.uniform("cube"))).hubs[0].strut_angles == pytest.approx((90.0,) * 3)
    for vertices, faces in (zoo.random_hull(20, 3), dome(3, -0.21)):
        table = strut_table(surface(vertices, faces))
        for v in np.flatnonzero(table.hub_types >= 0).tolist():
            around = faces[(faces == v).any(axis=1)]
            legs = vertices[[face[face != v] for face in around]] - vertices[v]
            legs /= np.linalg.norm(legs, axis=2, keepdims=True)
            angles = np.degrees(np.arccos((legs[:, 0] * legs[:, 1]).sum(axis=1)))
            hub = table.hubs[table.hub_types[v]]
            np.testing.assert_allclose(sorted(hub.strut_angles), sorted(angles), atol=0.3)
            if hub.count == 1:
                np.testing.assert_allclose(sorted(hub.strut_angles), sorted(angles), atol=1e-6)


def test_nothing_is_left_of_a_bar_that_is_full():
    vertices, _ = zoo.cube()
    cuts = strut_table(solid(vertices * [0.1, 0.2, 0.7]), stock=1.0).cuts
    assert min(bar.rest for bar in cuts.bars) == 0
    assert ", 0 left" in str(cuts)


def test_a_mirrored_frame_has_the_same_types():
    vertices, faces = zoo.random_hull(20, 3)
    one, other = surface(vertices, faces), surface(vertices * [1, 1, -1], faces[:, ::-1])
    here, there = strut_table(one), strut_table(other)
    assert here.struts == there.struts
    assert here.faces == there.faces
    for a, b in zip(here.hubs, there.hubs, strict=True):
        assert a.struts == b.struts and a.count == b.count
        np.testing.assert_allclose(a.angles, b.angles, atol=1e-9)


@pytest.mark.parametrize(
    ("name", "struts", "dihedral", "hub"),
    [
        ("cube", 12, 90.0, "3"),
        ("dodecahedron", 30, np.degrees(np.arccos(-(5**-0.5))), "3"),
        ("icosahedron", 30, np.degrees(np.arccos(-(5**0.5) / 3)), "5"),
        ("truncated icosahedron", 90, None, "3"),
    ],
)
def test_true_faces_of_solids(name, struts, dihedral, hub):
    table = strut_table(solid(solids.uniform(name)))
    (one,) = table.struts
    assert (one.count, table.hubs[0].name) == (struts, hub)
    if dihedral is not None:
        np.testing.assert_allclose(table.dihedral_angles, dihedral)
    sizes = Counter(map(len, solids.polygons(solids.uniform(name))))
    assert {len(face.struts): face.count for face in table.faces} == sizes


def test_an_ellipsoid_is_on_no_sphere():
    vertices, faces = triangulate(Ellipsoid((3, 2, 1)), 60)
    table = strut_table(surface(vertices, faces))
    assert table.radius is None and table.struts[0].chord_factor is None
    assert "chord factor" not in str(table)


def test_a_flat_frame_is_on_no_sphere():
    square = Surface(Triangulation([[0, 1, 2], [0, 2, 3]]), [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    table = strut_table(square)
    assert table.radius is None
    assert table.summary == "4 struts of 1 type, 4 hubs of 1 type, 1 face of 1 type"
    assert table.hubs[0].angles == pytest.approx((90.0,))


def test_the_tolerance_groups_lengths():
    vertices, faces = dome(4)
    exact = strut_table(surface(vertices, faces))
    coarse = strut_table(surface(vertices, faces), tolerance=0.006)
    assert [one.count for one in coarse.struts] == [60, 240, 120, 60]
    assert all(one.spread <= 0.006 for one in coarse.struts)
    middle = (exact.struts[1].length + exact.struts[3].length) / 2
    assert coarse.struts[1].length == pytest.approx(middle)


def test_single_precision_is_no_difference():
    vertices, faces = dome(4)
    table = strut_table(surface(vertices.astype(np.float32) * 1.0, faces))
    assert len(table.struts) == 6 and len(table.hubs) == 4


def test_hub_radius_and_stock():
    table = strut_table(surface(*dome(2, -0.01)), hub_radius=0.01, stock=3.0)
    a, b = table.struts
    assert (a.cut_length, b.cut_length) == pytest.approx((a.length - 0.02, b.length - 0.02))
    cut = Counter()
    for bar in table.cuts.bars:
        used = sum({"A": a, "B": b}[name].cut_length for name in bar.struts)
        assert bar.rest == pytest.approx(3.0 - used) and bar.rest >= 0
        cut.update(dict.fromkeys(bar.struts, 0))
        for name in bar.struts:
            cut[name] += bar.count
    assert cut == {"A": 30, "B": 35}
    total = 30 * a.cut_length + 35 * b.cut_length
    assert total / 3.0 <= table.cuts.count <= 11 / 9 * np.ceil(total / 3.0) + 1
    assert table.cuts.waste == pytest.approx(1 - total / (3.0 * table.cuts.count))


def test_struts_that_fill_a_bar():
    table = strut_table(solid(solids.uniform("cube")), stock=3.0)
    assert [(bar.count, len(bar.struts)) for bar in table.cuts.bars] == [(4, 3)]


def sawn(cuts):
    """How many struts of each type are cut."""
    count = Counter()
    for bar in cuts.bars:
        for name in bar.struts:
            count[name] += bar.count
    return count


def test_cuts_of_a_4v_dome():
    """If the longest are cut first, 55 bars; their whole length is that of 49.8."""
    vertices, faces = dome(4, -0.01)
    table = strut_table(surface(4 * vertices, faces), stock=6.0)
    assert sawn(table.cuts) == {one.name: one.count for one in table.struts}
    assert sum(one.count * one.length for one in table.struts) / 6 == pytest.approx(49.82, abs=0.01)
    assert table.cuts.count <= 51


@pytest.mark.parametrize("seed", range(4))
def test_cuts_are_few(seed):
    rng = np.random.default_rng(seed)
    lengths = [(f"{k}", float(rng.uniform(0.4, 1.6)), int(rng.integers(5, 80))) for k in range(8)]
    cuts = CutList.of(lengths, 6.0)
    sizes = {name: length for name, length, _ in lengths}
    assert sawn(cuts) == {name: count for name, _, count in lengths}
    for bar in cuts.bars:
        assert bar.rest == pytest.approx(6 - sum(sizes[name] for name in bar.struts)) and bar.rest >= 0
    assert cuts.count <= np.ceil(sum(length * count for _, length, count in lengths) / 6) + 1


def test_cuts_that_fill_bars_exactly():
    """The longest first take five bars: three of 8 + 3, one of 3 + 3 + 2 + 2 + 2, and one of 2."""
    cuts = CutList.of([("A", 8.0, 3), ("B", 3.0, 5), ("C", 2.0, 4)], 12.0)
    assert {bar.struts: bar.count for bar in cuts.bars} == {
        ("A", "C", "C"): 2,
        ("A", "B"): 1,
        ("B", "B", "B", "B"): 1,
    }
    assert str(cuts).startswith("4 bars of 12, ")
    assert str(CutList.of([("A", 8.0, 1)], 12.0)).startswith("1 bar of 12, ")


def test_cuts_of_hundreds_of_types():
    lengths = [(f"{k}", 0.4 + 0.003 * k, 2) for k in range(300)]
    cuts = CutList.of(lengths, 6.0)
    assert sawn(cuts) == {name: 2 for name, _, _ in lengths}


def test_more_types_than_letters():
    vertices, faces = zoo.random_hull(14, 1)
    table = strut_table(surface(vertices, faces))
    names = [one.name for one in table.struts]
    assert len(names) == len(set(names)) == 36 and names[25:28] == ["Z", "AA", "AB"]


def test_files(tmp_path):
    table = strut_table(surface(*dome(3, -0.21)), stock=2.0)
    table.save(tmp_path / "a.csv")
    assert (tmp_path / "a.csv").read_text(encoding="utf-8") == table.to_csv()
    table.save(tmp_path / "a.json")
    report = json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))
    assert [one["count"] for one in report["strut_types"]] == [30, 55, 80]
    assert len(report["struts"]) == 165 and report["struts"][0]["type"] in "ABC"
    assert [hub for hub in report["hubs"] if hub == "5"] == ["5"] * 6
    with pytest.raises(FileError, match=r"ending '.txt', not one of .csv .json"):
        table.save(tmp_path / "a.txt")


def test_the_text():
    lines = str(strut_table(surface(*dome(2)))).splitlines()
    assert lines[0] == (
        "120 struts of 2 types, 42 hubs of 2 types, 80 faces of 2 types; on a sphere of radius 1"
    )
    assert lines[2].split() == ["strut", "count", "length", "chord", "factor", "central", "angle"]
    assert lines[3].split() == ["A", "60", "0.546533", "0.54653", "31.717"]


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"tolerance": -1.0}, "tolerance is -1.0, not a non-negative length"),
        ({"stock": np.inf}, "stock is inf, not a non-negative length"),
        (
            {"hub_radius": 0.4},
            "hubs of radius 0.4 overlap: struts of type A are 0.546533 long",
        ),
        ({"stock": 0.5}, "a strut of type B is 0.618034 long, more than a bar of 0.5"),
    ],
)
def test_refusals(given, words):
    with pytest.raises(InvalidParameter, match=words.replace("(", r"\(")):
        strut_table(surface(*dome(2)), **given)


def test_curved_space_has_no_struts():
    points = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) * 0.3
    faces = [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]
    metric = PolyhedralMetric.from_mesh(points, faces, curvature=-1.0)
    curved = Embedding(metric, points, method="given", tolerance=1e-9)
    with pytest.raises(InvalidMetric, match="in hyperbolic space: strut tables require R"):
        strut_table(curved)


def test_a_floor_may_have_a_vertex_at_the_center_of_the_sphere():
    vertices, faces = dome(2, -0.01)
    vertices = np.vstack([vertices, np.zeros(3)])
    [rim] = Triangulation(faces).boundaries
    floor = [[b, a, len(vertices) - 1] for a, b in zip(rim, np.roll(rim, -1), strict=True)]
    table = strut_table(surface(vertices, np.vstack([faces, floor])))
    assert [one.count for one in table.struts] == [30, 35]
    assert table.hub_types[-1] == -1 and len(table.faces[-1].struts) == 10
